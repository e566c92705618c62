"""The loop of visual servoing: frame, any tracker, features, law, camera, and again.

`Servo` is the controller, a frozen dataclass with the pure method ``step`` like a
tracker; `Experiment` says what it is tried on, `close_loop` runs it and returns all
histories.  Without a tracker the true regions are fed in, with any noise, and nothing
has to be rendered.

A tracker that loses the target must not drive the robot: the camera goes on as it did,
but once `Servo.patience` frames in a row are lost, it is held until the target is found
again.

Explained in notebooks 08 and 09.
"""

import reprlib
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from mkt.checks import is_whole
from mkt.regions import HX, area
from mkt.servoing import law
from mkt.servoing.features import PERIODS, Camera, error, features, interaction_matrix
from mkt.servoing.robot import OutOfSight, Path, Workspace, move, place, to_and_fro
from mkt.servoing.self_motion import Kalman, measured_self_motion
from mkt.tracking import Tracker, check_tracker
from mkt.types import Array, ArrayLike, Frame, NDArray, Region, Regions, Rng


class ServoState(NamedTuple):
    """What the controller carries from frame to frame.

    Attributes
    ----------
    error : (4,) array, or None
        The last error, None if there was none.
    twists : (delay + 1, 6) array
        The twists of the last frames, the oldest last.
    filter : (2, 4) array
        The filter's state.
    missed : int
        How many frames in a row were lost.
    """

    error: Array | None
    twists: Array
    filter: Array
    missed: int


class Command(NamedTuple):
    """What a step of the controller found.

    Attributes
    ----------
    features, error : (4,) array
        NaN where the tracker is lost and gives no region.
    measured, estimated : (4,) array [1/s]
        de/dt of the target; NaN where nothing could be measured.
    twist : (6,) array [m/s, rad/s]
        The twist until the next frame.
    held : bool
        Whether the camera is held for lack of a target.
    """

    features: Array
    error: Array
    measured: Array
    estimated: Array
    twist: Array
    held: bool


@dataclass(frozen=True)
class Servo:
    """The controller (14) to (19) of [T09].

    Parameters
    ----------
    desired : tuple of five float [px, rad]
        The region where the target should appear.
    surface : float [m^2]
        The target's true area as the controller believes it.
    gain : float [1/s] or AdaptiveGain
    filter : Kalman
        Of the target's own motion: `self_motion.OFF`, `self_motion.RAW` or any other.
    dt : float [s]
        The frame period.
    dof : int
        6 or 4, see `mkt.servoing.law.twist`.
    angle : str
        "theta" or "alpha", see `mkt.servoing.features.features`.
    camera : Camera
        As calibrated.
    delay : int
        Frames from an exposure to its region.
    patience : int
        Once so many frames in a row are lost, the camera is held.

    Raises
    ------
    ValueError
        Naming the field.
    """

    desired: tuple[float, ...] = (159.5, 119.5, np.pi / 2, 50.0, 31.25)
    surface: float = 0.025
    gain: law.Gain = 1.0
    filter: Kalman = Kalman()
    dt: float = 0.2  # printed: 5 fps
    dof: int = 6  # printed
    angle: str = "theta"
    camera: Camera = Camera()
    delay: int = 0
    patience: int = 3

    def __post_init__(self):
        five = np.shape(self.desired) == (5,)
        for field, possible, need in (
            ("desired", five and _has_area(self.desired), "a region with an area"),
            ("dt", 0 < self.dt < np.inf, "a positive frame period in seconds"),
            ("surface", 0 < self.surface < np.inf, "a positive area in m^2"),
            ("gain", _is_gain(self.gain), "a number from 0 on, or an AdaptiveGain()"),
            ("filter", isinstance(self.filter, Kalman), "a Kalman filter"),
            ("dof", self.dof in law.AXES, "6 or 4"),
            ("angle", self.angle in PERIODS, "theta or alpha"),
            ("delay", is_whole(self.delay, 0), "a whole number of frames, from 0 on"),
            ("patience", is_whole(self.patience, 1), "a whole number, from 1 on"),
        ):
            if not possible:
                raise ValueError(
                    f"{field} is {getattr(self, field)!r}; it must be {need}"
                )

    @cached_property
    def goal(self) -> Array:
        """s* (4,), the features of the desired region."""
        return features(self.desired, self.camera, self.angle)

    def init(self) -> ServoState:
        """The state before the first frame: at rest, nothing measured."""
        return ServoState(None, np.zeros((self.delay + 1, 6)), np.zeros((2, 4)), 0)

    def step(
        self, state: ServoState, region: ArrayLike, lost: bool = False
    ) -> tuple[ServoState, Command]:
        """One control iteration: features, interaction matrix, filter, law.

        There is no measurement of de/dt in the first frame and after a lost one: the
        filter keeps what it has.

        Parameters
        ----------
        state : ServoState
        region : (5,) array_like [px, rad]
            What the tracker found.
        lost : bool
            Whether it says that the target is lost.

        Raises
        ------
        ValueError
            For a region without area, unless it is lost.
        """
        nothing = lost and not _has_area(region)
        s = _unknown() if nothing else features(region, self.camera, self.angle)
        e = error(s, self.goal, self.angle)
        if lost:
            return self._unseen(state, s, e)
        L = interaction_matrix(region, self.camera, self.surface, self.angle)
        measured = _unknown()
        filtered = state.filter
        if state.error is not None:
            measured = measured_self_motion(
                e, state.error, L, state.twists[-1], self.dt, self.angle
            )
            filtered = self.filter.step(filtered, measured)
        v = law.twist(e, L, self.gain, filtered[0], self.dof)
        following = ServoState(e, _pushed(v, state.twists), filtered, 0)
        return following, Command(s, e, measured, filtered[0], v, False)

    def _unseen(
        self, state: ServoState, s: Array, e: Array
    ) -> tuple[ServoState, Command]:
        """A step without a target: the camera goes on as it did, then is held."""
        missed = state.missed + 1
        held = missed >= self.patience
        v = np.zeros(6) if held else state.twists[0]
        filtered = np.zeros((2, 4)) if held else state.filter
        following = ServoState(None, _pushed(v, state.twists), filtered, missed)
        return following, Command(s, e, _unknown(), filtered[0], v, held)


