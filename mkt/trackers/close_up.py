"""Close-ups: the part of a frame in which a target can be, on a scale that fits it.

To bin all of a frame of 1920 x 1080 pixels takes ten times as long as to track in it.
But only those pixels count that some hypothesis covers, and of a large target not all
of them.  A close-up is cut out round the hypotheses, and shrunk where a target has more
pixels than the kernels have samples; its `mkt.colors.BinImage` knows where it lies, so
that regions stay those of the frame.
"""

from dataclasses import replace
from math import ceil

import cv2
import numpy as np

from mkt.checks import checked_frame
from mkt.colors import BinImage, Bins, binned
from mkt.kernels import Kernels
from mkt.regions import size
from mkt.trackers.gains import relit
from mkt.types import Array, Frame, Region, Regions

MARGIN = 1.0  # of the largest hypothesis' size, for an optimiser to walk in


def fitting_pitch(kernels: Kernels, region: Region) -> int:
    """How many pixels of the frame become one of the close-up, so samples meet pixels.

    Parameters
    ----------
    kernels : Kernels
        Whose samples look at the target.
    region : (5,) array [px, rad]
        The target.
    """
    return max(int(2 * size(region) / kernels.samples**0.5), 1)


def close_up(
    bins: Bins, frame: Frame, gains: Array, regions: Regions, pitch: int
) -> BinImage:
    """The bins of a frame round some regions.

    Parameters
    ----------
    bins : Bins
    frame : (H, W, 3) uint8 array, RGB
    gains : (3,) array
        Of the light, which are divided out: see `mkt.trackers.gains`.
    regions : (N, 5) array [px, rad]
        Where the target may be.
    pitch : int [px]
        Of `fitting_pitch`.

    Raises
    ------
    ValueError
        For an array that is not a frame, and what `mkt.colors.binned` refuses.
    """
    part, (x, y) = cut_out(frame, *_surroundings(regions, pitch), pitch)
    image = binned(bins, relit(part, gains))
    inner_x, inner_y = image.origin  # of bins of one's own, on a scale of their own
    origin = x + pitch * inner_x, y + pitch * inner_y
    return replace(image, origin=origin, pitch=pitch * image.pitch)


def cut_out(
    frame: Frame, low: Array, high: Array, pitch: int
) -> tuple[Frame, tuple[float, float]]:
    """The part of a frame from `low` to `high`, and where its first pixel lies.

    Parameters
    ----------
    frame : (H, W, 3) uint8 array, RGB
    low, high : (2,) arrays [px]
        The least and the largest x and y; what lies outside the frame is left out.
    pitch : int [px]
        Of `fitting_pitch`.

    Raises
    ------
    ValueError
        For an array that is not a frame.
    """
    frame = checked_frame(frame)
    spans = zip(low, high, frame.shape[1::-1], strict=True)
    x, y = (_span(*span, pitch) for span in spans)
    part = frame[y[0] : y[1], x[0] : x[1]]
    if pitch > 1:
        sides = max((x[1] - x[0]) // pitch, 1), max((y[1] - y[0]) // pitch, 1)
        part = cv2.resize(part, sides, interpolation=cv2.INTER_AREA)
    first = (pitch - 1) / 2  # the middle of its block of pixels
    return np.ascontiguousarray(part), (x[0] + first, y[0] + first)


def _surroundings(regions: Regions, pitch: int) -> tuple[Array, Array]:
    """From where to where hypotheses may lie or go; everywhere where none is finite."""
    regions = regions[np.isfinite(regions).all(1)]
    if not len(regions):
        return np.full(2, -np.inf), np.full(2, np.inf)
    reach = np.hypot(*regions[:, 3:].T) + MARGIN * size(regions).max() + 2 * pitch
    low, high = regions[:, :2].T - reach, regions[:, :2].T + reach
    return low.min(1), high.max(1)


def _span(low: float, high: float, side: int, pitch: int) -> tuple[int, int]:
    """First pixel along one side of the frame, and the one after the last.

    It is a multiple of the pitch, where the frame is no smaller.
    """
    # Plain numbers: for one of them numpy's functions cost ten times as much.
    start = int(min(max(low, 0), max(side - 2 * pitch, 0)))
    end = ceil(min(max(high, start + 2 * pitch), side))
    pixels = max((end - start) // pitch, 1)
    return start, min(start + pixels * pitch, side)
