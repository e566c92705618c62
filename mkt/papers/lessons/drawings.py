"""Drawings of how trackers work, one at the head of each of chapters 4 to 6, 9 to 14.

See `mkt.papers.lessons.pencil`.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Polygon, Rectangle

from mkt.evaluation import overlap
from mkt.histograms import coefficient, log_likelihood
from mkt.papers.lessons.pencil import (
    BLUE,
    BOX,
    MIDDLE,
    ORANGE,
    PURPLE,
    arrow,
    boxes,
    canvas,
    drawing,
)
from mkt.papers.nummiaro2003.sequences import WITH
from mkt.papers.nummiaro2003.steps import MISSED, PLAIN
from mkt.particles import SCHEMES, effective_sample_size, normalised
from mkt.plotting import CURRENT, DESIRED, EIGHT, TRACKERS, TRUTH
from mkt.regions import from_box
from mkt.trackers.hybrid_resampling import HybridResampling
from mkt.types import Array


@drawing("04", 9, 3)
def newton_on_kernels(fig: Figure) -> None:
    """A ball on a surface, and a kernel over pixels: chapter 4.

    Left, a ball on a curve with two bowls: from the right start it jumps to the
    bottom of the parabola that fits the curve under it, from another start into the
    wrong bowl. Right, a kernel is moved over a row of coloured pixels: the pixels stay
    in their bins, and only their weights change.
    """
    left, right = fig.subplots(1, 2, gridspec_kw={"bottom": 0.16, "wspace": 0.12})
    x = np.linspace(-3.2, 5.2, 400)
    left.plot(x, _two_bowls(x), color=TRUTH, lw=1.5)
    for start, color in ((0.55, CURRENT), (3.42, DESIRED)):
        value = _two_bowls(start)
        slope, bend = _slopes(start)
        end = start - slope / bend
        near = np.linspace(min(start, end) - 0.6, max(start, end) + 0.6, 50)
        fitted = value + slope * (near - start) + bend / 2 * (near - start) ** 2
        left.plot(near, fitted, "--", color=color, lw=1.2)
        left.plot(start, value, "o", color=color, ms=11)
        arrow(left, (start, value), (end, _two_bowls(end)), color=color)
    left.text(0, -0.19, "the target", **MIDDLE)
    left.text(4.1, 0.13, "something like it", **MIDDLE)
    left.set(xlim=(-3.2, 5.2), ylim=(-0.25, 1.2), xticks=[], yticks=[])
    left.set(xlabel="place, angle, size", ylabel="$O(x)$")
    _draw_row(right)


def _two_bowls(x: Any) -> Any:
    """A curve with its lowest point at 0 and another one near 3.8."""
    return 1 - np.exp(-((x / 1.7) ** 2)) - 0.65 * np.exp(-(((x - 3.8) / 1.1) ** 2))


def _slopes(x: float) -> tuple[float, float]:
    """The first derivative of the curve, and the second."""
    h = 1e-3
    low, middle, high = (_two_bowls(x + k * h) for k in (-1, 0, 1))
    return (high - low) / (2 * h), (high - 2 * middle + low) / h**2


def _draw_row(ax: Axes) -> None:
    """Pixels that stay, and a kernel before and after a move."""
    bins = np.array([0, 0, 1, 1, 1, 2, 2, 1, 0, 0, 2, 0])
    for k, label in enumerate(bins):
        color = (BLUE, ORANGE, PURPLE)[label]
        ax.add_patch(Rectangle((k, -0.3), 1, 0.3, fc=color, ec="white"))
    for centre, style in ((4.5, "-"), (6.5, "--")):
        x = np.linspace(centre - 3, centre + 3, 60)
        ax.plot(x, 1 - ((x - centre) / 3) ** 2, style, color=TRUTH, lw=1.5)
    k = 8  # a pixel that only the moved kernel sees well
    ax.plot([k + 0.5] * 2, [0, 1 - (2 / 3) ** 2], color=BLUE, lw=2)
    ax.text(9.7, 0.55, "its weight grows,\nits bin stays", va="center")
    arrow(ax, (4.6, 1.12), (6.4, 1.12))
    ax.text(5.5, 1.22, "the kernel moves", **MIDDLE)
    ax.text(6, -0.45, "the pixels stay", **MIDDLE)
    ax.set(xlim=(0, 13.5), ylim=(-0.6, 1.32))
    ax.set_axis_off()


def eight() -> dict[str, Array]:
    """The two generations of `cycle`: places, weights and ancestors of eight particles.

    Returns
    -------
    dict
        before, predicted, weights : (8,) arrays; ancestors : (8,) int array; likelihood
        : callable of a place; truth, estimate, n_eff : float.
    """
    rng = np.random.default_rng(6)
    before = np.sort(rng.normal(30, 6, 8))
    truth = 42.0
    predicted = before + 10 + rng.normal(0, 4, 8)

    def likelihood(x):
        d2 = 0.75 * (1 - np.exp(-(((x - truth) / 10) ** 2)))
        return np.exp(log_likelihood(1 - np.atleast_1d(d2)[:, None], 10.0))

    weights = normalised(np.log(likelihood(predicted)))
    return {
        "before": before,
        "predicted": predicted,
        "weights": weights,
        "ancestors": SCHEMES["systematic"](weights, rng),
        "likelihood": likelihood,
        "truth": truth,
        "estimate": weights @ predicted,
        "n_eff": effective_sample_size(weights),
    }  # pyright: ignore[reportReturnType]


@drawing("05", 9, 3.6)
def cycle(fig: Figure) -> None:
    """One round of the particle filter: chapter 5.

    Eight coloured particles go through one round. Predict: each moves on by its
    velocity and a little chance. Weigh: each gets a stick as high as the likelihood at
    its place. Estimate: the weighted mean, near the truth. Draw: heavy particles are
    copied, in their colours, and light ones are gone.
    """
    made = eight()
    ax = canvas(fig, 70, 36)
    titles = ("1 predict", "2 weigh", "3 estimate", "4 draw")
    ax.plot([made["truth"]] * 2, [0, 33.5], color="0.8", lw=6, zorder=0)
    ax.text(made["truth"], 34.7, "the car is here", **MIDDLE)
    ax.text(0.5, 32, "before", va="center")
    for title, y in zip(titles, (28, 18, 10, 2.5), strict=True):
        ax.text(0.5, y, title, weight="bold", va="center")
        ax.plot([13, 69], [y - 1] * 2, color="0.6", lw=0.8, zorder=0)
    _draw_prediction(ax, made["before"], made["predicted"])
    x = np.linspace(14, 68, 200)
    ax.plot(x, 17 + 6.5 * made["likelihood"](x), color="0.6", lw=1)
    for place, weight, color in zip(
        made["predicted"], made["weights"], EIGHT, strict=True
    ):
        height = 6.5 * weight / made["weights"].max()
        ax.plot([place] * 2, [17, 17 + height], color=color, lw=4)
    ax.plot(made["estimate"], 10.2, "D", color=CURRENT, ms=9, mec=TRUTH)
    ax.text(made["estimate"] + 1.5, 10.3, "weighted mean", va="center")
    ax.text(69, 21, f"$N_{{eff}}$ = {made['n_eff']:.1f} of 8", ha="right")
    _draw_offspring(ax, made["predicted"], made["ancestors"])


def _draw_prediction(ax: Axes, before: Array, predicted: Array) -> None:
    style = {"ms": 8, "mec": TRUTH, "mew": 0.6}
    for start, end, color in zip(before, predicted, EIGHT, strict=True):
        ax.plot(start, 32, "o", color=color, **style)
        ax.plot(end, 27.7, "o", color=color, **style)
        arrow(ax, (start, 31.4), (end, 28.4), lw=0.7)


def _draw_offspring(ax: Axes, places: Array, ancestors: Array) -> None:
    """Copies stand on one another; a cross where a particle has none."""
    counts = np.bincount(ancestors, minlength=len(places))
    style = {"ms": 8, "mec": TRUTH, "mew": 0.6}
    for place, count, color in zip(places, counts, EIGHT, strict=True):
        if not count:
            ax.plot(place, 2.2, "x", color=color, ms=7, mew=2)
        for k in range(count):
            ax.plot(place, 2.2 + 1.9 * k, "o", color=color, **style)


@drawing("06", 9, 2.1)
def switch(fig: Figure) -> None:
    """Filter, switch, optimiser: chapter 6.

    A frame goes to a filter of 75 particles. Its mean and the distance there go to a
    switch. If the distance is at most epsilon the optimiser walks the last bit, and its
    end is the answer; otherwise the mean is. Nothing flows back to the filter.
    """
    ax = canvas(fig, 90, 21)
    boxes(ax, ["frame", "filter,\n75 particles"], [7, 23], 11)
    boxes(ax, ["optimiser"], [64], 16)
    boxes(ax, ["answer"], [83], 11)
    diamond = [(44, 15.5), (51, 11), (44, 6.5), (37, 11)]
    ax.add_patch(Polygon(diamond, fc="#fff4dc", ec=ORANGE))
    ax.text(44, 11, r"$d_m \leq \varepsilon$?", **MIDDLE)
    for start, end in (((10, 11), (16.2, 11)), ((29.6, 11), (37, 11))):
        arrow(ax, start, end)
    ax.text(33.5, 12.8, r"$\bar x$, $d_m$", **MIDDLE)
    ax.plot([44, 44], [15.5, 16], color=TRUTH, lw=1.2)
    arrow(ax, (44, 16), (58, 16))
    ax.text(50, 17.6, "yes: seen", color=TRACKERS["combined"], **MIDDLE)
    arrow(ax, (70, 16), (79.5, 12.6))
    ax.plot([44, 44, 75], [6.5, 4, 4], color=TRUTH, lw=1.2)
    arrow(ax, (75, 4), (80, 9))
    ax.text(59, 5.5, "no: hidden, or lost", color=DESIRED, **MIDDLE)
    ax.plot([23, 23, 7], [8.5, 1.5, 1.5], color="0.4", lw=1.2)
    arrow(ax, (7, 1.5), (7, 8.8), color="0.4")
    ax.text(15, 2.9, "next frame", color="0.3", **MIDDLE)


@drawing("09", 9, 2.6)
def self_motion(fig: Figure) -> None:
    """Measure, filter, add: chapter 9.

    Left, the loop: what the image did, minus what the camera did, is what the car
    did; a filter smooths it, and the law adds it to the gain times the error. Right,
    three bells: the prediction is broad, the measurement narrower, and their product,
    the corrected estimate, is narrower than both and nearer to the measurement.
    """
    ax = fig.add_axes((0, 0, 0.62, 1))
    ax.set(xlim=(0, 62), ylim=(0, 26))
    ax.set_axis_off()
    seen = "the image did\n$(e_k - e_{k-1}) / \\Delta t$"
    done = "the camera did\n$L\\,v_{k-1}$"
    boxes(ax, [seen, done], [12, 12], 20)
    ax.texts[1].set_y(5)
    ax.text(28, 12.5, "$-$", size=16, bbox=BOX | {"boxstyle": "circle"}, **MIDDLE)
    arrow(ax, (19, 17), (26, 13.8))
    arrow(ax, (19, 8), (26, 11.2))
    boxes(ax, ["filter\n$K$", "law"], [42, 56], 12.5)
    arrow(ax, (30.4, 12.5), (38.6, 12.5))
    ax.text(34.6, 14.7, "the car\ndid, $z_k$", ha="center", va="bottom")
    arrow(ax, (45.6, 12.5), (53.3, 12.5))
    ax.text(49.3, 14.4, r"$\widehat{\partial e}/\partial t$", **MIDDLE)
    ax.plot([56, 56, 12], [11.1, 1, 1], color=TRUTH, lw=1.2)
    arrow(ax, (12, 1), (12, 2.2))
    ax.text(38, 2.4, "$v_k$, until the next frame", **MIDDLE)
    _draw_bells(fig.add_axes((0.66, 0.2, 0.32, 0.66)))


def bells(
    prior: tuple[float, float], measured: tuple[float, float]
) -> tuple[float, float]:
    """Mean and variance of the product of two Gaussian densities: one Kalman step.

    With K = P / (P + R) the mean is m + K (z - m), the variance (1 - K) P.

    Parameters
    ----------
    prior : (m, P)
    measured : (z, R)
    """
    (m, P), (z, R) = prior, measured
    K = P / (P + R)
    return m + K * (z - m), (1 - K) * P


def _draw_bells(ax: Axes) -> None:
    prior, measured = (0.0, 4.0), (3.0, 2.0)
    shown = {
        "predicted, $P$": (prior, BLUE, "--"),
        "measured, $R$": (measured, PURPLE, "-"),
        "corrected": (bells(prior, measured), BLUE, "-"),
    }
    x = np.linspace(-6, 8, 200)
    for name, ((mean, variance), color, dashes) in shown.items():
        height = np.exp(-((x - mean) ** 2) / 2 / variance) / np.sqrt(variance)
        ax.plot(x, height, dashes, color=color, label=name, lw=2)
    ax.set(yticks=[], xticks=[], xlabel="velocity of the car", xlim=(-6, 8))
    ax.set_ylim(0, 1.35)
    ax.legend(loc="upper left", borderaxespad=0, labelspacing=0.2)


@drawing("10", 9, 3)
def moving_ellipse(fig: Figure) -> None:
    """An ellipse with velocities: chapter 10.

    One sample: an upright ellipse with its centre, its half axes and an arrow for
    its velocity. A moment later it is further on along the arrow, larger because the
    size grows too, and a little off because of the noise.
    """
    ax = canvas(fig, 90, 30)
    first = Ellipse((16, 12), 16, 22, fc="0.96", ec=PLAIN, lw=2)
    ax.add_patch(first)
    ax.plot(16, 12, "o", color=TRUTH, ms=5)
    ax.text(15, 13.6, "$(x, y)$", ha="right")
    for end, name, place in (
        ((24, 12), "$H_x$", (20.4, 10.2)),
        ((16, 1), "$H_y$", (17.8, 5.5)),
    ):
        ax.plot([16, end[0]], [12, end[1]], color=PLAIN, lw=1.5)
        ax.text(*place, name, **MIDDLE)
    arrow(ax, (16, 12), (36, 17), lw=2, color=MISSED)
    ax.text(24.8, 19.6, r"$(\dot x, \dot y)$", color=MISSED, **MIDDLE)
    ax.add_patch(Ellipse((36, 17), 17.2, 23.6, fill=False, ec="0.45", ls="--"))
    ax.text(41.5, 28.2, r"$A\,s$: moved, and grown by $\dot a$", va="center")
    ax.add_patch(Ellipse((38, 14.5), 18, 24.8, fill=False, ec=PLAIN, lw=2))
    ax.text(48.5, 14.5, "$A\\,s + w$: with chance;\nthe next sample", va="center")
    ax.text(73, 7, "seven numbers:", ha="center")
    seven = r"$s = (x, y, \dot x, \dot y, H_x, H_y, \dot a)$"
    ax.text(73, 4, seven, ha="center", va="center")


@drawing("11", 9, 2.6)
def two_modes(fig: Figure) -> None:
    """Two modes: chapter 11.

    A state diagram of two modes, in the colours of figure 6. Tracking stays while
    enough samples appear, and also for fewer than five frames in which too few do.
    After five frames on end it changes to initialising, which places samples anew in
    each frame and changes back in the first frame in which more than b N appear.
    """
    ax = canvas(fig, 90, 26)
    for x, name, what, color in (
        (23, "tracking", "select, propagate,\nweigh, estimate, learn", WITH),
        (67, "initialising", "place samples anew\nin the zones", MISSED),
    ):
        ax.add_patch(Ellipse((x, 13), 25, 15, fc="white", ec=color, lw=2.5))
        ax.text(x, 15.6, name, weight="bold", **MIDDLE)
        ax.text(x, 11.2, what, **MIDDLE)
    bow = {"connectionstyle": "arc3,rad=-0.28", "shrinkB": 0}
    arrow(ax, (32, 18.5), (58, 18.5), **bow)
    ax.text(45, 23.8, "fewer than $b\\,N$ appear in 5 frames on end", **MIDDLE)
    arrow(ax, (58, 7.5), (32, 7.5), **bow)
    ax.text(45, 2, "more than $b\\,N$ appear in one frame", **MIDDLE)
    ax.text(45, 13, "$b = .1$", **MIDDLE)
    _loop_back(ax, 5.5, "a short\nocclusion", -1)
    _loop_back(ax, 84.5, "nobody\nyet", 1)


def _loop_back(ax: Axes, x: float, words: str, side: int) -> None:
    """An arrow from a state back to itself, at its left (-1) or its right (1)."""
    edge = x - 5.2 * side
    bow = {"connectionstyle": f"arc3,rad={-1.6 * side}", "shrinkB": 0}
    arrow(ax, (edge, 16.2), (edge, 9.8), **bow)
    ax.text(x, 21, words, **MIDDLE)


CAR_LOOK = np.array([0.70, 0.20, 0.05, 0.05])
GROUND_LOOK = np.array([0.05, 0.15, 0.35, 0.45])


def creep(alpha: float, shares: Array) -> tuple[Array, Array]:
    """A model that learns while its estimate creeps off a car of four colours.

    Parameters
    ----------
    alpha : float
        Share of each frame in the model.
    shares : (T,) array
        How much of the ellipse the car fills.

    Returns
    -------
    score, car : (T,) arrays
        Coefficient of the model with what is under the ellipse, before it learns that,
        and with the car.
    """
    q, score, car = CAR_LOOK, [], []
    for share in shares:
        p = share * CAR_LOOK + (1 - share) * GROUND_LOOK
        score.append(coefficient(p, q))
        q = (1 - alpha) * q + alpha * p
        car.append(coefficient(CAR_LOOK, q))
    return np.array(score), np.array(car)


@drawing("12", 9, 2.7)
def drift(fig: Figure) -> None:
    """Drift, step by step: chapter 12.

    Six frames. An ellipse creeps off a car, a little further in each. Below each
    frame stand two bars: the score of the ellipse with the model, which stays high, and
    the likeness of the model to the car, which falls; the gate lets every step pass.
    """
    shares = np.linspace(1, 0, 6)
    score, car = creep(0.6, shares)
    upper = fig.add_axes((0.1, 0.5, 0.89, 0.48))
    upper.set(xlim=(-0.5, 5.6), ylim=(0, 1))
    upper.set_axis_off()
    for k, share in enumerate(shares):
        upper.add_patch(Rectangle((k - 0.32, 0.3), 0.4, 0.4, fc=BLUE, ec="none"))
        centre = k - 0.12 + 0.42 * (1 - share)
        shape = Ellipse((centre, 0.5), 0.42, 0.75, fill=False, ec=CURRENT, lw=2)
        upper.add_patch(shape)
        upper.text(k, 0.0, f"frame {k}", ha="center")
    lower = fig.add_axes((0.1, 0.13, 0.89, 0.33))
    k = np.arange(6)
    lower.bar(k - 0.15, score, 0.28, color=CURRENT, label="its own score")
    lower.bar(k + 0.15, car, 0.28, color=BLUE, label="the model's likeness to the car")
    lower.axhline(0.8, color=DESIRED, lw=1, ls="--")
    lower.text(5.47, 0.83, "gate", color=DESIRED, ha="right")
    lower.set(xlim=(-0.5, 5.6), ylim=(0, 1.05), xticks=[], ylabel=r"$\rho$")
    place = {"loc": "upper center", "bbox_to_anchor": (0.45, 0.02)}
    lower.legend(ncols=2, borderaxespad=0.1, **place)


@drawing("13", 9, 2.7)
def hybrid(fig: Figure) -> None:
    """Two ways to go on, and a search that widens: chapter 13.

    Three moments of a person and a wall. In view, half of the particles, the walkers,
    walk at random round the last place, and half, the runners, have gone on with the
    person. A frame after the person went behind the wall, all are spread evenly round
    the last place, the runners moved on, a bit less in every frame. Longer hidden, the
    spread is wider, and when the person comes out some particle is near.
    """
    axes = fig.subplots(1, 3, gridspec_kw={"left": 0.01, "right": 0.99, "wspace": 0.05})
    titles = "in view", "hidden for 2 frames", "hidden for 6 frames"
    rng = np.random.default_rng(2)
    speed, damping = 1.5, HybridResampling().damping
    for ax, title, frames in zip(axes, titles, (1, 2, 6), strict=True):
        hidden = frames > 1
        last = 8.0 if hidden else 8.0 - speed
        chance = rng.normal(0, 0.8, (40, 2))
        if hidden:
            chance = rng.uniform(-1, 1, (40, 2)) * (1.5 + 0.45 * frames)
        places = np.array([last, 5.0]) + chance
        places[20:, 0] += speed * np.sum(damping ** np.arange(frames))
        ax.add_patch(Rectangle((8.8, 0.2), 6.4, 9.6, fc="0.85", ec="none"))
        ax.plot(*places[:20].T, "o", ms=4.5, color=EIGHT[6], label="walkers")
        ax.plot(*places[20:].T, "^", ms=5, color=PURPLE, label="runners")
        cross = {"ls": "", "color": MISSED, "mew": 2, "label": "last estimate"}
        ax.plot(last, 5, "+", ms=13, **cross)
        person = last + speed * frames
        star = {"ls": "", "color": TRUTH, "label": "the person"}
        ax.plot(person, 5, "*", ms=16, **star)
        ax.set(xlim=(1, 23), ylim=(0, 10), title=title)
        ax.set_axis_off()
    axes[0].text(12, 9, "wall", **MIDDLE)
    named = axes[0].get_legend_handles_labels()
    fig.legend(*named, loc="lower center", ncols=4, handletextpad=0.2, borderaxespad=0)


@drawing("14", 9, 2.4)
def two_boxes(fig: Figure) -> None:
    """Two boxes and their overlap: chapter 14.

    Three pairs of boxes, the truth in black and the answer in green. What both share
    is shaded; over the area that either covers it is the overlap: high for a small
    shift, one quarter for an answer of twice the width and height, and zero for two
    boxes with a gap between them.
    """
    pairs = {
        "a small shift": ([0, 0, 4, 3], [0.6, 0.4, 4, 3]),
        "twice too large": ([2, 1.5, 4, 3], [0, 0, 8, 6]),
        "a gap": ([0, 1, 4, 3], [5, 1, 4, 3]),
    }
    axes = fig.subplots(1, 3, gridspec_kw={"left": 0.02, "right": 0.98, "top": 0.84})
    for ax, (name, (truth, answer)) in zip(axes, pairs.items(), strict=True):
        shared = overlap(from_box(truth), from_box(answer))
        sides = [(max(a, b), min(a + w, b + v)) for a, w, b, v in _sides(truth, answer)]
        (left, right), (top, bottom) = sides
        if right > left and bottom > top:
            size = right - left, bottom - top
            ax.add_patch(Rectangle((left, top), *size, fc="#d6f0db", ec="none"))
        for (x, y, width, height), color in ((truth, TRUTH), (answer, CURRENT)):
            box = Rectangle((x, y), width, height, fill=False, ec=color, lw=2)
            ax.add_patch(box)
        ax.set_title(f"{name}: $A$ = {shared:.2f}")
        ax.set(xlim=(-0.5, 9.5), ylim=(6.4, -0.4), aspect="equal")
        ax.set_axis_off()


def _sides(a: Sequence[float], b: Sequence[float]) -> list[tuple[float, ...]]:
    """Starts and lengths of two boxes along x, and along y."""
    return [(a[k], a[k + 2], b[k], b[k + 2]) for k in (0, 1)]
