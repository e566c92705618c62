"""Where an object is looked at, and with what weight.

Layouts and profiles of kernels give sample points and a weight matrix K.

One kernel, nine overlapping Epanechnikov kernels, nine constant tiles and the ellipse
of [N03] are four different matrices ``K (J, n)`` over points in the canonical square.
The points never change while a target is tracked, so neither does K: a frame only
contributes the bin that each point falls into (`mkt.histograms`).

Kernel shapes are defined in the *object plane*: the canonical square stretched to the
object's aspect, scaled to area 4.  There the isotropic kernels of (10) in [T09] are
circles.

Explained in notebook 01.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from mkt import checks
from mkt.checks import locked
from mkt.regions import HX, HY
from mkt.types import Array, ArrayLike, NDArray

GRIDS = {"one": 1, "2x2": 2, "3x3": 3, "4x4": 4, "5x5": 5}
LAYOUTS = (*GRIDS, "cut", "tiles", "ellipse", "axes")
PROFILES = ("epanechnikov", "uniform")
ROUNDING = 1e-9  # a point on the border of a support belongs to it


@dataclass(frozen=True)
class Kernels:
    """A configuration of kernels: numbers and names here, their arrays as properties.

    Parameters
    ----------
    layout : str
        "one", "2x2", "3x3", "4x4", "5x5": kernels that stay inside the object,
        neighbours half a radius apart along its shorter side; "cut": those of "3x3"
        moved out to the middles of the tiles, so that the object's border cuts them
        off; "tiles": a 3x3 partition of the rectangle; "ellipse": everything inside the
        ellipse of the half axes, as in [N03]; "axes": the two kernels 1 - x^2 and
        1 - y^2 on it, of which `mkt.trackers.adaptive` mixes that of any ellipse.
    profile : {"epanechnikov", "uniform"}
        k(r^2) = 1 - r^2, (10) of [T09] and (2) of [N03]; or k = 1 on the support.
    span : float
        Factor on the kernels' radius h.  At 1 the nine kernels have h = min(W, H) / 3
        with centres at +-(W/2 - h), +-(H/2 - h): supports that leave the object make a
        tracker shrink.
    elliptic : bool
        Kernels stretched with the object instead of round ones.  For "ellipse" it is
        the elliptic radius instead of the radius a = sqrt(Hx^2 + Hy^2) printed under
        (3) of [N03].
    aspect : float, optional
        hx / hy of the object; `fitted` takes it from a region.  Without it there are no
        arrays.
    samples : int
        About how many points the grid on the rectangle has; those that no kernel sees
        are left out.  Fewer are faster; more of them lower the sampling floor and
        steady an optimiser.

    Raises
    ------
    ValueError
        Naming the field.

    Examples
    --------
    Figure 2 of [T09]; notebook 01.

    >>> nine = Kernels("3x3").fitted([50, 40, 0, 20, 10])
    >>> nine.aspect, len(nine.weights), nine.weights.sum(1).round(9).tolist()[:3]
    (2.0, 9, [1.0, 1.0, 1.0])
    """

    layout: str = "3x3"
    profile: str = "epanechnikov"
    span: float = 1.0
    elliptic: bool = False
    aspect: float | None = None
    samples: int = 1200

    def __post_init__(self):
        checks.one_of(self, layout=LAYOUTS, profile=PROFILES)
        checks.positive(self, "span")
        checks.flags(self, "elliptic")
        checks.counts(self, "samples")
        if self.layout == "axes" and self.span != 1:
            raise ValueError(f"span is {self.span:g}; the kernels of axes take 1")
        if self.aspect is not None:
            checks.positive(self, "aspect")

    def fitted(self, region: ArrayLike) -> "Kernels":
        """The same configuration for an object of the aspect of a region (5,).

        Equal ones share their arrays, which cannot be written to.

        Raises
        ------
        ValueError
            For a region without area, or that is not finite.
        """
        region = checks.checked_region(region)
        aspect = max(round(float(region[HX] / region[HY]), 6), 1e-6)
        return _shared(replace(self, aspect=aspect))

    @property
    def half_sides(self) -> Array:
        """(2,) half sides of the object in the object plane.

        They are sqrt(aspect) and 1 / sqrt(aspect).

        Raises
        ------
        ValueError
            Where the kernels are not fitted to an object yet.
        """
        aspect = self._known_aspect
        return np.array([aspect**0.5, aspect**-0.5])

    @property
    def _known_aspect(self) -> float:
        if self.aspect is None:
            raise ValueError(
                "these kernels are not fitted to an object yet; "
                "take kernels.fitted(region), or give their aspect"
            )
        return self.aspect

    @cached_property
    def radii(self) -> Array:
        """(2,) half axes of each kernel's support in the object plane; h of (10)."""
        if self.layout in ("ellipse", "axes"):
            return locked(self.half_sides)
        if self.layout == "tiles":
            return locked(self.span * self.half_sides / 3)
        # k kernels a side, neighbours half a radius apart, the outer ones touching the
        # border: h = 2 W / (k + 3).
        shorter = np.full(2, 2 * self.half_sides.min())
        sides = 2 * self.half_sides if self.elliptic else shorter
        return locked(self.span * sides * 2 / (GRIDS.get(self.layout, 3) + 3))

    @cached_property
    def centres(self) -> Array:
        """(J, 2) kernel centres c_j in the object plane, row by row."""
        if self.layout == "axes":
            return locked(np.zeros((2, 2)))
        on_tiles = self.layout in ("tiles", "cut")
        k = 3 if on_tiles else GRIDS.get(self.layout, 1)
        inside = np.maximum(self.half_sides - self.radii, 0)
        reach = self.half_sides * 2 / 3 if on_tiles else inside
        along = np.linspace(-1, 1, k) if k > 1 else np.zeros(1)
        places = np.stack(np.meshgrid(along, along), -1).reshape(-1, 2)
        return locked(reach * places)

    @cached_property
    def _grid(self) -> tuple[Array, Array, Array]:
        """Points (n, 2) and weights (J, n) of the samples that some kernel sees.

        The third are the sums (J,) of the weights before they were made to sum to 1.
        """
        aspect = self._known_aspect
        points = _pixel_grid(self.samples, aspect)
        weights = self.weigh(points * self.half_sides)
        if not weights.any(1).all():
            raise ValueError(
                f"a kernel covers no sample of an object of aspect {aspect:g}: raise "
                f"the span ({self.span:g}) or the samples ({self.samples}) of the "
                f"{self.layout} kernels, take fewer kernels, as the tracker pf-1 does, "
                "or choose a less narrow region"
            )
        order = _interleaved(weights)
        sums = weights.sum(1)
        normalised = np.ascontiguousarray(weights[:, order] / sums[:, None])
        return locked(points[order]), locked(normalised), locked(sums)

    def weigh(self, plane: Array) -> Array:
        """k(r^2) of every kernel, not normalised.

        Parameters
        ----------
        plane : (n, 2) array
            Points of the object plane.

        Returns
        -------
        (J, n) array
        """
        r2 = self._squared_radii(plane)
        if self.profile == "uniform":
            return np.where(r2 <= 1 + ROUNDING, 1.0, 0.0)
        return np.maximum(1 - r2, 0.0)

    def _squared_radii(self, plane: Array) -> Array:
        """r^2 of points (n, 2) for each kernel, above 1 outside its support: (J, n)."""
        with np.errstate(over="ignore"):  # infinitely far is outside as well
            u2 = ((plane - self.centres[:, None]) / self.radii) ** 2
        if self.layout == "tiles":
            return u2.max(-1)
        r2 = u2.sum(-1)
        if self.layout == "axes":
            return np.where(r2 <= 1 + ROUNDING, u2[0].T, np.inf)
        if self.layout == "ellipse":
            a2 = 1 if self.elliptic else np.sum(self.half_sides**2)
            radial = r2 if self.elliptic else np.sum(plane**2, -1)[None]
            inside = r2 <= 1 + ROUNDING
            return np.where(inside, radial / (self.span**2 * a2), np.inf)
        return r2

    @property
    def points(self) -> Array:
        """(n, 2) sample points in the canonical square."""
        return self._grid[0]

    @cached_property
    def homogeneous(self) -> NDArray:
        """(3, n) float32: x, y and 1 of the points, for a product with affine maps."""
        rows = np.vstack([self.points.T, np.ones(len(self.points))])
        return locked(rows.astype(np.float32))

    @property
    def weights(self) -> Array:
        """(J, n) kernel weights K, each row of sum 1: C_j k_ij of (7), (8) in [T09]."""
        return self._grid[1]

    @property
    def sums(self) -> Array:
        """(J,) sums of k over the samples: 1 / C_j of (7), (8) in [T09]."""
        return self._grid[2]

    def check_slopes(self) -> None:
        """Refuse to be differentiated where that is not possible.

        Raises
        ------
        ValueError
            For kernels that are no Epanechnikov kernels, which have no slope, and those
            of a subclass with weights of its own and no slopes of its own.
        """
        own = type(self)
        if own.weigh is not Kernels.weigh and own.slopes is Kernels.slopes:
            raise ValueError(
                f"{own.__name__} has a `weigh` of its own, and the slopes of "
                "Epanechnikov kernels; give it its own `slopes`"
            )
        if self.profile != "epanechnikov" or self.layout not in (*GRIDS, "cut"):
            raise ValueError(
                f"{self.layout} {self.profile} kernels have no slope; "
                "use Epanechnikov ones"
            )

    @cached_property
    def slopes(self) -> Array:
        """(2, J, n) derivatives of the weights along x and y of the object plane.

        The normaliser C is held fixed: -2 C (p - c_j) / h^2 on the support.

        Raises
        ------
        ValueError
            See `check_slopes`.
        """
        self.check_slopes()
        plane = self.points * self.half_sides
        raw = self.weigh(plane)
        slope = -2 * (plane - self.centres[:, None]) / self.radii**2
        slope *= (raw > 0)[..., None]
        return locked(np.moveaxis(slope, -1, 0) / raw.sum(1)[:, None])

    @cached_property
    def parts(self) -> NDArray | None:
        """(n,) the kernel of each sample, where they partition it with one weight."""
        seen = self.weights > 0
        constant = np.allclose(self.weights, seen / seen.sum(1, keepdims=True))
        alone = constant and (seen.sum(0) == 1).all()
        return locked(seen.argmax(0)) if alone else None


