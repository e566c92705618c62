"""The colour particle filter: the probabilistic framework, Section IV of [T09]; with one kernel and an upright box also SIR of [C14].

Every frame: predict each particle, weigh it by its likelihood (13), estimate by the weighted mean, draw the next set with replacement.
No gradient is needed and several hypotheses can live side by side, which is what carries a track through blur and occlusion.

Explained in notebook 05.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mkt.histograms import ColorBins, Target, learn, log_likelihood
from mkt.kernels import Kernels
from mkt.particles import SCHEMES, Motion, Particles, effective_sample_size, mean_region, normalised
from mkt.tracking import check_counts, report


class FilterState(NamedTuple):
    """The reference and the particles, all of equal weight."""

    target: Target
    particles: Particles


@dataclass(frozen=True)
class ParticleFilter:
    """The bootstrap filter with the likelihood exp(-lam sum_j d_j^2).

    n: number of particles; kernels: nine constant tiles, or any other; lam, combine: see `mkt.histograms.log_likelihood`.
    motion: the prediction; scheme: how to resample.  lost_above: the distance d_m beyond which the target is said to be lost.

    Raises ValueError naming the field.
    """

    n: int = 500  # printed, Section VI-A; 75 for the small filter
    kernels: Kernels = Kernels("tiles", "uniform")  # printed, Section IV-B: K constant on nine parts
    lam: float = 20.0  # printed, Section IV-B
    combine: str = "sum"  # ours: (5) is lost, and the mean is too flat
    motion: Motion = Motion()
    scheme: str = "multinomial"  # "random weighted draw"
    bins: ColorBins = ColorBins()
    lost_above: float = 0.65

    def __post_init__(self):
        check_counts(self, "n")
        for field, value, known in (("scheme", self.scheme, SCHEMES), ("combine", self.combine, ("sum", "mean"))):
            if value not in known:
                raise ValueError(f"{field} is {value!r}; it must be one of {', '.join(known)}")
        if not 0 <= self.lam < np.inf:
            raise ValueError(f"lam is {self.lam}; it must be finite, and not negative")

    def init(self, frame, region, rng):
        """Learn the reference and scatter particles round it.  Returns `FilterState`."""
        target = learn(self.bins(frame), region, self.bins, self.kernels)
        return FilterState(target, self.motion.scatter(region, self.n, rng))

    def step(self, state, frame, rng):
        """Predict, weigh, estimate, draw."""
        image = self.bins(frame)
        predicted, weights = self.weigh(state, image, rng)
        region = mean_region(predicted.regions, weights)
        distance = state.target.distances(image, region)
        info = report(region, distance, self.lost_above, n_eff=effective_sample_size(weights), evaluations=self.n + 1, particles=predicted.regions, weights=weights)
        return state._replace(particles=predicted.take(SCHEMES[self.scheme](weights, rng))), info

    def weigh(self, state, image, rng):
        """The predicted particles and their weights of sum 1."""
        predicted = self.motion.predict(state.particles, rng)
        return predicted, normalised(log_likelihood(state.target.coefficients(image, predicted.regions), self.lam, self.combine))
