"""`python3 -m mkt data`: what is known, what is there, what is wrong with it."""

import os
import pickle
import shutil

import cv2
import numpy as np
import pytest

from mkt.course import cli
from mkt.sequences.benchmarks import (
    ARCHIVES,
    Found,
    check,
    data_root,
    named,
    sequences,
)
from tests.sequences.written import ONE_BASED, mot_folder, numbers, refused

ROWS = [f"{k} .25 .25 .5 .5" for k in range(3)]


def command(capsys, *words):
    """The exit code and what was printed."""
    code = cli.run(cli.parse(["data", *words]))
    return code, capsys.readouterr().out


def images(folder, n=3, size=(48, 64)):
    folder.mkdir(parents=True)
    for k in range(n):
        frame = np.full((*size, 3), 40 * k, np.uint8)
        cv2.imwrite(str(folder / f"{k + 1:04d}.png"), frame)


@pytest.fixture
def root(tmp_path, monkeypatch):
    """A folder with one good sequence of each benchmark; MKT_DATA names it."""
    bobot = tmp_path / "bobot" / "Vid_X"
    images(bobot / "frames")
    (bobot / "truth.txt").write_text("\n".join(ROWS))
    otb = tmp_path / "otb" / "Thing"
    images(otb / "img")
    (otb / "groundtruth_rect.txt").write_text("10,10,20,20\n" * 3)
    vot = tmp_path / "vot" / "item"
    images(vot / "color")
    rows = "10,10,20,20\n11,11,20,20\nNaN,NaN,NaN,NaN\n"
    (vot / "groundtruth.txt").write_text(rows)
    mot = tmp_path / "mot15" / "train" / "Street"
    images(mot / "img1")
    (mot / "gt").mkdir()
    rows = "".join(f"{k},3,5,5,20,20,1,-1,-1,-1\n" for k in (2, 3))
    (mot / "gt" / "gt.txt").write_text(rows)
    monkeypatch.setenv("MKT_DATA", str(tmp_path))
    return tmp_path


def test_data_root(tmp_path, monkeypatch):
    monkeypatch.delenv("MKT_DATA", raising=False)
    assert data_root() is None and sequences() == []
    monkeypatch.setenv("MKT_DATA", str(tmp_path / "none"))
    with refused(tmp_path / "none", "does not exist", "unset it: .* then lists"):
        data_root()
    monkeypatch.setenv("MKT_DATA", str(tmp_path))
    assert data_root() == tmp_path


def test_without_data_everything_is_missing_and_how_to_get_it_is_said(
    capsys, monkeypatch
):
    monkeypatch.delenv("MKT_DATA", raising=False)
    code, text = command(capsys)
    assert not code and "MKT_DATA is not set" in text
    for archive in ARCHIVES:
        assert f"{archive.name}: missing" in text
        assert archive.licence in text and archive.get in text
    code, text = command(capsys, "check")
    assert not code and "nothing is there" in text


def test_what_is_there_is_listed(root, capsys):
    shutil.rmtree(root / "otb")
    _, text = command(capsys)
    assert "BoBoT: 1 found" in text and "there     Vid_X" in text
    assert "OTB: missing" in text
    assert str(root / "mot15" / "train" / "NAME") in text


def test_good_sequences_of_all_four_pass(root, capsys):
    code, text = command(capsys, "check")
    assert code == 0 and "4 sequences can be used, 0 cannot" in text
    assert "BoBoT/Vid_X: 3 frames of 64x48, hidden in 0" in text
    assert "VOT/item: 3 frames of 64x48, hidden in 1" in text
    assert "MOT15/Street: 2 frames" in text  # from the target's first frame on


def test_what_is_found_is_a_source(root):
    for found in sequences():
        assert found.sequence().name.startswith(found.folder.name)


LAST = "frames/0003.png"


def rewrite(folder, *rows):
    (folder / "truth.txt").write_text("\n".join(rows))


def broken_last(folder):
    (folder / LAST).write_bytes(b"not an image")


def broken_in_the_middle(folder):
    (folder / "frames/0002.png").write_bytes(b"not an image")


def too_few(folder):
    (folder / LAST).unlink()


def other_size(folder):
    cv2.imwrite(str(folder / LAST), np.zeros((24, 32, 3), np.uint8))


def hidden_first(folder):
    rewrite(folder, "0 0 0 0 0", *ROWS[1:])


def hidden_ever_after(folder):
    rewrite(folder, ROWS[0], "1 0 0 0 0", "2 0 0 0 0")


def no_truth(folder):
    (folder / "truth.txt").unlink()


def misnumbered(folder):
    rewrite(folder, ROWS[0], ROWS[2], ROWS[1])


def name_of(value):
    return value.__name__ if callable(value) else None


