"""A particle filter whose likelihood knows neighbouring bins, as [N03] wished.

It is the filter of `mkt.trackers.particle_filter` with another distance in (13).

Explained in notebook 17.
"""

from dataclasses import dataclass

import numpy as np

from mkt import checks
from mkt.colors import BinImage, ColorBins
from mkt.histograms import Target, histograms
from mkt.neighbours import MEASURES
from mkt.particles import Particles, normalised
from mkt.trackers.particle_filter import ParticleFilter
from mkt.types import Array


@dataclass(frozen=True)
class CrossBin(ParticleFilter):
    """The bootstrap filter with the likelihood exp(-lam sum_j d_j^2), d of a measure.

    Parameters
    ----------
    measure : str
        One of `mkt.neighbours.MEASURES`; at "bhattacharyya" it is its parent.

    Raises
    ------
    ValueError
        Naming the field.
    """

    measure: str = "smoothed"

    def __post_init__(self):
        super().__post_init__()
        checks.one_of(self, measure=MEASURES)

    def weigh(self, target: Target, image: BinImage, particles: Particles) -> Array:
        """The weights of particles, (N,) of sum 1."""
        q = histograms(image, target.kernels, particles.regions)
        bins = self.bins if isinstance(self.bins, ColorBins) else ColorBins()
        d2 = MEASURES[self.measure](q, target.q, bins)
        return normalised(-self.lam * np.sum(d2, -1))
