"""The loop of visual servoing: frame -> any tracker -> features -> law -> camera, and round again.

`Servo` is the controller, a frozen dataclass with the pure method ``step`` like a tracker; `Experiment` says what it is tried on, `run` does it
and returns every history.  Without a tracker the true regions are fed in, with any noise, and nothing has to be rendered.

A tracker that loses the target must not drive the robot: the camera goes on as it did, and from `Servo.patience` lost frames in a row on it is held
until the target is found again.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mkt.kalman import Kalman, drift
from mkt.regions import area
from mkt.robot import Workspace, move, place, to_and_fro
from mkt.servo import AXES, PERIODS, AdaptiveGain, Camera, control, error, features, interaction_matrix
from mkt.tracking import Tracker

UNKNOWN = np.full(4, np.nan)


class ServoState(NamedTuple):
    """The last error (4,), None if there was none; the twists of the last frames (delay + 1, 6), oldest last; the filter's state (2, 4); and how
    many frames in a row were lost."""

    error: np.ndarray | None
    twists: np.ndarray
    filter: np.ndarray
    missed: int


class Command(NamedTuple):
    """What a step of the controller found: features, error, measured and estimated de/dt, (4,) each, NaN where nothing could be measured; the
    twist (6,) until the next frame; and whether the camera is held for lack of a target."""

    features: np.ndarray
    error: np.ndarray
    measured: np.ndarray
    estimated: np.ndarray
    twist: np.ndarray
    held: bool


@dataclass(frozen=True)
class Servo:
    """The controller (14) to (19) of [T09].

    desired: the region (5,) [px, rad] where the target should appear; surface: its true area as the controller believes it [m^2].
    gain: a number [1/s] or an `AdaptiveGain`; filter: of the target's own motion, `kalman.OFF`, `kalman.RAW` or a `Kalman`.
    dt: frame period [s]; dof: 6 or 4; angle: "theta" or "alpha"; camera: as calibrated.
    delay: frames from an exposure to its region; patience: so many lost frames in a row and the camera is held.
    Raises ValueError naming the field.
    """

    desired: tuple[float, ...] = (159.5, 119.5, np.pi / 2, 50.0, 31.25)
    surface: float = 0.025
    gain: float | AdaptiveGain = 1.0
    filter: Kalman = Kalman()
    dt: float = 0.2  # printed: 5 fps
    dof: int = 6  # printed
    angle: str = "theta"
    camera: Camera = Camera()
    delay: int = 0
    patience: int = 3

    def __post_init__(self):
        for field, ok, need in (
            ("dt", self.dt > 0, "a positive frame period in seconds"), ("surface", self.surface > 0, "a positive area in m^2"),
            ("gain", callable(self.gain) or self.gain >= 0, "no negative number"), ("dof", self.dof in AXES, "6 or 4"),
            ("angle", self.angle in PERIODS, "theta or alpha"), ("delay", self.delay >= 0, "no negative number of frames"),
            ("patience", self.patience >= 1, "at least one frame"),
        ):
            if not ok:
                raise ValueError(f"{field} is {getattr(self, field)!r}; it must be {need}")

    @cached_property
    def goal(self):
        """s* (4,), the features of the desired region."""
        return features(self.desired, self.camera, self.angle)

    def init(self):
        """The state before the first frame: at rest, nothing measured."""
        return ServoState(None, np.zeros((self.delay + 1, 6)), np.zeros((2, 4)), 0)

    def step(self, state, region, lost=False):
        """One control iteration: features, interaction matrix, filter, law.  region: (5,) [px, rad].  Returns the next state and a `Command`.

        There is no measurement of de/dt in the first frame and after a lost one: the filter keeps what it has.
        """
        s = features(region, self.camera, self.angle)
        e = error(s, self.goal, self.angle)
        if lost:
            return self._unseen(state, s, e)
        L = interaction_matrix(region, self.camera, self.surface, self.angle)
        z, filtered = UNKNOWN, state.filter
        if state.error is not None:
            z = drift(e, state.error, L, state.twists[-1], self.dt, self.angle)
            filtered = self.filter.step(filtered, z)
        v = control(e, L, self.gain, filtered[0], self.dof)
        return ServoState(e, _pushed(v, state.twists), filtered, 0), Command(s, e, z, filtered[0], v, False)

    def _unseen(self, state, s, e):
        """A step without a target: the camera goes on as it did, then is held."""
        missed = state.missed + 1
        held = missed >= self.patience
        v, filtered = (np.zeros(6), np.zeros((2, 4))) if held else (state.twists[0], state.filter)
        return ServoState(None, _pushed(v, state.twists), filtered, missed), Command(s, e, UNKNOWN, filtered[0], v, held)


def _pushed(v, twists):
    return np.concatenate([v[None], twists[:-1]])


@dataclass(frozen=True)
class Experiment:
    """A controller, what it sees, and how the car moves.

    path: way-points of the car, see `mkt.robot`; start: a twist (6,), in the camera's frame, which moves the camera in one second from where it
    should be to where it starts; frames: how many.  tracker: any, started on the first true region; None for perfect regions with `jitter`,
    a noise [px] of their centre and outline.  seed: of all noise but the path's.
    """

    servo: Servo = Servo()
    workspace: Workspace = Workspace()
    path: tuple[tuple[float, ...], ...] = to_and_fro()
    start: tuple[float, ...] = (0.0,) * 6
    frames: int = 85
    tracker: Tracker | None = None
    jitter: float = 0.0
    seed: int = 0


class Run(NamedTuple):
    """Every history of an experiment, frame by frame, frame k at k dt.

    times: (T,) [s]; poses: (T, 4, 4) of the camera; cars: (T, 3) places [m, rad]; truths, regions: (T, 5) [px, rad], as they are and as they
    were found; lost: (T,) said the tracker; features, errors: (T, 4) that the controller had; measured, estimated: (T, 4) of de/dt [1/s],
    NaN where nothing was measured; velocities: (T, 6), the twist from frame k to k + 1 [m/s, rad/s]; held: (T,) was the camera.
    """

    times: np.ndarray
    poses: np.ndarray
    cars: np.ndarray
    truths: np.ndarray
    regions: np.ndarray
    lost: np.ndarray
    features: np.ndarray
    errors: np.ndarray
    measured: np.ndarray
    estimated: np.ndarray
    velocities: np.ndarray
    held: np.ndarray


def run(experiment):
    """Close the loop.  Returns a `Run`.  Raises ValueError where the target comes behind the camera."""
    x, servo = experiment, experiment.servo
    rng, look = np.random.default_rng(x.seed), None
    pose = move(x.workspace.facing(servo.desired, place(x.path, 0)), x.start, 1)
    state, twist, rows, arriving = servo.init(), np.zeros(6), [], []
    for k in range(x.frames):
        t = k * servo.dt
        car = place(x.path, t)
        truth = x.workspace.truth(pose, car)
        look, region, lost = _look(x, look, truth, pose, twist, k, rng)
        arriving.append((region, lost))
        state, command = servo.step(state, *arriving[max(k - servo.delay, 0)])
        rows.append((t, pose, car, truth, region, lost, *command[:4], command.twist, command.held))
        twist = command.twist
        pose = move(pose, twist, servo.dt)
    return Run(*map(np.array, zip(*rows)))


def view(experiment, run, k):
    """Frame k of a run as the tracker saw it, (H, W, 3) uint8 RGB, rendered again."""
    twist = run.velocities[k - 1] if k else np.zeros(6)
    return _frame(experiment, run.poses[k], twist, k)


def _frame(x, pose, twist, k):
    return x.workspace.frame(pose, twist, x.path, k * x.servo.dt, np.random.default_rng((x.seed, k)))


def _look(x, state, truth, pose, twist, k, rng):
    """What is found in frame k: the tracker's next state, its region (5,) and whether it is lost."""
    if x.tracker is None:
        return None, _jittered(truth, x.jitter, rng), False
    frame = _frame(x, pose, twist, k)
    if k == 0:
        return x.tracker.init(frame, truth, rng), truth, False
    state, info = x.tracker.step(state, frame, rng)
    return state, info["region"], info["lost"]


def _jittered(region, jitter, rng):
    """A region whose centre and outline are off by so many pixels."""
    noise, radius = jitter * rng.standard_normal(4), np.sqrt(area(region) / np.pi)
    return region + np.concatenate([noise[:2], [noise[2] / radius], region[3:] * np.expm1(noise[3] / radius)])
