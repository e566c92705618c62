"""How well a track fits the truth.

Overlap and errors for each frame, then the numbers that benchmarks make of a whole run:

* `true_positives`, (19) of [C14]: the share of frames whose overlap exceeds T_lim, with
  or without the frames in which the target is hidden;
* `success`, as OTB draws it: that share for every T_lim; its mean is the area under the
  curve;
* `restarted`, `accuracy` and `robustness`, as VOT measures: a tracker that fails is
  started again, and its failures are counted;
* `evaluate`: all numbers of a run at once.

A frame is scored if the target is seen in it, except for the first frame, in which the
tracker was told the region.  Every series over frames has the length T of the sequence,
and is NaN in frames that are not scored.  Overlap and errors are explained in notebook
02, the rest in notebook 14.
"""

import reprlib
from typing import NamedTuple

import numpy as np
import shapely

from mkt.checks import are_finite, check_seed, of_kind
from mkt.regions import HX, area, as_regions, corners, from_box, to_box, wrap_angle
from mkt.tracking import Sequence, Track, Tracker, check_tracker, checked_step
from mkt.types import Array, ArrayLike, NDArray

HIT = 0.2  # Section 4 of [C14]: T_lim, more than this overlap for a true positive
SEEN = 0.5  # visible fraction above which a frame is scored
LIMITS = np.linspace(0, 1, 21)  # of the success curve, as in OTB
PAUSE = 5  # frames from a failure to the next start, as in VOT
BURN_IN = 10  # frames after a start that are too easy for the accuracy, as in VOT
TURNED = 45.0  # [deg] beyond this the orientation is not the target's
SHRUNK = 0.5  # share of the true area below which a region has shrunk
SNAP, FAR = 1e-9, 1e9  # px
JUDGED = (  # of `evaluate`
    "overlap",
    "hits",
    "hits_of_all",
    "area",
    "position",
    "orientation",
    "scale",
    "shrunk",
    "lost",
    "failed",
    "silent",
    "false_alarms",
)
LAST = 10  # frames that say whether a target was lost in the end


class Errors(NamedTuple):
    """Errors of regions against the truth, NaN where one of the two is.

    Attributes
    ----------
    position : (...) array [px]
    orientation : (...) array [rad]
        In [0, pi].
    scale : (...) array
        Logarithm of the ratio of sizes, 0 where they agree, and infinite where one
        has no area.
    """

    position: Array
    orientation: Array
    scale: Array


def overlap(regions: ArrayLike, truth: ArrayLike, upright: bool = False) -> Array:
    """Area of the intersection over area of the union of rotated rectangles.

    Equation (19) of [C14].

    Parameters
    ----------
    regions, truth : (..., 5) array_like [px, rad]
        What lies beyond 1e9 px is not seen to overlap.
    upright : bool
        Compare the upright boxes round them, for truths without an orientation.

    Returns
    -------
    (...) array in [0, 1]
        NaN where either is not finite or has a negative half axis, 0 where neither has
        an area.

    Examples
    --------
    The same region; one that lies half beside it; one that is half of it.

    >>> truth = [[50, 40, 0, 20, 10], [70, 40, 0, 20, 10], [50, 40, 0, 10, 10]]
    >>> overlap([50, 40, 0, 20, 10], truth).round(3)
    array([1.   , 0.333, 0.5  ])
    """
    found, true = np.asarray(regions, float), np.asarray(truth, float)
    found, true = np.broadcast_arrays(found, true)
    known = np.isfinite(found).all(-1) & np.isfinite(true).all(-1)
    known &= (np.minimum(found, true)[..., HX:] >= 0).all(-1)  # none is mirrored
    if upright:
        found, true = from_box(to_box(found)), from_box(to_box(true))
    found, true = found[known], true[known]
    a, b = (shapely.polygons(corners(r).clip(-FAR, FAR)) for r in (found, true))
    # Without a grid to snap to, nearly collinear sides may be taken for disjoint ones.
    common = shapely.area(shapely.intersection(a, b, grid_size=SNAP))
    union = area(found) + area(true) - common
    shared = np.divide(common, union, out=np.zeros_like(common), where=union > 0)
    result = np.full(known.shape, np.nan)
    result[known] = np.minimum(shared, 1)  # of a millionth of a pixel it is rounded
    return result


