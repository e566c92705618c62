"""The controller of visual servoing: regions in, twists of the camera out.

`Servo` is a frozen dataclass with the pure method ``step``, like a tracker: features,
interaction matrix, filter, law.  A tracker that loses the target must not drive the
robot: the camera goes on as it did, but once `Servo.patience` frames in a row are lost,
it is held until the target is found again.

What closes the loop round it is `mkt.servoing.loop`.  Explained in notebooks 08 and 09.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mkt.checks import (
    in_a_tuple,
    in_words,
    is_number,
    is_whole,
    locked,
    positive,
    require,
)
from mkt.regions import HX, HY, as_one_region
from mkt.servoing import law
from mkt.servoing.features import PERIODS, Camera, error, features, interaction_matrix
from mkt.servoing.self_motion import Kalman, measured_self_motion
from mkt.types import Array, ArrayLike


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
        positive(self, "dt", "surface")
        region = in_a_tuple(self.desired, 5) and _has_area(self.desired)
        require(
            self,
            desired=(region, "a tuple, a region with an area"),
            gain=(_is_gain(self.gain), "a number from 0 on, or an AdaptiveGain()"),
            filter=(isinstance(self.filter, Kalman), "a Kalman filter"),
            dof=(law.has_axes(self.dof), "6 or 4"),
            angle=(
                isinstance(self.angle, str) and self.angle in PERIODS,
                "theta or alpha",
            ),
            camera=(isinstance(self.camera, Camera), "a Camera"),
            delay=(is_whole(self.delay, 0), "a whole number of frames, from 0 on"),
            patience=(is_whole(self.patience, 1), "a whole number, from 1 on"),
        )
        if self.angle == "alpha" and self.desired[HX] == self.desired[HY]:
            raise ValueError(
                f'desired is {self.desired}, a square, which has no alpha; use "theta"'
            )

    @cached_property
    def goal(self) -> Array:
        """s* (4,), the features of the desired region."""
        return locked(features(self.desired, self.camera, self.angle))

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
            For more than one region; for one that is not finite or has no area, unless
            it is lost; for a square one, where the angle is alpha; and as
            `mkt.servoing.law.twist` does.
        """
        nothing = lost and not _has_area(region)
        if not nothing:
            _check_seen(region)
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
        return following, _command(s, e, measured, filtered, v, False)

    def _unseen(
        self, state: ServoState, s: Array, e: Array
    ) -> tuple[ServoState, Command]:
        """A step without a target: the camera goes on as it did, then is held."""
        missed = state.missed + 1
        held = missed >= self.patience
        v = np.zeros(6) if held else state.twists[0]
        filtered = np.zeros((2, 4)) if held else state.filter
        following = ServoState(None, _pushed(v, state.twists), filtered, missed)
        return following, _command(s, e, _unknown(), filtered, v, held)


def _command(
    s: Array, e: Array, measured: Array, filtered: Array, v: Array, held: bool
) -> Command:
    """With arrays of its own: the others are those of the state."""
    return Command(s, e.copy(), measured, filtered[0].copy(), v.copy(), held)


def _check_seen(region: ArrayLike) -> None:
    """Refuse what is not one finite region."""
    if not np.isfinite(as_one_region(region)).all():
        raise ValueError(
            f"the region {in_words(region)} is not finite; pass lost=True where the "
            "target was not found"
        )


def _has_area(region: ArrayLike) -> bool:
    """Whether a region (5,) is finite and has an area."""
    numbers = np.asarray(region, float)  # None is NaN
    return bool(np.isfinite(numbers).all() and (numbers[..., HX:] > 0).all())


def _is_gain(gain: law.Gain) -> bool:
    """Whether it is a number from 0 on, or something that is called with an error."""
    return is_number(gain, 0) or (callable(gain) and not isinstance(gain, type))


def _unknown() -> Array:
    """Four numbers where nothing could be measured."""
    return np.full(4, np.nan)


def _pushed(v: Array, twists: Array) -> Array:
    """The last twists with a new one in front, as many as before."""
    return np.concatenate([v[None], twists[:-1]])
