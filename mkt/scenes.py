"""Synthetic scenes with exact truth: a hashable specification -> a `Sequence`.

A scene is a stack of flat textured layers over a background: what passes behind the target, the target, what passes in front.
Each layer follows a smooth path through way-points.  A frame is what a camera would see: the *mean of sub-frame renders over the
exposure* (true motion blur, half of it before and half after the instant of the truth), times the light, plus sensor noise.

Frames are rendered when asked for and kept for a while, so that a slider which returns to a scene finds it ready.  The same
specification gives the same frames, in any order.  Explained in notebook 02.
"""

from collections.abc import Sequence as Series
from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from scipy.interpolate import CubicSpline

from mkt.regions import corners, warp_matrices
from mkt.textures import texture
from mkt.tracking import Sequence

MAX_SUBFRAMES = 32
STILL = ((0.0, 0.0, 0.0, 0.0, 1.0),)


@dataclass(frozen=True)
class Layer:
    """A flat textured object on its path.

    texture: a name of `mkt.textures`; width: its width [px] at scale 1, the height follows from the texture.
    path:    way-points (frame, x [px], y [px], theta [rad], scale), joined by a cubic spline; one alone stands still.
    hue:     turns all colours round the colour circle [degrees]: the recoloured twin of an object.
    shuffle: cuts the texture into so many tiles a side and mixes them: the same colours at other places.
    view:    another layer, of which texture, hue and shuffle count: what the object shows when it turns out of the image plane.
    turn:    points (frame, share of that view), joined linearly.
    """

    texture: str
    width: float
    path: tuple[tuple[float, ...], ...]
    hue: float = 0.0
    shuffle: int = 1
    view: "Layer | None" = None
    turn: tuple[tuple[float, float], ...] = ((0.0, 0.0),)


@dataclass(frozen=True)
class Scene:
    """The specification of a sequence; every field is hashable.

    target, behind, front: the layers, drawn in the order behind, target, front.
    background: a name of `mkt.textures`, laid out as an endless mirrored plane with `zoom` screen pixels a texture pixel.
    camera:  way-points (frame, dx, dy, theta, scale) of how the whole world moves on the screen, about the image centre.
    shutter: open time of the shutter as a fraction of the frame period, 0 is a frozen instant.
    light:   points (frame, red, green, blue) of gain, joined linearly: exposure and colour cast.
    noise:   standard deviation of the sensor noise [grey levels]; seed: of the noise alone, paths are given.
    size:    (width, height) [px].
    """

    target: Layer
    background: str = "workshop"
    length: int = 100
    behind: tuple[Layer, ...] = ()
    front: tuple[Layer, ...] = ()
    camera: tuple[tuple[float, ...], ...] = STILL
    shutter: float = 0.5
    light: tuple[tuple[float, ...], ...] = ((0.0, 1.0, 1.0, 1.0),)
    noise: float = 3.0
    seed: int = 0
    size: tuple[int, int] = (320, 240)
    zoom: float = 0.5

    def __post_init__(self):
        for field, ok in (("length", self.length >= 1), ("shutter", 0 <= self.shutter <= 1), ("noise", self.noise >= 0), ("zoom", self.zoom > 0)):
            if not ok:
                raise ValueError(f"{field} is {getattr(self, field)}, which no camera can do")


def sequence(scene, name="synthetic scene"):
    """The scene as a `Sequence`, with its exact truth."""
    times = np.arange(scene.length, dtype=float)
    return Sequence(name, Frames(scene), regions(scene, scene.target, times), _visibility(_noiseless(scene)))


class Frames(Series):
    """The frames of a scene, (H, W, 3) uint8 RGB, rendered on demand; equal scenes share one cache.  A slice is a list of frames."""

    def __init__(self, scene):
        self.scene = scene

    def __len__(self):
        return self.scene.length

    def __getitem__(self, k):
        if isinstance(k, slice):
            return [self[i] for i in range(len(self))[k]]
        if not -len(self) <= k < len(self):
            raise IndexError(f"frame {k} of {len(self)}")
        return frame(self.scene, k % len(self))


@lru_cache(maxsize=400)
def frame(scene, k):
    """Frame k of a scene, (H, W, 3) uint8 RGB, read-only."""
    exposed = _exposed(_noiseless(scene), k)
    noisy = np.random.default_rng((scene.seed, k)).standard_normal(exposed.shape, np.float32)
    noisy *= scene.noise  # in place here and below: fresh memory costs as much as the arithmetic
    noisy += exposed
    image = np.clip(np.rint(noisy, out=noisy), 0, 255, out=noisy).astype(np.uint8)
    image.setflags(write=False)
    return image


