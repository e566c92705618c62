"""Teaching figures of the chapter on benchmarks.

What a ranking depends on, and the arithmetic of a printed table.
"""

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.checks import check_known, is_whole
from mkt.evaluation import HIT, LIMITS, overlaps, success, true_positives
from mkt.figures.registry import Shown, figure, grid_columns, shown
from mkt.papers import runs
from mkt.papers.cordoba2014.printed import COLORS as DASHED
from mkt.papers.cordoba2014.printed import NAMES, OVERALL, TABLE
from mkt.papers.nummiaro2003.sequences import WITH
from mkt.plotting import CONTRAST, DASHES, TRUTH
from mkt.plotting import TRACKERS as COLORS
from mkt.scenes.drawn import Drawn
from mkt.trackers.by_name import LABELS, TRACKERS, quick
from mkt.types import Array, NDArray

# Colours and dashes: full lines for [T09]'s trackers and ours, dashed ones for those of
# [C14], dashes and dots for that of [N03], all in their colours of other plots; others
# have none of their own.
OWN = {name: (color, "-") for name, color in COLORS.items()}
OWN |= {"guided": (TRUTH, "-")}
OWN |= {name: (color, "--") for name, color in DASHED.items()}
OWN |= {"adaptive": (WITH, "-.")}
OTHERS = [(color, dash) for dash in DASHES[2:] for color in CONTRAST]
SCENES = ("look-alike", "occlusion")
# Rows of truth in BoBoT; the first is where a tracker starts.
LENGTHS = {"A": 602, "B": 629, "C": 404, "D": 947}
LENGTHS |= {"E": 305, "F": 453, "G": 716, "I": 1017}
FRAMES = np.arange(200, 1101)
ROUNDINGS = ("truncated", "rounded")
POSSIBLE, IMPOSSIBLE = "#d62728", "0.7"  # numbers of frames
WRONG = "#d62728"
BOBOT = "#0072b2"


@figure(
    "own.success",
    size=(10, 5),
    live=("own.success",),
    limit=(0.05, 0.95, 0.05),
    scene=list(SCENES),
    seed=[0, 1],
)
def success_curves(
    fig: Figure, *, limit: float = HIT, scene: str = "occlusion", seed: int = 0
) -> Shown:
    """Success curves, and the ranking at one limit.

    First, the share of frames whose overlap exceeds T_lim, against T_lim.  Then the
    same share at the limit of the slider (dashed), in the same colours and beside the
    same line: plain out of the frames in which the target is seen, hatched out of all
    frames, as the fractions of [C14] suggest; last the area under the curve, as in OTB.
    Synthetic data: one sequence, one run of each tracker of the library but MIL, which
    would take longer than all the others together.
    """
    names = quick()
    iou = overlaps_on(Drawn(scene, seed), names)
    curves = success(iou)
    seen = true_positives(iou, limit)
    every = true_positives(iou, limit, hidden=True)

    fig.subplots_adjust(left=0.055, right=0.95, bottom=0.11, top=0.92, wspace=0.9)
    left, right = fig.subplots(1, 2)
    _draw_curves(left, names, curves)
    left.axvline(limit, color="0.4", ls="--", lw=1)
    _draw_ranking(right, names, seen, every, curves.mean(1))
    right.set_title(f"ranking at $T_{{lim}}$ = {limit:g}")
    table = grid_columns(
        {"tracker": names}, {"T_lim": LIMITS}, **{"share of the seen frames": curves}
    )
    numbers = {"area": curves.mean(1), "seen": seen, "all": every}
    return shown(table, names=names, curves=curves, **numbers)


def overlaps_on(source: Drawn, names: Sequence[str]) -> Array:
    """The overlaps (K, T) of one run of each tracker, see `mkt.evaluation.overlaps`."""
    trackers = [TRACKERS[name] for name in names]
    regions = runs.regions(trackers, source, (source.seed,))[:, 0]
    return overlaps(regions, runs.clip(source))


