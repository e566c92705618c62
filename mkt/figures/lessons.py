"""Teaching figures of the chapters on trackers: the Newton step, resampling, and a run frame by frame."""

from functools import lru_cache

import numpy as np
from matplotlib.collections import LineCollection

from mkt.evaluation import errors, overlap
from mkt.figures import figure
from mkt.figures.runs import clip
from mkt.figures.teuliere2009 import still
from mkt.histograms import ColorBins, distance, learn, log_likelihood
from mkt.kernels import Kernels
from mkt.particles import SCHEMES, effective_sample_size, normalised
from mkt.plotting import CONTRAST, CURRENT, TRACKERS, TRUTH, draw_box, draw_region, draw_tracked, show_frame
from mkt.regions import corners, displaced
from mkt.scenarios import fast, hidden
from mkt.trackers import catalogue
from mkt.trackers.ssd import differentiate, moved, newton_step
from mkt.tracking import track

STEPS = 10


@figure("own.newton", size=(10, 4.6), grid=("dx", "span"), dx=(0, 64, 8), turn=(0, 80, 20), scale=(0.6, 1.6, 0.2), layout=["one", "3x3"], span=(0.6, 1.4, 0.2),
        derivative_of_c=[True, False])
def newton(canvas, *, dx=24, turn=20, scale=1.2, layout="3x3", span=1.0, derivative_of_c=True, seed=0):
    """Gauss-Newton on kernels, step by step.

    Left, the true region (black), the start that the sliders displace (thick, orange), the steps between (thin) and where ten steps
    lead (green).  Right, the distance and the remaining errors after every step.  The object is learnt in one rendered frame and
    looked for in the next.  A single kernel cannot grow beyond the object, so above a span of 1 it stays as it is.
    """
    scene, bins = still("car", seed), ColorBins()
    truth, learnt, image = scene.truth[1], *(bins(frame) for frame in scene.frames)
    target = learn(learnt, truth, bins, Kernels(layout, span=min(span, 1.0) if layout == "one" else span, samples=2400))
    regions = newton_path(target, image, displaced(truth, dx, 0, np.deg2rad(turn), scale), derivative_of_c)
    distances, wrong = target.distances(image, regions), errors(regions, truth)

    ax = canvas.add_axes((0.01, 0.02, 0.56, 0.9))
    pale = 255 - (255 - scene.frames[1]) // 2
    show_frame(ax, pale, f"distance {distances[0]:.2f} at the start, {distances[-1]:.2f} after {STEPS} steps")
    draw_region(ax, truth, TRUTH)
    for region in regions[1:-1]:
        draw_box(ax, region, TRACKERS["ssd"], lw=1)
    draw_region(ax, regions[0], TRACKERS["ssd"], lw=2.5)
    draw_region(ax, regions[-1], CURRENT)
    ax.set(xlim=(60, 306), ylim=(215, 25))
    upper, lower = canvas.subplots(2, 1, sharex=True, gridspec_kw={"left": 0.66, "right": 0.985, "bottom": 0.11, "top": 0.94, "hspace": 0.16})
    upper.plot(distances, "o-", color=CURRENT, ms=4)
    upper.set(ylim=(0, 1), ylabel="distance $d_m$")
    remaining = {"position [px]": wrong.position, "angle [deg]": np.rad2deg(wrong.orientation), "size [%]": 100 * np.abs(np.expm1(wrong.scale))}
    for (label, values), color, marker in zip(remaining.items(), CONTRAST, "os^"):
        lower.semilogy(np.maximum(values, 0.03), marker=marker, ms=4, color=color, label=label)
    lower.set(ylim=(0.02, 900), xlabel="step", ylabel="error", xticks=range(0, STEPS + 1, 2))
    lower.minorticks_off()
    lower.legend(ncols=3, loc="upper center", columnspacing=0.8, handletextpad=0.3, handlelength=1.4)
    return {"distances": distances, "position": wrong.position, "orientation": wrong.orientation, "scale": wrong.scale}


def newton_path(target, image, start, derivative_of_c=True, steps=STEPS):
    """Regions (steps + 1, 5) from a start (5,), one Gauss-Newton step after the other, (9) of [T09]."""
    regions = [np.asarray(start, float)]
    for _ in range(steps):
        q, dq = differentiate(target, image, regions[-1], derivative_of_c)
        regions.append(moved(regions[-1], newton_step(q, dq, target.q)))
    return np.array(regions)