def _noiseless(scene):
    """What all scenes have in common that differ in their sensor noise alone."""
    return replace(scene, seed=0, noise=0.0)


@lru_cache(maxsize=96)
def _exposed(scene, k):
    """Frame k before the sensor's noise, (H, W, 3) float32; kept for the runs that differ in the noise alone."""
    first, *others = k + scene.shutter * _exposure(_subframes(scene, k))
    exposed = _instant(scene, first)
    for t in others:
        exposed += _instant(scene, t)
    exposed /= 1 + len(others)
    exposed *= _interpolated(scene.light, k).astype(np.float32)
    return exposed


def _exposure(n):
    """Mid-points of n equal slices of the exposure, in [-1/2, 1/2]."""
    return (np.arange(n) + 0.5) / n - 0.5


def _subframes(scene, k):
    """Sub-frames needed at frame k so that nothing jumps by more than a pixel from one to the next."""
    ends = np.array([k - scene.shutter / 2, k + scene.shutter / 2])
    layers = (*scene.behind, scene.target, *scene.front)
    boxes = [corners(regions(scene, layer, ends)) for layer in layers] + [corners(_seen(scene, _whole(scene), ends))]
    return int(np.clip(np.ceil(max(np.abs(b[1] - b[0]).max() for b in boxes)), 1, MAX_SUBFRAMES))


def _interpolated(points, t):
    """Values at the times t of way-points (time, ...), joined linearly.  Returns (..., number of values)."""
    table = np.array(points, float)
    return np.stack([np.interp(t, table[:, 0], column) for column in table[:, 1:].T], -1)


@lru_cache(maxsize=256)
def _spline(path):
    table = np.array(path, float)
    if len(table) == 1:
        return lambda t: np.broadcast_to(table[0, 1:], (*np.shape(t), table.shape[1] - 1))
    return CubicSpline(table[:, 0], table[:, 1:])


def regions(scene, layer, times):
    """True regions of a layer on the screen.  times: (T,) [frames].  Returns (T, 5) [px, rad]."""
    x, y, theta, scale = np.moveaxis(_spline(layer.path)(times), -1, 0)
    h, w = texture(layer.texture).shape[:2]
    half = scale * layer.width / 2
    return _seen(scene, np.stack([x, y, theta, half, half * h / w], -1), times)


def _seen(scene, region, times):
    """Where the moving camera sees regions (..., 5) of the world at the times (...)."""
    dx, dy, turn, zoom = np.moveaxis(_spline(scene.camera)(times), -1, 0)
    centre = (np.array(scene.size) - 1) / 2
    rx, ry = np.moveaxis(region[..., :2] - centre, -1, 0)
    c, s = np.cos(turn), np.sin(turn)
    x, y = centre[0] + dx + zoom * (c * rx - s * ry), centre[1] + dy + zoom * (s * rx + c * ry)
    return np.stack([x, y, region[..., 2] + turn, zoom * region[..., 3], zoom * region[..., 4]], -1)


def _whole(scene):
    """The region of the whole screen."""
    width, height = scene.size
    return np.array([(width - 1) / 2, (height - 1) / 2, 0.0, width / 2, height / 2])


def _instant(scene, t):
    """What the sensor sees in an instant: (H, W, 3) float32 in 0 ... 255."""
    screen = _seen(scene, _whole(scene), np.float64(t))
    image = _background(scene.background, scene.zoom, scene.size, tuple(map(float, screen))).astype(np.float32)
    for layer in (*scene.behind, scene.target, *scene.front):
        _paint(image, scene, layer, t)
    return image


@lru_cache(maxsize=16)
def _background(name, zoom, size, screen):
    """The background plane where the screen's region (5,) sees it, (H, W, 3) uint8; kept, because it mostly stands still."""
    plane = _resized(name, zoom)[..., :3]
    a = _texture_to_screen(np.array(screen), size)
    a[:, 2] -= a[:, :2] @ (np.array(plane.shape[1::-1]) - size) / 2
    return cv2.warpAffine(plane, a, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101)


@lru_cache(maxsize=32)
def _resized(name, factor):
    """A texture reduced or enlarged by a factor, without aliasing."""
    rgba = texture(name)
    size = tuple(max(round(factor * side), 2) for side in rgba.shape[1::-1])
    return cv2.resize(rgba, size, interpolation=cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC)