def _draw_curves(ax: Axes, names: Sequence[str], curves: Array) -> None:
    """The success curves (K, L) of the trackers."""
    for name, style, curve in zip(names, styles(names), curves, strict=True):
        ax.plot(LIMITS, curve, lw=2, label=LABELS[name], **style)
    ax.set(xlim=(0, 1), xlabel="$T_{lim}$")
    ax.set(ylim=(0, 1.02), ylabel="share of the seen frames")


def _draw_ranking(
    ax: Axes, names: Sequence[str], seen: Array, every: Array, area: Array
) -> None:
    """Trackers from the best to the worst at one limit, with three numbers (K,) each.

    Shares of the seen and of all frames are bars, the areas under the curves are text;
    of equal shares the larger area comes first.
    """
    order: list[int] = np.lexsort((-area, -seen))[::-1].tolist()  # bars begin below
    places = range(len(names))
    lines = styles(names)
    ax.barh(places, 100 * seen[order], color=[lines[k]["color"] for k in order])
    hatched: dict[str, Any] = {"color": "none", "edgecolor": "white", "hatch": "////"}
    ax.barh(places, 100 * every[order], lw=0, **hatched)
    ax.set_yticks(places, [LABELS[names[k]] for k in order], fontsize=8)
    ax.tick_params("y", length=0, pad=34)
    beside: dict[str, Any] = {"transform": ax.get_yaxis_transform(), "clip_on": False}
    for y, k in enumerate(order):
        ax.plot([-0.12, -0.015], [y, y], lw=2, **beside, **lines[k])
        ax.text(104, y, f"{area[k]:.2f}", va="center", fontsize=9)
    top = len(names) - 0.4
    ax.text(104, top, "area", fontsize=9, weight="bold")
    ax.set(xlim=(0, 100), ylim=(-0.6, top), xlabel="true positives [%]")


def styles(names: Sequence[str]) -> list[dict[str, Any]]:
    """Colour and dashes of each tracker's line, arguments of ``Axes.plot``."""
    others = iter(OTHERS)
    pairs = [OWN[name] if name in OWN else next(others) for name in names]
    return [{"color": color, "ls": dashes} for color, dashes in pairs]


def counts(percent: str, n: int, rounding: str = "truncated") -> list[int]:
    """The whole numbers k for which k of n frames is printed as this percentage.

    Only integers are used, because floats would be off by one.

    Parameters
    ----------
    percent : str
        With two decimals, such as "97.60".
    n : int
    rounding : {"truncated", "rounded"}
        The latter half up.

    Raises
    ------
    ValueError
        For a percentage with other decimals or as a number, no frame, and for another
        rounding.
    """
    check_known("rounding", rounding, ROUNDINGS)
    if not (isinstance(percent, str) and re.fullmatch(r"\d+\.\d\d", percent)):
        raise ValueError(
            f'percent is {percent!r}; give two decimals in a text, such as "97.60"'
        )
    if not is_whole(n, 1):
        raise ValueError(f"n is {n!r}; it must be a whole number, at least 1")
    hundredths = int(percent.replace(".", ""))
    first = (2 * hundredths - 1) * n // 20000  # half a hundredth less, for "rounded"
    last = (hundredths + 1) * n // 10000
    candidates = range(max(first, 0), min(last, n) + 1)
    return [k for k in candidates if _hundredths(k, n, rounding) == hundredths]


def _hundredths(k: int, n: int, rounding: str) -> int:
    """A share of k out of n in hundredths of a per cent, a whole number."""
    if rounding == "truncated":
        return 10000 * k // n
    return (20000 * k + n) // (2 * n)


def hits(row: str, rounding: str = "truncated") -> NDArray:
    """How many of a row's three percentages each of `FRAMES` allows, (S,) int.

    Parameters
    ----------
    row : str
        A key of `mkt.papers.cordoba2014.printed.TABLE`.
    rounding : {"truncated", "rounded"}
    """
    possible = [_possible(row, n, rounding) for n in FRAMES.tolist()]
    return np.sum(possible, axis=1)


def _possible(row: str, n: int, rounding: str) -> list[bool]:
    """Whether each percentage of a row is one of n frames."""
    return [bool(counts(percent, n, rounding)) for percent in TABLE[row].printed]


