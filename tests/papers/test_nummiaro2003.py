"""The figures of [N03]: what a reader sees holds over random numbers and frames."""

import inspect
import re

import numpy as np
import pytest

from mkt.evaluation import HIT
from mkt.experiments import timing
from mkt.figures.registry import FIGURES
from mkt.papers.nummiaro2003 import (
    costs,
    films,
    learning,
    listing,
    losing,
    sequences,
    steps,
)
from mkt.plotting import new_figure
from mkt.scenes.nummiaro2003 import (
    PASSES,
    STUDENTS,
    TREE,
    doors,
    students,
    traffic,
)
from mkt.trackers.adaptive import Adaptive
from mkt.trackers.ellipses import Disc
from mkt.tracking import track

pytestmark = pytest.mark.slow

LISTED = [function for _, functions in listing.STEPS.values() for function in functions]


def shown(function, **parameters):
    return function(new_figure((10, 5)), **parameters)


# Figure 1


@pytest.mark.parametrize("function", LISTED, ids=lambda f: f.__qualname__)
def test_fig1_lists_the_source_without_its_docstring(function):
    source = inspect.getsource(function)
    code = re.sub('""".*?"""', "", source, count=1, flags=re.S)
    lines = listing.listing(function)
    assert " ".join(lines).split() == code.split()
    assert max(map(len, lines)) <= 88


def test_fig1_is_all_on_the_page():
    fig, row = FIGURES["nummiaro2003.fig1"].draw()
    assert 0 < row["left"] < 0.1
    assert row["lines"] == sum(len(listing.listing(function)) for function in LISTED)
    fig.canvas.draw()
    boxes = [text.get_window_extent() for text in fig.texts]
    begin = listing.CODE * fig.bbox.x1
    left = [box.x1 for box in boxes if box.x0 < begin - 1]
    code = [box.x1 for box in boxes if box.x0 == pytest.approx(begin)]
    assert len(code) == 2 * len(LISTED) + 1 and len(left) + len(code) == len(boxes)
    assert max(left) < begin and max(code) < fig.bbox.x1


# Figures 2 and 3


def test_fig2_mean_and_top_are_near_the_annotated_head():
    """In the median over the clip, of a head with half axes of 28 and 44 px.

    The mean is also near the top of the surface.
    """
    rows = [shown(steps.fig2, frame=k) for k in range(0, 120, 17)]
    mean, top = (np.array([row[key] for row in rows]) for key in ("mean", "offset"))
    assert np.median(np.linalg.norm(mean, axis=1)) < 12
    assert np.median(np.linalg.norm(top, axis=1)) < 12
    assert np.median(np.linalg.norm(mean - top, axis=1)) < 10


def test_fig2_table_has_the_surface_and_what_stands_on_it():
    row = shown(steps.fig2)
    table = row.table.set_index("drawn")
    assert (table.loc["surface", "coefficient"] == row["rho"].ravel()).all()
    assert table.loc["top", "coefficient"] == row["rho"].max()
    assert table.loc["top", ["x [px]", "y [px]"]].tolist() == row["offset"].tolist()
    assert 90 < len(table.loc["sample"]) <= 100


@pytest.mark.parametrize("placement", steps.PLACEMENTS)
def test_fig3_samples_lie_in_the_named_zones(placement):
    row = shown(steps.fig3, placement=placement, particles=400)
    x, y = row["samples"].T
    depth = students(0).sequence().truth[0, 3:]  # the band is a half axis deep
    at_border = (np.minimum(x, 319 - x) <= depth[0]) | (
        np.minimum(y, 239 - y) <= depth[1]
    )
    beside_tree = doors(students(0))[:-1]
    off = [np.hypot(x - cx, y - cy) / spread for cx, cy, spread, _ in beside_tree]
    at_door = np.min(off, axis=0) < 4
    allowed = {
        "doors": at_door,
        "borders": at_border,
        "doors and borders": at_door | at_border,
        "anywhere": x > -1,
    }
    assert allowed[placement].all()
    if placement in ("borders", "anywhere"):
        assert at_door.mean() < 0.3
    else:
        assert at_door.mean() > 0.6


def test_fig3_only_the_student_appears():
    behind, out = (shown(steps.fig3, frame=frame) for frame in (TREE, TREE + 30))
    assert behind["positives"] <= 2 and out["positives"] > 10
    assert behind["covered"] > 0.9 and behind["student"] > behind["limit"] + 0.3
    samples = out.table.query("drawn == 'sample'")
    assert samples["appears"].sum() == out["positives"]
    background = out.table.query("drawn == 'background'")
    assert 1 - background["appears"].mean() == pytest.approx(out["covered"])


