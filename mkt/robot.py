"""A simulated robot: a camera on its hand, a toy car driven by hand over a table, and the frames that the camera takes.

The car and the table lie in the plane Z = 0 of the world, X to the right, Y down and Z away from a camera that looks at them upright.  A pose is the
matrix (4, 4) that takes camera coordinates to the world; a twist held for a time moves it by the exponential map.  A place is (X, Y, theta) of the
car [m, rad], a path is way-points (t, X, Y, theta) joined linearly, so that a reversal is sudden.

A frame is the mean of sub-frames over the exposure, which ends at the frame's instant because a robot cannot wait for the future, plus noise.
Textures are reduced to the resolution at which the camera sees them, so that nothing aliases.
"""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter1d

from mkt.regions import corners, rotation, wrap_angle
from mkt.servo import Camera, quadrature
from mkt.textures import texture

MAX_SUBFRAMES = 16


def move(pose, twist, dt):
    """The pose (4, 4) after a twist (6,) [m/s, rad/s] in the camera's frame was held for dt [s], possibly negative: pose exp(dt [v])."""
    v, w = np.asarray(twist, float)[:3] * dt, np.asarray(twist, float)[3:] * dt
    K = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    turn = np.sqrt(w @ w)
    a, b = np.sinc(turn / np.pi), np.sinc(turn / (2 * np.pi)) ** 2 / 2  # sin x / x and (1 - cos x) / x^2
    c = (1 - a) / turn**2 if turn > 1e-4 else 1 / 6
    step = np.eye(4)
    step[:3, :3] += a * K + b * K @ K
    step[:3, 3] = v + b * K @ v + c * K @ K @ v
    return pose @ step


def place(path, t):
    """Where the car is at the time t [s].  path: way-points (t, X, Y, theta).  Returns (3,) [m, rad]."""
    table = np.array(path, float)
    return np.array([np.interp(t, table[:, 0], column) for column in table[:, 1:].T])


def to_and_fro(seed=0, speed=0.05, times=(1.0, 6.0, 7.4, 13.0), wobble=0.1, heading=np.pi / 2):
    """A path along Y as a hand would drive it: start, reversals and stop at the given times [s], those of figure 9 in [T09] at 5 frames a second.

    speed [m/s]; wobble: how unsteady the hand is, as a share of the speed; also its drift along X, and, in radians a second, its turning.
    """
    t = np.arange(times[0], times[-1] + 0.05, 0.1)
    middle = (t[1:] + t[:-1]) / 2
    sign = 1 - 2 * (np.searchsorted(times[1:-1], middle) % 2)
    white = np.random.default_rng(seed).standard_normal((3, len(middle)))
    noise = wobble * gaussian_filter1d(white, 5, axis=1, mode="wrap") * np.sqrt(2 * np.sqrt(np.pi) * 5)  # of unit variance before the factor
    rates = np.array([speed * noise[0], speed * (sign + noise[1]), noise[2]])
    places = np.cumsum(np.column_stack([[0, 0, heading], 0.1 * rates]), 1)
    return tuple(map(tuple, np.column_stack([t, *places]).tolist()))


def circle(radius=0.08, period=12.0, length=24.0, heading=np.pi / 2):
    """A path round a circle [m] through the origin, the car keeping its heading, one turn a period [s]."""
    t = np.arange(0, length, 0.1)
    phase = 2 * np.pi * t / period
    table = np.column_stack([t, radius * (np.cos(phase) - 1), radius * np.sin(phase), np.full(len(t), heading)])
    return tuple(map(tuple, table.tolist()))


