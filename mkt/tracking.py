"""What a tracker is, what it is shown, and what comes out of the loop.

`Tracker`, `Sequence`, `Track`; and the loop itself, `follow` and `track`.

A tracker is a frozen dataclass whose fields are the paper's parameters, with two pure
methods: ``init`` looks at the object once, ``step`` finds it again.  Nothing is hidden
in the tracker itself, so ``replace(tracker, n=75)`` is all that a slider for particles
has to do, any moment can be replayed, and the same seed gives the same run.

A `Sequence` is used in notebook 03.
"""

import reprlib
from collections.abc import Callable, Iterable, Iterator
from collections.abc import Sequence as Series
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, NamedTuple, Protocol

import numpy as np

from mkt.checks import (
    check_seed,
    checked_region,
    finite,
    in_words,
    is_truth,
    of_frames,
    of_kind,
    positive,
)
from mkt.regions import HX
from mkt.types import Array, ArrayLike, Frame, NDArray, Region, Regions, Rng

ALWAYS = ("region", "score", "lost")  # entries that no info can do without
NUMBERS = ("score", "evaluations", "steps")  # each is one, where it is there
LARGE = ("particles", "weights", "model")  # entries of an info that are kept on request
LAMBDA = 20.0  # printed, Section IV-B of [T09]

Info = dict[str, Any]
Progress = Callable[[int, int], None]  # called with frames done and frames in all


class Tracker(Protocol):
    """The one protocol of all trackers.

    The info of a step is a dict that `report` makes, with these keys:

    ===========  ==================================================================
    region       (5,) the estimate [px, rad]; its angle may be whole turns off
    distance     d_m of the estimate to what was learnt, in [0, 1]; NaN where a
                 tracker has none
    score        exp(-20 distance^2), (13) of [T09] read with the mean over kernels;
                 the same for all trackers (filters weigh with the sum)
    lost         whether the tracker says that the target is lost: for most where
                 the distance exceeds the field ``lost_above``
    evaluations  regions looked at, the cost that no machine changes
    covariance   (5, 5) of the particles about the estimate, where there are any
    n_eff        their effective sample size
    steps        those of its optimiser, where it has one
    particles    (N, 5) regions, after the prediction
    weights      (N,) of sum 1
    ===========  ==================================================================

    A tracker may add others, the same ones in every frame.

    One that reads a file, such as weights, has a method ``identity`` as a `Source` has.
    """

    def init(self, frame: Frame, region: Region, rng: Rng) -> Any:
        """Learn the object inside a region (5,) of a frame; return the first state."""
        ...

    def step(self, state: Any, frame: Frame, rng: Rng) -> tuple[Any, Info]:
        """Find the object in the next frame; return the next state and the info."""
        ...


@dataclass(frozen=True)
class Sequence:
    """Frames with what is known about the target in them.

    Parameters
    ----------
    name : str
    frames : series of T (H, W, 3) uint8 RGB images
        Indexable and iterable, made or decoded on demand.
    truth : (T, 5) array [px, rad]
        Regions, NaN where nothing is known.
    visibility : (T,) array
        The visible fraction of the target in [0, 1], NaN where nothing is known: a
        target whose region is known counts as seen there.
    source : str
        Where it comes from, for captions: "synthetic", or origin and licence.
    upright : bool
        The truth is an upright box: an orientation must not be scored against it.
    fps : float
        Frames a second.

    Raises
    ------
    ValueError
        For frames without a length or an index; where truth or visibility does not fit
        them, a true region has no area or is infinite, a visibility is no share, or the
        rate of frames is none.
    """

    name: str
    frames: Series
    truth: Regions
    visibility: Array
    source: str = "synthetic"
    upright: bool = False
    fps: float = 25.0

    def __post_init__(self):
        of_frames(self.frames)
        _check_shape("truth", self.truth, (len(self), 5))
        _check_shape("visibility", self.visibility, (len(self),))
        empty = np.flatnonzero((self.truth[:, HX:] <= 0).any(1))  # NaN is not
        if len(empty):
            raise ValueError(
                f"truth has a region without area in frame {empty[0]}; give half axes "
                "above 0, or NaN where the target is hidden or nothing is known"
            )
        infinite = np.flatnonzero(np.isinf(self.truth).any(1))
        if len(infinite):
            raise ValueError(
                f"truth is infinite in frame {infinite[0]}; give NaN where nothing is "
                "known"
            )
        positive(self, "fps")
        beyond = (self.visibility < 0) | (self.visibility > 1)  # NaN is not
        if beyond.any():
            raise ValueError(
                f"visibility has {float(self.visibility[beyond][0])} in it; "
                "a share lies between 0 and 1, and what is not known is NaN"
            )

    def __len__(self) -> int:
        return len(self.frames)

    def part(self, chosen: slice) -> "Sequence":
        """Some of its frames, with what is known about the target in them.

        Of every k-th frame there are so many less a second.

        Raises
        ------
        ValueError
            For what is no slice.
        """
        of_kind(chosen, slice, "chosen", "give a slice, such as slice(10, 50)")
        # No float is beyond 1e308, and no step beyond the length makes a difference.
        every = min(abs(chosen.step or 1), max(len(self), 1))
        frames, truth = self.frames[chosen], self.truth[chosen]
        visibility = self.visibility[chosen]
        fps = self.fps / every
        return replace(self, frames=frames, truth=truth, visibility=visibility, fps=fps)