def _shown(layer, t):
    """What a layer shows at the time t, (h, w, 4) float32: its texture, or a mixture with its other view."""
    front = _prepared(replace(layer, path=STILL, view=None))
    share = float(_interpolated(layer.turn, t)[0])
    if layer.view is None or share == 0:
        return front
    other = _prepared(replace(layer.view, width=layer.width, path=STILL))
    return (1 - share) * front + share * cv2.resize(other, front.shape[1::-1])


@lru_cache(maxsize=64)
def _prepared(layer):
    """A layer's texture at its width, recoloured and shuffled, colours times opacity, with a transparent border: (h, w, 4) float32."""
    rgba = _resized(layer.texture, layer.width / texture(layer.texture).shape[1])
    rgb = _shuffled(_recoloured(rgba[..., :3], layer.hue), layer.shuffle)
    alpha = rgba[..., 3:].astype(np.float32) / 255
    return cv2.copyMakeBorder(np.dstack([rgb * alpha, alpha]).astype(np.float32), 1, 1, 1, 1, cv2.BORDER_CONSTANT)


def _recoloured(rgb, degrees):
    hsv = cv2.cvtColor(rgb, cv2.COLOR_RGB2HSV)
    hsv[..., 0] = (hsv[..., 0].astype(int) + round(degrees / 2)) % 180  # in uint8 it would overflow
    return cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)


def _shuffled(rgb, k):
    """The k x k tiles of an image in another order, the same for every image."""
    th, tw = rgb.shape[0] // k, rgb.shape[1] // k
    tiles = rgb[:k * th, :k * tw].reshape(k, th, k, tw, 3).swapaxes(1, 2).reshape(k * k, th, tw, 3)
    mixed = tiles[np.random.default_rng(k).permutation(k * k)].reshape(k, k, th, tw, 3).swapaxes(1, 2)
    result = rgb.copy()
    result[:k * th, :k * tw] = mixed.reshape(k * th, k * tw, 3)
    return result


def _texture_to_screen(region, size):
    """The affine map (2, 3) from the pixels of a texture of the size (w, h) to the screen, the texture filling the region (5,)."""
    w, h = size
    canonical = np.array([[2 / w, 0, 1 / w - 1], [0, 2 / h, 1 / h - 1], [0, 0, 1]])
    return warp_matrices(region) @ canonical


def _painting(scene, layer, t):
    """A layer's part of the screen: slices (rows, columns) and its pixels (h, w, 4) float32, colours times opacity."""
    region, rgba = regions(scene, layer, np.float64(t)), _shown(layer, t)
    h, w = rgba.shape[0] - 2, rgba.shape[1] - 2
    low = np.clip(np.floor(corners(region).min(0)).astype(int) - 1, 0, scene.size)
    high = np.clip(np.ceil(corners(region).max(0)).astype(int) + 2, low, scene.size)
    a = _texture_to_screen(region, (w, h))
    a[:, 2] -= a[:, :2] @ [1, 1] + low  # the border of one pixel, and the corner of the part
    window = slice(low[1], high[1]), slice(low[0], high[0])
    if (high == low).any():
        return window, np.zeros((*(high - low)[::-1], 4), np.float32)
    return window, cv2.warpAffine(rgba, a, tuple(map(int, high - low)), flags=cv2.INTER_LINEAR)


def _paint(image, scene, layer, t):
    window, part = _painting(scene, layer, t)
    seen = image[window]
    seen *= 1 - part[..., 3:]
    seen += part[..., :3]


@lru_cache(maxsize=64)
def _visibility(scene):
    """Visible fraction of the target in every frame, (T,) in [0, 1], read-only: not hidden by what is in front, and inside the image."""
    visible = np.array([_visible(scene, t) for t in range(scene.length)])
    visible.setflags(write=False)
    return visible


def _visible(scene, t):
    opacity = np.zeros(scene.size[::-1], np.float32)
    window, part = _painting(scene, scene.target, t)
    opacity[window] = part[..., 3]
    for layer in scene.front:
        window, part = _painting(scene, layer, t)
        opacity[window] *= 1 - part[..., 3]
    alpha = _shown(scene.target, t)[..., 3]
    zoom = 2 * regions(scene, scene.target, np.float64(t))[3] / (alpha.shape[1] - 2)
    whole = alpha.sum() * zoom**2
    return float(np.clip(opacity.sum() / whole, 0, 1))
