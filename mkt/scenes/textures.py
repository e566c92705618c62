"""What the synthetic scenes are made of: objects with an outline, and backgrounds.

Photographs come from the sample images inside scikit-image and matplotlib, so that
nothing has to be fetched.  The toy car is drawn here.  All textures are (h, w, 4) uint8
RGBA arrays, transparent where the object is not.

Shown in notebook 02.
"""

from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from mkt.files import DataError, installed_file
from mkt.types import NDArray

OBJECTS = ("car", "astronaut", "badge", "cat", "cup", "motorcycle", "hopper")
CUT_OUT = ("ring", "starfish")  # objects with a hole, and with limbs
BACKGROUNDS = (
    "workshop",
    "table",
    "launch pad",
    "tissue",
    "fur",
    "portrait",
    "bricks",
    "grass",
    "gravel",
)

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


_PHOTOGRAPHS = {
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
    "launch pad": _Photograph("rocket.jpg"),
    "tissue": _Photograph("ihc.png"),
    "fur": _Photograph("chelsea.png"),
    "portrait": _Photograph("grace_hopper.jpg", package="matplotlib"),
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


@lru_cache(maxsize=32)
def texture(name: str) -> NDArray:
    """A texture by its name, at the resolution of its source.

    Parameters
    ----------
    name : str
        One of `OBJECTS`, `CUT_OUT` or `BACKGROUNDS`.

    Returns
    -------
    (h, w, 4) uint8 array
        RGBA, read-only.

    Raises
    ------
    ValueError
        Listing the names.
    """
    if name != "car" and name not in _PHOTOGRAPHS:
        raise ValueError(
            f"no texture {name!r}; there are car, {', '.join(_PHOTOGRAPHS)}"
        )
    rgba = _car() if name == "car" else _photograph(name)
    rgba.setflags(write=False)
    return rgba


def _photograph(name: str) -> NDArray:
    """The texture of a photograph, (h, w, 4) RGBA."""
    photograph = _PHOTOGRAPHS[name]
    rgb = _pixels(photograph)
    if name in _TINTS:
        rgb = (rgb * (np.array(_TINTS[name]) / 255)).astype(np.uint8)
    if photograph.part:
        x, y, w, h = photograph.part
        rgb = rgb[y : y + h, x : x + w]
    h, w = rgb.shape[:2]
    return np.dstack([rgb, _OUTLINES[photograph.outline](h, w)])


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
    mask, centre = _ellipse(h, w), (w // 2, h // 2)
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


# The toy car from above, driving to the right: shapes in tenths of its width, painted
# in this order.
_PAINT = {
    "tyre": (35, 35, 38),
    "body": (40, 95, 200),
    "hood": (60, 130, 225),
    "glass": (30, 45, 60),
    "roof": (245, 200, 50),
    "stripe": (235, 240, 245),
    "number": (200, 40, 40),
    "lamp": (255, 245, 190),
    "tail": (215, 30, 40),
    "door": (25, 150, 90),
}


def _box(x0: float, y0: float, x1: float, y1: float) -> list[tuple[float, float]]:
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


_CAR = [
    ("tyre", _box(1.3, 0.0, 3.0, 0.9)),
    ("tyre", _box(1.3, 5.35, 3.0, 6.25)),
    ("tyre", _box(6.9, 0.0, 8.6, 0.9)),
    ("tyre", _box(6.9, 5.35, 8.6, 6.25)),
    (
        "body",
        [
            (0.4, 0.9),
            (1.2, 0.35),
            (8.3, 0.35),
            (9.5, 1.1),
            (9.9, 2.2),
            (9.9, 4.05),
            (9.5, 5.15),
            (8.3, 5.9),
            (1.2, 5.9),
            (0.4, 5.35),
        ],
    ),
    (
        "hood",
        [
            (6.9, 0.8),
            (8.2, 0.8),
            (9.2, 1.4),
            (9.5, 2.3),
            (9.5, 3.95),
            (9.2, 4.85),
            (8.2, 5.45),
            (6.9, 5.45),
        ],
    ),
    ("door", _box(3.0, 0.4, 5.9, 1.0)),
    ("tail", _box(3.0, 5.25, 5.9, 5.85)),
    ("stripe", _box(6.9, 2.65, 9.85, 3.6)),
    ("stripe", _box(0.5, 2.65, 2.2, 3.6)),
    ("glass", [(5.9, 1.3), (6.9, 0.95), (6.9, 5.3), (5.9, 4.95)]),
    ("glass", [(2.2, 1.2), (3.0, 1.5), (3.0, 4.75), (2.2, 5.05)]),
    ("roof", _box(3.0, 1.3, 5.9, 4.95)),
    (
        "number",
        [(3.9, 2.0), (5.2, 1.9), (4.5, 4.3), (4.0, 4.3), (4.6, 2.5), (3.9, 2.5)],
    ),
    ("lamp", [(9.2, 1.0), (9.75, 1.5), (9.85, 2.2), (9.3, 1.8)]),
    ("lamp", [(9.2, 5.25), (9.75, 4.75), (9.85, 4.05), (9.3, 4.45)]),
    ("tail", _box(0.4, 1.0, 0.8, 2.0)),
    ("tail", _box(0.4, 4.25, 0.8, 5.25)),
]
_CAR_SIZE = 256, 160  # (width, height) [px]
_ENLARGED = 4  # how many times too large the car is painted, to be reduced afterwards


def _car() -> NDArray:
    """The toy car, (160, 256, 4) RGBA."""
    width, height = _CAR_SIZE
    w, h = _ENLARGED * width, _ENLARGED * height
    rgb = np.zeros((h, w, 3), np.uint8)
    alpha = np.zeros((h, w), np.uint8)
    for paint, polygon in _CAR:
        outline = np.round(np.array(polygon) * w / 10).astype(np.int32)
        cv2.fillPoly(rgb, [outline], _PAINT[paint])
        cv2.fillPoly(alpha, [outline], (255,))
    large = np.dstack([rgb, alpha])
    rgba = cv2.resize(large, _CAR_SIZE, interpolation=cv2.INTER_AREA)
    rgba[..., :3] = np.clip(rgba[..., :3] * _unevenness(), 0, 255)
    return rgba


def _unevenness() -> NDArray:
    """What uneven paint does to the car's colours: factors (160, 256, 1)."""
    rng = np.random.default_rng(2009)
    coarse = rng.normal(1, 0.12, (20, 32, 1)).astype(np.float32)
    return cv2.resize(coarse, _CAR_SIZE, interpolation=cv2.INTER_CUBIC)[..., None]