@figure(
    "own.table_forensics",
    size=(10, 6.6),
    row=list(TABLE),
    rounding=list(ROUNDINGS),
)
def table_forensics(
    fig: Figure, *, row: str = "clutter", rounding: str = "truncated"
) -> Shown:
    """What the numbers of a printed table give away.

    A percentage of true positives is a whole number out of n.  Above, for one row of
    Table 1 of [C14], how many of its three percentages can be written as k / n with two
    decimals: at the n in red, all of them can.  Marked below are sequences of BoBoT, by
    the number of their rows of truth less the first.  Then the whole table: each cell
    with its k for the n at the right, red where there is none, and the means of the
    columns against the printed ones.  All numbers are those that our copy of the paper
    reads; nothing was run for this figure.  Which sequence belongs to which row is
    inferred.
    """
    found = hits(row, rounding)
    upper = fig.add_axes((0.07, 0.63, 0.905, 0.3))
    _draw_hits(upper, found)
    printed = ", ".join(f"{percent} %" for percent in TABLE[row].printed)
    upper.set_title(f"{TABLE[row].title}: {printed}, {rounding}")
    means = np.mean([line.percent for line in TABLE.values()], 0)
    _draw_table(fig.add_axes((0.07, 0.01, 0.915, 0.5)), rounding, means)
    possible = {
        name: _possible(name, line.frames, rounding) for name, line in TABLE.items()
    }
    table = {"number of frames": FRAMES, "possible of 3": found}
    all_three = FRAMES[found == 3].tolist()
    return shown(table, n=all_three, hits=found, possible=possible, means=means)


def _draw_hits(ax: Axes, found: NDArray) -> None:
    """How many percentages are possible for each of FRAMES, and BoBoT's lengths."""
    all_three = found == 3
    colors = np.where(all_three, POSSIBLE, IMPOSSIBLE).tolist()
    ax.vlines(FRAMES, 0, found, color=colors, lw=np.where(all_three, 2, 1).tolist())
    for n in FRAMES[all_three].tolist():
        ax.text(n, 3.08, str(n), ha="center", color=POSSIBLE)
    style: dict[str, Any] = {"color": BOBOT, "clip_on": False}
    for name, length in LENGTHS.items():
        ax.plot(length - 1, -0.17, "^", ms=7, **style)
        ax.text(length + 6, -0.17, name, va="center", weight="bold", **style)
    ax.set(xlim=(200, 1100), xlabel="number of frames n")
    ax.set(ylim=(-0.4, 3.5), yticks=range(4), ylabel="possible of 3")


def _draw_table(ax: Axes, rounding: str, means: Array) -> None:
    """The printed table with its counts, and its last line against means (3,)."""
    ax.set_axis_off()
    ax.set(xlim=(0, 1), ylim=(8.3, -0.6))
    columns = (0.31, 0.53, 0.75)
    heads = ("Table 1 of [C14]", *NAMES.values(), "n")
    for x, text in zip((0.0, *columns, 0.93), heads, strict=True):
        ax.text(x, 0, text, weight="bold")
    for y, (name, row) in enumerate(TABLE.items(), 1):
        again = " (row 1 again)" if name == "background" else ""
        ax.text(0, y, row.title + again)
        ax.text(0.93, y, str(row.frames))
        for x, percent in zip(columns, row.printed, strict=True):
            k = counts(percent, row.frames, rounding)
            number = f"k = {k[0]}" if k else "no such k"
            _write(ax, x, y, f"{percent}   {number}", right=bool(k))
    ax.text(0, 7, "overall, as printed", style="italic")
    ax.text(0, 8, "mean of the column", style="italic")
    for x, printed, mean in zip(columns, OVERALL, means.tolist(), strict=True):
        ax.text(x, 7, printed)
        _write(ax, x, 8, f"{mean:.3f}", right=abs(mean - float(printed)) < 0.01)
    ax.axhline(0.35, color="0.6", lw=0.8)
    ax.axhline(6.4, color="0.6", lw=0.8)


def _write(ax: Axes, x: float, y: float, text: str, right: bool) -> None:
    """A cell, in red where it is wrong."""
    ax.text(x, y, text, color="black" if right else WRONG)