@dataclass(frozen=True)
class Workspace:
    """What the robot sees, and with what.

    camera: the true one; car: name of a texture of `mkt.textures`, and width: its length on the table [m]; table: name of a texture, and
    table_width: what one copy of it covers [m], mirrored endlessly.  exposure [s]; noise: standard deviation of the sensor's [grey levels].
    Raises ValueError naming the field.
    """

    camera: Camera = Camera()
    car: str = "car"
    width: float = 0.2
    table: str = "workshop"
    table_width: float = 1.2
    exposure: float = 0.02
    noise: float = 3.0

    def __post_init__(self):
        for field, least in (("width", 1e-6), ("table_width", 1e-6), ("exposure", 0), ("noise", 0)):
            if not getattr(self, field) >= least:
                raise ValueError(f"{field} is {getattr(self, field)}; it must be at least {least}")

    @property
    def sides(self):
        """Length and width of the car (2,) [m]."""
        return _sides(self.car, self.width)

    @property
    def surface(self):
        """True area S of the car [m^2]."""
        return float(self.sides.prod())

    def facing(self, region, car):
        """The pose, parallel to the table, from which the car at a place (3,) appears as a region (5,) of the car's aspect."""
        x, y, theta, hx, _ = self.camera.normalised(region)
        pose = np.eye(4)
        pose[:2, :2] = rotation(car[2] - theta)
        depth = self.width / (2 * hx)
        pose[:3, 3] = [*(car[:2] - pose[:2, :2] @ [x * depth, y * depth]), -depth]
        return pose

    def outline(self, pose, car):
        """The car's four corners in the image, (4, 2) [px].  Raises ValueError where the car is behind the camera."""
        return _through(_homography(self.camera, pose), corners(np.array([*car, *(self.sides / 2)])))

    def truth(self, pose, car):
        """What a perfect tracker answers: the region (5,) [px, rad] of the similarity that carries the car best onto its image.

        Where the image is parallel to the table it is the outline itself.  Raises ValueError where the car is behind the camera.
        """
        points, weights = quadrature(corners(np.array([*car, *(self.sides / 2)])))
        seen = _through(_homography(self.camera, pose), points.T)
        centre, (x, y) = weights @ seen / weights.sum(), points - np.reshape(car[:2], (2, 1))
        u, v = (seen - centre).T
        along, across = weights @ (x * u + y * v), weights @ (x * v - y * u)
        scale = np.hypot(along, across) / (weights @ (x * x + y * y))
        return np.array([*centre, wrap_angle(car[2] + np.arctan2(across, along)), *(scale * self.sides / 2)])

    def frame(self, pose, twist, path, t, rng):
        """The frame (H, W, 3) uint8 RGB that is ready at the time t [s], when the camera is at a pose after a twist.

        Raises ValueError where the car is behind the camera or the camera looks past the horizon.
        """
        n = self._subframes(pose, twist, path, t)
        total = np.zeros((*self.camera.size[::-1], 3), np.float32)
        for lag in self.exposure * (np.arange(n) + 0.5) / n:
            cv2.accumulate(self._instant(move(pose, twist, -lag), place(path, t - lag)), total)
        total *= 1 / n
        total += self.noise * rng.standard_normal(total.shape, np.float32)
        return cv2.convertScaleAbs(np.maximum(total, 0, out=total))

    def _subframes(self, pose, twist, path, t):
        """Sub-frames needed so that neither car nor table jumps by more than a pixel from one to the next."""
        before, now = move(pose, twist, -self.exposure), _homography(self.camera, pose)
        seen = _through(np.linalg.inv(now), _frame_corners(self.camera))
        jumps = (self.outline(before, place(path, t - self.exposure)) - self.outline(pose, place(path, t)),
                 _through(_homography(self.camera, before), seen) - _frame_corners(self.camera))
        return int(np.clip(np.ceil(np.abs(jumps).max()), 1, MAX_SUBFRAMES))

    def _instant(self, pose, car):
        """What the sensor sees in an instant, (H, W, 3) uint8."""
        plane = _homography(self.camera, pose)
        image = self._table(plane)
        low, part = self._car(plane, car)
        window = image[low[1]:low[1] + part.shape[0], low[0]:low[0] + part.shape[1]]
        window[:] = window * (1 - part[..., 3:]) + part[..., :3] + 0.5
        return image

    def _table(self, plane):
        rgb = _reduced(self.table, self.table_width, _pixel_size(plane, _frame_corners(self.camera)))
        to_image = plane @ _texture_to_plane(rgb, np.zeros(3), _sides(self.table, self.table_width))
        return cv2.warpPerspective(rgb, to_image, self.camera.size, borderMode=cv2.BORDER_REFLECT)

    def _car(self, plane, car):
        """The car's part of the image: its left top corner (2,) [px] and its pixels (h, w, 4) float32, colours times opacity."""
        outline = _through(plane, corners(np.array([*car, *(self.sides / 2)])))
        low = np.clip(np.floor(outline.min(0)).astype(int) - 1, 0, self.camera.size)
        high = np.clip(np.ceil(outline.max(0)).astype(int) + 2, low, self.camera.size)
        if (high == low).any():
            return low, np.zeros((0, 0, 4), np.float32)
        rgba = _reduced(self.car, self.width, _pixel_size(plane, outline), True)
        shift = np.array([[1, 0, -low[0]], [0, 1, -low[1]], [0, 0, 1.0]])
        return low, cv2.warpPerspective(rgba, shift @ plane @ _texture_to_plane(rgba, car, self.sides, 1), tuple(map(int, high - low)))


