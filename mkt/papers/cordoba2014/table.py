"""Table 1 of [C14] beside ours."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from tqdm import tqdm

from mkt.evaluation import overlaps, true_positives
from mkt.figures.registry import Shown, figure, grid_columns, shown
from mkt.papers.cordoba2014.looks import RIVALS as OURS
from mkt.papers.cordoba2014.printed import (
    COLORS,
    NAMES,
    OVERALL,
    TABLE,
    said,
    share_seen,
    source,
)
from mkt.papers.cordoba2014.tracking import repeated
from mkt.papers.runs import clip
from mkt.tracking import Source, Tracker
from mkt.types import Array

CENTRED: dict[str, Any] = {"ha": "center", "va": "center"}


@figure("cordoba2014.table1", size=(10, 4.8), t_lim=(0.0, 0.8, 0.2))
def table1(fig: Figure, *, t_lim: float = 0.2, runs: int = 3) -> Shown:
    """The share of true positives, printed and ours.

    On the synthetic twins of one object, or on the BoBoT sequences whose lengths most
    of the printed fractions fit where MKT_DATA has them; under its name each row says
    which. Percent of all frames, hidden ones too, whose overlap exceeds T_lim: mean and
    standard deviation over so many runs with other random numbers; WM has none.  "Seen"
    is the share of frames in which the target can be seen, more than which nobody
    reaches.  PFHR and SIR have the same bins and kernel, once those of the paper's text
    and once ours, so that a pair differs in hybrid resampling alone: when it draws,
    inertia, the search while the target is hidden, the model update.  Bold: the best of
    ours in a row.  The printed numbers were measured on BoBoT at 20 %, and other data
    need not give the same ones.  In our copy of the paper the third row repeats the
    first, and the overall mean of PFHR does not follow from its column, whose mean is
    94.31.  BoBoT's sequence D, which the third row may mean, fits none of its three
    fractions.
    """
    names = list(OURS)
    rows = [_row(kind, t_lim, runs) for kind in tqdm(TABLE, disable=None)]
    means, spread = np.moveaxis(np.array(rows), -1, 0)
    seen = np.array([100 * share_seen(source(kind)) for kind in TABLE])
    ax = fig.add_axes((0, 0, 1, 1))
    _draw_table(
        ax, names, means, spread, seen, f"ours at {100 * t_lim:.0f} %, {runs} runs"
    )
    table = _as_table(names, means, spread)
    overall = means.mean(0)
    facts = {"means": means, "spread": spread, "names": names, "overall": overall}
    return shown(table, seen=seen, **facts)


def _row(kind: str, t_lim: float, runs: int) -> Array:
    """Mean and standard deviation of the trackers on a kind of sequence, (5, 2) [%]."""
    shares = [percent(one, source(kind), t_lim, runs) for one in OURS.values()]
    return np.array([(np.mean(share), np.std(share)) for share in shares])


def percent(tracker: Tracker, origin: Source, t_lim: float, n: int) -> Array:
    """True positives in n runs, (n,) [%] of all frames."""
    return 100 * true_positives(_overlaps(tracker, origin, n), t_lim, hidden=True)


@lru_cache(maxsize=64)
def _overlaps(tracker: Tracker, origin: Source, n: int) -> Array:
    """The same for every T_lim, (n, T)."""
    return overlaps(repeated(tracker, origin, n), clip(origin))


def _as_table(names: Sequence[str], means: Array, spread: Array) -> pd.DataFrame:
    """A row for each cell of the drawn table, with what is printed there."""
    numbers = {"mean [%]": means, "standard deviation [%]": spread}
    rows = {"row": [row.title for row in TABLE.values()]}
    table = grid_columns(rows, {"tracker": names}, **numbers)
    data = [said(source(kind)) for kind in TABLE]
    printed = [dict(zip(NAMES, row.percent, strict=True)) for row in TABLE.values()]
    table.insert(1, "data", np.repeat(data, len(names)))
    table["printed [%]"] = [
        row.get(name.partition(" ")[0], np.nan) for row in printed for name in names
    ]
    return table


class _Columns(NamedTuple):
    """Where the columns stand: seen, the printed ones, and ours by tracker's name."""

    seen: float
    printed: tuple[float, ...]
    ours: dict[str, float]


COLUMNS = _Columns(
    0.225,
    (0.28, 0.345, 0.41),
    dict(zip(OURS, (0.53, 0.64, 0.75, 0.86, 0.95), strict=True)),
)


def _draw_table(
    ax: Axes,
    names: Sequence[str],
    means: Array,
    spread: Array,
    seen: Array,
    title: str,
) -> None:
    """The printed table and ours: (6, K) means and deviations of K trackers."""
    ax.set(xlim=(0, 1), ylim=(7.1, -1.4))
    ax.set_axis_off()
    columns = COLUMNS
    _draw_head(ax, columns, title)
    for y, (kind, row) in enumerate(TABLE.items()):
        words = {"va": "center", "fontsize": 9, "color": "0.35"}
        ax.text(0.01, y + 0.75, said(source(kind)), **words)
        texts = [_cell(*one) for one in zip(names, means[y], spread[y], strict=True)]
        best = means[y] == means[y].max()
        _draw_line(ax, y + 0.35, columns, (row.title, *row.printed), texts, best)
        ax.text(columns.seen, y + 0.35, f"{seen[y]:.1f}", color="0.35", **CENTRED)
    overall = means.mean(0)
    texts = [_cell(*one) for one in zip(names, overall, overall * np.nan, strict=True)]
    best = overall == overall.max()
    _draw_line(ax, 6.5, columns, ("Overall average", *OVERALL), texts, best)


def _cell(name: str, mean: float, spread: float) -> str:
    """What a cell of ours says; without a spread for WM and for a mean of rows."""
    if name == "wm" or np.isnan(spread):
        return f"{mean:.1f}"
    return f"{mean:.1f} ± {spread:.1f}"


def _draw_head(ax: Axes, columns: _Columns, title: str) -> None:
    ours = [columns.ours[name] for name in OURS]
    heads = [
        (columns.printed, -0.9, "printed (BoBoT, 20 %)"),
        (ours, -1.15, title),
        (ours[:2], -0.75, "the paper's look"),
        (ours[2:4], -0.75, "our look"),
    ]
    for places, y, text in heads:
        ax.text(float(np.mean(places)), y, text, **CENTRED)
    ax.text(columns.seen, -0.35, "seen", color="0.35", **CENTRED)
    named = [*zip(columns.printed, NAMES, strict=True)]
    named += [(columns.ours[name], name.partition(" ")[0]) for name in OURS]
    for x, name in named:
        ax.text(x, -0.35, NAMES[name], fontweight="bold", **CENTRED)
        ax.plot([x - 0.018, x + 0.018], [-0.08] * 2, color=COLORS[name], lw=2.5)
    for y in (0, 6):
        ax.axhline(y, color="0.3", lw=1)


def _draw_line(
    ax: Axes,
    y: float,
    columns: _Columns,
    printed: Sequence[str],
    ours: Sequence[str],
    best: Array,
) -> None:
    """A line: its title and numbers as printed, then ours, the best of them bold."""
    title, *numbers = printed
    ax.text(0.01, y, title, va="center")
    for x, text in zip(columns.printed, numbers, strict=True):
        ax.text(x, y, text, color="0.35", **CENTRED)
    for x, text, bold in zip(columns.ours.values(), ours, best, strict=True):
        weight = "bold" if bold else "normal"
        ax.text(x, y, text, fontweight=weight, **CENTRED)
