"""The colour particle filter: Section IV of [T09].

With one kernel and an upright box it is also SIR of [C14].

For each frame: predict each particle, weigh it by its likelihood (13), estimate by the
weighted mean, draw the next set with replacement.  No gradient is needed and several
hypotheses can live side by side.

Explained in notebook 05.
"""

from dataclasses import dataclass
from typing import NamedTuple

from mkt import checks
from mkt.colors import BinImage, Bins, ColorBins, binned, of_bins
from mkt.histograms import Target, learn, log_likelihood
from mkt.kernels import Kernels, of_kernels
from mkt.particles import (
    SCHEMES,
    Motion,
    MotionModel,
    Particles,
    covariance,
    effective_sample_size,
    mean_region,
    normalised,
    of_motion,
)
from mkt.tracking import Info, report
from mkt.types import Array, Frame, NDArray, Region, Rng


class FilterState(NamedTuple):
    """The reference and the particles, all of equal weight."""

    target: Target
    particles: Particles


@dataclass(frozen=True)
class ParticleFilter:
    """The bootstrap filter with the likelihood exp(-lam sum_j d_j^2).

    Parameters
    ----------
    n : int
        Number of particles.
    kernels : Kernels
        Nine constant tiles, or any other.
    lam, combine
        See `mkt.histograms.log_likelihood`.
    motion : MotionModel
        The prediction.
    scheme : str
        How to resample, one of `mkt.particles.SCHEMES`.
    bins : Bins
        What the frames are binned with.
    lost_above : float
        The distance d_m beyond which the target is said to be lost.

    Raises
    ------
    ValueError
        Naming the field.
    """

    n: int = 500  # printed, Section VI-A; 75 for the small filter
    kernels: Kernels = Kernels("tiles", "uniform")  # printed, Section IV-B
    lam: float = 20.0  # printed, Section IV-B
    combine: str = "sum"  # ours: (5) is not legible, and the mean is too flat
    motion: MotionModel = Motion()
    scheme: str = "multinomial"  # "random weighted draw"
    bins: Bins = ColorBins()
    lost_above: float = 0.65

    def __post_init__(self):
        of_bins(self.bins)
        of_kernels(self.kernels, "kernels")
        of_motion(self.motion)
        checks.counts(self, "n")
        checks.one_of(self, scheme=SCHEMES, combine=("sum", "mean"))
        checks.not_negative(self, "lam")
        checks.numbers(self, "lost_above")

    def init(self, frame: Frame, region: Region, rng: Rng) -> FilterState:
        """Learn the reference and scatter particles round it."""
        target = learn(binned(self.bins, frame), region, self.kernels)
        return FilterState(target, self.motion.scatter(region, self.n, rng))

    def step(
        self, state: FilterState, frame: Frame, rng: Rng
    ) -> tuple[FilterState, Info]:
        """Predict, weigh, estimate, draw."""
        return self.advance(state, binned(self.bins, frame), rng)

    def advance(
        self, state: FilterState, image: BinImage, rng: Rng
    ) -> tuple[FilterState, Info]:
        """`step` on a frame that is binned already."""
        particles = self.motion.predict(state.particles, rng)
        weights = self.weigh(state.target, image, particles)
        region = mean_region(particles.regions, weights)
        d = state.target.distances(image, region)
        info = report(
            region,
            d,
            bool(d > self.lost_above),
            self.n + 1,
            covariance=covariance(particles.regions, weights, region),
            n_eff=effective_sample_size(weights),
            particles=particles.regions,
            weights=weights,
        )
        ancestors = self.resample(weights, rng)
        return state._replace(particles=particles.take(ancestors)), info

    def resample(self, weights: Array, rng: Rng) -> NDArray:
        """The indices (N,) of the particles that live on, by their weights (N,)."""
        return SCHEMES[self.scheme](weights, rng)

    def weigh(self, target: Target, image: BinImage, particles: Particles) -> Array:
        """The weights of particles, (N,) of sum 1, by the likelihood (13)."""
        rho = target.coefficients(image, particles.regions)
        return normalised(log_likelihood(rho, self.lam, self.combine))
