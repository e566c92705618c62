"""Weighted histograms of many upright ellipses of any aspect, (2), (3) of [N03].

They are made from two kernels that no ellipse changes.

On the unit disc, x = (x_i - y_x) / H_x and y likewise, the printed radius
``r = |y - x_i| / a`` with a^2 = H_x^2 + H_y^2 gives the weight

    k = 1 - r^2 = f (1 - x^2) + (1 - f) (1 - y^2),    f = H_x^2 / a^2,

a mixture of the two kernels "axes" of `mkt.kernels`; the elliptic radius needs but one,
1 - x^2 - y^2.  With the printed radius the weight does not vanish on the border of the
ellipse: it is .5 there for a circle.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mkt import checks
from mkt.colors import BinImage
from mkt.histograms import histograms, mixed_histograms
from mkt.kernels import Kernels
from mkt.regions import HX
from mkt.types import NDArray, Regions


@dataclass(frozen=True)
class Disc:
    """A grid of points on the unit disc, with the weights that an ellipse gives them.

    Parameters
    ----------
    elliptic : bool
        The elliptic radius in place of the printed one.
    samples : int
        Points on the square round the disc, of which pi / 4 lie in it.

    Raises
    ------
    ValueError
        Naming the field.
    """

    elliptic: bool = False
    samples: int = 1200

    def __post_init__(self):
        checks.flags(self, "elliptic")
        checks.counts(self, "samples")

    @cached_property
    def kernels(self) -> Kernels:
        """On the unit disc, whatever the aspect of an ellipse."""
        layout = "ellipse" if self.elliptic else "axes"
        return Kernels(layout, elliptic=True, aspect=1.0, samples=self.samples)

    def histograms(self, image: BinImage, regions: Regions) -> NDArray:
        """Histograms p, (3) of [N03].

        Points outside the image are not counted; an ellipse all outside has zeros.

        Parameters
        ----------
        image : BinImage
            The bins of the frame.
        regions : (N, 5) array [px, rad]
            Upright ones.

        Returns
        -------
        (N, m) float32 array of sum 1
        """
        regions = np.asarray(regions, float)
        kernels = self.kernels
        if self.elliptic:
            return histograms(image, kernels, regions)[:, 0]
        squares = regions[:, HX:] ** 2
        shares = squares / squares.sum(1, keepdims=True) * kernels.sums
        return mixed_histograms(image, kernels, regions, shares)
