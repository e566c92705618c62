"""Multiple kernel tracking with SSD: the deterministic tracker of Section III of [T09].

Its steps are in `mkt.trackers.newton`.  Explained in notebook 04.
"""

from dataclasses import dataclass, replace
from math import sqrt
from typing import NamedTuple

import numpy as np

from mkt import checks
from mkt.checks import checked_region
from mkt.colors import BinImage, Bins, ColorBins, binned, of_bins
from mkt.histograms import Target, learn
from mkt.kernels import Kernels, of_kernels
from mkt.trackers.newton import distance_at, minimise
from mkt.tracking import Info, report
from mkt.types import Frame, Region, Rng


class SSDState(NamedTuple):
    """What is carried from frame to frame.

    Attributes
    ----------
    targets : tuple of Target
        The references, one for each span.
    region : (5,) array [px, rad]
        The last estimate.
    size : float [px]
        sqrt(hx hy) of the first one.
    """

    targets: tuple[Target, ...]
    region: Region
    size: float


@dataclass(frozen=True)
class SSD:
    """The deterministic tracker: in every frame, minimise from the last estimate.

    Parameters
    ----------
    kernels : Kernels
        Nine Epanechnikov kernels, (10) of [T09].
    spans : tuple of float
        Factors on their span, from coarse to fine, one pass each; the paper has one.
    iterations : int
        Steps in a pass, at most; the paper says "a few".
    derivative_of_c : bool
        See `mkt.trackers.newton.differentiate`.
    bins : Bins
        What the frames are binned with.
    lost_above : float
        The distance d_m beyond which the target is said to be lost.
    sizes : tuple of float
        Bounds on the size of the region, relative to the first frame.

    Raises
    ------
    ValueError
        Naming the field.
    """

    kernels: Kernels = Kernels("3x3")
    spans: tuple[float, ...] = (1.0,)
    iterations: int = 10  # ours: the paper prints no number
    derivative_of_c: bool = True
    bins: Bins = ColorBins()
    lost_above: float = 0.65
    sizes: tuple[float, float] = (0.3, 3.0)

    def __post_init__(self):
        of_bins(self.bins)
        checks.counts(self, "iterations")
        checks.numbers(self, "lost_above")
        checks.flags(self, "derivative_of_c")
        of_kernels(self.kernels, "kernels")
        self.kernels.check_slopes()
        given = checks.in_a_tuple(self.spans, None)
        if not given or min(self.spans) <= 0:
            raise ValueError(
                f"spans is {self.spans}; give a tuple of positive factors on the "
                "kernels' span, such as (1,)"
            )
        given = checks.in_a_tuple(self.sizes, 2)
        if not given or not 0 < self.sizes[0] <= self.sizes[1]:
            raise ValueError(
                f"sizes is {self.sizes}; give a tuple of a smaller and a larger "
                "positive factor"
            )

    def init(self, frame: Frame, region: Region, rng: Rng) -> SSDState:
        """Learn the reference at every span."""
        image = binned(self.bins, frame)
        region = checked_region(region)
        own = self.kernels.span
        kernels = [replace(self.kernels, span=span * own) for span in self.spans]
        targets = tuple(learn(image, region, each) for each in kernels)
        return SSDState(targets, region, np.sqrt(region[3] * region[4]))

    def step(self, state: SSDState, frame: Frame, rng: Rng) -> tuple[SSDState, Info]:
        """Minimise from the last estimate."""
        region, d, steps = self.refine(state, binned(self.bins, frame), state.region)
        info = report(region, d, d > self.lost_above, steps, steps=steps)
        return state._replace(region=region), info

    def refine(
        self, state: SSDState, image: BinImage, start: Region
    ) -> tuple[Region, float, int]:
        """Minimise from any start (5,), span after span.

        Returns
        -------
        region : (5,) array [px, rad]
        distance : float
            Its d_m.
        steps : int
            How many were taken.
        """
        region, steps = start, 0
        for target in state.targets:
            region, k = minimise(
                target, image, region, self.iterations, self.derivative_of_c
            )
            steps += k
        region = self._bounded(region, state.size)
        return region, distance_at(state.targets[-1], image, region), steps

    def _bounded(self, region: Region, first: float) -> Region:
        """A region whose size is within bounds of the first one [px]."""
        size = sqrt(region[3] * region[4])
        smallest, largest = self.sizes[0] * first, self.sizes[1] * first
        region[3:] *= min(max(size, smallest), largest) / size
        return region
