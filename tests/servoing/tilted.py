"""The interaction matrix in a plane of any tilt, to judge that of a parallel one by."""

import numpy as np

from mkt.servoing.features import quadrature
from mkt.types import Array, ArrayLike


def interaction_matrix_tilted(corners: ArrayLike, plane: ArrayLike) -> Array:
    """L of the features `moments`, for a target in a plane of any tilt.

    Every point of the target moves by the interaction matrix of a point,
    dx/dt = l(x) v.  So a moment m = int f(x) dx changes by
    dm/dt = int (grad f . l + f div l) dx v.  The integrals are sums over nine points,
    exact for the polynomials that occur here.

    Parameters
    ----------
    corners : (4, 2) array_like
        In normalised image coordinates, in order.
    plane : (A, B, C) [1/m]
        With 1 / Z = A x + B y + C.

    Returns
    -------
    (4, 6) array
    """
    points, weights = quadrature(corners)
    a = weights.sum()
    centre = points @ weights / a
    centred = points - centre[:, None]
    u, v = centred
    m20, m11, m02 = np.array([u * u, u * v, v * v]) @ weights
    flow, divergence = _flow(points, plane)
    # The centre: f is a coordinate about it, over the area.
    L_centre = (flow + divergence * centred[:, None]) @ weights / a
    # The second moments: f is u^2, v^2 and u v.
    squares = 2 * centred[:, None] * flow + divergence * centred[:, None] ** 2
    L_20, L_02 = squares @ weights
    L_11 = (u * flow[1] + v * flow[0] + divergence * u * v) @ weights
    # The area: f is 1, and a_n = a^(-1/2).
    a_n = 1 / np.sqrt(a)
    L_an = -a_n / (2 * a) * (divergence @ weights)
    # The axis: tan(2 alpha) = 2 m11 / (m20 - m02).
    difference = m20 - m02
    numerator = difference * L_11 - m11 * (L_20 - L_02)
    L_alpha = numerator / (difference**2 + 4 * m11**2)
    # x_n = a_n x_g and y_n = a_n y_g by the product rule.
    L_xy = a_n * L_centre + np.outer(centre, L_an)
    return np.array([*L_xy, L_an, L_alpha])


def _flow(points: Array, plane: ArrayLike) -> tuple[Array, Array]:
    """The interaction matrices l (2, 6, 9) of points (2, 9), and div l (6, 9)."""
    x, y = points
    A, B, C = np.asarray(plane, float)
    d = A * x + B * y + C  # inverse depths
    o = np.zeros_like(x)
    along_x = [-d, o, x * d, x * y, -1 - x * x, y]
    along_y = [o, -d, y * d, 1 + y * y, -x * y, -x]
    divergence = [o - A, o - B, 3 * d - C, 3 * y, -3 * x, o]
    return np.array([along_x, along_y]), np.array(divergence)