@figure("own.resampling", size=(10, 5), grid=("scheme", "lam"), scheme=list(SCHEMES), n=(4, 12, 2), lam=(0, 60, 20), seed=(0, 4, 1))
def resampling(canvas, *, scheme="multinomial", n=6, lam=20, seed=0):
    """Resampling by hand.

    Above, the weights of a few particles laid end to end, with the draws as ticks: a particle has as many offspring as ticks fall on it.
    Residual resampling first gives whole copies for certain; its bar shows only what rounding left over.  Below, the weights against the
    distances that made them, (13) of [T09]; the offspring against what is expected of them; and how far the offspring scatter round that
    over 400 repetitions, for each scheme.
    """
    d = np.random.default_rng(3).permutation(np.linspace(0.1, 0.6, n))
    weights = normalised(log_likelihood(1 - d[:, None] ** 2, lam))
    counts = np.bincount(SCHEMES[scheme](weights, np.random.default_rng(seed)), minlength=n)
    colors = [PALETTE[i % len(PALETTE)] for i in range(n)]

    bar = canvas.add_axes((0.02, 0.68, 0.96, 0.18))
    _draw_draws(bar, *draws(scheme, weights, np.random.default_rng(seed)), colors)
    bar.set_title(f"{scheme}: {n} draws" if scheme != "residual" else "residual: what rounding left over, and the draws from it", pad=14)
    left, middle, right = canvas.subplots(1, 3, gridspec_kw={"left": 0.07, "right": 0.985, "bottom": 0.12, "top": 0.53, "wspace": 0.38})
    left.scatter(d, weights, s=60, c=colors, edgecolors="black", lw=0.6, zorder=3)
    left.set(xlabel="distance $d$", ylabel="weight $w$", xlim=(0, 0.7), ylim=(0, 1.05), title=f"$N_{{eff}}$ = {effective_sample_size(weights):.1f} of {n}")
    middle.bar(range(n), counts, color=colors, edgecolor="black", lw=0.6)
    middle.plot(range(n), n * weights, "_", color="black", ms=14, mew=2, label="expected, $N w$")
    middle.set(xlabel="particle", ylabel="offspring", ylim=(0, n + 0.5), xticks=range(n), title=f"{np.count_nonzero(counts)} of {n} live on")
    middle.legend(loc="upper right")
    scatter = {name: offspring_scatter(weights, name) for name in SCHEMES}
    right.barh(list(scatter), list(scatter.values()), color=["black" if name == scheme else "0.7" for name in scatter])
    right.set(xlabel="scatter of the offspring", title="how lucky is a draw?", xlim=(0, 1.3))
    right.invert_yaxis()
    return {"weights": weights, "counts": counts, "n_eff": effective_sample_size(weights), "scatter": list(scatter.values())}


PALETTE = ("#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7", "#999999")  # Okabe and Ito


def draws(scheme, weights, rng):
    """Where a scheme of `mkt.particles` draws, for a picture of it.

    Returns the shares (N,) of the bar that the particles take up, of sum 1, and the draws on it in [0, 1); for "residual" of what is left
    after the certain copies.
    """
    n = len(weights)
    if scheme == "residual":
        left = np.maximum(n * weights - np.floor(n * weights + 1e-9), 0)
        missing = round(left.sum())
        return left / max(left.sum(), 1e-9), rng.random(missing)
    inside = {"multinomial": lambda: n * rng.random(n), "stratified": lambda: np.arange(n) + rng.random(n), "systematic": lambda: np.arange(n) + rng.random()}
    return weights, inside[scheme]() / n


def offspring_scatter(weights, scheme, repeats=400):
    """Root mean square of the offspring minus N w, over all particles and repeated draws."""
    rng, n = np.random.default_rng(0), len(weights)
    counts = [np.bincount(SCHEMES[scheme](weights, rng), minlength=n) for _ in range(repeats)]
    return float(np.sqrt(np.mean((counts - n * weights) ** 2)))


def _draw_draws(ax, shares, positions, colors):
    """A bar from 0 to 1, cut into shares, with ticks where the draws fall."""
    starts = np.cumsum(shares) - shares
    ax.barh(0, shares, left=starts, color=colors, edgecolor="black", lw=0.6, height=1)
    for i in np.flatnonzero(shares > 0.025):
        ax.text(starts[i] + shares[i] / 2, 0, str(i), ha="center", va="center", weight="bold")
    ax.vlines(positions, 0.3, 0.9, color="black", lw=2)
    ax.plot(positions, np.full(len(positions), 0.95), "v", color="black", ms=7, clip_on=False)
    ax.set(xlim=(0, 1), ylim=(-0.5, 1), yticks=[], xlabel="cumulative weight")
    ax.spines["left"].set_visible(False)


SCENES = {"hidden": hidden, "fast": fast}
OUTLINED = 30  # particles; more would be slow to draw and hide the frame


