"""Homographies: how a plane in space is seen, and the group that they form.

A *homography* is a matrix (3, 3) that takes the canonical square of `mkt.regions` to
the image, (x, y, 1) -> w (u, v, 1), with 1 as its last element.  A region is a
homography whose last row is (0, 0, 1), so every function that looks an object up in a
frame takes either of them.

Its motions are generators of sl(3), matrices without trace, in the *object plane* of
`mkt.kernels`, where the object is not stretched.  They stand in an order in which the
first four make a similarity, the first six an affine map, and all eight a homography:

==================  ============================================================
tau_x, tau_y        a shift
theta, log s        a turn and a change of size
stretch, shear      x grows while y shrinks; the same along the diagonals
tilt_x, tilt_y      the right or the lower side goes away from the viewer
==================  ============================================================

Explained in notebook 16.
"""

import numpy as np

from mkt.regions import SQUARE, THETA, as_regions, warp_matrices
from mkt.types import Array, ArrayLike

PARAMETERS = (
    "tau_x",
    "tau_y",
    "theta",
    "log s",
    "stretch",
    "shear",
    "tilt_x",
    "tilt_y",
)
GROUPS = {"similarity": 4, "affine": 6, "homography": 8}  # how many of them
GENERATORS = np.array(
    [
        [[0, 0, 1], [0, 0, 0], [0, 0, 0]],
        [[0, 0, 0], [0, 0, 1], [0, 0, 0]],
        [[0, -1, 0], [1, 0, 0], [0, 0, 0]],
        [[1 / 3, 0, 0], [0, 1 / 3, 0], [0, 0, -2 / 3]],
        [[1, 0, 0], [0, -1, 0], [0, 0, 0]],
        [[0, 1, 0], [1, 0, 0], [0, 0, 0]],
        [[0, 0, 0], [0, 0, 0], [1, 0, 0]],
        [[0, 0, 0], [0, 0, 0], [0, 1, 0]],
    ]
)
HORIZON = 1e-6  # w of a point at the horizon, or behind the viewer
SERIES, HALVINGS = 8, 4  # of the exponential: its error is below 1e-11 for |A| <= 2


def as_places(places: ArrayLike) -> Array:
    """Regions as (N, 5), or homographies as (N, 3, 3).

    Parameters
    ----------
    places : (..., 5) or (..., 3, 3) array_like [px, rad]

    Raises
    ------
    ValueError
        For any other shape.
    """
    places = np.asarray(places, float)
    if places.shape[-2:] == (3, 3):
        return places.reshape(-1, 3, 3)
    return as_regions(places).reshape(-1, 5)


def maps(places: Array) -> Array:
    """The maps of `as_places` as matrices: (N, 2, 3), or (N, 3, 3) in perspective."""
    return places.copy() if places.ndim == 3 else warp_matrices(places)


def angles(places: Array) -> Array:
    """The orientations (N,) [rad] of `as_places`, at the middle of each."""
    if places.ndim == 2:
        return places[:, THETA]
    return np.arctan2(*_turn(slope_at_middle(places)))


def turning(homography: Array, half_sides: Array, k: int) -> Array:
    """Derivatives of `angles` by the first k parameters of `moved`, at a homography.

    Not theta alone turns what is seen: so does shear, where the object is no square,
    and a shift, where it is seen in perspective.

    Parameters
    ----------
    homography : (3, 3) array
    half_sides : (2,) array
        Of the object in its plane.
    k : int

    Returns
    -------
    (k,) array [rad]
    """
    stretch = np.array([*half_sides, 1.0])
    h = homography / homography[2, 2]
    change = h @ (GENERATORS[:k] * stretch / stretch[:, None])
    change = change - h * change[:, 2:, 2:]  # the last element stays 1
    by = (
        change[:, :2, :2]
        - change[:, :2, 2:] * h[2:, :2]
        - h[:2, 2:] * change[:, 2:, :2]
    )
    across, along = _turn(slope_at_middle(h))
    sideways, ahead = _turn(by)
    return (along * sideways - across * ahead) / (across**2 + along**2)


def _turn(slopes: Array) -> tuple[Array, Array]:
    """Sine and cosine of the turn in derivatives (..., 2, 2), times a common factor."""
    sine = slopes[..., 1, 0] - slopes[..., 0, 1]
    return sine, slopes[..., 0, 0] + slopes[..., 1, 1]


def of_regions(regions: ArrayLike) -> Array:
    """Regions (..., 5) as homographies (..., 3, 3)."""
    matrices = warp_matrices(regions)
    last = np.broadcast_to([0.0, 0.0, 1.0], (*matrices.shape[:-2], 1, 3))
    return np.concatenate([matrices, last], -2)


