"""Synthetic scenes with exact truth: a hashable specification -> a `Sequence`.

A scene is a stack of flat textured layers (`mkt.scenes.layers`) over a background:
what passes behind the target, the target, what passes in front.  Each layer follows a
smooth path through way-points (`mkt.scenes.paths`).  A frame is what a camera would
see: the *mean of sub-frame renders over the exposure* (true motion blur, half of it
before and half after the instant of the truth), times the light, plus sensor noise.

Frames are rendered when asked for and kept for a while, so that a slider which returns
to a scene finds it ready.  The same specification gives the same frames, in any order.

Explained in notebook 02.
"""

import reprlib
from collections.abc import Callable, Iterator
from collections.abc import Sequence as Series
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from mkt import checks
from mkt.checks import locked
from mkt.homographies import corners, of_regions
from mkt.regions import HX
from mkt.scenes.layers import FLAT, Layer, looks
from mkt.scenes.paths import STILL, Path, check_points, joined, spline
from mkt.scenes.textures import NAMES, resized, texture
from mkt.tracking import Sequence
from mkt.types import Array, ArrayLike, Frame, NDArray, Region, Regions

MAX_SUBFRAMES = 32
# Pixels in what is kept of each size of image: at 320x240 640 frames (150 MB),
# four scenes of 150, for loops return to them, and 96 exposures (90 MB).
FRAMES, EXPOSED = 640 * 320 * 240, 96 * 320 * 240


@dataclass(frozen=True)
class Scene:
    """The specification of a sequence; every field is hashable.

    Parameters
    ----------
    target : Layer
    background : str
        A name of `mkt.scenes.textures`, laid out as an endless mirrored plane.
    length : int
        Frames.
    behind, front : tuple of Layer
        Drawn before the target, and after it.
    camera : tuple of way-points
        (frame, dx, dy, theta, scale): how the whole world moves on the screen, about
        the image centre.
    shutter : float
        Open time of the shutter as a share of the frame period; 0 is an instant.
    light : tuple of (frame, red, green, blue)
        Gains, joined linearly: exposure and colour cast.
    noise : float
        Standard deviation of the sensor noise [grey levels].
    seed : int
        Of the noise alone; paths are given.  The noise of frame 0 begins with the same
        random bits as a tracker that is run with this seed, because NumPy fills seeds
        up with zeros.  It does not matter: over 270 scenes "base", PF-75 with this seed
        and with another one differ by 0.002 ± 0.003 in their mean overlap.
    size : (width, height) [px]
    zoom : float
        Screen pixels for a texture pixel of the background.
    focal : float [px]
        Focal length of the camera that sees tilted layers.

    Raises
    ------
    ValueError
        Naming the field.
    """

    target: Layer
    background: str = "workshop"
    length: int = 100
    behind: tuple[Layer, ...] = ()
    front: tuple[Layer, ...] = ()
    camera: Path = STILL
    shutter: float = 0.5
    light: tuple[tuple[float, ...], ...] = ((0.0, 1.0, 1.0, 1.0),)
    noise: float = 3.0
    seed: int = 0
    size: tuple[int, int] = (320, 240)
    zoom: float = 0.5
    focal: float = 400.0

    def __post_init__(self):
        checks.of_kind(self.target, Layer, "target", "give a Layer")
        _check_layers(self, "behind", "front")
        checks.one_of(self, background=NAMES)
        checks.counts(self, "length")
        checks.shares(self, "shutter")
        checks.positive(self, "zoom", "focal")
        checks.grey_levels(self, "noise")
        check_points(self, camera=5, light=4)
        if min(gain for point in self.light for gain in point[1:]) < 0:
            raise ValueError(
                f"light is {reprlib.repr(self.light)}; gains must be at least 0"
            )
        checks.check_seed(self.seed)
        checks.image_size(self.size)

    def sequence(self, name: str = "synthetic scene") -> Sequence:
        """The scene as a `Sequence`, with its exact truth.

        Raises
        ------
        ValueError
            Where a scale is not positive, perhaps between two points that are.
        """
        times = np.arange(self.length, dtype=float)
        truth = regions(self, self.target, times)
        if not (truth[:, HX:] > 0).all():
            k = int(np.argmin(truth[:, HX:].min(1)))
            raise ValueError(
                f"the target has no area in frame {k}; give its path and the camera's "
                "scales above 0, and more points where they change fast"
            )
        return Sequence(name, Frames(self), truth, _visibility(_noiseless(self)))


