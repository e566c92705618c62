"""A motion model learnt from earlier tracks, as [N03] wished.

The state s = (x, y, theta, ln size) follows a second-order autoregression,

    s_t = s_(t-1) + phi (s_(t-1) - s_(t-2)) + w,    w ~ N(0, sigma^2),

with one root at 1, because nothing pulls a target to a place in the image.  So what is
learnt is how a *change* follows from the last one: phi and sigma for each component.
Places are in units of the target, as in `mkt.particles.Motion`, whose phi and sigma
are set by hand, and which carries on the velocity of the place alone.

Explained in notebook 17.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from mkt.checks import checked_region, in_a_tuple
from mkt.particles import Particles
from mkt.regions import HX, size
from mkt.types import Array, ArrayLike, Regions, Rng

SAME = 0, 0, 1, 2  # x and y, which no axis of an image tells apart, share their numbers


@dataclass(frozen=True)
class AutoRegression:
    """The model of the module's text, a motion model for a `ParticleFilter`.

    The three numbers of a field belong to the place, in sqrt(hx hy) a frame, to the
    orientation [rad/frame] and to the logarithm of the size.  `learnt` finds them.

    Parameters
    ----------
    phi : tuple of three float
        Share of a change that is kept from one frame to the next.
    sigma : tuple of three float
        Standard deviations of the noise w.
    spread : tuple of three float
        Standard deviations of the random change with which each particle starts.

    Raises
    ------
    ValueError
        Naming the field.
    """

    phi: tuple[float, float, float]
    sigma: tuple[float, float, float]
    spread: tuple[float, float, float]

    def __post_init__(self):
        for field, least, need in (
            ("phi", -np.inf, "three finite numbers"),
            ("sigma", 0, "three finite numbers from 0 on"),
            ("spread", 0, "three finite numbers from 0 on"),
        ):
            value = getattr(self, field)
            if not (in_a_tuple(value, 3) and np.min(value) >= least):
                raise ValueError(f"{field} is {value}; it must be a tuple of {need}")

    def scatter(self, region: ArrayLike, n: int, rng: Rng) -> Particles:
        """Some particles at a region (5,) [px, rad], each with a change of its own.

        Raises
        ------
        ValueError
            Where it is not one region, is not finite or has no area.
        """
        changes = np.take(self.spread, SAME) * rng.standard_normal((n, 4))
        regions = np.tile(checked_region(region), (n, 1))
        return self.predict(Particles(regions, changes), rng)

    def predict(self, particles: Particles, rng: Rng) -> Particles:
        """Every particle one frame later; their velocities are the changes (N, 4)."""
        regions, changes = particles
        noise = np.take(self.sigma, SAME) * rng.standard_normal(changes.shape)
        changes = np.take(self.phi, SAME) * changes + noise
        unit = size(regions)[:, None]
        centres = regions[:, :2] + changes[:, :2] * unit
        angles = regions[:, 2] + changes[:, 2]
        sides = regions[:, 3:] * np.exp(changes[:, 3:])
        return Particles(np.column_stack([centres, angles, sides]), changes)


def changes(regions: Regions) -> Array:
    """What changes from frame to frame in a track (T, 5), in the model's units.

    Parameters
    ----------
    regions : (T, 5) array [px, rad]

    Returns
    -------
    (T - 1, 4) array
    """
    units = size(regions)
    steps = np.diff(regions[:, :2], axis=0) / units[:-1, None]
    turns = np.diff(np.unwrap(regions[:, 2]))
    return np.column_stack([steps, turns, np.diff(np.log(units))])


def learnt(tracks: Iterable[Regions], loosen: float = 1.0) -> AutoRegression:
    """The model of some tracks, by least squares: the equation of Yule and Walker.

    phi = sum u_t u_(t-1) / sum u_(t-1)^2 for the changes u, but within -1 and 1, beyond
    which changes would grow without end; sigma^2 is the mean square of the residuals.

    Parameters
    ----------
    tracks : iterable of (T, 5) arrays [px, rad]
        Each of at least three frames, without NaN.
    loosen : float
        Factor on sigma.  A filter needs more noise than the true tracks show, because
        its few particles must also correct their own errors.

    Raises
    ------
    ValueError
        For no track, for one alone that is in no list, for one of fewer frames, for
        regions that are not finite or have no area, and for a negative factor.
    """
    tracks = [np.asarray(track, float) for track in tracks]
    if wrong := [track.shape for track in tracks if track.shape[1:] != (5,)]:
        raise ValueError(
            f"a track has the shape {wrong[0]}; give a list of tracks, each (T, 5)"
        )
    if not 0 <= loosen < np.inf:
        raise ValueError(f"loosen is {loosen}; it must be a number from 0 on")
    if min(map(len, tracks), default=0) < 3:
        raise ValueError(
            f"tracks have {[len(track) for track in tracks]} frames; "
            "give at least one track, each of at least three frames"
        )
    if not all(np.isfinite(t).all() and (t[:, HX:] > 0).all() for t in tracks):
        raise ValueError(
            "a track has regions that are not finite or have no area; leave them out, "
            "and give what is before and behind them as two tracks"
        )
    moves = [(u[:-1], u[1:]) for u in map(changes, tracks)]
    before, after = (_pooled(np.concatenate(side)) for side in zip(*moves, strict=True))
    pairs = list(zip(before, after, strict=True))
    ratios = [float(b @ a) / max(float(b @ b), 1e-300) for b, a in pairs]
    phi = [min(max(ratio, -1.0), 1.0) for ratio in ratios]
    left = [a - f * b for f, (b, a) in zip(phi, pairs, strict=True)]
    sigma = [loosen * deviation for deviation in _deviations(left)]
    return AutoRegression(_three(phi), _three(sigma), _deviations(after))


def _pooled(changes: Array) -> list[Array]:
    """The columns of changes (n, 4), those of x and y joined into one."""
    return [changes[:, :2].ravel(), changes[:, 2], changes[:, 3]]


def _deviations(columns: Iterable[Array]) -> tuple[float, float, float]:
    return _three(np.sqrt(np.mean(column**2)) for column in columns)


def _three(numbers: Iterable[float]) -> tuple[float, float, float]:
    """Three numbers, with as many digits as tables and cache keys need."""
    first, second, third = (float(f"{number:.4g}") for number in numbers)
    return first, second, third
