"""The figures of [N03]: what a reader sees holds over random numbers and frames; the listing is the library's source."""

import inspect

import numpy as np
import pytest

from mkt.figures import get
from mkt.figures import nummiaro2003 as steps
from mkt.figures import nummiaro2003_sequences as sequences
from mkt.plotting import canvas
from mkt.stories import PASSES, STUDENTS, TREE, doors, students
from mkt.trackers.ellipses import Disc

LISTED = [function for _, functions in steps.STEPS.values() for function in functions]


def shown(function, **parameters):
    return function(canvas((10, 5)), **parameters)


@pytest.mark.parametrize("function", LISTED, ids=lambda f: f.__qualname__)
def test_fig1_lists_the_source_without_its_docstring(function):
    source = inspect.getsource(function)
    code = source.replace(f'"""{function.__doc__}"""', "")
    assert " ".join(steps.listing(function)).split() == code.split()
    assert " ".join(steps._broken(function)).split() == code.split()
    assert max(map(len, steps._broken(function))) <= steps.WIDE


def test_fig1_is_all_on_the_page():
    _, row = get("nummiaro2003.fig1").draw()
    assert 0 < row["left"] < 0.1


def test_fig2_mean_and_top_are_near_the_annotated_head():
    """In the median over the clip, of a head with half axes of 28 and 44 px; the mean also near the top of the surface."""
    rows = [shown(steps.fig2, frame=k) for k in range(0, 120, 17)]
    mean, top = (np.array([row[key] for row in rows]) for key in ("mean", "offset"))
    assert np.median(np.linalg.norm(mean, axis=1)) < 12 and np.median(np.linalg.norm(top, axis=1)) < 12
    assert np.median(np.linalg.norm(mean - top, axis=1)) < 10


@pytest.mark.parametrize("placement", steps.PLACEMENTS)
def test_fig3_samples_lie_in_the_named_zones(placement):
    row = shown(steps.fig3, placement=placement, particles=400)
    x, y = row["samples"].T
    at_border = (np.minimum(x, 319 - x) <= 20) | (np.minimum(y, 239 - y) <= 25)
    at_door = np.any([np.hypot(x - cx, y - cy) < 4 * sx for cx, cy, sx, _ in doors(students(0))[:-1]], 0)
    assert {"doors": at_door, "borders": at_border, "doors and borders": at_door | at_border, "anywhere": x > -1}[placement].all()
    assert at_door.mean() < 0.3 if placement in ("borders", "anywhere") else at_door.mean() > 0.6


def test_fig3_only_the_student_appears():
    behind, out = (shown(steps.fig3, frame=frame) for frame in (TREE, TREE + 30))
    assert behind["positives"] <= 2 and out["positives"] > 10
    assert behind["covered"] > 0.9 and behind["student"] > behind["limit"] + 0.3


def test_fig4_person_and_car_are_followed():
    row = shown(sequences.fig4)
    assert np.median(row["person position"]) < 5 and np.median(row["car position"]) < 12
    assert all(np.median(np.abs(row[f"{target} size"] - 1)) < 0.3 for target in ("person", "car"))
    assert np.median(shown(sequences.fig4, alpha=0.0)["car position"]) > 15


class Meter:
    """In place of the processor's clock, one that goes on by 1 s for every pixel that a histogram looks up."""

    def __init__(self, monkeypatch):
        self.seconds, count = 0, Disc.count

        def counted(disc, image, m, regions):
            self.seconds += len(regions) * disc.points.shape[1]
            return count(disc, image, m, regions)

        monkeypatch.setattr(Disc, "count", counted)
        monkeypatch.setattr(steps, "time", self)

    def thread_time(self):
        return self.seconds


@pytest.fixture
def meter(monkeypatch):
    forget = steps.milliseconds.cache_clear, steps.weighting.cache_clear
    for clear in forget:
        clear()
    yield Meter(monkeypatch)
    for clear in forget:
        clear()


def test_fig5_cost_is_linear_in_samples_and_in_pixels_and_flat_on_the_fixed_grid(meter):
    row = shown(steps.fig5)
    assert row["samples"] == pytest.approx(1) and row["pixels"] == pytest.approx(1, abs=0.05) and row["grid"] == pytest.approx(0, abs=1e-9)
    assert len(row["person"]) == len(row["car"]) == 25
    assert set([*row["person"], *row["car"]]) == {1e3 * 101 * Disc().points.shape[1]}  # 100 samples and the mean state, whatever their size


def test_fig6_found_again_passes_bridged_and_loss_declared():
    row = shown(sequences.fig6)
    waiting = row["initialising"]
    assert waiting[TREE] and not waiting[TREE + 30:195].any() and waiting[-5:].all()
    assert not any(waiting[k - 8:k + 9].any() for k in PASSES)
    assert row["overlap"][TREE + 30] > 0.2
    gone = np.flatnonzero(row["visibility"] > 0)[-1]
    assert abs(np.flatnonzero(~waiting)[-1] + 1 - gone) <= 10


def test_fig7_is_the_run_of_fig6_and_its_crossings_are_the_modes():
    row, strip = shown(sequences.fig7), shown(sequences.fig6)
    assert (row["initialising"] == strip["initialising"]).all() and len(row["positives"]) == STUDENTS - 1
    for switch in row["switches"]:
        now = row["positives"][switch - 1]
        assert now < row["line"] if row["initialising"][switch] else now > row["line"]


def test_fig8_the_update_holds_the_target_and_a_fast_one_learns_what_is_beside_it():
    row = shown(sequences.fig8)
    held, lost = (np.mean(row[f"{title} overlap"] > 0.2) for title in ("with update", "without update"))
    assert held > lost + 0.2
    assert row["with update target"][-1] > row["with update beside"][-1]
    assert row["without update target"][-1] < 0.4
    fast = shown(sequences.fig8, alpha=0.9)
    assert np.mean(fast["with update overlap"] > 0.2) < held - 0.2
    assert (fast["with update beside"] > fast["with update target"]).any()


def test_fig9_the_update_hurts_when_only_the_size_changes():
    row = shown(sequences.fig9, turns=False)
    assert row["with update error"].mean() > row["without update error"].mean() + 0.05


def test_fig10_the_head_is_followed_to_the_end():
    row = shown(sequences.fig10)
    assert row["overlap"].shape == (sequences.RUNS, 450)
    assert row["overlap"].mean() > 0.5 and (row["overlap"][:, -30:].mean(1) > 0.25).all()
