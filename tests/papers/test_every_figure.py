"""Every registered figure is drawn and shows what it claims.

At the paper's values, or with all sliders at one of their ends.  The book draws all at
the paper's values, and the ends of single sliders where panels are made beforehand.
"""

import subprocess
import sys

import numpy as np
import pytest

from mkt.figures.registry import FIGURES, figure
from mkt.files import ROOT
from mkt.kernels import Kernels
from mkt.papers.teuliere2009.histograms import still
from mkt.registry import UnknownName
from mkt.scenes.textures import OBJECTS
from tests.lot import DAY
from tests.papers.drawing import numbers
from tests.same_numbers import numbers_of

pytestmark = pytest.mark.slow

NAMES = list(FIGURES)
GAPS = ("nummiaro2003.fig4",)  # no number while its tracker says that it is lost
INFINITE = "Q / R"  # the last place on its axis is infinity, the raw measurement


@pytest.fixture(autouse=True)
def without_benchmarks(monkeypatch):
    """Figures that would use them fall back to scenes, and take as long everywhere."""
    monkeypatch.delenv("MKT_DATA", raising=False)


def position(name):
    """The paper's values, or all sliders at their first or at their last places.

    In four days every figure stands once at the first and once at the last ones.
    """
    entry, end = FIGURES[name], (DAY + NAMES.index(name)) % 4
    ends = {slider: entry.values(slider)[-(end % 2)] for slider in entry.sliders}
    return ends if end < 2 else {}


def cut(ax):
    """Whether a curve of these axes leaves them above or below."""
    if ax.name == "3d" or not ax.axison or ax.get_yscale() != "linear":
        return False
    low, high = np.sort(ax.get_ylim()) + [-1e-9, 1e-9]
    left, right = np.sort(ax.get_xlim())
    for line in ax.lines:
        x, y = np.asarray(line.get_data(), float)
        beside = (x >= left) & (x <= right) & ((y < low) | (y > high))
        if line.get_transform() == ax.transData and beside.any():
            return True
    return False


def flattened(shown):
    """All numbers that a figure shows: those of its table, then those of its facts."""
    columns = shown.table.select_dtypes("number")
    return np.ravel(columns.to_numpy(float)).tolist(), numbers_of(shown.facts)


@pytest.mark.parametrize("name", NAMES)
def test_every_figure_is_drawn(name):
    fig, shown = FIGURES[name].draw(**position(name))
    fig.canvas.draw()
    pixels = np.asarray(fig.canvas.buffer_rgba())[..., :3]
    # Something on a white page, and nothing over its edge.
    assert pixels.std() > 5 and (pixels[0] == 255).mean() > 0.3
    in_table, in_facts = flattened(shown)
    assert in_table + in_facts and len(shown.table)
    assert np.isfinite(in_facts).all() or name in GAPS
    assert not np.isinf(in_facts).any()
    if name != "own.approach":  # which draws a loop that runs away
        assert [ax.get_ylabel() for ax in fig.axes if cut(ax)] == []
    # NaN is a gap in a curve, so there are numbers in each column too.
    columns = shown.table.select_dtypes("number")
    assert np.isfinite(columns).any().all()
    assert not np.isinf(columns.drop(columns=INFINITE, errors="ignore")).any().any()


@pytest.mark.parametrize("name", NAMES)
def test_defaults_are_slider_positions_and_captions_exist(name):
    entry = FIGURES[name]
    assert entry.title.endswith(".") and len(entry.caption) > 80
    for slider in entry.sliders:
        values = entry.values(slider)
        assert entry.defaults[slider] in values and len(values) >= 2


def test_drawing_twice_shows_the_same():
    first, second = (numbers("teuliere2009.fig4", seed=5)["blurred"] for _ in range(2))
    assert (first == second).all()


def test_unknown_figures_and_parameters_are_named():
    with pytest.raises(UnknownName, match="perhaps teuliere2009.fig9"):
        FIGURES["teuliere2009.fig99"]
    with pytest.raises(ValueError, match="'colour'.*span"):
        FIGURES["teuliere2009.fig3"].draw(colour="red")


def test_registering_checks_the_sliders():
    with pytest.raises(ValueError, match="no parameter"):
        figure("x.y", nothing=(0, 1, 1))(lambda fig: {})
    assert "x.y" not in FIGURES


SETTINGS = """
import os
import cv2, matplotlib  # these set variables for themselves

def settings():
    return matplotlib.rcParams.copy(), cv2.getNumThreads(), dict(os.environ)

before = settings()
from mkt.registry import import_all
import_all("mkt")
assert settings() == before, "importing"
from mkt.figures.registry import FIGURES
FIGURES["own.run"].draw()[0].canvas.draw()
assert settings() == before, "drawing"
"""


def test_no_import_and_no_drawing_changes_a_global_setting():
    done = subprocess.run(
        [sys.executable, "-c", SETTINGS],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("item", OBJECTS)
def test_fig1_histogram_sums_to_one(item):
    shown = numbers("teuliere2009.fig1", item=item)
    assert shown["sum"] == pytest.approx(1) and shown["filled"] >= 5


@pytest.mark.parametrize("layout", ["2x2", "3x3", "4x4", "tiles"])
def test_fig2_kernels_cover_the_object(layout):
    least = 0.999 if layout == "tiles" else 0.7
    assert numbers("teuliere2009.fig2", layout=layout)["covered"] > least


@pytest.mark.parametrize("layout", ["one", "2x2", "3x3", "4x4", "tiles"])
def test_fig2_kernels_stay_inside_the_object_whatever_the_span(layout):
    table = numbers("teuliere2009.fig2", layout=layout, span=1.4).table
    reach = [
        abs(table["x"]) + table["half width"],
        abs(table["y"]) + table["half height"],
    ]
    sides = Kernels(layout).fitted(still("car").truth[0]).half_sides
    assert np.all(np.max(reach, axis=1) <= sides + 1e-9)


@pytest.mark.parametrize("item", OBJECTS)
def test_fig3_nine_kernels_feel_the_rotation_and_one_does_not(item):
    """T09-a: the curvature of d^2 along the rotation at the truth.

    That of nine kernels is at least 5 times that of one; and the nine have their
    minimum at the truth, within three steps of the grid in the median (the cat, of one
    colour nearly all over, has the bluntest).
    """
    ratios = []
    offsets = []
    for seed in range(5):
        shown = numbers("teuliere2009.fig3", item=item, seed=seed)
        theta, several = shown["theta"], shown["several"]
        near = np.abs(theta) <= np.deg2rad(30)
        one, nine = (
            np.polyfit(theta[near], distances[near, 30] ** 2, 2)[0]
            for distances in (shown["one"], several)
        )
        ratios.append(nine / max(one, 1e-3))
        row, column = np.unravel_index(np.argmin(several), (61, 61))
        offsets.append((abs(shown["x"][column]), abs(np.rad2deg(theta[row]))))
    assert np.median(ratios) >= 5
    assert (np.median(offsets, 0) <= [2, 6]).all()


@pytest.mark.parametrize("item", OBJECTS)
def test_fig4_distance_at_the_truth_grows_with_blur(item):
    def at_truth(exposure, seed):
        shown = numbers("teuliere2009.fig4", item=item, exposure=exposure, seed=seed)
        return shown["blurred"][20, 20]

    exposures = 0.0, 0.3, 0.6, 1.0
    means = [np.mean([at_truth(e, seed) for seed in range(3)]) for e in exposures]
    assert (np.diff(means) > 0).all()
