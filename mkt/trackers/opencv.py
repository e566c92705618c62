"""Rivals: the trackers that OpenCV brings along, for comparison only.

They follow our protocol.

* `MIL`, boosting over rectangle features with multiple instances.  The box keeps its
  size and stays upright.
* `MeanShift`, to the centre of mass of the back-projected histogram of hues.  The box
  keeps its size and stays upright.
* `CamShift`, the same, followed by the ellipse of the second moments: size and angle
  too.

The wheel of OpenCV 5 has no KCF and no CSRT, so the stronger rivals that one reads
about cannot be run here.  MIL gives no likelihood, so its distance and score are NaN.
"""

import ctypes
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import cv2
import numpy as np

from mkt import checks
from mkt.checks import checked_frame, checked_region, finite, in_words
from mkt.colors import HUES
from mkt.regions import HX, HY, THETA, corners, from_box, outside, to_box
from mkt.tracking import Info, report
from mkt.types import Frame, NDArray, Region, Rng

SMALLEST = 8  # px; in a box of 4 OpenCV's MIL looks for a feature for ever
STOP = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 1)  # steps, px
FAR = 1e4  # px beyond which OpenCV is not asked to draw

Window = Sequence[int]  # left, top, width, height [px]


class MILState(NamedTuple):
    """What is carried from frame to frame.

    Attributes
    ----------
    tracker : cv2.TrackerMIL
        OpenCV's own, which every step changes.
    region : (5,) array [px, rad]
        The last estimate.
    shape : (H, W, 3)
        The shape that all frames must have.
    """

    tracker: Any
    region: Region
    shape: tuple[int, ...]


@dataclass(frozen=True)
class MIL:
    """cv2.TrackerMIL with its own parameters.

    The state holds OpenCV's object, and a step changes it: a state cannot be stepped
    from twice, nor replayed or pickled.  A whole run does repeat itself for a seed, in
    one thread, for all threads share OpenCV's random numbers (on Windows untested).
    OpenCV says that the target is lost only when it finds no place to look at, so not
    when a wall hides it.
    """

    def init(self, frame: Frame, region: Region, rng: Rng) -> MILState:
        """Learn the upright box round the region.

        Raises
        ------
        ValueError
            When OpenCV cannot learn from it.
        """
        frame = checked_frame(frame)
        box = _window(frame, checked_region(region))
        if min(box[2:]) < SMALLEST:
            raise ValueError(
                f"the box has {box[2]}x{box[3]} px inside the image, but MIL needs "
                f"{SMALLEST}x{SMALLEST}; choose a larger one"
            )
        # The features are drawn by the C library's rand(), all else by OpenCV's own.
        library = ctypes.CDLL("ucrtbase" if os.name == "nt" else None)
        library.srand(int(rng.integers(2**31)))
        cv2.setRNGSeed(int(rng.integers(2**31)))
        tracker = cv2.TrackerMIL.create()
        try:
            tracker.init(frame, box)
        except cv2.error:
            raise ValueError(
                f"MIL cannot learn from the box {box}: it needs background round it; "
                "choose a smaller one"
            ) from None
        return MILState(tracker, from_box(box), frame.shape)

    def step(self, state: MILState, frame: Frame, rng: Rng) -> tuple[MILState, Info]:
        """Let OpenCV find the box.

        Raises
        ------
        ValueError
            For a frame of another size, for which OpenCV would ask for endless memory.
        """
        frame = _of_shape(frame, state.shape)
        cv2.setRNGSeed(int(rng.integers(2**31)))
        found, box = state.tracker.update(frame)
        region = from_box(box) if found else state.region
        return state._replace(region=region), report(region, np.nan, not found, np.nan)


class ShiftState(NamedTuple):
    """What is carried from frame to frame.

    Attributes
    ----------
    hues : (bins,) array
        The histogram of hues, scaled to a maximum of 255.
    window : tuple of int [px]
    region : (5,) array [px, rad]
        The last estimate.
    first : float
        How probable the hues in the window were at the first look.
    shape : (H, W, 3)
        The shape that all frames must have.
    """

    hues: NDArray
    window: Window
    region: Region
    first: float
    shape: tuple[int, ...]


