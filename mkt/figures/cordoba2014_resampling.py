"""Section 4.5 of [C14]: what resampling costs."""

import time

import numpy as np

from mkt.figures import figure
from mkt.figures.cordoba2014_material import COLORS


READINGS = {"search begun anew for each draw (4.5.2)": True, "one sweep (Algorithm 1)": False}


def ancestors(cumulative, u, anew):
    """Resampling: for each place in u the first particle whose cumulative weight reaches it.

    anew: begin each search at the first particle, as Section 4.5.2 counts; else where the last one stopped, as Algorithm 1 lists, which never sets i
    back.  cumulative, u: (N,), both rising.  Returns the ancestors (N,) and the number of comparisons, at most 2 N - 1 where i is never set back.
    """
    chosen, comparisons, i = [], 0, 0
    for place in u:
        i = 0 if anew else i
        comparisons += 1
        while place > cumulative[i]:
            i += 1
            comparisons += 1
        chosen.append(i)
    return np.array(chosen), comparisons


def counted(anew, n, seed=0):
    """How many comparisons the searches need for n particles of random weight, and how long they take [ms]."""
    rng = np.random.default_rng((seed, n))
    cumulative = np.cumsum(rng.exponential(size=n))
    u = (np.arange(n) + rng.random()) / n * cumulative[-1]
    start = time.process_time()
    _, comparisons = ancestors(cumulative, u, anew)
    return comparisons, 1e3 * (time.process_time() - start)


def exponent(n, values):
    """The slope of a straight line through the logarithms."""
    return float(np.polyfit(np.log(n), np.log(values), 1)[0])


@figure("cordoba2014.complexity", size=(10, 4.2), largest=[400, 800, 1600])
def complexity(canvas, *, largest=1600, seed=0):
    """Section 4.5: what resampling costs, counted and timed.

    Comparisons and time of two readings of the search through the cumulative weights, for particles of random weight; the exponents are slopes of
    straight lines through the logarithms.  The paper counts N searches of up to N steps each and concludes O(N^2).  But its Algorithm 1 never sets i back
    to the start, so that all searches together take at most 2 N steps.  Times are of plain Python loops on the machine that drew this, the best of three.
    """
    n = np.unique(np.geomspace(25, largest, 7).round().astype(int))
    left, right = canvas.subplots(1, 2, gridspec_kw={"left": 0.07, "right": 0.985, "bottom": 0.14, "top": 0.92, "wspace": 0.2})
    result = {"n": n}
    for (label, anew), color, marker in zip(READINGS.items(), (COLORS["wm"], COLORS["pfhr"]), "os"):
        table = np.array([[counted(anew, size, seed) for size in n] for _ in range(3)])
        comparisons, milliseconds = table[0, :, 0], table[..., 1].min(0)
        for ax, values in ((left, comparisons), (right, milliseconds)):
            ax.loglog(n, values, marker + "-", color=color, label=f"{label}: exponent {exponent(n, values):.2f}")
        result["anew" if anew else "sweep"] = {"comparisons": comparisons, "exponent": exponent(n, comparisons), "timed": exponent(n, milliseconds)}
    left.set(xlabel="number of particles N", ylabel="comparisons")
    right.set(xlabel="number of particles N", ylabel="time [ms]")
    for ax in (left, right):
        ax.legend(loc="upper left")
        ax.set_ylim(top=30 * ax.get_ylim()[1])
    return result
