"""One target of many: MOT's rows become its regions, or are refused in words."""

import numpy as np
import pytest

from mkt.sequences.mot import mot, mot_ids, mot_main, mot_part
from mkt.sequences.video import ImageFolder
from tests.sequences.written import ONE_BASED, REGION, mot_folder, numbers, refused


def test_mot_takes_one_id_and_hides_missing_rows(tmp_path):
    box = numbers(ONE_BASED)
    rows = [
        f"3,7,{box},1,1,0.25",
        f"1,7,{box},1,1,1",
        "1,8,1,1,9,9,1,1,1",
        "2,8,1,1,9,9,1,1,1",
    ]
    clip = mot(mot_folder(tmp_path, *rows), 7)
    np.testing.assert_array_equal(clip.truth[[0, 2]], [REGION, REGION])
    assert np.isnan(clip.truth[[1, 3]]).all()
    np.testing.assert_array_equal(clip.visibility, [1, 0, 0.25, 0])


def test_the_main_target_of_mot_is_the_one_seen_longest(tmp_path):
    rows = []
    for target, frames, confidence in (
        (4, (1, 2), 1),
        (7, (2, 4, 5), 1),
        (9, (1, 2, 3, 4, 5), 0),
    ):
        rows += [f"{k},{target},11,13,20,10,{confidence},1,1" for k in frames]
    clip = mot_main(mot_folder(tmp_path, *rows, n=6))
    assert clip.name.endswith("-7") and len(clip) == 4
    assert clip.visibility.tolist() == [1, 0, 1, 1]
    assert np.isfinite(clip.truth[0]).all()
    assert (clip.frames[0] == ImageFolder(tmp_path / "img1")[1]).all()
    with refused("gt.txt", "no target is to be scored", "download"):
        mot_main(mot_folder(tmp_path / "none", rows[-1]))


def test_of_targets_seen_equally_long_the_smaller_id_comes_first(tmp_path):
    """A confidence below 0 is one that is not known."""
    rows = [
        f"{k},{target},11,13,20,10,{confidence},1,1"
        for target, confidence in ((8, 1), (3, -1), (5, 1), (6, 1))
        for k in range(1, 4 if target == 6 else 3)
    ]
    assert mot_ids(mot_folder(tmp_path, *rows)) == [6, 3, 5, 8]


def test_mot_ten_columns(tmp_path):
    clip = mot(mot_folder(tmp_path, f"2,1,{numbers(ONE_BASED)},1,-1,-1,-1"), 1)
    np.testing.assert_array_equal(clip.visibility, [0, 1, 0, 0])


@pytest.mark.parametrize(
    "rows, what, remedy, line",
    [
        (["1,7,9,9,9,9,1,1,1"], "no target has the id 3", "choose one of 7", None),
        (["1,7,9,9,9,9,1,1,1", "5,3,9,9,9,9,1,1,1"], "1 to 4", "missing", 2),
        (["1,7,9,9,9,9,1,1,1", "0,3,9,9,9,9,1,1,1"], "1 to 4", "correct", 2),
        (["1,7,9,9,9,9,1,1,1", "1.5,3,9,9,9,9,1,1,1"], "1 to 4", "correct", 2),
        (["2,3,9,9,9,9,1,1,1"] * 2, "second row", "remove", 2),
        (
            ["1,7,9,9,9,9,1,1,1", "2,3,NaN,NaN,NaN,NaN,1,1,1"],
            "NaN is not allowed",
            "correct",
            2,
        ),
        (["1,7,9,9,9,9,1,1,1", "2,3,99,9,9,9,1,1,1"], "outside", "correct", 2),
    ],
)
def test_bad_mot(tmp_path, rows, what, remedy, line):
    folder = mot_folder(tmp_path, *rows)
    with refused("gt.txt", what, remedy, line):
        mot(folder, 3)


@pytest.mark.parametrize(
    "row, what, remedy, line",
    [
        (
            "1,1,11,13,20,10,1,1,0",
            "the target 1 is never visible",
            "choose another",
            None,
        ),
        ("1,NaN,11,13,20,10,1,1,1", "NaN is not allowed", "correct", 1),
        (
            "1,1,11,13,20,10,1,1,7",
            "the visibility does not lie between 0 and 1",
            "correct",
            1,
        ),
        ("1,1.5,11,13,20,10,1,1,1", "the id is no whole number", "correct", 1),
        ("1,1e300,11,13,20,10,1,1,1", "the id is no whole number", "correct", 1),
    ],
)
def test_a_damaged_mot_file_is_named(row, what, remedy, line, tmp_path):
    folder = mot_folder(tmp_path, row)
    with refused("gt.txt", what, remedy, line):
        mot_main(folder)


def test_ids_of_mot_may_be_large(tmp_path):
    folder = mot_folder(tmp_path, "1,9999999999,11,13,20,10,1,1,1")
    assert len(mot(folder, 9999999999)) == 4
    with refused("gt.txt", "no target has the id 1", "choose one of 9999999999"):
        mot(folder, 1)


@pytest.mark.parametrize("target", ["1", 1.0, None])
def test_an_id_is_a_whole_number(target, tmp_path):
    folder = mot_folder(tmp_path, "1,1,11,13,20,10,1,1,1")
    with pytest.raises(TypeError):
        mot(folder, target)


def test_the_frame_rate_is_the_one_that_the_sequence_says(tmp_path):
    folder = mot_folder(tmp_path, f"1,7,{numbers(ONE_BASED)},1,1,1")
    assert mot(folder, 7).fps == 25
    said = folder / "seqinfo.ini"
    said.write_text("[Sequence]\nname=x\nframeRate=7\n")
    assert mot(folder, 7).fps == 7
    said.write_text("[Sequence]\nframeRate=8\n", encoding="utf-8-sig")
    assert mot(folder, 7).fps == 8
    for text in (
        "frameRate=7",
        "[Sequence]\nframeRate=fast",
        "[Sequence]\nframeRate=0",
        "[Sequence]\nframeRate=inf",
    ):
        said.write_text(text)
        with refused("seqinfo.ini", "no frame rate", "write frameRate=25"):
            mot(folder, 7)


def test_a_part_begins_and_ends_where_a_little_of_the_target_is_seen(tmp_path):
    seen = enumerate([0, 0.05, 1, 0.05], 1)
    rows = [f"{k},7,{numbers(ONE_BASED)},1,1,{share}" for k, share in seen]
    clip, first = mot_part(mot_folder(tmp_path, *rows), 7)
    assert (len(clip), first) == (3, 1)


def test_an_id_that_is_far_too_small_is_refused_too(tmp_path):
    with refused("gt.txt", "no whole number", "correct", 1):
        mot_ids(mot_folder(tmp_path, f"1,-1e17,{numbers(ONE_BASED)},1,1,1"))


def test_ids_of_as_many_frames_are_in_the_order_of_their_numbers(tmp_path):
    rows = [
        f"{k},{target},{numbers(ONE_BASED)},1,1,1"
        for target in range(1, 101)
        for k in range(1, 2 + target % 2)
    ]
    odd, even = [*range(1, 101, 2)], [*range(2, 101, 2)]
    assert mot_ids(mot_folder(tmp_path, *rows)) == odd + even