def errors(regions: ArrayLike, truth: ArrayLike) -> Errors:
    """Errors in position, orientation and scale.

    Parameters
    ----------
    regions, truth : (..., 5) array_like [px, rad]
    """
    found, true = np.asarray(regions, float), np.asarray(truth, float)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 0.5 * np.log(area(found) / area(true))
    return Errors(
        np.linalg.norm(found[..., :2] - true[..., :2], axis=-1),
        np.abs(wrap_angle(found[..., 2] - true[..., 2])),
        scale,
    )


def scored_frames(clip: Sequence) -> NDArray:
    """Which frames of a clip count, (T,) bool: after frame 0, if the target is seen.

    That is where its true region is known, and nothing says that too little of it is
    visible.
    """
    scored = _seen(clip)
    scored[:1] = False
    return scored


def _seen(clip: Sequence) -> NDArray:
    hidden = clip.visibility <= SEEN  # NaN says nothing
    return ~hidden & np.isfinite(clip.truth).all(-1)


def overlaps(regions: ArrayLike, clip: Sequence) -> Array:
    """Overlap in the scored frames, 0 where the tracker gave no region.

    Parameters
    ----------
    regions : (..., T, 5) array_like [px, rad]
        Of one or more runs over the sequence.
    clip : Sequence

    Returns
    -------
    (..., T) array in [0, 1]
        NaN in frame 0 and where the target is hidden.

    Raises
    ------
    ValueError
        For another number of regions than the sequence has frames.
    """
    regions = as_regions(regions)
    if regions.ndim < 2 or regions.shape[-2] != len(clip):
        raise ValueError(
            f"regions has the shape {regions.shape}; give one region for each of the "
            f"{len(clip)} frames, (..., {len(clip)}, 5)"
        )
    iou = np.nan_to_num(overlap(regions, clip.truth, clip.upright))
    return np.where(scored_frames(clip), iou, np.nan)


def true_positives(iou: ArrayLike, limit: float = HIT, hidden: bool = False) -> Array:
    """Share of frames whose overlap exceeds T_lim, (19) of [C14].

    Parameters
    ----------
    iou : (..., T) array_like
        Of `overlaps`.
    limit : float
        T_lim.
    hidden : bool
        Divide by all frames but the first, as the printed fractions of [C14] suggest,
        although no tracker can score where there is no truth; else by those in which
        the target is seen.

    Returns
    -------
    (...) array in [0, 1]
        NaN where there is no frame to divide by.

    Raises
    ------
    ValueError
        For several limits, which `success` takes, for one that is not a finite number,
        and for one overlap alone.
    """
    if np.ndim(limit):
        raise ValueError("limit is one number; `success` takes several")
    if not are_finite(limit):
        raise ValueError(f"limit is {limit!r}; give a number from 0 to 1")
    iou = np.asarray(iou, float)
    if not iou.ndim:
        raise ValueError(f"iou is {iou}; give the overlap of every frame, as a series")
    every = np.full(iou.shape[:-1], iou.shape[-1] - 1)
    frames = every if hidden else np.isfinite(iou).sum(-1)
    hits = iou[..., int(hidden) :] > limit  # the start, which was given, is no hit
    return np.sum(hits, -1) / np.where(frames > 0, frames, np.nan)


def success(iou: ArrayLike, limits: ArrayLike = LIMITS) -> Array:
    """The success curve of OTB: the share of seen frames that exceed each limit.

    Its mean over the limits is what OTB calls the area under the curve; a perfect track
    has 20 / 21, because no overlap exceeds 1.

    Parameters
    ----------
    iou : (..., T) array_like
        Of `overlaps`.
    limits : (L,) array_like

    Returns
    -------
    (..., L) array

    Raises
    ------
    ValueError
        For limits that are not a series of finite numbers, and for one overlap alone.
    """
    if not are_finite(limits, None):
        raise ValueError(
            f"limits is {reprlib.repr(limits)}; give a list of finite numbers, such as "
            "[0.5], or one number to `true_positives`"
        )
    return np.stack([true_positives(iou, limit) for limit in np.asarray(limits)], -1)


