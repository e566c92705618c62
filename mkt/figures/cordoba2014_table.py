"""Table 1 of [C14] beside ours, and which part of PFHR its true positives come from."""

from dataclasses import replace

import numpy as np
from tqdm import tqdm

from mkt.evaluation import judged, overlaps, true_positives
from mkt.figures import figure
from mkt.figures.cordoba2014_material import COLORS, NAMES, OVERALL, TABLE, material, run, runs, said, source
from mkt.trackers.catalogue import TRACKERS


@figure("cordoba2014.table1", size=(10, 4.8), t_lim=(0.0, 0.8, 0.2), also=["none", "all"])
def table1(canvas, *, t_lim=0.2, runs=10, also="none"):
    """Table 1: the share of true positives, printed and ours.

    On the synthetic twins of one object, or on the BoBoT sequences whose lengths the printed fractions fit where MKT_DATA has them; under its name each row
    says which.  Percent of all frames, hidden ones too, whose overlap exceeds T_lim: mean and standard deviation over so many runs with other random
    numbers; WM has none.  Bold: the best of ours in a row.  The printed numbers were measured on BoBoT at 20 %, and other data need not give the same
    ones.  The printed third row repeats the first, and the printed overall mean of PFHR does not follow from its column, whose mean is 94.31.  BoBoT's
    sequence D, which the third row may mean, fits none of its three fractions.  `also` adds the library's other trackers, one run each, which takes
    minutes on the benchmark.
    """
    names = [*NAMES, *(name for name in TRACKERS if name not in NAMES and also == "all")]
    cells = [[_percent(TRACKERS[name], source(kind), t_lim, runs if name in NAMES else 1) for name in names] for kind in tqdm(TABLE, disable=None)]
    means, spread = (np.array([[statistic(cell) for cell in row] for row in cells]) for statistic in (np.mean, np.std))
    ax = canvas.add_axes((0, 0, 1, 1))
    ax.set(xlim=(0, 1), ylim=(7.1, -1.2))
    ax.set_axis_off()
    columns = _columns(names)
    _table_head(ax, columns, f"ours at {100 * t_lim:.0f} %, {runs} runs")
    for k, (kind, row) in enumerate(TABLE.items()):
        ax.text(0.01, k + 0.75, said(kind, source(kind)), va="center", fontsize=7.5, color="0.35")
        _table_line(ax, k + 0.35, columns, row.title, row.printed, means[k], spread[k])
    _table_line(ax, 6.5, columns, "Overall average", OVERALL, means.mean(0), None)
    return {"means": means, "spread": spread, "names": names, "overall": means.mean(0)}


def _percent(tracker, origin, t_lim, n):
    """True positives in n runs, (n,) [%] of all frames."""
    return 100 * true_positives(overlaps(runs(tracker, origin, n), material(origin)), t_lim, hidden=True)


def _columns(names):
    """Where the printed columns stand, and ours, dict name -> x."""
    others = names[len(NAMES):]
    printed, ours = ((0.24, 0.295, 0.35), (0.43, 0.525, 0.6)) if others else ((0.4, 0.49, 0.58), (0.7, 0.82, 0.93))
    return printed, dict(zip(names, [*ours, *np.linspace(0.67, 0.98, len(others))]))


def _table_head(ax, columns, title):
    printed, ours = columns
    for places, text in ((printed, "printed (BoBoT, 20 %)"), ([ours[name] for name in NAMES], title)):
        ax.text(np.mean(places), -0.9, text, ha="center", va="center")
        for x, name in zip(places, NAMES):
            ax.text(x, -0.35, NAMES[name], ha="center", va="center", fontweight="bold", color=COLORS[name])
    for name, x in ours.items():
        if name not in NAMES:
            ax.text(x, -0.1, name, rotation=60, ha="center", fontsize=8)
    for y in (0, 6):
        ax.axhline(y, color="0.3", lw=1)


def _table_line(ax, y, columns, title, printed, means, spread):
    places, ours = columns
    ax.text(0.01, y, title, va="center")
    for x, text in zip(places, printed):
        ax.text(x, y, text, ha="center", va="center", color="0.35")
    for k, ((name, x), value) in enumerate(zip(ours.items(), means)):
        text = f"{value:.0f}" if name not in NAMES else f"{value:.1f}" + (f" ± {spread[k]:.1f}" if spread is not None and name != "wm" else "")
        ax.text(x, y, text, ha="center", va="center", fontweight="bold" if value == max(means) else "normal", fontsize=9)


VARIANTS = {
    "PFHR": {}, "no occlusion mode": {"occlusion": "never"}, "occlusion by N_eff, as printed": {"occlusion": "n_eff"}, "no inertia": {"inertial": 0.0},
    "acceptance as printed": {"accept": "paper"}, "acceptance: fresh": {"accept": "fresh"}, "acceptance: Metropolis": {"accept": "metropolis"},
    "no model update": {"eta": 0.0, "gamma": 0.0},
}


@figure("cordoba2014.ablation", size=(10, 5.0), kind=["pillars", "passers", "trajectory"])
def ablation(canvas, *, kind="pillars", runs=4):
    """Where PFHR's gain comes from: its parts left out one at a time.

    Dots are runs, each on another synthetic twin of that kind: other path, object and ground; or, where MKT_DATA has it, on the BoBoT sequence with
    other random numbers.  The bar is their mean: true positives at 20 % out of all frames.  Dashed: the share of frames in which the target is seen, more than
    which nobody can reach.  The paper leaves no part out; its sentences credit the whole.  PFHR accepts every proposal; the three other readings of the
    acceptance test are below.  SIR is the paper's other filter; "SIR, our look" is the same with PFHR's bins and kernel.
    """
    origins, pfhr, sir = [source(kind, k) for k in range(runs)], TRACKERS["pfhr"], TRACKERS["sir"]
    trackers = {name: replace(pfhr, **change) for name, change in VARIANTS.items()}
    trackers |= {"SIR": sir, "SIR, our look": replace(sir, bins=pfhr.bins, kernels=pfhr.kernels)}
    tracks = [[(run(tracker, origin, k), material(origin)) for tracker in trackers.values()] for k, origin in enumerate(origins)]
    shares = 100 * np.array([[true_positives(overlaps(*one), hidden=True) for one in row] for row in tracks]).T
    ax = canvas.add_axes((0.24, 0.1, 0.72, 0.8))
    for k, (name, share) in enumerate(zip(trackers, shares)):
        color = COLORS["sir" if name.startswith("SIR") else "pfhr"]
        ax.barh(k, share.mean(), color=color, alpha=0.3 if k else 0.6)
        ax.plot(share, np.full(len(share), k), "o", color=color, ms=4, alpha=0.7)
        ax.text(101, k, f"{share.mean():.0f}", va="center")
    ax.axvline(shares[0].mean(), color=COLORS["pfhr"], lw=1)
    ax.axvline(100 * np.mean([judged(material(origin))[1:].mean() for origin in origins]), color="0.4", ls="--", lw=1)
    ax.set(yticks=range(len(trackers)), yticklabels=list(trackers), xlim=(0, 100), xlabel="true positives [%]", title=f"{said(kind, origins[0])}, {runs} runs")
    ax.invert_yaxis()
    return {"shares": shares, "names": list(trackers)}
