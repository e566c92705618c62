"""Runs that several figures show: each is made once in a process and kept.

So figures 6 and 7 of [T09] draw one and the same run, and a slider runs only the trackers that it changes.
"""

from functools import lru_cache

from mkt.scenes import sequence
from mkt.tracking import track


@lru_cache(maxsize=64)
def clip(scene):
    """`mkt.scenes.sequence`.  Returns a `Sequence`."""
    return sequence(scene)


@lru_cache(maxsize=1024)
def run(tracker, scene, seed=0):
    """`mkt.tracking.track` over a scene, without the infos, whose particles would fill the memory.  Returns a `Track`."""
    return track(tracker, clip(scene), seed)._replace(info={})
