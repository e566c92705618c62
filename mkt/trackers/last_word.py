"""The last word: a few steps on pixels, where an object still looks like its picture.

Kernels find an object whatever became of it, but no more exactly than its histograms
change with its place and size.  Pixels are exact as long as the object is what it was:
a thing that does not bend, seen from the same side.  So from where the kernels ended,
the steps of `mkt.trackers.homography_esm` are taken in place, turn and size alone,
towards the picture of the first frame, and they are believed where it correlates.
"""

from typing import NamedTuple

import cv2
import numpy as np

from mkt.homographies import PARAMETERS, of_regions
from mkt.regions import corners, size
from mkt.trackers.close_up import cut_out
from mkt.trackers.homography_esm import esm_step, facing, in_view
from mkt.trackers.newton import moved
from mkt.types import Array, Frame, NDArray, Region

PIXELS = 900  # of a picture, about
SHORTEST = 8  # [px] side of a picture
BLUR = 5, 5  # [px] of the Gaussian that smooths a close-up
ROOM = 0.25  # of the object's size, for the steps to walk in
STEPS = 2
MOTIONS = tuple(PARAMETERS.index(name) for name in ("tau_x", "tau_y", "theta", "log s"))


class _CloseUp(NamedTuple):
    """A grey close-up: its pixels, where the first one lies, and their pitch [px]."""

    grey: NDArray
    origin: Array
    pitch: int


def picture_of(frame: Frame, region: Region, pitch: int) -> NDArray:
    """The object in a region (5,), in grey.

    Parameters
    ----------
    frame : (H, W, 3) uint8 array, RGB
    region : (5,) array [px, rad]
    pitch : int [px]
        Of the close-up, see `mkt.trackers.close_up`.

    Returns
    -------
    (h, w) float32 array
        Of about `PIXELS`; NaN outside the frame.
    """
    hx, hy = region[3:]
    across = (PIXELS * hx / hy) ** 0.5
    sides = [max(round(side), SHORTEST) for side in (PIXELS / across, across)]
    blank = np.zeros(sides, np.float32)
    return _over(_close_up(frame, region, pitch), region, blank)


def aligned(
    frame: Frame, picture: NDArray, start: Region, pitch: int
) -> tuple[Region, float]:
    """A region (5,) after `STEPS` from the start, in place, turn and size.

    Parameters
    ----------
    frame : (H, W, 3) uint8 array, RGB
    picture : (h, w) float32 array
        Of `picture_of`.
    start : (5,) array [px, rad]
    pitch : int [px]

    Returns
    -------
    region : (5,) array [px, rad]
    correlation : float
        With the picture, in [-1, 1], before the last step; 0 where the frame shows
        too little of the object.
    """
    close_up = _close_up(frame, start, pitch)
    region = start
    correlation = 0.0
    for _ in range(STEPS):
        seen = _over(close_up, region, picture)
        if not in_view(seen + picture):
            return start, 0.0
        step, correlation = esm_step(picture, seen, MOTIONS)
        region = moved(region, step)
    return region, correlation


def _close_up(frame: Frame, region: Region, pitch: int) -> _CloseUp:
    outline = corners(region)
    room = ROOM * size(region) + (2 + BLUR[0]) * pitch
    low, high = outline.min(0) - room, outline.max(0) + room
    part, origin = cut_out(frame, low, high, pitch)
    grey = cv2.cvtColor(part, cv2.COLOR_RGB2GRAY).astype(np.float32)
    return _CloseUp(cv2.GaussianBlur(grey, BLUR, 0), np.array(origin), pitch)


def _over(close_up: _CloseUp, region: Region, picture: NDArray) -> NDArray:
    """The close-up over the region, of a picture's size (h, w); NaN outside of it."""
    here = region.copy()
    here[:2] -= close_up.origin
    here[[0, 1, 3, 4]] /= close_up.pitch
    return facing(close_up.grey, of_regions(here), picture)