@figure("own.run", size=(10, 6.6), frame=(1, 79, 1), tracker=[*TRACKERS, "guided"], particles=[25, 75, 250], scene=list(SCENES), seed=[0, 1])
def run(canvas, *, frame=20, tracker="pf-75", particles=75, scene="hidden", seed=0):
    """A tracker at work, frame by frame.

    Above left, the frame: the truth dashed in black and white, the estimate in green, the hypotheses as dots, larger the more they
    weigh, the thirty heaviest with their outline.  Right, the distance of each of the nine parts at the estimate, and the sorted weights of the particles.
    Below, the whole run, the frame marked; grey where less than half of the target is visible, red where the tracker itself says that it is lost.
    Synthetic scenes of [T09]'s figures 6 ("hidden") and 5 ("fast").  The number in "pf-1" counts kernels (it has 500 particles), in "pf-500" and
    "pf-75" particles; the slider for particles concerns "pf-75" and "combined" alone.
    """
    scene = SCENES[scene](seed)
    sequence, result = clip(scene), watched(configured(tracker, particles), scene, seed)
    frame = min(frame, len(sequence) - 1)
    image, estimate, parts = sequence.frames[frame], result.regions[frame], part_distances(scene, result, frame)
    left = canvas.add_axes((0.01, 0.36, 0.56, 0.6))
    draw_tracked(left, image, sequence.truth[frame], estimate, CURRENT, f"frame {frame}: {catalogue.LABELS[tracker].replace('75', str(particles))}")
    upper, lower = canvas.subplots(2, 1, gridspec_kw={"left": 0.65, "right": 0.985, "bottom": 0.43, "top": 0.95, "hspace": 0.68})
    upper.bar(range(1, 10), parts, color=CURRENT)
    upper.set(ylim=(0, 1), yticks=(0, 0.5, 1), xticks=(1, 5, 9), xlabel="part, row by row", ylabel="$d_j$", title="distance of each part at the estimate")
    n_eff = _draw_particles(left, lower, result.info, frame)
    below = canvas.add_axes((0.065, 0.08, 0.92, 0.2))
    _draw_course(below, sequence, result, frame)
    return {"parts": parts, "n_eff": n_eff, "overlap": overlap(result.regions, sequence.truth), "lost": result.lost}


def configured(name, particles):
    """A tracker of the catalogue, "pf-75" and "combined" with so many particles."""
    return catalogue.with_particles(name, particles) if name in ("pf-75", "combined") else catalogue.get(name)


@lru_cache(maxsize=12)
def watched(tracker, scene, seed):
    """A whole run with its infos, which `mkt.figures.runs` does without: here every step is looked into.  Returns a `Track`."""
    return track(tracker, clip(scene), seed)


def part_distances(scene, result, frame):
    """The distance of each of the nine parts at the estimate of a frame, (9,), whatever kernels the tracker uses."""
    sequence, bins = clip(scene), ColorBins()
    target = learn(bins(sequence.frames[0]), sequence.truth[0], bins, Kernels("tiles", "uniform"))
    return distance(target.coefficients(bins(sequence.frames[frame]), result.regions[frame])[0])


def _draw_particles(ax, below, info, frame):
    """Hypotheses over the frame and their sorted weights below.  Returns N_eff, 0 for a tracker without particles."""
    if "particles" not in info:
        below.set_axis_off()
        below.text(0.5, 0.5, "this tracker has no particles", ha="center", transform=below.transAxes)
        return 0.0
    regions, weights = info["particles"][frame], info["weights"][frame]
    size = weights / weights.max()
    best = np.argsort(weights)[-OUTLINED:]
    colors = [(0.8, 0.1, 0.5, 0.1 + 0.6 * a) for a in size[best]]
    ax.add_collection(LineCollection(corners(regions[best])[:, [0, 1, 2, 3, 0]], colors=colors, lw=0.8, zorder=1.9))
    ax.plot(*regions[:, :2].T, "o", color="#f0e442", ms=2.5, mec="black", mew=0.3)
    ax.scatter(*regions[best, :2].T, s=4 + 60 * size[best], color="#f0e442", edgecolors="black", lw=0.4, zorder=3)
    below.stairs(np.sort(weights)[::-1], np.arange(len(weights) + 1) + 0.5, fill=True, color="#cc79a7")
    below.locator_params(nbins=4)
    below.set(xlabel="particle, heaviest first", ylabel="weight $w$", xlim=(0.5, len(weights) + 0.5), title=f"$N_{{eff}}$ = {effective_sample_size(weights):.1f} of {len(weights)}")
    return effective_sample_size(weights)


def _draw_course(ax, sequence, result, frame):
    """Overlap and distance over the whole run, the hidden and the lost frames shaded, the current one marked."""
    times = np.arange(len(sequence))
    ax.fill_between(times, 0, 1, where=sequence.visibility < 0.5, step="mid", color="0.8", lw=0)
    ax.fill_between(times, 0, 1, where=result.lost, step="mid", color="#d62728", alpha=0.2, lw=0)
    ax.plot(times, overlap(result.regions, sequence.truth), color=CURRENT, lw=2, label="overlap with the truth")
    ax.plot(times[1:], result.info["distance"][1:], color="0.2", ls="--", lw=1.2, label="distance $d_m$")
    ax.axvline(frame, color="black", lw=1.2)
    ax.set(xlim=(0, times[-1]), ylim=(0, 1), yticks=(0, 0.5, 1), xticks=range(0, len(sequence), 20), xlabel="frame")
    ax.legend(loc="lower left", ncols=2, bbox_to_anchor=(0, 0.98), borderaxespad=0.2)
