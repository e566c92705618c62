"""A simulated robot: a camera on its hand over a table on which a toy car is driven.

The car and the table lie in the plane Z = 0 of the world, X to the right, Y down and Z
away from a camera that looks at them upright.  A *pose* is the matrix (4, 4) that takes
camera coordinates to the world; a *twist* held for a time moves it by the exponential
map.  A *place* is (X, Y, theta) of the car [m, rad], a *path* is way-points
(t, X, Y, theta) joined linearly, so that a reversal is sudden.

A frame is the mean of sub-frames over the exposure, plus noise.  The exposure ends at
the frame's instant, because a robot cannot wait for the future.  Textures are reduced
to the resolution at which the camera sees them, so that nothing aliases.

Shown in notebooks 07 to 09.
"""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from mkt import checks
from mkt.regions import corners, rotation, wrap_angle
from mkt.scenes.textures import NAMES, texture
from mkt.servoing.features import Camera, quadrature
from mkt.types import Array, ArrayLike, Frame, NDArray, Region, Rng

Path = tuple[tuple[float, ...], ...]  # way-points (t [s], X [m], Y [m], theta [rad])

MAX_SUBFRAMES = 16


class OutOfSight(ValueError):
    """The target, or part of the table in view, is behind the camera."""


def move(pose: Array, twist: ArrayLike, dt: float) -> Array:
    """The pose after a twist was held for a time: pose exp(dt [v]).

    Parameters
    ----------
    pose : (4, 4) array
    twist : (6,) array_like [m/s, rad/s]
        In the camera's frame.
    dt : float [s]
        Possibly negative.

    Returns
    -------
    (4, 4) array
    """
    v, w = np.split(np.asarray(twist, float) * dt, 2)
    # Rodrigues' formula: the turn is I + a K + b K^2, the way (I + b K + c K^2) v.
    K = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    angle = np.sqrt(w @ w)
    a = np.sinc(angle / np.pi)  # sin x / x
    b = np.sinc(angle / (2 * np.pi)) ** 2 / 2  # (1 - cos x) / x^2
    c = (1 - a) / angle**2 if angle > 1e-4 else 1 / 6  # (x - sin x) / x^3
    step = np.eye(4)
    step[:3, :3] += a * K + b * K @ K
    step[:3, 3] = v + b * K @ v + c * K @ K @ v
    return pose @ step


def place(path: Path, t: float) -> Array:
    """Where the car on a path is at the time t [s]: (3,) [m, rad]."""
    times, *columns = np.array(path, float).T
    return np.array([np.interp(t, times, column) for column in columns])


def to_and_fro(
    seed: int = 0,
    speed: float = 0.05,
    times: tuple[float, ...] = (1.0, 6.0, 7.4, 13.0),
    wobble: float = 0.1,
    heading: float = np.pi / 2,
) -> Path:
    """A path along Y as a hand would drive the car.

    Parameters
    ----------
    seed : int
        Of the hand's unsteadiness.
    speed : float [m/s]
    times : tuple of float [s]
        Of the start, of the reversals and of the stop; by default those of figure 9 in
        [T09], at 5 frames a second.
    wobble : float
        How unsteady the hand is, as a share of the speed; also how much it drifts along
        X, and, in radians a second, how much it turns.
    heading : float [rad]
        The orientation at the start.

    Raises
    ------
    ValueError
        For a seed that is none, and for times that do not rise.
    """
    from scipy.ndimage import gaussian_filter1d  # slow to import, for this hand alone

    checks.check_seed(seed)
    rising = checks.are_finite(times, None) and np.all(np.diff(times) > 0)
    if not (rising and len(times) > 1):
        raise ValueError(
            f"times is {times}; give the start, the reversals and the stop, each later "
            "than the one before"
        )
    t = np.arange(times[0], times[-1] + 0.05, 0.1)
    middle = (t[1:] + t[:-1]) / 2
    sign = 1 - 2 * (np.searchsorted(times[1:-1], middle) % 2)
    white = np.random.default_rng(seed).standard_normal((3, len(middle)))
    smooth = gaussian_filter1d(white, 5, axis=1, mode="wrap")
    # Smoothing lowers the variance: this brings it back to 1 before the factor.
    noise = wobble * smooth * np.sqrt(2 * np.sqrt(np.pi) * 5)
    rates = np.array([speed * noise[0], speed * (sign + noise[1]), noise[2]])
    places = np.cumsum(np.column_stack([[0, 0, heading], 0.1 * rates]), 1)
    return _as_path(t, *places)


