"""Textures that are painted: polygons on a larger canvas, reduced, in uneven colours.

An evenly coloured object would be easier to follow than any real one.
"""

from collections.abc import Iterable

import cv2
import numpy as np

from mkt.types import NDArray

Color = tuple[int, int, int]
Polygon = list[tuple[float, float]]
Shape = tuple[Color, Polygon]

_ENLARGED = 4  # how many times too large it is painted, to be reduced afterwards
_PATCH = 8  # [px] from one draw of the unevenness to the next
_UNEVEN = 0.12  # its standard deviation


def painted(
    shapes: Iterable[Shape],
    size: tuple[int, int],
    seed: int,
    below: Color = (0, 0, 0),
) -> NDArray:
    """Shapes one upon the other as a texture, transparent where there are none.

    Parameters
    ----------
    shapes : iterable of (colour, polygon)
        With corners in tenths of the width.
    size : (width, height) [px]
        Multiples of 8.
    seed : int
        Of the unevenness.
    below : (red, green, blue)
        The colour under transparent pixels, which is seen when tiles are shuffled.

    Returns
    -------
    (height, width, 4) uint8 array
        RGBA.
    """
    w, h = (_ENLARGED * side for side in size)
    rgb = np.full((h, w, 3), below, np.uint8)
    alpha = np.zeros((h, w), np.uint8)
    for color, polygon in shapes:
        outline = np.round(np.array(polygon) * w / 10).astype(np.int32)
        cv2.fillPoly(rgb, [outline], color)
        cv2.fillPoly(alpha, [outline], (255,))
    rgba = cv2.resize(np.dstack([rgb, alpha]), size, interpolation=cv2.INTER_AREA)
    rgba[..., :3] = np.clip(rgba[..., :3] * unevenness(size, seed), 0, 255)
    return rgba


def unevenness(size: tuple[int, int], seed: int) -> NDArray:
    """What uneven paint does to colours: factors (height, width, 1) about 1."""
    rng = np.random.default_rng(seed)
    cells = size[1] // _PATCH, size[0] // _PATCH, 1
    coarse = rng.normal(1, _UNEVEN, cells).astype(np.float32)
    return cv2.resize(coarse, size, interpolation=cv2.INTER_CUBIC)[..., None]


def box(x0: float, y0: float, x1: float, y1: float) -> Polygon:
    """A rectangle from one corner to the other."""
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


def oval(x: float, y: float, rx: float, ry: float) -> Polygon:
    """An ellipse round a place, with its half axes."""
    turns = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    return [(x + rx * np.cos(turn), y + ry * np.sin(turn)) for turn in turns]
