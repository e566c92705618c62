"""A particle filter that looks where its target is, not in a whole box.

[N03] wished for the target's shape: here it is learnt in the first frame
(`mkt.silhouettes`) and moves with the region.

Explained in notebook 17.
"""

from dataclasses import dataclass

from mkt import checks
from mkt.checks import checked_frame
from mkt.colors import binned
from mkt.histograms import learn
from mkt.silhouettes import SHAPES, masked
from mkt.trackers.particle_filter import FilterState, ParticleFilter
from mkt.types import Frame, Region, Rng


@dataclass(frozen=True)
class Shaped(ParticleFilter):
    """The bootstrap filter with kernels times a silhouette.

    Parameters
    ----------
    shape : str
        How it is found, one of `mkt.silhouettes.SHAPES`.

    Raises
    ------
    ValueError
        Naming the field.
    """

    shape: str = "grab-cut"

    def __post_init__(self):
        super().__post_init__()
        checks.one_of(self, shape=SHAPES)

    def init(self, frame: Frame, region: Region, rng: Rng) -> FilterState:
        """Learn the shape, then the reference, and scatter particles."""
        frame = checked_frame(frame)
        kernels = masked(self.kernels, SHAPES[self.shape](frame, region))
        target = learn(binned(self.bins, frame), region, kernels)
        return FilterState(target, self.motion.scatter(region, self.n, rng))
