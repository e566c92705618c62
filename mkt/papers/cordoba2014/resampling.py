"""Section 4.5 of [C14]: what resampling costs."""

from collections.abc import Sequence
from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter

from mkt.experiments.timing import exponent, side_by_side
from mkt.figures.registry import Shown, figure, shown
from mkt.particles import systematic_positions
from mkt.plotting import CURRENT
from mkt.types import Array, NDArray

# How the search can be read: whether it begins anew for each draw.
READINGS = {
    "search begun anew for each draw (4.5.2)": True,
    "one sweep (Algorithm 1)": False,
}
STYLES = {True: ("o", "#737373"), False: ("s", CURRENT)}  # no filter's colours
COLUMNS = ("comparisons", "time [ms]")
SIZES = 7  # numbers of particles on each line


def ancestors(cumulative: Array, u: Array, anew: bool) -> tuple[NDArray, int]:
    """Resampling: for each place in u the first particle whose share reaches it.

    Parameters
    ----------
    cumulative : (N,) array
        Rising cumulative weights.
    u : (N,) array
        Rising places in their range.
    anew : bool
        Begin each search at the first particle, as Section 4.5.2 counts; else where the
        last one stopped, as Algorithm 1 lists, which never sets i back.

    Returns
    -------
    ancestors : (N,) int array
    comparisons : int
        At most 2 N - 1 where i is never set back.
    """
    chosen: list[int] = []
    comparisons = 0
    i = 0
    for place in u:
        i = 0 if anew else i
        comparisons += 1
        while place > cumulative[i]:
            i += 1
            comparisons += 1
        chosen.append(i)
    return np.array(chosen), comparisons


def _draw(n: int, seed: int) -> tuple[Array, Array]:
    """Cumulative weights (N,) of particles of random weight, and places in them."""
    rng = np.random.default_rng((seed, n))
    cumulative = np.cumsum(rng.exponential(size=n))
    return cumulative, systematic_positions(n, rng) * cumulative[-1]


def counted(anew: bool, n: int, seed: int = 0) -> int:
    """How many comparisons the searches need for n particles of random weight."""
    return ancestors(*_draw(n, seed), anew)[1]


def timed(anew: bool, sizes: Sequence[int], seed: int = 0) -> list[float]:
    """How long the same searches take [ms] for numbers of particles, best of three."""
    works = {n: partial(ancestors, *_draw(n, seed), anew) for n in sizes}
    return [float(times.min()) for times in side_by_side(works, repeats=3).values()]


def spans(chosen: NDArray, anew: bool) -> NDArray:
    """The particles that each draw is compared with, first and last: (N, 2).

    Parameters
    ----------
    chosen : (N,) int array
        The ancestors.
    anew : bool
        As for `ancestors`.
    """
    before = np.r_[0, chosen[:-1]]
    return np.column_stack([np.zeros_like(chosen) if anew else before, chosen])


@figure(
    "cordoba2014.complexity",
    size=(10, 3.9),
    live=("cordoba2014.complexity",),
    particles=(4, 40, 1),
    largest=[400, 800, 1600],
    seed=(0, 20, 1),
)
def complexity(
    fig: Figure, *, particles: int = 12, largest: int = 1600, seed: int = 0
) -> Shown:
    """Section 4.5: what resampling costs, counted and timed.

    Two readings of the search through the cumulative weights, for particles of random
    weight.  At the left a row for each draw, as long as there are particles that it is
    compared with; then comparisons and time for larger numbers of particles, where the
    exponents are slopes of straight lines through the logarithms.  Times are of plain
    Python loops on the machine that drew this, the best of three.

    In the page: Two readings of the search through the cumulative weights, for
    particles of random weight.  First a row for each draw, as long as there are
    particles that it is compared with; then the comparisons for larger numbers of
    particles, where the exponents are slopes of straight lines through the logarithms.
    Times are of this browser.  The page draws weights and darts of its own: for the
    same seed its counts are not quite those of Python.

    The paper counts N searches of up to N steps each and concludes O(N^2).  But its
    Algorithm 1 never sets i back to the start, so that all searches together take at
    most 2 N steps.
    """
    n = np.unique(np.geomspace(25, largest, SIZES).round().astype(int))
    costs = {label: _costs(anew, n, seed) for label, anew in READINGS.items()}
    fig.subplots_adjust(left=0.06, right=0.99, bottom=0.14, top=0.83, wspace=0.28)
    few, *many = fig.subplots(1, 3)
    rows = _draw_spans(few, particles, seed)
    fig.legend(handles=few.containers, loc="upper center", ncols=2)
    for ax, column in zip(many, COLUMNS, strict=True):
        _draw_costs(ax, costs, column)
    anew, sweep = (_exponents(cost) for cost in costs.values())
    table = pd.concat(costs, names=["reading"]).reset_index("reading")
    return shown(table, n=n, anew=anew, sweep=sweep, rows=rows)


def _draw_spans(ax: Axes, n: int, seed: int) -> dict[str, int]:
    """The comparisons of few particles; returns how many there are for each reading."""
    chosen, _ = ancestors(*_draw(n, seed), anew=False)
    counts = {}
    for (label, anew), side in zip(READINGS.items(), (-0.2, 0.2), strict=True):
        first, last = spans(chosen, anew).T
        long = last - first + 1
        style = {"color": STYLES[anew][1], "height": 0.4, "label": label}
        ax.barh(np.arange(n) + side, long, left=first - 0.5, **style)
        counts[label] = int(long.sum())
    ax.set(xlim=(-0.5, n - 0.5), ylim=(n - 0.5, -0.5), xlabel="particle i")
    ax.set(
        ylabel="draw", title=" and ".join(map(str, counts.values())) + " comparisons"
    )
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(6, integer=True))
    return counts


def _costs(anew: bool, n: NDArray, seed: int) -> pd.DataFrame:
    """Comparisons and time for numbers of particles (S,)."""
    sizes = n.tolist()
    comparisons = [counted(anew, size, seed) for size in sizes]
    columns = {"comparisons": comparisons, "time [ms]": timed(anew, sizes, seed)}
    return pd.DataFrame({"particles": n} | columns)


def _exponents(costs: pd.DataFrame) -> dict[str, float]:
    """The exponent of the comparisons, and that of the time."""
    steps, time = (exponent(costs["particles"], costs[name]) for name in COLUMNS)
    return {"exponent": steps, "timed": time}


def _draw_costs(ax: Axes, costs: dict[str, pd.DataFrame], column: str) -> None:
    """A column of the costs of each reading against the number of particles."""
    for label, cost in costs.items():
        marker, color = STYLES[READINGS[label]]
        text = f"exponent {exponent(cost['particles'], cost[column]):.2f}"
        line = cost["particles"], cost[column], f"{marker}-"
        ax.loglog(*line, color=color, label=text)
    ax.set(xlabel="number of particles N", ylabel=column)
    ax.xaxis.set_minor_formatter(NullFormatter())  # of few decades they overlap
    ax.legend(loc="upper left")