def evaluate(track: Track, clip: Sequence) -> dict[str, float]:
    """What a track is worth on its sequence, over the scored frames.

    Returns
    -------
    dict of float
        overlap : mean.
        hits, hits_of_all : the share of true positives, out of the frames in which the
        target is seen, and out of all frames, hidden ones too.
        area : under the success curve.
        position [px], orientation [deg], scale [log] : means without sign.
        shrunk : the share of frames with less than half of the true area.
        These four are of the frames that have an estimate, NaN without any; the
        orientation is NaN where the truth is upright.
        lost, failed : 1 when none of the last ten scored frames is a hit, or none is a
        hit whose orientation is right to 45 degrees.
        silent, false_alarms : the share of the misses in which the tracker did not say
        "lost", and the share of the hits in which it did; NaN without misses or without
        hits.
        All are NaN where no frame was scored.

    Raises
    ------
    ValueError
        For what is no track or no sequence, and for two of different lengths.
    """
    of_kind(track, Track, "track", "give what mkt.track(tracker, clip) returns")
    of_kind(clip, Sequence, "clip", "give the sequence that the track was made on")
    if len(track.regions) != len(clip):
        raise ValueError(
            f"the track has {len(track.regions)} frames, but {clip.name} has "
            f"{len(clip)}; give the sequence that it was made on"
        )
    every = overlaps(track.regions, clip)
    scored = scored_frames(clip)
    if not scored.any():
        return dict.fromkeys(JUDGED, np.nan)
    iou = every[scored]
    off = errors(track.regions[scored], clip.truth[scored])
    degrees = np.rad2deg(off.orientation)
    hit = iou > HIT
    said = np.asarray(track.lost, bool)[scored]
    right = hit & (clip.upright | (degrees <= TURNED))
    given = np.isfinite(track.regions[scored]).all(-1)
    numbers = {
        "overlap": np.mean(iou),
        "hits": true_positives(every),
        "hits_of_all": true_positives(every, hidden=True),
        "area": np.mean(success(every)),
        "position": mean_of(off.position[given]),
        "orientation": np.nan if clip.upright else mean_of(degrees[given]),
        "scale": mean_of(np.abs(off.scale[given])),
        "shrunk": mean_of(np.exp(2 * off.scale[given]) < SHRUNK),
        "lost": not hit[-LAST:].any(),
        "failed": not right[-LAST:].any(),
        "silent": mean_of(~said[~hit]),
        "false_alarms": mean_of(said[hit]),
    }
    return {name: float(value) for name, value in numbers.items()}


def mean_of(values: NDArray) -> float:
    """The mean of values (n,), NaN where there are none."""
    return float(np.mean(values)) if len(values) else np.nan


class Restarted(NamedTuple):
    """A run with restarts.

    Attributes
    ----------
    overlap : (T,) array
        NaN where nothing was judged.
    starts, failures : list of int
        The frames in which the tracker was started, and in which it failed.
    """

    overlap: Array
    starts: list[int]
    failures: list[int]


def restarted(tracker: Tracker, clip: Sequence, seed: int = 0) -> Restarted:
    """Run a tracker as VOT does: after a failure it is started again on the truth.

    It has failed where it misses a visible target altogether, or gives no region; it is
    started five frames later, or as soon after as the target is seen and the tracker
    takes it.

    Raises
    ------
    ValueError
        Where the tracker refuses its first start, and for what is no tracker, no
        `Sequence` or no seed.
    """
    check_tracker(tracker)
    of_kind(clip, Sequence, "clip", "give a Sequence, such as mkt.video(path, box)")
    check_seed(seed)
    rng = np.random.default_rng(seed)
    seen = _seen(clip)
    run = Restarted(np.full(len(clip), np.nan), [], [])
    state, running, ready = None, False, 0
    for k, frame in enumerate(clip.frames):
        if running:
            state, info = checked_step(tracker, tracker.step(state, frame, rng))
            if seen[k]:
                iou = overlap(info["region"], clip.truth[k], clip.upright)
                run.overlap[k] = np.nan_to_num(iou)
            if run.overlap[k] == 0:
                running = False
                ready = k + PAUSE
                run.failures.append(k)
        elif k >= ready and seen[k]:
            try:
                state = tracker.init(frame, np.array(clip.truth[k], float), rng)
            except ValueError:  # such as a target that is half outside the image
                if not run.starts:
                    raise
                continue
            running = True
            run.starts.append(k)
    return run


def accuracy(run: Restarted) -> float:
    """Mean overlap of a run with restarts, NaN where nothing is left to judge.

    Its failures do not count, nor do the ten frames from each start on.
    """
    iou = run.overlap.copy()
    iou[run.failures] = np.nan
    for start in run.starts:
        iou[start : start + BURN_IN] = np.nan
    return float(np.nanmean(iou)) if np.isfinite(iou).any() else np.nan


def robustness(run: Restarted, span: int = 100) -> float:
    """The score exp(-span F / T) of F failures in T frames.

    How probable it would be to go `span` frames without one, if they came at random and
    equally often everywhere.  NaN where no frame let the tracker start.
    """
    if not run.starts:
        return np.nan
    return float(np.exp(-span * len(run.failures) / len(run.overlap)))
