"""Overlap against an independent count of points, errors, and the numbers of a run against the toolkit of GOT-10k."""

from types import SimpleNamespace
from typing import NamedTuple

import cv2
import numpy as np
import pytest
from got10k.experiments import ExperimentOTB, ExperimentVOT
from got10k.trackers import Tracker
from got10k.utils.metrics import poly_iou, rect_iou
from hypothesis import given, settings

from mkt.datasets import vot
from mkt.evaluation import HIT, LIMITS, accuracy, errors, judged, overlap, overlaps, restarted, robustness, success, true_positives
from mkt.regions import corners, from_box, to_box, unwarp
from mkt.tracking import Sequence
from tests.strategies import regions


@settings(max_examples=100)
@given(regions(), regions())
def test_overlap_equals_counting_points(a, b):
    low = np.min([corners(a).min(0), corners(b).min(0)], 0)
    high = np.max([corners(a).max(0), corners(b).max(0)], 0)
    grid = low + (high - low) * (np.indices((300, 300)).reshape(2, -1).T + 0.5) / 300
    in_a, in_b = ((np.abs(unwarp(r, grid)) <= 1).all(-1) for r in (a, b))
    if in_a.sum() > 500 and in_b.sum() > 500:  # else the grid is too coarse to tell
        assert overlap(a, b) == pytest.approx((in_a & in_b).sum() / (in_a | in_b).sum(), abs=0.05)


@given(regions())
def test_overlap_with_itself_is_one(a):
    assert overlap(a, a) == pytest.approx(1, abs=1e-4)


def test_disjoint_neighbours_do_not_overlap():
    assert overlap(from_box([0, 0, 0.1, 0.1]), from_box([0.15, 0, 0.1, 0.1])) == 0


def test_hidden_truth_gives_nan():
    truth = np.full((2, 5), np.nan)
    assert np.isnan(overlap(np.ones((2, 5)), truth)).all()


def test_upright_ignores_the_angle():
    turned = [10, 10, np.pi / 2, 4, 8]
    assert overlap(turned, [10, 10, 0, 8, 4], upright=True) == pytest.approx(1)
    assert overlap(turned, [10, 10, 0, 4, 8]) < 0.5


def test_errors_wrap_and_have_signs():
    e = errors([3, 4, 3.1, 20, 20], [0, 0, -3.1, 10, 10])
    assert e.position == pytest.approx(5)
    assert e.orientation == pytest.approx(2 * np.pi - 6.2)
    assert e.scale == pytest.approx(np.log(2))


def boxes(seed, n=400):
    """Pairs of boxes that overlap more or less: two (n, 4)."""
    rng = np.random.default_rng(seed)
    a = np.column_stack([rng.uniform(0, 100, (n, 2)), rng.uniform(5, 40, (n, 2))])
    return a, a + rng.normal(0, [12, 12, 1, 1], (n, 4)) * rng.random((n, 1))


def seen(truth, hidden=()):
    """A `Sequence` of this truth (T, 5), upright, the target hidden in some frames."""
    visibility = np.ones(len(truth))
    visibility[list(hidden)] = 0
    return Sequence("made up", range(len(truth)), truth, visibility, upright=True)


@pytest.mark.parametrize("seed", range(3))
def test_overlap_and_success_curve_are_those_of_the_toolkit(seed):
    a, b = boxes(seed)
    theirs = rect_iou(a, b)
    iou = overlap(from_box(a), from_box(b), upright=True)
    assert iou == pytest.approx(theirs, abs=1e-9)
    curve, _ = ExperimentOTB._calc_curves(SimpleNamespace(nbins_iou=21, nbins_ce=51), theirs, np.zeros(len(theirs)))
    assert 0.2 < curve.mean() < 0.8
    assert success(iou) == pytest.approx(curve)


def test_the_area_under_the_success_curve_is_the_mean_overlap_but_for_its_steps():
    iou = np.random.default_rng(0).random((3, 500))
    assert success(iou).mean(-1) == pytest.approx(iou.mean(-1), abs=0.5 / 20)
    assert success(np.ones(9)).mean() == pytest.approx(20 / 21)


def test_hidden_frames_count_only_where_they_are_asked_for():
    iou = np.array([0.9, np.nan, 0.1, HIT, 0.3, np.nan])
    assert true_positives(iou) == pytest.approx(2 / 4)  # an overlap of just T_lim is none
    assert true_positives(iou, hidden=True) == pytest.approx(2 / 6)
    assert true_positives(iou, 0.5) == pytest.approx(1 / 4)
    assert np.isnan(true_positives(np.full(3, np.nan)))


