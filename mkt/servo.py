"""Image-based visual servoing: what the camera measures, how it changes with the camera's motion, and the law that closes the loop.

Section VI of [T09].  Four features (16) of the region that a tracker finds, s = (x_n, y_n, a_n, theta), with

    a_n = 1 / sqrt(a),    x_n = a_n x_g,    y_n = a_n y_g,

in normalised image coordinates x = (u - u0) / f.  A twist v = (vx, vy, vz, wx, wy, wz) of the camera, in its own frame (x right, y down, z
forward), changes them by ds/dt = L v with the interaction matrix L (4, 6), and a moving target by de/dt besides.  The law (17),

    v = -gain L^+ e - L^+ de/dt,    e = s - s*,

makes the error decay as exp(-gain t).  How de/dt is found: `mkt.kalman`.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mkt.regions import CX, CY, HX, HY, THETA, area

# The angle comes back after a whole turn if a tracker counted it, after half a turn if it is the axis of second moments.
PERIODS = {"theta": 2 * np.pi, "alpha": np.pi}
AXES = {6: np.arange(6), 4: np.array([0, 1, 2, 5])}  # of the twist, by degrees of freedom


@dataclass(frozen=True)
class Camera:
    """A pinhole camera with square pixels.  focal: focal length f [px]; size: (width, height) [px], the axis through its middle.

    Raises ValueError for a focal length that is not positive.
    """

    focal: float = 400.0
    size: tuple[int, int] = (320, 240)

    def __post_init__(self):
        if not self.focal > 0:
            raise ValueError(f"focal is {self.focal}; the focal length in pixels must be positive")

    @property
    def matrix(self):
        """K (3, 3), which takes (x, y, 1) to (u, v, 1) [px]."""
        return np.array([[self.focal, 0, (self.size[0] - 1) / 2], [0, self.focal, (self.size[1] - 1) / 2], [0, 0, 1.0]])

    def normalised(self, regions):
        """Regions (..., 5) [px, rad] in normalised image coordinates."""
        return (np.asarray(regions, float) - self._origin) / self._unit

    @cached_property
    def _origin(self):
        return np.array([(self.size[0] - 1) / 2, (self.size[1] - 1) / 2, 0, 0, 0])

    @cached_property
    def _unit(self):
        return np.array([self.focal, self.focal, 1, self.focal, self.focal])


def features(regions, camera, angle="theta"):
    """The features (x_n, y_n, a_n, theta) of (16), or alpha for theta: the direction of the longer axis, in [-pi/2, pi/2).

    regions: (..., 5) [px, rad].  Returns (..., 4).  Raises ValueError for a region without area.
    """
    r = camera.normalised(regions)
    a = area(r)
    if not (a > 0).all():
        raise ValueError("the region has no area, hence no features; its half axes hx and hy must be positive")
    theta = r[..., THETA]
    if angle == "alpha":
        theta = _wrapped(theta + np.where(r[..., HX] < r[..., HY], np.pi / 2, 0), np.pi)
    s = np.empty((*r.shape[:-1], 4))
    s[..., 2] = a_n = 1 / np.sqrt(a)
    s[..., 0], s[..., 1], s[..., 3] = a_n * r[..., CX], a_n * r[..., CY], theta
    return s


def error(s, desired, angle="theta"):
    """e = s - s*, (14), the angle wrapped: modulo 2 pi for a tracker's theta, modulo pi for alpha.

    s, desired: (..., 4).  Returns (..., 4).
    """
    e = np.asarray(s, float) - desired
    e[..., 3] = _wrapped(e[..., 3], PERIODS[angle])
    return e


def _wrapped(x, period):
    return (x + period / 2) % period - period / 2


def interaction_matrix(region, camera, surface, angle="theta"):
    """L (4, 6) of the features of a rectangle whose plane is parallel to the image.

    region: (5,) [px, rad]; surface: the true area S of the target [m^2].  As a_n / Z = 1 / sqrt(S) whatever the depth Z, the columns of the
    translations are -1 / sqrt(S) times the identity: this is what (16) is made for.  The row of theta is that of the similarity which fits the
    rectangle best, as a tracker finds it; that of alpha belongs to the second moments.  Raises ValueError for a surface that is not positive, a
    region without area, and the alpha of a square, which is not defined.
    """
    if not surface > 0:
        raise ValueError(f"surface is {surface}; the true area of the target in m^2 must be positive")
    x, y, theta, w, h = camera.normalised(region).tolist()
    w, h = 2 * w, 2 * h
    if not (w > 0 and h > 0):
        raise ValueError("the region has no area, hence no interaction matrix; its half axes hx and hy must be positive")
    if angle == "alpha" and w == h:
        raise ValueError('the second moments of a square have no axis; use angle="theta"')
    p, q, c2, s2 = w * w + h * h, w * w - h * h, math.cos(2 * theta), math.sin(2 * theta)
    n20, n02, n11 = (p + q * c2) / 24, (p - q * c2) / 24, q * s2 / 24  # second moments over the area
    elongation = p / q if angle == "alpha" else q / p
    a_n, t = 1 / math.sqrt(w * h), -1 / math.sqrt(surface)
    return np.array([
        [t, 0, 0, a_n * (4 * n11 - x * y / 2), -a_n * (1 + 4 * n20 - x * x / 2), a_n * y],
        [0, t, 0, a_n * (1 + 4 * n02 - y * y / 2), -a_n * (4 * n11 - x * y / 2), -a_n * x],
        [0, 0, t, -1.5 * a_n * y, 1.5 * a_n * x, 0],
        [0, 0, 0, (elongation * (x * c2 + y * s2) - x) / 2, (elongation * (x * s2 - y * c2) - y) / 2, -1],
    ])


def moments(corners):
    """Features (x_n, y_n, a_n, alpha) of any quadrilateral, from its dense moments.

    corners: (4, 2) in normalised image coordinates, in order.  Returns (4,).  Raises ValueError where it has no area.
    """
    a, centre, _, (m20, m11, m02) = _moments(*quadrature(corners))
    a_n = 1 / np.sqrt(a)
    return np.array([*(a_n * centre), a_n, np.arctan2(2 * m11, m20 - m02) / 2])


def interaction_matrix_tilted(corners, plane):
    """L (4, 6) of the features `moments`, for a target in a plane of any tilt.

    corners: (4, 2) in normalised image coordinates, in order; plane: (A, B, C) with 1 / Z = A x + B y + C [1/m].  Raises ValueError for a
    quadrilateral without area.

    Every point of the target moves by the interaction matrix of a point, dx/dt = l(x) v.  So a moment m = int f(x) dx changes by
    dm/dt = int (grad f . l + f div l) dx v.  The integrals are sums over nine points, exact for the polynomials that occur here.
    """
    points, weights = quadrature(corners)
    a, centre, centred, (m20, m11, m02) = _moments(points, weights)
    (x, y), (u, v), (A, B, C), o = points, centred, plane, np.zeros(9)
    d = A * x + B * y + C  # inverse depths
    flow = np.array([[-d, o, x * d, x * y, -1 - x * x, y], [o, -d, y * d, 1 + y * y, -x * y, -x]])  # l, (2, 6, 9)
    div = np.array([o - A, o - B, 3 * d - C, 3 * y, -3 * x, o])
    L_xy = (flow + div * centred[:, None]) @ weights / a
    L_20, L_02 = (2 * centred[:, None] * flow + div * centred[:, None] ** 2) @ weights
    L_11 = (u * flow[1] + v * flow[0] + div * u * v) @ weights
    a_n = 1 / np.sqrt(a)
    L_an = -a_n / (2 * a) * (div @ weights)
    L_alpha = ((m20 - m02) * L_11 - m11 * (L_20 - L_02)) / ((m20 - m02) ** 2 + 4 * m11**2)
    return np.array([*(a_n * L_xy + np.outer(centre, L_an)), L_an, L_alpha])


def quadrature(corners):
    """Nine points (2, 9) and weights (9,) that integrate cubic polynomials over a quadrilateral exactly: Gauss's, on a bilinear map.

    corners: (4, 2), in order.
    """
    node, weight = np.polynomial.legendre.leggauss(3)
    s, t = np.meshgrid(node, node)
    s, t, p, q = s.ravel(), t.ravel(), np.array([[-1, 1, 1, -1]]).T, np.array([[-1, -1, 1, 1]]).T
    shapes = np.array([(1 + p * s) * (1 + q * t), p * (1 + q * t), q * (1 + p * s)]) / 4  # of the corners, and their slopes by s and t
    points, ds, dt = np.asarray(corners, float).T @ shapes
    return points, np.outer(weight, weight).ravel() * np.abs(ds[0] * dt[1] - ds[1] * dt[0])


def _moments(points, weights):
    """Area, centre (2,), points about the centre (2, 9), and their second moments (mu_20, mu_11, mu_02)."""
    a = weights.sum()
    if not a > 0:
        raise ValueError("the quadrilateral has no area, hence no features; give four corners in order round the target")
    centre = points @ weights / a
    u, v = centred = points - centre[:, None]
    return a, centre, centred, np.array([u * u, u * v, v * v]) @ weights


@dataclass(frozen=True)
class AdaptiveGain:
    """A gain [1/s] that is large near the goal and small far from it, lest the camera rush:

        gain(e) = (near - far) exp(-slope |e| / (near - far)) + far,    |e| the largest component.

    near, far: the gains at e = 0 and far away; slope: how fast it falls at e = 0.  Raises ValueError unless near > far > 0 and slope > 0.
    """

    near: float = 2.0
    far: float = 0.5
    slope: float = 4.0

    def __post_init__(self):
        if not (self.near > self.far > 0 and self.slope > 0):
            raise ValueError(f"near, far, slope are {self.near}, {self.far}, {self.slope}; near > far > 0 and slope > 0 are needed")

    def __call__(self, e):
        """The gain at the error e (4,)."""
        return (self.near - self.far) * np.exp(-self.slope * np.abs(e).max() / (self.near - self.far)) + self.far


def control(e, L, gain, drift=0.0, dof=6):
    """The control law v = -gain L^+ e - L^+ de/dt, (17), whose gain print has lost.

    e: (4,) error; L: (4, 6); gain: a number [1/s] or an `AdaptiveGain`; drift: (4,) the estimate of de/dt, what the target does by itself.
    dof: 6, with the pseudo-inverse of minimum norm, which shares a motion along y between vy and wx; or 4: vx, vy, vz, wz alone.
    Returns the camera's twist (6,) [m/s, rad/s].  Raises ValueError for another dof and where L is singular.
    """
    if dof not in AXES:
        raise ValueError(f"dof is {dof}; it must be 6, or 4 for vx, vy, vz, wz")
    J, wanted = L[:, AXES[dof]], -(gain(e) if callable(gain) else gain) * e - drift
    v = np.zeros(6)
    try:
        v[AXES[dof]] = J.T @ np.linalg.solve(J @ J.T, wanted)  # J^+ = J^T (J J^T)^-1 where the rows are independent
    except np.linalg.LinAlgError:
        v[:] = np.nan
    if not np.abs(L @ v - wanted).max() <= 1e-6 * np.abs(wanted).max():
        raise ValueError("the interaction matrix is singular: some features cannot be controlled; free more axes, or choose other features")
    return v
