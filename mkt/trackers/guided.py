"""Ours: particles that look coarsely and widely, an optimiser that looks closely, each helping the other.

What it adds to the combination of [T09], each for a failure seen there:

* **cascade**: many particles on a coarse grid, because a hypothesis that is far off needs no fine look (fast motion);
* **several starts**: the last estimate moved by its velocity, then the best particles, until the optimiser finds the target (blur);
* **coarse to fine**: the optimiser passes from wide to narrow kernels, so that a start may be further away;
* **trust**: in the optimiser, kernels that look unlike their reference count less, so that a covered part does not pull (occlusion);
* **wandering**: in every frame in which the target is seen, a few particles chosen by lot begin anew at the estimate; all others go on, each
  as far as chance has taken it since its own beginning.  So the crowd is dense near the target and thin far away, wherever the target has
  been, and while it is hidden nobody comes back and the crowd spreads (occlusion);
* **light**: three gains follow the light (`mkt.trackers.light`), so that the reference itself never changes and cannot drift (illumination).

There is no resampling: drawing by weight was tried, and the sharper the weights the more often a hidden target stayed lost, because the crowd
had gathered on whatever looked a little like it.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mkt.histograms import ColorBins, Target, learn
from mkt.kernels import Kernels
from mkt.particles import Motion, Particles
from mkt.regions import checked
from mkt.tracking import check_counts, report
from mkt.trackers.light import Light, first_light, followed, relit
from mkt.trackers.ssd import minimise


class GuidedState(NamedTuple):
    """Particles; the references, coarse to fine; the light; the last estimate (5,) and its velocity (2,) [px a frame]."""

    particles: Particles
    targets: tuple[Target, ...]
    light: Light
    region: np.ndarray
    velocity: np.ndarray


@dataclass(frozen=True)
class Guided:
    """The tracker of the module's text.  Distances are d_m under the last of the `fine` kernels.

    n, coarse: the particles and the kernels they are compared with; renewed: chance of a particle to begin anew at the estimate.
    fine, steps: the kernels of the optimiser, a pass each, and its steps a pass; starts: best particles that it may start from.
    found, seen: the distance below which no further start is tried, and that below which the target counts as seen.

    Raises ValueError naming the field.
    """

    n: int = 200
    coarse: Kernels = Kernels("tiles", "uniform", samples=300)
    renewed: float = 0.05
    fine: tuple[Kernels, ...] = (Kernels("3x3", span=1.4, samples=600), Kernels("3x3", samples=2400))
    steps: int = 5
    starts: int = 2
    found: float = 0.3
    seen: float = 0.6
    motion: Motion = Motion(position=0.1)
    bins: ColorBins = ColorBins()

    def __post_init__(self):
        check_counts(self, "n", "steps")
        if not self.fine:
            raise ValueError("fine is empty; give the optimiser at least one Kernels")

    def init(self, frame, region, rng):
        """Learn the references.  Returns `GuidedState`."""
        image, region = self.bins(frame), checked(region)
        targets = tuple(learn(image, region, self.bins, kernels) for kernels in (self.coarse, *self.fine))
        return GuidedState(self.motion.scatter(region, self.n, rng), targets, first_light(targets[-1], frame, region), region, np.zeros(2))

    def step(self, state, frame, rng):
        """Look widely, then closely, then decide whether the target was seen at all."""
        image = self.bins(relit(frame, state.light.gains))
        particles = self.motion.predict(state.particles, rng)
        likeness = np.maximum(state.targets[0].coefficients(image, particles.regions).mean(-1), 1e-9)
        best = particles.regions[np.argsort(likeness)[:-self.starts - 1:-1]]
        region, d, steps = self._optimum(state.targets[1:], image, [_drifted(state), *best])
        if d > self.seen:
            region = _drifted(state, 0.9)
        velocity = 0.5 * state.velocity + 0.5 * (region[:2] - state.region[:2])
        cost = (self.n * len(state.targets[0].kernels.points) + steps * len(state.targets[-1].kernels.points)) / 4800
        info = report(region, d, self.seen, steps=steps, evaluations=cost, particles=particles.regions.copy(), weights=likeness / likeness.sum())
        if d <= self.seen:
            renewed = rng.random(self.n) < self.renewed
            particles.regions[renewed], particles.velocities[renewed] = region, velocity
        light = followed(state.light, frame, region) if d <= self.found else state.light
        return GuidedState(particles, state.targets, light, region, velocity), info

    def _optimum(self, targets, image, starts):
        """The first optimum, over the starts, that is surely the target, or else the closest.  Returns region, distance, steps."""
        closest, distance, total = None, np.inf, 0
        for region in starts:
            for target in targets:
                region, d, steps = minimise(target, image, region, self.steps, robust=True)
                total += steps
            if d < distance:
                closest, distance = region, d
            if distance < self.found:
                break
        return closest, distance, total


def _drifted(state, share=1.0):
    """The last estimate, moved by a share of its velocity."""
    return state.region + np.concatenate([share * state.velocity, np.zeros(3)])
