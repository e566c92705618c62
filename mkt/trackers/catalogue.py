"""The trackers by the names that commands, figures and tables use; the first five are (1) to (5) of figure 6 in [T09], in its order."""

from mkt.kernels import Kernels
from mkt.trackers.combined import Combined
from mkt.trackers.guided import Guided
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD

TRACKERS = {
    "pf-1": ParticleFilter(n=500, kernels=Kernels("one")),  # the single kernel of Section II
    "ssd": SSD(),
    "pf-500": ParticleFilter(n=500),
    "pf-75": ParticleFilter(n=75),
    "combined": Combined(),
    "guided": Guided(),
}
LABELS = {
    "pf-1": "(1) one kernel, 500 particles",
    "ssd": "(2) SSD, nine kernels",
    "pf-500": "(3) nine parts, 500 particles",
    "pf-75": "(4) nine parts, 75 particles",
    "combined": "(5) combined, 75 particles",
    "guided": "guided (ours)",
}


def get(name):
    """The tracker of a name.  Raises KeyError that lists the known names."""
    if name not in TRACKERS:
        raise KeyError(f"no tracker {name!r}; there are {', '.join(TRACKERS)}")
    return TRACKERS[name]
