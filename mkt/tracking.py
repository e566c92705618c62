"""What a tracker is, what it is shown, and what comes out: `Tracker`, `Sequence`, `Track`, and the loop: `follow`, `track`.

A tracker is a frozen dataclass whose fields are the paper's parameters, with two pure methods: ``init`` looks at the object once,
``step`` finds it again.  Nothing is hidden in the tracker itself, so ``replace(tracker, n=75)`` is all a particle slider has to do,
any moment can be replayed, and the same seed gives the same run.

A `Sequence` is used in notebook 03.
"""

from collections.abc import Sequence as Series
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

_listener = ContextVar("listener", default=lambda done, length: None)


class Tracker(Protocol):
    """The one protocol of all trackers.

    ``info`` is a dict with at least ``region`` (5,), ``score`` (the likelihood of the estimate, in [0, 1], NaN where a rival
    does not tell it) and ``lost`` (bool).
    """

    def init(self, frame: np.ndarray, region: np.ndarray, rng: np.random.Generator) -> Any:
        """Learn the object inside `region` (5,) of `frame` (H, W, 3); return the first state."""

    def step(self, state: Any, frame: np.ndarray, rng: np.random.Generator) -> tuple[Any, dict]:
        """Find the object in the next frame; return the next state and the info."""


@dataclass(frozen=True)
class Sequence:
    """Frames with what is known about the target in them.

    frames: T images (H, W, 3) uint8 RGB, indexable and iterable, made or decoded on demand.
    truth: (T, 5) regions [px, rad], NaN where nothing is known.
    visibility: (T,) the visible fraction of the target in [0, 1], NaN where nothing is known.
    source: where it comes from, for captions ("synthetic", or origin and licence).
    upright: the truth is an upright box, so an orientation must not be scored against it.
    """

    name: str
    frames: Series
    truth: np.ndarray
    visibility: np.ndarray
    source: str = "synthetic"
    upright: bool = False
    fps: float = 25.0

    def __len__(self):
        return len(self.frames)


class Track(NamedTuple):
    """What a tracker said, frame by frame; frame 0 is the region it was started on.

    regions: (T, 5) [px, rad]; score: (T,) likelihoods; lost: (T,) bool; info: every further entry of the infos, one list each.
    """

    regions: np.ndarray
    score: np.ndarray
    lost: np.ndarray
    info: dict[str, list]


def check_counts(tracker, *fields):
    """Raise ValueError naming the first of these fields of a tracker that is not a whole number of at least 1."""
    for field in fields:
        value = getattr(tracker, field)
        if not (isinstance(value, (int, np.integer)) and value >= 1):
            raise ValueError(f"{field} is {value!r}; it must be a whole number, at least 1")


def finite(region):
    """An estimate (5,), as it is.  Raises ValueError where it is not finite, which no later step could mend."""
    if not np.isfinite(region).all():
        raise ValueError(f"the estimate {region} is not finite; check the state and the tracker's motion, and start it again with init")
    return region


def report(region, distance, lost_above, **more):
    """The info of a step: the estimate (5,), its likelihood exp(-20 d^2) with lambda as printed in [T09], whether it is lost, and more.

    Raises ValueError for an estimate that is not `finite`.
    """
    return {"region": finite(region), "score": float(np.exp(-20 * distance**2)), "distance": float(distance), "lost": bool(distance > lost_above), **more}


def follow(tracker, sequence, seed=0, start=None):
    """Run a tracker over a sequence, started on the first true region or on `start` (5,), and yield the info of each frame.

    Nothing is kept, so that a long video takes no more memory than a short one.
    Raises ValueError when there is no region to start on.
    """
    start = sequence.truth[0] if start is None else np.asarray(start, float)
    if not np.all(np.isfinite(start)):
        raise ValueError(f"{sequence.name}: the first frame has no true region; pass start=(cx, cy, theta, hx, hy)")
    rng, frames, tell = np.random.default_rng(seed), iter(sequence.frames), _listener.get()
    state = tracker.init(next(frames), start, rng)
    yield {"region": start, "score": 1.0, "lost": False}
    for done, frame in enumerate(frames, 2):
        state, info = tracker.step(state, frame, rng)
        tell(done, len(sequence))
        yield info


@contextmanager
def heard(listener):
    """For a while, call listener(frames done, frames in all) after every frame that any tracker follows: for a bar that shows how far it is."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


def track(tracker, sequence, seed=0, start=None):
    """All that `follow` yields, with the same arguments, as a `Track` of the sequence's length."""
    infos = list(follow(tracker, sequence, seed, start))
    columns = {key: [info.get(key) for info in infos] for key in infos[-1]}
    return Track(np.array(columns.pop("region"), float), np.array(columns.pop("score"), float), np.array(columns.pop("lost"), bool), columns)
