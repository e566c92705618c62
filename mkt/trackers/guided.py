"""Ours: particles that look coarsely and widely, an optimiser that looks closely, each helping the other.

What it adds to the combination of [T09], each for a failure seen there:

* **cascade**: many particles on a coarse grid, because a hypothesis that is far off needs no fine look (fast motion);
* **several starts**: the best particles, and the last estimate moved by its velocity; the closest after optimisation wins (blur);
* **coarse to fine**: the optimiser passes from wide to narrow kernels, so that a start may be further away;
* **trust**: in the optimiser, kernels that look unlike their reference count less, so that a covered part does not pull (occlusion);
* **feedback**: part of the particles begins the next frame at the corrected estimate (precision);
* **floor**: a small constant added to every likelihood keeps hypotheses alive while the target is hidden (occlusion);
* **light**: three gains, one a colour channel, follow the light.  The reference itself never changes, so it cannot drift (illumination).
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np

from mkt.histograms import ColorBins, Target, learn, log_likelihood
from mkt.kernels import Kernels
from mkt.particles import Motion, Particles, mean_region, normalised, systematic
from mkt.regions import warp
from mkt.tracking import report
from mkt.trackers.ssd import minimise


class GuidedState(NamedTuple):
    """Particles; the references, coarse first; the mean colours (J, 3) of the first look; the light's gains (3,) since; the last estimate (5,) and
    its velocity (2,) [px a frame]."""

    particles: Particles
    targets: tuple[Target, ...]
    colors: np.ndarray
    light: np.ndarray
    region: np.ndarray
    velocity: np.ndarray


@dataclass(frozen=True)
class Guided:
    """The tracker of the module's text.  Distances are d_m at the grid of `fine`; rates are a frame.

    n, coarse: the particles and the kernels they are weighed with; lam: of their likelihood; floor: added to it.
    fine, spans, steps: kernels of the optimiser, a pass for each span, and its steps a pass; starts: best particles it starts from.
    seen: the distance below which the target counts as seen; glimpse: the coefficient of the best particle above which it is at least followed.
    sure, rate: the distance below which the gains of the light follow, and how fast.  feedback: share of particles set back to the estimate.
    """

    n: int = 300
    coarse: Kernels = Kernels("tiles", "uniform", samples=300)
    lam: float = 20.0
    floor: float = 1e-8
    fine: Kernels = Kernels("3x3", samples=2400)
    spans: tuple[float, ...] = (1.4, 1.0)
    steps: int = 5
    starts: int = 2
    seen: float = 0.6
    glimpse: float = 0.4
    sure: float = 0.35
    rate: float = 0.3
    feedback: float = 0.5
    motion: Motion = Motion(position=0.1, velocity=0.1)
    bins: ColorBins = ColorBins()

    def init(self, frame, region, rng):
        """Learn the references.  Returns `GuidedState`."""
        image, region = self.bins(frame), np.asarray(region, float)
        kernels = (self.coarse, *(replace(self.fine, span=span) for span in self.spans))
        targets = tuple(learn(image, region, self.bins, k) for k in kernels)
        return GuidedState(self.motion.scatter(region, self.n, rng), targets, _mean_colors(frame, targets[-1], region), np.ones(3), region, np.zeros(2))

    def step(self, state, frame, rng):
        """Look widely, then closely; then decide whether the target was seen at all."""
        raw, frame = frame, _relit(frame, state.light)
        image = self.bins(frame)
        particles = self.motion.predict(state.particles, rng)
        rho = state.targets[0].coefficients(image, particles.regions)
        weights = normalised(np.logaddexp(log_likelihood(rho, self.lam), np.log(self.floor)))
        region, d, steps = self._closest(state, image, particles.regions[np.argsort(weights)[:-self.starts - 1:-1]])
        drawn = particles.take(systematic(weights, rng))
        if d <= self.seen:
            state = self._found(state, region, drawn)
            if d <= self.sure:
                state = self._lit(state, raw)
        else:
            region = mean_region(particles.regions, weights) if rho.mean(-1).max() > self.glimpse else _drifted(state, 0.9)
            state = _moved(state, region, drawn)
        cost = (self.n * len(state.targets[0].kernels.points) + steps * len(state.targets[-1].kernels.points)) / 4800
        return state, report(state.region, d, self.seen, steps=steps, evaluations=cost, particles=particles.regions, weights=weights)

    def _closest(self, state, image, best):
        """The optimum of the smallest distance, over starts at the best particles and where the velocity leads.  Returns region, distance, steps."""
        results, total = [], 0
        for region in (_drifted(state), *best):
            for target in state.targets[1:]:
                region, _, k = minimise(target, image, region, self.steps, robust=True)
                total += k
            results.append(region)
        distances = state.targets[-1].distances(image, np.array(results))
        k = np.argmin(distances)
        return results[k], distances[k], total

    def _found(self, state, region, particles):
        """The next state after the target was seen at a region, with part of the particles set back to it."""
        state = _moved(state, region, particles)
        n = int(self.feedback * self.n)
        particles.regions[:n], particles.velocities[:n] = region, state.velocity
        return state

    def _lit(self, state, frame):
        """The gains, moved towards what turns the colours seen now into those learnt, if that brings the histograms closer too."""
        target = state.targets[-1]
        ratio = np.median(_mean_colors(frame, target, state.region) / state.colors, axis=0) / state.light
        candidates = state.light, np.clip(state.light * ratio**self.rate, 0.25, 4), state.light ** 0.9
        distances = [target.distances(self.bins(_relit(frame, light)), state.region) for light in candidates]
        return state._replace(light=candidates[int(np.argmin(distances))])


def _moved(state, region, particles):
    velocity = 0.5 * state.velocity + 0.5 * (region[:2] - state.region[:2])
    return state._replace(particles=particles, region=region, velocity=velocity)


def _drifted(state, share=1.0):
    """The last estimate, moved by a share of its velocity."""
    return state.region + np.concatenate([share * state.velocity, np.zeros(3)])


def _mean_colors(frame, target, region):
    """Mean colour under each kernel at a region (5,), (J, 3), at least 1."""
    x, y = warp(region, target.kernels.points).astype(np.float32).T
    pixels = cv2.remap(frame, x, y, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
    return np.maximum(target.kernels.weights @ pixels.reshape(-1, 3), 1.0)


def _relit(frame, light):
    """The frame as it would be under the first light."""
    table = np.clip(np.arange(256)[:, None] / light, 0, 255).astype(np.uint8)
    return cv2.LUT(frame, table[:, None])
