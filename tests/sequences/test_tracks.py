"""Tracks as text: ours there and back, and boxes of other programs in each form."""

import numpy as np
import pytest

from mkt.evaluation import evaluate
from mkt.files import DataError
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


@pytest.mark.parametrize(
    "name, rows, said",
    [
        ("OTB/car", [[1, 2, 3, 4]], "1 rows for the 6 frames of OTB/car"),
        ("walk:9", mot(1, np.ones((2, 4)), 5), "no box in frame 2"),
    ],
)
def test_what_does_not_fit_is_refused(data, tmp_path, name, rows, said):
    write(tmp_path / "found.txt", rows)
    with pytest.raises(DataError, match=said):
        tracks.read(tmp_path / "found.txt", named(name))
