"""Paths: way-points of layers and of cameras, what joins them, and random smooth ones.

A way-point is (frame, x [px], y [px], theta [rad], scale); a path is a tuple of them,
so that a scene can be hashed.
"""

import reprlib
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from mkt.checks import are_finite, check_seed
from mkt.types import Array, ArrayLike, Rng

Path = tuple[tuple[float, ...], ...]
STILL: Path = ((0.0, 0.0, 0.0, 0.0, 1.0),)

LENGTH = 120  # frames of a scene, unless it says otherwise
WIDTH = 80.0  # of its object [px]
MIDDLE = np.array([160.0, 120.0])  # of the image [px]
EDGES = 60.0, 50.0  # [px] how near to the border an object's centre may come
BEAT = 15.0  # frames from one way-point of a walk or of a camera to the next


def check_points(specification: Any, **numbers: int) -> None:
    """Refuse a field that is no tuple of points, each a tuple of so many numbers.

    They must be finite, and the frames must rise.

    Parameters
    ----------
    specification : object
        The dataclass whose fields are looked at.
    **numbers : int
        Field name -> how many numbers a point has, the frame included.

    Raises
    ------
    ValueError
        Naming the field.
    """
    for field, n in numbers.items():
        points = getattr(specification, field)
        given = isinstance(points, tuple) and bool(points)
        if not given or not all(
            isinstance(point, tuple) and len(point) == n for point in points
        ):
            raise ValueError(
                f"{field} is {reprlib.repr(points)}; give a tuple of at least one "
                f"point, each a tuple of {n} numbers, the first of which is the frame"
            )
        finite = are_finite(points, None, n)
        if not finite or (np.diff([point[0] for point in points]) <= 0).any():
            raise ValueError(
                f"{field} is {reprlib.repr(points)}; give finite numbers, and frames "
                "that rise from point to point"
            )


def lots(story: int, seed: int) -> Rng:
    """The random numbers of one story: other stories of the same seed have others.

    Raises
    ------
    ValueError
        For a seed that is none.
    """
    check_seed(seed)
    return np.random.default_rng((story, seed))


@lru_cache(maxsize=256)
def spline(path: Path) -> Callable[[ArrayLike], Array]:
    """The smooth curve through way-points: times (...) -> values (..., k).

    For way-points of another kind as well, (frame, k values); one alone stays.  A curve
    goes on for a frame beyond its ends, where a shutter may be open; then it stays.
    """
    table = np.array(path, float)
    values = table[:, 1:]
    if len(table) == 1:
        return lambda t: np.broadcast_to(values[0], (*np.shape(t), values.shape[1]))
    from scipy.interpolate import CubicSpline  # slow to import, and many draw nothing

    curve = CubicSpline(table[:, 0], values)
    first, last = table[0, 0] - 1, table[-1, 0] + 1
    return lambda t: curve(np.clip(t, first, last))


def joined(points: Path, t: float | Array) -> Array:
    """Values (..., k) at the times t (...) of points (frame, k values), by lines."""
    times, *columns = np.array(points, float).T
    return np.stack([np.interp(t, times, column) for column in columns], -1)


def way(
    times: ArrayLike,
    x: ArrayLike,
    y: ArrayLike,
    theta: ArrayLike = 0.0,
    scale: ArrayLike = 1.0,
) -> Path:
    """Way-points (frame, px, px, rad, factor) from columns (n,) that broadcast."""
    columns = np.broadcast_arrays(times, x, y, theta, scale)
    return as_path(np.column_stack(columns))


def as_path(table: ArrayLike) -> Path:
    """A table (n, k) as a path, rounded to three places."""
    rows = np.round(np.asarray(table, float), 3)
    return tuple(tuple(map(float, row)) for row in rows)


def standing(x: float, y: float) -> Path:
    """A path that stays where it is [px]."""
    return ((0.0, float(x), float(y), 0.0, 1.0),)


def roaming(
    rng: Rng,
    length: int = LENGTH,
    every: int = 20,
    turn: float = 0.5,
    growth: float = 0.25,
) -> Path:
    """A smooth random walk inside the image that turns and changes its size.

    It starts from rest, so that the first frame, where it is learnt, is sharp.

    Parameters
    ----------
    rng : numpy.random.Generator
    length : int
        Frames.
    every : int
        Frames from one way-point to the next.
    turn : float [rad]
        Standard deviation of the rotation from one to the next.
    growth : float
        Bound on the logarithm of the sizes at the way-points, which are then divided by
        the first.  The curve between them goes a little beyond.
    """
    times = np.arange(0, length + every, every, dtype=float)
    places = rng.uniform([70, 60], [250, 180], (len(times), 2))
    angles = np.cumsum(rng.normal(0, turn, len(times)))
    scales = np.exp(rng.uniform(-growth, growth, len(times)))
    table = np.column_stack([times, places, angles - angles[0], scales / scales[0]])
    start = table[:1]
    frame = np.array([1.0, 0, 0, 0, 0])
    rest = [start - 2 * frame, start - frame, start]
    return as_path(np.concatenate([*rest, table[1:] + 2 * frame]))


def wandering(rng: Rng, length: int, step: float, spread: float) -> Path:
    """An upright walk that begins in the middle and stays inside the image.

    Parameters
    ----------
    rng : numpy.random.Generator
    length : int
        Frames.
    step : float [px]
        Standard deviation from one way-point to the next, 15 frames later.
    spread : float
        Bound on the logarithm of the size at the way-points; the curve between them
        goes beyond.
    """
    times = np.arange(0, length + BEAT, BEAT)
    steps = rng.normal(0, step, (len(times), 2))
    steps[0] = 0
    places = np.clip(MIDDLE + np.cumsum(steps, 0), EDGES, 2 * MIDDLE - EDGES)
    return way(times, *places.T, scale=sizes(rng, len(times), spread))


def shaking(rng: Rng, length: int, step: float, zoom: float) -> Path:
    """A camera that wanders about and zooms.

    Parameters
    ----------
    rng : numpy.random.Generator
    length : int
        Frames.
    step : float [px]
        How far it wanders.
    zoom : float
        Bound on the logarithm of the size at the way-points; the curve between them
        goes beyond.
    """
    times = np.arange(0, length + BEAT, BEAT)
    shifts = rng.normal(0, step, (len(times), 2))
    shifts[0] = 0
    x, y = shifts.T
    turns = rng.normal(0, 0.01, len(times))
    return way(times, x, y, turns, sizes(rng, len(times), zoom))


def sizes(rng: Rng, n: int, spread: float) -> Array:
    """Sizes (n,), the first of them 1, their logarithms within `spread` of 0."""
    logarithms = rng.uniform(-spread, spread, n)
    logarithms[0] = 0
    return np.exp(logarithms)


def position(path: Path, frame: float) -> tuple[float, float]:
    """About where a path is at a frame, (x, y) [px], if its way-points were joined."""
    times, x, y, *_ = np.array(path).T
    return float(np.interp(frame, times, x)), float(np.interp(frame, times, y))
