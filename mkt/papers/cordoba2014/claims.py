"""The claims of [C14], on the synthetic twins of its sequences.

D. A. L. Córdoba, C. M. C. C. Koike, F. de Barros Vidal, 2014; the twins are those of
`mkt.scenes.cordoba2014`.
"""

from functools import partial

import numpy as np

from mkt.evaluation import HIT, errors, overlaps, scored_frames
from mkt.experiments.claims import Part, Runs, claim, over_seeds
from mkt.experiments.statistics import MEAN, PAIRS, SHARE
from mkt.experiments.timing import exponent, one_thread
from mkt.papers.cordoba2014.looks import LOOKS, PRINTED, RIVALS
from mkt.papers.cordoba2014.printed import TABLE
from mkt.papers.cordoba2014.resampling import counted, timed
from mkt.scenes.drawn import drawn
from mkt.tracking import track
from mkt.types import Array

OCCLUDED = ("passers", "pillars")
SIZED = ("clutter", *OCCLUDED)  # of which the paper speaks of the size
PARTICLES = (50, 100, 200, 400, 800)
AS_PRINTED = "pfhr as printed"
EQUAL = 1.0  # [%] of true positives: less is taken for none
EQUAL_RATIO = 0.1  # of errors of the size: a tenth is taken for none


@claim(
    "C14-a",
    "Table 1: 94.75, 89.74, 64.51 %",
    **dict.fromkeys(TABLE, RIVALS | {AS_PRINTED: PRINTED}),
)
def hybrid_resampling_ranks_first(runs: Runs) -> list[Part]:
    """PFHR has more true positives than SIR, and SIR has more than window matching.

    The first overall and for every kind of sequence, the second overall, which is the
    mean over the six kinds.  True positives in percent of all frames, hidden ones too,
    at 20 % of overlap, as the printed fractions suggest.  PFHR and SIR have the same
    bins, kernel and motion, once with the paper's look and once with ours, which has
    more bins and trusts the border of the box less.  They differ in all that hybrid
    resampling is: when it draws, inertia, the search while the target is hidden, and
    the model update.  PFHR is as we could make it work: it accepts every proposal, and
    waits where the likelihood says that the target is hidden.  As it is printed, with
    the test of Algorithm 2 and a wide search after every frame of low N_eff, it stands
    at the end, as ours, since that can hardly be meant; another reading, by which it
    waited after such a frame, was run before this one.  So do the lines with our look.
    The printed table itself has SIR ahead of PFHR on scale variations.  Window matching
    is ours; on these scenes it follows better than the printed one does on the paper's,
    on BoBoT's ball and cup worse.  Its lines beside PFHR came after the runs.
    """
    (pfhr, sir), (pfhr_ours, sir_ours) = (
        [_hits(runs, name) for name in names] for names in LOOKS.values()
    )
    wm, printed = _hits(runs, "wm"), _hits(runs, AS_PRINTED)
    return [
        *_leads("PFHR minus SIR, the paper's look", pfhr - sir),
        *_leads("PFHR minus WM, the paper's look", pfhr - wm),
        *_leads("SIR minus WM", sir - wm)[:1],
        *_leads("PFHR as printed minus SIR", printed - sir, ours=True),
        *_leads("PFHR minus SIR, our look", pfhr_ours - sir_ours, ours=True),
    ]


def _leads(text: str, lead: Array, ours: bool = False) -> list[Part]:
    """Parts on the lead (6, n) of one over another: overall, then for every kind."""
    said = f"true positives, {text}"
    return [
        _lead(f"overall: {said}", lead.mean(0), ours),
        *(
            _lead(f"{kind}: {said}", row, ours)
            for kind, row in zip(TABLE, lead, strict=True)
        ),
    ]


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
    """After occlusions PFHR finds the target again, SIR and window matching do not.

    A run is lost when none of its last ten frames is a hit, after three total
    occlusions.  PFHR and SIR have the same look, the paper's, and in lines of ours also
    ours; PFHR is that of C14-a.  The paper says that window matching, and SIR indoors,
    do not find it; of SIR outdoors it says that and that it follows.  Before the runs
    they were to be lost more often than PFHR.  The lines that ask whether they are lost
    in most runs came after the runs.
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
    ours = look == "our look"
    rivals = {"SIR": sir} if ours else {"SIR": sir, "WM": wm}  # which has no look
    return [
        Part(f"{compared}: PFHR", pfhr, 0.5, below=True, statistic=SHARE, ours=ours),
        *(
            Part(f"{compared}: {name}", lost, 0.5, statistic=SHARE, ours=ours)
            for name, lost in rivals.items()
        ),
        _more(f"{compared}: SIR minus PFHR", sir - pfhr, ours),
        _more(f"{compared}: WM minus PFHR", wm - pfhr, ours),
    ]


def _more(text: str, values: Array, ours: bool) -> Part:
    return Part(text, values, 0, statistic=PAIRS, margin=0.1, ours=ours)


@claim("C14-c", "Section 4.5: O(n^2)")
def resampling_is_quadratic(runs: Runs) -> list[Part]:
    """The time of resampling grows at most with the square of the number of particles.

    O(n^2) is an upper bound, which both readings keep whatever happens: the exponent of
    the CPU time from 50 to 800 particles of random weight is below 2.1.  These lines
    had a say at first, and are ours since then, after the first runs.  Whether the
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


@claim("C14-d", "Sections 4.1 to 4.3")
def hybrid_resampling_knows_the_size(runs: Runs) -> list[Part]:
    """SIR misses the size of the target, and PFHR estimates it.

    Of this only the comparison is tested: SIR's error over PFHR's, both with the
    paper's look, in the frames in which both hold the target, since a lost one has any
    size.  PFHR is that of C14-a.  The claim was put after runs on ten of the scenes,
    and that a tenth is none was said after all.
    """
    return [
        Part(
            f"{kind}: error of the size, SIR over PFHR",
            np.array(over_seeds(partial(_sizes, kind), runs.seeds)),
            1,
            margin=EQUAL_RATIO,
        )
        for kind in SIZED
    ]


def _sizes(kind: str, seed: int) -> float:
    """Mean error of log H for SIR over that for PFHR, where both hold the target."""
    clip = drawn(kind, seed).sequence()
    pfhr, sir = (
        track(RIVALS[name], clip, seed).regions for name in LOOKS["the paper's look"]
    )
    scored = scored_frames(clip)
    held = scored & (overlaps(pfhr, clip) > HIT) & (overlaps(sir, clip) > HIT)
    of_sir, of_pfhr = (
        np.abs(errors(regions[held], clip.truth[held]).scale).mean()
        for regions in (sir, pfhr)
    )
    return float(of_sir / of_pfhr)
