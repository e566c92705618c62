"""Rivals: the trackers that OpenCV brings along, under our protocol, for comparison only.

* `MIL`, boosting over rectangle features with multiple instances.  The box keeps its size and stays upright.
* `MeanShift`, to the centre of mass of the hue histogram's back-projection.  The box keeps its size and stays upright.
* `CamShift`, the same, followed by the ellipse of the second moments: size and angle too.

The wheel of OpenCV 5 has no KCF and no CSRT, so the stronger rivals one reads about cannot be run here.  OpenCV tells of no likelihood:
MIL's score is NaN, that of the other two is how probable the hues inside the window are.
"""

import ctypes
import os
from dataclasses import dataclass
from typing import Any, NamedTuple

import cv2
import numpy as np

from mkt.histograms import checked_frame
from mkt.regions import HX, HY, THETA, checked, corners, from_box, to_box
from mkt.tracking import check_counts, finite

SMALLEST = 8  # px; in a box of 4 OpenCV's MIL looks for a feature for ever
STOP = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 1)  # steps, px
FAR = 1e4  # px beyond which OpenCV is not asked to draw


class MILState(NamedTuple):
    """OpenCV's tracker, which every step changes; the last estimate (5,); the shape (H, W, 3) that all frames must have."""

    tracker: Any
    region: np.ndarray
    shape: tuple[int, int, int]


@dataclass(frozen=True)
class MIL:
    """cv2.TrackerMIL with its own parameters.

    The state holds OpenCV's object, and a step changes it: a state cannot be stepped from twice, nor replayed or pickled.  A whole run
    does repeat itself for a seed (on Windows untested).  OpenCV says that the target is lost only when it finds no place to look at, so
    not when a wall hides it.
    """

    def init(self, frame, region, rng):
        """Learn the upright box round the region.  Returns `MILState`.  Raises ValueError when OpenCV cannot learn from it."""
        frame = checked_frame(frame)
        box = _window(frame, checked(region))
        if min(box[2:]) < SMALLEST:
            raise ValueError(f"the box has {box[2]}x{box[3]} px inside the image, but MIL needs {SMALLEST}x{SMALLEST}; choose a larger one")
        # The features are drawn by the C library's rand(), all else by OpenCV's generator.
        ctypes.CDLL("ucrtbase" if os.name == "nt" else None).srand(int(rng.integers(2**31)))
        cv2.setRNGSeed(int(rng.integers(2**31)))
        tracker = cv2.TrackerMIL.create()
        try:
            tracker.init(frame, box)
        except cv2.error:
            raise ValueError(f"MIL cannot learn from the box {box}: it needs background round it; choose a smaller one") from None
        return MILState(tracker, from_box(box), frame.shape)

    def step(self, state, frame, rng):
        """Let OpenCV find the box; NaN for the score and the cost, of which it does not tell.  Raises ValueError for a frame of another size."""
        frame = checked_frame(frame)
        if frame.shape != state.shape:  # in a smaller one OpenCV asks for endless memory
            raise ValueError(f"the frame has the shape {frame.shape}, but MIL was started on {state.shape}; bring all frames to one size")
        cv2.setRNGSeed(int(rng.integers(2**31)))
        found, box = state.tracker.update(frame)
        region = from_box(box) if found else state.region
        return state._replace(region=region), {"region": region, "score": np.nan, "lost": not found, "evaluations": np.nan}


class ShiftState(NamedTuple):
    """The histogram of hues (bins,), scaled to a maximum of 255; the window (left, top, width, height) int [px]; the last estimate (5,);
    the score of the first look."""

    hues: np.ndarray
    window: tuple[int, int, int, int]
    region: np.ndarray
    first: float


