"""Teaching figures on trackers: the Newton step, resampling, a run frame by frame."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from mkt.colors import ColorBins
from mkt.evaluation import SEEN, Errors, errors, overlap
from mkt.figures.registry import REGION, Shown, at_most, figure, shown
from mkt.histograms import distance, learn, log_likelihood
from mkt.kernels import Kernels
from mkt.papers import runs
from mkt.papers.teuliere2009.histograms import still
from mkt.papers.teuliere2009.tracking import label
from mkt.particles import (
    SCHEMES,
    effective_sample_size,
    independent_positions,
    normalised,
    stratified_positions,
    systematic_positions,
    whole_and_rest,
)
from mkt.plotting import (
    CONTRAST,
    CURRENT,
    TRACKERS,
    TRUTH,
    TWELVE,
    draw_box,
    draw_region,
    draw_tracked,
    pale,
    shade_frames,
    show_frame,
)
from mkt.regions import corners, displaced
from mkt.scenes import SCENES
from mkt.trackers import by_name
from mkt.trackers.newton import newton_path
from mkt.tracking import Sequence as Clip
from mkt.tracking import Track, Tracker
from mkt.types import Array, Frame, NDArray, Region, Regions, Rng

STEPS = 10


@figure(
    "own.newton",
    size=(10, 4.6),
    live=("own.newton", "surfaces-car-hsv"),
    dx=(0, 64, 8),
    turn=(0, 80, 20),
    scale=(0.6, 1.6, 0.2),
    layout=["one", "3x3"],
    span=(0.6, 1.4, 0.2),
    derivative_of_c=[True, False],
)
def newton(
    fig: Figure,
    *,
    dx: float = 24,
    turn: float = 20,
    scale: float = 0.8,
    layout: str = "3x3",
    span: float = 1.0,
    derivative_of_c: bool = True,
    seed: int = 0,
) -> Shown:
    """Gauss-Newton on kernels, step by step.

    Left, the true region (black), the start that the sliders displace (thick, orange),
    the steps between (thin) and where ten steps lead (green).  Right, the distance and
    the remaining errors after every step, those below .03 at .03.

    In the page: Above, the true region (dashed, black and white), the start (thick,
    orange), the steps taken (thin) and where they lead (green), and beside it all
    starts: dark ones lead home.  Below, the distance after every step, and O along the
    next one with the parabola that the step takes it for.

    The object is learnt in one rendered frame and looked for in the next.  A single
    kernel cannot grow beyond the object, so above a span of 1 it stays as it is.
    """
    clip = still("car", seed)
    bins = ColorBins()
    learnt, image = (bins(frame) for frame in clip.frames)
    truth = clip.truth[1]
    widest = min(span, 1.0) if layout == "one" else span
    target = learn(learnt, truth, Kernels(layout, span=widest, samples=2400))
    start = displaced(truth, dx, 0, np.deg2rad(turn), scale)
    regions = newton_path(target, image, start, STEPS, derivative_of_c)
    distances = target.distances(image, regions)
    wrong = errors(regions, truth)

    ax = fig.add_axes((0.01, 0.02, 0.56, 0.9))
    _draw_path(ax, clip.frames[1], truth, regions)
    first, last = distances[[0, -1]]
    ax.set_title(f"distance {first:.2f} at the start, {last:.2f} after {STEPS} steps")
    margins = {"left": 0.66, "right": 0.985, "bottom": 0.11, "top": 0.94}
    spaces = margins | {"hspace": 0.16}
    upper, lower = fig.subplots(2, 1, sharex=True, gridspec_kw=spaces)
    upper.plot(distances, "o-", color=CURRENT, ms=4)
    upper.set(ylim=(0, 1), ylabel="distance $d_m$")
    remaining = _remaining(wrong)
    _draw_errors(lower, remaining)

    table = pd.DataFrame(regions, columns=REGION).rename_axis("step").reset_index()
    off = {f"error of {name}": values for name, values in remaining.items()}
    table = table.assign(distance=distances, **off)
    return shown(table, distances=distances, **wrong._asdict())


def _draw_path(ax: Axes, frame: Frame, truth: Region, regions: Array) -> None:
    """The regions (n, 5) from a start to an end over a pale frame."""
    show_frame(ax, pale(frame))
    draw_region(ax, truth, TRUTH)
    for region in regions[1:-1]:
        draw_box(ax, region, TRACKERS["ssd"], lw=1)
    draw_region(ax, regions[0], TRACKERS["ssd"], lw=2.5)
    draw_region(ax, regions[-1], CURRENT)
    ax.set(xlim=(60, 306), ylim=(215, 25))


def _remaining(wrong: Errors) -> dict[str, Array]:
    """Errors in the units of the picture."""
    return {
        "position [px]": wrong.position,
        "angle [deg]": np.rad2deg(wrong.orientation),
        "size [%]": 100 * np.abs(np.expm1(wrong.scale)),
    }


def _draw_errors(ax: Axes, remaining: Mapping[str, Array]) -> None:
    """What is left of each error after every step, (STEPS + 1,) each."""
    curves = zip(remaining.items(), CONTRAST, "os^", strict=True)
    for (name, values), color, marker in curves:
        seen = np.maximum(values, 0.03)
        ax.semilogy(seen, marker=marker, ms=4, color=color, label=name)
    ax.set(xlabel="step", xticks=range(0, STEPS + 1, 2))
    ax.set(ylabel="error", ylim=(0.02, 900))
    ax.minorticks_off()
    spaces = {"columnspacing": 0.8, "handletextpad": 0.3, "handlelength": 1.4}
    ax.legend(ncols=3, loc="upper center", **spaces)


@figure(
    "own.resampling",
    size=(10, 5),
    live=("own.resampling",),
    scheme=list(SCHEMES),
    n=(4, 12, 2),
    lam=(0, 60, 20),
    seed=(0, 4, 1),
)
def resampling(
    fig: Figure,
    *,
    scheme: str = "multinomial",
    n: int = 6,
    lam: float = 20,
    seed: int = 0,
) -> Shown:
    """Resampling by hand.

    Above, the weights of a few particles laid end to end, with the draws as ticks: a
    particle has as many offspring as ticks fall on it. Residual resampling first gives
    whole copies for certain; its bar shows only what rounding left over.  Below, the
    weights against the distances that made them, (13) of [T09]; the offspring against
    what is expected of them; and how far the offspring scatter round that over 400
    repetitions, for each scheme.
    """
    at_most(len(TWELVE), n=n)
    d = spread_distances(n)
    weights = normalised(log_likelihood(1 - d[:, None] ** 2, lam))
    ancestors = SCHEMES[scheme](weights, np.random.default_rng(seed))
    counts = np.bincount(ancestors, minlength=n)
    shares, positions = draws(scheme, weights, np.random.default_rng(seed))
    scatter = {name: offspring_scatter(weights, name) for name in SCHEMES}
    colors = TWELVE[:n]

    bar = fig.add_axes((0.02, 0.68, 0.96, 0.18))
    _draw_draws(bar, shares, positions, colors)
    title = f"{scheme}: {n} draws"
    if scheme == "residual" and len(positions):
        title = "residual: what rounding left over, and the draws from it"
    elif scheme == "residual":
        title = "residual: rounding left nothing over, all copies are certain"
    bar.set_title(title, pad=14)
    margins = {"left": 0.07, "right": 0.985, "bottom": 0.12, "top": 0.53}
    spaces = margins | {"wspace": 0.38}
    left, middle, right = fig.subplots(1, 3, gridspec_kw=spaces)
    _draw_weights(left, d, weights, colors)
    _draw_offspring(middle, counts, weights, colors)
    _draw_scatter(right, scatter, scheme)

    columns = {"particle": np.arange(n), "distance": d, "weight": weights}
    table = columns | {"offspring": counts, "expected offspring": n * weights}
    facts = {"weights": weights, "counts": counts, "draws": positions}
    n_eff = effective_sample_size(weights)
    return shown(table, n_eff=n_eff, scatter=list(scatter.values()), **facts)


def spread_distances(n: int) -> Array:
    """The distances (n,) of the particles of `resampling`, in no order."""
    return np.random.default_rng(3).permutation(np.linspace(0.1, 0.6, n))


_POSITIONS = {
    "multinomial": independent_positions,
    "stratified": stratified_positions,
    "systematic": systematic_positions,
}


def draws(scheme: str, weights: Array, rng: Rng) -> tuple[Array, Array]:
    """Where a scheme of `mkt.particles` draws, for a picture of it.

    Parameters
    ----------
    scheme : str
        One of `mkt.particles.SCHEMES`.
    weights : (N,) array
        Of sum 1.
    rng : numpy.random.Generator

    Returns
    -------
    shares : (N,) array
        Of the bar that the particles take up, of sum 1; for "residual" of what is left
        after the certain copies.
    positions : (K,) array
        The draws on it, in [0, 1).
    """
    n = len(weights)
    if scheme != "residual":
        return weights, _POSITIONS[scheme](n, rng)
    certain, left = whole_and_rest(weights)
    return left / max(left.sum(), 1e-9), independent_positions(n - certain.sum(), rng)


def offspring_scatter(weights: Array, scheme: str, repeats: int = 400) -> float:
    """Root mean square of the offspring minus N w, over all particles and draws.

    Parameters
    ----------
    weights : (N,) array
        Of sum 1.
    scheme : str
        One of `mkt.particles.SCHEMES`.
    repeats : int
        How often it is drawn.
    """
    rng = np.random.default_rng(0)
    n = len(weights)
    drawn = [SCHEMES[scheme](weights, rng) for _ in range(repeats)]
    counts = np.array([np.bincount(ancestors, minlength=n) for ancestors in drawn])
    return float(np.sqrt(np.mean((counts - n * weights) ** 2)))


def _draw_draws(
    ax: Axes, shares: Array, positions: Array, colors: Sequence[str]
) -> None:
    """A bar from 0 to 1, cut into shares, with ticks where the draws fall."""
    starts = np.cumsum(shares) - shares
    ax.barh(0, shares, left=starts, color=colors, edgecolor="black", lw=0.6, height=1)
    for i in np.flatnonzero(shares > 0.025):
        middle = starts[i] + shares[i] / 2
        ax.text(middle, 0, str(i), ha="center", va="center", weight="bold")
    ax.vlines(positions, 0.3, 0.9, color="black", lw=2)
    tops = np.full(len(positions), 0.95)
    ax.plot(positions, tops, "v", color="black", ms=7, clip_on=False)
    ax.set(xlim=(0, 1), ylim=(-0.5, 1), yticks=[], xlabel="cumulative weight")
    ax.spines["left"].set_visible(False)


def _draw_weights(ax: Axes, d: Array, weights: Array, colors: Sequence[str]) -> None:
    """Weights over the distances that made them."""
    ax.scatter(d, weights, s=60, c=colors, edgecolors="black", lw=0.6, zorder=3)
    n_eff = effective_sample_size(weights)
    ax.set_title(f"$N_{{eff}}$ = {n_eff:.1f} of {len(weights)}")
    ax.set(xlabel="distance $d$", xlim=(0, 0.7))
    ax.set(ylabel="weight $w$", ylim=(0, 1.05))


def _draw_offspring(
    ax: Axes, counts: NDArray, weights: Array, colors: Sequence[str]
) -> None:
    """How many offspring each particle has, and what is expected."""
    n = len(counts)
    ax.bar(range(n), counts, color=colors, edgecolor="black", lw=0.6)
    style = {"color": "black", "ms": 14, "mew": 2}
    ax.plot(range(n), n * weights, "_", label="expected, $N w$", **style)
    ax.set(title=f"{np.count_nonzero(counts)} of {n} live on")
    # Room for the legend above one that has them all.
    ax.set(xlabel="particle", xticks=range(n), ylabel="offspring", ylim=(0, 1.35 * n))
    ax.yaxis.get_major_locator().set_params(integer=True)
    ax.legend(loc="upper right")


def _draw_scatter(ax: Axes, scatter: Mapping[str, float], scheme: str) -> None:
    """The scatter under each scheme, the chosen one in black."""
    colors = ["black" if name == scheme else "0.7" for name in scatter]
    ax.barh(list(scatter), list(scatter.values()), color=colors)
    ax.set(title="how lucky is a draw?", xlabel="scatter of the offspring")
    ax.set_xlim(0, 1.3)
    ax.invert_yaxis()


OUTLINED = 30  # particles; more would be slow to draw and hide the frame
LAST = 79  # frame of the longer scene


@figure(
    "own.run",
    size=(10, 6.6),
    frame=(1, LAST, 1),
    tracker=[*TRACKERS, "guided"],
    particles=[25, 75, 250],
    scene=["hidden", "fast"],
    seed=[0, 1],
)
def run(
    fig: Figure,
    *,
    frame: int = 20,
    tracker: str = "pf-75",
    particles: int = 75,
    scene: str = "hidden",
    seed: int = 0,
) -> Shown:
    """A tracker at work, frame by frame.

    Above left, the frame: the truth dashed in black and white, the estimate in green,
    the hypotheses as dots, larger the more they weigh, the thirty heaviest with their
    outline.  Right, the distance of each of the nine parts at the estimate, and the
    sorted weights of the particles. Below, the whole run, the frame marked; grey where
    less than half of the target is visible, pale red where the tracker itself says that
    it is lost, dark red where both are so. Synthetic scenes of [T09]'s figures 6
    ("hidden") and 5 ("fast").  The number in "pf-1" counts kernels (it has 500
    particles), in "pf-500" and "pf-75" particles; the slider for particles concerns
    "pf-75" and "combined" alone.
    """
    at_most(LAST, frame=frame)
    source = SCENES[scene](seed)
    clip = runs.clip(source)
    looked_into = ("particles", "weights")
    track = runs.run(configured(tracker, particles), source, seed, looked_into)
    k = min(frame, len(clip) - 1)
    parts = _part_distances(clip, track.regions[k], k)
    hypotheses, weights = _hypotheses(track, k)
    iou = overlap(track.regions, clip.truth)

    left = fig.add_axes((0.01, 0.36, 0.56, 0.6))
    last = " (the last)" if k < frame else ""
    title = f"frame {k}{last}: {label(tracker, particles)}"
    estimate = track.regions[k]
    draw_tracked(left, clip.frames[k], clip.truth[k], estimate, CURRENT, title)
    margins = {"left": 0.65, "right": 0.985, "bottom": 0.43, "top": 0.95}
    spaces = margins | {"hspace": 0.68}
    upper, lower = fig.subplots(2, 1, gridspec_kw=spaces)
    _draw_parts(upper, parts)
    if len(weights):
        _draw_hypotheses(left, hypotheses, weights)
    _draw_sorted(lower, weights)
    _draw_course(fig.add_axes((0.065, 0.08, 0.92, 0.2)), clip, track, iou, k)

    n_eff = effective_sample_size(weights) if len(weights) else 0.0
    columns = {"frame": np.arange(len(clip)), "overlap": iou, "lost": track.lost}
    seen = {"distance": track.info["distance"], "visible fraction": clip.visibility}
    return shown(columns | seen, parts=parts, n_eff=n_eff)


def configured(name: str, particles: int) -> Tracker:
    """A tracker by its name, "pf-75" and "combined" with so many particles."""
    if name in ("pf-75", "combined"):
        return by_name.with_particles(name, particles)
    return by_name.TRACKERS[name]


def _part_distances(clip: Clip, region: Region, k: int) -> Array:
    """The distances (9,) of the nine parts at a region in frame k.

    Whatever kernels the tracker uses.
    """
    bins = ColorBins()
    tiles = Kernels("tiles", "uniform")
    target = learn(bins(clip.frames[0]), clip.truth[0], tiles)
    return distance(target.coefficients(bins(clip.frames[k]), region)[0])


def _hypotheses(track: Track, k: int) -> tuple[Regions, Array]:
    """Particles (N, 5) and weights (N,) of a frame; none for some trackers."""
    if not {"particles", "weights"} <= track.info.keys():
        return np.empty((0, 5)), np.empty(0)
    return track.info["particles"][k], track.info["weights"][k]


def _draw_parts(ax: Axes, parts: Array) -> None:
    """A bar for the distance of each of the nine parts."""
    ax.bar(range(1, 10), parts, color=CURRENT)
    ax.set(title="distance of each part at the estimate")
    ax.set(xlabel="part, row by row", xticks=(1, 5, 9))
    ax.set(ylabel="$d_j$", ylim=(0, 1), yticks=(0, 0.5, 1))


def _draw_hypotheses(ax: Axes, particles: Regions, weights: Array) -> None:
    """Particles as dots, the heaviest larger and outlined."""
    best = np.argsort(weights)[-OUTLINED:]
    heaviest = particles[best]
    size = weights[best] / weights.max()
    colors = [(0.8, 0.1, 0.5, 0.1 + 0.6 * share) for share in size]
    outlines = list(corners(heaviest)[:, [0, 1, 2, 3, 0]])
    ax.add_collection(LineCollection(outlines, colors=colors, lw=0.8, zorder=1.9))
    yellow = "#f0e442"
    ax.plot(*particles[:, :2].T, "o", color=yellow, ms=2.5, mec="black", mew=0.3)
    dots = {"color": yellow, "edgecolors": "black", "lw": 0.4, "zorder": 3}
    ax.scatter(*heaviest[:, :2].T, s=4 + 60 * size, **dots)


def _draw_sorted(ax: Axes, weights: Array) -> None:
    """Weights, the heaviest first."""
    n = len(weights)
    if not n:
        ax.set_axis_off()
        style = {"ha": "center", "transform": ax.transAxes}
        ax.text(0.5, 0.5, "this tracker has no particles", **style)
        return
    edges = np.arange(n + 1) + 0.5
    ax.stairs(np.sort(weights)[::-1], edges, fill=True, color="#cc79a7")
    ax.set_xscale("log")  # often one of hundreds has nearly all
    ax.xaxis.set_major_formatter("{x:g}")
    ax.locator_params(axis="y", nbins=4)
    ax.set_title(f"$N_{{eff}}$ = {effective_sample_size(weights):.1f} of {n}")
    ax.set(xlabel="particle, heaviest first", xlim=(0.5, n + 0.5))
    ax.set(ylabel="weight $w$")


def _draw_course(ax: Axes, clip: Clip, track: Track, iou: Array, k: int) -> None:
    """Overlap (T,) and distance over the whole run, frame k marked.

    The frames in which the target is hidden, or said to be lost, are shaded.
    """
    times = np.arange(len(clip))
    shade_frames(ax, times, clip.visibility <= SEEN, color="0.8")
    shade_frames(ax, times, track.lost, color="#d62728", alpha=0.2)
    ax.plot(times, iou, color=CURRENT, lw=2, label="overlap with the truth")
    dashed = {"color": "0.2", "ls": "--", "lw": 1.2}
    ax.plot(times, track.info["distance"], label="distance $d_m$", **dashed)
    ax.axvline(k, color="black", lw=1.2)
    ax.set(xlabel="frame", xlim=(0, times[-1] + 0.5), xticks=range(0, len(clip), 20))
    ax.set(ylim=(0, 1.03), yticks=(0, 0.5, 1))
    ax.legend(loc="lower left", ncols=2, bbox_to_anchor=(0, 0.98), borderaxespad=0.2)