@lru_cache(maxsize=64)
def _shared(kernels: Kernels) -> Kernels:
    """Of all equal configurations, the one whose arrays are computed already."""
    return kernels


def of_kernels(value: Any, name: str) -> None:
    """Refuse an argument that is no `Kernels`, such as the name of a layout."""
    checks.of_kind(value, Kernels, name, "give Kernels(layout), such as Kernels('3x3')")


def _pixel_grid(samples: int, aspect: float) -> Array:
    """Centres (n, 2) of about `samples` equal cells, square on an object's plane."""
    nx = round(min(max((samples * aspect) ** 0.5, 1), samples))
    ny = round(samples / nx)
    along_x = (2 * np.arange(nx) + 1) / nx - 1
    along_y = (2 * np.arange(ny) + 1) / ny - 1
    x, y = np.meshgrid(along_x, along_y)
    return np.stack([x.ravel(), y.ravel()], -1)


def _interleaved(weights: Array) -> NDArray:
    """An order that takes the seen samples round-robin from the kernels.

    On an object of few colours neighbouring samples mostly fall into the same bin, and
    counting twice in a row into one place stalls the processor.  On a textured object
    the order makes no difference.
    """
    seen = np.flatnonzero(weights.any(0))
    part = weights[:, seen].argmax(0)
    rank = np.empty(len(seen), int)
    for j in np.unique(part):
        rank[part == j] = np.arange(np.sum(part == j))
    return seen[np.lexsort((part, rank))]
