"""The control law of visual servoing, and a gain that adapts to the error.

With the features s, the desired ones s* and the interaction matrix L of
`mkt.servoing.features`, the law (17) of [T09],

    v = -gain L^+ e - L^+ de/dt,    e = s - s*,

makes the error decay as exp(-gain t).  `mkt.servoing.self_motion` finds de/dt, the
target's own motion.

Explained in notebook 08.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mkt import checks
from mkt.checks import in_words, is_number
from mkt.types import Array, ArrayLike

Gain = float | Callable[[Array], float]  # [1/s], a number or a function of the error

# Axes of the twist (vx, vy, vz, wx, wy, wz), by degrees of freedom.
AXES = {6: (0, 1, 2, 3, 4, 5), 4: (0, 1, 2, 5)}


@dataclass(frozen=True)
class AdaptiveGain:
    """A gain [1/s], large near the goal and small far from it.

    This makes the camera quick in the end without being too fast at the start::

        gain(e) = (near - far) exp(-slope |e| / (near - far)) + far,

    where ``|e|`` is the largest component.

    Parameters
    ----------
    near, far : float [1/s]
        The gains at e = 0 and far away.
    slope : float
        How fast the gain falls at e = 0.

    Raises
    ------
    ValueError
        Unless near > far > 0 and slope > 0, all finite.
    """

    near: float = 2.0
    far: float = 0.5
    slope: float = 4.0

    def __post_init__(self):
        checks.positive(self, "near", "far", "slope")
        if not self.near > self.far:
            raise ValueError(
                f"near is {self.near} and far {self.far}; near > far is needed"
            )

    def __call__(self, e: Array) -> float:
        """The gain at the error e (4,)."""
        span = self.near - self.far
        return span * np.exp(-self.slope * np.abs(e).max() / span) + self.far


def twist(
    e: ArrayLike, L: ArrayLike, gain: Gain, de_dt: ArrayLike = 0.0, dof: int = 6
) -> Array:
    """The camera's twist by the control law v = -gain L^+ e - L^+ de/dt, (17).

    The gain is missing in (17) as it is printed.

    Parameters
    ----------
    e : (n,) array_like
        The error of the features, of which there are no more than axes.
    L : (n, 6) array_like
        Their interaction matrix, whose rows must be independent.
    gain : float [1/s] or AdaptiveGain
    de_dt : (n,) array_like or float [1/s]
        The estimate of what the target does by itself.
    dof : int
        6, with the pseudo-inverse of minimum norm, which shares a motion along y
        between vy and wx; or 4: vx, vy, vz, wz alone.

    Returns
    -------
    (6,) array [m/s, rad/s]

    Raises
    ------
    ValueError
        For another dof, for an L or a de_dt that does not fit, for anything that is not
        finite, and where L is singular.
    """
    if not has_axes(dof):
        raise ValueError(f"dof is {dof!r}; it must be 6, or 4 for vx, vy, vz, wz")
    axes = list(AXES[dof])
    e, L, de_dt = (np.asarray(given, float) for given in (e, L, de_dt))
    _check_fit(L, e, de_dt, dof)
    if not all(np.isfinite(given).all() for given in (e, L, de_dt)):
        raise ValueError(
            f"the error {in_words(e)}, its interaction matrix or its estimated rate "
            "is not finite; give features of a region that was seen"
        )
    rate = gain(e) if callable(gain) else gain
    if isinstance(rate, np.ndarray) and rate.ndim == 0:  # such as of np.where
        rate = rate.item()
    if not is_number(rate, -np.inf):
        raise ValueError(
            f"gain is {rate} at the error {in_words(e)}; it must be one finite number"
        )
    wanted = -rate * e - de_dt
    v = np.zeros(6)
    v[axes] = _least_solution(L[:, axes], wanted)
    if not np.abs(L @ v - wanted).max() <= 1e-6 * np.abs(wanted).max():
        raise ValueError(
            "the interaction matrix is singular: some features cannot be controlled; "
            "free more axes, or choose other features"
        )
    return v


def has_axes(dof: Any) -> bool:
    """Whether these are degrees of freedom that the law knows, 6 or 4."""
    return is_number(dof, 0) and dof in AXES


def _check_fit(L: Array, e: Array, de_dt: Array, dof: int) -> None:
    """Refuse numbers of other features, or of more than can be moved."""
    if e.ndim != 1:
        raise ValueError(
            f"e has the shape {e.shape}; give (n,), a number for each feature"
        )
    if de_dt.shape not in ((), e.shape):
        raise ValueError(
            f"de_dt has the shape {de_dt.shape}; give {e.shape}, a number for each "
            "feature, or one for all"
        )
    if L.shape != (*e.shape, 6):
        raise ValueError(
            f"L has the shape {L.shape}; for {e.size} features it is "
            f"{e.size, 6}, a row for each and a column for each axis of the twist"
        )
    if len(L) > dof:
        raise ValueError(
            f"L has {len(L)} rows, one for each feature, which are more than the "
            f"{dof} axes; leave features out"
        )


def _least_solution(J: Array, wanted: Array) -> Array:
    """J^+ wanted = J^T (J J^T)^-1 wanted; NaN where the rows are not independent."""
    try:
        return J.T @ np.linalg.solve(J @ J.T, wanted)
    except np.linalg.LinAlgError:
        return np.full(J.shape[1], np.nan)
