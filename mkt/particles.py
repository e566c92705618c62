"""What particle filters share: motion models, resampling, effective sample size.

A particle is a hypothesis about the target: a region and its velocity.  A step of the
filter is *predict* (a motion model moves every particle), *weigh* (the tracker's
business) and *resample*: a scheme ``weights, rng -> ancestors`` says which particles
live on.  All `SCHEMES` share that form.

Explained in notebook 05.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

import numpy as np

from mkt import checks
from mkt.regions import HX, as_regions, size, wrap_angle
from mkt.types import Array, ArrayLike, NDArray, Region, Regions, Rng

NO_DISTRIBUTION = (
    "weights must not be negative, NaN, all zero, or none at all; make them of sum 1 "
    "with `normalised`, from their logarithms"
)


class Particles(NamedTuple):
    """N hypotheses.

    Attributes
    ----------
    regions : (N, 5) array [px, rad]
    velocities : (N, 2) array [px/frame]
        Or whatever else a motion model carries from frame to frame, one row for each
        particle.
    """

    regions: Regions
    velocities: Array

    def take(self, ancestors: NDArray) -> "Particles":
        """The particles that resampling chose; ancestors: (N,) indices."""
        return Particles(self.regions[ancestors], self.velocities[ancestors])


class MotionModel(Protocol):
    """What a particle filter predicts with."""

    def scatter(self, region: ArrayLike, n: int, rng: Rng) -> Particles:
        """Some particles round the region (5,) where a target is first seen."""
        ...

    def predict(self, particles: Particles, rng: Rng) -> Particles:
        """Every particle one frame later."""
        ...


def of_motion(value: Any) -> None:
    """Refuse what is no `MotionModel`, such as the motion of another tracker."""
    known = hasattr(value, "scatter") and hasattr(value, "predict")
    if isinstance(value, type) or not known:
        raise ValueError(f"motion is {value!r}; give a motion model, such as Motion()")


@dataclass(frozen=True)
class Motion:
    """Constant velocity with noise; at damping 0 and velocity 0 it is a random walk.

    All noise is in units of the target, so that doubling the image changes nothing.
    [T09] says "constant velocity model" in its Section IV-A and gives no numbers: these
    are ours.

    Parameters
    ----------
    position : float
        Standard deviation of the place, in sqrt(hx hy) a frame.
    velocity : float
        Of the velocity, in the same unit.
    angle : float
        Of the orientation [rad/frame].
    scale : float
        Of the logarithm of the size.
    damping : float
        Share of the velocity that is kept from one frame to the next.

    Raises
    ------
    ValueError
        Naming the field.
    """

    position: float = 0.06
    velocity: float = 0.05
    angle: float = 0.08
    scale: float = 0.03
    damping: float = 0.8

    def __post_init__(self):
        checks.not_negative(self, "position", "velocity", "angle", "scale")
        checks.shares(self, "damping")

    def scatter(self, region: ArrayLike, n: int, rng: Rng) -> Particles:
        """Some particles, as one frame of noise spreads them round a region (5,)."""
        regions = np.tile(checks.checked_region(region), (n, 1))
        return self.predict(Particles(regions, np.zeros((n, 2))), rng)

    def predict(self, particles: Particles, rng: Rng) -> Particles:
        """Every particle one frame later."""
        regions, velocities = particles
        n = len(regions)
        unit = size(regions)[:, None]
        kicks = self.velocity * unit * rng.standard_normal((n, 2))
        velocities = self.damping * velocities + kicks
        walk = self.position * unit * rng.standard_normal((n, 2))
        centres = regions[:, :2] + velocities + walk
        angles = regions[:, 2] + self.angle * rng.standard_normal(n)
        growth = np.exp(self.scale * rng.standard_normal(n))[:, None]
        moved = np.column_stack([centres, angles, regions[:, 3:] * growth])
        return Particles(moved, velocities)


@dataclass(frozen=True)
class EllipseMotion:
    """s_t = A s_(t-1) + w for s = (x, y, vx, vy, Hx, Hy, va), (9) of [N03].

    The velocity is constant and so is the change of scale: va is the change of a =
    sqrt(Hx^2 + Hy^2) in a frame.  How it enters Hx and Hy is not printed; we take Hx +=
    (Hx0 / a0) va and Hy += (Hy0 / a0) va, with the half axes of the start, which is
    linear and keeps the aspect.  w is Gaussian.  The paper prints no numbers: these are
    ours.

    Parameters
    ----------
    position, velocity : float
        Standard deviations, in sqrt(Hx Hy) a frame.
    axes : float
        Of Hx and of Hy, each for itself, in the same unit.
    growth : float
        Of va, in the same unit.
    smallest : float [px]
        Half axes do not fall below it.

    Raises
    ------
    ValueError
        Naming the field.
    """

    position: float = 0.1
    velocity: float = 0.01
    axes: float = 0.01
    growth: float = 0.002
    smallest: float = 4.0

    def __post_init__(self):
        checks.not_negative(self, "position", "velocity", "axes", "growth")
        checks.positive(self, "smallest")

    def transition(self, half_axes: Array) -> Array:
        """A (7, 7) for a start with half axes (2,) [px]."""
        A = np.eye(7)
        A[[0, 1], [2, 3]] = 1
        A[4:6, 6] = half_axes / np.linalg.norm(half_axes)
        return A

    @property
    def sigma(self) -> Array:
        """Standard deviations (7,) of w, in sqrt(Hx Hy)."""
        place, speed = [self.position] * 2, [self.velocity] * 2
        return np.array([*place, *speed, self.axes, self.axes, self.growth])

    def predict(self, particles: Array, half_axes: Array, rng: Rng) -> Array:
        """Particles (N, 7) one frame later.

        Parameters
        ----------
        particles : (N, 7) array
        half_axes : (2,) array [px]
            Of the start.
        rng : numpy.random.Generator

        Returns
        -------
        (N, 7) array
        """
        unit = np.sqrt(particles[:, 4:5] * particles[:, 5:6])
        w = self.sigma * unit * rng.standard_normal(particles.shape)
        moved = particles @ self.transition(half_axes).T + w
        moved[:, 4:6] = np.maximum(moved[:, 4:6], self.smallest)
        return moved


def normalised(log_weights: ArrayLike) -> Array:
    """Weights of sum 1 from their logarithms.

    They are equal where the largest is not finite, from which no ratio follows.

    Working in the log domain keeps the ratios of weights that are all too small to be
    written down.

    Parameters
    ----------
    log_weights : (N,) array_like

    Returns
    -------
    (N,) array

    Raises
    ------
    ValueError
        For none at all.

    Examples
    --------
    exp(-2000) is 0 to a computer.

    >>> normalised([-2000, -2000 + np.log(3)]).round(9)
    array([0.25, 0.75])
    """
    log_weights = np.asarray(log_weights, float)
    if not log_weights.size:
        raise ValueError("log_weights is empty; give one for each particle")
    top = log_weights.max()
    if not np.isfinite(top):
        return np.full(len(log_weights), 1 / len(log_weights))
    weights = np.exp(log_weights - top)
    return weights / weights.sum()


def effective_sample_size(weights: ArrayLike) -> float:
    """N_eff = 1 / sum w^2 in [1, N], (5) of [C14].

    In our copy of the paper the formula lacks the square, which the listing of Section
    4.5.1 has in its line 7; Algorithm 2 only points to the formula.

    Parameters
    ----------
    weights : (N,) array_like
        Of sum 1.

    Raises
    ------
    ValueError
        For weights that are none, negative, not finite, or not of sum 1.

    Examples
    --------
    >>> equal, alone = [0.25, 0.25, 0.25, 0.25], [1, 0, 0, 0]
    >>> float(effective_sample_size(equal)), float(effective_sample_size(alone))
    (4.0, 1.0)
    """
    weights = _distribution(weights)
    if not _is_one(weights.sum()):
        raise ValueError(NO_DISTRIBUTION)
    return 1.0 / np.sum(np.square(weights))


def mean_region(regions: ArrayLike, weights: ArrayLike) -> Region:
    """Weighted mean, circular for the orientation and geometric for the size.

    [T09] prints the mean after the draw; before the draw the expectation is the same
    and the scatter smaller.

    Parameters
    ----------
    regions : (N, 5) array_like [px, rad]
    weights : (N,) array_like
        Of sum 1.

    Returns
    -------
    (5,) array [px, rad]
        NaN where a region is.

    Raises
    ------
    ValueError
        For regions of another shape or without area, and for weights that are no
        distribution, such as none at all.
    """
    regions = as_regions(regions)
    weights = _distribution(weights)
    if not _is_one(weights.sum()):
        raise ValueError(NO_DISTRIBUTION)
    if regions.shape != (*weights.shape[:1], 5):
        raise ValueError(
            f"regions have the shape {regions.shape} and weights {weights.shape}; "
            "give (N, 5) and (N,), a weight for each region"
        )
    angle = np.angle(weights @ np.exp(1j * regions[:, 2]))
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = np.exp(weights @ np.log(regions[:, HX:]))
    if not (sides[0] > 0 and sides[1] > 0):  # to look at all regions takes longer
        _check_areas(regions)
    return np.concatenate([weights @ regions[:, :2], [angle], sides])


def _check_areas(regions: Regions) -> None:
    """Refuse regions (N, 5) one of which has no area; it may be NaN."""
    empty = np.flatnonzero((regions[:, HX:] <= 0).any(1))
    if empty.size:
        raise ValueError(
            f"region {empty[0]} is {checks.in_words(regions[empty[0]])}, without area; "
            "give half axes hx and hy above 0, or leave it out with its weight"
        )


def covariance(regions: Regions, weights: Array, mean: Region) -> Array:
    """Weighted covariance of regions about their mean, angles the shorter way round.

    Parameters
    ----------
    regions : (N, 5) array [px, rad]
    weights : (N,) array
        Of sum 1.
    mean : (5,) array [px, rad]

    Returns
    -------
    (5, 5) array
        In the units of a region.
    """
    off = regions - mean
    off[:, 2] = wrap_angle(off[:, 2])
    return (weights * off.T) @ off


def independent_positions(n: int, rng: Rng) -> Array:
    """Positions (n,) in [0, 1), each drawn independently."""
    return rng.random(n)


def stratified_positions(n: int, rng: Rng) -> Array:
    """Positions (n,), one in each of n equal strata of [0, 1)."""
    return (np.arange(n) + rng.random(n)) / n


def systematic_positions(n: int, rng: Rng) -> Array:
    """Positions (n,), equally spaced from one random start in [0, 1 / n)."""
    return (np.arange(n) + rng.random()) / n


def multinomial(weights: ArrayLike, rng: Rng) -> NDArray:
    """Indices (N,) of independent draws by weights (N,): step 1 in [N03].

    Each is found by binary search in the cumulative weights.

    Raises
    ------
    ValueError
        For weights that are negative, NaN, all zero, or none at all.
    """
    return search(weights, independent_positions(np.size(weights), rng))


def stratified(weights: ArrayLike, rng: Rng) -> NDArray:
    """Indices (N,) by weights (N,): one draw in each of N equal strata of [0, 1).

    Raises
    ------
    ValueError
        For weights that are negative, NaN, all zero, or none at all.

    Examples
    --------
    A particle that weighs twice its share has two children.

    >>> rng = np.random.default_rng(0)
    >>> stratified([0.5, 0.0, 0.25, 0.25], rng).tolist()
    [0, 0, 2, 3]
    """
    return search(weights, stratified_positions(np.size(weights), rng))


def systematic(weights: ArrayLike, rng: Rng) -> NDArray:
    """Indices (N,) by weights (N,), equally spaced: Algorithm 1 of [C14].

    The draws begin at one random start.  With c_1 = w_1, where our copy reads 0.

    Raises
    ------
    ValueError
        For weights that are negative, NaN, all zero, or none at all.
    """
    return search(weights, systematic_positions(np.size(weights), rng))


def residual(weights: ArrayLike, rng: Rng) -> NDArray:
    """Indices (N,) by weights (N,): floor(N w_i) copies of each are certain.

    The rest is drawn from what rounding left over.

    Raises
    ------
    ValueError
        For weights that are negative, NaN, all zero, or none at all.
    """
    n = np.size(weights)
    certain, left = whole_and_rest(weights)
    copies = np.repeat(np.arange(n), certain)
    missing = n - len(copies)
    if missing == 0:
        return copies
    drawn = search(left, independent_positions(missing, rng))
    return np.concatenate([copies, drawn])


def whole_and_rest(weights: ArrayLike) -> tuple[NDArray, Array]:
    """What `residual` copies for certain, and what it draws from.

    Parameters
    ----------
    weights : (N,) array_like

    Returns
    -------
    certain : (N,) int array
        floor(N w_i).
    left : (N,) array
        N w_i - floor(N w_i).
    """
    weights = _distribution(weights)
    expected = len(weights) * weights / weights.sum()
    certain = np.floor(expected + 1e-9).astype(int)
    return certain, np.maximum(expected - certain, 0)


#: What draws: weights (N,) and a generator in, indices (N,) of ancestors out.
Scheme = Callable[[ArrayLike, Rng], NDArray]
# Nobody can enter one: kept runs and other processes would know nothing of it.
#: The four schemes of resampling by name.
#:
#: :meta hide-value:
SCHEMES: Mapping[str, Scheme] = MappingProxyType(
    {
        "multinomial": multinomial,
        "stratified": stratified,
        "systematic": systematic,
        "residual": residual,
    }
)


def resample_if_degenerate(
    weights: Array, share: float, scheme: Scheme, rng: Rng
) -> tuple[NDArray, Array]:
    """Draw by any scheme when N_eff is below a share of N: Algorithm 2 of [C14].

    Parameters
    ----------
    weights : (N,) array
        Of sum 1.
    share : float
        N_lim over N.
    scheme : callable
        One of `SCHEMES`.
    rng : numpy.random.Generator

    Returns
    -------
    ancestors : (N,) int array
        Each particle is its own ancestor where nothing is drawn.
    weights : (N,) array
        They are equal after a draw, and otherwise unchanged.
    """
    n = len(weights)
    if effective_sample_size(weights) < share * n:
        return scheme(weights, rng), np.full(n, 1 / n)
    return np.arange(n), weights


def search(weights: ArrayLike, positions: ArrayLike) -> NDArray:
    """The particle whose share of the cumulative weights each position falls into.

    Parameters
    ----------
    weights : (N,) array_like
    positions : (K,) array_like
        In [0, 1).

    Returns
    -------
    (K,) int array

    Raises
    ------
    ValueError
        For weights that are no distribution, from which nothing can be drawn.
    """
    cumulative = np.cumsum(_distribution(weights))
    # (n - 1 + u) / n may round to 1.
    below = np.minimum(positions, np.nextafter(1, 0))
    return np.searchsorted(cumulative / cumulative[-1], below, side="right")


def _is_one(total: float) -> bool:
    """Whether weights of this sum are of sum 1, in single precision too."""
    return abs(total - 1) < 1e-4


def _distribution(weights: ArrayLike) -> Array:
    """The weights (N,) as an array; ValueError where they are no distribution."""
    weights = np.asarray(weights, float)
    some = weights.ndim == 1 and weights.size
    if not (some and weights.min() >= 0 and 0 < weights.sum() < np.inf):
        raise ValueError(NO_DISTRIBUTION)
    return weights
