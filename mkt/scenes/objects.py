"""Painted objects with an outline: toys, people, a van, a tree, pillars.

Each is a list of shapes in tenths of its width, painted in their order.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from mkt.scenes.painting import Color, Shape, box, oval, painted
from mkt.scenes.photographs import photograph
from mkt.types import NDArray

# The toy car from above, driving to the right.
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
CAR = [
    (_PAINT["tyre"], box(1.3, 0.0, 3.0, 0.9)),
    (_PAINT["tyre"], box(1.3, 5.35, 3.0, 6.25)),
    (_PAINT["tyre"], box(6.9, 0.0, 8.6, 0.9)),
    (_PAINT["tyre"], box(6.9, 5.35, 8.6, 6.25)),
    (
        _PAINT["body"],
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
        _PAINT["hood"],
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
    (_PAINT["door"], box(3.0, 0.4, 5.9, 1.0)),
    (_PAINT["tail"], box(3.0, 5.25, 5.9, 5.85)),
    (_PAINT["stripe"], box(6.9, 2.65, 9.85, 3.6)),
    (_PAINT["stripe"], box(0.5, 2.65, 2.2, 3.6)),
    (_PAINT["glass"], [(5.9, 1.3), (6.9, 0.95), (6.9, 5.3), (5.9, 4.95)]),
    (_PAINT["glass"], [(2.2, 1.2), (3.0, 1.5), (3.0, 4.75), (2.2, 5.05)]),
    (_PAINT["roof"], box(3.0, 1.3, 5.9, 4.95)),
    (
        _PAINT["number"],
        [(3.9, 2.0), (5.2, 1.9), (4.5, 4.3), (4.0, 4.3), (4.6, 2.5), (3.9, 2.5)],
    ),
    (_PAINT["lamp"], [(9.2, 1.0), (9.75, 1.5), (9.85, 2.2), (9.3, 1.8)]),
    (_PAINT["lamp"], [(9.2, 5.25), (9.75, 4.75), (9.85, 4.05), (9.3, 4.45)]),
    (_PAINT["tail"], box(0.4, 1.0, 0.8, 2.0)),
    (_PAINT["tail"], box(0.4, 4.25, 0.8, 5.25)),
]
_CAR_SIZE = 256, 160  # (width, height) [px]

_SKIN, _SHOE = (224, 172, 138), (60, 48, 44)
# Hair, shirt, its band, trousers, bag.
_CLOTHES: dict[str, tuple[Color, Color, Color, Color, Color]] = {
    "student": (
        (82, 52, 30),
        (214, 62, 44),
        (250, 214, 92),
        (44, 70, 140),
        (236, 232, 222),
    ),
    "passer in blue": (
        (36, 32, 34),
        (52, 116, 190),
        (220, 226, 232),
        (58, 58, 66),
        (30, 92, 84),
    ),
    "passer in green": (
        (190, 150, 84),
        (74, 150, 82),
        (44, 92, 58),
        (150, 128, 96),
        (104, 66, 130),
    ),
}
_PERSON_SIZE = 120, 288

_VAN_SIZE = 240, 200
_WINDOW, _TYRE, _BUMPER = (44, 58, 74), (34, 34, 36), (112, 116, 122)
_VAN_REAR: list[Shape] = [
    (_TYRE, box(0.7, 7.2, 2.1, 8.3)),
    (_TYRE, box(7.9, 7.2, 9.3, 8.3)),
    ((38, 92, 190), box(0.0, 0.0, 10.0, 7.6)),
    ((58, 124, 222), box(0.4, 0.3, 9.6, 0.9)),
    (_WINDOW, box(0.9, 1.2, 4.7, 3.6)),
    (_WINDOW, box(5.3, 1.2, 9.1, 3.6)),
    ((24, 60, 130), box(4.9, 0.9, 5.1, 7.0)),
    ((216, 32, 40), box(0.3, 4.2, 1.3, 5.9)),
    ((216, 32, 40), box(8.7, 4.2, 9.7, 5.9)),
    ((240, 240, 232), box(3.4, 5.1, 6.6, 6.1)),
    ((30, 34, 40), box(3.8, 5.4, 6.2, 5.8)),
    (_BUMPER, box(0.0, 6.8, 10.0, 7.6)),
]
_VAN_SIDE: list[Shape] = [
    ((38, 92, 190), box(0.0, 0.0, 10.0, 7.6)),
    ((58, 124, 222), box(0.0, 0.3, 10.0, 0.9)),
    ((246, 176, 52), box(0.5, 1.2, 7.0, 6.4)),
    ((214, 62, 120), oval(3.7, 3.8, 2.6, 2.2)),
    ((255, 246, 226), oval(3.7, 3.8, 1.5, 1.2)),
    (_WINDOW, [(7.4, 1.2), (9.5, 1.2), (9.9, 3.6), (7.4, 3.6)]),
    (_BUMPER, box(0.0, 6.9, 10.0, 7.6)),
    (_TYRE, oval(2.2, 7.2, 1.15, 1.1)),
    (_TYRE, oval(7.9, 7.2, 1.15, 1.1)),
]


_BALL: list[Shape] = [
    ((238, 236, 228), oval(5.0, 5.0, 5.0, 5.0)),
    ((206, 44, 52), [(5.0, 5.0), (2.6, 0.7), (5.0, 0.0), (7.4, 0.7)]),
    ((40, 92, 180), [(5.0, 5.0), (9.7, 3.4), (9.8, 6.2), (8.2, 8.8)]),
    ((246, 196, 40), [(5.0, 5.0), (1.8, 8.8), (0.2, 6.2), (0.3, 3.4)]),
    ((40, 40, 44), oval(5.0, 5.0, 1.1, 1.1)),
]
_FACELETS: list[Color] = [
    (210, 40, 44), (244, 206, 48), (36, 90, 190),
    (250, 250, 246), (40, 150, 80), (240, 130, 36),
    (36, 90, 190), (210, 40, 44), (244, 206, 48),
]  # fmt: skip
_CUBE: list[Shape] = [((24, 24, 26), box(0.0, 0.0, 10.0, 10.0))] + [
    (color, box(0.4 + 3.2 * x, 0.4 + 3.2 * y, 3.2 + 3.2 * x, 3.2 + 3.2 * y))
    for (y, x), color in zip(np.ndindex(3, 3), _FACELETS, strict=True)
]
_TOY_SIZE = 160, 160


def _car() -> NDArray:
    return painted(CAR, _CAR_SIZE, 2009)


def _person(name: str) -> NDArray:
    """Somebody who walks, with a bag."""
    hair, shirt, band, trousers, bag = _CLOTHES[name]
    legs = [(2.3, 12.6), (7.7, 12.6), (8.0, 23.0), (5.9, 23.0), (5.2, 15.2)]
    shapes = [
        (_SHOE, oval(2.7, 23.3, 1.7, 0.65)),
        (_SHOE, oval(7.3, 23.3, 1.7, 0.65)),
        (trousers, [*legs, (4.5, 23.0), (2.0, 23.0)]),
        (_SKIN, oval(0.9, 13.0, 0.8, 0.9)),
        (_SKIN, oval(9.1, 13.0, 0.8, 0.9)),
        (shirt, [(2.4, 5.5), (1.0, 6.6), (0.1, 12.6), (1.6, 12.9), (2.9, 8.0)]),
        (shirt, [(7.6, 5.5), (9.0, 6.6), (9.9, 12.6), (8.4, 12.9), (7.1, 8.0)]),
        (_SKIN, box(4.2, 4.4, 5.8, 6.0)),
        (shirt, [(2.4, 5.5), (7.6, 5.5), (7.9, 13.0), (2.1, 13.0)]),
        (band, box(2.2, 8.6, 7.8, 10.2)),
        (bag, [(2.5, 5.5), (3.2, 5.5), (8.6, 11.5), (8.0, 12.0)]),
        (bag, box(6.4, 10.8, 9.4, 14.6)),
        (hair, oval(5.0, 2.5, 2.1, 2.4)),
        (_SKIN, oval(5.0, 3.1, 1.6, 1.9)),
        (hair, [(3.3, 2.5), (3.8, 0.9), (6.2, 0.9), (6.7, 2.5), (5.0, 1.7)]),
        (_SHOE, oval(4.3, 3.0, 0.25, 0.25)),
        (_SHOE, oval(5.7, 3.0, 0.25, 0.25)),
    ]
    return painted(shapes, _PERSON_SIZE, 2003, below=shirt)


def _tree() -> NDArray:
    """A dense tree whose leaves begin low above the ground."""
    leaves = photograph("grass")[:480, :208, :3] * np.array([0.55, 0.72, 0.5])
    h, w = leaves.shape[:2]
    across = np.linspace(-1, 1, w)
    down = np.linspace(0, 1, h)[:, None]
    leaves *= (1.05 - 0.5 * across**2)[:, None]  # the sides are in the shade
    crown = np.abs(across) < 1.05 * np.minimum(1, (1 - (1 - 3 * down).clip(0) ** 2))
    trunk = (np.abs(across) < 0.3) & (down > 0.9)
    opaque = crown & (down < 0.93) | trunk
    rgb = np.where((down > 0.93)[..., None], (92, 66, 44), leaves)
    return np.dstack([rgb, 255 * opaque]).astype(np.uint8)


def _pillar(color: Color, material: str) -> NDArray:
    """A round pillar of a material, from below the image to above it."""
    stone = photograph(material)[:512, :128, :3].mean(2, keepdims=True)
    stone = stone / stone.mean() * np.array(color)
    round_ = np.cos(np.linspace(-1.2, 1.0, 128))[:, None] ** 0.7
    rgb = np.clip(stone * (0.35 + 0.75 * round_), 0, 255)
    for top in (0, 472):
        rgb[top : top + 40] *= 0.8
    return np.dstack([rgb, np.full(rgb.shape[:2], 255)]).astype(np.uint8)


PAINTED: dict[str, Callable[[], NDArray]] = {
    "car": _car,
    **{name: partial(_person, name) for name in _CLOTHES},
    "van from behind": lambda: painted(_VAN_REAR, _VAN_SIZE, 2004),
    "van from the side": lambda: painted(_VAN_SIDE, _VAN_SIZE, 2005),
    "ball": lambda: painted(_BALL, _TOY_SIZE, 2006),
    "cube": lambda: painted(_CUBE, _TOY_SIZE, 2007),
    "tree": _tree,
    "brick pillar": lambda: _pillar((168, 92, 66), "bricks"),
    "stone pillar": lambda: _pillar((196, 186, 168), "gravel"),
    "green pillar": lambda: _pillar((96, 128, 92), "grass"),
}
