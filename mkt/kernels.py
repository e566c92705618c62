"""Where an object is looked at, and with what weight: kernel layouts and profiles -> sample points and a weight matrix K.

One kernel, nine overlapping Epanechnikov kernels, nine constant tiles and the ellipse of [N03] are four different matrices
``K (J, n)`` over points in the canonical square.  The points never change while a target is tracked, so neither does K: a frame
only contributes the bin that each point falls into (`mkt.histograms`).

Kernel shapes are defined in the *object plane*: the canonical square stretched to the object's aspect, scaled to area 4.  There the
isotropic kernels of (10) in [T09] are circles.

Explained in notebook 01.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from mkt.regions import HX, HY

GRIDS = {"one": 1, "2x2": 2, "3x3": 3, "4x4": 4}
LAYOUTS = (*GRIDS, "cut", "tiles", "ellipse")
PROFILES = ("epanechnikov", "uniform")


@dataclass(frozen=True)
class Kernels:
    """A kernel configuration: numbers and names here, the arrays they imply as properties.

    layout:   "one", "2x2", "3x3", "4x4" kernels that stay inside the object, neighbours half a radius apart along its shorter side;
              "cut", those of "3x3" moved out to the middles of the tiles, so that the object's border cuts them off; "tiles", a 3x3
              partition of the rectangle; "ellipse", everything inside the ellipse of the half axes, as in [N03].
    profile:  "epanechnikov", k(r^2) = 1 - r^2, (10) of [T09] and (2) of [N03]; or "uniform", k = 1 on the support.
    span:     factor on the kernels' radius h.  At 1 the nine kernels have h = min(W, H) / 3 with centres at +-(W/2 - h), +-(H/2 - h):
              supports that leave the object make a tracker shrink.
    elliptic: kernels stretched with the object instead of round ones.  For "ellipse" the radius a = sqrt(Hx^2 + Hy^2) printed
              under (3) of [N03] (False) or the elliptic radius (True).
    aspect:   hx / hy of the object, see `fitted`.
    samples:  about how many points.  Fewer are faster; more lower the sampling floor and steady an optimiser.

    Raises ValueError naming the field.  Figure 2 of [T09]; notebook 01.

    >>> nine = Kernels("3x3").fitted([50, 40, 0, 20, 10])
    >>> nine.aspect, nine.weights.shape[0], nine.weights.sum(1).round(9).tolist()[:3]
    (2.0, 9, [1.0, 1.0, 1.0])
    """

    layout: str = "3x3"
    profile: str = "epanechnikov"
    span: float = 1.0
    elliptic: bool = False
    aspect: float = 1.0
    samples: int = 1200

    def __post_init__(self):
        for field, value, known in (("layout", self.layout, LAYOUTS), ("profile", self.profile, PROFILES)):
            if value not in known:
                raise ValueError(f"{field} is {value!r}; it must be one of {', '.join(known)}")
        for field in ("span", "aspect", "samples"):
            if not 0 < getattr(self, field) < np.inf:
                raise ValueError(f"{field} is {getattr(self, field)}; it must be positive")

    def fitted(self, region):
        """The same configuration for an object of the aspect of `region` (5,), arrays shared between equal ones."""
        return _shared(replace(self, aspect=max(round(float(region[HX] / region[HY]), 6), 1e-6)))

    @property
    def half_sides(self):
        """(2,) half sides of the object in the object plane: (sqrt(aspect), 1 / sqrt(aspect))."""
        return np.array([self.aspect**0.5, self.aspect**-0.5])

    @cached_property
    def radii(self):
        """(2,) half axes of each kernel's support in the object plane; h of (10) in [T09]."""
        if self.layout == "ellipse":
            return self.half_sides
        if self.layout == "tiles":
            return self.span * self.half_sides / 3
        # k kernels a side, neighbours half a radius apart, the outer ones touching the border: h = 2 W / (k + 3).
        sides = 2 * self.half_sides if self.elliptic else np.full(2, 2 * self.half_sides.min())
        return self.span * sides * 2 / (GRIDS.get(self.layout, 3) + 3)

    @cached_property
    def centres(self):
        """(J, 2) kernel centres c_j in the object plane, row by row."""
        on_tiles = self.layout in ("tiles", "cut")
        k = 3 if on_tiles else GRIDS.get(self.layout, 1)
        reach = self.half_sides * 2 / 3 if on_tiles else np.maximum(self.half_sides - self.radii, 0)
        along = np.linspace(-1, 1, k) if k > 1 else np.zeros(1)
        return reach * np.stack(np.meshgrid(along, along), -1).reshape(-1, 2)

    @cached_property
    def _grid(self):
        """Points and weights of the samples that some kernel sees, interleaved: (n, 2) canonical and (J, n) with rows of sum 1."""
        points = _pixel_grid(self.samples, self.aspect)
        weights = self.weigh(points * self.half_sides)
        if not weights.any(1).all():
            raise ValueError(f"a kernel covers no sample of an object of aspect {self.aspect:g}: raise span ({self.span:g}) or samples ({self.samples}), "
                             "or choose a less narrow region")
        order = _interleaved(weights)
        return points[order], np.ascontiguousarray(weights[:, order] / weights.sum(1, keepdims=True))

    def weigh(self, plane):
        """k(r^2) of every kernel at points (n, 2) of the object plane, not normalised.  Returns (J, n)."""
        u2 = ((plane - self.centres[:, None]) / self.radii) ** 2
        r2 = u2.max(-1) if self.layout == "tiles" else u2.sum(-1)
        inside = r2 <= 1 + 1e-9
        if self.layout == "ellipse":
            span2 = self.span**2 * (1 if self.elliptic else np.sum(self.half_sides**2))
            r2 = (r2 if self.elliptic else np.sum(plane**2, -1)[None]) / span2
            inside &= r2 <= 1
        return np.where(inside, np.maximum(1 - r2, 0) if self.profile == "epanechnikov" else 1.0, 0.0)

    @property
    def points(self):
        """(n, 2) sample points in the canonical square."""
        return self._grid[0]

    @cached_property
    def homogeneous(self):
        """(3, n) float32: x, y and 1 of the sample points, ready for a product with affine maps (2, 3)."""
        return np.vstack([self.points.T, np.ones(len(self.points))]).astype(np.float32)

    @property
    def weights(self):
        """(J, n) kernel weights K, each row of sum 1: C_j k_ij of (7), (8) in [T09]."""
        return self._grid[1]

    @cached_property
    def slopes(self):
        """(2, J, n) derivatives of the weights along x and y of the object plane, the normaliser C held fixed.

        Epanechnikov: -2 C (p - c_j) / h^2 on the support.  Raises ValueError for any other profile, which has none.
        """
        if self.profile != "epanechnikov" or self.layout in ("tiles", "ellipse"):
            raise ValueError(f"{self.layout} {self.profile} kernels have no slope; use Epanechnikov ones")
        plane = self.points * self.half_sides
        raw = self.weigh(plane)
        slope = -2 * (plane - self.centres[:, None]) / self.radii**2 * (raw > 0)[..., None]
        return np.moveaxis(slope, -1, 0) / raw.sum(1)[:, None]

    @cached_property
    def parts(self):
        """(n,) the kernel of each sample where the kernels are a partition with constant weights, else None."""
        seen = self.weights > 0
        constant = np.allclose(self.weights, seen / seen.sum(1, keepdims=True))
        return seen.argmax(0) if constant and (seen.sum(0) == 1).all() else None


_shared = lru_cache(maxsize=64)(lambda kernels: kernels)


def _pixel_grid(samples, aspect):
    """Centres of about `samples` equal cells, square on an object of that aspect.  Returns (n, 2) canonical."""
    nx = round(min(max((samples * aspect) ** 0.5, 1), samples))
    ny = max(round(samples / nx), 1)
    x, y = np.meshgrid((2 * np.arange(nx) + 1) / nx - 1, (2 * np.arange(ny) + 1) / ny - 1)
    return np.stack([x.ravel(), y.ravel()], -1)


def _interleaved(weights):
    """An order that takes the seen samples round-robin from the kernels.

    On an object of few colours neighbouring samples mostly fall into the same bin, and counting twice in a row into one place stalls the
    processor.  On a textured object the order makes no difference.
    """
    seen = np.flatnonzero(weights.any(0))
    part = weights[:, seen].argmax(0)
    rank = np.empty(len(seen), int)
    for j in np.unique(part):
        rank[part == j] = np.arange(np.sum(part == j))
    return seen[np.lexsort((part, rank))]