@pytest.mark.parametrize(
    "fault, file, what",
    [
        (broken_last, "0003.png", "not an image"),
        (broken_in_the_middle, "0002.png", "not an image"),
        (too_few, "truth.txt", "3 rows for 2 frames"),
        (other_size, "0003.png", "32x24"),
        (hidden_first, "Vid_X", "not visible in the first frame"),
        (hidden_ever_after, "Vid_X", "visible in no further frame"),
        (no_truth, "Vid_X", "exactly one truth file"),
        (misnumbered, "truth.txt, line 2", "must count the rows"),
    ],
    ids=name_of,
)
def test_what_is_wrong_is_named_and_the_rest_still_checked(
    root, capsys, fault, file, what
):
    fault(root / "bobot" / "Vid_X")
    code, text = command(capsys, "check")
    (wrong,) = [line for line in text.splitlines() if line.startswith("wrong: ")]
    assert code == 1 and file in wrong and what in wrong and ";" in wrong
    assert "3 sequences can be used, 1 cannot" in text


def test_a_setting_that_names_nothing_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setenv("MKT_DATA", str(tmp_path / "gone"))
    for words in ((), ("check",)):
        with pytest.raises(SystemExit) as stopped:
            cli.run(cli.parse(["data", *words]))
        assert "MKT_DATA names a folder that does not exist" in stopped.value.code


def test_a_fingerprint_is_of_the_files_and_not_of_their_place(root):
    first, *_ = sequences()
    before = first.fingerprint()
    shutil.move(root / "bobot", root / "elsewhere")
    moved = Found(first.archive, root / "elsewhere" / "Vid_X")
    assert moved.fingerprint() == before
    rewrite(moved.folder, *ROWS[:2], "2 .25 .25 .5 .6")
    assert moved.fingerprint() != before


def test_an_identity_is_the_name_and_the_files_and_not_the_place(root):
    """Under it rows are kept, which must serve wherever the data lie."""
    first, *others = sequences()
    before = first.identity()
    assert before.startswith("BoBoT/Vid_X ") and str(root) not in before
    shutil.move(root / "bobot", root / "elsewhere")
    moved = Found(first.archive, root / "elsewhere" / "Vid_X")
    assert moved.identity() == before
    assert before not in [found.identity() for found in others]
    rewrite(moved.folder, *ROWS[:2], "2 .25 .25 .5 .6")
    assert moved.identity() != before


BOBOT = {
    "Vid_A_ball": (602, 0),
    "Vid_B_cup": (629, 0),
    "Vid_F_person_fully_occluded": (453, 37),
    "Vid_G_rubikscube": (716, 0),
    "Vid_I_person_crossing": (1017, 23),
}


@pytest.mark.skipif(
    not os.environ.get("MKT_DATA"),
    reason="set MKT_DATA to the folder that contains bobot/ to read the real sequences",
)
@pytest.mark.parametrize("name", BOBOT)
def test_real_bobot(name):
    there = [found for found in sequences() if found.name == f"BoBoT/{name}"]
    if not there:
        pytest.skip(f"there is no {name} below MKT_DATA")
    (found,) = there
    clip = found.sequence()
    hidden = np.flatnonzero(clip.visibility == 0)
    assert (len(clip), len(hidden)) == BOBOT[name]
    assert clip.frames[-1].shape == (240, 320, 3)
    absent = np.isnan(clip.truth).all(1)
    np.testing.assert_array_equal(absent, clip.visibility == 0)
    if "occluded" in name:
        np.testing.assert_array_equal(hidden, np.r_[142:154, 248:260, 354:367])
        assert "reconstructed" in clip.source


def test_a_fingerprint_tells_frames_of_other_names_and_sizes(root):
    first, *_ = sequences()
    frames = sorted((first.folder / "frames").iterdir())
    before, last = first.fingerprint(), frames[-1]
    other = last.with_name("later.png")
    last.rename(other)
    renamed = first.fingerprint()
    other.write_bytes(other.read_bytes() + b"more")
    assert len({before, renamed, first.fingerprint()}) == 3


@pytest.mark.parametrize("name", ["frames/0001.bmp", "truth.csv", "seqinfo.INI"])
def test_a_fingerprint_tells_contents_of_one_size_where_nothing_is_packed(root, name):
    first, *_ = sequences()
    file = first.folder / name
    prints = []
    for content in (b"1,2,3", b"1,2,4"):
        file.write_bytes(content)
        prints.append(first.fingerprint())
    assert prints[0] != prints[1]


def test_a_sequence_comes_back_the_same_from_another_process(root):
    found = sequences()
    assert pickle.loads(pickle.dumps(found)) == found


def test_a_name_of_two_benchmarks_needs_the_benchmark(root):
    images(root / "vot" / "Thing" / "color")
    with pytest.raises(ValueError, match="several .* 'Thing'; say OTB/Thing or VOT/Th"):
        named("Thing")
    assert named("VOT/Thing").archive.name == "VOT"


def test_what_is_partly_hidden_is_not_counted_as_hidden(tmp_path):
    rows = [f"{k},7,{numbers(ONE_BASED)},1,1,0.75" for k in range(1, 5)]
    [archive] = [archive for archive in ARCHIVES if archive.name == "MOT15"]
    found = Found(archive, mot_folder(tmp_path, *rows))
    assert check(found).endswith("hidden in 0")
