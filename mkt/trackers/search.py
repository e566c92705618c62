"""Where the optimiser ends in a frame, and which end `mkt.trackers.guided` takes.

An end costs O(x) and what its prior asks for it.  `Search` has all that the starts of a
frame share.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mkt.colors import BinImage
from mkt.histograms import Target
from mkt.regions import THETA
from mkt.trackers.newton import Prior, distance_at, minimise
from mkt.types import Region


class Optimum(NamedTuple):
    """Where the optimiser ended.

    Attributes
    ----------
    region : (5,) array [px, rad]
    distance : float
        d_m of the region under the target's kernels.
    steps : int
        How many were taken.
    free : bool
        Whether the orientation was free, and not the first one.
    """

    region: Region
    distance: float
    steps: int
    free: bool


@dataclass(frozen=True)
class Search:
    """What the starts of a frame share.

    Parameters
    ----------
    target : Target
        The reference under the kernels of the optimiser.
    image : BinImage
    theta : float [rad]
        The first orientation.
    steps : int
        From a start.
    found, sure, turn : float
        As in `mkt.trackers.guided.Guided`.
    """

    target: Target
    image: BinImage
    theta: float
    steps: int
    found: float
    sure: float
    turn: float

    @property
    def full(self) -> int:
        """O(x) of (6) is this times d_m^2: twice the number of kernels that count."""
        return 2 * self.target.counted

    def over(self, prior: Prior, starts: Iterable[Region], free: bool) -> Optimum:
        """The first optimum that is surely the target, over the starts, or the best.

        Parameters
        ----------
        prior : Prior
        starts : iterable of (5,) arrays [px, rad]
        free : bool
            Whether the orientation is, or is held at the first one.
        """
        total, least = 0, np.inf
        best = Optimum(prior.region, 1.0, 0, free)
        for start in starts:
            end = self.closest(prior, start, free)
            total += end.steps
            cost = end.distance**2 + prior.cost(end.region) / self.full
            if cost < least:
                best, least = end, cost
            if best.distance < self.found:
                break
        return best._replace(steps=total)

    def anywhere(
        self, prior: Prior, known: Optimum, start: Region
    ) -> tuple[Prior, Optimum]:
        """The optimum from a start wherever it is, if it is the target beyond doubt.

        Else the `known` one; each behind the prior that it was found under.  A start
        anywhere is a hypothesis of its own, with its own size and orientation: those
        of the estimate may be of something else.
        """
        anywhere = Prior(start, prior.weights * (0, 0, 1, 1))
        end = self.closest(anywhere, start, True)
        end = end._replace(steps=known.steps + end.steps)
        if end.distance < self.sure:
            return anywhere, end
        return prior, known._replace(steps=end.steps)

    def turned(self, prior: Prior, known: Optimum) -> Optimum:
        """The optimum under the model that explains the frame.

        The other model than that of the `known` optimum starts from there.  A turn must
        leave less than the share `turn` of O(x), as an F-test asks without a level.
        """
        other = self.closest(prior, known.region, not known.free)
        free, first = (known, other) if known.free else (other, known)
        turned = free.distance**2 < self.turn * first.distance**2
        best = free if turned else first
        return best._replace(steps=known.steps + other.steps)

    def closest(self, prior: Prior, start: Region, free: bool) -> Optimum:
        """Where the optimiser ends, with a free orientation or with the first one."""
        if not free:
            start, middle = np.array([start, prior.region])
            start[THETA] = middle[THETA] = self.theta
            prior = Prior(middle, prior.weights + (0, 0, np.inf, 0))
        region, steps = minimise(
            self.target, self.image, start, self.steps, robust=True, prior=prior
        )
        distance = distance_at(self.target, self.image, region)
        return Optimum(region, distance, steps, free)
