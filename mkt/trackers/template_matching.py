"""Window matching, the WM of [C14]: OpenCV's template matching with the first look at the object.

The template never changes, in size either, and no pixel is explained away: it knows the object in one pose, and that one exactly.  Which measure of
likeness and which search window the paper used it does not say.
"""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from mkt.histograms import checked_frame
from mkt.regions import checked, from_box, to_box
from mkt.tracking import finite

SEARCHES = ("local", "global")


class TemplateState(NamedTuple):
    """The template (h, w, 3) uint8 and the last estimate (5,)."""

    template: np.ndarray
    region: np.ndarray


@dataclass(frozen=True)
class TemplateMatching:
    """The place of the highest normalised correlation, cv2.TM_CCOEFF_NORMED.

    search: "local", within `reach` times the box's own size on either side of the last estimate, or "global", all over the image.
    lost_below: the correlation below which the target is said to be lost.

    Raises ValueError naming the field.  Section 4 of [C14].
    """

    search: str = "local"
    reach: float = 0.5  # ours
    lost_below: float = 0.5  # ours

    def __post_init__(self):
        if self.search not in SEARCHES:
            raise ValueError(f"search is {self.search!r}; it must be one of {', '.join(SEARCHES)}")
        if not self.reach > 0:
            raise ValueError(f"reach is {self.reach}; it must be positive")

    def init(self, frame, region, rng):
        """Cut the template out of the upright box round the region.  Returns `TemplateState`.  Raises ValueError when it does not fit into the frame."""
        frame = checked_frame(frame)
        x, y, w, h = to_box(checked(region))
        size = max(round(w), 1), max(round(h), 1)
        if size[0] > frame.shape[1] or size[1] > frame.shape[0]:
            raise ValueError(f"the box of {size[0]}x{size[1]} px is larger than the frame of {frame.shape[1]}x{frame.shape[0]}; choose a smaller one")
        if x >= frame.shape[1] or y >= frame.shape[0] or x + w <= 0 or y + h <= 0:
            raise ValueError(f"the region {np.round(region, 1)} lies outside the image; choose a box inside it")
        region = from_box((x + w / 2 - size[0] / 2, y + h / 2 - size[1] / 2, *size))
        return TemplateState(cv2.getRectSubPix(frame, size, tuple(map(float, region[:2]))), region)

    def step(self, state, frame, rng):
        """Slide the template over the window; the score is the correlation where it is highest, 0 if that is negative.

        Raises ValueError for a frame that is smaller than the template.
        """
        frame = checked_frame(frame)
        if (np.array(frame.shape) < state.template.shape).any():
            raise ValueError(f"the frame has the shape {frame.shape}, but the template {state.template.shape}; bring all frames to the size of the first one")
        left, top, right, bottom = self.window(state, frame.shape)
        likeness = cv2.matchTemplate(frame[top:bottom, left:right], state.template, cv2.TM_CCOEFF_NORMED)
        _, best, _, (x, y) = cv2.minMaxLoc(likeness)
        h, w = state.template.shape[:2]
        region = from_box((left + x, top + y, w, h))
        info = {"region": region, "score": max(best, 0.0), "lost": best < self.lost_below, "evaluations": likeness.size}
        return state._replace(region=region), info

    def window(self, state, shape):
        """Left, top, right, bottom [px] of the part of the image that is searched; the template always fits into it."""
        h, w = state.template.shape[:2]
        if self.search == "global":
            return 0, 0, shape[1], shape[0]
        x, y = to_box(finite(state.region))[:2]
        left, top = (int(np.clip(round(low - self.reach * side), 0, full - side)) for low, side, full in ((x, w, shape[1]), (y, h, shape[0])))
        right, bottom = (int(np.clip(round(low + (1 + self.reach) * side), side, full)) for low, side, full in ((x, w, shape[1]), (y, h, shape[0])))
        return left, top, max(right, left + w), max(bottom, top + h)
