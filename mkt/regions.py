"""The one currency of the library: oriented rectangles (and the ellipses inside them) in an image.

A *region* is a float64 array ``(..., 5) = (cx, cy, theta, hx, hy)``:

=========  ======================================================================================
cx, cy     centre [px]; x to the right, y down, pixel centres at integers
theta      orientation [rad], counted from x towards y, that is clockwise on the screen
hx, hy     half axes [px], along the region's own x and y
=========  ======================================================================================

*Canonical* points live in the square [-1, 1]^2 that `warp` lays over the region.  `unwarp` is the deformation f_x of [T09], which pulls
image points back to the object (its equation (1) is lost and rebuilt in notebook 01); `warp` is its inverse.

Explained in notebook 01.
"""

import numpy as np

CX, CY, THETA, HX, HY = range(5)
_CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def as_regions(regions):
    """Regions as float64 (..., 5).  Raises ValueError for any other shape."""
    regions = np.asarray(regions, float)
    if regions.shape[-1:] != (5,):
        raise ValueError(f"regions must have the shape (..., 5), each (cx, cy, theta, hx, hy), not {regions.shape}")
    return regions


def checked(region):
    """The region (5,) that a tracker is to start on, as float64.  Raises ValueError where it is not one, is not finite, or has no area."""
    region = as_regions(region)
    if region.shape != (5,):
        raise ValueError(f"one region (cx, cy, theta, hx, hy) is needed, not an array of the shape {region.shape}")
    if not np.isfinite(region).all():
        raise ValueError(f"the region {region} is not finite; give five numbers (cx, cy, theta, hx, hy)")
    if min(*region[HX:], region[HX] * region[HY]) <= 0:  # the product of tiny ones may be rounded to 0
        raise ValueError(f"the region {region} has no area; its half axes hx and hy must be positive")
    return region


def rotation(theta):
    """Rotation matrices R(theta), clockwise on the screen.

    theta: (...) [rad].  Returns (..., 2, 2).
    """
    c, s = np.cos(theta), np.sin(theta)
    return np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)


def warp_matrices(regions):
    """The affine maps from canonical points to image points, g(p) = c + R(theta) diag(hx, hy) p.

    regions: (..., 5) [px, rad].  Returns (..., 2, 3), so that ``A @ (px, py, 1)`` is the image point [px].
    """
    regions = as_regions(regions)
    c, s = np.cos(regions[..., THETA]), np.sin(regions[..., THETA])
    hx, hy = regions[..., HX], regions[..., HY]
    matrices = np.empty((*regions.shape[:-1], 2, 3))  # filled in place: an optimiser warps one region in every step
    matrices[..., 0, 0], matrices[..., 0, 1] = c * hx, -s * hy
    matrices[..., 1, 0], matrices[..., 1, 1] = s * hx, c * hy
    matrices[..., 2] = regions[..., :2]
    return matrices


def warp(regions, points):
    """Carry canonical points into the image.

    regions: (..., 5) [px, rad]; points: (n, 2) canonical.  Returns (..., n, 2) [px].

    >>> quarter = np.pi / 2
    >>> warp([50, 40, quarter, 20, 10], [[1, 0]]).round(9)  # the right end of an object that was turned clockwise lies below its centre
    array([[50., 60.]])
    """
    a = warp_matrices(regions)
    return np.asarray(points) @ np.swapaxes(a[..., :2], -1, -2) + a[..., None, :, 2]


def unwarp(regions, points):
    """Pull image points back into the canonical square, the inverse of `warp`: f_x of [T09], up to the half axes.

    regions: (..., 5) [px, rad] with positive half axes; points: (..., n, 2) [px].  Returns (..., n, 2) canonical.
    """
    regions = as_regions(regions)
    centred = np.asarray(points) - regions[..., None, :2]
    return centred @ rotation(regions[..., THETA]) / regions[..., None, HX:]


def corners(regions):
    """The four corners, clockwise on the screen from the region's own top left.

    regions: (..., 5) [px, rad].  Returns (..., 4, 2) [px].
    """
    return warp(regions, _CORNERS)


def area(regions):
    """Area of the rectangle, 4 hx hy.

    regions: (..., 5) [px, rad].  Returns (...) [px^2].
    """
    regions = as_regions(regions)
    return 4 * regions[..., HX] * regions[..., HY]


def from_box(box, angle=0.0):
    """A region from a box as annotations give it: left, top, width, height, the image's own corner being (0, 0).

    Pixel 0 covers [0, 1] in box coordinates and has its centre at 0 in regions, hence the half pixel.
    box: (..., 4) [px]; angle: (...) [rad], about the centre.  Returns (..., 5).

    >>> from_box([0, 0, 1, 1])  # the first pixel alone
    array([0. , 0. , 0. , 0.5, 0.5])
    """
    x, y, w, h = np.moveaxis(np.asarray(box, float), -1, 0)
    return np.stack([x + w / 2 - 0.5, y + h / 2 - 0.5, np.broadcast_to(angle, x.shape), w / 2, h / 2], -1)


def to_box(regions):
    """The upright box round a region; the inverse of `from_box` where theta is 0.

    regions: (..., 5) [px, rad].  Returns (..., 4): left, top, width, height [px].
    """
    c = corners(regions)
    low, high = c.min(-2), c.max(-2)
    return np.concatenate([low + 0.5, high - low], -1)


def wrap_angle(theta):
    """The same angle in [-pi, pi).

    theta: (...) [rad].  Returns (...) [rad].
    """
    return (np.asarray(theta) + np.pi) % (2 * np.pi) - np.pi


def displaced(region, dx=0.0, dy=0.0, dtheta=0.0, scale=1.0):
    """Copies of a region, moved, turned and scaled: the grids over which surfaces are drawn.

    region: (5,) [px, rad]; dx, dy [px], dtheta [rad], scale: arrays that broadcast to (...).  Returns (..., 5).
    """
    dx, dy, dtheta, scale = np.broadcast_arrays(dx, dy, dtheta, scale)
    cx, cy, theta, hx, hy = region
    return np.stack([cx + dx, cy + dy, theta + dtheta, hx * scale, hy * scale], -1)