def _check_shape(name: str, found: Any, wanted: tuple[int, ...]) -> None:
    """Refuse what is no array of numbers of the shape that the frames ask for."""
    of_kind(found, np.ndarray, name, f"give an array of the shape {wanted}")
    if isinstance(found, np.ma.MaskedArray):  # whose mask many functions drop
        raise ValueError(f"{name} is masked; give NaN where nothing is known")
    if found.dtype.kind not in "biuf":
        raise ValueError(f"{name} holds {found.dtype}; give numbers")
    if found.shape != wanted:
        boxes = "; mkt.regions.from_box makes regions of boxes" if wanted[1:] else ""
        raise ValueError(
            f"{name} has the shape {found.shape}; its frames ask for {wanted}, NaN "
            f"where nothing is known{boxes}"
        )


class Source(Protocol):
    """Whatever gives a sequence: a scene, a found benchmark, settings, the clip.

    Its runs are kept under its fields.  One that reads files has a further method,
    ``identity() -> str``, whose text takes their place: the fields, and a hash of what
    is in the files.  Without it, a changed file brings back the runs of the old one.
    """

    def sequence(self) -> Sequence:
        """The `Sequence`."""
        ...


class Track(NamedTuple):
    """What a tracker found, frame by frame; frame 0 is the region it was started on.

    Attributes
    ----------
    regions : (T, 5) array [px, rad]
        An angle may be whole turns away from that of the frame before, or of the truth:
        some trackers wrap it into [-pi, pi], others count on.  Compare angles by
        `mkt.regions.wrap_angle` of their difference, as `mkt.evaluation.errors` does;
        ``np.unwrap`` makes a curve of them.
    score : (T,) array
        Likelihoods of the estimates, 1 in frame 0.
    lost : (T,) bool array
    info : dict of (T, ...) arrays
        Every further entry of the infos; in frame 0, which no step has made, NaN, and
        an empty word where the others are words.
    """

    regions: Regions
    score: Array
    lost: NDArray
    info: dict[str, NDArray]


def report(
    region: Region,
    distance: float | Array,
    lost: bool,
    evaluations: float,
    **more: Any,
) -> Info:
    """The info of a step, see `Tracker`.

    Parameters
    ----------
    region : (5,) array [px, rad]
    distance : float
    lost : bool
    evaluations : float
    **more
        Further entries.

    Raises
    ------
    ValueError
        For an estimate that is not finite, and where `lost` is neither True nor False.
    """
    if not is_truth(lost[()] if isinstance(lost, np.ndarray) else lost):
        raise ValueError(f"lost is {reprlib.repr(lost)}; give True or False")
    return {
        "region": np.array(finite(region)),  # the caller's own, as all that follow
        "score": float(np.exp(-LAMBDA * distance**2)),
        "lost": bool(lost),
        "distance": float(distance),
        "evaluations": float(evaluations),
        **{name: _own(value) for name, value in more.items()},
    }


def _own(value: Any) -> Any:
    """An array that is the caller's and not the state's; anything else as it is."""
    return value.copy() if isinstance(value, np.ndarray) else value


def follow(
    tracker: Tracker,
    clip: Sequence,
    seed: int = 0,
    start: ArrayLike | None = None,
    progress: Progress | None = None,
) -> Iterator[Info]:
    """Run a tracker over a sequence and yield the info of each frame.

    Nothing is kept, so that a long video takes no more memory than a short one.

    Parameters
    ----------
    tracker : Tracker
    clip : Sequence
    seed : int
        Of the tracker's random numbers.
    start : (5,) array_like [px, rad], optional
        Where the target is in the first frame; the first true region by default.
    progress : callable, optional
        Called after every frame with the numbers of frames done and in all.

    Raises
    ------
    ValueError
        When there is no frame, or no region to start on; for a seed that is none; and
        whatever the tracker refuses.
    """
    check_tracker(tracker)
    of_kind(clip, Sequence, "clip", "give a Sequence, such as mkt.video(path, box)")
    if not len(clip):
        raise ValueError(f"{clip.name} has no frames, so there is nothing to follow")
    check_seed(seed)
    first = np.array(clip.truth[0], float) if start is None else checked_region(start)
    if not np.all(np.isfinite(first)):
        raise ValueError(
            f"{clip.name}: the first frame has no true region; "
            "pass start=(cx, cy, theta, hx, hy)"
        )
    rng = np.random.default_rng(seed)
    frames = iter(clip.frames)
    state = tracker.init(next(frames), first.copy(), rng)
    if progress:
        progress(1, len(clip))
    yield {"region": first.copy(), "score": 1.0, "lost": False}
    for done, frame in enumerate(frames, 2):
        state, info = checked_step(tracker, tracker.step(state, frame, rng))
        if progress:
            progress(done, len(clip))
        yield info