def circle(
    radius: float = 0.08,
    period: float = 12.0,
    length: float = 24.0,
    heading: float = np.pi / 2,
) -> Path:
    """A path round a circle through the origin, the car keeping its heading.

    Parameters
    ----------
    radius : float [m]
    period : float [s]
        Of one turn.
    length : float [s]
        Of the path; its last way-point is a tenth of a second before this.
    heading : float [rad]

    Raises
    ------
    ValueError
        For a period or a length that is not positive.
    """
    for name, value in {"period": period, "length": length}.items():
        if not (checks.is_number(value, 0) and value > 0):
            raise ValueError(f"{name} is {value}; it must be positive, and finite")
    t = np.arange(0, length, 0.1)
    phase = 2 * np.pi * t / period
    x, y = radius * (np.cos(phase) - 1), radius * np.sin(phase)
    return _as_path(t, x, y, np.full(len(t), heading))


def _as_path(*columns: Array) -> Path:
    return tuple(tuple(row) for row in np.column_stack(columns).tolist())


@dataclass(frozen=True)
class Workspace:
    """What the robot sees, and with what.

    Parameters
    ----------
    camera : Camera
        The true one.
    car : str
        Name of a texture of `mkt.scenes.textures`.
    width : float [m]
        The car's length on the table.
    table : str
        Name of a texture.
    table_width : float [m]
        What one copy of it covers; copies are mirrored endlessly.
    exposure : float [s]
    noise : float [grey levels]
        Standard deviation of the sensor's.

    Raises
    ------
    ValueError
        Naming the field.
    """

    camera: Camera = Camera()
    car: str = "car"
    width: float = 0.2
    table: str = "planks"
    table_width: float = 1.2
    exposure: float = 0.02
    noise: float = 3.0

    def __post_init__(self):
        checks.of_kind(self.camera, Camera, "camera", "give a Camera")
        checks.positive(self, "width", "table_width")
        checks.not_negative(self, "exposure")
        checks.grey_levels(self, "noise")
        checks.one_of(self, car=NAMES, table=NAMES)

    @property
    def sides(self) -> Array:
        """Length and width of the car (2,) [m]."""
        return _sides(self.car, self.width)

    @property
    def surface(self) -> float:
        """True area S of the car [m^2]."""
        return float(self.sides.prod())

    def facing(self, region: ArrayLike, car: ArrayLike) -> Array:
        """The pose, parallel to the table, from which the car appears as a region.

        Parameters
        ----------
        region : (5,) array_like [px, rad]
            Of the car's aspect.
        car : (3,) array_like [m, rad]
            The car's place.

        Returns
        -------
        (4, 4) array

        Raises
        ------
        ValueError
            For what is no region.
        """
        x, y, theta, hx, _ = self.camera.normalised(checks.checked_region(region))
        X, Y, heading = np.asarray(car, float)
        turn = rotation(heading - theta)
        depth = self.width / (2 * hx)
        pose = np.eye(4)
        pose[:2, :2] = turn
        pose[:2, 3] = [X, Y] - turn @ [x * depth, y * depth]
        pose[2, 3] = -depth
        return pose

    def outline(self, pose: Array, car: ArrayLike) -> Array:
        """The car's four corners in the image.

        Parameters
        ----------
        pose : (4, 4) array
        car : (3,) array_like [m, rad]
            The car's place.

        Returns
        -------
        (4, 2) array [px]

        Raises
        ------
        OutOfSight
            A ValueError, where the car is behind the camera.
        """
        return _through(_homography(self.camera, pose), self._corners(car))

    def _corners(self, car: ArrayLike) -> Array:
        """The car's corners (4, 2) [m] on the table."""
        return corners(np.array([*np.asarray(car, float), *(self.sides / 2)]))

    def truth(self, pose: Array, car: ArrayLike) -> Region:
        """The region that a perfect tracker finds.

        It belongs to the similarity that carries the car best onto its image.  Where
        the image is parallel to the table it is the outline itself.

        Parameters
        ----------
        pose : (4, 4) array
        car : (3,) array_like [m, rad]
            The car's place.

        Returns
        -------
        (5,) array [px, rad]

        Raises
        ------
        OutOfSight
            A ValueError, where the car is behind the camera.
        """
        X, Y, heading = np.asarray(car, float)
        points, weights = quadrature(self._corners(car))
        seen = _through(_homography(self.camera, pose), points.T)
        centre = weights @ seen / weights.sum()
        x, y = points - [[X], [Y]]
        u, v = (seen - centre).T
        # Least squares over the car's area: (u, v) = scale R(turn) (x, y).
        along = weights @ (x * u + y * v)
        across = weights @ (x * v - y * u)
        scale = np.hypot(along, across) / (weights @ (x * x + y * y))
        theta = wrap_angle(heading + np.arctan2(across, along))
        return np.array([*centre, theta, *(scale * self.sides / 2)], float)

    def frame(
        self, pose: Array, twist: ArrayLike, path: Path, t: float, rng: Rng
    ) -> Frame:
        """The frame that is ready at the time t.

        Parameters
        ----------
        pose : (4, 4) array
            Of the camera at that time.
        twist : (6,) array_like [m/s, rad/s]
            The twist by which it came there.
        path : tuple of way-points
            The car's.
        t : float [s]
        rng : numpy.random.Generator
            Of the sensor's noise.

        Returns
        -------
        (H, W, 3) uint8 array

        Raises
        ------
        OutOfSight
            A ValueError, where the car is behind the camera or the camera looks past
            the horizon.
        """
        count = self._subframes(pose, twist, path, t)
        total = np.zeros((*self.camera.size[::-1], 3), np.float32)
        for lag in self.exposure * (np.arange(count) + 0.5) / count:
            before = move(pose, twist, -lag)
            cv2.accumulate(self._instant(before, place(path, t - lag)), total)
        total *= 1 / count
        total += self.noise * rng.standard_normal(total.shape, np.float32)
        rounded = cv2.convertScaleAbs(np.maximum(total, 0, out=total))
        return np.asarray(rounded, np.uint8)

    def _subframes(self, pose: Array, twist: ArrayLike, path: Path, t: float) -> int:
        """Number of sub-frames, so that no corner jumps by more than a pixel."""
        earlier = move(pose, twist, -self.exposure)
        first = _homography(self.camera, earlier)
        last = _homography(self.camera, pose)
        screen = _frame_corners(self.camera)
        table = _through(np.linalg.inv(last), screen)
        jumps = (
            self.outline(earlier, place(path, t - self.exposure))
            - self.outline(pose, place(path, t)),
            _through(first, table) - screen,
        )
        return int(np.clip(np.ceil(np.abs(jumps).max()), 1, MAX_SUBFRAMES))

    def _instant(self, pose: Array, car: Array) -> NDArray:
        """What the sensor sees in an instant, (H, W, 3) uint8."""
        plane = _homography(self.camera, pose)
        image = self._table(plane)
        (left, top), part = self._car(plane, car)
        height, width = part.shape[:2]
        window = image[top : top + height, left : left + width]
        # Adding 0.5 rounds; assigning to uint8 alone would cut off the fraction.
        window[:] = window * (1 - part[..., 3:]) + part[..., :3] + 0.5
        return image

    def _table(self, plane: Array) -> NDArray:
        """The image of the table alone, (H, W, 3) uint8."""
        pixel = _pixel_size(plane, _frame_corners(self.camera))
        rgb = _reduced(self.table, self.table_width, pixel)
        sides = _sides(self.table, self.table_width)
        to_image = plane @ _texture_to_plane(rgb, np.zeros(3), sides)
        mirrored = cv2.BORDER_REFLECT
        return cv2.warpPerspective(rgb, to_image, self.camera.size, borderMode=mirrored)

    def _car(self, plane: Array, car: Array) -> tuple[NDArray, NDArray]:
        """The car's part of the image: its left top corner (2,) [px] and its pixels.

        These are (h, w, 4) float32, colours times opacity.
        """
        outline = _through(plane, self._corners(car))
        size = self.camera.size
        low = np.clip(np.floor(outline.min(0)).astype(int) - 1, 0, size)
        high = np.clip(np.ceil(outline.max(0)).astype(int) + 2, low, size)
        if (high == low).any():
            return low, np.zeros((0, 0, 4), np.float32)
        rgba = _reduced(self.car, self.width, _pixel_size(plane, outline), True)
        shift = np.array([[1, 0, -low[0]], [0, 1, -low[1]], [0, 0, 1.0]])
        to_part = shift @ plane @ _texture_to_plane(rgba, car, self.sides, 1)
        width, height = (high - low).tolist()
        return low, cv2.warpPerspective(rgba, to_part, (width, height))


