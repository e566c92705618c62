"""Runs that figures show: each is made once for a state of the library.

So figures 6 and 7 of [T09] draw one and the same run, a slider runs only the trackers
that it changes, and the book, its tests and the next day's work find what is there.
The arrays of a run are read-only, because all who ask for it share them.
"""

from functools import lru_cache

import numpy as np

from mkt.checks import locked
from mkt.experiments import cache, dependencies
from mkt.figures.registry import listener
from mkt.servoing import loop
from mkt.servoing.loop import Experiment, Run, close_loop
from mkt.tracking import Sequence, Source, Track, Tracker, track

FIELDS = ("regions", "score", "lost")
TRACKS = cache.Shelf("tracks", ".npz", cache.arrays_as_bytes, cache.arrays_of)
LOOPS = cache.Shelf("loops", ".npz", cache.arrays_as_bytes, cache.arrays_of)


@lru_cache(maxsize=64)
def clip(source: Source) -> Sequence:
    """The `Sequence` of a source, made once; nobody may write to what it knows."""
    made = source.sequence()
    for known in (made.truth, made.visibility):
        locked(known)
    return made


@lru_cache(maxsize=64)
def run(
    tracker: Tracker, source: Source, seed: int = 0, keep: tuple[str, ...] = ()
) -> Track:
    """`mkt.tracking.track` of a tracker on a source, kept on disk.

    Parameters
    ----------
    tracker, source
    seed : int
        Of the tracker's random numbers.
    keep : tuple of str
        Which large entries of the infos are wanted, see `mkt.tracking.track`.
    """

    def make() -> dict[str, np.ndarray]:
        made = track(tracker, clip(source), seed, keep=keep, progress=listener())
        columns = {name: getattr(made, name) for name in FIELDS}
        return columns | {f"info {name}": a for name, a in made.info.items()}

    code = dependencies.code_of(tracker, source)
    origin = cache.identity(source)
    key = cache.key(tracker, origin, seed, sorted(keep), code)
    known = None not in (code, origin, key)
    columns = TRACKS.kept(key, make) if known else make()
    columns = {name: locked(column) for name, column in columns.items()}
    names = [name for name in columns if name not in FIELDS]
    info = {name.removeprefix("info "): columns[name] for name in names}
    return Track(columns["regions"], columns["score"], columns["lost"], info)


def regions(
    trackers: list[Tracker], source: Source, seeds: range | tuple[int, ...] = (0,)
) -> np.ndarray:
    """The regions (len(trackers), len(seeds), T, 5) that trackers find in a source."""
    return np.array(
        [[run(one, source, seed).regions for seed in seeds] for one in trackers]
    )


@lru_cache(maxsize=512)
def loop_run(experiment: Experiment, until_lost: bool = False) -> Run:
    """`mkt.servoing.loop.close_loop` of an experiment, kept on disk.

    A run that keeps the target in view is the same one with `until_lost` and without,
    and is made once for both.

    Parameters
    ----------
    experiment : Experiment
    until_lost : bool
        Whether a run that gets out of control is cut short, rather than refused.
    """
    if not until_lost:
        seen = loop_run(experiment, until_lost=True)
        if len(seen.times) == experiment.frames:
            return seen

    def make() -> dict[str, np.ndarray]:
        return close_loop(experiment, until_lost)._asdict()

    code = dependencies.code_of(loop, experiment)
    key = cache.key(experiment, until_lost, code)
    made = make() if None in (code, key) else LOOPS.kept(key, make)
    return Run(**{name: locked(history) for name, history in made.items()})