def _has_area(region: ArrayLike) -> bool:
    """Whether a region (5,) is finite and has an area."""
    return bool(np.isfinite(region).all() and np.min(np.asarray(region)[HX:]) > 0)


def _is_gain(gain: law.Gain) -> bool:
    """Whether it is a number from 0 on, or something that is called with an error."""
    if isinstance(gain, int | float | np.number):
        return bool(0 <= gain < np.inf)
    return callable(gain) and not isinstance(gain, type)


def _unknown() -> Array:
    """Four numbers where nothing could be measured."""
    return np.full(4, np.nan)


def _pushed(v: Array, twists: Array) -> Array:
    """The last twists with a new one in front, as many as before."""
    return np.concatenate([v[None], twists[:-1]])


@dataclass(frozen=True)
class Experiment:
    """A controller, what it sees, and how the car moves.

    Parameters
    ----------
    servo : Servo
    workspace : Workspace
    path : tuple of way-points
        The car's, see `mkt.servoing.robot`.
    start : tuple of six float [m, rad]
        A twist in the camera's frame, which moves the camera in one second from where
        it should be to where it starts.
    frames : int
        Number of frames.
    tracker : Tracker, optional
        Any tracker, which is started on the first true region; None for perfect
        regions.
    jitter : float [px]
        Noise of the centre and the outline of perfect regions.
    seed : int
        Of all noise but the path's.

    Raises
    ------
    ValueError
        Naming the field.
    """

    servo: Servo = Servo()
    workspace: Workspace = Workspace()
    path: Path = to_and_fro()
    start: tuple[float, ...] = (0.0,) * 6
    frames: int = 85
    tracker: Tracker | None = None
    jitter: float = 0.0
    seed: int = 0

    def __post_init__(self):
        if self.tracker is not None:
            check_tracker(self.tracker)
        for field, possible, need in (
            ("servo", isinstance(self.servo, Servo), "a Servo"),
            ("workspace", isinstance(self.workspace, Workspace), "a Workspace"),
            ("path", _is_path(self.path), "way-points (t, X, Y, theta), t increasing"),
            ("start", _are_finite(self.start, (6,)), "six finite numbers"),
            ("frames", is_whole(self.frames, 1), "a whole number, at least 1"),
            ("jitter", 0 <= self.jitter < np.inf, "a number from 0 on"),
            ("seed", is_whole(self.seed, 0), "a whole number, at least 0"),
        ):
            if not possible:
                found = reprlib.repr(getattr(self, field))
                raise ValueError(f"{field} is {found}; it must be {need}")


def _is_path(path: Any) -> bool:
    """Whether these are way-points, one after the other in time."""
    ordered = _are_finite(path, (None, 4)) and np.diff(np.array(path)[:, 0]) >= 0
    return bool(np.all(ordered))


def _are_finite(numbers: Any, shape: tuple[int | None, ...]) -> bool:
    """Whether numbers are finite and of a shape, None for any length but 0."""
    try:
        array = np.array(numbers, float)
    except (TypeError, ValueError):
        return False
    fits = array.ndim == len(shape) and array.size > 0
    fits = fits and all(n in (None, m) for n, m in zip(shape, array.shape, strict=True))
    return bool(fits and np.isfinite(array).all())


class Run(NamedTuple):
    """Every history of an experiment, frame by frame, frame k at k dt.

    Attributes
    ----------
    times : (T,) array [s]
    poses : (T, 4, 4) array
        Of the camera.
    cars : (T, 3) array [m, rad]
        Places of the car.
    truths, regions : (T, 5) array [px, rad]
        The true regions, and those that were found.
    lost : (T,) bool array
        Whether the tracker said that the target is lost.
    features, errors : (T, 4) array
        Those that the controller had.
    measured, estimated : (T, 4) array [1/s]
        Of de/dt; NaN where nothing was measured.
    velocities : (T, 6) array [m/s, rad/s]
        The twist from frame k to k + 1.
    held : (T,) bool array
        Whether the camera was held.
    """

    times: Array
    poses: Array
    cars: Array
    truths: Regions
    regions: Regions
    lost: NDArray
    features: Array
    errors: Array
    measured: Array
    estimated: Array
    velocities: Array
    held: NDArray