def _sides(name: str, length: float) -> Array:
    """Length and width (2,) [m] of what a texture covers when its length is given."""
    height, width = texture(name).shape[:2]
    return length * np.array([1, height / width])


def _homography(camera: Camera, pose: Array) -> Array:
    """The map (3, 3) from the table (X, Y, 1) [m] to the image [px].

    It gives (u, v, 1) times the depth.
    """
    world = pose[:3, :3].T
    return camera.matrix @ np.column_stack([world[:, :2], -world @ pose[:3, 3]])


def _through(homography: Array, points: Array) -> Array:
    """Points (n, 2) through a homography.

    OutOfSight where it takes one of them to infinity or behind the camera.
    """
    image = _homogeneous(points) @ homography.T
    if np.any(image[:, 2] <= 1e-9):
        raise OutOfSight(
            "the target, or part of the table in view, is behind the camera; "
            "start nearer to the desired pose or lower the gain"
        )
    return image[:, :2] / image[:, 2:]


def _homogeneous(points: Array) -> Array:
    return np.column_stack([points, np.ones(len(points))])


def _frame_corners(camera: Camera) -> Array:
    """The middles of the four corner pixels of the image, (4, 2) [px]."""
    width, height = camera.size
    return np.array(
        [[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1.0]]
    )


