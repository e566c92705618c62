"""The claims of [C14], on the synthetic twins of its sequences.

D. A. L. Córdoba, C. M. C. C. Koike, F. de Barros Vidal, 2014; the twins are those of
`mkt.scenes.cordoba2014`.
"""

import numpy as np

from mkt.experiments.claims import Part, Runs, claim
from mkt.experiments.statistics import MEAN, PAIRS, SHARE
from mkt.experiments.timing import exponent, one_thread
from mkt.papers.cordoba2014.looks import LOOKS, RIVALS
from mkt.papers.cordoba2014.printed import TABLE
from mkt.papers.cordoba2014.resampling import counted, timed
from mkt.types import Array

OCCLUDED = ("passers", "pillars")
PARTICLES = (50, 100, 200, 400, 800)
EQUAL = 1.0  # [%] of true positives: less is taken for none


@claim("C14-a", "Table 1: 94.75, 89.74, 64.51 %", **dict.fromkeys(TABLE, RIVALS))
def hybrid_resampling_ranks_first(runs: Runs) -> list[Part]:
    """PFHR has more true positives than SIR, and SIR has more than window matching.

    The first overall and for every kind of sequence, the second overall, which is the
    mean over the six kinds.  True positives in percent of all frames, hidden ones too,
    at 20 % of overlap, as the printed fractions suggest.  PFHR and SIR have the same
    bins, kernel and motion, once with the paper's look and once with ours, which has
    more bins and trusts the border of the box less.  They differ in all that hybrid
    resampling is: when it draws, inertia, the search while the target is hidden, and
    the model update.  The printed table itself has SIR ahead of PFHR on scale
    variations.  Not measured here: that PFHR is ahead of window matching on every kind,
    and that SIR misses the size.  Window matching is ours, and follows better than the
    printed one.
    """
    parts = []
    for look, names in LOOKS.items():
        pfhr, sir = (_hits(runs, name) for name in names)
        lead = pfhr - sir
        text = f"true positives, PFHR minus SIR, {look}"
        parts += [
            _lead(f"overall: {text}", lead.mean(0)),
            *(
                _lead(f"{kind}: {text}", row, ours=look == "our look")
                for kind, row in zip(TABLE, lead, strict=True)
            ),
        ]
    second = (_hits(runs, "sir") - _hits(runs, "wm")).mean(0)
    return [*parts, _lead("overall: true positives, SIR minus WM", second)]


def _hits(runs: Runs, label: str) -> Array:
    """True positives [%] of a tracker on all kinds of sequence, (6, n)."""
    return 100 * np.array([runs(kind, label, "hits_of_all") for kind in TABLE])


def _lead(text: str, values: Array, ours: bool = False) -> Part:
    """By how much one is ahead of another."""
    return Part(text, values, 0, unit="%", statistic=MEAN, margin=EQUAL, ours=ours)


@claim(
    "C14-b", "Sections 4.2 and 4.3, figures 4 and 6", **dict.fromkeys(OCCLUDED, RIVALS)
)
def hybrid_resampling_recovers(runs: Runs) -> list[Part]:
    """After occlusions PFHR finds the target again, SIR and window matching less often.

    A run is lost when none of its last ten frames is a hit, after three total
    occlusions.  PFHR and SIR have the same look, the paper's and ours.  The paper says
    of the two others that they do not find it again at all; here they do in many runs.
    """
    return [
        part
        for kind in OCCLUDED
        for look, names in LOOKS.items()
        for part in _recovery(runs, kind, look, *names)
    ]


def _recovery(runs: Runs, kind: str, look: str, hybrid: str, plain: str) -> list[Part]:
    """What C14-b says about a kind of sequence, with the filters of one look."""
    pfhr, sir, wm = (runs(kind, name, "lost") for name in (hybrid, plain, "wm"))
    compared = f"{kind}: share of runs lost, {look}"
    return [
        Part(f"{compared}: PFHR", pfhr, 0.5, below=True, statistic=SHARE),
        _more(f"{compared}: SIR minus PFHR", sir - pfhr),
        _more(f"{compared}: WM minus PFHR", wm - pfhr),
    ]


def _more(text: str, values: Array) -> Part:
    return Part(text, values, 0, statistic=PAIRS, margin=0.1)


@claim("C14-c", "Section 4.5: O(n^2)")
def resampling_is_quadratic(runs: Runs) -> list[Part]:
    """The time of resampling grows at most with the square of the number of particles.

    O(n^2) is an upper bound, which both readings keep whatever happens: the exponent of
    the CPU time from 50 to 800 particles of random weight is below 2.1.  Whether the
    bound is tight is our question, for which comparisons are counted: Algorithm 1 as
    listed never sets its index back and is linear, the paper's count of steps, (n - 1)
    times n for the search, begins each search anew.
    """
    readings = {"Algorithm 1 as listed": False, "each search begun anew": True}
    return [
        part
        for text, anew in readings.items()
        for part in (
            Part(
                f"exponent of the CPU time, {text}",
                np.array([_timed(anew, seed) for seed in runs.seeds]),
                2.1,
                below=True,
                ours=True,
            ),
            Part(
                f"exponent of the comparisons, {text}",
                np.array([_counted(anew, seed) for seed in runs.seeds]),
                1.5,
                ours=True,
            ),
        )
    ]


def _counted(anew: bool, seed: int) -> float:
    return exponent(PARTICLES, [counted(anew, n, seed) for n in PARTICLES])


@one_thread()
def _timed(anew: bool, seed: int) -> float:
    return exponent(PARTICLES, timed(anew, PARTICLES, seed))