@dataclass(frozen=True)
class MeanShift:
    """cv2.meanShift on the back-projection of the hues.

    Its distance is sqrt(1 - p / p_0), with p how probable the hues in the window are
    and p_0 the same at the first look; 0 where they are more probable than then.

    Parameters
    ----------
    bins : int
        Of hue.
    s_min, v_min : int
        Saturation and value [0, 255] below which a pixel counts as having no hue.
    lost_above : float
        The distance beyond which the target is said to be lost.

    Raises
    ------
    ValueError
        Naming the field.
    """

    bins: int = 16
    s_min: int = 60
    v_min: int = 32
    lost_above: float = 0.7**0.5  # ours: three tenths of the first look

    def __post_init__(self):
        checks.counts(self, "bins")
        checks.grey_levels(self, "s_min", "v_min")
        checks.numbers(self, "lost_above")

    def init(self, frame: Frame, region: Region, rng: Rng) -> ShiftState:
        """Learn the hues inside the region.

        Raises
        ------
        ValueError
            When it has none, or lies outside the image.
        """
        frame = checked_frame(frame)
        region = checked_region(region)
        window = _window(frame, region)
        hsv = cv2.cvtColor(frame, cv2.COLOR_RGB2HSV)
        outline = np.rint(corners(region)).clip(-FAR, FAR).astype(np.int32)
        inside = np.zeros(frame.shape[:2], np.uint8)
        cv2.fillConvexPoly(inside, outline, 255)
        mask = inside & self._colorful(hsv)
        hues = cv2.calcHist([hsv], [0], mask, [self.bins], [0, HUES]).ravel()
        if not hues.any():
            raise ValueError(
                "the box has no colourful pixel, but MeanShift and CamShift go by hue; "
                "choose another box or another tracker"
            )
        hues *= 255 / hues.max()
        first = _mean(self._projection(frame, hues), window)
        return ShiftState(hues, window, region, first, frame.shape)

    def step(
        self, state: ShiftState, frame: Frame, rng: Rng
    ) -> tuple[ShiftState, Info]:
        """Shift the window; the cost is its number of places, as far as known.

        Raises
        ------
        ValueError
            For a frame of another size than the first.
        """
        frame = _of_shape(frame, state.shape)
        projection = self._projection(frame, state.hues)
        window, region, evaluations = self._search(projection, state)
        ratio = min(_mean(projection, window) / max(state.first, 1e-9), 1.0)
        d = np.sqrt(1 - ratio)
        info = report(region, d, d > self.lost_above, evaluations)
        return state._replace(window=window, region=region), info

    def _search(
        self, projection: NDArray, state: ShiftState
    ) -> tuple[Window, Region, float]:
        """The next window, the region (5,) it stands for, and the cost."""
        steps, window = cv2.meanShift(projection, state.window, STOP)
        return window, from_box(window), steps

    def _projection(self, frame: Frame, hues: NDArray) -> NDArray:
        """How probable the hue of each pixel is, (H, W) uint8, 0 where it has none."""
        hsv = cv2.cvtColor(frame, cv2.COLOR_RGB2HSV)
        probable = cv2.calcBackProject([hsv], [0], hues, [0, HUES], 1)
        return probable & self._colorful(hsv)

    def _colorful(self, hsv: NDArray) -> NDArray:
        least = 0, float(self.s_min), float(self.v_min)
        return cv2.inRange(hsv, least, (HUES, 255, 255))


@dataclass(frozen=True)
class CamShift(MeanShift):
    """cv2.CamShift on the same back-projection; the parameters are `MeanShift`'s."""

    def _search(
        self, projection: NDArray, state: ShiftState
    ) -> tuple[Window, Region, float]:
        ellipse, window = cv2.CamShift(projection, state.window, STOP)
        (x, y), (width, height), degrees = ellipse
        if min(width, height) < 1:  # no probable pixel in reach
            return state.window, state.region, np.nan
        region = np.array([x, y, np.radians(degrees), width / 2, height / 2])
        return window, _like(region, finite(state.region)[THETA]), np.nan


def _of_shape(frame: Frame, shape: tuple[int, ...]) -> Frame:
    """A frame of the first one's shape; ValueError for any other."""
    frame = checked_frame(frame)
    if frame.shape != shape:
        raise ValueError(
            f"the frame has the shape {frame.shape}, but the first one {shape}; bring "
            "all frames to one size"
        )
    return frame


def _window(frame: Frame, region: Region) -> Window:
    """The upright box round a region (5,), cut at the border of the image."""
    x, y, w, h = to_box(region)
    height, width = frame.shape[:2]
    left, right = np.clip(np.rint([x, x + w]), 0, width).astype(int).tolist()
    top, bottom = np.clip(np.rint([y, y + h]), 0, height).astype(int).tolist()
    if left == right or top == bottom:
        why = "covers no whole pixel of the image; choose a larger one"
        if outside(region, frame.shape):
            why = "lies outside the image; choose a box inside it"
        raise ValueError(f"the region {in_words(region)} {why}")
    return left, top, right - left, bottom - top


def _mean(projection: NDArray, window: Window) -> float:
    """Mean of the back-projection in a window, in [0, 1].

    The part of the window that lies outside the image counts as improbable.
    """
    x, y, w, h = window
    return float(projection[y : y + h, x : x + w].sum() / (255 * w * h))


def _like(region: Region, theta: float) -> Region:
    """The same rectangle, of its four descriptions the one nearest to theta [rad]."""
    quarters = round((theta - region[THETA]) / (np.pi / 2))
    region[THETA] += quarters * np.pi / 2
    if quarters % 2:
        region[[HX, HY]] = region[[HY, HX]]
    return region
