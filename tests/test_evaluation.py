"""Overlap against a count of points, errors, and the numbers of a run.

The numbers are compared with those that the toolkit of GOT-10k (got10k 0.1.3 on PyPI)
gave for the same boxes and the same drifting tracker, recorded here.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mkt.evaluation import (
    HIT,
    JUDGED,
    Restarted,
    accuracy,
    errors,
    evaluate,
    overlap,
    overlaps,
    restarted,
    robustness,
    scored_frames,
    success,
    true_positives,
)
from mkt.regions import area, corners, from_box, rotation, to_box, unwarp
from mkt.scenes.drawn import Drawn
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD
from mkt.tracking import Sequence, Track, report, track
from tests.strategies import regions


@settings(max_examples=100)
@given(regions(), regions())
def test_overlap_equals_counting_points(a, b):
    outline = np.concatenate([corners(a), corners(b)])
    low, high = outline.min(0), outline.max(0)
    grid = low + (high - low) * (np.indices((300, 300)).reshape(2, -1).T + 0.5) / 300
    in_a, in_b = ((np.abs(unwarp(r, grid)) <= 1).all(-1) for r in (a, b))
    if in_a.sum() > 500 and in_b.sum() > 500:  # else the grid is too coarse to tell
        counted = (in_a & in_b).sum() / (in_a | in_b).sum()
        assert overlap(a, b) == pytest.approx(counted, abs=0.05)


@given(regions(), st.floats(0.1, 3), st.floats(0.1, 3), st.floats(-9, 9))
@example(np.array([12, 12, -5.888208170424364, 6, 10.71875]), 2.0, 1.0, 0.0)
def test_rectangles_turned_alike_overlap_as_upright_ones_do(region, wide, high, along):
    """Their sides are parallel, which is hard for a program that cuts polygons."""
    other = region * [1, 1, 1, wide, high]
    other[:2] += along * rotation(region[2])[:, 0]
    ends = [sorted((-region[3], region[3])), [along - other[3], along + other[3]]]
    x = min(ends[0][1], ends[1][1]) - max(ends[0][0], ends[1][0])
    common = max(x, 0) * 2 * min(region[4], other[4])
    expected = common / (area(region) + area(other) - common)
    assert overlap(region, other) == pytest.approx(expected, abs=1e-6)


@given(regions())
def test_overlap_with_itself_is_one(a):
    assert overlap(a, a) == pytest.approx(1, abs=1e-4)


def test_disjoint_neighbours_do_not_overlap():
    assert overlap(from_box([0, 0, 0.1, 0.1]), from_box([0.15, 0, 0.1, 0.1])) == 0


@pytest.mark.filterwarnings("error")
def test_a_region_without_area_is_infinitely_small():
    found = errors([[0, 0, 0, 0, 5], [0, 0, 0, 5, 5]], [0, 0, 0, 5, 5])
    assert found.scale.tolist() == [-np.inf, 0]


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


# Of the 400 pairs of `boxes`, how many overlap by more than 0, 0.05, ... 1, for each
# seed: ExperimentOTB._calc_curves of the toolkit, on the overlaps of its rect_iou.
CURVES = (
    "355 337 324 313 295 282 266 254 232 210 187 170 153 136 106 85 69 50 35 17 0",
    "359 346 335 316 304 282 268 245 233 213 190 172 149 135 114 95 75 53 34 13 0",
    "363 355 345 328 315 295 283 257 242 217 182 164 139 126 110 88 70 52 41 23 0",
)
MEANS = 0.4631883883885061, 0.4696590632227749, 0.4784617888296647


def rectangle_overlap(a, b):
    """Intersection over union of upright boxes (n, 4), by their sides."""
    low = np.maximum(a[:, :2], b[:, :2])
    high = np.minimum(a[:, :2] + a[:, 2:], b[:, :2] + b[:, 2:])
    common = np.maximum(high - low, 0).prod(1)
    return common / (a[:, 2:].prod(1) + b[:, 2:].prod(1) - common)


@pytest.mark.parametrize("seed", range(3))
def test_overlap_and_success_curve_are_those_of_the_toolkit(seed):
    a, b = boxes(seed)
    iou = overlap(from_box(a), from_box(b), upright=True)
    assert iou == pytest.approx(rectangle_overlap(a, b), abs=1e-9)
    assert iou.mean() == pytest.approx(MEANS[seed], abs=1e-9)
    curve = np.array(CURVES[seed].split(), float) / 400
    assert success(iou) == pytest.approx(curve)


def test_for_an_upright_truth_what_was_found_counts_as_the_box_round_it():
    turned = np.array([50.0, 40, 0.6, 20, 10])
    box = from_box(to_box(turned))
    assert overlap(turned, box, upright=True) == pytest.approx(1)
    assert overlap(turned, box) < 0.8


def test_the_area_under_the_success_curve_is_the_mean_overlap_but_for_its_steps():
    iou = np.random.default_rng(0).random((3, 500))
    assert success(iou).mean(-1) == pytest.approx(iou.mean(-1), abs=0.5 / 20)
    assert success(np.ones(9)).mean() == pytest.approx(20 / 21)


def test_hidden_frames_count_only_where_they_are_asked_for():
    # The first frame never counts; an overlap of just T_lim is no hit.
    iou = np.array([np.nan, 0.9, np.nan, 0.1, HIT, 0.3, np.nan])
    assert true_positives(iou) == pytest.approx(2 / 4)
    for yes in (True, np.True_):
        assert true_positives(iou, hidden=yes) == pytest.approx(2 / 6)
    assert true_positives(np.ones(5), hidden=True) == 1  # with that of the start, too
    assert true_positives(iou, 0.5) == pytest.approx(1 / 4)
    assert np.isnan(true_positives(np.full(3, np.nan)))


def test_the_shares_of_several_limits_are_those_of_success():
    with pytest.raises(ValueError, match="limit is one number; `success` takes"):
        true_positives(np.ones(20), np.arange(0, 1, 0.05))


@pytest.mark.parametrize("limits", [0.5, None, "half", [], [[0.5]], [np.nan], ["0.5"]])
def test_limits_are_a_series_of_numbers(limits):
    with pytest.raises(ValueError, match="^limits is .*; give a list of finite"):
        success(np.ones(20), limits)


@pytest.mark.parametrize("limit", [None, "half", np.nan, True])
def test_a_limit_is_a_number(limit):
    assert true_positives([0, 0.4, 0.6], np.array(0.5)) == pytest.approx(1 / 3)
    with pytest.raises(ValueError, match="^limit is .*; give a number from 0 to 1"):
        true_positives(np.ones(20), limit)


def test_one_overlap_is_no_share_of_frames():
    with pytest.raises(ValueError, match="iou is 0.5; give the overlap of every frame"):
        true_positives(0.5)


@pytest.mark.parametrize("cut", [np.s_[0], np.s_[:1], np.s_[:-1]])
def test_a_track_has_a_region_for_each_frame(cut):
    clip = Drawn("base", 0).sequence()
    with pytest.raises(ValueError, match="regions has the shape .*; give one region f"):
        overlaps(clip.truth[cut], clip)


def test_frames_before_the_start_and_behind_a_wall_are_not_judged():
    truth = from_box(np.tile([10.0, 10, 20, 20], (6, 1)))
    clip = seen(truth, hidden=(2, 3))
    assert scored_frames(clip).tolist() == [False, True, False, False, True, True]
    clip.visibility[4] = 0.5  # half of it is not enough
    assert not scored_frames(clip)[4]
    clip.visibility[4] = 1
    found = truth.copy()
    found[4] = np.nan  # a tracker gets no credit for silence
    iou = overlaps(np.stack([truth, found]), clip)
    nan = np.nan
    assert iou == pytest.approx(
        np.array([[nan, 1, nan, nan, 1, 1], [nan, 1, nan, nan, 0, 1]]), nan_ok=True
    )


def tracked(regions, lost=()):
    """A `Track` that says that the target is lost in some frames."""
    said = np.isin(np.arange(len(regions)), list(lost))
    return Track(np.asarray(regions, float), np.ones(len(regions)), said, {})


def test_a_perfect_track():
    truth = from_box(np.tile([10.0, 10, 20, 20], (30, 1)))
    numbers = evaluate(tracked(truth), seen(truth, hidden=range(5, 11)))
    assert numbers["overlap"] == numbers["hits"] == pytest.approx(1)
    assert numbers["hits_of_all"] == pytest.approx(23 / 29)
    assert numbers["area"] == pytest.approx(20 / 21)
    for name in ("position", "scale", "shrunk", "lost", "failed"):
        assert numbers[name] == pytest.approx(0), name
    assert numbers["false_alarms"] == 0 and np.isnan(numbers["silent"])


def test_a_track_that_drifts_off_and_says_so_late():
    truth = from_box(np.tile([10.0, 10, 20, 20], (31, 1)))
    found = truth.copy()
    found[11:, 0] += 100
    found[21:, 3:] /= 2
    numbers = evaluate(tracked(found, lost=[1, *range(21, 31)]), seen(truth))
    assert numbers["hits"] == numbers["overlap"] == pytest.approx(1 / 3)
    assert numbers["position"] == pytest.approx(200 / 3)
    assert numbers["scale"] == pytest.approx(np.log(2) / 3)
    assert numbers["shrunk"] == pytest.approx(1 / 3)
    assert numbers["lost"] == numbers["failed"] == 1
    assert numbers["silent"] == pytest.approx(0.5)
    assert numbers["false_alarms"] == pytest.approx(0.1)


@pytest.mark.parametrize("hit, lost", [([20], 1), ([21], 0), ([25], 0), ([30], 0)])
def test_one_hit_in_the_last_ten_frames_is_not_lost(hit, lost):
    truth = from_box(np.tile([10.0, 10, 20, 20], (31, 1)))
    found = truth + [100, 0, 0, 0, 0]
    found[[0, *hit]] = truth[0]
    numbers = evaluate(tracked(found), seen(truth))
    assert numbers["lost"] == numbers["failed"] == lost


@pytest.mark.parametrize("upright, off, failed", [(True, np.nan, 0), (False, 90, 1)])
def test_an_orientation_is_scored_where_the_truth_has_one(upright, off, failed):
    truth = from_box(np.tile([10.0, 10, 20, 20], (30, 1)))
    found = truth + [0, 0, np.pi / 2, 0, 0]
    clip = Sequence("made up", range(30), truth, np.ones(30), upright=upright)
    numbers = evaluate(tracked(found), clip)
    assert numbers["orientation"] == pytest.approx(off, nan_ok=True)
    assert numbers["lost"] == 0 and numbers["failed"] == failed


class Drifting(NamedTuple):
    """A tracker that walks off in a straight line, whatever it sees."""

    step_by: tuple[float, float]  # (dx, dy) [px/frame]

    def init(self, frame, region, rng):
        return np.array(region)

    def step(self, state, frame, rng):
        state = state + [*self.step_by, 0, 0, 0]
        return state, {"region": state, "score": 1.0, "lost": False}


# ExperimentVOT.run of the toolkit, "supervised", with the tracker that drifts by
# `step_by` on the boxes of a walk: the frames of its starts and of its failures, and
# its accuracy.  The toolkit's file of results has four decimals.
@pytest.mark.parametrize(
    "seed, step_by, starts, failures, mean",
    [
        (0, (2.1, 0.4), [0, 19, 35, 53, 72, 88], [14, 30, 48, 67, 83], 0.035639),
        (1, (-1.3, 1.7), [0, 15, 34, 48, 62, 79], [10, 29, 43, 57, 74], 0.033527),
        (2, (0.0, 0.2), [0, 71], [66], 0.417621),
    ],
    ids=["right", "left", "nearly still"],
)
def test_restarts_accuracy_and_failures_are_those_of_the_toolkit(
    seed, step_by, starts, failures, mean
):
    walk = np.cumsum(np.random.default_rng(seed).uniform(-1.5, 1.5, (90, 2)), 0)
    walked = np.column_stack([walk + [150, 110], np.full((90, 2), [24, 18])])
    run = restarted(Drifting(step_by), seen(from_box(walked.round(6))))
    assert run.starts == starts
    assert run.failures == failures
    assert accuracy(run) == pytest.approx(mean, abs=1e-5)


def test_the_drifting_tracker_does_fail():
    """Else the comparison above would compare nothing."""
    still = seen(from_box(np.tile([100.0, 100, 20, 20], (90, 1))))
    run = restarted(Drifting((2.0, 0.0)), still)
    assert run.failures == [10, 25, 40, 55, 70, 85]
    assert run.starts == [0, 15, 30, 45, 60, 75]
    assert robustness(run) == pytest.approx(np.exp(-100 * 6 / 90))
    assert np.isnan(accuracy(run))  # ten frames of burn-in, and then it is gone
    assert robustness(restarted(Drifting((0.0, 0.0)), still)) == 1


def test_a_hidden_target_is_neither_a_failure_nor_a_place_to_start():
    truth = from_box(np.tile([100.0, 100, 20, 20], (60, 1)))
    run = restarted(Drifting((2.0, 0.0)), seen(truth, hidden=(10, 11, *range(14, 24))))
    assert run.failures == [12, 34, 49] and run.starts == [0, 24, 39, 54]
    assert np.isnan(run.overlap[10:12]).all()


@pytest.mark.parametrize("share, shrunk", [(0.45, 1), (0.55, 0), (1.8, 0)])
def test_a_region_has_shrunk_below_half_of_the_true_area(share, shrunk):
    truth = from_box(np.tile([10.0, 10, 20, 20], (5, 1)))
    found = truth * [1, 1, 1, share**0.5, share**0.5]
    assert evaluate(tracked(found), seen(truth))["shrunk"] == shrunk


def test_frames_without_an_estimate_are_misses_of_no_known_error():
    truth = from_box(np.tile([10.0, 10, 20, 20], (5, 1)))
    found = truth * [1, 1, 1, 0.5, 0.5] + [3, 4, 0.1, 0, 0]
    clip = replace(seen(truth), upright=False)
    whole = evaluate(tracked(found), clip)
    found[2] = np.nan
    part = evaluate(tracked(found), clip)
    for name in ("position", "orientation", "scale", "shrunk"):
        assert part[name] == pytest.approx(whole[name])
    assert part["hits"] == pytest.approx(0.75 * whole["hits"])
    found[:] = np.nan
    assert np.isnan(evaluate(tracked(found), clip)["position"])


def test_silence_is_counted_among_the_misses_alone():
    truth = from_box(np.tile([10.0, 10, 20, 20], (31, 1)))
    found = truth + [100, 0, 0, 0, 0]
    found[:11] = truth[:11]
    numbers = evaluate(tracked(found, lost=[1, 2, *range(11, 16)]), seen(truth))
    assert numbers["silent"] == pytest.approx(15 / 20)
    assert numbers["false_alarms"] == pytest.approx(2 / 10)


def test_where_one_frame_is_seen_it_decides_and_where_none_is_nothing_does():
    iou = np.array([[np.nan, 0.9, np.nan], [np.nan, 0.1, np.nan], [np.nan] * 3])
    assert true_positives(iou).tolist()[:2] == [1, 0]
    assert np.isnan(true_positives(iou)[2])


def test_a_truth_that_is_turned_is_compared_as_it_is():
    truth = np.array([[50.0, 40, turn, 20, 10] for turn in (0.6, -0.6, 0.6)])
    clip = Sequence("made up", range(3), truth, np.ones(3))
    expected = float(overlap(truth[0], truth[1]))
    assert expected < 0.8
    assert overlaps(truth * [1, 1, -1, 1, 1], clip)[1:] == pytest.approx(expected)
    run = restarted(Drifting((0.0, 0.0)), clip)
    assert run.overlap[1:] == pytest.approx([expected, 1])


@pytest.mark.parametrize("degrees, failed", [(44, 0), (46, 1)])
def test_a_target_is_turned_the_right_way_up_to_45_degrees(degrees, failed):
    truth = np.tile([50.0, 40, 0, 20, 20], (4, 1))
    found = truth + [0, 0, np.radians(degrees), 0, 0]
    clip = Sequence("made up", range(4), truth, np.ones(4))
    assert evaluate(tracked(found), clip)["failed"] == failed
    found[2:, 2] = 0
    assert evaluate(tracked(found), clip)["orientation"] == pytest.approx(degrees / 3)


def test_where_no_frame_is_scored_no_number_is_known():
    truth = from_box(np.tile([100.0, 100, 20, 20], (5, 1)))
    numbers = evaluate(tracked(truth), seen(truth, hidden=range(5)))
    assert tuple(numbers) == JUDGED and np.isnan(list(numbers.values())).all()
    judged = evaluate(tracked(truth), seen(truth))
    assert tuple(judged) == JUDGED and judged["overlap"] == 1


class Silent(Drifting):
    """Has no state, and gives no region."""

    def init(self, frame, region, rng):
        return None

    def step(self, state, frame, rng):
        return None, {"region": np.full(5, np.nan), "score": 0.0, "lost": True}


def test_who_gives_no_region_fails_and_a_state_may_be_none():
    still = seen(from_box(np.tile([100.0, 100, 20, 20], (20, 1))))
    run = restarted(Silent((0, 0)), still)
    assert run.starts == [0, 6, 12, 18] and run.failures == [1, 7, 13, 19]
    assert robustness(run) < 1


def test_restarts_refuse_what_is_no_tracker_as_tracks_do():
    still = seen(from_box(np.tile([100.0, 100, 20, 20], (20, 1))))
    with pytest.raises(ValueError, match="is no tracker"):
        restarted(Drifting, still)
    with pytest.raises(ValueError, match="clip is of the type str; give a Sequence"):
        restarted(Drifting((0.0, 0.0)), "film.avi")


def test_a_frame_whose_true_region_is_not_known_is_not_scored():
    truth = from_box(np.tile([100.0, 100, 20, 20], (9, 1)))
    gap = truth.copy()
    gap[5] = np.nan
    clip = Sequence("made up", range(9), gap, np.ones(9))
    numbers = evaluate(tracked(truth), clip)
    assert numbers["hits"] == 1 and numbers["position"] == 0
    assert np.isnan(restarted(Drifting((0, 0)), clip).overlap[5])


def test_what_has_no_area_overlaps_nothing_and_nothing_overlaps_more_than_all():
    point, tiny = [5, 5, 0, 0, 0], [5, 5, 0.3, 1e-6, 1e-6]
    assert overlap(point, point) == 0 and overlap(point, [5, 5, 0, 2, 2]) == 0
    assert 0.9 < overlap(tiny, tiny) <= 1


@pytest.mark.parametrize("upright", [False, True])
def test_a_mirrored_rectangle_is_no_region_to_be_compared(upright):
    region, turned = [50, 50, 0.3, 10, 10], [50, 50, 0.3, -10, 10]
    both = [region, turned, [50, 50, 0.3, 10, -10]]
    for one, other in ((both, region), (region, both)):
        iou = overlap(one, other, upright)
        assert iou == pytest.approx([1, np.nan, np.nan], nan_ok=True)
    truth = np.tile(region, (3, 1))
    clip = Sequence("made up", range(3), truth, np.ones(3), upright=upright)
    assert overlaps(both, clip)[1:].tolist() == [0, 0]


def test_a_target_whose_region_is_known_is_seen_unless_it_is_said_to_be_hidden():
    truth = from_box(np.tile([100.0, 100, 20, 20], (6, 1)))
    truth[5] = np.nan
    visibility = np.array([np.nan, np.nan, 0, np.nan, 1, np.nan])
    clip = Sequence("made up", range(6), truth, visibility)
    assert scored_frames(clip).tolist() == [False, True, False, True, True, False]
    assert evaluate(tracked(truth), clip)["hits"] == 1
    assert restarted(Drifting((0.0, 0.0)), clip).starts == [0]


class Choosy(Drifting):
    """Takes no target to the left of x = 50."""

    def init(self, frame, region, rng):
        if region[0] < 50:
            raise ValueError("outside the image")
        return super().init(frame, region, rng)


def test_a_start_that_is_refused_is_tried_again_in_the_next_frame():
    x = np.where((15 <= np.arange(40)) & (np.arange(40) < 22), 20.0, 100.0)
    truth = from_box(np.column_stack([x, np.full(40, 100.0), np.full((40, 2), 20.0)]))
    run = restarted(Choosy((2.0, 0.0)), seen(truth))
    assert run.failures[0] == 10 and run.starts[:2] == [0, 22]
    with pytest.raises(ValueError, match="outside"):
        restarted(Choosy((2.0, 0.0)), seen(truth[15:]))


class Trampling(NamedTuple):
    """A tracker that moves the very region that it was given."""

    def init(self, frame, region, rng):
        region[:2] += 500
        return region

    def step(self, state, frame, rng):
        return state, report(state, 0.1, False, 1)


def test_a_tracker_that_changes_its_start_changes_no_truth():
    clip = seen(np.tile([50.0, 40.0, 0.0, 10.0, 8.0], (9, 1)))
    restarted(Trampling(), clip)
    assert (clip.truth[:, :2] == [50, 40]).all()


def test_no_frame_of_no_frames_is_scored():
    clip = seen(np.tile([50.0, 40.0, 0.0, 10.0, 8.0], (9, 1)))
    assert scored_frames(clip.part(slice(0, 0))).tolist() == []


@pytest.mark.slow
def test_a_tracker_that_never_fails_goes_on_as_in_a_track():
    """With the same frames and the same chance."""
    clip, tracker = Drawn("base", 1).sequence(), ParticleFilter(n=60)
    run, whole = restarted(tracker, clip, seed=3), track(tracker, clip, seed=3)
    assert run.starts == [0] and run.failures == []
    assert np.array_equal(run.overlap[1:], overlaps_of(whole, clip))
    usual, anew = (track(tracker, clip, **seed) for seed in ({}, {"seed": 0}))
    assert np.array_equal(usual.regions, anew.regions)
    assert np.array_equal(restarted(tracker, clip).overlap[1:], overlaps_of(anew, clip))


def overlaps_of(run, clip):
    return overlap(run.regions[1:], clip.truth[1:])


def test_a_tracker_that_was_never_started_is_not_robust():
    clip = Drawn("base", 1).sequence().part(slice(9))
    nowhere = replace(clip, truth=np.full((9, 5), np.nan))
    assert np.isnan(robustness(restarted(SSD(), nowhere)))


def test_what_is_said_may_come_from_a_table_as_0_and_1():
    clip = Drawn("base", 1).sequence().part(slice(9))
    found = track(SSD(), clip)
    away = found._replace(regions=found.regions + [500, 0, 0, 0, 0])
    numbers = [
        evaluate(away._replace(lost=away.lost.astype(kind)), clip)
        for kind in (bool, int)
    ]
    assert numbers[0] == pytest.approx(numbers[1], nan_ok=True)


@pytest.mark.parametrize("seed", [None, 1.5, -1])
def test_a_seed_is_a_whole_number(seed):
    clip = Drawn("base", 1).sequence().part(slice(9))
    for run in (track, restarted):
        with pytest.raises(ValueError, match=f"seed is {seed}"):
            run(SSD(), clip, seed=seed)


def test_a_track_is_judged_on_its_own_sequence_alone():
    clip = Drawn("base").sequence()
    found = track(SSD(iterations=1), clip.part(slice(5)))
    with pytest.raises(ValueError, match="the track has 5 frames, but .* has"):
        evaluate(found, clip)
    with pytest.raises(ValueError, match="track is of the type ndarray"):
        evaluate(clip.truth, clip)
    with pytest.raises(ValueError, match="clip is of the type NoneType"):
        evaluate(found, None)


def test_the_accuracy_leaves_a_run_as_it_is():
    run = Restarted(np.linspace(0, 1, 30), [0], [20])
    assert accuracy(run) == accuracy(run) and np.isfinite(run.overlap).all()
