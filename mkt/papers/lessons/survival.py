"""Who survives what: every tracker on every kind of drawn scene, from the release."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.experiments import shipped
from mkt.experiments.statistics import FRACTION, SHARE, Statistic, interval, refused
from mkt.figures.registry import Shown, figure, shown
from mkt.scenes import SCENES
from mkt.trackers.by_name import LABELS, TRACKERS
from mkt.types import Array

# What is counted of a run: the column, whether it is turned round, and the statistic.
COUNTED: dict[str, tuple[str, bool, Statistic]] = {
    "runs that end on the target": ("lost", True, SHARE),
    "overlap": ("overlap", False, FRACTION),
    "frames with a hit": ("hits", False, FRACTION),
}
DARK = 55  # [%]: from here on the letters are dark
# Questions of [T09] and ours first, then the twins of [C14].
ORDER = (
    "base",
    "look-alike",
    "illumination",
    "blur",
    "fast",
    "hidden",
    "occlusion",
    "clutter",
    "background",
    "scale",
    "trajectory",
    "passers",
    "pillars",
)


@figure("own.survival", size=(10, 6.4), counted=list(COUNTED))
def survival(fig: Figure, *, counted: str = "runs that end on the target") -> Shown:
    """Who survives what: all trackers on all kinds of drawn scene.

    In each cell a percentage over 32 scenes and its 95 % interval; more is better.  A
    run ends on the target when one of its last ten frames is a hit, that is an overlap
    above .2.  The scenes are those of the claims, on which nothing was tuned; they were
    run once for the release, and the table comes with the library.  A tracker that
    would not start on a scene scores nothing there.
    """
    column, turned, statistic = COUNTED[counted]
    rows, made = shipped.read_runs(shipped.TRACKED)
    values = rows[column].where(~refused(rows), float(turned))
    scored = rows.assign(value=1 - values if turned else values)
    names = [name for name in TRACKERS if (rows["tracker"] == name).any()]
    cells = [
        {"tracker": name, "scene": kind} | _cell(scored, name, kind, statistic)
        for name in names
        for kind in ORDER
    ]
    table = pd.DataFrame(cells)
    ax = fig.add_axes((0.27, 0.02, 0.69, 0.8))
    numbers = (table[name].to_numpy() for name in ("value [%]", "low [%]", "high [%]"))
    _draw(ax, names, *(each.reshape(len(names), len(ORDER)) for each in numbers))
    ax.set_title(f"{counted} [%], {len(shipped.seeds_of(made))} scenes each", pad=62)
    return shown(table, scenes=len(SCENES), seeds=made.seeds)


def _cell(
    rows: pd.DataFrame, name: str, kind: str, statistic: Statistic
) -> dict[str, float]:
    """The number of a tracker on a kind of scene, with the ends of its interval."""
    values = rows.loc[(rows["tracker"] == name) & (rows["source"] == kind), "value"]
    value, low, high = interval(values, statistic)
    return {"value [%]": 100 * value, "low [%]": 100 * low, "high [%]": 100 * high}


def _draw(ax: Axes, names: list[str], values: Array, low: Array, high: Array) -> None:
    """The table of (trackers, kinds) numbers and ends of intervals [%]."""
    ax.pcolormesh(values, cmap="viridis", vmin=0, vmax=100, edgecolor="w", lw=1)
    for (row, column), value in np.ndenumerate(values):
        color = "k" if value > DARK else "w"
        words = {"ha": "center", "color": color}
        ax.text(column + 0.5, row + 0.47, f"{value:.0f}", va="bottom", **words)
        ends = f"{low[row, column]:.0f}–{high[row, column]:.0f}"
        ax.text(column + 0.5, row + 0.87, ends, va="baseline", fontsize=7.5, **words)
    ax.invert_yaxis()
    ax.set_yticks(np.arange(len(names)) + 0.5, [LABELS[name] for name in names])
    ax.xaxis.tick_top()
    ax.set_xticks(np.arange(len(ORDER)) + 0.5, ORDER, rotation=45, ha="left")
    ax.tick_params(length=0)
