"""Right pieces of labs, for checks that need one in place of a student's own.

They are here and not in the checks, where who has not written a piece yet would read
how it is done.
"""

import numpy as np

from mkt.types import Array, ArrayLike, NDArray


def histogram(labels: NDArray, weights: Array, m: int) -> Array:
    """Lab 1: the histogram (m,) of bins (n,) with weights (n,); m is outside."""
    q = np.bincount(labels, weights, minlength=m + 1)[:m]
    return q / q.sum()


def through(H: ArrayLike, points: ArrayLike) -> Array:
    """Lab 8: where points (n, 2) of a plane are seen under (3, 3) H.

    Unlike `mkt.homographies.through` it takes complex ones, for which whoever takes a
    derivative by a complex step asks.
    """
    H, points = np.asarray(H), np.asarray(points)
    seen = points @ H[:, :2].T + H[:, 2]
    return seen[..., :2] / seen[..., 2:]


def velocity(G: ArrayLike, points: ArrayLike) -> Array:
    """Lab 8: velocities (n, 2) of points (n, 2) of the plane under (3, 3) G.

    By moving them a hair, because a check may ask for complex ones.
    """
    h = 1e-3
    steps = h * np.asarray(G)
    there, back = (through(np.eye(3) + step, points) for step in (steps, -steps))
    return (there - back) / (2 * h)


def moved(centres: Array, velocity: Array, runs: NDArray, walk: Array) -> Array:
    """Lab 6: centres (N, 2) a frame later; velocity (2,) is that of the runners."""
    return np.where(np.asarray(runs)[:, None], centres + velocity, centres) + walk


def tilt(H: Array, C: Array) -> float:
    """Lab 8: the angle [rad] of a plane's normal with the view, (3, 3) H and C."""
    r1, r2 = (np.linalg.inv(C) @ H).T[:2]
    normal = np.cross(r1, r2)
    return float(np.arctan2(np.hypot(*normal[:2]), abs(normal[2])))
