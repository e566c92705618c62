"""Photographs for the scenes: files of installed packages, or parts of them.

They are the sample images inside scikit-image and matplotlib, so that nothing has to be
fetched.
"""

from typing import NamedTuple

import cv2
import numpy as np

from mkt.files import DataError, installed_file
from mkt.types import NDArray

_FOLDERS = {
    "scikit-image": "skimage/data/",
    "matplotlib": "matplotlib/mpl-data/sample_data/",
}


class _Photograph(NamedTuple):
    """A file of a package, or a part of it, which may be cut along an outline.

    Attributes
    ----------
    file : str
    part : (left, top, width, height) [px], optional
    outline : str
        "whole", "ellipse", "ring" or "star".
    package : str
    """

    file: str
    part: tuple[int, int, int, int] | None = None
    outline: str = "whole"
    package: str = "scikit-image"


PHOTOGRAPHS = {
    "astronaut": _Photograph("astronaut.png", (165, 10, 130, 160)),
    "badge": _Photograph("astronaut.png", (110, 310, 160, 120)),
    "cat": _Photograph("chelsea.png", (110, 20, 260, 195)),
    "cup": _Photograph("coffee.png", (146, 12, 320, 340), "ellipse"),
    "motorcycle": _Photograph("motorcycle_left.png", (150, 125, 390, 275)),
    "hopper": _Photograph(
        "grace_hopper.jpg", (175, 90, 170, 230), "ellipse", "matplotlib"
    ),
    "ring": _Photograph("coffee.png", (146, 12, 320, 340), "ring"),
    "starfish": _Photograph("astronaut.png", (110, 310, 160, 120), "star"),
    "workshop": _Photograph("motorcycle_right.png"),
    "table": _Photograph("coffee.png"),
    "tissue": _Photograph("ihc.png"),
    "fur": _Photograph("chelsea.png"),
    "bricks": _Photograph("brick.png"),
    "grass": _Photograph("grass.png"),
    "gravel": _Photograph("gravel.png"),
}
# Grey photographs are given a colour: white becomes this.
_TINTS = {
    "bricks": (235, 150, 120),
    "grass": (150, 215, 110),
    "gravel": (225, 210, 180),
}


def photograph(name: str) -> NDArray:
    """A photograph by its name in `PHOTOGRAPHS`, tinted, and cut along its outline.

    Returns
    -------
    (h, w, 4) uint8 array
        RGBA.

    Raises
    ------
    DataError
        For a file that is not there or cannot be read.
    """
    chosen = PHOTOGRAPHS[name]
    rgb = _pixels(chosen)
    if name in _TINTS:
        rgb = (rgb * (np.array(_TINTS[name]) / 255)).astype(np.uint8)
    if chosen.part:
        x, y, w, h = chosen.part
        rgb = rgb[y : y + h, x : x + w]
    h, w = rgb.shape[:2]
    return np.dstack([rgb, _OUTLINES[chosen.outline](h, w)])


def _pixels(photograph: _Photograph) -> NDArray:
    """The whole file, (H, W, 3) RGB."""
    name = _FOLDERS[photograph.package] + photograph.file
    path = installed_file(photograph.package, name)
    bgr = cv2.imread(str(path))
    if bgr is None:
        reinstall = "python -m pip install --force-reinstall"
        raise DataError(
            path,
            "not an image, or cut short",
            f"install it again with: {reinstall} {photograph.package}",
        )
    return cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)


def _ellipse(h: int, w: int) -> NDArray:
    """An alpha channel (h, w) that is opaque inside the inscribed ellipse.

    Its edge is soft.
    """
    mask = np.zeros((h, w), np.uint8)
    centre = w // 2, h // 2
    axes = w // 2 - 1, h // 2 - 1
    return cv2.ellipse(mask, centre, axes, 0, 0, 360, 255, -1, cv2.LINE_AA)


def _ring(h: int, w: int) -> NDArray:
    """The ellipse without its inner part, seven tenths of its axes."""
    mask = _ellipse(h, w)
    centre = (w // 2, h // 2)
    inner = 7 * w // 20, 7 * h // 20
    return cv2.ellipse(mask, centre, inner, 0, 0, 360, 0, -1, cv2.LINE_AA)


def _star(h: int, w: int) -> NDArray:
    """A star of five slender limbs that touch the ellipse."""
    turns = np.pi * (np.arange(10) / 5 - 0.5)
    reach = np.where(np.arange(10) % 2, 0.3, 1.0)[:, None]
    directions = np.stack([np.cos(turns), np.sin(turns)], -1)
    corners = np.array([w, h]) / 2 * (1 + reach * directions)
    mask = np.zeros((h, w), np.uint8)
    return cv2.fillPoly(mask, [np.rint(corners).astype(np.int32)], 255, cv2.LINE_AA)


_OUTLINES = {
    "whole": lambda h, w: np.full((h, w), 255, np.uint8),
    "ellipse": _ellipse,
    "ring": _ring,
    "star": _star,
}
