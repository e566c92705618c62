"""Which part of PFHR its true positives come from.

Its runs are shipped; ``.venv/bin/python -m mkt.papers.cordoba2014.ablation`` makes them
again.  Explained in notebook 13.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.experiments.shipped import ABLATED, read_table, write_runs
from mkt.experiments.statistics import MEAN, holm, interval, p_value
from mkt.experiments.sweep import Job, jobs, sweep
from mkt.figures.registry import Shown, figure, grid_columns, shown
from mkt.papers.cordoba2014.looks import RIVALS
from mkt.papers.cordoba2014.printed import COLORS, share_seen
from mkt.scenes.drawn import HELD_BACK, drawn
from mkt.trackers.by_name import TRACKERS
from mkt.tracking import Tracker
from mkt.types import Array

VARIANTS: dict[str, dict[str, Any]] = {
    "PFHR": {},
    "no occlusion mode": {"occlusion": "never"},
    "occlusion by N_eff, as printed": {"occlusion": "n_eff"},
    "no inertia": {"inertial": 0.0},
    "acceptance as printed": {"accept": "paper"},
    "no mode, acceptance as printed": {"occlusion": "never", "accept": "paper"},
    "acceptance: fresh": {"accept": "fresh"},
    "acceptance: Metropolis": {"accept": "metropolis"},
    "no model update": {"eta": 0.0, "gamma": 0.0},
}
KINDS = ["pillars", "passers", "trajectory"]
MEANS, LOST = 112, 133  # places of the numbers beside the bars
SEEDS = HELD_BACK[:16]  # all pairs of an object and a ground
COLUMNS = ("tracker", "source", "seed", "hits_of_all", "seen")


@figure("cordoba2014.ablation", size=(10, 5.0), kind=KINDS)
def ablation(fig: Figure, *, kind: str = "pillars") -> Shown:
    """Where PFHR's gain comes from: its parts left out one at a time.

    Dots are runs, each on another drawn scene of that kind, on which nothing was tuned:
    sixteen pairs of an object and a ground, each on a path of its own.  The bar is
    their mean, the first number at the right: true positives at 20 % out of all frames.
    The second one is what is lost against the whole PFHR, with the 95 % interval of
    this mean of sixteen differences; bold where a t test says that it is not zero,
    after Holm's correction over the lines of a kind.  Dashed: the share of frames in
    which the target is seen, in the mean of the scenes; no mean can be beyond it.  The
    paper leaves no part out; its sentences credit the whole.  PFHR accepts every
    proposal; the three other readings of the acceptance test are below, the printed one
    also without the occlusion mode.  By N_eff, as printed, a frame of low N_eff draws
    and estimates as ever, and the next one searches wide.  SIR is the paper's other
    filter; "SIR, our look" is the same with PFHR's bins and kernel.
    """
    rows, _ = read_table(ABLATED, *COLUMNS)
    rows = rows[rows["source"] == kind]
    cells = rows.pivot(index="tracker", columns="seed", values="hits_of_all")
    names = list(variants())
    values = 100 * cells.loc[names, list(SEEDS)].to_numpy()
    losses = [values[0] - each for each in values[1:]]
    none = (0.0, 0.0, 0.0)  # of the whole against itself
    lost = np.array([none, *(interval(each, MEAN) for each in losses)])
    sure = [False, *(holm([_two_sided(each) for each in losses]) < 0.05)]
    ax = fig.add_axes((0.25, 0.1, 0.5, 0.8))
    _draw_bars(ax, names, values)
    for y, each in enumerate(lost):
        _write(ax, y, values[y].mean(), each if y else None, sure[y])
    seen = 100 * rows["seen"].mean()
    ax.axvline(seen, color="0.4", ls="--", lw=1)
    ax.set_title(f'"{kind}", {len(SEEDS)} drawn scenes')
    table = grid_columns(
        {"variant": names}, {"seed": SEEDS}, **{"true positives [%]": values}
    )
    facts = {"seen": seen, "lost": lost, "sure": np.array(sure)}
    return shown(table, shares=values, names=names, **facts)


def _two_sided(values: Array) -> float:
    """P-value of the t test whether the mean of values (n,) is another than 0."""
    return min(1.0, 2 * min(p_value(values, MEAN, 0, s) for s in ("less", "greater")))


def variants() -> dict[str, Tracker]:
    """PFHR, PFHR with one part of it left out or read in another way, and SIR."""
    pfhr, sir = TRACKERS["pfhr"], TRACKERS["sir"]
    trackers = {name: replace(pfhr, **change) for name, change in VARIANTS.items()}
    return trackers | {"SIR": sir, "SIR, our look": RIVALS["sir ours"]}


def _draw_bars(ax: Axes, names: list[str], shares: Array) -> None:
    """A bar for the mean of each variant, and its runs as dots: shares (V, n)."""
    for y, (name, share) in enumerate(zip(names, shares, strict=True)):
        color = COLORS["sir" if name.startswith("SIR") else "pfhr"]
        ax.barh(y, share.mean(), color=color, alpha=0.3 if y else 0.6)
        dots = {"color": color, "ms": 4, "alpha": 0.7, "clip_on": False}
        ax.plot(share, np.full(len(share), y), "o", **dots)
    ax.axvline(shares[0].mean(), color=COLORS["pfhr"], lw=1)
    ax.set_yticks(range(len(names)), names)
    ax.set(xlim=(0, 100), xlabel="true positives [%]")
    ax.invert_yaxis()
    ax.text(MEANS, -0.75, "mean", ha="right")
    ax.text(LOST, -0.75, "PFHR minus it, 95 %", ha="center")


def _write(ax: Axes, y: int, mean: float, lost: Array | None, sure: bool) -> None:
    """The numbers of a line: its mean, and what is lost with its interval."""
    ax.text(MEANS, y, f"{mean:.0f}", ha="right", va="center")
    if lost is None:
        return
    value, low, high = np.round(lost, 1) + 0.0  # without a minus before 0
    weight = "bold" if sure else "normal"
    text = f"{value:.1f} [{low:.1f}, {high:.1f}]".replace("-", "\N{MINUS SIGN}")
    ax.text(LOST, y, text, ha="center", va="center", fontweight=weight)


def all_jobs() -> list[Job]:
    """Every variant on every scene, with the scene's seed."""
    return [
        job
        for kind in KINDS
        for seed in SEEDS
        for job in jobs(variants(), [drawn(kind, seed)], [seed])
    ]


def release() -> None:
    """Run all of it and keep it.  Raises OSError."""
    rows = sweep(all_jobs())
    pairs = zip(rows["source"], rows["seed"], strict=True)
    rows["seen"] = [share_seen(drawn(kind, seed)) for kind, seed in pairs]
    write_runs(rows[list(COLUMNS)], SEEDS, ABLATED)


if __name__ == "__main__":
    release()
