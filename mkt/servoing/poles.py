"""The servo loop of one feature as a linear system: its poles, and its simulation.

Everything is linear except for the camera's perspective: the error grows by the
target's motion and shrinks by the command, which comes so many frames late, and the
Kalman filter of `mkt.servoing.self_motion` runs with its steady gain.  The `control`
package connects these blocks and says where the poles are: the loop is stable while
they lie inside the unit circle.

Explained in notebooks 08 and 09.
"""

from typing import TYPE_CHECKING, cast

import numpy as np

from mkt.checks import is_number, is_whole
from mkt.servoing.self_motion import OFF, Kalman, Matrices, check_period
from mkt.types import Array, ArrayLike

# The control package is imported only where it is needed, because this takes seconds:
# it imports its own plots too.
if TYPE_CHECKING:
    from control import StateSpace


def closed_loop(
    gain: float,
    dt: float,
    kalman: Kalman = OFF,
    delay: int = 0,
    mismatch: float = 1.0,
) -> "StateSpace":
    """The servo loop of one feature as a linear system; see its ``poles()``.

    It leads from the target's own velocity de/dt to the error e.

    Parameters
    ----------
    gain : float [1/s]
    dt : float [s]
        The frame period.
    kalman : Kalman
        The filter of the target's own motion.
    delay : int
        Frames from the exposure to the command.
    mismatch : float
        How many times too large L is thought to be.

    Returns
    -------
    control.StateSpace

    Raises
    ------
    ValueError
        For a frame period or a mismatch that is not positive and finite, a delay that
        is not a whole number from 0 on, and a gain that is not finite.
    """
    _check_loop(gain, dt, delay)
    if not (is_number(mismatch, 0) and mismatch > 0):
        raise ValueError(f"mismatch is {mismatch!r}; it must be positive, and finite")
    import control

    blocks = [
        # The error grows by the target's motion and shrinks by the command u = -L v.
        _sum([1, -1 / mismatch], ["de_dt", "u"], "de", dt),
        _system((1, dt, 1, 0), "de", "e", dt),
        _late(delay, "e", "seen", dt),
        # (18) and (19), with -L v of the twist that acted between the two frames.
        _system((0, 1, -1 / dt, 1 / dt), "seen", "difference", dt),
        _late(delay + 1, "u", "done", dt),
        _sum([1, 1], ["difference", "done"], "z", dt),
        _system(kalman.matrices, "z", "estimate", dt),
        # The law (17).
        _sum([gain, 1], ["seen", "estimate"], "u", dt),
    ]
    loop = control.interconnect(blocks, inputs="de_dt", outputs="e")
    return cast("StateSpace", loop)


def _check_loop(gain: ArrayLike, dt: float, delay: int) -> None:
    check_period(dt)
    if not np.isfinite(gain).all():
        raise ValueError(f"gain is {gain}; it must be finite")
    if not is_whole(delay, 0):
        raise ValueError(
            f"delay is {delay!r}; it must be a whole number of frames, from 0 on"
        )


def _system(
    matrices: Matrices, inputs: str | list[str], output: str, dt: float
) -> "StateSpace":
    """A linear system between signals of these names."""
    import control

    name = f"{inputs} to {output}"
    return control.StateSpace(*matrices, dt, inputs=inputs, outputs=output, name=name)


def _sum(
    weights: list[float], inputs: str | list[str], output: str, dt: float
) -> "StateSpace":
    """A weighted sum of signals."""
    return _system(([], [], [], [weights]), inputs, output, dt)


def _late(frames: int, signal: str, output: str, dt: float) -> "StateSpace":
    """A signal so many frames later."""
    if not frames:
        return _sum([1], signal, output, dt)
    shift = np.eye(frames, k=-1)
    first, last = np.eye(frames, 1), np.eye(1, frames, frames - 1)
    return _system((shift, first, last, 0), signal, output, dt)


def one_feature(
    gain: Array,
    dt: float,
    kalman: Kalman,
    velocity: ArrayLike,
    noise: Array,
    delay: int = 0,
) -> Array:
    """The servo loop of one feature simulated, (17) to (19), n cases side by side.

    `closed_loop` describes the same loop, and `mkt.servoing.loop` closes it with all
    features and a robot.

    Parameters
    ----------
    gain : (n,) array [1/s]
    dt : float [s]
        The frame period.
    kalman : Kalman
        The filter of the target's own motion.
    velocity : (T,) array_like
        The target's own, in any unit of length a second.
    noise : (T, n) array
        Added to the errors that are measured, in that unit of length.
    delay : int
        Frames from the exposure to the command.

    Returns
    -------
    (T, n) array
        The true errors, in that unit of length.

    Raises
    ------
    ValueError
        As `closed_loop` does.
    """
    _check_loop(gain, dt, delay)
    e = np.zeros(len(gain))
    state = np.zeros((2, len(gain)))
    history = []
    seen = []
    sent = [e] * (delay + 1)
    for k, own in enumerate(np.asarray(velocity, float)):
        history.append(e)
        seen.append(e + noise[k])
        now, before = seen[max(k - delay, 0)], seen[max(k - delay - 1, 0)]
        if k:
            measured = (now - before) / dt + sent[-1 - delay]
            state = kalman.step(state, measured)
        command = gain * now + state[0]
        sent.append(command)
        e = e + dt * (own - command)
    return np.array(history)
