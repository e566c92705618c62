"""Ours: particles that look widely and an optimiser that looks closely.

Each helps the other.

What it adds to the combination of [T09], each for a failure seen there:

* **cascade**: many particles on a coarse grid, because a hypothesis that is far off
  needs no fine look (fast motion);
* **several starts**: the last estimate moved by its velocity, then the best particles,
  until the optimiser finds the target (blur);
* **trust**: in the optimiser, kernels that look unlike their reference count less, so
  that a covered part does not pull (occlusion);
* **wandering**: in every frame in which the target is seen, a few particles chosen by
  lot begin anew at the estimate; all others go on, each as far as chance has taken it
  since its own beginning.  So the crowd is dense near the target and thin far away,
  wherever the target has been, and while it is hidden nobody comes back and the crowd
  spreads (occlusion);
* **light**: three gains follow the light (`mkt.trackers.gains`), so that the reference
  itself never changes and cannot drift (illumination).

Taken away one at a time over sixteen tuning scenes of each question
(`mkt.scenes.drawn`), several starts are worth .096 of overlap [.069, .124]; a coarse
grid costs a quarter of a fine one at the same overlap; and wandering is worth .05 on
real sequences (BoBoT A, C and F, three seeds), though nothing on drawn scenes.  A first
pass of the optimiser with wide kernels was worth nothing, and is gone.
There is no resampling: drawing by weight was tried, and the sharper the weights the
more often a hidden target stayed lost, because the crowd had gathered on whatever
looked a little like it.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mkt import checks
from mkt.checks import checked_region
from mkt.colors import BinImage, Bins, ColorBins
from mkt.histograms import Target, learn
from mkt.kernels import Kernels
from mkt.particles import Motion, Particles, covariance, effective_sample_size
from mkt.trackers.gains import Light, first_light, followed, relit
from mkt.trackers.ssd import distance_at, minimise
from mkt.tracking import Info, report
from mkt.types import Array, Frame, Region, Rng

FULL_GRID = 4800  # samples of a region whose cost counts as one evaluation


class GuidedState(NamedTuple):
    """What is carried from frame to frame.

    Attributes
    ----------
    particles : Particles
    coarse, fine : Target
        The references, for the particles and for the optimiser.
    light : Light
    region : (5,) array [px, rad]
        The last estimate.
    velocity : (2,) array [px a frame]
    """

    particles: Particles
    coarse: Target
    fine: Target
    light: Light
    region: Region
    velocity: Array


@dataclass(frozen=True)
class Guided:
    """The tracker of the module's text; distances are d_m under the fine kernels.

    Parameters
    ----------
    n : int
        Number of particles.
    coarse : Kernels
        Those that the particles are compared with.
    renewed : float
        Chance of a particle to begin anew at the estimate.
    fine : Kernels
        Of the optimiser.
    steps : int
        Of the optimiser from a start.
    starts : int
        Best particles that it may start from.
    found : float
        The distance below which no further start is tried.
    lost_above : float
        The distance beyond which the target is said to be lost.
    motion : Motion
    bins : Bins

    Raises
    ------
    ValueError
        Naming the field.
    """

    n: int = 200
    coarse: Kernels = Kernels("tiles", "uniform", samples=300)
    renewed: float = 0.05
    fine: Kernels = Kernels("3x3", samples=2400)
    steps: int = 5
    starts: int = 2
    found: float = 0.3
    lost_above: float = 0.6
    motion: Motion = Motion(position=0.1)
    bins: Bins = ColorBins()

    def __post_init__(self):
        checks.counts(self, "n", "steps")

    def init(self, frame: Frame, region: Region, rng: Rng) -> GuidedState:
        """Learn the references."""
        image, region = self.bins(frame), checked_region(region)
        coarse, fine = (learn(image, region, k) for k in (self.coarse, self.fine))
        particles = self.motion.scatter(region, self.n, rng)
        light = first_light(fine, self.bins, frame, region)
        return GuidedState(particles, coarse, fine, light, region, np.zeros(2))

    def step(
        self, state: GuidedState, frame: Frame, rng: Rng
    ) -> tuple[GuidedState, Info]:
        """Look widely, then closely, then decide whether the target was seen at all."""
        image = self.bins(relit(frame, state.light.gains))
        particles = self.motion.predict(state.particles, rng)
        rho = state.coarse.coefficients(image, particles.regions)
        likeness = np.maximum(rho.mean(-1), 1e-9)
        best = particles.regions[np.argsort(likeness)[::-1][: self.starts]]
        region, d, steps = self._optimum(state, image, [_drifted(state), *best])
        lost, light = d > self.lost_above, state.light
        if d <= self.found:
            light = followed(light, frame, region)
        if lost:
            region = _drifted(state, 0.9)
            d = distance_at(state.fine, image, region)
        velocity = 0.5 * state.velocity + 0.5 * (region[:2] - state.region[:2])
        weights = likeness / likeness.sum()
        info = report(
            region,
            d,
            lost,
            self._cost(state, steps),
            covariance=covariance(particles.regions, weights, region),
            n_eff=effective_sample_size(weights),
            particles=particles.regions,
            weights=weights,
            steps=steps,
        )
        if not lost:
            particles = self._renewed(particles, region, velocity, rng)
        return state._replace(
            particles=particles, light=light, region=region, velocity=velocity
        ), info

    def _cost(self, state: GuidedState, steps: int) -> float:
        """The work of a frame in regions looked at with the full grid of samples."""
        coarse, fine = state.coarse.kernels.points, state.fine.kernels.points
        samples = self.n * len(coarse) + steps * len(fine)
        return samples / FULL_GRID

    def _renewed(
        self, particles: Particles, region: Region, velocity: Array, rng: Rng
    ) -> Particles:
        """The particles, of which a few chosen by lot begin anew at the estimate."""
        chosen = rng.random(self.n) < self.renewed
        regions = np.where(chosen[:, None], region, particles.regions)
        velocities = np.where(chosen[:, None], velocity, particles.velocities)
        return Particles(regions, velocities)

    def _optimum(
        self, state: GuidedState, image: BinImage, starts: Iterable[Region]
    ) -> tuple[Region, float, int]:
        """The first optimum that is surely the target, over the starts, or the closest.

        Returns
        -------
        region : (5,) array [px, rad]
        distance : float
        steps : int
        """
        fine, total = state.fine, 0
        closest, least = state.region, np.inf
        for start in starts:
            region, steps = minimise(fine, image, start, self.steps, robust=True)
            total += steps
            d = distance_at(fine, image, region)
            if d < least:
                closest, least = region, d
            if least < self.found:
                break
        return closest, least, total


def _drifted(state: GuidedState, share: float = 1.0) -> Region:
    """The last estimate, moved by a share of its velocity."""
    return state.region + np.concatenate([share * state.velocity, np.zeros(3)])
