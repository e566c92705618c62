"""Figures of the four wishes of [N03]: a landscape each, and what it is worth.

On the right of three of them stand means over the held-back scenes with their 95 %
intervals, from the table of `mkt.papers.lessons.wishes`.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.autoregression import changes
from mkt.colors import ColorBins
from mkt.experiments.statistics import FRACTION, interval
from mkt.figures.registry import Shown, at_most, figure, shown
from mkt.histograms import histograms, learn
from mkt.kernels import Kernels
from mkt.neighbours import MEASURES, SoftBins
from mkt.papers.lessons import wishes
from mkt.papers.lessons.bin_images import CAR
from mkt.particles import Particles
from mkt.plotting import (
    CONTRAST,
    CURRENT,
    DASHES,
    TRUTH,
    draw_region,
    draw_truth,
    pale,
    show_frame,
)
from mkt.regions import displaced
from mkt.scenes.two_cameras import TwoViews, homographies, seen
from mkt.scenes.varied import Varied
from mkt.silhouettes import AROUND, SHAPES, masked, patch
from mkt.types import Array, Frame, Region

REACH = np.linspace(-60, 60, 49)  # [px]
LEFT = {"left": 0.01, "right": 0.985, "bottom": 0.16, "top": 0.88, "wspace": 0.35}
STYLES = {
    "bhattacharyya": (TRUTH, DASHES[0]),
    "soft votes": (CONTRAST[0], DASHES[0]),
    "smoothed": (CONTRAST[1], DASHES[0]),
    "quadratic": (CONTRAST[2], DASHES[1]),
    "earth mover": ("0.55", DASHES[2]),
}


def _draw_means(
    ax: Axes, cells: dict[str, tuple[str, str, str]], number: str
) -> pd.DataFrame:
    """Means over scenes of {text: (kind, label, colour)} with intervals, as a table."""
    rows = wishes.runs()
    lines = []
    for y, (text, (kind, label, color)) in enumerate(cells.items()):
        cell = rows[(rows["source"] == kind) & (rows["tracker"] == label)]
        value, low, high = interval(cell[number].to_numpy(float), FRACTION)
        lines.append({"what": text, number: value, "low": low, "high": high})
        ax.hlines(y, low, high, color=color, lw=2)
        ax.plot(value, y, "o", color=color)
    table = pd.DataFrame(lines)
    ax.set_yticks(range(len(table)), table["what"].tolist())
    ax.set(xlabel=f"{number}, mean of 32 scenes", ylim=(len(table) - 0.5, -0.5))
    ax.grid(axis="x", alpha=0.3)
    return table


@figure(
    "own.neighbours",
    size=(10, 3.8),
    count=[5, 10, 20, 30],
    cast=(0.0, 0.6, 0.1),
    grain=(0, 40, 10),
)
def neighbours(
    fig: Figure, *, count: int = 30, cast: float = 0.2, grain: float = 3
) -> Shown:
    """What a bin knows of its neighbours.

    Left, the frame in which the car is looked for, under a light that lacks a share of
    blue and half of that of green, and with grain [grey levels]; dashed where it is.
    Middle, the squared distance of regions along x, each over its largest value, for
    Bhattacharyya's distance of hard bins and four that know neighbouring bins.  Right,
    what each was worth to a filter of 50 particles with 930 bins in changing light,
    over the held-back scenes; the lines are 95 % intervals of the mean.  Learnt in a
    sharp frame in white light.  Synthetic data.
    """
    margins = LEFT | {"wspace": 0.5, "top": 0.82}
    axes = fig.subplots(1, 3, width_ratios=(1.1, 1.2, 0.9), gridspec_kw=margins)
    frame, region = _lit(cast, grain)
    found = _sections(frame, region, ColorBins(counts=(count,) * 3))
    curves = {name: curve / curve.max() for name, curve in found.items()}
    show_frame(axes[0], frame, f"{count} bins of each channel")
    draw_truth(axes[0], region)
    off = {}
    for name, curve in curves.items():
        color, dashes = STYLES[name]
        axes[1].plot(REACH, curve, color=color, ls=dashes, label=name)
        off[f"off_{name}"] = float(abs(REACH[curve.argmin()]))
    axes[1].set(xlabel="x [px]", ylabel="$d^2$ over its largest", ylim=(0, 1.05))
    place = {"loc": "lower center", "bbox_to_anchor": (0.5, 1), "borderaxespad": 0.2}
    axes[1].legend(fontsize=8, ncols=2, columnspacing=1, **place)
    cells = {
        name: ("light", f"{name}, 930 bins", color)
        for name, (color, _) in STYLES.items()
    }
    means = _draw_means(axes[2], cells, "overlap")
    return shown({"x [px]": REACH, **curves}, means=means, **off)


def _lit(cast: float, noise: float) -> tuple[Frame, Region]:
    """The car in another light, and where it is."""
    light = ((0.0, 1.0, 1 - cast / 2, 1 - cast),)
    clip = replace(CAR, light=light, noise=float(noise)).sequence()
    return clip.frames[1], clip.truth[1]


def _sections(frame: Frame, region: Region, bins: ColorBins) -> dict[str, Array]:
    """D^2 of the regions along x, the mean over nine kernels, by each measure."""
    before = CAR.sequence().frames[1]
    tiles = Kernels("tiles", "uniform")
    regions = displaced(region, REACH)
    target = learn(bins(before), region, tiles)
    q = histograms(bins(frame), target.kernels, regions)
    curves = {name: d2(q, target.q, bins).mean(-1) for name, d2 in MEASURES.items()}
    soft = SoftBins(bins)
    target = learn(soft(before), region, tiles)
    curves["soft votes"] = target.distances(soft(frame), regions) ** 2
    return {name: curves[name] for name in STYLES}


@figure(
    "own.silhouettes",
    size=(10, 3.6),
    item=["ring", "starfish", "car"],
    ground=["workshop", "tissue", "bricks", "grass"],
    seed=(0, 3, 1),
)
def silhouettes(
    fig: Figure, *, item: str = "starfish", ground: str = "grass", seed: int = 0
) -> Shown:
    """Where a target is, inside its box.

    From the left: the first frame round the box; the shape by grab-cut; the share of
    each pixel's colour that lies inside rather than around, both with their mean over
    the box; the squared distance of regions along x a second later, over its largest
    value, for one kernel of constant weight on the box, on the ellipse and on both
    shapes; and the overlap of a filter with 50 particles over the held-back scenes with
    rings and starfish; the lines are 95 % intervals of the mean.  Synthetic data.
    """
    widths = (1, 1, 1, 1.5, 1.2)
    axes = fig.subplots(
        1, 5, width_ratios=widths, gridspec_kw=LEFT | {"right": 0.9, "wspace": 0.3}
    )
    scene = Varied("calm", seed).scene()
    target = replace(scene.target, texture=item)
    clip = replace(scene, target=target, background=ground).sequence()
    first, region = clip.frames[0], clip.truth[0]
    masks = {name: shape(first, region) for name, shape in SHAPES.items()}
    show_frame(axes[0], patch(first, region, AROUND), "first frame")
    for ax, (name, mask) in zip(axes[1:3], masks.items(), strict=True):
        ax.imshow(mask, cmap="gray", vmin=0, vmax=1)
        ax.set(title=f"{name}: {mask.mean():.0%}", xticks=[], yticks=[])
    kernels = {"box": wishes.BOX, "ellipse": wishes.ELLIPSE}
    for name, mask in masks.items():
        kernels[name] = masked(wishes.BOX, mask)
    later, there, curves = clip.frames[25], clip.truth[25], {}
    colors = dict(zip(kernels, ("0.55", TRUTH, *CONTRAST[:2]), strict=True))
    for name, kernel in kernels.items():
        learnt = learn(ColorBins()(first), region, kernel)
        d2 = learnt.distances(ColorBins()(later), displaced(there, REACH)) ** 2
        curves[name] = d2 / d2.max()
        axes[3].plot(REACH, curves[name], color=colors[name], label=name)
    axes[3].set(xlabel="x [px]", title="$d^2$ over its largest", ylim=(0, 1.4))
    axes[3].set_yticks(np.linspace(0, 1, 6))
    narrow = {"ncols": 2, "handlelength": 1.0, "columnspacing": 0.8}
    axes[3].legend(fontsize=8, loc="upper center", **narrow)  # above the curves
    cells = {name: ("cut-out", name, color) for name, color in colors.items()}
    means = _draw_means(axes[4], cells, "overlap")
    axes[4].yaxis.tick_right()
    axes[4].spines.left.set_visible(False)
    axes[4].spines.right.set_visible(True)
    axes[4].set_xlabel("overlap, 32 scenes")
    areas = {f"area_{name}": float(mask.mean()) for name, mask in masks.items()}
    return shown({"x [px]": REACH, **curves}, means=means, **areas)


MODELS = {
    "by hand": CONTRAST[2],
    "by hand, loose": "0.4",
    "learnt on calm": CONTRAST[0],
    "learnt on swift": CONTRAST[1],
}


@figure(
    "own.learnt_motion",
    size=(10, 3.8),
    kind=["swift", "calm"],
    k=(5, 45, 5),
    ahead=(1, 8, 1),
    seed=(0, 3, 1),
)
def learnt_motion(
    fig: Figure, *, kind: str = "swift", k: int = 25, ahead: int = 4, seed: int = 0
) -> Shown:
    """Where motion models believe that a target goes.

    Left, one frame of a path with the target's true middle in the last frames and the
    next (a black line, with a cross where it is then), and for each model 200 particles
    some frames ahead, which started from the true region and the true change of it.
    In the middle, how far these are from the truth at that time, in the median.  Right,
    hits of filters with 20 particles over the held-back scenes of the same kind; the
    lines are 95 % intervals of the mean.
    The learnt models are those of the chapter, from the true paths of other scenes.
    Synthetic data.
    """
    clip = Varied(kind, seed).sequence()
    truth = clip.truth
    at_most(len(truth) - 2, k=k)
    at_most(len(truth) - 1 - k, ahead=ahead)
    axes = fig.subplots(
        1, 3, width_ratios=(1.25, 1, 0.9), gridspec_kw=LEFT | {"wspace": 0.5}
    )
    rng = np.random.default_rng(seed)
    frames = "frame" if ahead == 1 else "frames"
    show_frame(axes[0], pale(clip.frames[k]), f"{kind}, {ahead} {frames} ahead of {k}")
    spread, inside = {}, {}
    for name, color in MODELS.items():
        cloud = _predicted(name, truth[k - 1 : k + 1], ahead, rng)
        axes[0].plot(*cloud[:, :2].T, ".", color=color, ms=3, label=name)
        off = np.linalg.norm(cloud[:, :2] - truth[k + ahead, :2], axis=1)
        inside[name] = float(np.mean(off < 10))
        spread[name] = float(np.median(off))
    axes[0].plot(*truth[max(k - 5, 0) : k + ahead + 1, :2].T, "-", color=TRUTH, lw=1.5)
    for color, size, thick in (("white", 15, 6), (TRUTH, 12, 2.5)):
        axes[0].plot(*truth[k + ahead, :2], "x", color=color, ms=size, mew=thick)
    bars = axes[1].barh(list(spread), list(spread.values()))
    for bar, color in zip(bars, MODELS.values(), strict=True):
        bar.set_color(color)
    axes[1].set(xlabel="median distance from the truth [px]")
    axes[1].set_ylim(len(MODELS) - 0.5, -0.5)  # rows level with those at the right
    cells = {name: (kind, f"{name}, 20", color) for name, color in MODELS.items()}
    means = _draw_means(axes[2], cells, "hits")
    axes[2].set_yticks([])
    axes[2].set_xlabel("hits of 20 particles, 32 scenes")
    table = {"model": list(spread), "median [px]": list(spread.values())}
    return shown(table, means=means, inside=inside)


def _predicted(name: str, two: Array, ahead: int, rng: np.random.Generator) -> Array:
    """Regions (200, 5) some frames after the second of two true ones, (2, 5)."""
    model = wishes.motions()[name]
    change = changes(two)[0]
    carried = np.diff(two[:, :2], axis=0)[0] if "hand" in name else change
    cloud = Particles(np.tile(two[1], (200, 1)), np.tile(carried, (200, 1)))
    for _ in range(ahead):
        cloud = model.predict(cloud, rng)
    return cloud.regions


@figure(
    "own.two_cameras",
    size=(10, 3.6),
    grid=("k", "off"),
    k=(10, 50, 10),
    off=(0, 40, 10),
    talking=[True, False],
    seed=(0, 3, 1),
)
def two_cameras(
    fig: Figure, *, k: int = 30, off: float = 0, talking: bool = True, seed: int = 0
) -> Shown:
    """Two cameras on one ground, the first of them behind a wall.

    Left and middle, a frame of both: the truth in black, the filters in green.  Right,
    how far the estimate of the first is from the true middle, alone (grey) and, where
    they talk, told by the second (blue), whose calibration may be off by some pixels on
    the ground; the band is the time in which more than half of the target is behind the
    wall.  100 particles each; synthetic data.
    """
    views = TwoViews(seed)
    at_most(len(views.truth) - 1, k=k)
    axes = fig.subplots(1, 3, width_ratios=(1, 1, 1.1), gridspec_kw=LEFT)
    matrices = homographies()
    run = wishes.exchanged(seed, talking, float(off))
    alone = wishes.exchanged(seed, False, 0.0)["errors"][:, 0]
    truths = np.array([[seen(H, r) for H in matrices] for r in views.truth])
    for ax, frame, i in zip(axes, views.frames(k), (0, 1), strict=False):
        show_frame(ax, frame, f"camera {i + 1}, frame {k}")
        draw_region(ax, truths[k, i], TRUTH)
        draw_region(ax, run["regions"][k, i], CURRENT)
    hidden = np.flatnonzero(wishes.behind_the_wall(truths[:, 0]))
    axes[2].axvspan(hidden[0], hidden[-1], color="0.5", alpha=0.2, lw=0)
    axes[2].plot(alone, color="0.55", ls=DASHES[1], label="alone")
    if talking:
        axes[2].plot(run["errors"][:, 0], color=CONTRAST[0], label="told")
    axes[2].axvline(k, color="0.3", lw=0.8)
    largest = max(alone.max(), run["errors"][:, 0].max())
    axes[2].set(xlabel="frame", ylabel="error of camera 1 [px]")
    axes[2].set_ylim(0, max(120, 1.05 * largest))
    axes[2].legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, borderaxespad=0.1)
    table = {"frame": np.arange(len(alone)), "alone [px]": alone}
    if talking:
        table["told [px]"] = run["errors"][:, 0]
    return shown(table, bytes=float(run["bytes"][1:].mean()))
