"""Tracks as text: ours there and back, and boxes of other programs in each form."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mkt.course import cli
from mkt.evaluation import JUDGED, evaluate
from mkt.files import DataError
from mkt.regions import corners, from_box
from mkt.sequences import benchmarks, tracks
from mkt.sequences.benchmarks import named
from mkt.tracking import Track
from tests.sequences.written import HEIGHT, WIDTH, write_images

N = 6


@pytest.fixture
def data(tmp_path, monkeypatch):
    """One sequence of each benchmark, of one moving box; returns its regions (N, 5)."""
    k = np.arange(N)
    boxes = np.stack([5.0 + 3 * k, 7.0 + k, 0 * k + 20.0, 0 * k + 12.0], -1)
    for name, frames in {
        "bobot/ball": "frames",
        "otb/car": "img",
        "vot/cat": "color",
        "mot15/train/walk": "img1",
    }.items():
        write_images(tmp_path / name / frames, N)
    share = boxes / [WIDTH, HEIGHT, WIDTH, HEIGHT]
    texts = {
        "bobot/ball/truth.txt": [[i, *row] for i, row in enumerate(share)],
        "otb/car/groundtruth_rect.txt": boxes + [1, 1, 0, 0],
        "vot/cat/groundtruth.txt": boxes,
        "mot15/train/walk/gt/gt.txt": mot(9, boxes[1:5], 2) + mot(4, boxes[:3], 1),
    }
    for name, rows in texts.items():
        write(tmp_path / name, rows)
    monkeypatch.setenv("MKT_DATA", str(tmp_path))
    return boxes


def mot(target, boxes, first):
    """Rows of MOT for a target that is there from a frame on, counted from 1."""
    return [
        [first + k, target, *(box + [1, 1, 0, 0]), 1, 1, 1]
        for k, box in enumerate(boxes)
    ]


def write(path, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(",".join(f"{x:.6f}" for x in row) for row in rows))


@pytest.mark.parametrize(
    "name, text",
    [
        ("BoBoT/ball", "bobot/ball/truth.txt"),
        ("OTB/car", "otb/car/groundtruth_rect.txt"),
        ("cat", "vot/cat/groundtruth.txt"),
        ("walk:9", "mot15/train/walk/gt/gt.txt"),
        ("walk:4", "mot15/train/walk/gt/gt.txt"),
    ],
)
def test_the_truth_itself_is_a_perfect_track(data, tmp_path, name, text):
    track, clip = tracks.read(tmp_path / text, named(name))
    seen = np.isfinite(clip.truth).all(1)
    assert np.allclose(track.regions[seen], clip.truth[seen])
    assert evaluate(track, clip)["overlap"] == pytest.approx(1)


def test_boxes_for_a_new_benchmark_are_read_as_it_says(data, tmp_path):
    """One that counts from 0, with nothing but its `Archive`."""
    [vot] = [archive for archive in benchmarks.ARCHIVES if archive.name == "VOT"]
    found = replace(named("cat"), archive=replace(vot, name="New"))
    track, clip = tracks.read(tmp_path / "vot/cat/groundtruth.txt", found)
    assert np.allclose(track.regions, clip.truth)


def test_boxes_that_miss_by_half_overlap_by_a_third(data, tmp_path):
    rows = data + [1, 1, 0, 0] + [10, 0, 0, 0]
    write(tmp_path / "found.txt", rows)
    track, clip = tracks.read(tmp_path / "found.txt", named("OTB/car"))
    assert evaluate(track, clip)["overlap"] == pytest.approx(1 / 3)


def test_of_several_ids_it_is_the_one_that_begins_on_the_target(data, tmp_path):
    rows = mot(1, data[1:5] + [30, 0, 0, 0], 2) + mot(2, data[1:3], 2)
    write(tmp_path / "found.txt", rows)
    track, clip = tracks.read(tmp_path / "found.txt", named("walk:9"))
    assert np.allclose(track.regions[:2], clip.truth[:2])
    assert np.isnan(track.regions[2:]).all() and track.lost.tolist() == [0, 0, 1, 1]


def test_rows_before_the_target_s_first_frame_are_left_out(data, tmp_path):
    write(tmp_path / "found.txt", mot(1, data[:4], 1))
    track, clip = tracks.read(tmp_path / "found.txt", named("walk:9"))
    assert np.allclose(track.regions[:3], clip.truth[:3])
    assert track.lost.tolist() == [0, 0, 0, 1]


def test_boxes_for_vot_may_have_four_corners(data, tmp_path):
    write(tmp_path / "found.txt", (corners(from_box(data)) + 0.5).reshape(-1, 8))
    track, clip = tracks.read(tmp_path / "found.txt", named("cat"))
    assert np.allclose(track.regions, clip.truth)


def test_a_box_of_another_id_without_a_size_is_not_the_target(data, tmp_path):
    rows = mot(1, data[1:2] * [1, 1, -1, 1], 2) + mot(2, data[1:3], 2)
    write(tmp_path / "found.txt", rows)
    track, clip = tracks.read(tmp_path / "found.txt", named("walk:9"))
    assert np.allclose(track.regions[:2], clip.truth[:2])


@pytest.mark.parametrize("ending", [".csv", ".txt"])
def test_what_we_write_is_read_again(data, tmp_path, ending):
    found = named("walk:9")
    truth = found.sequence().truth
    turned = truth + [0, 0, 0.3 * (ending == ".csv"), 0, 0]
    lost = np.array([False, False, True, False])
    score = np.array([1, 0.9876, 0.1234, 4.321e-5])
    path = tmp_path / f"mine{ending}"
    tracks.write(Track(turned, score, lost, {}), path, found.first)
    track, clip = tracks.read(path, found)
    assert track.lost.tolist() == lost.tolist()
    kept = ~lost if ending == ".txt" else np.ones(4, bool)
    assert np.allclose(track.regions[kept], turned[kept], atol=1e-3)
    rows = np.loadtxt(path, delimiter=",", skiprows=int(ending == ".csv"))
    assert np.allclose(rows[:, 6], score[kept], rtol=1e-3, atol=0)
    if ending == ".txt":
        assert rows[:, 0].tolist() == [2, 3, 5]
        loud = str(tmp_path / "MINE.TXT")  # a path may be text, and an ending loud
        tracks.write(Track(turned, score, lost, {}), loud, found.first)
        assert Path(loud).read_text() == path.read_text()


def test_a_table_of_ours_may_come_back_in_quotes(data, tmp_path):
    found, path = named("OTB/car"), tmp_path / "mine.csv"
    truth = found.sequence().truth
    tracks.write(Track(truth, np.ones(N), np.zeros(N, bool), {}), path)
    lines = path.read_text().splitlines()
    quoted = ['"' + line.replace(",", '","') + '"' for line in lines]
    path.write_text("\n".join(quoted))
    assert np.allclose(tracks.read(path, found)[0].regions, truth, atol=1e-3)


@pytest.mark.parametrize(
    "name, said",
    [
        (
            "dog",
            "no sequence 'dog'; there are BoBoT/ball, OTB/car, VOT/cat, MOT15/walk",
        ),
        ("walk:7", "walk has no target 7; its ids: 9, 4"),
        ("car:1", "only targets of MOT have an id"),
    ],
)
def test_an_unknown_sequence_or_target_is_told_the_known_ones(data, name, said):
    with pytest.raises(ValueError, match=said):
        named(name)


def test_a_target_of_mot_has_a_name_of_its_own(data):
    assert named("walk").name == "MOT15/walk:9"
    assert named("MOT15/walk:4").sequence().name == "walk-4"
    assert named("walk:4").identity() != named("walk:9").identity()
    assert len(benchmarks.usable([named("walk:4")])[0]) == 1


def test_a_file_that_may_not_be_read_is_a_trouble_of_its_sequence_alone(data):
    def look(found):
        if found == named("walk:4"):
            raise PermissionError(13, "Permission denied", "gt.txt")
        return "fine"

    good, troubles = benchmarks.usable([named("walk:4"), named("walk:9")], look)
    assert list(good) == [named("walk:9")]
    assert troubles == ["[Errno 13] Permission denied: 'gt.txt'"]


@pytest.mark.parametrize(
    "name, rows, said",
    [
        ("OTB/car", [[1, 2, 3, 4]], "1 rows for the 6 frames of OTB/car"),
        ("OTB/car", [[1, 2, 3, 4]] * 7, "7 rows for the 6 .* --to 5"),
        (
            "BoBoT/ball",
            [range(1, 11)] * 6,
            "rows of MOT, which BoBoT/ball is not; .*csv",
        ),
        ("walk:9", mot(1, np.ones((2, 4)), 5), "no box in frame 2"),
        ("OTB/car", [range(8)] * 6, "no head; put it back .*: frame,cx"),
    ],
)
def test_what_does_not_fit_is_refused(data, tmp_path, name, rows, said):
    write(tmp_path / "found.txt", rows)
    with pytest.raises(DataError, match=said):
        tracks.read(tmp_path / "found.txt", named(name))


def test_every_number_of_a_score_is_said_with_what_it_means(data, tmp_path, capsys):
    write(tmp_path / "found.txt", data + [1, 1, 0, 0])
    cli.run(cli.parse(["bench", "score", str(tmp_path / "found.txt"), "OTB/car"]))
    lines = [line.split(maxsplit=2) for line in capsys.readouterr().out.splitlines()]
    assert tuple(name for name, _, _ in lines) == JUDGED
    assert lines[0][1] == "1.000" and "[px]" in lines[4][2] and "[deg]" in lines[5][2]
    unknown = {name for name, number, _ in lines if number == "-"}
    assert unknown == {"orientation", "silent"}  # an upright truth, and no misses


def ours(path):
    """A table of ours for walk:9 in a file; returns its head and its rows."""
    truth = named("walk:9").sequence().truth
    tracks.write(Track(truth, np.ones(4), np.zeros(4, bool), {}), path)
    head, *rows = path.read_text().splitlines()
    return head, rows


def changed(row, column, text):
    """A row of text with another field."""
    fields = row.split(",")
    fields[column] = text
    return ",".join(fields)


@pytest.mark.parametrize(
    "hurt, line, said",
    [
        (lambda a, b, c, d: [d, c, b, a], 2, "is 3, but must .* 1, 2, 3,.* in order"),
        (
            lambda a, b, c, d: [b, c, d, d],
            5,
            "is 3, but must .* 1, 2, 3,.* put missing",
        ),
        (lambda a, b, c, d: [a, b, b, d], 4, "the first column is 1, but must count"),
        (lambda a, b, c, d: [a, changed(b, 0, "nan"), c, d], 3, "column is nan"),
        (
            lambda a, b, c, d: [a, b, changed(c, 4, "0"), d],
            4,
            "width or height is zero",
        ),
        (lambda a, b, c, d: [a, b, c, changed(d, 5, "-6")], 5, "negative; .* with NaN"),
        (lambda a, b, c, d: [a, changed(b, 1, "nan"), c, d], 3, "some of its numbers"),
    ],
    ids=["backwards", "cut", "twice", "no number", "flat", "negative", "half"],
)
def test_a_damaged_table_of_ours_is_named_with_its_line(
    hurt, line, said, data, tmp_path
):
    path = tmp_path / "mine.csv"
    head, rows = ours(path)
    path.write_text("\n".join([head, *hurt(*rows)]))
    with pytest.raises(DataError, match=f"mine.csv, line {line}: .*{said}"):
        tracks.read(path, named("walk:9"))


def swapped(line):
    """A line with its second and third field the other way round."""
    frame, x, y, *rest = line.split(",")
    return ",".join([frame, y, x, *rest])


@pytest.mark.parametrize(
    "change",
    [swapped, lambda line: line.replace("deg", "rad"), lambda line: line + ",more"],
    ids=["other order", "other unit", "one more"],
)
def test_a_table_of_other_columns_is_refused_with_ours(change, data, tmp_path):
    path = tmp_path / "mine.csv"
    head, rows = ours(path)
    path.write_text("\n".join(map(change, [head, *rows])))
    with pytest.raises(DataError, match="mine.csv, line 1: .*columns.*: frame,cx .px"):
        tracks.read(path, named("walk:9"))


@pytest.mark.parametrize("separator", [";", "\t", " ", ", "])
def test_a_table_of_ours_may_come_back_with_other_separators(separator, data, tmp_path):
    path = tmp_path / "mine.csv"
    head, rows = ours(path)
    path.write_text("\r\n".join([head, *rows]).replace(",", separator))
    track, clip = tracks.read(path, named("walk:9"))
    assert np.allclose(track.regions, clip.truth)


@pytest.mark.parametrize("nothing", ["nan", "0"])
def test_a_row_of_ours_may_say_that_nothing_was_found(nothing, data, tmp_path):
    path = tmp_path / "mine.csv"
    head, rows = ours(path)
    for column in range(1, 6):
        rows[2] = changed(rows[2], column, nothing)
    path.write_text("\n".join([head, *(changed(row, 7, "0") for row in rows)]))
    track, _ = tracks.read(path, named("walk:9"))
    assert np.isnan(track.regions[2]).all()
    assert track.lost.tolist() == [False, False, True, False]


def test_a_table_of_ours_may_count_as_the_whole_of_mot_does(data, tmp_path):
    path = tmp_path / "mine.csv"
    head, rows = ours(path)
    rows = [changed(row, 0, str(k)) for k, row in enumerate(rows, 1)]
    path.write_text("\n".join([head, *rows]))
    track, clip = tracks.read(path, named("walk:9"))
    assert np.allclose(track.regions, clip.truth)


@pytest.mark.parametrize(
    "column, number, line, said",
    [
        (0, 3.9, 2, "the frame is not one of 1 to 6; correct"),
        (0, 7, 2, "the frame is not one of 1 to 6; correct"),
        (0, np.nan, 2, "NaN is not allowed"),
        (3, np.nan, 2, "NaN is not allowed"),
        (0, 4, 3, "a second row for the same frame and id; correct or remove"),
        (4, -20, 2, "its width or height is zero or negative; .*remove it"),
    ],
)
def test_damaged_rows_of_mot_are_named_with_their_line(
    column, number, line, said, data, tmp_path
):
    rows = mot(1, data[1:5], 2)
    rows[1][column] = number
    write(tmp_path / "found.txt", rows)
    with pytest.raises(DataError, match=f"found.txt, line {line}: .*{said}"):
        tracks.read(tmp_path / "found.txt", named("walk:9"))


def test_mot_s_rows_may_lack_a_confidence(data, tmp_path):
    rows = [[*row[:6], np.nan, 1, 1] for row in mot(1, data[1:5], 2)]
    write(tmp_path / "found.txt", rows)
    track, clip = tracks.read(tmp_path / "found.txt", named("walk:9"))
    assert np.allclose(track.regions, clip.truth)


@pytest.mark.parametrize(
    "name, row",
    [
        ("OTB/car", [9, 9, -20, 12]),
        ("cat", [9, 9, 20, 0]),
        ("BoBoT/ball", [40, 9, 20, 12]),
    ],
)
def test_boxes_without_a_size_are_refused_in_every_form(data, tmp_path, name, row):
    write(tmp_path / "found.txt", [[9, 9, 20, 12], row] + 4 * [[9, 9, 20, 12]])
    said = "found.txt, line [12]: .* zero or negative; .* NaN or zeros for all of it"
    with pytest.raises(DataError, match=said):
        tracks.read(tmp_path / "found.txt", named(name))


@pytest.mark.parametrize("nothing", [np.nan, 0])
@pytest.mark.parametrize("name", ["OTB/car", "cat", "BoBoT/ball"])
def test_a_frame_without_a_box_is_a_row_of_nan_or_of_zeros(
    nothing, name, data, tmp_path
):
    rows = [[9, 9, 20, 12] for _ in range(6)]
    rows[2] = 4 * [nothing]
    write(tmp_path / "found.txt", rows)
    track, _ = tracks.read(tmp_path / "found.txt", named(name))
    assert track.lost.tolist() == [0, 0, 1, 0, 0, 0]


def test_a_region_that_is_nowhere_is_no_row_of_mot(data, tmp_path):
    found, path = named("walk:9"), tmp_path / "a.txt"
    regions = found.sequence().truth.copy()
    regions[1] = np.nan
    said = Track(regions, np.ones(4), np.zeros(4, bool), {})
    tracks.write(said, path, found.first)
    track, _ = tracks.read(path, found)
    assert track.lost.tolist() == [False, True, False, False]


def test_of_several_ids_the_one_counts_that_begins_where_the_target_does(
    data, tmp_path
):
    away = np.repeat(data[4:5], 4, 0)  # begins where the target ends
    write(tmp_path / "found.txt", mot(1, away, 2) + mot(2, data[1:5], 2))
    track, clip = tracks.read(tmp_path / "found.txt", named("walk:9"))
    np.testing.assert_allclose(track.regions, clip.truth)
