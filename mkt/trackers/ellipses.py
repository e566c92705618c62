"""Weighted histograms of many upright ellipses of any aspect on one fixed grid, (2) and (3) of [N03].

On the unit disc, x = (x_i - y_x) / H_x and y likewise, the printed radius r = |y - x_i| / a with a^2 = H_x^2 + H_y^2 gives the weight

    k = 1 - r^2 = f (1 - x^2) + (1 - f) (1 - y^2),    f = H_x^2 / a^2,

a mixture of two that no ellipse changes; the elliptic radius needs but one, 1 - x^2 - y^2.  With the printed radius the weight does not
vanish on the border of the ellipse: it is .5 there for a circle.
"""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from scipy.sparse import csr_matrix

from mkt.histograms import ColorBins
from mkt.kernels import Kernels
from mkt.regions import CX, CY, HX, HY

CHUNK = 100_000  # points at a time: the processor's cache holds their positions and labels


@dataclass(frozen=True)
class Disc:
    """A grid of points on the unit disc, with the weights that an ellipse gives them.

    elliptic: the elliptic radius in place of the printed one; samples: points on the square round the disc, of which pi / 4 lie in it.
    """

    elliptic: bool = False
    samples: int = 1200

    @cached_property
    def points(self):
        """(2, n) float32 sample points in the unit disc."""
        return np.ascontiguousarray(Kernels("ellipse", samples=self.samples).points.T, np.float32)

    def weights(self, regions):
        """k at the sample points of regions (N, 5), not normalised.  Returns (N, n) float32."""
        halves = np.ones((len(regions), 2)) if self.elliptic else regions[:, HX:] ** 2 / np.sum(regions[:, HX:] ** 2, 1, keepdims=True)
        return 1 - halves.astype(np.float32) @ self.points**2

    def histograms(self, image, m, regions):
        """Histograms p of regions (N, 5) [px, upright], (3) of [N03].  image: (H, W) bin numbers below m.  Returns (N, m) float32 of sum 1.

        Points outside the image count for nothing; an ellipse all outside has zeros.
        """
        regions, rows = np.asarray(regions, float), max(CHUNK // self.points.shape[1], 1)
        return np.concatenate([self.count(image, m, regions[k:k + rows]) for k in range(0, len(regions), rows)])

    def count(self, image, m, regions):
        """`histograms` of as many regions as there is room for in the processor's cache."""
        # A product with (place on the disc, 1) needs half the memory of a product and a sum.
        x, y = (regions[:, [h, c]].astype(np.float32) @ np.stack([p, np.ones_like(p)]) for h, c, p in zip((HX, HY), (CX, CY), self.points))
        labels = cv2.remap(image, x, y, cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT, borderValue=m).astype(np.int32)
        rows = np.arange(0, labels.size + 1, labels.shape[1], dtype=np.int32)
        # Unpacking a sparse matrix adds up what falls into one place; np.bincount takes half as long again.
        p = csr_matrix((self.weights(regions).ravel(), labels.ravel(), rows), (len(regions), m + 1)).toarray()[:, :m]
        p /= np.maximum(p @ np.ones((m, 1), np.float32), 1e-9)
        return p


@dataclass(frozen=True)
class JointHSV:
    """Hue, saturation and value jointly, 8x8x4 bins as in [N03]: frame (H, W, 3) uint8 RGB -> (H, W) bin numbers below m."""

    counts: tuple[int, int, int] = (8, 8, 4)

    @cached_property
    def _bins(self):
        return ColorBins("rgb", self.counts)

    @property
    def m(self):
        """Number of bins."""
        return self._bins.m

    def __call__(self, frame):
        return self._bins(cv2.cvtColor(frame, cv2.COLOR_RGB2HSV_FULL))