def _check_layers(scene: Scene, *fields: str) -> None:
    """Refuse a field that is no tuple of layers."""
    for field in fields:
        layers = getattr(scene, field)
        tuples = isinstance(layers, tuple)
        if not (tuples and all(isinstance(layer, Layer) for layer in layers)):
            raise ValueError(
                f"{field} is {reprlib.repr(layers)}; give a tuple of Layers, or ()"
            )


class Frames(Series):
    """The frames of a scene, (H, W, 3) uint8 RGB, rendered on demand.

    Equal scenes share one cache.  A slice is a list of frames.
    """

    def __init__(self, scene: Scene):
        self.scene = scene

    def __len__(self) -> int:
        return self.scene.length

    def __getitem__(self, k):
        if isinstance(k, slice):
            return [self[i] for i in range(len(self))[k]]
        if not -len(self) <= k < len(self):
            raise IndexError(f"frame {k} of {len(self)}")
        return render(self.scene, k % len(self))


def render(scene: Scene, k: int) -> Frame:
    """Frame k of a scene, (H, W, 3) uint8 RGB, read-only."""
    return _kept(_rendered, FRAMES, scene.size)(scene, k)


@lru_cache(maxsize=8)
def _kept(make: Callable, pixels: int, size: tuple[int, int]) -> Callable:
    """A function that keeps its images of one size, so many pixels of them."""
    return lru_cache(maxsize=max(pixels // (size[0] * size[1]), 2))(make)


def _rendered(scene: Scene, k: int) -> Frame:
    exposed = _kept(_exposed, EXPOSED, scene.size)(_noiseless(scene), k)
    rng = np.random.default_rng((scene.seed, k))
    noisy = rng.standard_normal(exposed.shape, np.float32)
    # In place, here and below: fresh memory costs as much as the arithmetic.
    noisy *= scene.noise
    frame = cv2.add(noisy, exposed, dtype=cv2.CV_8U)  # rounded, and kept in 0 ... 255
    return locked(frame)


def _noiseless(scene: Scene) -> Scene:
    """What scenes have in common that differ only in their sensor noise."""
    return replace(scene, seed=0, noise=0.0)


def _exposed(scene: Scene, k: int) -> NDArray:
    """Frame k before the sensor's noise, (H, W, 3) float32.

    It is kept for the runs that differ only in the noise.
    """
    times = k + scene.shutter * _exposure(_subframes(scene)[k])
    instants = _instants(scene, times)
    exposed = next(instants)
    for instant in instants:
        exposed += instant
    exposed /= len(times)
    gains = joined(scene.light, k).astype(np.float32)
    if (gains != 1).any():  # the product takes as long as an instant
        exposed *= gains
    return exposed


def _exposure(n: int) -> Array:
    """Mid-points of n equal slices of the exposure, in [-1/2, 1/2]."""
    return (np.arange(n) + 0.5) / n - 0.5


@lru_cache(maxsize=64)
def _subframes(scene: Scene) -> list[int]:
    """Sub-frames needed in each frame so that nothing jumps by more than a pixel."""
    half = scene.shutter / 2
    ends = np.arange(scene.length)[:, None] + np.array([-half, half])
    seen = [homographies(scene, layer, ends) for layer in _layers(scene)]
    seen.append(of_regions(_seen(scene, _whole(scene), ends)))
    jumps = [np.abs(np.diff(corners(each), axis=1)).max((1, 2, 3)) for each in seen]
    needed = np.ceil(np.max(jumps, 0))
    return np.clip(needed, 1, MAX_SUBFRAMES).astype(int).tolist()


def _layers(scene: Scene) -> tuple[Layer, ...]:
    """All layers, in the order in which they are drawn."""
    return (*scene.behind, scene.target, *scene.front)


def regions(scene: Scene, layer: Layer, times: ArrayLike) -> Regions:
    """True regions of a layer on the screen; of a tilted one before its tilt.

    Parameters
    ----------
    scene : Scene
    layer : Layer
    times : (...) array_like [frames]

    Returns
    -------
    (..., 5) array [px, rad]
    """
    way = spline(layer.path)(times)
    h, w = texture(layer.texture).shape[:2]
    placed = np.empty((*way.shape[:-1], 5))
    placed[..., :3] = way[..., :3]
    placed[..., 3] = way[..., 3] * layer.width / 2
    placed[..., 4] = placed[..., 3] * h / w
    return _seen(scene, placed, times)


def homographies(scene: Scene, layer: Layer, times: ArrayLike) -> Array:
    """True homographies of a layer on the screen, see `mkt.homographies`.

    The layer's middle stays where its region has it, at the distance of the focal
    length, and its plane turns about it.

    Parameters
    ----------
    scene : Scene
    layer : Layer
    times : (...) array_like [frames]

    Returns
    -------
    (..., 3, 3) array
    """
    facing = regions(scene, layer, times)
    if layer.tilt == FLAT:
        return of_regions(facing)
    from scipy.spatial.transform import Rotation  # slow to import, and few cards tilt

    about_x, about_y = np.moveaxis(spline(layer.tilt)(times), -1, 0)
    angles = np.stack([facing[..., 2], about_y, about_x], -1)
    turns = Rotation.from_euler("ZYX", angles.reshape(-1, 3)).as_matrix()
    in_space = turns.reshape(*np.shape(times), 3, 3)
    in_space[..., :2] *= facing[..., None, 3:]
    centre = (np.array(scene.size) - 1) / 2
    in_space[..., :2, 2] = facing[..., :2] - centre
    in_space[..., 2, :2] /= scene.focal
    in_space[..., 2, 2] = 1
    in_space[..., :2, :] += centre[:, None] * in_space[..., 2:, :]
    return in_space


def _seen(scene: Scene, region: Regions, times: ArrayLike) -> Regions:
    """Where the moving camera sees regions (..., 5) of the world at the times (...)."""
    move = spline(scene.camera)(times)
    turn, zoom = move[..., 2], move[..., 3]
    cx, cy = ((side - 1) / 2 for side in scene.size)
    rx, ry = region[..., 0] - cx, region[..., 1] - cy
    c, s = np.cos(turn), np.sin(turn)
    seen = np.empty((*move.shape[:-1], 5))
    seen[..., 0] = cx + move[..., 0] + zoom * (c * rx - s * ry)
    seen[..., 1] = cy + move[..., 1] + zoom * (s * rx + c * ry)
    seen[..., 2] = region[..., 2] + turn
    seen[..., 3] = zoom * region[..., 3]
    seen[..., 4] = zoom * region[..., 4]
    return seen


def _whole(scene: Scene) -> Region:
    """The region of the whole screen."""
    width, height = scene.size
    return np.array([(width - 1) / 2, (height - 1) / 2, 0.0, width / 2, height / 2])


def _instants(scene: Scene, times: Array) -> Iterator[NDArray]:
    """What the sensor sees at each of the times: (H, W, 3) float32 in 0 ... 255."""
    screens = _seen(scene, _whole(scene), times).tolist()
    parts = (_parts(scene, layer, times) for layer in _layers(scene))
    for screen, *painted in zip(screens, *parts, strict=True):
        plane = _background(scene.background, scene.zoom, scene.size, tuple(screen))
        image = plane.astype(np.float32)
        for window, pixels in painted:
            _paint(image[window], pixels)
        yield image


@lru_cache(maxsize=16)
def _background(
    name: str, zoom: float, size: tuple[int, int], screen: tuple[float, ...]
) -> Frame:
    """The background plane where the screen's region (5,) sees it, (H, W, 3) uint8.

    It is kept, because it mostly stands still.
    """
    plane = resized(name, zoom)[..., :3]
    a = _texture_to_screen(of_regions(screen), size)[:2]
    a[:, 2] -= a[:, :2] @ (np.array(plane.shape[1::-1]) - size) / 2
    mirrored = cv2.BORDER_REFLECT_101
    return cv2.warpAffine(plane, a, size, flags=cv2.INTER_LINEAR, borderMode=mirrored)


def _texture_to_screen(homography: Array, size: tuple[int, int]) -> Array:
    """The map (3, 3) from a texture's pixels to the screen.

    The texture, of the size (w, h), fills the image of the canonical square.
    """
    w, h = size
    canonical = np.array([[2 / w, 0, 1 / w - 1], [0, 2 / h, 1 / h - 1], [0, 0, 1]])
    return homography @ canonical


class _Painted(NamedTuple):
    """A layer's part of the screen in an instant.

    Attributes
    ----------
    window : (rows, columns), two slices
    pixels : (h, w, 4) float32 array
        Colours times opacity.
    """

    window: tuple[slice, slice]
    pixels: NDArray


def _parts(scene: Scene, layer: Layer, times: Array) -> Iterator[_Painted]:
    """A layer's part of the screen at each of the times.

    Where the layer lies is computed for all of them at once: for a single one that
    takes longer than to draw it.
    """
    seen = homographies(scene, layer, times)
    outlines = corners(seen)
    low = np.clip(np.floor(outlines.min(1)).astype(int) - 1, 0, scene.size)
    high = np.clip(np.ceil(outlines.max(1)).astype(int) + 2, low, scene.size)
    flat = layer.tilt == FLAT
    for homography, rgba, begin, end in zip(
        seen, looks(layer, times), low, high, strict=True
    ):
        yield _part(homography, rgba, begin, end, flat)


def _part(
    homography: Array, rgba: NDArray, low: NDArray, high: NDArray, flat: bool
) -> _Painted:
    """What a homography makes of a texture in the part (low, high) of the screen."""
    h, w = rgba.shape[0] - 2, rgba.shape[1] - 2
    window = slice(low[1], high[1]), slice(low[0], high[0])
    size = int(high[0] - low[0]), int(high[1] - low[1])
    if min(size) == 0:
        return _Painted(window, np.zeros((*size[::-1], 4), np.float32))
    a = _texture_to_screen(homography, (w, h))
    a[:, 2] -= a[:, :2] @ [1, 1]  # the border of a pixel
    a[:2] -= low[:, None] * a[2]  # the part's corner
    if flat:
        pixels = cv2.warpAffine(rgba, a[:2], size, flags=cv2.INTER_LINEAR)
    else:
        pixels = cv2.warpPerspective(rgba, a, size, flags=cv2.INTER_LINEAR)
    return _Painted(window, pixels)


def _paint(image: NDArray, pixels: NDArray) -> None:
    """Lay a layer's pixels (h, w, 4) over a part of an image (h, w, 3), in place."""
    if pixels.size:
        # Three channels each: to let numpy stretch a factor takes nine times as long.
        image *= cv2.cvtColor(1 - pixels[..., 3], cv2.COLOR_GRAY2RGB)
        image += cv2.cvtColor(pixels, cv2.COLOR_RGBA2RGB)


@lru_cache(maxsize=64)
def _visibility(scene: Scene) -> Array:
    """Visible fraction of the target in every frame, (T,) in [0, 1], read-only.

    Parts that layers in front hide, or that lie outside the image, are not visible.
    """
    times = np.arange(scene.length, dtype=float)
    parts = (_parts(scene, layer, times) for layer in (scene.target, *scene.front))
    seen = [_opacity(scene, *of_one) for of_one in zip(*parts, strict=True)]
    areas = _area(corners(homographies(scene, scene.target, times)))
    whole = [
        look[..., 3].sum() * (area / np.prod(np.array(look.shape[:2]) - 2))
        for look, area in zip(looks(scene.target, times), areas, strict=True)
    ]
    return locked(np.clip(np.array(seen) / whole, 0, 1))


def _opacity(scene: Scene, target: _Painted, *front: _Painted) -> float:
    """The sum of the target's opacity on the screen behind the parts in front of it."""
    opacity = np.zeros(scene.size[::-1], np.float32)
    opacity[target.window] = target.pixels[..., 3]
    for part in front:
        opacity[part.window] *= 1 - part.pixels[..., 3]
    return opacity.sum()


def _area(outlines: Array) -> Array:
    """The areas (...) [px^2] of quadrilaterals with corners (..., 4, 2), in order."""
    x, y = np.moveaxis(outlines[..., 2, :] - outlines[..., 0, :], -1, 0)
    p, q = np.moveaxis(outlines[..., 3, :] - outlines[..., 1, :], -1, 0)
    return np.abs(x * q - y * p) / 2
