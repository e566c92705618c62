"""How well a track fits the truth: overlap and errors of a frame, then the numbers that benchmarks make of a whole run.

* `true_positives`, (19) of [C14]: the share of frames whose overlap exceeds T_lim, with or without the frames in which the target is hidden;
* `success`, as OTB draws it: that share for every T_lim; its mean is the area under the curve;
* `restarted`, `accuracy` and `robustness`, as VOT measures: a tracker that fails is started again, and its failures are counted.

Everywhere a frame is judged in which the target is seen, the first one excepted, where the tracker was told.  Overlaps of frames that are
not judged are NaN.  Overlap and errors are explained in notebook 02, the rest in notebook 14.
"""

from typing import NamedTuple

import numpy as np
import shapely

from mkt.regions import area, corners, from_box, to_box, wrap_angle

HIT = 0.2  # printed, Section 4 of [C14]: T_lim, the overlap above which a frame counts as a true positive
SEEN = 0.5  # visible fraction above which a frame is judged
LIMITS = np.linspace(0, 1, 21)  # of the success curve, as in OTB
PAUSE, BURN_IN = 5, 10  # frames, as in VOT: from a failure to the next start; after each start, too easy to count for the accuracy


class Errors(NamedTuple):
    """Errors of regions against the truth, one array (...) each: position [px], orientation [rad, in [0, pi]], scale as the logarithm
    of the ratio of sizes, 0 where they agree, NaN where the truth is."""

    position: np.ndarray
    orientation: np.ndarray
    scale: np.ndarray


def overlap(regions, truth, upright=False):
    """Area of the intersection over area of the union, (19) of [C14], of rotated rectangles.

    regions, truth: (..., 5) [px, rad]; upright: compare the upright boxes round them, for truths without an orientation.
    Returns (...) in [0, 1], NaN where either is not finite.

    >>> overlap([50, 40, 0, 20, 10], [[50, 40, 0, 20, 10], [70, 40, 0, 20, 10], [50, 40, 0, 10, 10]]).round(3)  # the same; half beside it; half of it
    array([1.   , 0.333, 0.5  ])
    """
    regions, truth = np.broadcast_arrays(np.asarray(regions, float), np.asarray(truth, float))
    known = np.isfinite(regions).all(-1) & np.isfinite(truth).all(-1)
    if upright:
        regions, truth = from_box(to_box(regions)), from_box(to_box(truth))
    a, b = (shapely.polygons(corners(r[known])) for r in (regions, truth))
    result = np.full(known.shape, np.nan)
    result[known] = shapely.area(shapely.intersection(a, b)) / shapely.area(shapely.union(a, b))
    return result


def errors(regions, truth):
    """Errors in position, orientation and scale.

    regions, truth: (..., 5) [px, rad].  Returns `Errors`.
    """
    regions, truth = np.asarray(regions, float), np.asarray(truth, float)
    return Errors(
        np.linalg.norm(regions[..., :2] - truth[..., :2], axis=-1),
        np.abs(wrap_angle(regions[..., 2] - truth[..., 2])),
        0.5 * np.log(area(regions) / area(truth)),
    )


def judged(sequence):
    """Which frames of a `Sequence` count: those in which the target is seen, without the first one.  Returns (T,) bool."""
    seen = sequence.visibility > SEEN
    seen[0] = False
    return seen


def overlaps(regions, sequence):
    """Overlap in all frames but the first, NaN where the target is hidden, 0 where the tracker gave no region.

    regions: (..., T, 5) [px, rad], of one or more runs over the `Sequence`.  Returns (..., T - 1) in [0, 1].
    """
    iou = np.nan_to_num(overlap(regions, sequence.truth, sequence.upright))
    return np.where(judged(sequence), iou, np.nan)[..., 1:]


def true_positives(iou, limit=HIT, hidden=False):
    """Share of frames whose overlap exceeds T_lim, (19) of [C14].

    iou: (..., T) of `overlaps`; hidden: divide by all frames, as [C14] does, although no tracker can score where there is no truth; else
    by those in which the target is seen.  Returns (...) in [0, 1], NaN where there is no frame to divide by.
    """
    frames = np.full(np.shape(iou)[:-1], np.shape(iou)[-1]) if hidden else np.isfinite(iou).sum(-1)
    return np.sum(iou > limit, -1) / np.where(frames > 0, frames, np.nan)


def success(iou, limits=LIMITS):
    """The success curve of OTB: the share of seen frames whose overlap exceeds each limit.

    iou: (..., T) of `overlaps`; limits: (L,).  Returns (..., L).  Its mean over the limits is what OTB calls the area under the curve; a
    perfect track has 20 / 21, for no overlap exceeds 1.
    """
    return np.stack([true_positives(iou, limit) for limit in limits], -1)


class Restarted(NamedTuple):
    """A run with restarts: the overlap (T,), NaN where nothing was judged, and the frames of the starts and of the failures."""

    overlap: np.ndarray
    starts: list[int]
    failures: list[int]


def restarted(tracker, sequence, seed=0):
    """Run a tracker as VOT does: where it misses a visible target altogether, it has failed, and is started again on the truth.

    That is five frames later, or as soon after as the target is seen.  Returns `Restarted`.
    """
    rng, state, ready = np.random.default_rng(seed), None, 0
    run, seen = Restarted(np.full(len(sequence), np.nan), [], []), sequence.visibility > SEEN
    for k, frame in enumerate(sequence.frames):
        if state is not None:
            state, info = tracker.step(state, frame, rng)
            run.overlap[k] = overlap(info["region"], sequence.truth[k], sequence.upright) if seen[k] else np.nan
            if run.overlap[k] == 0:
                state, ready = None, k + PAUSE
                run.failures.append(k)
        elif k >= ready and seen[k]:
            state = tracker.init(frame, sequence.truth[k], rng)
            run.starts.append(k)
    return run


def accuracy(run):
    """Mean overlap of a `Restarted` run, without its failures and the ten frames from each start on; NaN where nothing is left."""
    iou = run.overlap.copy()
    iou[run.failures] = np.nan
    for start in run.starts:
        iou[start:start + BURN_IN] = np.nan
    return float(np.nanmean(iou)) if np.isfinite(iou).any() else np.nan


def robustness(run, span=100):
    """How probable it is to go `span` frames without a failure, exp(-span F / T), F failures of a `Restarted` run in T frames."""
    return float(np.exp(-span * len(run.failures) / len(run.overlap)))
