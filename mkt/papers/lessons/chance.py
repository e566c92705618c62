"""What the kick-off fraction of [N03] is set against: samples that appear by chance.

Explained in notebook 11.
"""

import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.figures.registry import Shown, figure, shown
from mkt.plotting import CONTRAST, DASHES, DESIRED
from mkt.types import Array, ArrayLike

WAIT = 100  # frames
HIGHEST = 0.6  # share that is drawn: at b's largest, false starts lie beyond b
LEAST = 1e-6  # probability that is drawn
MARGIN = 0.02  # beside the bars
COMPARED = 2.3, 5.0, 10.0  # [%] of the background; the first is beyond two spreads


def false_start(n: int, epsilon: ArrayLike, b: ArrayLike) -> Array:
    """The probability that more than b N of N samples appear by chance, in one frame.

    Parameters
    ----------
    n : int
        N, how many samples wait.
    epsilon : array_like
        The share of the background that appears, by which each does.
    b : array_like
        Kick-off fraction, of one shape with `epsilon` or to be broadcast.

    Returns
    -------
    array
        The upper tail of a binomial distribution.
    """
    return scipy.stats.binom.sf(_most(b, n), n, epsilon)


def _most(b: ArrayLike, n: int) -> Array:
    """The largest number of n samples that starts nothing.

    A product such as .29 x 100 is rounded to less than 29.
    """
    return np.floor(np.multiply(b, n) + 1e-9)


@figure(
    "own.chance",
    size=(10, 3.8),
    live=("own.chance",),
    epsilon=(0.5, 20, 0.5),
    particles=(25, 400, 25),
    b=(0.02, 0.4, 0.02),
)
def chance(
    fig: Figure, *, epsilon: float = 5.0, particles: int = 100, b: float = 0.1
) -> Shown:
    """What chance does to the count: false starts on the background.

    Each of the samples that wait appears by chance with the probability epsilon.
    First, how many of them do so in a frame, the part above b N (red) being a false
    start; then, whether it comes to none in a hundred frames, for every kick-off
    fraction, with thin lines for 2.3, 5 and 10 % of the background.  The dashed line is
    b, the dotted one what one zone of three can hold.
    """
    if not 0 <= epsilon <= 100:
        raise ValueError(f"epsilon is {epsilon}, a share in %; give 0 to 100")
    share = epsilon / 100
    counts = np.arange(round(HIGHEST * particles) + 1)
    probability = scipy.stats.binom.pmf(counts, particles, share)
    false = float(false_start(particles, share, b))
    limits = counts / particles
    each = false_start(particles, share, limits)

    fig.subplots_adjust(left=0.075, right=0.985, bottom=0.15, top=0.9, wspace=0.22)
    left, right = fig.subplots(1, 2)
    above = counts > _most(b, particles)
    for part, color in ((~above, CONTRAST[0]), (above, DESIRED)):
        left.bar(limits[part], probability[part], 0.9 / particles, color=color)
    left.set(yscale="log", ylim=(LEAST, 1), xlabel="share of the samples that appear")
    left.set(ylabel="probability", title=f"a false start: {false:.2g} per frame")
    for other, dashes in zip(COMPARED, DASHES, strict=False):
        if other == epsilon:
            continue
        none = (1 - false_start(particles, other / 100, limits)) ** WAIT
        style = {"color": "0.45", "lw": 1, "ls": dashes, "zorder": 1}
        right.step(limits, none, where="post", label=f"{other:g} %", **style)
    waited = (1 - each) ** WAIT
    style = {"color": CONTRAST[0], "lw": 2.5, "label": f"{epsilon:g} %"}
    right.step(limits, waited, where="post", **style)
    right.legend(loc="lower right")
    none = (1 - false) ** WAIT
    right.set(xlabel="kick-off fraction b", ylabel=f"none in {WAIT} frames")
    right.set(ylim=(-0.02, 1.02), title=f"none in {WAIT} frames: {100 * none:.1f} %")
    for ax in (left, right):
        _draw_limits(ax, b)
    table = {"count": counts, "probability": probability, "false start": each}
    return shown(table, false=false, none=none)


def _draw_limits(ax: Axes, b: float) -> None:
    ax.axvline(b, color="black", lw=1.5, ls="--")
    ax.axvline(1 / 3, color="black", lw=1, ls=":")
    ax.set(xlim=(-MARGIN, HIGHEST + MARGIN))
