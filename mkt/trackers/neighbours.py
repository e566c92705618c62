"""A particle filter whose likelihood knows neighbouring bins, as [N03] wished.

It is the filter of `mkt.trackers.particle_filter` with another distance in (13).

Explained in notebook 17.
"""

from dataclasses import dataclass

from mkt import checks
from mkt.colors import BinImage, ColorBins
from mkt.histograms import Target, histograms, log_likelihood
from mkt.neighbours import MEASURES, hsv_counts
from mkt.particles import Particles, normalised
from mkt.trackers.particle_filter import ParticleFilter
from mkt.types import Array, NDArray


@dataclass(frozen=True)
class CrossBin(ParticleFilter):
    """The bootstrap filter with the likelihood exp(-lam sum_j d_j^2), d of a measure.

    Parameters
    ----------
    measure : str
        One of `mkt.neighbours.MEASURES`; at "bhattacharyya" it is its parent, but for
        the bins, which must be `ColorBins` of the space "hsv".

    Raises
    ------
    ValueError
        Naming the field.
    """

    measure: str = "smoothed"

    def __post_init__(self):
        super().__post_init__()
        checks.one_of(self, measure=MEASURES)
        if not isinstance(self.bins, ColorBins):
            raise ValueError(
                f"bins is {self.bins}; neighbours are known for hsv, take ColorBins()"
            )
        hsv_counts(self.bins)

    def weigh(self, target: Target, image: BinImage, particles: Particles) -> Array:
        """The weights of particles, (N,) of sum 1."""
        q = histograms(image, target.kernels, particles.regions)
        d2 = self._compare(q, target.q)
        return normalised(log_likelihood(1 - d2, self.lam, self.combine))

    def _compare(self, q: NDArray, reference: NDArray) -> Array:
        assert isinstance(self.bins, ColorBins)  # or it would have been refused
        return MEASURES[self.measure](q, reference, self.bins)