def test_frames_before_the_start_and_behind_a_wall_are_not_judged():
    truth = from_box(np.tile([10.0, 10, 20, 20], (6, 1)))
    sequence = seen(truth, hidden=(2, 3))
    assert judged(sequence).tolist() == [False, True, False, False, True, True]
    found = truth.copy()
    found[4] = np.nan  # a tracker gets no credit for silence
    assert overlaps(np.stack([truth, found]), sequence) == pytest.approx(np.array([[1, np.nan, np.nan, 1, 1], [1, np.nan, np.nan, 0, 1]]), nan_ok=True)


class Drifting(NamedTuple):
    """A tracker that walks off in a straight line, a step (dx, dy) a frame, whatever it sees."""

    step_by: tuple[float, float]

    def init(self, frame, region, rng):
        return np.array(region)

    def step(self, state, frame, rng):
        state = state + [*self.step_by, 0, 0, 0]
        return state, {"region": state, "score": 1.0, "lost": False}


class Theirs(Tracker):
    """The same under the protocol of the toolkit."""

    def __init__(self, step_by):
        super().__init__("drifting", is_deterministic=True)
        self.step_by = step_by

    def init(self, image, box):
        self.box = np.array(box, float)

    def update(self, image):
        self.box = self.box + [*self.step_by, 0, 0]
        return self.box


@pytest.fixture(params=[(0, (2.1, 0.4)), (1, (-1.3, 1.7)), (2, (0.0, 0.2))], ids=["right", "left", "nearly still"])
def drift(request, tmp_path):
    """A sequence in the format of VOT with an object that walks about, and a drift: the folder above it, its name and the step."""
    seed, step_by = request.param
    walk = np.cumsum(np.random.default_rng(seed).uniform(-1.5, 1.5, (90, 2)), 0)
    folder = tmp_path / "walk"
    folder.mkdir()
    np.savetxt(folder / "groundtruth.txt", np.column_stack([walk + [150, 110], np.full((90, 2), [24, 18])]), delimiter=",", fmt="%.6f")
    for k in range(90):
        cv2.imwrite(str(folder / f"{k:08d}.jpg"), np.zeros((240, 320, 3), np.uint8))
    (tmp_path / "list.txt").write_text("walk")
    return tmp_path, step_by


def test_restarts_accuracy_and_failures_are_those_of_the_toolkit(drift, tmp_path, monkeypatch):
    root, step_by = drift
    # Two things that NumPy has given up since the toolkit was written: the name, and an array as an element of a longer one.
    monkeypatch.setattr(np, "NaN", np.nan, raising=False)
    monkeypatch.setattr("got10k.experiments.vot.poly_iou", lambda *boxes, **bound: poly_iou(*boxes, **bound)[0])
    theirs = ExperimentVOT(str(root), read_image=True, experiments="supervised", result_dir=str(tmp_path / "results"), report_dir=str(tmp_path))
    theirs.run(Theirs(step_by))
    record = next((tmp_path / "results").rglob("walk_001.txt")).read_text().split("\n")
    record = [[float(x) for x in line.split(",")] for line in record]
    iou = theirs._calc_iou(record, np.loadtxt(root / "walk" / "groundtruth.txt", delimiter=","), (320, 240), burnin=True)
    run = restarted(Drifting(step_by), vot(root / "walk"))
    assert run.starts == [k for k, line in enumerate(record) if line == [1]]
    assert run.failures == [k for k, line in enumerate(record) if line == [2]]
    assert accuracy(run) == pytest.approx(np.nanmean(iou), abs=1e-3)  # their file has four decimals


def test_the_drifting_tracker_does_fail():
    """Else the comparison above would compare nothing."""
    still = seen(from_box(np.tile([100.0, 100, 20, 20], (90, 1))))
    run = restarted(Drifting((2.0, 0.0)), still)
    assert run.failures == [10, 25, 40, 55, 70, 85] and run.starts == [0, 15, 30, 45, 60, 75]
    assert robustness(run) == pytest.approx(np.exp(-100 * 6 / 90))
    assert np.isnan(accuracy(run))  # ten frames of burn-in, and then it is gone
    assert robustness(restarted(Drifting((0.0, 0.0)), still)) == 1


def test_a_hidden_target_is_neither_a_failure_nor_a_place_to_start():
    truth = from_box(np.tile([100.0, 100, 20, 20], (60, 1)))
    run = restarted(Drifting((2.0, 0.0)), seen(truth, hidden=(10, 11, *range(14, 24))))
    assert run.failures == [12, 34, 49] and run.starts == [0, 24, 39, 54]
    assert np.isnan(run.overlap[10:12]).all()
