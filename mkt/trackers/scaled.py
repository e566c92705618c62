"""Any tracker on smaller frames: less work for frames that show more than it needs.

The frames are shrunk before the tracker sees them, and its answers are given in pixels
of the original frames.  A position x in a frame, counted from the middle of its first
pixel, is at s (x + 1/2) - 1/2 in one that is shrunk by s.
"""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from mkt import checks
from mkt.checks import checked_frame, checked_region
from mkt.regions import CX, CY, HX, HY
from mkt.tracking import Info, Tracker, check_tracker
from mkt.types import Array, Frame, Region, Regions, Rng

LENGTHS = [CX, CY, HX, HY]


@dataclass(frozen=True)
class Scaled:
    """A tracker on frames of another scale; it answers in pixels of the frames given.

    Parameters
    ----------
    tracker : Tracker
    scale : float
        Above 0, up to 1: of the length of a side.

    Raises
    ------
    ValueError
        For another scale, and what is no tracker.
    """

    tracker: Tracker
    scale: float

    def __post_init__(self):
        check_tracker(self.tracker)
        checks.numbers(
            self,
            "scale",
            fits=lambda scale: 0 < scale <= 1,
            need="it must be above 0, up to 1",
        )

    def init(self, frame: Frame, region: Region, rng: Rng) -> Any:
        """Show the shrunk frame to the tracker, and raise what the tracker raises.

        Raises
        ------
        ValueError
            Where less than a pixel would be left of the target's width or height.
        """
        shrunk = self._shrunk(frame)
        region = rescaled(checked_region(region), self.scale)
        if 2 * min(region[HX:]) < 1:
            raise ValueError(
                f"scale is {self.scale:g}, which leaves less than a pixel of the "
                "target; choose a larger one"
            )
        try:
            return self.tracker.init(shrunk, region, rng)
        except ValueError as error:
            raise ValueError(
                f"in frames at the scale {self.scale:g}: {error}"
            ) from error

    def step(self, state: Any, frame: Frame, rng: Rng) -> tuple[Any, Info]:
        """What the tracker finds in the shrunk frame, in pixels of the whole one."""
        state, info = self.tracker.step(state, self._shrunk(frame), rng)
        grown = {
            name: rescaled(info[name], 1 / self.scale)
            for name in ("region", "particles")
            if name in info
        }
        if "covariance" in info:
            units = np.ones(5)
            units[LENGTHS] = self.scale
            grown["covariance"] = info["covariance"] / np.outer(units, units)
        if "homography" in info:
            grown["homography"] = self._to_whole() @ info["homography"]
        return state, info | grown

    def _to_whole(self) -> Array:
        """The map (3, 3) from pixels of the shrunk frame to those of the whole one."""
        s, shift = 1 / self.scale, (1 / self.scale - 1) / 2
        return np.array([[s, 0, shift], [0, s, shift], [0, 0, 1]])

    def _shrunk(self, frame: Frame) -> Frame:
        frame = checked_frame(frame)
        scale = self.scale
        height, width = frame.shape[:2]
        if min(height, width) * scale <= 0.5:
            raise ValueError(
                f"scale is {scale:g}, which leaves nothing of a frame of "
                f"{width}x{height} px; choose a larger one"
            )
        return cv2.resize(frame, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)


def rescaled(regions: Regions, scale: float) -> Array:
    """Regions of a frame, in a frame that is larger by a factor.

    Parameters
    ----------
    regions : (..., 5) array [px, rad]
    scale : float

    Returns
    -------
    (..., 5) array [px, rad]
    """
    changed = np.array(regions, float)
    changed[..., [CX, CY]] += 0.5
    changed[..., LENGTHS] *= scale
    changed[..., [CX, CY]] -= 0.5
    return changed
