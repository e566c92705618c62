"""The trackers by the names that commands, figures and tables use.

The first five are (1) to (5) of figure 6 in [T09], in its order.
"""

from dataclasses import replace

from mkt.checks import is_whole
from mkt.colors import ColorBins
from mkt.kernels import Kernels
from mkt.registry import Registry
from mkt.trackers.adaptive import Adaptive
from mkt.trackers.combined import Combined
from mkt.trackers.guided import Guided
from mkt.trackers.hybrid_resampling import HybridResampling
from mkt.trackers.opencv import MIL, CamShift, MeanShift
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD
from mkt.trackers.template_matching import TemplateMatching
from mkt.tracking import Tracker, check_tracker


class _Labels(dict[str, str]):
    """A label for each name, which is its own where none was given."""

    def __missing__(self, name: str) -> str:
        return name


#: The trackers by name.
#:
#: :meta hide-value:
TRACKERS = Registry("tracker")
#: What tables and menus call them, by the same names.
#:
#: :meta hide-value:
LABELS = _Labels()
SLOW = ("mil",)  # ten times slower than the rest: run less often where it must be quick


def add(name: str, tracker: Tracker, label: str) -> None:
    """Give a tracker a name and a label.

    ValueError for a name that is taken or no text, and for what is no tracker.
    """
    check_tracker(tracker)
    TRACKERS.add(name, tracker)
    LABELS[name] = label


PFHR = HybridResampling()
# Every pixel of the box has the same weight, as in [C14].
WHOLE_BOX = Kernels("one", "uniform", span=1.5, elliptic=True, samples=400)
SIR = ParticleFilter(
    n=200,
    kernels=WHOLE_BOX,
    motion=PFHR.motion,
    scheme="systematic",
    bins=ColorBins("hs"),
)
ONE = ParticleFilter(n=500, kernels=Kernels("one"))  # a single kernel, round

add("pf-1", ONE, "(1) one kernel, 500 particles")
add("ssd", SSD(), "(2) SSD, nine kernels")
add("pf-500", ParticleFilter(n=500), "(3) nine parts, 500 particles")
add("pf-75", ParticleFilter(n=75), "(4) nine parts, 75 particles")
add("combined", Combined(), "(5) combined, 75 particles")
add("guided", Guided(), "guided (ours)")
add("adaptive", Adaptive(), "adaptive colour particle filter [N03]")
add("sir", SIR, "SIR particle filter [C14]")
add("pfhr", PFHR, "hybrid resampling, PFHR [C14]")
add("wm", TemplateMatching(), "window matching, WM [C14]")
add("mil", MIL(), "MIL (OpenCV)")
add("camshift", CamShift(), "CamShift (OpenCV)")
add("meanshift", MeanShift(), "MeanShift (OpenCV)")
SHIPPED = tuple(TRACKERS)  # what a command knows by its name, whatever a notebook adds


def quick() -> list[str]:
    """The names of all trackers but the slow ones."""
    return [name for name in TRACKERS if name not in SLOW]


def with_particles(name: str, n: int) -> Tracker:
    """The tracker of a name, with n particles.

    Raises
    ------
    ValueError
        For an unknown name, for a tracker without particles, and for an n that is no
        whole number from 1 on.
    """
    tracker = TRACKERS[name]
    if not is_whole(n, 1):
        raise ValueError(
            f"particles is {n!r}; there must be at least 1, and a whole number of them"
        )
    if hasattr(tracker, "n"):
        return replace(tracker, n=n)
    if hasattr(tracker, "filter"):
        return replace(tracker, filter=replace(tracker.filter, n=n))
    able = [one for one, made in TRACKERS.items() if _has_particles(made)]
    raise ValueError(
        f"the tracker {name!r} has no particles; leave their number out, "
        f"or choose one of {', '.join(able)}"
    )


def _has_particles(tracker: Tracker) -> bool:
    return hasattr(tracker, "n") or hasattr(tracker, "filter")
