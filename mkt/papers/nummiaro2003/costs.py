"""Figure 5 of [N03]: what a step costs, and on what that depends.

Explained in notebook 10.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.checks import locked
from mkt.colors import BinImage, Bins
from mkt.experiments import timing
from mkt.figures.registry import Shown, figure, shown
from mkt.papers import runs
from mkt.papers.nummiaro2003.steps import BINS, CAR, PALE, PLAIN, TARGETS
from mkt.scenes.nummiaro2003 import parking
from mkt.trackers.adaptive import Adaptive, AdaptiveState
from mkt.trackers.ellipses import Disc
from mkt.types import Array, ArrayLike, Frame

TRIALS = 5  # of a timed step
FRAMES = 25  # that are timed
NUMBERS = 50, 100, 200, 400, 800  # of samples
HALVES = 12, 18, 27, 40, 60  # [px] half axes H_x of ellipses
ASPECT = 1.25  # their H_y over H_x
COMPARED = {"rgb 4x4x4": "D:", "rgb 8x8x8": "s-"}  # bins, and how their costs are drawn


@figure(
    "nummiaro2003.fig5",
    size=(10, 3.9),
    particles=[50, 100, 200],
    bins=list(COMPARED),
)
def fig5(fig: Figure, *, particles: int = 100, bins: str = "rgb 8x8x8") -> Shown:
    """What a frame costs: over the frames, and against samples, region size and bins.

    Measured while the figure is drawn, on this machine, in CPU time; so it is never
    twice the same.  Synthetic data: the person and the car of figure 4, which cost
    about the same where nothing else runs.  In the middle against the number of
    samples, for a whole frame and for the histograms of the samples alone, these with
    both numbers of bins.  At the right the histograms of 100 ellipses of growing area:
    with a grid of points as fine as the pixels, as a direct (3) would need, and with
    the fixed grid that the tracker uses, whose cost does not depend on the size.  The
    slope in a doubly logarithmic plot is the exponent.  The print has the times of its
    person and its car at 800 MHz, and says that they depend on the size of the region;
    ours hardly do.
    """
    tracker = Adaptive(n=particles, bins=BINS[bins])
    by_frame = {name: step_costs(tracker, name) for name in TARGETS}
    by_number = _costs_by_number(tracker)
    by_area = _costs_by_area(tracker.bins)
    areas = np.pi * ASPECT * np.square(HALVES)

    margins = {"left": 0.06, "right": 0.985, "bottom": 0.15, "top": 0.88}
    left, middle, right = fig.subplots(1, 3, gridspec_kw=margins | {"wspace": 0.3})
    title = f"N = {particles}, {tracker.bins.m} bins"
    _draw_by_frame(left, by_frame, title)
    slopes = _draw_by_number(middle, by_number)
    fine, fixed = _draw_by_area(right, areas, by_area)
    parts = [
        _costs("frame", np.arange(1, FRAMES + 1), by_frame),
        _costs("samples", NUMBERS, by_number),
        _costs("area [px]", areas, by_area),
    ]
    table = pd.concat(parts, ignore_index=True)
    return shown(table, **by_frame, samples=slopes, pixels=fine, grid=fixed)


# Times are kept, so that a slider measures only what it changes.
@lru_cache(maxsize=64)
def step_costs(tracker: Adaptive, target: str, frames: int = FRAMES) -> Array:
    """CPU time of the first steps of a tracker on the parking place.

    Parameters
    ----------
    tracker : Adaptive
    target : {"person", "car"}
    frames : int

    Returns
    -------
    (frames,) array [ms]
        Without the rendering.
    """
    clip = runs.clip(parking(0, target))
    rng = np.random.default_rng(0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    spent = []
    for frame in clip.frames[1 : frames + 1]:
        spent.append(_cost_of_step(tracker, state, frame))
        state, _ = tracker.step(state, frame, rng)
    return locked(np.array(spent))


def _cost_of_step(tracker: Adaptive, state: AdaptiveState, frame: Frame) -> float:
    def step():
        tracker.step(state, frame, np.random.default_rng(1))

    return timing.milliseconds(step, TRIALS)


@lru_cache(maxsize=64)
def histogram_cost(
    bins: Bins, half: float, n: int = 100, as_pixels: bool = False
) -> float:
    """CPU time of the histograms of ellipses on an image of 320 x 240 pixels [ms].

    Parameters
    ----------
    bins : Bins
    half : float [px]
        The half axis H_x; H_y is 1.25 times that.
    n : int
        Number of ellipses.
    as_pixels : bool
        With a point for each pixel, in place of the fixed grid.
    """
    rng = np.random.default_rng(0)
    image = BinImage(rng.integers(0, bins.m, (240, 320)).astype(np.uint16), bins.m)
    disc = Disc(samples=int(4 * ASPECT * half**2)) if as_pixels else Disc()
    regions = np.tile([160.0, 120.0, 0.0, half, ASPECT * half], (n, 1))

    def count():
        disc.histograms(image, regions)

    return timing.milliseconds(count, TRIALS)


def _costs_by_number(tracker: Adaptive) -> dict[str, Array]:
    """CPU times [ms] for `NUMBERS` of samples: a frame, and the histograms alone."""
    trackers = [replace(tracker, n=n) for n in NUMBERS]
    frames = [step_costs(one, "car", 4).min() for one in trackers]
    costs = {"a frame": np.array(frames)}
    for name in COMPARED:
        alone = [histogram_cost(BINS[name], 40, n) for n in NUMBERS]
        costs[f"histograms, {BINS[name].m} bins"] = np.array(alone)
    return costs


def _costs_by_area(bins: Bins) -> dict[str, Array]:
    """CPU times [ms] for `HALVES`: with a point for each pixel, and the fixed grid."""
    fine = [histogram_cost(bins, half, as_pixels=True) for half in HALVES]
    fixed = [histogram_cost(bins, half) for half in HALVES]
    return {"every pixel": np.array(fine), "fixed grid": np.array(fixed)}


def _costs(against: str, at: ArrayLike, curves: Mapping[str, Array]) -> pd.DataFrame:
    """The points of some curves of one chart."""
    parts = [
        pd.DataFrame({"curve": name, "against": against, "at": at, "CPU time [ms]": t})
        for name, t in curves.items()
    ]
    return pd.concat(parts)


def _draw_by_frame(ax: Axes, curves: Mapping[str, Array], title: str) -> None:
    for name, costs in curves.items():
        frames = np.arange(1, len(costs) + 1)
        label = f"{name}: {np.median(costs):.1f} ms"
        ax.plot(frames, costs, color=TARGETS[name], label=label)
    ax.set(xlabel="frame", ylabel="CPU time [ms]", ylim=(0, None), title=title)
    ax.legend(loc="lower right")


def _draw_by_number(ax: Axes, curves: Mapping[str, Array]) -> list[float]:
    """Costs against the number of samples; returns the histograms' exponents."""
    (_, whole), *alone = curves.items()
    slopes = [timing.exponent(NUMBERS, costs) for _, costs in alone]
    ax.loglog(NUMBERS, whole, "o-", color=CAR, label="a frame of the car")
    styles = COMPARED.values()
    for (name, costs), slope, style in zip(alone, slopes, styles, strict=True):
        label = f"{name}: {_rounded(slope)}"
        ax.loglog(NUMBERS, costs, style, color=PLAIN, label=label)
    times = [0.2, 0.5, 1, 2, 5, 10]
    ax.set_xticks(NUMBERS, [str(n) for n in NUMBERS])
    ax.set_yticks(times, [f"{t:g}" for t in times])
    ax.minorticks_off()
    labels = {"xlabel": "samples N", "ylabel": "CPU time [ms]"}
    ax.set(ylim=(None, 9 * whole.max()), title="number of samples, and bins", **labels)
    ax.legend(loc="upper left", title="with the exponents", alignment="left")
    return slopes


def _rounded(slope: float) -> str:
    """An exponent in two places, one next to nothing without a minus."""
    return f"{round(slope, 2) + 0.0:.2f}"


def _draw_by_area(
    ax: Axes, areas: Array, curves: Mapping[str, Array]
) -> tuple[float, float]:
    """Costs against the area; returns the exponents, which leave out the smallest."""
    fine, fixed = curves.values()
    slopes = timing.exponent(areas[1:], fine[1:]), timing.exponent(areas[1:], fixed[1:])
    labels = [
        f"{name}: exponent {_rounded(slope)}"
        for name, slope in zip(curves, slopes, strict=True)
    ]
    ax.loglog(areas, fine, "o-", color=PALE, label=labels[0])
    ax.loglog(areas, fixed, "s-", color=PLAIN, label=labels[1])
    ax.set(
        xlabel="area of an ellipse [px]",
        ylabel="histograms of 100 ellipses [ms]",
        title="region size",
        ylim=(None, 3 * fine.max()),
    )
    ax.legend(loc="upper left")
    return slopes