@dataclass(frozen=True)
class MeanShift:
    """cv2.meanShift on the back-projection of the hues.

    bins: of hue; s_min, v_min: saturation and value [0, 255] below which a pixel counts as having no hue.
    lost_below: the share of the first look's score below which the target is said to be lost.

    Raises ValueError naming the field.
    """

    bins: int = 16
    s_min: int = 60
    v_min: int = 32
    lost_below: float = 0.3  # ours

    def __post_init__(self):
        check_counts(self, "bins")

    def init(self, frame, region, rng):
        """Learn the hues inside the region.  Returns `ShiftState`.  Raises ValueError when it has none, or lies outside the image."""
        frame, region = checked_frame(frame), checked(region)
        window = _window(frame, region)
        hsv = cv2.cvtColor(frame, cv2.COLOR_RGB2HSV)
        inside = cv2.fillConvexPoly(np.zeros(frame.shape[:2], np.uint8), np.rint(corners(region)).clip(-FAR, FAR).astype(np.int32), 255)
        hues = cv2.calcHist([hsv], [0], inside & self._colorful(hsv), [self.bins], [0, 180]).ravel()
        if not hues.any():
            raise ValueError("the box has no colourful pixel, but MeanShift and CamShift go by hue; choose another box or another tracker")
        hues *= 255 / hues.max()
        return ShiftState(hues, window, region, _mean(self._projection(frame, hues), window))

    def step(self, state, frame, rng):
        """Shift the window.  The cost is the number of windows looked at, as far as OpenCV tells it."""
        projection = self._projection(checked_frame(frame), state.hues)
        window, region, evaluations = self._search(projection, state)
        score = _mean(projection, window)
        info = {"region": region, "score": score, "lost": bool(score < self.lost_below * state.first), "evaluations": evaluations}
        return state._replace(window=window, region=region), info

    def _search(self, projection, state):
        """The next window, the region (5,) it stands for, and the cost."""
        steps, window = cv2.meanShift(projection, state.window, STOP)
        return window, from_box(window), steps

    def _projection(self, frame, hues):
        """How probable the hue of each pixel is, (H, W) uint8, 0 where it has none."""
        hsv = cv2.cvtColor(frame, cv2.COLOR_RGB2HSV)
        return cv2.calcBackProject([hsv], [0], hues, [0, 180], 1) & self._colorful(hsv)

    def _colorful(self, hsv):
        return cv2.inRange(hsv, (0, self.s_min, self.v_min), (180, 255, 255))


@dataclass(frozen=True)
class CamShift(MeanShift):
    """cv2.CamShift on the same back-projection; the parameters are those of `MeanShift`."""

    def _search(self, projection, state):
        (centre, (width, height), degrees), window = cv2.CamShift(projection, state.window, STOP)
        if min(width, height) < 1:  # no probable pixel in reach
            return state.window, state.region, np.nan
        region = np.array([*centre, np.radians(degrees), width / 2, height / 2])
        return window, _like(region, finite(state.region)[THETA]), np.nan


def _window(frame, region):
    """The upright box round a region (5,), cut at the border of the image: left, top, width, height int [px]."""
    x, y, w, h = to_box(region)
    left, right = np.clip(np.rint([x, x + w]), 0, frame.shape[1]).astype(int).tolist()
    top, bottom = np.clip(np.rint([y, y + h]), 0, frame.shape[0]).astype(int).tolist()
    if left == right or top == bottom:
        raise ValueError(f"the region {np.round(region, 1)} lies outside the image; choose a box inside it")
    return left, top, right - left, bottom - top


def _mean(projection, window):
    """Mean of the back-projection in a window, in [0, 1]; what of the window lies outside the image counts as improbable."""
    x, y, w, h = window
    return float(projection[y:y + h, x:x + w].sum() / (255 * w * h))


def _like(region, theta):
    """The same rectangle, of its four descriptions (5,) the one whose angle is nearest to theta [rad]."""
    quarters = round((theta - region[THETA]) / (np.pi / 2))
    region[THETA] += quarters * np.pi / 2
    if quarters % 2:
        region[[HX, HY]] = region[[HY, HX]]
    return region