# Figure 5


class Meter:
    """In place of the processor's clock: a second for every pixel that is looked up."""

    def __init__(self, monkeypatch):
        self.seconds, histograms = 0, Disc.histograms

        def counted(disc, image, regions):
            self.seconds += len(regions) * len(disc.kernels.points)
            return histograms(disc, image, regions)

        monkeypatch.setattr(Disc, "histograms", counted)
        monkeypatch.setattr(timing, "milliseconds", self.milliseconds)

    def milliseconds(self, work, repeats):
        before = self.seconds
        work()
        return 1e3 * (self.seconds - before)


@pytest.fixture
def meter(monkeypatch):
    forget = costs.step_costs.cache_clear, costs.histogram_cost.cache_clear
    for clear in forget:
        clear()
    yield Meter(monkeypatch)
    for clear in forget:
        clear()


def test_fig5_cost_is_linear_in_samples_and_in_pixels_and_flat_on_the_fixed_grid(meter):
    row = shown(costs.fig5)
    assert row["samples"] == pytest.approx([1, 1])
    assert row["pixels"] == pytest.approx(1, abs=0.05)
    assert row["grid"] == pytest.approx(0, abs=1e-9)
    assert len(row["person"]) == len(row["car"]) == 25
    # 100 samples and the mean state, whatever their size.
    a_frame = 1e3 * 101 * len(Disc().kernels.points)
    assert set([*row["person"], *row["car"]]) == {a_frame}
    curves = row.table.groupby("curve")["CPU time [ms]"]
    assert curves.size().to_dict() == {
        "person": 25,
        "car": 25,
        "a frame": 5,
        "histograms, 64 bins": 5,
        "histograms, 512 bins": 5,
        "every pixel": 5,
        "fixed grid": 5,
    }


def test_fig5_each_number_of_bins_is_counted_with_that_many(monkeypatch):
    """Here a bin costs 1 ms."""
    monkeypatch.setattr(costs, "histogram_cost", lambda bins, half, n: float(bins.m))
    by_number = costs._costs_by_number(Adaptive(n=5))
    assert set(by_number["histograms, 64 bins"]) == {64}
    assert set(by_number["histograms, 512 bins"]) == {512}


def test_fig5_an_exponent_of_next_to_nothing_has_no_minus():
    assert [costs._rounded(x) for x in (-0.004, 0.004, -0.5)] == [
        "0.00",
        "0.00",
        "-0.50",
    ]


# Whole sequences


def test_fig4_the_person_is_followed_and_the_turning_van_only_in_part():
    fig = new_figure((10, 5))
    row = sequences.fig4(fig)
    off = np.nanmedian(row["car position"][:, 1:])  # frame 0 was given
    assert f"car: {off:.1f} px off" in fig.axes[1].get_title()
    assert row["person position"].shape == (sequences.PATHS, 150)
    assert (np.median(row["person position"], 1) < 8).all()
    assert (row["person overlap"] > HIT).all()
    still = shown(sequences.fig4, alpha=0.0)
    assert (still["car position"][:, -1] > 20).all()
    assert (still["car size"][:, -1] < 0.8).all()


def test_fig4_learning_three_times_as_fast_loses_the_person_in_some_runs():
    held = np.mean(shown(sequences.fig4, alpha=0.3)["person overlap"] > HIT, 1)
    assert held.max() == 1 and held.min() < 0.6


def test_fig6_found_again_passes_bridged_and_loss_declared():
    row = shown(losing.fig6)
    waiting = row["initialising"]
    assert waiting[TREE] and not waiting[TREE + 30 : 195].any() and waiting[-5:].all()
    assert not any(waiting[k - 8 : k + 9].any() for k in PASSES)
    assert row["overlap"][TREE + 30] > 0.2
    gone = np.flatnonzero(row["visibility"] > 0)[-1]
    assert abs(np.flatnonzero(~waiting)[-1] + 1 - gone) <= 10


def test_fig7_is_the_run_of_fig6_and_its_crossings_are_the_modes():
    row, strip = shown(losing.fig7), shown(losing.fig6)
    assert (row["initialising"] == strip["initialising"]).all()
    assert len(row["positives"]) == STUDENTS - 1
    for switch in row["switches"]:
        now = row["positives"][switch - 1]
        assert now < row["line"] if row["initialising"][switch] else now > row["line"]


def held(row, title):
    """The share of the frames in which a row of figure 8 holds the van."""
    return np.mean(row[f"{title} overlap"] > 0.2)


