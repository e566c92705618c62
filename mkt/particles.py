"""What all particle filters share: motion models, resampling schemes, the effective sample size.

A particle is a hypothesis about the target: a region and its velocity.  A filter step is *predict* (a motion model moves every
particle), *weigh* (the tracker's business) and *resample* (a scheme ``weights -> ancestors`` says which particles live on).

Explained in notebook 05.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


class Particles(NamedTuple):
    """N hypotheses: regions (N, 5) [px, rad] and velocities (N, 2) [px a frame]."""

    regions: np.ndarray
    velocities: np.ndarray

    def take(self, ancestors):
        """The particles that resampling chose.  ancestors: (N,) indices."""
        return Particles(self.regions[ancestors], self.velocities[ancestors])


@dataclass(frozen=True)
class Motion:
    """Constant velocity with noise; at damping 0 and velocity 0 it is a random walk.

    All noise is in units of the target, so that doubling the image changes nothing.

    position: standard deviation of the place, in sqrt(hx hy) a frame; velocity: of the velocity, in the same unit.
    angle:    of the orientation [rad a frame]; scale: of the logarithm of the size.
    damping:  share of the velocity that is kept from one frame to the next.

    [T09] says "constant velocity model" and gives no numbers: these are ours.  Section IV-A of [T09].
    """

    position: float = 0.06
    velocity: float = 0.05
    angle: float = 0.08
    scale: float = 0.03
    damping: float = 0.8

    def scatter(self, region, n, rng):
        """Particles spread as one frame of noise would spread them round a known region (5,).  Returns `Particles`."""
        return self.predict(Particles(np.tile(np.asarray(region, float), (n, 1)), np.zeros((n, 2))), rng)

    def predict(self, particles, rng):
        """Every particle one frame later.  Returns new `Particles`."""
        regions, velocities = particles
        n = len(regions)
        unit = np.sqrt(regions[:, 3] * regions[:, 4])[:, None]
        velocities = self.damping * velocities + self.velocity * unit * rng.standard_normal((n, 2))
        centres = regions[:, :2] + velocities + self.position * unit * rng.standard_normal((n, 2))
        angles = regions[:, 2] + self.angle * rng.standard_normal(n)
        sizes = regions[:, 3:] * np.exp(self.scale * rng.standard_normal(n))[:, None]
        return Particles(np.column_stack([centres, angles, sizes]), velocities)


@dataclass(frozen=True)
class EllipseMotion:
    """s_t = A s_(t-1) + w for samples s = (x, y, vx, vy, Hx, Hy, va), (9) of [N03]: constant velocity and constant change of scale.

    va is the change of a = sqrt(Hx^2 + Hy^2) a frame.  How it enters Hx and Hy is not printed; linear, and true to the aspect, is
    Hx += (Hx0 / a0) va and Hy += (Hy0 / a0) va, with the half axes of the start.

    w is Gaussian; standard deviations, in sqrt(Hx Hy) a frame: position, velocity, axes (of Hx and Hy, each for itself), growth (of va).
    smallest: [px] half axes do not fall below it.  The paper prints no numbers: these are ours.
    """

    position: float = 0.1
    velocity: float = 0.01
    axes: float = 0.01
    growth: float = 0.002
    smallest: float = 4.0

    def transition(self, half_axes):
        """A (7, 7) for a start with half axes (2,) [px]."""
        A = np.eye(7)
        A[[0, 1], [2, 3]] = 1
        A[4:6, 6] = half_axes / np.linalg.norm(half_axes)
        return A

    def predict(self, samples, half_axes, rng):
        """Samples (N, 7) one frame later; half_axes: (2,) of the start [px].  Returns (N, 7)."""
        sigma = np.array([self.position, self.position, self.velocity, self.velocity, self.axes, self.axes, self.growth])
        unit = np.sqrt(samples[:, 4:5] * samples[:, 5:6])
        samples = samples @ self.transition(half_axes).T + sigma * unit * rng.standard_normal(samples.shape)
        samples[:, 4:6] = np.maximum(samples[:, 4:6], self.smallest)
        return samples


def normalised(log_weights):
    """Weights of sum 1 from their logarithms, (N,); equal ones when none is finite.

    Working in the log domain keeps the ratios of weights that are all too small to be written down.

    >>> normalised([-2000, -2000 + np.log(3)]).round(9)  # exp(-2000) is 0 to a computer
    array([0.25, 0.75])
    """
    log_weights = np.asarray(log_weights, float)
    top = log_weights.max()
    if not np.isfinite(top):
        return np.full(len(log_weights), 1 / len(log_weights))
    weights = np.exp(log_weights - top)
    return weights / weights.sum()


def effective_sample_size(weights):
    """N_eff = 1 / sum w^2 in [1, N], for weights of sum 1; (5) of [C14] with the square that its listing has and its formula lost.

    >>> float(effective_sample_size([0.25, 0.25, 0.25, 0.25])), float(effective_sample_size([1, 0, 0, 0]))
    (4.0, 1.0)
    """
    return 1.0 / np.sum(np.square(weights))


def mean_region(regions, weights):
    """Weighted mean of regions (N, 5), circular for the orientation, geometric for the size.  weights: (N,) of sum 1.  Returns (5,).

    The paper prints the mean after the draw; before the draw the expectation is the same and the scatter smaller.
    """
    angle = np.angle(weights @ np.exp(1j * regions[:, 2]))
    return np.concatenate([weights @ regions[:, :2], [angle], np.exp(weights @ np.log(regions[:, 3:]))])


def multinomial(weights, rng):
    """N independent draws, each by binary search in the cumulative weights: step 1 of the algorithm in [N03]."""
    return search(weights, rng.random(len(weights)))


def stratified(weights, rng):
    """One draw in each of N equal strata of [0, 1).

    >>> stratified([0.5, 0.0, 0.25, 0.25], np.random.default_rng(0)).tolist()  # who weighs twice its share has two children
    [0, 0, 2, 3]
    """
    n = len(weights)
    return search(weights, (np.arange(n) + rng.random(n)) / n)


def systematic(weights, rng):
    """N equally spaced draws from one random start: Algorithm 1 of [C14], with c_1 = w_1 in place of the printed 0."""
    n = len(weights)
    return search(weights, (np.arange(n) + rng.random()) / n)


def residual(weights, rng):
    """floor(N w_i) copies for certain, the rest drawn from what the rounding left over."""
    n = len(weights)
    certain = np.floor(n * _checked(weights) + 1e-9).astype(int)
    left = n * np.asarray(weights) - certain
    copies = np.repeat(np.arange(n), certain)
    missing = n - len(copies)
    if missing == 0:
        return copies
    return np.concatenate([copies, search(np.maximum(left, 0), rng.random(missing))])


SCHEMES = {"multinomial": multinomial, "stratified": stratified, "systematic": systematic, "residual": residual}


def search(weights, positions):
    """The particle whose share of the cumulative weights (N,) each position in [0, 1) falls into, by binary search.  Returns indices."""
    cumulative = np.cumsum(_checked(weights))
    below = np.minimum(positions, np.nextafter(1, 0))  # (n - 1 + u) / n may be rounded to 1
    return np.searchsorted(cumulative / cumulative[-1], below, side="right")


def _checked(weights):
    """The weights (N,) as an array.  Raises ValueError where they are no distribution, from which nothing can be drawn."""
    weights = np.asarray(weights, float)
    if not (weights.size and weights.min() >= 0 and 0 < weights.sum() < np.inf):
        raise ValueError("weights must not be negative, nor all zero, nor NaN; make them of sum 1 with `normalised`, from their logarithms")
    return weights
