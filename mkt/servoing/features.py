"""Image features of visual servoing, and how they change with the camera's motion.

Section VI of [T09].  Four features (16) of the region that a tracker finds,
s = (x_n, y_n, a_n, theta), with

    a_n = 1 / sqrt(a),    x_n = a_n x_g,    y_n = a_n y_g,

in normalised image coordinates x = (u - u0) / f; a is the area of the region there and
(x_g, y_g) its centre.  A twist v = (vx, vy, vz, wx, wy, wz) of the camera, in its own
frame (x right, y down, z forward), changes them by ds/dt = L v with the interaction
matrix L (4, 6), and a moving target changes them by de/dt besides.

What the camera should do about it: `mkt.servoing.law`.  Explained in notebook 07.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mkt.checks import check_known, image_size, positive
from mkt.regions import (
    CX,
    CY,
    HX,
    HY,
    THETA,
    area,
    as_one_region,
    as_regions,
    wrap_angle,
)
from mkt.types import Array, ArrayLike, Regions

# The angle comes back after a whole turn if a tracker counted it, after half a turn if
# it is the axis of second moments.
PERIODS = {"theta": 2 * np.pi, "alpha": np.pi}
ROUND = 1e-9  # share of the second moments below which their difference is rounding


@dataclass(frozen=True)
class Camera:
    """A pinhole camera with square pixels, its axis through the middle of the image.

    Parameters
    ----------
    focal : float [px]
        The focal length f.
    size : (width, height) [px]

    Raises
    ------
    ValueError
        For a focal length that is not positive and finite, and for another size.
    """

    focal: float = 400.0
    size: tuple[int, int] = (320, 240)

    def __post_init__(self):
        positive(self, "focal")
        image_size(self.size)

    @property
    def matrix(self) -> Array:
        """K (3, 3), which takes (x, y, 1) to (u, v, 1) [px]."""
        return np.array(
            [
                [self.focal, 0, (self.size[0] - 1) / 2],
                [0, self.focal, (self.size[1] - 1) / 2],
                [0, 0, 1.0],
            ]
        )

    def normalised(self, regions: ArrayLike) -> Regions:
        """Regions (..., 5) [px, rad] in normalised image coordinates."""
        return (as_regions(regions) - self._origin) / self._unit

    @cached_property
    def _origin(self) -> Array:
        return np.array([(self.size[0] - 1) / 2, (self.size[1] - 1) / 2, 0, 0, 0])

    @cached_property
    def _unit(self) -> Array:
        return np.array([self.focal, self.focal, 1, self.focal, self.focal])


def features(regions: ArrayLike, camera: Camera, angle: str = "theta") -> Array:
    """The features (x_n, y_n, a_n, theta) of (16).

    Parameters
    ----------
    regions : (..., 5) array_like [px, rad]
    camera : Camera
    angle : str
        "theta", or "alpha" for the direction of the longer axis, in [-pi/2, pi/2).

    Returns
    -------
    (..., 4) array
        The alpha of a square, which has no longer axis, is the direction of its hx.

    Raises
    ------
    ValueError
        For a region without area, and another angle.
    """
    check_known("angle", angle, PERIODS)
    seen = camera.normalised(regions)
    a = area(seen)
    if not ((a > 0) & (seen[..., HX] > 0)).all():
        raise ValueError(
            "the region has no area, hence no features; "
            "its half axes hx and hy must be positive"
        )
    a_n = 1 / np.sqrt(a)
    s = np.empty((*seen.shape[:-1], 4))
    s[..., 0] = a_n * seen[..., CX]
    s[..., 1] = a_n * seen[..., CY]
    s[..., 2] = a_n
    s[..., 3] = _longer_axis(seen) if angle == "alpha" else seen[..., THETA]
    return s


def _longer_axis(regions: Regions) -> Array:
    """Directions (...) of the longer axes of regions, in [-pi/2, pi/2)."""
    quarter = np.where(regions[..., HX] < regions[..., HY], np.pi / 2, 0.0)
    return wrap_angle(regions[..., THETA] + quarter, np.pi)


def error(s: ArrayLike, desired: ArrayLike, angle: str = "theta") -> Array:
    """The error e = s - s* of (14), its angle the shorter way round.

    Parameters
    ----------
    s, desired : (..., 4) array_like
    angle : str
        "theta", a tracker's angle, modulo 2 pi; or "alpha", an axis, modulo pi.

    Returns
    -------
    (..., 4) array

    Raises
    ------
    ValueError
        For another angle.
    """
    check_known("angle", angle, PERIODS)
    e = np.asarray(s, float) - np.asarray(desired, float)
    e[..., 3] = wrap_angle(e[..., 3], PERIODS[angle])
    return e


def interaction_matrix(
    region: ArrayLike, camera: Camera, surface: float, angle: str = "theta"
) -> Array:
    """L of the features of a rectangle whose plane is parallel to the image.

    As a_n / Z = 1 / sqrt(S) whatever the depth Z, the columns of the translations are
    -1 / sqrt(S) times the identity: this is what (16) is made for.  The row of theta is
    that of the similarity which fits the rectangle best, as a tracker finds it; that of
    alpha belongs to the second moments.

    The rows of x_n, y_n and a_n are those of moments for either angle.  To turns about
    x and y the similarity, see `mkt.servoing.robot.Workspace.truth`, answers otherwise:
    for a rectangle of w by h the two entries of a_n are off by (w^2 - h^2) / (w^2 +
    h^2) / 3 of their length, 15 % for the car, and those of x_n and y_n by less than
    0.06 a_n, wherever it is in an image of 320x240, up to the size that `Servo` desires
    by default; where it looks 2.4 times as long they are off by up to 0.13 a_n.

    Parameters
    ----------
    region : (5,) array_like [px, rad]
    camera : Camera
    surface : float [m^2]
        The true area S of the target.
    angle : str
        "theta" or "alpha", see `features`.

    Returns
    -------
    (4, 6) array

    Raises
    ------
    ValueError
        For a surface that is not positive, more than one region or one without area,
        another angle, and the alpha of a square, which is not defined.
    """
    x, y, theta, hx, hy = camera.normalised(as_one_region(region)).tolist()
    w, h = 2 * hx, 2 * hy
    _check_rectangle(w, h, surface, angle)
    c2, s2 = math.cos(2 * theta), math.sin(2 * theta)
    # Second moments of the rectangle over its area: w^2 / 12 and h^2 / 12 along its own
    # axes, turned by theta.
    p, q = w * w + h * h, w * w - h * h
    n20, n02, n11 = (p + q * c2) / 24, (p - q * c2) / 24, q * s2 / 24
    a_n = 1 / math.sqrt(w * h)
    # A translation moves x_n, y_n and a_n by -a_n / Z.
    t = -1 / math.sqrt(surface)
    # A turn of the camera moves a point by (xy, 1 + y^2) wx - (1 + x^2, xy) wy.  For
    # the centre the moments come in besides, and a_n, which changes too, leaves -1/2 of
    # the products x y, x^2 and y^2.
    xy = 4 * n11 - x * y / 2
    xx = 1 + 4 * n20 - x * x / 2
    yy = 1 + 4 * n02 - y * y / 2
    # The angle follows the rotation in that motion, and k times its shear along the
    # rectangle's own axes.  Where a similarity is fitted, k is 1 for a line and 0 for a
    # square, which no shear turns.
    k = p / q if angle == "alpha" else q / p
    turn_x = (k * (x * c2 + y * s2) - x) / 2
    turn_y = (k * (x * s2 - y * c2) - y) / 2
    return np.array(
        [
            [t, 0, 0, a_n * xy, -a_n * xx, a_n * y],  # x_n
            [0, t, 0, a_n * yy, -a_n * xy, -a_n * x],  # y_n
            [0, 0, t, -1.5 * a_n * y, 1.5 * a_n * x, 0],  # a_n
            [0, 0, 0, turn_x, turn_y, -1],  # theta or alpha
        ]
    )


def _check_rectangle(w: float, h: float, surface: float, angle: str) -> None:
    """Refuse what has no interaction matrix."""
    check_known("angle", angle, PERIODS)
    if not 0 < surface < math.inf:
        raise ValueError(
            f"surface is {surface}; the true area of the target in m^2 must be positive"
        )
    if not (w > 0 and h > 0):
        raise ValueError(
            "the region has no area, hence no interaction matrix; "
            "its half axes hx and hy must be positive"
        )
    if angle == "alpha" and w == h:
        raise ValueError(
            'the second moments of a square have no axis; use angle="theta"'
        )


def moments(corners: ArrayLike) -> Array:
    """Features (x_n, y_n, a_n, alpha) of a quadrilateral, from its dense moments.

    Parameters
    ----------
    corners : (4, 2) array_like
        In normalised image coordinates, in order, of a convex one.

    Returns
    -------
    (4,) array

    Raises
    ------
    ValueError
        Where it has no area, is not convex, or its corners do not go round it in order;
        and where it has no axis, as a square, whose alpha is not defined.  And for
        another shape.
    """
    if np.shape(corners) != (4, 2):
        raise ValueError(
            f"corners have the shape {np.shape(corners)}; give (4, 2), four places"
        )
    points, weights = quadrature(corners)
    a = weights.sum()
    if not (a > 0 and _turn_one_way(np.asarray(corners, float))):
        raise ValueError(
            "the quadrilateral has no area, crosses itself or has a dent: no features; "
            "give four corners in order round the target"
        )
    centre = points @ weights / a
    u, v = points - centre[:, None]
    m20, m11, m02 = np.array([u * u, u * v, v * v]) @ weights
    if np.hypot(2 * m11, m20 - m02) <= ROUND * (m20 + m02):
        raise ValueError(
            "the second moments of a square have no axis; "
            "give a quadrilateral that is longer than it is wide"
        )
    a_n = 1 / np.sqrt(a)
    alpha = np.arctan2(2 * m11, m20 - m02) / 2
    return np.array([*(a_n * centre), a_n, alpha])


def _turn_one_way(corners: Array) -> bool:
    """Whether one turns to the same side at each of the corners (4, 2), or goes on."""
    sides = np.roll(corners, -1, axis=0) - corners
    following = np.roll(sides, -1, axis=0)
    turns = sides[:, 0] * following[:, 1] - sides[:, 1] * following[:, 0]
    return bool((turns >= 0).all() or (turns <= 0).all())


def quadrature(corners: ArrayLike) -> tuple[Array, Array]:
    """What integrates cubic polynomials over a quadrilateral exactly.

    Gauss's nine points in a square, carried over by the bilinear map of the corners.

    Parameters
    ----------
    corners : (4, 2) array_like
        In order.

    Returns
    -------
    points : (2, 9) array
    weights : (9,) array
    """
    node, weight = np.polynomial.legendre.leggauss(3)
    s, t = (axis.ravel() for axis in np.meshgrid(node, node))
    # The corners of the square, of which each has a share in every point.
    p = np.array([[-1, 1, 1, -1]]).T
    q = np.array([[-1, -1, 1, 1]]).T
    shares = (1 + p * s) * (1 + q * t)
    slopes_by_s, slopes_by_t = p * (1 + q * t), q * (1 + p * s)
    maps = np.array([shares, slopes_by_s, slopes_by_t]) / 4
    points, ds, dt = np.asarray(corners, float).T @ maps
    stretch = np.abs(ds[0] * dt[1] - ds[1] * dt[0])
    return points, np.outer(weight, weight).ravel() * stretch
