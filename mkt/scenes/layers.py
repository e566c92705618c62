"""Layers: the flat textured objects that scenes are made of, and what each shows.

A layer is a specification, which can be hashed.  Where it is at a time, and how a
camera sees it there, is the business of `mkt.scenes.rendering`.

Explained in notebook 02.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import repeat

import cv2
import numpy as np

from mkt import checks
from mkt.checks import are_finite
from mkt.colors import HUES
from mkt.scenes.paths import STILL, Path, check_points, joined
from mkt.scenes.textures import NAMES, resized, texture
from mkt.types import Array, Frame, NDArray

FLAT: Path = ((0.0, 0.0, 0.0),)


@dataclass(frozen=True)
class Layer:
    """A flat textured object on its path.

    Parameters
    ----------
    texture : str
        A name of `mkt.scenes.textures`.
    width : float [px]
        At scale 1; the height follows from the texture.
    path : tuple of way-points
        (frame, x [px], y [px], theta [rad], scale), joined by a cubic spline; with a
        single way-point the layer stands still, as it does from one frame after the
        last one on.
    hue : float [deg]
        Turns all colours round the colour circle: the recoloured twin of an object.
    shuffle : int
        Cuts the texture into so many tiles a side and mixes them: the same colours at
        other places.  Not more tiles than pixels, or rendering ends with a ValueError.
    view : Layer, optional
        Another look of the object; only its texture, hue and shuffle count.
    turn : tuple of (frame, share)
        The share of that look, joined linearly.
    box : bool
        The other look is the next side of a box that turns about its upright axis, seen
        from far away, and its share is a share of the width.  Otherwise the first look
        fades into the other.
    tilt : tuple of (frame, about x [rad], about y [rad])
        Turns out of the image plane, about the layer's own axes, first about x: the
        lower side or the left one goes away.  Joined by a cubic spline; the layer is
        then seen in perspective.

    Raises
    ------
    ValueError
        Naming the field.
    """

    texture: str
    width: float
    path: Path
    hue: float = 0.0
    shuffle: int = 1
    view: "Layer | None" = None
    turn: tuple[tuple[float, float], ...] = ((0.0, 0.0),)
    box: bool = False
    tilt: Path = FLAT

    def __post_init__(self):
        checks.one_of(self, texture=NAMES)
        checks.positive(self, "width")
        checks.numbers(self, "hue", fits=are_finite, need="it must be finite")
        checks.flags(self, "box")
        checks.counts(self, "shuffle")
        if self.view is not None:
            checks.of_kind(self.view, Layer, "view", "give a Layer, or None")
        check_points(self, path=5, turn=2, tilt=3)
        if not all(0 <= share <= 1 for _, share in self.turn):
            raise ValueError(f"turn is {self.turn}; a share lies between 0 and 1")


def looks(layer: Layer, times: Array) -> Iterator[NDArray]:
    """What a layer shows at each of the times, (h, w, 4) float32.

    That is its texture alone, or together with its other look.

    Parameters
    ----------
    layer : Layer
    times : (n,) array [frames]
    """
    front = _prepared(replace(layer, path=STILL, view=None))
    if layer.view is None:
        yield from repeat(front, len(times))
        return
    other = _prepared(replace(layer.view, width=layer.width, path=STILL))
    for share in joined(layer.turn, times)[:, 0].tolist():
        if share == 0:
            yield front
        elif layer.box:
            yield _side_by_side(front, other, share)
        else:
            yield (1 - share) * front + share * cv2.resize(other, front.shape[1::-1])


def _side_by_side(front: NDArray, side: NDArray, share: float) -> NDArray:
    """Two sides of a box, each squeezed to its share of the width, with a border."""
    height, width = (length - 2 for length in front.shape[:2])
    seam = round((1 - share) * width)
    parts = [
        cv2.resize(whole[1:-1, 1:-1], (part, height), interpolation=cv2.INTER_AREA)
        for whole, part in ((front, seam), (side, width - seam))
        if part
    ]
    return cv2.copyMakeBorder(np.hstack(parts), 1, 1, 1, 1, cv2.BORDER_CONSTANT)


@lru_cache(maxsize=64)
def _prepared(layer: Layer) -> NDArray:
    """A layer's texture at its width, recoloured and shuffled: (h, w, 4) float32.

    Colours are multiplied by the opacity, and the border is transparent.
    """
    rgba = resized(layer.texture, layer.width / texture(layer.texture).shape[1])
    rgb = _shuffled(_recoloured(rgba[..., :3], layer.hue), layer.shuffle)
    alpha = rgba[..., 3:].astype(np.float32) / 255
    pixels = np.dstack([rgb * alpha, alpha]).astype(np.float32)
    return checks.locked(cv2.copyMakeBorder(pixels, 1, 1, 1, 1, cv2.BORDER_CONSTANT))


def _recoloured(rgb: Frame, degrees: float) -> Frame:
    hsv = cv2.cvtColor(rgb, cv2.COLOR_RGB2HSV)
    hues = hsv[..., 0].astype(int)  # in uint8 the sum would overflow
    hsv[..., 0] = (hues + round(degrees % 360 / 2)) % HUES
    return cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)


def _shuffled(rgb: Frame, k: int) -> Frame:
    """The k x k tiles of an image in another order, the same for every image."""
    th, tw = rgb.shape[0] // k, rgb.shape[1] // k
    if not min(th, tw):
        raise ValueError(
            f"shuffle is {k}, but the texture has {min(rgb.shape[:2])} px a side; "
            "cut it into fewer tiles"
        )
    whole = rgb[: k * th, : k * tw].reshape(k, th, k, tw, 3)
    tiles = whole.swapaxes(1, 2).reshape(k * k, th, tw, 3)
    mixed = tiles[np.random.default_rng(k).permutation(k * k)]
    mixed = mixed.reshape(k, k, th, tw, 3).swapaxes(1, 2)
    result = rgb.copy()
    result[: k * th, : k * tw] = mixed.reshape(k * th, k * tw, 3)
    return result
