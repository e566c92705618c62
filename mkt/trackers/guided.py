"""Ours: particles that look coarsely and widely, an optimiser that looks closely, each helping the other.

What it adds to the combination of [T09], each for a failure seen there:

* **cascade**: many particles on a coarse grid, because a hypothesis that is far off needs no fine look (fast motion);
* **several starts**: the best particles, and the last estimate moved by its velocity; the closest after optimisation wins (blur);
* **coarse to fine**: the optimiser passes from wide to narrow kernels, so that a start may be further away;
* **feedback**: part of the particles begins the next frame at the corrected estimate (precision);
* **floor**: a small constant added to every likelihood keeps hypotheses alive while the target is hidden (occlusion);
* **anchored model**: the reference follows what is surely seen, tied to the first one so that it cannot drift away (illumination).

Explained in notebook 06.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from mkt.histograms import ColorBins, Target, coefficient, histograms, learn, log_likelihood
from mkt.kernels import Kernels
from mkt.particles import Motion, Particles, mean_region, normalised, systematic
from mkt.tracking import report
from mkt.trackers.ssd import minimise


class GuidedState(NamedTuple):
    """Particles; coarse and fine references, the first ones and those in use; the last estimate and its velocity; frames since it was seen."""

    particles: Particles
    first: tuple[Target, ...]
    targets: tuple[Target, ...]
    region: np.ndarray
    velocity: np.ndarray
    hidden: int
    size: float


@dataclass(frozen=True)
class Guided:
    """The tracker of the module's text.  Distances are d_m at the grid of `fine`; rates are a frame.

    n, coarse: the particles and the kernels they are weighed with; spans: of the optimiser's passes; starts: particles it starts from.
    seen: the distance below which the target counts as seen; sure: below which the reference is updated; rate: of the update;
    anchor: share of the first reference in every update; feedback: share of particles set back to the estimate; floor: added to the likelihood.
    """

    n: int = 300
    coarse: Kernels = Kernels("tiles", "uniform", samples=300)
    fine: Kernels = Kernels("3x3")
    spans: tuple[float, ...] = (1.4, 1.0)
    starts: int = 2
    steps: int = 5
    lam: float = 20.0
    seen: float = 0.6
    sure: float = 0.4
    rate: float = 0.1
    anchor: float = 0.2
    feedback: float = 0.5
    floor: float = 1e-8
    robust: bool = True
    part: float = 0.8
    glimpse: float = 0.4
    motion: Motion = Motion(position=0.1, velocity=0.1)
    bins: ColorBins = ColorBins()

    def init(self, frame, region, rng):
        """Learn the references.  Returns `GuidedState`."""
        image, region = self.bins(frame), np.asarray(region, float)
        kernels = (self.coarse, *(replace(self.fine, span=span) for span in self.spans))
        targets = tuple(learn(image, region, self.bins, k) for k in kernels)
        particles = self.motion.scatter(region, self.n, rng)
        return GuidedState(particles, targets, targets, region, np.zeros(2), 0, np.sqrt(region[3] * region[4]))

    def step(self, state, frame, rng):
        """Look widely, then closely; then decide whether the target was seen at all."""
        image = self.bins(frame)
        particles = self.motion.predict(state.particles, rng)
        rho = state.targets[0].coefficients(image, particles.regions)
        weights = normalised(np.logaddexp(log_likelihood(rho, self.lam), np.log(self.floor)))
        region, d, steps = self._closest(state, image, particles, weights)
        seen = d <= self.seen
        chosen = particles.take(systematic(weights, rng))
        if not seen and rho.mean(-1).max() > self.glimpse:
            region = mean_region(particles.regions, weights)
            state = state._replace(particles=chosen, velocity=0.5 * state.velocity + 0.5 * (region[:2] - state.region[:2]), region=region)
        else:
            state = self._found(state, region, chosen, image, d) if seen else self._missed(state, chosen)
        cost = (self.n * len(self.coarse.fitted(region).points) + steps * len(state.targets[-1].kernels.points)) / 4800
        return state, report(state.region, d, self.seen, steps=steps, evaluations=cost, particles=particles.regions, weights=weights)

    def _closest(self, state, image, particles, weights):
        """The optimum of the smallest distance over all starts.  Returns region, distance, steps."""
        guess = state.region.copy()
        guess[:2] += state.velocity
        best = particles.regions[np.argsort(weights)[:-self.starts - 1:-1]]
        results, total = [], 0
        for region in (guess, *best):
            for target in state.targets[1:]:
                region, k = minimise(target, image, region, self.steps, robust=self.robust)
                total += k
            results.append(region)
        distances = state.targets[-1].distances(image, np.array(results))
        k = np.argmin(distances)
        return results[k], distances[k], total

    def _found(self, state, region, particles, image, d):
        """The next state after the target was seen at a region."""
        velocity = 0.5 * state.velocity + 0.5 * (region[:2] - state.region[:2]) if not state.hidden else np.zeros(2)
        n = int(self.feedback * self.n)
        particles.regions[:n], particles.velocities[:n] = region, velocity
        targets = tuple(self._updated(t, f, image, region) for t, f in zip(state.targets, state.first)) if d <= self.sure else state.targets
        return state._replace(particles=particles, targets=targets, region=region, velocity=velocity, hidden=0)

    def _missed(self, state, particles):
        """The next state when nothing looked like the target: it goes on as it went, ever slower."""
        region = state.region.copy()
        region[:2] += state.velocity
        return state._replace(particles=particles, region=region, velocity=0.9 * state.velocity, hidden=state.hidden + 1)

    def _updated(self, target, first, image, region):
        """The reference moved towards what is seen at a region, and towards the first one."""
        q = histograms(image, self.bins.m, target.kernels, region)[0]
        fresh = (1 - self.anchor) * q + self.anchor * first.q
        rate = self.rate * (coefficient(q, target.q) > self.part)[:, None]
        return target._replace(q=(1 - rate) * target.q + rate * fresh)
