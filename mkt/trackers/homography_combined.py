"""Particle filter, then SSD, on homographies of a plane, as in Section V of [T09].

A particle is an offset x (k,) from the last estimate in the group of motions, H_i = H
exp(x_i).  So the mean of particles is a mean of vectors, whereas a mean of matrices
would have no meaning; after each frame the offsets are counted from the new estimate,
to first order.  By default they scatter over the similarities alone, round the tilt
that the optimiser found last: four parameters need few particles, eight very many.

Explained in notebook 16.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mkt import checks
from mkt.colors import binned
from mkt.histograms import Target, distance, learn, log_likelihood
from mkt.homographies import as_region, moved
from mkt.kernels import Kernels, of_kernels
from mkt.particles import (
    covariance,
    effective_sample_size,
    normalised,
    systematic,
)
from mkt.trackers.homography import PlaneSSD, PlaneState, plane_report
from mkt.tracking import LAMBDA, Info
from mkt.types import Array, Frame, Region, Rng


class PlaneCombinedState(NamedTuple):
    """The optimiser's state, the filter's reference and its offsets (n, k)."""

    ssd: PlaneState
    target: Target
    offsets: Array


@dataclass(frozen=True)
class PlaneCombined:
    """A small filter on the group, refined by SSD where the target is seen.

    Unlike in `mkt.trackers.combined`, the correction is fed back, because the filter
    does not know the tilt.

    Parameters
    ----------
    n : int
        Number of particles.
    spread : tuple of k float
        Standard deviations of the noise in the first k parameters of
        `mkt.homographies`, in object units, for each frame.
    kernels : Kernels
        The kernels with which particles are weighed.
    ssd : PlaneSSD
    threshold : float
        On the distance d_m at the filter's estimate: beyond it the target is hidden.

    Raises
    ------
    ValueError
        Naming the field.
    """

    # Both chosen on cards of the tuning seeds of which every twelfth frame is shown: 75
    # particles with a third of the spread find fewer.
    n: int = 150
    spread: tuple[float, ...] = (0.6, 0.6, 0.4, 0.15)
    kernels: Kernels = Kernels("tiles", "uniform")
    ssd: PlaneSSD = PlaneSSD()
    threshold: float = 0.6

    def __post_init__(self):
        checks.counts(self, "n")
        checks.numbers(self, "threshold")
        of_kernels(self.kernels, "kernels")
        checks.of_kind(self.ssd, PlaneSSD, "ssd", "give a PlaneSSD()")
        given = checks.in_a_tuple(self.spread, None)
        if not given or len(self.spread) > 8 or min(self.spread) < 0:
            raise ValueError(
                f"spread is {self.spread}; give a tuple, with a number from 0 on for "
                "each of the first parameters that shall scatter, at most 8"
            )

    def init(self, frame: Frame, region: Region, rng: Rng) -> PlaneCombinedState:
        """Both learn the same region."""
        state = self.ssd.init(frame, region, rng)
        target = learn(binned(self.ssd.bins, frame), region, self.kernels)
        return PlaneCombinedState(state, target, np.zeros((self.n, len(self.spread))))

    def step(
        self, state: PlaneCombinedState, frame: Frame, rng: Rng
    ) -> tuple[PlaneCombinedState, Info]:
        """Scatter, weigh, estimate; refine where the target is seen; draw."""
        image = binned(self.ssd.bins, frame)
        ssd, target, offsets = state
        half_sides = target.kernels.half_sides
        offsets = offsets + self.spread * rng.standard_normal(offsets.shape)
        places = moved(ssd.homography, offsets, half_sides)
        rho = target.coefficients(image, places)
        weights = normalised(log_likelihood(rho, LAMBDA))
        mean = weights @ offsets
        estimate = moved(ssd.homography, mean, half_sides)
        d = float(distance(target.coefficients(image, estimate[None])[0], -1))
        lost = d > self.threshold
        steps = 0
        if not lost:
            estimate, d, steps = self.ssd.refine(ssd, image, estimate)
            lost = d > self.ssd.lost_above
        cost = self.n + 1 + steps
        info = plane_report(ssd, estimate, d, lost, cost, steps=steps)
        cloud = as_region(places, half_sides[0] / half_sides[1])
        info |= {
            "covariance": covariance(cloud, weights, info["region"]),
            "n_eff": effective_sample_size(weights),
            "particles": cloud,
            "weights": weights,
        }
        kept = offsets[systematic(weights, rng)] - mean
        ssd = ssd._replace(homography=estimate)
        return PlaneCombinedState(ssd, target, kept), info