def _sides(name, width):
    """Length and height (2,) [m] of what a texture covers when its length is given."""
    h, w = texture(name).shape[:2]
    return width * np.array([1, h / w])


def _homography(camera, pose):
    """The map (3, 3) from points of the table (X, Y, 1) [m] to the image (u, v, 1) [px], times the depth."""
    world = pose[:3, :3].T
    return camera.matrix @ np.column_stack([world[:, :2], -world @ pose[:3, 3]])


def _through(homography, points):
    """Points (n, 2) through a homography.  Raises ValueError where it takes one to infinity or behind the camera."""
    x = np.column_stack([points, np.ones(len(points))]) @ homography.T
    if np.any(x[:, 2] <= 1e-9):
        raise ValueError("the target, or part of the table in view, is behind the camera; start nearer to the desired pose or lower the gain")
    return x[:, :2] / x[:, 2:]


def _frame_corners(camera):
    width, height = camera.size
    return np.array([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1.0]])


def _pixel_size(plane, points):
    """How much of the table [m] a pixel covers, in the direction where it covers most; the mean over image points (n, 2)."""
    inverse = np.linalg.inv(plane)
    x = np.column_stack([points, np.ones(len(points))]) @ inverse.T
    slopes = (inverse[:2, :2] - (x[:, :2] / x[:, 2:])[..., None] * inverse[2, :2]) / x[:, 2, None, None]
    return float(np.linalg.norm(slopes, 2, axis=(1, 2)).mean())


def _reduced(name, width, pixel, cut_out=False):
    """A texture that covers a width [m], reduced to about 1.5 of its pixels for one of the image's [m]: the look-up averages two."""
    finest = width / texture(name).shape[1]
    return _level(name, max(int(np.floor(4 * np.log2(pixel / finest))) - 2, 0), cut_out)


@lru_cache(maxsize=64)
def _level(name, k, cut_out):
    """A texture reduced by 2^(k / 4): (h, w, 3) uint8, or cut out, colours times opacity with a transparent border, (h, w, 4) float32."""
    rgba = texture(name)
    size = tuple(max(round(side * 2 ** (-k / 4)), 4) for side in rgba.shape[1::-1])
    if not cut_out:
        return cv2.resize(np.ascontiguousarray(rgba[..., :3]), size, interpolation=cv2.INTER_AREA)
    alpha = rgba[..., 3:].astype(np.float32) / 255
    small = cv2.resize(np.dstack([rgba[..., :3] * alpha, alpha]), size, interpolation=cv2.INTER_AREA)
    return cv2.copyMakeBorder(small, 1, 1, 1, 1, cv2.BORDER_CONSTANT)


def _texture_to_plane(image, car, sides, border=0):
    """The map (3, 3) from pixels of a texture to the table [m], the texture without its border filling (car, sides), (3,) and (2,)."""
    size = np.array(image.shape[1::-1]) - 2 * border
    turn, scale = np.eye(3), np.diag([*(sides / size), 1])
    turn[:2, :2], turn[:2, 2] = rotation(car[2]), car[:2]
    scale[:2, 2] = sides * ((0.5 - border) / size - 0.5)
    return turn @ scale