def check_tracker(tracker: Tracker) -> None:
    """Refuse what is no tracker, with a ValueError."""
    wanted = hasattr(tracker, "init") and hasattr(tracker, "step")
    if isinstance(tracker, type) or not wanted:
        raise ValueError(
            f"{tracker!r} is no tracker, which has the methods init and step; give an "
            "object such as mkt.SSD(), or mkt.TRACKERS[name]"
        )


def checked_step(tracker: Tracker, said: Any) -> tuple[Any, Info]:
    """What a step returned; ValueError where that is no state with an info."""
    name = f"{type(tracker).__name__}.step"
    pair = isinstance(said, tuple) and len(said) == 2 and isinstance(said[1], dict)
    if not pair:
        raise ValueError(
            f"{name} must return (state, info), and info is a dict that mkt.report "
            f"makes; it returned {reprlib.repr(said)}"
        )
    missing = [key for key in ALWAYS if key not in said[1]]
    if missing:
        raise ValueError(
            f"{name}: its info has no {missing[0]!r}; make it with mkt.report"
        )
    if trouble := _wrong(said[1]["region"]):
        raise ValueError(f"{name}: its region {trouble}")
    lost = said[1]["lost"]
    if not is_truth(lost):
        raise ValueError(f"{name}: its lost is {lost!r}; give True or False")
    for key in NUMBERS:
        value = said[1].get(key, 0)
        if np.ndim(value) or np.asarray(value).dtype.kind not in "biuf":
            raise ValueError(
                f"{name}: its {key} is {reprlib.repr(value)}; give a number"
            )
    # A copy, because a tracker may go on in the array that it has handed out.
    return said[0], said[1] | {"region": np.array(said[1]["region"], float)}


def _wrong(region: Any) -> str:
    """What is wrong with an estimate, empty where nothing is; it may be NaN."""
    shape = np.shape(region)
    if shape != (5,):
        return f"has the shape {shape}; give (cx, cy, theta, hx, hy)"
    numbers = np.asarray(region)
    if numbers.dtype.kind not in "iuf":
        return f"is {reprlib.repr(region)}; give five numbers"
    if (numbers[HX:] <= 0).any():
        return f"is {in_words(numbers)}, without area; give half axes above 0, or NaN"
    return ""


def track(
    tracker: Tracker,
    clip: Sequence,
    seed: int = 0,
    start: ArrayLike | None = None,
    keep: str | Series[str] = (),
    progress: Progress | None = None,
) -> Track:
    """All that `follow` yields, as a `Track` of the sequence's length.

    Parameters
    ----------
    tracker, clip, seed, start, progress
        As for `follow`, which also says what is refused.
    keep : str, or sequence of str
        Which of the large entries of the infos to keep: "particles", "weights",
        "model".

    Raises
    ------
    ValueError
        For another name to keep, and as `follow` does.
    """
    names = f"give names among {', '.join(LARGE)}, or leave it out"
    of_kind(keep, Iterable, "keep", names)
    kept = {keep} if isinstance(keep, str) else set(keep)
    if unknown := sorted(kept - set(LARGE)):
        raise ValueError(f"keep has {unknown[0]!r}; it takes {', '.join(LARGE)}")
    left_out = set(LARGE) - kept
    infos = [  # copies, because a tracker may go on in arrays that it has handed out
        {name: _own(value) for name, value in info.items() if name not in left_out}
        for info in follow(tracker, clip, seed, start, progress)
    ]
    columns = {name: _column(name, infos) for name in dict.fromkeys(chain(*infos))}
    regions, score = columns.pop("region"), columns.pop("score")
    return Track(regions, score, columns.pop("lost"), columns)


def _column(name: str, infos: list[Info]) -> NDArray:
    """One entry of all infos; NaN, or no word, in frames whose info has none."""
    given = [name in info for info in infos]
    values = [info[name] for info in infos if name in info]
    if len(shapes := {np.shape(value) for value in values}) > 1:
        raise ValueError(
            f"{name!r} of the infos has the shapes {sorted(shapes)}; it must have the "
            "same one in all frames"
        )
    values = np.array(values)
    if all(given):
        return values
    words = values.dtype.kind == "U"
    kind = values.dtype if words else np.result_type(values, float)
    column = np.full((len(infos), *values.shape[1:]), "" if words else np.nan, kind)
    column[given] = values
    return column
