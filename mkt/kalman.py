"""How fast the target moves by itself: measured from two frames, filtered, and what the closed loop makes of it.

Between two frames the error changes by the camera's motion, which is known, and by the target's.  So (18) and (19) of [T09] measure

    z_k = (e_k - e_(k-1)) / dt - L v,    v the twist that acted between the two frames,

and a Kalman filter smooths each feature's z with the constant-velocity model: de/dt = epsilon stays, but for a coloured noise nu,

    epsilon_(k+1) = epsilon_k + nu_k,    nu_(k+1) = rho nu_k + w_k,    z_k = epsilon_k + r_k,    w ~ N(0, Q), r ~ N(0, R).

Only Q / R matters.  Its two ends are no filter: 0 ignores the target's motion, infinity believes every measurement.  The filter runs with
its steady gain, so the whole loop is linear, and the `control` package can say where its poles are.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mkt.servo import error

# The control package is imported where it is needed: that takes seconds, because it brings its own plots.


def drift(e, previous, L, v, dt, angle="theta"):
    """The velocity of the features that is not the camera's doing, (18) and (19).

    e, previous: (4,) errors of two frames that are dt [s] apart; L: (4, 6); v: (6,) the twist between them.  Returns (4,) [1/s].
    Raises ValueError for a frame period that is not positive.
    """
    if not dt > 0:
        raise ValueError(f"dt is {dt}; the frame period in seconds must be positive")
    return error(e, previous, angle) / dt - L @ v


@dataclass(frozen=True)
class Kalman:
    """The filter of the module's text, with its steady gain, for any number of features side by side.

    ratio: Q / R, from 0 (compensation off) to infinity (raw); rho: correlation of the noise from one frame to the next, in [0, 1).
    Raises ValueError naming the field.  [T09] gives no numbers: these suit 5 frames a second.
    """

    ratio: float = 1.0
    rho: float = 0.3

    def __post_init__(self):
        if not self.ratio >= 0:
            raise ValueError(f"ratio is {self.ratio}; Q / R cannot be negative")
        if not 0 <= self.rho < 1:
            raise ValueError(f"rho is {self.rho}; the noise's correlation must be in [0, 1)")

    @cached_property
    def transition(self):
        """F (2, 2) of the state (epsilon, nu)."""
        return np.array([[1.0, 1.0], [0.0, self.rho]])

    @cached_property
    def gain(self):
        """K (2,), from the steady covariance P that `control.dlqe` finds: K = P H^T / (H P H^T + R)."""
        if self.ratio == 0:
            return np.zeros(2)
        if np.isinf(self.ratio):
            return np.array([1.0, self.rho])
        import control

        _, P, _ = control.dlqe(self.transition, np.eye(2), np.array([[1.0, 0.0]]), np.diag([0.0, self.ratio]), 1.0)
        return P[:, 0] / (P[0, 0] + 1)

    def step(self, state, z):
        """Predict, then correct by the measurement.  state: (2, n); z: (n,).  Returns the next state, whose first row is the estimate."""
        predicted = self.transition @ state
        return predicted + self.gain[:, None] * (z - predicted[0])

    @property
    def matrices(self):
        """A, B, C, D of the filter as a linear system from z to the estimate; one that is off has no state."""
        if self.ratio == 0:
            return [], [], [], [[0.0]]
        A = (np.eye(2) - np.outer(self.gain, [1, 0])) @ self.transition
        return A, self.gain[:, None], np.array([[1 - self.gain[0], 0]]) @ self.transition, self.gain[:1, None]


OFF, RAW = Kalman(0.0), Kalman(np.inf)


def closed_loop(gain, dt, filter=OFF, delay=0, mismatch=1.0):
    """The servo loop of one feature, from the target's own velocity de/dt to the error e, as a `control.StateSpace`; see its ``poles()``.

    gain [1/s]; dt [s]; filter: a `Kalman`; delay: frames from the exposure to the command; mismatch: how many times too large L is thought to be.
    Raises ValueError for a frame period that is not positive.
    """
    if not dt > 0:
        raise ValueError(f"dt is {dt}; the frame period in seconds must be positive")
    import control as ct

    def system(A, B, C, D, inputs, outputs):
        return ct.ss(A, B, C, D, dt, inputs=inputs, outputs=outputs, name=f"{inputs} to {outputs}")

    def mix(row, inputs, output):
        return system([], [], [], [row], inputs, output)

    def late(n, inputs, outputs):
        return system(np.eye(n, k=-1), np.eye(n, 1), np.eye(1, n, n - 1), 0, inputs, outputs) if n else mix([1], inputs, outputs)

    return ct.interconnect([
        mix([1, -1 / mismatch], ["drift", "u"], "de"),
        system(1, dt, 1, 0, "de", "e"),
        late(delay, "e", "seen"),
        system(0, 1, -1 / dt, 1 / dt, "seen", "difference"),
        late(delay + 1, "u", "done"),  # -L v of the twist that acted between the two frames
        mix([1, 1], ["difference", "done"], "z"),
        system(*filter.matrices, "z", "estimate"),
        mix([gain, 1], ["seen", "estimate"], "u"),
    ], inputs="drift", outputs="e")