def test_fig8_the_update_holds_a_van_that_takes_other_colours():
    row = shown(learning.fig8)
    assert held(row, "with update") > held(row, "without update") + 0.4
    assert row["with update target"][-1] > row["with update beside"][-1]
    assert row["without update target"][-1] < row["with update target"][-1] - 0.1


def test_fig8_the_update_does_not_hold_a_box_that_turns():
    row = shown(learning.fig8, van="turns")
    assert held(row, "with update") < 0.8 and held(row, "without update") < 0.8
    assert row["with update beside"][-1] > row["with update target"][-1]


def test_fig8_who_learns_fast_loses_what_never_changes():
    row = shown(learning.fig8, van="same", alpha=0.9)
    assert held(row, "without update") == 1 and held(row, "with update") < 0.5


def test_fig8_a_van_that_passes_where_the_ellipse_was_lost_is_not_held():
    row = shown(learning.fig8, van="turns", alpha=0.9)
    followed = track(Adaptive(alpha=0.9), traffic(0, "turns").sequence())
    iou, lost = row["with update overlap"], followed.lost[1:]
    assert lost.mean() > 0.4 and (iou[lost] == 0).all() and (iou[~lost] > 0).any()


def test_fig9_the_update_hurts_when_only_the_size_changes():
    row = shown(learning.fig9, van="same")
    assert row["with update error"].mean() > row["without update error"].mean() + 0.03


def test_fig9_has_no_width_while_the_van_is_lost():
    settings = {"van": "turns", "alpha": 0.9, "threshold": 0.95}
    rows = shown(learning.fig9, **settings).table
    rows = rows[(rows["tracker"] == "with update") & (rows["run"] == 0)]
    widths = rows["H_x [px]"].to_numpy()
    assert np.isfinite(widths[:60]).all() and np.isnan(widths[-60:]).all()


def test_fig9_the_own_score_does_not_tell_that_the_background_was_learnt():
    row = shown(learning.fig9, van="same", alpha=0.9)
    assert row["with update held"].mean() < 0.8
    assert np.median(row["with update score"]) > 0.9


def test_fig10_the_head_is_followed_to_the_end():
    row = shown(sequences.fig10)
    assert row["overlap"].shape == (sequences.RUNS, 450)
    assert row["overlap"].mean() > 0.5
    assert (row["overlap"][:, -30:].mean(1) > 0.25).all()


# The films


def pixels(picture, color):
    """How many pixels of a picture have a colour, about."""
    wanted = np.array([int(color[k : k + 2], 16) for k in (1, 3, 5)])
    return int((np.abs(picture.astype(int) - wanted).max(-1) < 40).sum())


def test_a_film_of_the_modes_shades_what_was_waited_and_its_curve_grows():
    scene = students(0)
    clip, tracker = scene.sequence(), Adaptive(alpha=0.0, zones=doors(scene))
    run = track(tracker, clip, keep=("particles",))
    frames = list(films.modes(tracker, clip, run, every=20))
    assert len(frames) == 12 and {frame.shape for frame in frames} == {(240, 608, 3)}
    right = [frame[:, 320:] for frame in frames]
    grey = [(part == 217).all(-1).sum() for part in right]
    waited = (run.info["mode"] == "initialising").cumsum()[1::20]
    assert (np.diff(grey) > 0).tolist() == (np.diff(waited) > 1).tolist()
    curve = [pixels(part, steps.PERSON) for part in right]
    assert curve[0] < curve[1] < curve[3]


def test_a_film_of_learning_shows_what_the_model_is_like_up_to_the_frame():
    clip, tracker = traffic(0, "same").sequence(), Adaptive(alpha=0.9)
    run = track(tracker, clip, keep=("model",))
    frames = list(films.learning(tracker, clip, run, every=50))
    assert len(frames) == 3
    green = [pixels(frame[40:, 350:], sequences.WITH) for frame in frames]
    assert green[0] < green[1] < green[2]


LENGTHS = {
    sequences.fig4: 1500,
    losing.fig6: STUDENTS,
    learning.fig8: 300,
    learning.fig9: 600,
    sequences.fig10: 900,
}


@pytest.mark.parametrize("figure", LENGTHS, ids=lambda f: f.__name__)
def test_tables_have_a_row_for_each_run_and_frame(figure):
    table = shown(figure).table
    columns = {"target", "tracker", "run"} & set(table)
    assert len(table) == LENGTHS[figure]
    assert not table.duplicated(["frame", *columns]).any()
