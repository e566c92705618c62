"""The particle filter with hybrid resampling, PFHR: Section 3 of [C14], made sound, with what is printed beside it.

Half of the particles walk at random, the other half go on as the target went (11), (17).  When nothing looks like the target any more, all are
spread uniformly round the last estimate, wider every frame (18).  The reference is learnt anew little by little (10).

Two parts of the printed algorithm cannot be meant as they stand, so they are parameters here.  Its acceptance test compares a likelihood of this
frame with a normalised weight of the last; after a draw that accepts whatever has d < sqrt(ln N / lam).  And its sign of an occlusion, a low N_eff,
is a sign of the contrary: where all looks equally bad, all weights are equal and N_eff is high.  Here the target is taken for hidden when the highest
likelihood falls far below what it has been lately.  A fixed level also takes an object that slowly shows another side for a hidden one, and waits for it
where it was last seen.  The price is that the wait ends: what is usual follows while nothing is seen, too.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mkt.histograms import ColorBins, Target, coefficient, histograms, learn, log_likelihood
from mkt.kernels import Kernels
from mkt.particles import Motion, Particles, effective_sample_size, mean_region, systematic
from mkt.regions import HX, HY, checked, from_box, to_box
from mkt.tracking import check_counts, report

ACCEPT = ("paper", "always", "fresh", "metropolis")
OCCLUSION = ("likelihood", "n_eff", "never")
NOTHING_LEARNT = np.array([1.0, 0.0, 0.0, 0.0])  # the shares of (10) while the reference stays as it is


class HybridState(NamedTuple):
    """The reference as it is now and as it was at first (J, m); regions (N, 5) and weights (N,); the last estimate (5,), its mean velocity (2,)
    [px a frame], for how many frames the target has been hidden, and how high the highest likelihood of a frame usually is."""

    target: Target
    first: np.ndarray
    regions: np.ndarray
    weights: np.ndarray
    estimate: np.ndarray
    velocity: np.ndarray
    hidden: int
    usual: float


@dataclass(frozen=True)
class HybridResampling:
    """PFHR.

    n, lam: number of particles, and the likelihood exp(-lam d^2) (9).  inertial: share of the particles that go on with the mean velocity, (17).
    motion: the noise r_k (its velocity and angle are not used).  smoothing: share of the last displacement in the mean velocity (12).
    accept: Algorithm 2's test of each new particle.  "paper": keep it if its likelihood exceeds the old one's normalised weight; "fresh": if it
            exceeds the likelihood of the old one's place in this frame; "metropolis": with the ratio of these two for a probability; "always":
            no test, and weights multiply as in (4), which follows the synthetic twins best.
    occlusion: "likelihood": hidden when no particle's likelihood reaches the share `level` of the usual highest one; "n_eff": when N_eff < n_lim n, as
            printed; "never".
    following: share of this frame in the usual highest likelihood, which is 1 at first.
    spread, growth: half width of the uniform (18) in the first hidden frame, and what every further one adds, in sqrt(hx hy).
    n_lim: N_lim over n: draw anew when N_eff is below.  damping: share of the mean velocity that outlives a hidden frame.
    eta, gamma: shares in (10): alpha + beta = eta, split by the likelihoods of the estimate and of the heaviest particle; gamma of the first look.
    w_min: mean likelihood of the particles near the estimate above which the reference is updated.

    Raises ValueError naming the field.  Algorithms 1 and 2 of [C14].
    """

    n: int = 200  # printed, Section 4: up to 200
    lam: float = 20.0  # printed, under (9)
    inertial: float = 0.5  # printed, Section 4.2: half of the particles
    motion: Motion = Motion(position=0.35, velocity=0.0, angle=0.0, scale=0.015, damping=0.0)  # ours
    smoothing: float = 0.5
    accept: str = "always"
    occlusion: str = "likelihood"
    level: float = 0.1
    following: float = 0.1
    spread: float = 0.5
    growth: float = 0.1
    n_lim: float = 0.5
    damping: float = 0.9
    eta: float = 0.05
    gamma: float = 0.1  # printed, under (10)
    w_min: float = 0.3
    bins: ColorBins = ColorBins()  # ours: the 10 x 10 for H and S of Section 2.2, and 10 for what has no hue
    kernels: Kernels = Kernels("ellipse", elliptic=True, samples=400)  # ours: the paper counts every pixel of the box alike

    def __post_init__(self):
        check_counts(self, "n")
        for field, value, known in (("accept", self.accept, ACCEPT), ("occlusion", self.occlusion, OCCLUSION)):
            if value not in known:
                raise ValueError(f"{field} is {value!r}; it must be one of {', '.join(known)}")
        shares = {field: getattr(self, field) for field in ("inertial", "following", "eta", "gamma")} | {"eta + gamma": self.eta + self.gamma}
        for field, value in shares.items():
            if not 0 <= value <= 1:
                raise ValueError(f"{field} is {value:g}; a share lies between 0 and 1")

    def init(self, frame, region, rng):
        """Learn the reference in the upright box of the region, and scatter particles round it.  Returns `HybridState`."""
        region = from_box(to_box(checked(region)))
        target = learn(self.bins(frame), region, self.bins, self.kernels)
        regions, weights = self.motion.scatter(region, self.n, rng).regions, np.full(self.n, 1 / self.n)
        return HybridState(target, target.q, regions, weights, region, velocity=np.zeros(2), hidden=0, usual=1.0)

    def step(self, state, frame, rng):
        """Predict, weigh, accept or keep; then wait for the target, or estimate, draw and learn."""
        image = self.bins(frame)
        predicted = self.predict(state, frame.shape, rng)
        likelihoods = self.likelihoods(state.target, image, predicted)
        # The wide search does not descend from the old particles, so there is nothing to keep in it.
        regions, weights = (predicted, likelihoods) if state.hidden else self.accepted(state, image, predicted, likelihoods, rng)
        weights = weights / weights.sum()
        n_eff, highest = effective_sample_size(weights), likelihoods.max()
        hidden = {"likelihood": highest < self.level * state.usual, "n_eff": n_eff < self.n_lim * self.n, "never": False}[self.occlusion]
        state = state._replace(usual=state.usual + self.following * (highest - state.usual))
        if hidden:
            state, seen = self._waited(state, image, predicted)
        else:
            state, seen = self._found(state, image, regions, weights, likelihoods, rng)
        looked = 2 * self.n if self.accept in ("fresh", "metropolis") else self.n
        return state, seen | {"lost": bool(hidden), "n_eff": n_eff, "evaluations": looked + 2, "particles": regions, "weights": weights}

    def predict(self, state, shape, rng):
        """Where the particles may be now, (N, 5): a walk and inertia, mixed (17); spread uniformly (18) while the target is hidden."""
        start = np.tile(state.estimate, (self.n, 1)) if state.hidden else state.regions
        regions = self.motion.predict(Particles(start, np.zeros((self.n, 2))), rng).regions
        if state.hidden:
            width = (self.spread + self.growth * (state.hidden - 1)) * np.sqrt(state.estimate[HX] * state.estimate[HY])
            regions[:, :2] = state.estimate[:2] + rng.uniform(-width, width, (self.n, 2))
        onward = np.diff(np.floor(np.arange(self.n + 1) * self.inertial)) > 0  # spread over all: copies of one ancestor are neighbours
        regions[onward, :2] += self.drift(state)
        regions[:, :2] = regions[:, :2].clip(0, [shape[1] - 1, shape[0] - 1])
        return regions

    def drift(self, state):
        """How far inertia has carried the target since it was last seen, (2,) [px]: v tau, less what is damped."""
        return state.velocity * np.sum(self.damping ** np.arange(state.hidden + 1))

    def likelihoods(self, target, image, regions):
        """exp(-lam d^2) of regions (N, 5), (9).  Returns (N,)."""
        return np.exp(log_likelihood(target.coefficients(image, regions), self.lam))

    def accepted(self, state, image, predicted, likelihoods, rng):
        """The acceptance test of Algorithm 2.  Returns the regions (N, 5) that live on and their weights (N,), not normalised."""
        if self.accept == "always":
            return predicted, state.weights * likelihoods
        old = state.weights if self.accept == "paper" else self.likelihoods(state.target, image, state.regions)
        bar = old * rng.random(self.n) if self.accept == "metropolis" else old
        better = likelihoods > bar
        return np.where(better[:, None], predicted, state.regions), np.where(better, likelihoods, old)

    def _waited(self, state, image, predicted):
        """A frame without the target: nothing is learnt, inertia carries the estimate on."""
        region = state.estimate.copy()
        region[:2] += self.drift(state)
        equal = np.full(self.n, 1 / self.n)
        seen = report(region, state.target.distances(image, region), 0, shares=NOTHING_LEARNT)
        return state._replace(regions=predicted, weights=equal, hidden=state.hidden + 1), seen

    def _found(self, state, image, regions, weights, likelihoods, rng):
        """A frame with the target: estimate, mean velocity, a draw if it is due, and the reference."""
        region = mean_region(regions, weights)
        velocity = state.velocity + self.smoothing * ((region - state.estimate)[:2] / (state.hidden + 1) - state.velocity)
        target, distance, shares = self._learnt(state, image, region, regions[np.argmax(weights)], weights @ likelihoods)
        if effective_sample_size(weights) < self.n_lim * self.n:
            regions, weights = regions[systematic(weights, rng)], np.full(self.n, 1 / self.n)
        state = state._replace(target=target, regions=regions, weights=weights, estimate=region, velocity=velocity, hidden=0)
        return state, report(region, distance, 1, shares=shares)

    def _learnt(self, state, image, region, heaviest, level):
        """The reference after (10), the distance of the estimate, and the four shares."""
        target = state.target
        q = histograms(image, self.bins.m, target.kernels, np.stack([region, heaviest]))
        rho = coefficient(q, target.q)[:, 0]
        shares = self.shares(*np.exp(-self.lam * (1 - rho))) if level > self.w_min else NOTHING_LEARNT
        mixed = np.tensordot(shares, np.stack([target.q, *q, state.first]), 1)
        return target._replace(q=mixed), np.sqrt(max(1 - rho[0], 0)), shares

    def shares(self, estimate, heaviest):
        """The coefficients of (10) from the likelihoods of the estimate and of the heaviest particle: 1 - alpha - beta - gamma, alpha, beta, gamma.

        Each lies in [0, 1] and they sum to 1, which the printed "normalised weight" and "proportional to" do not promise.
        """
        alpha = self.eta * estimate / (estimate + heaviest)
        return np.array([1 - self.eta - self.gamma, alpha, self.eta - alpha, self.gamma])