def _pixel_size(plane: Array, points: Array) -> float:
    """How much of the table [m] a pixel covers, in the direction where it covers most.

    It is the mean over image points (n, 2).
    """
    inverse = np.linalg.inv(plane)
    table = _homogeneous(points) @ inverse.T
    depths = table[:, 2, None, None]
    places = (table[:, :2] / table[:, 2:])[..., None]
    slopes = (inverse[:2, :2] - places * inverse[2, :2]) / depths
    return float(np.linalg.norm(slopes, 2, axis=(1, 2)).mean())


def _reduced(name: str, width: float, pixel: float, cut_out: bool = False) -> NDArray:
    """A texture that covers a width [m], for pixels of the image of this size [m].

    It is reduced to about 1.5 of its pixels for each pixel of the image, because the
    look-up averages two.
    """
    finest = width / texture(name).shape[1]
    level = int(np.floor(4 * np.log2(pixel / finest))) - 2
    return _level(name, max(level, 0), cut_out)


@lru_cache(maxsize=64)
def _level(name: str, k: int, cut_out: bool) -> NDArray:
    """A texture reduced by 2^(k / 4), (h, w, 3) uint8.

    A cut-out texture is (h, w, 4) float32: colours times opacity, with a transparent
    border.
    """
    rgba = texture(name)
    width, height = (max(round(side * 2 ** (-k / 4)), 4) for side in rgba.shape[1::-1])
    rgb = np.ascontiguousarray(rgba[..., :3])
    area = cv2.INTER_AREA
    if not cut_out:
        return cv2.resize(rgb, (width, height), interpolation=area)
    alpha = rgba[..., 3:].astype(np.float32) / 255
    pixels = np.dstack([rgb * alpha, alpha])
    small = cv2.resize(pixels, (width, height), interpolation=area)
    return cv2.copyMakeBorder(small, 1, 1, 1, 1, cv2.BORDER_CONSTANT)


def _texture_to_plane(
    image: NDArray, car: Array, sides: Array, border: int = 0
) -> Array:
    """The map (3, 3) from pixels of a texture to the table [m].

    The texture without its border fills the rectangle of these sides (2,) at the place
    (3,) of the car.
    """
    size = np.array(image.shape[1::-1]) - 2 * border
    scale = np.diag([*(sides / size), 1])
    scale[:2, 2] = sides * ((0.5 - border) / size - 0.5)
    turn = np.eye(3)
    turn[:2, :2] = rotation(car[2])
    turn[:2, 2] = car[:2]
    return turn @ scale
