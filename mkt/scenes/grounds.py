"""Painted grounds, with the grain of photographs: where the stories of [N03] happen.

All have 640 x 480 pixels, which a `Scene` shows at half of that.
"""

from collections.abc import Callable

import cv2
import numpy as np

from mkt.scenes.painting import Color, box
from mkt.scenes.photographs import photograph
from mkt.types import NDArray

WIDTH, HEIGHT = 640, 480
_LAWN, _ASPHALT, _PAVING = (122, 158, 84), (104, 106, 112), (178, 172, 160)
_LINE = 232, 230, 222


def _grain(material: str, color: Color, finer: int, strength: float) -> NDArray:
    """A photograph's grain in another colour, (HEIGHT, WIDTH, 3) float."""
    grey = photograph(material)[..., :3].mean(2)
    side = grey.shape[0] // finer
    small = cv2.resize(grey, (side, side), interpolation=cv2.INTER_AREA)
    small = (small - small.mean()) / small.std()
    times = -(-HEIGHT // side), -(-WIDTH // side)
    laid = np.tile(small, times)[:HEIGHT, :WIDTH, None]
    return np.array(color) * (1 + strength * laid)


def _opaque(rgb: NDArray) -> NDArray:
    rgb = np.clip(rgb, 0, 255)
    return np.dstack([rgb, np.full(rgb.shape[:2], 255)]).astype(np.uint8)


def _fill(rgb: NDArray, corners: list[tuple[float, float]], color: Color) -> None:
    outline = np.round(corners).astype(np.int32)
    cv2.fillPoly(rgb, [outline], color, cv2.LINE_AA)


def _campus() -> NDArray:
    """A house with windows, a lawn before it, and a path."""
    rgb = _grain("bricks", (196, 178, 150), 4, 0.1)
    for x in range(30, WIDTH, 104):
        for y in (14, 104):
            _fill(rgb, box(x - 5, y - 5, x + 61, y + 71), (226, 222, 212))
            _fill(rgb, box(x, y, x + 26, y + 66), (66, 84, 104))
            _fill(rgb, box(x + 30, y, x + 56, y + 66), (78, 98, 120))
    rgb[200:214] = (150, 140, 124)
    rgb[214:330] = _grain("grass", _LAWN, 1, 0.2)[214:330]
    rgb[330:] = _grain("gravel", _PAVING, 4, 0.08)[330:]
    rgb[330:336] = (140, 136, 128)
    return _opaque(rgb)


def _street() -> NDArray:
    """A road seen from a car, with trees at its end."""
    sky = np.linspace(1, 0, HEIGHT)[:, None, None]
    rgb = (
        np.array([222, 230, 236])
        - sky * np.array([70, 40, 6])
        + np.zeros((1, WIDTH, 1))
    )
    trees = _grain("grass", (74, 98, 62), 2, 0.3)
    tops = 150 + 22 * np.sin(np.arange(WIDTH) / 23) + 14 * np.sin(np.arange(WIDTH) / 9)
    below = np.arange(HEIGHT)[:, None] > tops
    rgb = np.where(below[..., None], trees, rgb)
    rgb[206:] = _grain("grass", (150, 160, 96), 1, 0.18)[206:]
    road = np.zeros((HEIGHT, WIDTH, 3))
    _fill(road, [(300, 206), (340, 206), (760, HEIGHT), (-120, HEIGHT)], (1, 1, 1))
    rgb = np.where(road > 0.5, _grain("gravel", _ASPHALT, 4, 0.1), rgb)
    for near, far in ((1.0, 0.72), (0.56, 0.4), (0.3, 0.2), (0.14, 0.09)):
        ends = [
            (320 + side * 14 * at, 206 + 274 * at)
            for at in (near, far)
            for side in (-1, 1)
        ]
        _fill(rgb, [ends[0], ends[1], ends[3], ends[2]], _LINE)
    for side in (-1, 1):
        line = [(320 + side * reach, y) for reach, y in ((19, 206), (400, HEIGHT))]
        _fill(rgb, [line[0], line[1], (line[1][0] - side * 22, HEIGHT), line[0]], _LINE)
    return _opaque(rgb)


def _parking() -> NDArray:
    """A parking place, from a window above it: bays, a hedge, a kerb."""
    rgb = _grain("gravel", _ASPHALT, 4, 0.1)
    for x in range(-20, WIDTH + 60, 92):
        _fill(rgb, [(x, 190), (x + 7, 190), (x + 43, 70), (x + 37, 70)], _LINE)
        _fill(rgb, [(x, HEIGHT), (x + 8, HEIGHT), (x - 30, 380), (x - 37, 380)], _LINE)
    rgb[:58] = _grain("grass", (66, 104, 58), 2, 0.3)[:58]
    rgb[58:70] = _grain("gravel", _PAVING, 4, 0.08)[58:70]
    return _opaque(rgb)


def _planks() -> NDArray:
    """A wooden table: seven planks with their grain."""
    rng = np.random.default_rng(1)
    fine = rng.normal(0, 1, (HEIGHT, 20)).astype(np.float32)
    grain = cv2.resize(cv2.GaussianBlur(fine, (1, 3), 0), (WIDTH, HEIGHT))
    knots = cv2.resize(rng.normal(0, 1, (12, 8)).astype(np.float32), (WIDTH, HEIGHT))
    edges = np.linspace(0, HEIGHT, 8).astype(int)
    tone = np.repeat(rng.uniform(0.85, 1.12, 7), np.diff(edges))[:, None]
    light = tone * (1 + 0.07 * grain + 0.08 * knots)
    for y in edges[1:-1]:
        light[y - 2 : y + 1] *= 0.55
    return _opaque(np.array([176, 124, 78]) * light[..., None])


PAINTED: dict[str, Callable[[], NDArray]] = {
    "campus": _campus,
    "street": _street,
    "parking place": _parking,
    "planks": _planks,
}
