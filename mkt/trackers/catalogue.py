"""The trackers by the names that commands, figures and tables use; the first five are (1) to (5) of figure 6 in [T09], in its order."""

from dataclasses import replace

from mkt.histograms import ColorBins
from mkt.kernels import Kernels
from mkt.trackers.adaptive import Adaptive
from mkt.trackers.baselines import MIL, CamShift, MeanShift
from mkt.trackers.combined import Combined
from mkt.trackers.guided import Guided
from mkt.trackers.hybrid_resampling import HybridResampling
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD
from mkt.trackers.template_matching import TemplateMatching

PFHR = HybridResampling()
WHOLE_BOX = Kernels("one", "uniform", span=1.5, elliptic=True, samples=400)  # every pixel of the box alike, as [C14] has it

TRACKERS = {
    "pf-1": ParticleFilter(n=500, kernels=Kernels("one")),  # the single kernel of Section II
    "ssd": SSD(),
    "pf-500": ParticleFilter(n=500),
    "pf-75": ParticleFilter(n=75),
    "combined": Combined(),
    "guided": Guided(),
    "adaptive": Adaptive(),
    "sir": ParticleFilter(n=200, kernels=WHOLE_BOX, motion=PFHR.motion, scheme="systematic", bins=ColorBins("hs")),
    "pfhr": PFHR,
    "wm": TemplateMatching(),
    "mil": MIL(),
    "camshift": CamShift(),
    "meanshift": MeanShift(),
}
LABELS = {
    "pf-1": "(1) one kernel, 500 particles",
    "ssd": "(2) SSD, nine kernels",
    "pf-500": "(3) nine parts, 500 particles",
    "pf-75": "(4) nine parts, 75 particles",
    "combined": "(5) combined, 75 particles",
    "guided": "guided (ours)",
    "adaptive": "adaptive colour particle filter [N03]",
    "sir": "SIR particle filter [C14]",
    "pfhr": "hybrid resampling, PFHR [C14]",
    "wm": "window matching, WM [C14]",
    "mil": "MIL (OpenCV)",
    "camshift": "CamShift (OpenCV)",
    "meanshift": "MeanShift (OpenCV)",
}
SLOW = ("mil",)  # ten times slower than the rest: run less often where many runs must be quick


def get(name):
    """The tracker of a name.  Raises KeyError that lists the known names."""
    if name not in TRACKERS:
        raise KeyError(f"no tracker {name!r}; there are {', '.join(TRACKERS)}")
    return TRACKERS[name]


def with_particles(name, n):
    """The tracker of a name, with n particles.  Raises KeyError as `get` does, ValueError when it has none, or when n is not positive."""
    tracker = get(name)
    if n < 1:
        raise ValueError(f"particles is {n}; there must be at least 1")
    if hasattr(tracker, "n"):
        return replace(tracker, n=n)
    if not hasattr(tracker, "filter"):
        able = ", ".join(other for other, t in TRACKERS.items() if hasattr(t, "n") or hasattr(t, "filter"))
        raise ValueError(f"the tracker {name!r} has no particles; leave their number out, or choose one of {able}")
    return replace(tracker, filter=replace(tracker.filter, n=n))
