"""Teaching figures of the chapter on benchmarks: what a ranking depends on, and the arithmetic of a printed table."""

import numpy as np

from mkt.evaluation import HIT, LIMITS, overlaps, success, true_positives
from mkt.figures import figure
from mkt.figures.cordoba2014_material import NAMES, OVERALL, TABLE
from mkt.figures.runs import clip, run
from mkt.plotting import CONTRAST, DASHES, TRUTH
from mkt.plotting import TRACKERS as COLORS
from mkt.scenarios import SCENARIOS
from mkt.trackers.catalogue import LABELS, SLOW, TRACKERS

OTHERS = [(TRUTH, "-"), *((color, dash) for dash in DASHES[1:] for color in CONTRAST)]  # colours and dashes
SCENES = ("look-alike", "occlusion")


@figure("own.success", size=(10, 5), limit=(0.05, 0.95, 0.05), scene=list(SCENES), seed=[0, 1])
def success_curves(canvas, *, limit=HIT, scene="occlusion", seed=0):
    """Success curves, and the ranking at one limit.

    Left, the share of frames whose overlap exceeds T_lim, against T_lim.  Right, the same share at the limit of the slider (dashed), in the same
    colours and beside the same line: plain out of the frames in which the target is seen, hatched out of all frames, as [C14] counts; then the area
    under the curve, as in OTB.  Synthetic data: one sequence, one run of each tracker of the library but MIL, which would take longer than all the others together.
    """
    sequence = clip(SCENARIOS[scene](seed))
    names = [name for name in TRACKERS if name not in SLOW]
    iou = overlaps(np.array([run(TRACKERS[name], SCENARIOS[scene](seed), seed).regions for name in names]), sequence)
    curves, seen, every = success(iou), true_positives(iou, limit), true_positives(iou, limit, hidden=True)
    styles = dict(zip(names, _styles(names)))

    left, right = canvas.subplots(1, 2, gridspec_kw={"left": 0.055, "right": 0.95, "bottom": 0.11, "top": 0.92, "wspace": 0.9})
    for name, curve in zip(names, curves):
        left.plot(LIMITS, curve, lw=2, label=LABELS[name], **styles[name])
    left.axvline(limit, color="0.4", ls="--", lw=1)
    left.set(xlim=(0, 1), ylim=(0, 1.02), xlabel="$T_{lim}$", ylabel="share of the seen frames")
    order = np.argsort(seen, kind="stable")
    right.barh(range(len(names)), 100 * seen[order], color=[styles[names[k]]["color"] for k in order])
    right.barh(range(len(names)), 100 * every[order], color="none", edgecolor="white", hatch="////", lw=0)
    right.set_yticks(range(len(names)), [LABELS[names[k]] for k in order], fontsize=8)
    right.tick_params("y", length=0, pad=34)
    for y, k in enumerate(order):
        right.plot([-0.12, -0.015], [y, y], lw=2, transform=right.get_yaxis_transform(), clip_on=False, **styles[names[k]])
        right.text(104, y, f"{curves[k].mean():.2f}", va="center", fontsize=9)
    right.text(104, len(names) - 0.4, "area", fontsize=9, weight="bold")
    right.set(xlim=(0, 100), ylim=(-0.6, len(names) - 0.4), xlabel="true positives [%]", title=f"ranking at $T_{{lim}}$ = {limit:g}")
    return {"names": names, "curves": curves, "area": curves.mean(1), "seen": seen, "all": every}


def _styles(names):
    """Colour and dashes of each tracker: a full line in its colour of the plots where it has one."""
    others = iter(OTHERS)
    return [dict(zip(("color", "ls"), (COLORS[name], "-") if name in COLORS else next(others))) for name in names]


LENGTHS = {"A": 602, "B": 629, "F": 453, "G": 716, "I": 1017}  # rows of truth in BoBoT; the first is where a tracker starts
FRAMES = np.arange(200, 1101)


