"""The particle filter with hybrid resampling, PFHR: Section 3 of [C14].

Here it is made sound; the printed version can be chosen too.

Half of the particles walk at random, the other half go on as the target went (11),
(17). When nothing looks like the target any more, all are spread uniformly round the
last estimate, wider in every frame (18).  The reference is learnt anew little by little
(10).

Two things cannot be meant as our copy reads, so they are parameters here.  The
acceptance test of Algorithm 2 compares a likelihood of this frame with a normalised
weight of the last one; after a draw this test accepts whatever has d < sqrt(ln N /
lam).  And the text takes a low N_eff for a sign of an occlusion, but where all places
look equally bad, all weights are equal and N_eff is high: what it says depends on the
ground.  As printed, such a frame draws, learns and estimates as Algorithm 2 does in
every frame, and the next one spreads the particles by (18).  Here the target is taken
for hidden when the highest likelihood is below a fixed level, and then the filter
waits: nothing is learnt, and inertia alone moves the estimate.  The price is that the
filter also waits when the object only shows another side; it waits where the object was
last seen.  A level that follows the likelihoods of the last frames was tried on the
tuning scenes (`mkt.scenes.drawn`), sixteen of each twin of [C14] and sixteen of the
turning car of [N03], and is worse there, because the wait ends before the target is
back: 84.0 against 84.8 % of true positives, 58 against 77 (on the scenes as they were
before their objects were painted).  On the present twins, accepting every proposal is
better than the other tests: the target is held in 97.1 % of the frames in which it can
be seen, with the others in 93.2 to 95.0.  The weights differ, too: a proposal
that passes one of the tests has its likelihood for its weight, as Algorithm 2 says, and
without a test weights multiply, as (4) does.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mkt import checks
from mkt.checks import checked_region
from mkt.colors import BinImage, Bins, ColorBins, binned, of_bins
from mkt.histograms import (
    Target,
    coefficient,
    distance,
    histograms,
    learn,
    log_likelihood,
)
from mkt.kernels import Kernels, of_kernels
from mkt.particles import (
    Motion,
    Particles,
    covariance,
    effective_sample_size,
    mean_region,
    resample_if_degenerate,
    systematic,
)
from mkt.regions import from_box, size, to_box
from mkt.tracking import Info, report
from mkt.types import Array, Frame, NDArray, Region, Regions, Rng

ACCEPT = ("paper", "always", "fresh", "metropolis")
OCCLUSION = ("likelihood", "n_eff", "never")
NOTHING_LEARNT = np.array([1.0, 0.0, 0.0, 0.0])  # shares of (10): it stays as it is


class HybridState(NamedTuple):
    """What is carried from frame to frame.

    Attributes
    ----------
    target : Target
        The reference as it is now.
    first : (J, m) array
        The histograms of the first look.
    regions, weights : (N, 5) and (N,) arrays
    estimate : (5,) array [px, rad]
        The last one.
    velocity : (2,) array [px/frame]
        Its mean.
    hidden : int
        For how many frames the target has been hidden.
    """

    target: Target
    first: NDArray
    regions: Regions
    weights: Array
    estimate: Region
    velocity: Array
    hidden: int


@dataclass(frozen=True)
class HybridResampling:
    """PFHR, Algorithms 1 and 2 of [C14].

    Parameters
    ----------
    n : int
        Number of particles.
    lam : float
        Of the likelihood exp(-lam d^2), (9).
    inertial : float
        Share of the particles that go on with the mean velocity, (17).
    motion : Motion
        The noise r_k; by default boxes stay upright, and only inertia has a velocity.
    smoothing : float
        Share of the last displacement in the mean velocity, (12).
    accept : str
        Algorithm 2's test of each new particle.  "paper": keep it if its likelihood
        exceeds the old one's normalised weight; "fresh": if it exceeds the likelihood
        of the old one's place in this frame; "metropolis": with the ratio of these two
        as the probability; "always": no test, and weights multiply as in (4).
    occlusion : str
        "likelihood": hidden when no particle's likelihood reaches `level`, and the
        filter waits; "n_eff", as printed: when N_eff < n_lim n, and Algorithm 2 draws,
        learns and estimates as ever, but spreads next; "never".
    level : float
        The likelihood that the best particle must reach where the object is seen.
    spread, growth : float
        Half width of the uniform (18) in the frame after the first hidden one, when it
        is known to be hidden, and what every further one adds, in sqrt(hx hy).
    n_lim : float
        N_lim over n: draw anew when N_eff is below N_lim.
    damping : float
        Share of the mean velocity that outlives a hidden frame.
    eta, gamma : float
        Shares in (10): alpha + beta = eta, split by the likelihoods of the estimate and
        of the heaviest particle; gamma of the first look.
    w_min : float
        Mean likelihood of the particles above which the reference is updated.
    bins : Bins
        What the frames are binned with.
    kernels : Kernels
        An ellipse in the upright box.

    Raises
    ------
    ValueError
        Naming the field.
    """

    n: int = 200  # printed, Section 4: up to 200
    lam: float = 20.0  # printed, under (9)
    inertial: float = 0.5  # printed, Section 4.2: half of the particles
    motion: Motion = Motion(
        position=0.35, velocity=0.0, angle=0.0, scale=0.015, damping=0.0
    )  # ours
    smoothing: float = 0.5
    accept: str = "always"
    occlusion: str = "likelihood"
    level: float = 0.1
    spread: float = 0.5
    growth: float = 0.1
    n_lim: float = 0.5
    damping: float = 0.9
    eta: float = 0.05
    gamma: float = 0.1  # printed, under (10)
    w_min: float = 0.3
    # Ours: the 10 x 10 for H and S of Section 2.2, and 10 for what has no hue.
    bins: Bins = ColorBins()
    # Ours: the paper counts every pixel of the box alike.
    kernels: Kernels = Kernels("ellipse", elliptic=True, samples=400)

    def __post_init__(self):
        of_bins(self.bins)
        of_kernels(self.kernels, "kernels")
        checks.of_kind(self.motion, Motion, "motion", "give a Motion, such as Motion()")
        checks.counts(self, "n")
        checks.one_of(self, accept=ACCEPT, occlusion=OCCLUSION)
        checks.shares(self, "inertial", "smoothing", "damping", "eta", "gamma")
        checks.positive(self, "lam")
        checks.not_negative(self, "spread", "growth")
        checks.numbers(self, "level", "n_lim", "w_min")
        if self.eta + self.gamma > 1:
            raise ValueError(
                f"eta + gamma is {self.eta + self.gamma:g}; "
                "a share lies between 0 and 1"
            )

    def init(self, frame: Frame, region: Region, rng: Rng) -> HybridState:
        """Learn the reference in the region's upright box, and scatter particles."""
        region = from_box(to_box(checked_region(region)))
        target = learn(binned(self.bins, frame), region, self.kernels)
        regions = self.motion.scatter(region, self.n, rng).regions
        still = np.zeros(2)
        weights = self._equal_weights()
        return HybridState(target, target.q, regions, weights, region, still, 0)

    def step(
        self, state: HybridState, frame: Frame, rng: Rng
    ) -> tuple[HybridState, Info]:
        """Predict, weigh, accept; then wait for the target, or estimate and learn."""
        image = binned(self.bins, frame)
        predicted = self.predict(state, frame.shape[:2], rng)
        likelihoods = self.likelihoods(state.target, image, predicted)
        regions, weights, likelihoods = self.accepted(
            state, image, predicted, likelihoods, rng
        )
        total = weights.sum()  # 0 where all are too small to be written down
        weights = weights / total if total > 0 else self._equal_weights()
        hidden = self.is_hidden(weights, likelihoods)
        waits = hidden and self.occlusion == "likelihood"
        looked = self._cost(state, waits)
        if waits:
            state = self._waited(state, predicted)
            region = self._gone_on(state)
            d = state.target.distances(image, region)
            shares = NOTHING_LEARNT
        else:
            before = state
            state, d, shares = self._found(
                state, image, regions, weights, likelihoods, rng
            )
            region = state.estimate
            if hidden:
                state = self._spread_next(state, before)
        info = report(
            region,
            d,
            hidden,
            looked,
            covariance=covariance(regions, weights, region),
            n_eff=effective_sample_size(weights),
            particles=regions,
            weights=weights,
            shares=shares,
        )
        return state, info

    def _cost(self, state: HybridState, waits: bool) -> float:
        """Regions looked at in a frame after this state.

        They are the particles, their old places where the test asks for these, the
        estimate, and the heaviest particle where something may be learnt.
        """
        anew = self.accept in ("fresh", "metropolis") and not state.hidden
        return float(self.n * (1 + anew) + (1 if waits else 2))

    def predict(self, state: HybridState, shape: tuple[int, int], rng: Rng) -> Regions:
        """Where the particles may be now, (N, 5) in an image of a shape (H, W).

        A walk and inertia, mixed, (17); spread uniformly, (18), while the target is
        hidden.
        """
        start = state.regions
        if state.hidden:
            start = np.tile(state.estimate, (self.n, 1))
        walk = self.motion.predict(Particles(start, np.zeros((self.n, 2))), rng)
        regions = walk.regions
        if state.hidden:
            frames = state.hidden - 1
            width = (self.spread + self.growth * frames) * size(state.estimate)
            uniform = rng.uniform(-width, width, (self.n, 2))
            regions[:, :2] = state.estimate[:2] + uniform
        # Spread over all, because copies of one ancestor are neighbours; to 9 places,
        # because .58 x 200 is a little less than 116.
        so_far = np.floor(np.round(np.arange(self.n + 1) * self.inertial, 9))
        onward = np.diff(so_far) > 0
        regions[onward, :2] += self.drift(state)
        regions[:, :2] = regions[:, :2].clip(0, [shape[1] - 1, shape[0] - 1])
        return regions

    def drift(self, state: HybridState) -> Array:
        """How far inertia has carried the target since it was last seen, (2,) [px]."""
        return state.velocity * np.sum(self.damping ** np.arange(state.hidden + 1))

    def likelihoods(self, target: Target, image: BinImage, regions: Regions) -> Array:
        """exp(-lam d^2) of regions (N, 5), (9): (N,)."""
        return np.exp(log_likelihood(target.coefficients(image, regions), self.lam))

    def accepted(
        self,
        state: HybridState,
        image: BinImage,
        predicted: Regions,
        likelihoods: Array,
        rng: Rng,
    ) -> tuple[Regions, Array, Array]:
        """The acceptance test of Algorithm 2.

        The wide search does not descend from the old particles, so there is nothing to
        keep in it.

        Parameters
        ----------
        state : HybridState
        image : BinImage
        predicted : (N, 5) array [px, rad]
            The new places of the particles.
        likelihoods : (N,) array
            Of the new places.
        rng : numpy.random.Generator

        Returns
        -------
        regions : (N, 5) array [px, rad]
            Those that live on.
        weights : (N,) array
            Not normalised.
        likelihoods : (N,) array
            Of those that live on; with "paper" of the new ones, since the printed test
            does not look at the old places.
        """
        if state.hidden:
            return predicted, likelihoods, likelihoods
        if self.accept == "always":
            return predicted, state.weights * likelihoods, likelihoods
        old = state.weights
        if self.accept != "paper":
            old = self.likelihoods(state.target, image, state.regions)
        bar = old * rng.random(self.n) if self.accept == "metropolis" else old
        better = likelihoods > bar
        regions = np.where(better[:, None], predicted, state.regions)
        weights = np.where(better, likelihoods, old)
        return regions, weights, likelihoods if self.accept == "paper" else weights

    def is_hidden(self, weights: Array, likelihoods: Array) -> bool:
        """Whether weights and likelihoods (n,) say hidden, see `occlusion`."""
        if self.occlusion == "likelihood":
            return bool(likelihoods.max() < self.level)
        if self.occlusion == "n_eff":
            return bool(effective_sample_size(weights) < self.n_lim * self.n)
        return False

    def _waited(self, state: HybridState, predicted: Regions) -> HybridState:
        """A frame without the target: nothing is learnt."""
        return state._replace(
            regions=predicted, weights=self._equal_weights(), hidden=state.hidden + 1
        )

    def _gone_on(self, state: HybridState) -> Region:
        """The last estimate, carried on by inertia, (5,), after a frame of waiting."""
        before = state._replace(hidden=state.hidden - 1)
        return state.estimate + np.concatenate([self.drift(before), np.zeros(3)])

    def _spread_next(self, state: HybridState, before: HybridState) -> HybridState:
        """As printed: Algorithm 2 has drawn and learnt, and (18) comes next.

        It spreads round the estimate from before the occlusion, with its velocity.
        """
        return state._replace(
            estimate=before.estimate,
            velocity=before.velocity,
            hidden=before.hidden + 1,
        )

    def _found(
        self,
        state: HybridState,
        image: BinImage,
        regions: Regions,
        weights: Array,
        likelihoods: Array,
        rng: Rng,
    ) -> tuple[HybridState, float, Array]:
        """A frame with the target: estimate, mean velocity, a draw, and the reference.

        Returns the next state, the distance of the estimate, and the shares of (10).
        """
        region = mean_region(regions, weights)
        shift = (region - state.estimate)[:2] / (state.hidden + 1)
        velocity = state.velocity + self.smoothing * (shift - state.velocity)
        heaviest = regions[np.argmax(weights)]
        level = float(weights @ likelihoods)
        target, d, shares = self._learnt(state, image, region, heaviest, level)
        ancestors, weights = resample_if_degenerate(
            weights, self.n_lim, systematic, rng
        )
        state = HybridState(
            target,
            state.first,
            regions[ancestors],
            weights,
            region,
            velocity,
            hidden=0,
        )
        return state, d, shares

    def _learnt(
        self,
        state: HybridState,
        image: BinImage,
        region: Region,
        heaviest: Region,
        level: float,
    ) -> tuple[Target, float, Array]:
        """The reference after (10), the distance of the estimate, and the shares."""
        target = state.target
        q = histograms(image, target.kernels, np.stack([region, heaviest]))
        rho = coefficient(q, target.q)
        shares = NOTHING_LEARNT
        if level > self.w_min:
            shares = self.shares(*np.exp(log_likelihood(rho, self.lam)))
        mixed = np.tensordot(shares, np.stack([target.q, *q, state.first]), 1)
        return target._replace(q=mixed), float(distance(rho[0], -1)), shares

    def shares(self, estimate: float, heaviest: float) -> Array:
        """1 - alpha - beta - gamma, alpha, beta, gamma of (10), from two likelihoods.

        Each lies in [0, 1] and they sum to 1, which "normalised weight" and
        "proportional to" in the paper do not promise.

        Parameters
        ----------
        estimate, heaviest : float
            Likelihoods of the estimate and of the heaviest particle.
        """
        both = estimate + heaviest
        alpha = self.eta * (estimate / both if both > 0 else 0.5)
        kept = 1 - self.eta - self.gamma
        return np.array([kept, alpha, self.eta - alpha, self.gamma])

    def _equal_weights(self) -> Array:
        return np.full(self.n, 1 / self.n)