def slope_at_middle(homographies: Array) -> Array:
    """Derivatives (..., 2, 2) [px] of homographies (..., 3, 3) at the middle (0, 0)."""
    h = homographies / homographies[..., 2:, 2:]
    return h[..., :2, :2] - h[..., :2, 2:] * h[..., 2:, :2]


def as_region(homographies: Array, aspect: float) -> Array:
    """Regions (..., 5) that fit homographies (..., 3, 3) at the object's middle.

    The aspect is the object's hx / hy.

    Parameters
    ----------
    homographies : (..., 3, 3) array
        From the canonical square to the image [px].
    aspect : float

    Returns
    -------
    (..., 5) array [px, rad]
    """
    size = np.sqrt(np.abs(np.linalg.det(slope_at_middle(homographies))))
    x, y = np.moveaxis(homographies[..., :2, 2] / homographies[..., 2:, 2], -1, 0)
    theta = angles(homographies.reshape(-1, 3, 3)).reshape(size.shape)
    return np.stack([x, y, theta, size * aspect**0.5, size / aspect**0.5], -1)


def through(homographies: Array, points: ArrayLike) -> Array:
    """Points (n, 2) through homographies (..., 3, 3): (..., n, 2).

    A point at the horizon, or beyond, goes very far away.

    Parameters
    ----------
    homographies : (..., 3, 3) array
    points : (n, 2) array_like, canonical

    Returns
    -------
    (..., n, 2) array [px]
    """
    h = np.asarray(homographies)
    u = np.asarray(points, float) @ np.swapaxes(h[..., :2], -1, -2)
    u = u + h[..., None, :, 2]
    return u[..., :2] / np.maximum(u[..., 2:], HORIZON)


def corners(homographies: Array) -> Array:
    """The four corners (..., 4, 2) [px] of homographies (..., 3, 3)."""
    return through(homographies, SQUARE)


def corner_error(homographies: Array, truth: Array) -> Array:
    """Root of the mean squared distance of the four corners, (...) [px].

    Of homographies (..., 3, 3) from true ones of the same shape.
    """
    off = corners(homographies) - corners(truth)
    return np.sqrt((off**2).sum(-1).mean(-1))


def exponential(steps: Array) -> Array:
    """The matrix exponential of sum_i x_i G_i for steps (..., k): (..., 3, 3).

    A Taylor series of the matrix over 2^4, squared four times.  For 75 particles it
    takes a quarter of the time of ``scipy.linalg.expm``, its oracle in the tests.

    Raises
    ------
    ValueError
        For a number alone, and for steps of more than eight components.
    """
    shape = np.shape(steps)
    if not shape or shape[-1] > len(PARAMETERS):
        raise ValueError(
            f"steps have the shape {shape}; give (..., k), with k at most "
            f"{len(PARAMETERS)}"
        )
    a = np.tensordot(steps, GENERATORS[: shape[-1]], 1) / 2**HALVINGS
    result = np.eye(3) + a / SERIES
    for n in range(SERIES - 1, 0, -1):
        result = np.eye(3) + a @ result / n
    for _ in range(HALVINGS):
        result = result @ result
    return result


def moved(homographies: Array, steps: Array, half_sides: Array) -> Array:
    """Homographies after steps in the object plane: H <- H exp(sum_i x_i G_i).

    Parameters
    ----------
    homographies : (..., 3, 3) array
    steps : (..., k) array
        Of the first k parameters, in object units.
    half_sides : (2,) array
        Of the object in its plane, see `mkt.kernels.Kernels.half_sides`.

    Returns
    -------
    (..., 3, 3) array
    """
    stretch = np.array([*half_sides, 1.0])
    in_square = exponential(steps) * stretch / stretch[:, None]
    result = homographies @ in_square
    return result / result[..., 2:, 2:]


def flow(points: Array, k: int) -> tuple[Array, Array]:
    """The velocities of points of the object plane under the first k generators.

    d/dx of exp(x G) p at x = 0 is v = (G p)_xy - p (G p)_w, with p = (x, y, 1).

    Parameters
    ----------
    points : (n, 2) array
    k : int

    Returns
    -------
    v : (k, n, 2) array
    divergence : (k, n) array
    """
    g = GENERATORS[:k]
    image = np.column_stack([points, np.ones(len(points))]) @ np.swapaxes(g, 1, 2)
    v = image[..., :2] - points * image[..., 2:]
    away = np.einsum("ki,ni->kn", g[:, 2, :2], points)
    trace = np.trace(g[:, :2, :2], axis1=1, axis2=2)[:, None]
    return v, trace - 2 * image[..., 2] - away