def counts(percent, n, rounding="truncated"):
    """The whole numbers k for which k of n frames is printed as this percentage with two decimals.

    percent: text such as "97.60"; rounding: "truncated" or "rounded", half up.  Integers only, for floats would be off by one.  Returns a list.
    """
    hundredths = int(percent.replace(".", ""))
    first = hundredths * n // 10000
    return [k for k in range(max(first - 1, 0), min(first + 2, n) + 1) if _hundredths(k, n, rounding) == hundredths]


def _hundredths(k, n, rounding):
    """k of n in hundredths of a per cent, a whole number."""
    return 10000 * k // n if rounding == "truncated" else (20000 * k + n) // (2 * n)


def hits(row, rounding="truncated", frames=FRAMES):
    """How many of the three percentages of a row are possible for each number of frames, (len(frames),) int."""
    return np.array([sum(bool(counts(percent, int(n), rounding)) for percent in TABLE[row].printed) for n in frames])


@figure("own.table_forensics", size=(10, 6.6), row=list(TABLE), rounding=["truncated", "rounded"])
def table_forensics(canvas, *, row="clutter", rounding="truncated"):
    """What the numbers of a printed table give away.

    A percentage of true positives is a whole number out of n.  Above, for one row of Table 1 of [C14], how many of its three percentages can be
    written as k / n with two decimals: at the n in red, all of them can.  Marked below are sequences of BoBoT, by the number of their rows of truth
    less the first.  Then the whole table: each cell with its k for the n at the right, red where there is none, and the means of the columns against
    the printed ones.  All numbers are the print's; nothing was run for this figure.  Which sequence belongs to which row is inferred.
    """
    found = hits(row, rounding)
    upper = canvas.add_axes((0.07, 0.63, 0.915, 0.3))
    upper.vlines(FRAMES, 0, found, color=np.where(found == 3, "#d62728", "0.7"), lw=np.where(found == 3, 2, 1))
    all_three = FRAMES[found == 3].tolist()
    for n in all_three:
        upper.text(n, 3.08, str(n), ha="center", color="#d62728")
    for name, length in LENGTHS.items():
        upper.plot(length - 1, -0.17, "^", color="#0072b2", ms=7, clip_on=False)
        upper.text(length - 1 + 7, -0.17, name, color="#0072b2", va="center", clip_on=False, weight="bold")
    upper.set(xlim=(200, 1100), ylim=(-0.4, 3.5), yticks=range(4), xlabel="number of frames n", ylabel="possible of 3",
              title=f"{TABLE[row].title}: {', '.join(f'{p} %' for p in TABLE[row].printed)}, {rounding}")
    cells = {name: [counts(percent, row.frames, rounding) for percent in row.printed] for name, row in TABLE.items()}
    means = np.mean([row.percent for row in TABLE.values()], 0)
    _draw_table(canvas.add_axes((0.07, 0.01, 0.915, 0.5)), cells, means)
    return {"n": all_three, "hits": found, "possible": {name: [bool(k) for k in cell] for name, cell in cells.items()}, "means": means}


def _draw_table(ax, cells, means):
    """The printed table with its counts, and its last line against the means of the columns."""
    ax.set_axis_off()
    ax.set(xlim=(0, 1), ylim=(8.3, -0.6))
    columns = (0.31, 0.53, 0.75)
    for x, text in zip((0.0, *columns, 0.93), ("Table 1 of [C14]", *NAMES.values(), "n")):
        ax.text(x, 0, text, weight="bold")
    for y, (name, row) in enumerate(cells.items(), 1):
        ax.text(0, y, TABLE[name].title + " (row 1 again)" * (name == "background"))
        ax.text(0.93, y, str(TABLE[name].frames))
        for x, percent, k in zip(columns, TABLE[name].printed, row):
            ax.text(x, y, f"{percent}   " + (f"k = {k[0]}" if k else "no such k"), color="black" if k else "#d62728")
    ax.text(0, 7, "overall, as printed", style="italic")
    ax.text(0, 8, "mean of the column", style="italic")
    for x, printed, mean in zip(columns, OVERALL, means):
        ax.text(x, 7, printed)
        ax.text(x, 8, f"{mean:.3f}", color="black" if abs(mean - float(printed)) < 0.01 else "#d62728")
    ax.axhline(0.35, color="0.6", lw=0.8)
    ax.axhline(6.4, color="0.6", lw=0.8)
