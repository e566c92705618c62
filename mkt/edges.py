"""From edges to bins: which way the brightness rises at every pixel.

The second kind of bin image beside colours (`mkt.colors`).  The direction of the
gradient hardly depends on the strength or the colour of the light, and it shows the
structure of an object: an object that has the colours of the background can still have
other edges.

The direction at a pixel is measured in the image; a region counts it from its own x
axis (`turned`), so that the directions of an object turn with it.

Explained in notebook 15.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from threading import get_ident

import cv2
import numpy as np

from mkt import checks
from mkt.checks import checked_frame
from mkt.colors import BinImage
from mkt.types import Frame, NDArray


@dataclass(frozen=True)
class EdgeBins:
    """Directions of the gradient in equal sectors, and one bin more for what is flat.

    Parameters
    ----------
    directions : int
        Sectors of the full circle; the first is centred on a rise to the right, the
        others follow clockwise on the screen.
    flat : float
        Grey levels a pixel below which a gradient has no direction.

    Raises
    ------
    ValueError
        Naming the field.

    Examples
    --------
    A rise to the right is in the first of eight sectors; beside it the image is flat.

    >>> frame = np.zeros((3, 9, 3), np.uint8)
    >>> frame[:, 4:] = 100
    >>> EdgeBins()(frame).labels[1].tolist()
    [8, 8, 8, 0, 0, 8, 8, 8, 8]
    """

    directions: int = 8
    flat: float = 4.0

    def __post_init__(self):
        checks.counts(self, "directions")
        checks.positive(self, "flat")
        if self.m > 255:
            raise ValueError(f"directions is {self.directions}; take at most 254")

    @property
    def m(self) -> int:
        """Number of bins."""
        return self.directions + 1

    def __call__(self, frame: Frame) -> BinImage:
        """The bins of a frame (H, W, 3) uint8 RGB; ValueError for anything else."""
        grey = cv2.cvtColor(checked_frame(frame), cv2.COLOR_RGB2GRAY)
        dx, dy, size, angle = _room(get_ident(), *grey.shape)
        for way, slope in zip(WAYS, (dx, dy), strict=True):
            cv2.Sobel(grey, cv2.CV_32F, *way, slope, scale=1 / 8)
        cv2.cartToPolar(dx, dy, size, angle, angleInDegrees=True)
        sector = cv2.convertScaleAbs(angle, alpha=self.directions / 360)
        flat = -(size < self.flat).view(np.uint8)  # `FLAT` where it is, else 0
        labels = cv2.LUT(sector | flat, self._labels)
        return BinImage(labels, self.m, compasses=((0, self.directions),))

    @cached_property
    def _labels(self) -> NDArray:
        """The bins of sectors and of `FLAT`; one more is half of the first sector."""
        labels = np.arange(256, dtype=np.uint8)
        labels[self.directions], labels[FLAT] = 0, self.directions
        return labels


FLAT = 255
WAYS = (1, 0), (0, 1)  # of the derivatives, along x and along y


def _room(thread: int, height: int, width: int) -> NDArray:
    """Four images (4, height, width) to work in, kept for each thread.

    To ask the system for fresh memory takes as long as all the work.  What is kept is
    a power of two long, for close-ups are of many sizes.
    """
    room = _kept(thread, (height * width - 1).bit_length())
    return room[:, : height * width].reshape(4, height, width)


@lru_cache(maxsize=4)
def _kept(_thread: int, bits: int) -> NDArray:
    return np.empty((4, 1 << bits), np.float32)
