"""What the figures of [C14] are made of: the printed Table 1, its six kinds of sequence with the data that stand for them, and runs over these.

Where MKT_DATA has the BoBoT benchmark, its sequences are used, else their synthetic twins of `mkt.twins`; `said` tells which.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from mkt import archives
from mkt.figures.runs import clip
from mkt.plotting import CONTRAST
from mkt.scenes import Scene
from mkt.trackers.catalogue import TRACKERS
from mkt.tracking import track
from mkt.twins import TWINS

TWIN = ("astronaut", "bricks"), ("car", "workshop"), ("hopper", "gravel"), ("cat", "launch pad")  # object and ground of a twin, seed by seed
COLORS = dict(zip(("sir", "wm", "pfhr"), CONTRAST))
NAMES = {"pfhr": "PFHR", "sir": "SIR", "wm": "WM"}  # in the order of the table's columns


@dataclass(frozen=True)
class Row:
    """A row of Table 1: its name, the percentages of PFHR, SIR and WM as printed, and what was inferred from these (notebook 14): how the name of
    its BoBoT sequence begins, and the number of frames that they are fractions of."""

    title: str
    printed: tuple[str, str, str]
    bobot: str
    frames: int

    @property
    def percent(self):
        """The printed percentages as numbers."""
        return tuple(map(float, self.printed))


TABLE = {
    "clutter": Row("Cluttered environments", ("97.60", "95.21", "82.93"), "Vid_B", 627),
    "passers": Row("Outdoor w/ total occlusion", ("93.79", "90.18", "70.07"), "Vid_I", 1016),
    "background": Row("Background changes", ("97.60", "95.21", "82.93"), "Vid_D", 627),  # the first row again; D has 946 or 947, which none of them fits
    "scale": Row("Scale variations", ("92.30", "94.96", "33.90"), "Vid_G", 715),
    "trajectory": Row("Trajectory changes", ("95.67", "76.87", "87.18"), "Vid_A", 601),
    "pillars": Row("Indoor w/ total occlusion", ("88.93", "86.06", "30.08"), "Vid_F", 452),
}
OVERALL = "94.75", "89.74", "64.51"  # printed; the mean of the printed PFHR column is 94.31


def source(kind, seed=0):
    """What stands for a kind of sequence: its BoBoT sequence, a `mkt.archives.Found`, or if that is not there the `Scene` of a twin."""
    found = [one for one in archives.sequences() if one.name.startswith(f"BoBoT/{TABLE[kind].bobot}")]
    return found[0] if found else TWINS[kind](seed, *TWIN[seed % len(TWIN)])


def material(source):
    """The `Sequence` of a source."""
    return clip(source) if isinstance(source, Scene) else _recorded(source)


@lru_cache(maxsize=8)
def _recorded(found):
    return found.read()


def said(kind, source):
    """What the reader is looking at, in a few words."""
    if isinstance(source, Scene):
        return f"synthetic twin \"{kind}\""
    return f"{source.name}, {source.archive.licence}" + ", frames reconstructed" * ("reconstructed" in material(source).source)


@lru_cache(maxsize=2048)
def run(tracker, source, seed=0):
    """The regions (T, 5) that a tracker finds in a source; each run is made once and kept."""
    return track(tracker, material(source), seed).regions


def contenders(particles=200, n_lim=0.5, gamma=0.1):
    """WM, SIR and PFHR, the filters with so many particles, dict name -> tracker."""
    pfhr = replace(TRACKERS["pfhr"], n=particles, n_lim=n_lim, gamma=gamma)
    return {"wm": TRACKERS["wm"], "sir": replace(TRACKERS["sir"], n=particles), "pfhr": pfhr}


def runs(tracker, source, n):
    """The regions of n runs, (n, T, 5); a tracker without particles would only repeat itself, and runs once."""
    return np.array([run(tracker, source, seed) for seed in range(n if hasattr(tracker, "n") else 1)])