def close_loop(experiment: Experiment, until_lost: bool = False) -> Run:
    """Close the loop.

    Parameters
    ----------
    experiment : Experiment
    until_lost : bool
        Whether to end a run that gets out of control, with shorter histories, before
        the frame at which the target, or a part of it, comes behind the camera.  A
        target beside the image, or lost by the tracker, does not end it.

    Raises
    ------
    OutOfSight
        A ValueError, where the target comes behind the camera, or a tracker needs a
        frame and the camera looks past the horizon; with `until_lost` only in the first
        frame.
    """
    rows = []
    try:
        for row in _rows(experiment):
            if until_lost:
                # All of the car: what a perfect tracker needs may be seen for longer.
                experiment.workspace.outline(row["poses"], row["cars"])
            rows.append(row)
    except OutOfSight:
        if not (until_lost and rows):
            raise
    return Run(**{name: _column(name, rows) for name in Run._fields})


def _column(name: str, rows: list[dict[str, Any]]) -> NDArray:
    return np.array([row[name] for row in rows])


class _Instant(NamedTuple):
    """Frame k as it is: the camera's pose after a twist, the car's place and region."""

    k: int
    time: float
    pose: Array
    twist: Array
    car: Array
    truth: Region


class _Sight(NamedTuple):
    """What is found in a frame, whether it is lost, and the tracker's state."""

    region: Region
    lost: bool
    state: Any


def _rows(experiment: Experiment) -> Iterator[dict[str, Any]]:
    """The loop itself: the entries of a `Run`, for each frame."""
    servo = experiment.servo
    rng = np.random.default_rng(experiment.seed)
    pose = _start(experiment)
    v = np.zeros(6)
    state = servo.init()
    sight = None
    # What is on its way to the controller, the oldest first.
    arriving: deque[_Sight] = deque(maxlen=servo.delay + 1)
    for k in range(experiment.frames):
        instant = _instant(experiment, k, pose, v)
        sight = _look(experiment, instant, sight, rng)
        arriving.append(sight)
        state, command = servo.step(state, arriving[0].region, arriving[0].lost)
        yield _row(instant, sight, command)
        v = command.twist
        pose = move(pose, v, servo.dt)


def _start(experiment: Experiment) -> Array:
    """The camera's pose (4, 4) in the first frame."""
    car = place(experiment.path, 0)
    wanted = experiment.workspace.facing(experiment.servo.desired, car)
    return move(wanted, experiment.start, 1)


def _instant(experiment: Experiment, k: int, pose: Array, twist: Array) -> _Instant:
    time = k * experiment.servo.dt
    car = place(experiment.path, time)
    truth = experiment.workspace.truth(pose, car)
    return _Instant(k, time, pose, twist, car, truth)


def _look(
    experiment: Experiment, instant: _Instant, before: _Sight | None, rng: Rng
) -> _Sight:
    """What is found in a frame, after what was found in the frame before."""
    tracker, truth = experiment.tracker, instant.truth
    if tracker is None:
        return _Sight(_jittered(truth, experiment.jitter, rng), False, None)
    frame = _frame(experiment, instant.k, instant.pose, instant.twist)
    if before is None:
        return _Sight(truth, False, tracker.init(frame, truth, rng))
    state, info = tracker.step(before.state, frame, rng)
    return _Sight(info["region"], info["lost"], state)


def _jittered(region: Region, jitter: float, rng: Rng) -> Region:
    """A region whose centre and outline are off by so many pixels."""
    dx, dy, around, across = jitter * rng.standard_normal(4)
    radius = np.sqrt(area(region) / np.pi)
    growth = region[3:] * np.expm1(across / radius)
    return region + np.array([dx, dy, around / radius, *growth])


def _row(instant: _Instant, sight: _Sight, command: Command) -> dict[str, Any]:
    """The entries of a `Run` for one frame."""
    return {
        "times": instant.time,
        "poses": instant.pose,
        "cars": instant.car,
        "truths": instant.truth,
        "regions": sight.region,
        "lost": sight.lost,
        "features": command.features,
        "errors": command.error,
        "measured": command.measured,
        "estimated": command.estimated,
        "velocities": command.twist,
        "held": command.held,
    }


def view(experiment: Experiment, run: Run, k: int) -> Frame:
    """Frame k of a run as the tracker saw it, (H, W, 3) uint8 RGB, rendered again."""
    twist = run.velocities[k - 1] if k else np.zeros(6)
    return _frame(experiment, k, run.poses[k], twist)


def _frame(experiment: Experiment, k: int, pose: Array, twist: Array) -> Frame:
    """Frame k, taken from a pose after a twist."""
    time = k * experiment.servo.dt
    noise = np.random.default_rng((experiment.seed, k))
    return experiment.workspace.frame(pose, twist, experiment.path, time, noise)
