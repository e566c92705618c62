"""The loop of visual servoing: frame, any tracker, features, law, camera, and again.

`Experiment` says what a controller, `mkt.servoing.controller.Servo`, is tried on, and
`close_loop` runs it and returns all histories.  Without a tracker the true regions are
fed in, with any noise, and nothing has to be rendered.

Explained in notebooks 08 and 09.
"""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from mkt.checks import in_a_tuple, is_number, is_whole, require
from mkt.regions import area
from mkt.servoing.controller import Command, Servo
from mkt.servoing.robot import OutOfSight, Path, Workspace, move, place, to_and_fro
from mkt.tracking import Tracker, check_tracker, checked_step
from mkt.types import Array, Frame, NDArray, Region, Regions, Rng


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
    path: Path = field(default_factory=to_and_fro)
    start: tuple[float, ...] = (0.0,) * 6
    frames: int = 85
    tracker: Tracker | None = None
    jitter: float = 0.0
    seed: int = 0

    def __post_init__(self):
        if self.tracker is not None:
            check_tracker(self.tracker)
        require(
            self,
            servo=(isinstance(self.servo, Servo), "a Servo"),
            workspace=(isinstance(self.workspace, Workspace), "a Workspace"),
            path=(_is_path(self.path), "a tuple of (t, X, Y, theta), with t rising"),
            start=(in_a_tuple(self.start, 6), "a tuple of six finite numbers"),
            frames=(is_whole(self.frames, 1), "a whole number, at least 1"),
            jitter=(is_number(self.jitter, 0), "a finite number from 0 on"),
            seed=(is_whole(self.seed, 0), "a whole number, at least 0"),
        )


def _is_path(path: Any) -> bool:
    """Whether these are way-points, one after the other in time."""
    if not (in_a_tuple(path, None, 4) and all(isinstance(p, tuple) for p in path)):
        return False
    return bool((np.diff(np.array(path)[:, 0]) > 0).all())


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
        Of de/dt; NaN where nothing was measured.  With a delay the first picture is
        seen several times, and 0 is measured there.
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
        return _Sight(truth, False, tracker.init(frame, truth.copy(), rng))
    stepped = tracker.step(before.state, frame, rng)
    state, info = checked_step(tracker, stepped)
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
