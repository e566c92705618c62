"""What the synthetic scenes are made of: objects with an outline, and backgrounds.

Photographs come from the sample images inside scikit-image and matplotlib, so that nothing has to be fetched.  The toy car is
drawn here.  All textures are (h, w, 4) uint8 RGBA arrays, transparent where the object is not.

Shown in notebook 02.
"""

from functools import lru_cache

import cv2
import numpy as np

from mkt.datasets import distribution_file

_SKIMAGE, _MATPLOTLIB = ("scikit-image", "skimage/data/"), ("matplotlib", "matplotlib/mpl-data/sample_data/")

# name: (package, folder), file, (left, top, width, height) of the cut [px] or None for all, cut along the inscribed ellipse or not
PHOTOGRAPHS = {
    "astronaut": (_SKIMAGE, "astronaut.png", (165, 10, 130, 160), False),
    "badge": (_SKIMAGE, "astronaut.png", (110, 310, 160, 120), False),
    "cat": (_SKIMAGE, "chelsea.png", (110, 20, 260, 195), False),
    "cup": (_SKIMAGE, "coffee.png", (146, 12, 320, 340), True),
    "motorcycle": (_SKIMAGE, "motorcycle_left.png", (150, 125, 390, 275), False),
    "hopper": (_MATPLOTLIB, "grace_hopper.jpg", (175, 90, 170, 230), True),
    "workshop": (_SKIMAGE, "motorcycle_right.png", None, False),
    "table": (_SKIMAGE, "coffee.png", None, False),
    "launch pad": (_SKIMAGE, "rocket.jpg", None, False),
    "tissue": (_SKIMAGE, "ihc.png", None, False),
    "fur": (_SKIMAGE, "chelsea.png", None, False),
    "portrait": (_MATPLOTLIB, "grace_hopper.jpg", None, False),
    "bricks": (_SKIMAGE, "brick.png", None, False),
    "grass": (_SKIMAGE, "grass.png", None, False),
    "gravel": (_SKIMAGE, "gravel.png", None, False),
}
# Grey photographs are given a colour: white becomes this.
_TINTS = {"bricks": (235, 150, 120), "grass": (150, 215, 110), "gravel": (225, 210, 180)}
OBJECTS = ("car", "astronaut", "badge", "cat", "cup", "motorcycle", "hopper")
BACKGROUNDS = ("workshop", "table", "launch pad", "tissue", "fur", "portrait", "bricks", "grass", "gravel")


@lru_cache(maxsize=32)
def texture(name):
    """A texture by its name, at the resolution of its source.

    Returns (h, w, 4) uint8 RGBA, read-only.  Raises ValueError listing the names.
    """
    if name != "car" and name not in PHOTOGRAPHS:
        raise ValueError(f"no texture {name!r}; there are car, {', '.join(PHOTOGRAPHS)}")
    rgba = _car() if name == "car" else _photograph(name)
    rgba.setflags(write=False)
    return rgba


def _photograph(name):
    (package, folder), file, cut, elliptic = PHOTOGRAPHS[name]
    rgb = cv2.cvtColor(cv2.imread(str(distribution_file(package, folder + file))), cv2.COLOR_BGR2RGB)
    if name in _TINTS:
        rgb = (rgb * (np.array(_TINTS[name]) / 255)).astype(np.uint8)
    if cut:
        x, y, w, h = cut
        rgb = rgb[y:y + h, x:x + w]
    return np.dstack([rgb, _ellipse(rgb.shape[:2]) if elliptic else np.full(rgb.shape[:2], 255, np.uint8)])


def _ellipse(shape):
    """An alpha channel (h, w) that is opaque inside the inscribed ellipse, with a soft edge."""
    h, w = shape
    mask = np.zeros(shape, np.uint8)
    return cv2.ellipse(mask, (w // 2, h // 2), (w // 2 - 1, h // 2 - 1), 0, 0, 360, 255, -1, cv2.LINE_AA)


# The toy car from above, driving to the right: shapes in tenths of its width, painted in this order.
_PAINT = {
    "tyre": (35, 35, 38), "body": (40, 95, 200), "hood": (60, 130, 225), "glass": (30, 45, 60), "roof": (245, 200, 50),
    "stripe": (235, 240, 245), "number": (200, 40, 40), "lamp": (255, 245, 190), "tail": (215, 30, 40), "door": (25, 150, 90),
}


def _box(x0, y0, x1, y1):
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


_CAR = [
    *[("tyre", _box(x, y, x + 1.7, y + 0.9)) for x in (1.3, 6.9) for y in (0.0, 5.35)],
    ("body", [(0.4, 0.9), (1.2, 0.35), (8.3, 0.35), (9.5, 1.1), (9.9, 2.2), (9.9, 4.05), (9.5, 5.15), (8.3, 5.9), (1.2, 5.9), (0.4, 5.35)]),
    ("hood", [(6.9, 0.8), (8.2, 0.8), (9.2, 1.4), (9.5, 2.3), (9.5, 3.95), (9.2, 4.85), (8.2, 5.45), (6.9, 5.45)]),
    ("door", _box(3.0, 0.4, 5.9, 1.0)), ("tail", _box(3.0, 5.25, 5.9, 5.85)),
    ("stripe", _box(6.9, 2.65, 9.85, 3.6)), ("stripe", _box(0.5, 2.65, 2.2, 3.6)),
    ("glass", [(5.9, 1.3), (6.9, 0.95), (6.9, 5.3), (5.9, 4.95)]), ("glass", [(2.2, 1.2), (3.0, 1.5), (3.0, 4.75), (2.2, 5.05)]),
    ("roof", _box(3.0, 1.3, 5.9, 4.95)), ("number", [(3.9, 2.0), (5.2, 1.9), (4.5, 4.3), (4.0, 4.3), (4.6, 2.5), (3.9, 2.5)]),
    ("lamp", [(9.2, 1.0), (9.75, 1.5), (9.85, 2.2), (9.3, 1.8)]), ("lamp", [(9.2, 5.25), (9.75, 4.75), (9.85, 4.05), (9.3, 4.45)]),
    ("tail", _box(0.4, 1.0, 0.8, 2.0)), ("tail", _box(0.4, 4.25, 0.8, 5.25)),
]


def _car(width=256, scale=4):
    """The toy car, (160, 256, 4) RGBA: painted `scale` times too large with uneven paint, then reduced."""
    w, h = width * scale, width * scale * 5 // 8
    rgb, alpha = np.zeros((h, w, 3), np.uint8), np.zeros((h, w), np.uint8)
    for paint, polygon in _CAR:
        outline = np.round(np.array(polygon) * w / 10).astype(np.int32)
        cv2.fillPoly(rgb, [outline], _PAINT[paint])
        cv2.fillPoly(alpha, [outline], 255)
    small = cv2.resize(np.dstack([rgb, alpha]), (width, h // scale), interpolation=cv2.INTER_AREA)
    coarse = np.random.default_rng(2009).normal(1, 0.12, (20, 32, 1)).astype(np.float32)
    shade = cv2.resize(coarse, (small.shape[1], small.shape[0]), interpolation=cv2.INTER_CUBIC)[..., None]
    small[..., :3] = np.clip(small[..., :3] * shade, 0, 255)
    return small
