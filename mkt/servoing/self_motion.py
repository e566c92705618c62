"""How fast the target moves by itself: measured, filtered, and used in the closed loop.

Between two frames the error changes by the camera's motion, which is known, and by the
target's.  So (18) and (19) of [T09] measure

    z_k = (e_k - e_(k-1)) / dt - L v,

with the twist v that acted between the two frames, and a Kalman filter smooths each
feature's z with the constant-velocity model: de/dt = epsilon stays as it is except for
a coloured noise nu,

    epsilon_(k+1) = epsilon_k + nu_k,
    nu_(k+1) = rho nu_k + w_k,    w ~ N(0, Q),
    z_k = epsilon_k + r_k,        r ~ N(0, R).

Only Q / R matters.  At its two ends there is no filter: 0 ignores the target's motion,
infinity believes every measurement.  The filter runs with its steady gain, so the whole
loop is linear (`mkt.servoing.poles`).

Explained in notebook 09.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mkt.checks import is_number, locked, numbers
from mkt.servoing.features import error
from mkt.types import Array, ArrayLike

RATIOS = 1e-12, 1e12  # of Q / R, beyond which a filter is hardly off or raw
Matrices = tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike]  # A, B, C, D


def measured_self_motion(
    e: Array, previous: Array, L: Array, v: Array, dt: float, angle: str = "theta"
) -> Array:
    """de/dt of the target: how the features move without the camera, (18) and (19).

    Parameters
    ----------
    e, previous : (4,) array
        Errors of two frames.
    L : (4, 6) array
        The interaction matrix.
    v : (6,) array [m/s, rad/s]
        The camera's twist between the frames.
    dt : float [s]
        The time between them.
    angle : str
        "theta" or "alpha", see `mkt.servoing.features.features`.

    Returns
    -------
    (4,) array [1/s]

    Raises
    ------
    ValueError
        For a frame period that is not positive and finite.
    """
    check_period(dt)
    return error(e, previous, angle) / dt - L @ v


def check_period(dt: float) -> None:
    """Raise ValueError for a frame period [s] that is not positive and finite."""
    if not (is_number(dt, 0) and dt > 0):
        raise ValueError(f"dt is {dt!r}; the frame period in seconds must be positive")


@dataclass(frozen=True)
class Kalman:
    """The filter of the module's text, with its steady gain.

    It takes any number of features side by side.  [T09] gives no numbers: these suit 5
    frames a second.  A filter of one's own is a subclass with another `gain`; with
    another `step` it needs its own `matrices`, too, from which poles are computed.

    Parameters
    ----------
    ratio : float
        Q / R, from 0 (compensation off) to infinity (raw); between its two ends it must
        be one whose gain can be computed, see `RATIOS`.
    rho : float
        Correlation of the noise from one frame to the next, in [0, 1).

    Raises
    ------
    ValueError
        Naming the field.
    """

    ratio: float = 1.0
    rho: float = 0.3

    def __post_init__(self):
        numbers(self, "ratio", "rho")
        if not self.ratio >= 0:
            raise ValueError(f"ratio is {self.ratio}; Q / R cannot be negative")
        if 0 < self.ratio < np.inf and not RATIOS[0] <= self.ratio <= RATIOS[1]:
            raise ValueError(
                f"ratio is {self.ratio}; take 0, infinity, or a number from "
                f"{RATIOS[0]:g} to {RATIOS[1]:g}"
            )
        if not 0 <= self.rho < 1:
            raise ValueError(
                f"rho is {self.rho}; the noise's correlation must be in [0, 1)"
            )

    @cached_property
    def transition(self) -> Array:
        """F (2, 2) of the state (epsilon, nu)."""
        return locked(np.array([[1.0, 1.0], [0.0, self.rho]]))

    @cached_property
    def gain(self) -> Array:
        """K (2,) = P H^T / (H P H^T + R).

        P is the steady covariance, from scipy, as `control.dlqe` has it: the package
        control takes most of a second to import.
        """
        if self.ratio == 0:
            return locked(np.zeros(2))
        if np.isinf(self.ratio):
            return locked(np.array([1.0, self.rho]))
        from scipy.linalg import solve_discrete_are

        H = np.array([[1.0, 0.0]])
        Q = np.diag([0.0, self.ratio])
        R = np.eye(1)
        P = solve_discrete_are(self.transition.T, H.T, Q, R)
        return locked(P[:, 0] / (P[0, 0] + 1))

    def step(self, state: Array, z: Array) -> Array:
        """Predict, then correct by the measurement.

        Parameters
        ----------
        state : (2, n) array
            (epsilon, nu) of each feature; all zero at the start.
        z : (n,) array

        Returns
        -------
        (2, n) array
            The next state, whose first row is the estimate.
        """
        predicted = self.transition @ state
        return predicted + self.gain[:, None] * (z - predicted[0])

    @property
    def matrices(self) -> Matrices:
        """A, B, C, D of the filter as a linear system from z to the estimate.

        A filter that is off has no state.
        """
        if self.ratio == 0:
            return [], [], [], [[0.0]]
        F, K = self.transition, self.gain
        A = (np.eye(2) - np.outer(K, [1, 0])) @ F
        C = np.array([[1 - K[0], 0]]) @ F
        return A, K[:, None], C, K[:1, None]


#: No compensation of the object's own motion: the law (17) of [T09] without its term in
#: the object's own motion, de/dt.
OFF = Kalman(0.0)
#: Compensation by the last measurement as it is, unfiltered.
RAW = Kalman(np.inf)
