"""The one currency of the library: oriented rectangles and their ellipses.

A *region* is a float64 array ``(..., 5) = (cx, cy, theta, hx, hy)``:

=========  ===================================================================
cx, cy     centre [px]; x to the right, y down, pixel centres at integers
theta      orientation [rad], counted from x towards y: clockwise on the screen
hx, hy     half axes [px], along the region's own x and y
=========  ===================================================================

*Canonical* points live in the square [-1, 1]^2 that `warp` lays over the region.
`unwarp` is the deformation f_x of [T09], which pulls image points back to the object
(equation (1) is not legible in our copy; notebook 01 rebuilds it); `warp` is its
inverse.

Explained in notebook 01.
"""

import numpy as np

from mkt.types import Array, ArrayLike, NDArray, Region, Regions

CX, CY, THETA, HX, HY = range(5)
SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def as_regions(regions: ArrayLike) -> Regions:
    """Regions as float64.

    Parameters
    ----------
    regions : (..., 5) array_like [px, rad]

    Raises
    ------
    ValueError
        For any other shape.
    """
    regions = np.asarray(regions, float)
    if regions.shape[-1:] != (5,):
        raise ValueError(
            "regions must have the shape (..., 5), each (cx, cy, theta, hx, hy), "
            f"not {regions.shape}"
        )
    return regions


def as_one_region(region: ArrayLike) -> Region:
    """One region (5,) as float64.

    Raises
    ------
    ValueError
        For any other shape.
    """
    region = np.asarray(region, float)
    if region.shape != (5,):
        raise ValueError(
            f"region has the shape {region.shape}; give one, (cx, cy, theta, hx, hy)"
        )
    return region


def rotation(theta: ArrayLike) -> Array:
    """Rotation matrices R(theta), clockwise on the screen.

    Parameters
    ----------
    theta : (...) array_like [rad]

    Returns
    -------
    (..., 2, 2) array
    """
    c, s = np.cos(theta), np.sin(theta)
    return np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)


def warp_matrices(regions: ArrayLike) -> Array:
    """The affine maps g(p) = c + R(theta) diag(hx, hy) p, canonical to image.

    Parameters
    ----------
    regions : (..., 5) array_like [px, rad]

    Returns
    -------
    (..., 2, 3) array
        A, so that ``A @ (px, py, 1)`` is the image point [px].
    """
    regions = as_regions(regions)
    c, s = np.cos(regions[..., THETA]), np.sin(regions[..., THETA])
    hx, hy = regions[..., HX], regions[..., HY]
    # Filled in place: an optimiser warps one region in every step.
    matrices = np.empty((*regions.shape[:-1], 2, 3))
    matrices[..., 0, 0] = c * hx
    matrices[..., 0, 1] = -s * hy
    matrices[..., 1, 0] = s * hx
    matrices[..., 1, 1] = c * hy
    matrices[..., 2] = regions[..., :2]
    return matrices


def warp(regions: ArrayLike, points: ArrayLike) -> Array:
    """Carry canonical points into the image.

    Parameters
    ----------
    regions : (..., 5) array_like [px, rad]
    points : (n, 2) array_like, canonical

    Returns
    -------
    (..., n, 2) array [px]

    Examples
    --------
    The right end of an object that was turned clockwise lies below its centre.

    >>> warp([50, 40, np.pi / 2, 20, 10], [[1, 0]]).round(9)
    array([[50., 60.]])
    """
    a = warp_matrices(regions)
    return np.asarray(points) @ np.swapaxes(a[..., :2], -1, -2) + a[..., None, :, 2]


def unwarp(regions: ArrayLike, points: ArrayLike) -> Array:
    """Pull image points back into the canonical square: f_x of [T09].

    It is the inverse of `warp`, and f_x up to the half axes.

    Parameters
    ----------
    regions : (..., 5) array_like [px, rad]
        With positive half axes.
    points : (..., n, 2) array_like [px]

    Returns
    -------
    (..., n, 2) array, canonical
    """
    regions = as_regions(regions)
    centred = np.asarray(points) - regions[..., None, :2]
    return centred @ rotation(regions[..., THETA]) / regions[..., None, HX:]


def corners(regions: ArrayLike) -> Array:
    """The four corners, clockwise on the screen from the region's own top left.

    Parameters
    ----------
    regions : (..., 5) array_like [px, rad]

    Returns
    -------
    (..., 4, 2) array [px]
    """
    return warp(regions, SQUARE)


