"""Window matching, the WM of [C14].

It is OpenCV's template matching with the first look at the object.

The template never changes, not even in size, and every pixel counts: it knows the
object in a single pose, but that one exactly.  The paper does not say which measure of
likeness and which search window it used.
"""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from mkt import checks
from mkt.checks import checked_frame, checked_region, finite, in_words
from mkt.regions import HX, HY, from_box, outside, to_box
from mkt.tracking import Info, report
from mkt.types import Array, Frame, Region, Rng

SEARCHES = ("local", "global")


class TemplateState(NamedTuple):
    """The template (h, w, 3) uint8 and where it was found last, a region (5,).

    The object is a box larger by `beyond`, (left, top, width, height) [px]: what of it
    lay outside the first frame.
    """

    template: Frame
    region: Region
    beyond: Array


@dataclass(frozen=True)
class TemplateMatching:
    """The place of the highest normalised correlation c, cv2.TM_CCOEFF_NORMED.

    Its distance is sqrt(1 - c), or 1 where c is negative.  Section 4 of [C14].

    Parameters
    ----------
    search : {"local", "global"}
        Round the last estimate, or all over the image.
    reach : float
        How far on either side of the last estimate, in sizes of the box.
    lost_above : float
        The distance beyond which the target is said to be lost.

    Raises
    ------
    ValueError
        Naming the field.
    """

    search: str = "local"
    reach: float = 0.5  # ours
    lost_above: float = 0.5**0.5  # ours: a correlation of .5

    def __post_init__(self):
        checks.one_of(self, search=SEARCHES)
        checks.positive(self, "reach")
        checks.numbers(self, "lost_above")

    def init(self, frame: Frame, region: Region, rng: Rng) -> TemplateState:
        """Cut the template out of the upright box round the region.

        Of a box that sticks out of the frame it is the part inside.

        Raises
        ------
        ValueError
            When it is larger than the frame, lies outside it, or holds a single colour.
        """
        frame = checked_frame(frame)
        height, width = frame.shape[:2]
        x, y, w, h = to_box(checked_region(region))
        size = max(round(w), 1), max(round(h), 1)
        if size[0] > width or size[1] > height:
            raise ValueError(
                f"the box of {size[0]}x{size[1]} px is larger than the frame of "
                f"{width}x{height}; choose a smaller one"
            )
        if outside(region, frame.shape):
            raise ValueError(
                f"the region {in_words(region)} lies outside the image; "
                "choose a box inside it"
            )
        whole = np.array((x + w / 2 - size[0] / 2, y + h / 2 - size[1] / 2, *size))
        beyond = _beyond(whole, frame.shape)
        region = from_box(whole - beyond)
        centre = float(region[0]), float(region[1])
        sides = round(2 * region[HX]), round(2 * region[HY])
        template = cv2.getRectSubPix(frame, sides, centre)
        if not template.std((0, 1)).any():  # OpenCV finds such a one everywhere
            raise ValueError(
                f"the region {in_words(region)} is of one colour, which correlates "
                "with nothing; choose a box with some pattern in it"
            )
        return TemplateState(template, region, beyond)

    def step(
        self, state: TemplateState, frame: Frame, rng: Rng
    ) -> tuple[TemplateState, Info]:
        """Slide the template over the window.

        Raises
        ------
        ValueError
            For a frame that is smaller than the template.
        """
        frame = checked_frame(frame)
        template = state.template
        if (np.array(frame.shape) < template.shape).any():
            raise ValueError(
                f"the frame has the shape {frame.shape}, but the template "
                f"{template.shape}; bring all frames to the size of the first one"
            )
        rows, columns = self.window(state, frame.shape)
        part = frame[rows, columns]
        likeness = cv2.matchTemplate(part, template, cv2.TM_CCOEFF_NORMED)
        _, best, _, (x, y) = cv2.minMaxLoc(likeness)
        h, w = template.shape[:2]
        region = from_box((columns.start + x, rows.start + y, w, h))
        d = np.sqrt(1 - min(max(best, 0.0), 1.0))
        whole = from_box(to_box(region) + state.beyond)
        info = report(whole, d, d > self.lost_above, likeness.size)
        return state._replace(region=region), info

    def window(
        self, state: TemplateState, shape: tuple[int, ...]
    ) -> tuple[slice, slice]:
        """Rows and columns of the image that are searched; the template always fits."""
        height, width = shape[:2]
        h, w = state.template.shape[:2]
        if self.search == "global":
            return slice(0, height), slice(0, width)
        x, y = to_box(finite(state.region))[:2]
        return self._span(y, h, height), self._span(x, w, width)

    def _span(self, low: float, side: int, full: int) -> slice:
        """From where to where one side of the box is searched, in an image's side."""
        # Clipped first, for what is infinite cannot be rounded.
        first = round(np.clip(low - self.reach * side, 0, full - side))
        last = round(np.clip(low + (1 + self.reach) * side, side, full))
        return slice(first, max(last, first + side))


def _beyond(box: Array, shape: tuple[int, ...]) -> Array:
    """What to add to the part of a box inside an image, to have the box: (4,) [px].

    Whole pixels, and 0 where it lies inside; at least a pixel of the box is left.
    """
    corner, size = box[:2], box[2:]
    before = np.clip(np.rint(-corner), 0, size - 1)
    behind = np.clip(np.rint(corner + size - shape[1::-1]), 0, size - 1)
    return np.concatenate([-before, before + behind])