def area(regions: ArrayLike) -> Array:
    """Area of the rectangle, 4 hx hy.

    Parameters
    ----------
    regions : (..., 5) array_like [px, rad]

    Returns
    -------
    (...) array [px^2]
    """
    regions = as_regions(regions)
    return 4 * regions[..., HX] * regions[..., HY]


def size(regions: ArrayLike) -> Array:
    """Half the side of the square of the same area, sqrt(hx hy).

    Parameters
    ----------
    regions : (..., 5) array_like [px, rad]

    Returns
    -------
    (...) array [px]
    """
    regions = as_regions(regions)
    return np.sqrt(regions[..., HX] * regions[..., HY])


def from_box(box: ArrayLike, angle: ArrayLike = 0.0) -> Regions:
    """A region from a box as annotations give it.

    In box coordinates pixel 0 covers [0, 1], in regions its centre is at 0: hence the
    half pixel.

    Parameters
    ----------
    box : (..., 4) array_like [px]
        Left, top, width, height; the image's own corner is (0, 0).
    angle : (...) array_like [rad]
        Clockwise, about the centre.

    Returns
    -------
    (..., 5) array [px, rad]

    Raises
    ------
    ValueError
        For another number of numbers.

    Examples
    --------
    The first pixel alone.

    >>> from_box([0, 0, 1, 1])
    array([0. , 0. , 0. , 0.5, 0.5])
    """
    numbers = np.asarray(box, float)
    if not numbers.ndim or numbers.shape[-1] != 4:
        raise ValueError(
            "a box is (left, top, width, height), four numbers, "
            f"not an array of the shape {numbers.shape}"
        )
    x, y, w, h = np.moveaxis(numbers, -1, 0)
    theta = np.broadcast_to(angle, x.shape)
    return np.stack([x + w / 2 - 0.5, y + h / 2 - 0.5, theta, w / 2, h / 2], -1)


def to_box(regions: ArrayLike) -> Array:
    """The upright box round a region; the inverse of `from_box` where theta is 0.

    Parameters
    ----------
    regions : (..., 5) array_like [px, rad]

    Returns
    -------
    (..., 4) array [px]
        Left, top, width, height.
    """
    c = corners(regions)
    low, high = c.min(-2), c.max(-2)
    return np.concatenate([low + 0.5, high - low], -1)


def outside(regions: ArrayLike, shape: tuple[int, ...]) -> NDArray:
    """Whether the upright boxes round regions lie outside an image altogether.

    Parameters
    ----------
    regions : (..., 5) array_like [px, rad]
    shape : (height, width, ...) of the image [px]

    Returns
    -------
    (...) bool array
        False for NaN.
    """
    x, y, w, h = np.moveaxis(to_box(regions), -1, 0)
    return (x >= shape[1]) | (y >= shape[0]) | (x + w <= 0) | (y + h <= 0)


def wrap_angle(theta: ArrayLike, period: float = 2 * np.pi) -> Array:
    """The same angle in [-pi, pi), or in [-period / 2, period / 2).

    Parameters
    ----------
    theta : (...) array_like [rad]
    period : float [rad]
        Pi for the axis of something that looks the same after half a turn.

    Returns
    -------
    (...) array [rad]
    """
    end = period / 2
    wrapped = (np.asarray(theta) + end) % period - end
    return np.where(wrapped >= end, -end, wrapped)[()]  # rounded up to the end


def displaced(
    region: ArrayLike,
    dx: ArrayLike = 0.0,
    dy: ArrayLike = 0.0,
    dtheta: ArrayLike = 0.0,
    scale: ArrayLike = 1.0,
) -> Regions:
    """Copies of a region, moved, turned and scaled: the grids of cost surfaces.

    Parameters
    ----------
    region : (5,) array_like [px, rad]
    dx, dy : (...) array_like [px]
    dtheta : (...) array_like [rad]
    scale : (...) array_like
        Arrays that broadcast to one shape.

    Returns
    -------
    (..., 5) array [px, rad]

    Raises
    ------
    ValueError
        For a region of another shape, and arrays that do not broadcast.
    """
    dx, dy, dtheta, scale = np.broadcast_arrays(dx, dy, dtheta, scale)
    cx, cy, theta, hx, hy = as_one_region(region)
    return np.stack([cx + dx, cy + dy, theta + dtheta, hx * scale, hy * scale], -1)
