"""Ours: particles that look widely and an optimiser that looks closely.

Each helps the other.

What it adds to the combination of [T09], each for a failure seen there:

* **two kinds of evidence**: kernels over colours and over the directions of edges
  (`mkt.edges`), one sum O(x), for particles and optimiser alike;
* **priors**: ``O(x) + lambda_c (c - c*)^2 + lambda_s (log s / s*)^2`` round the last
  estimate moved by its velocity (`mkt.trackers.newton.Prior`), in the steps and in the
  choice between their ends.  So a look-alike far off, or a smaller region that fits a
  little better, must pay for its distance.  That of the place widens while the target
  is not surely seen, and it is as sure as the velocity has predicted lately: its weight
  is divided by 1 + (r^2 / m^2)^2, r^2 the mean squared surprise of the last sure looks
  and m the step of the particles (blur, fast);
* **a turn must earn its place**: each frame is explained with the first orientation and
  with a free one, and the free one is believed where it leaves less than a share of
  O(x).  That is the form of an F-test, but no level belongs to it.  Where nothing fits
  well, small gains say nothing: so one rule serves a person, whose turns are never
  real, and a toy car, whose always are;
* **a velocity learnt from sure looks alone**: between two of them.  In doubt it is
  kept, and while the target is hidden it fades: a jump to a look-alike, or back from
  one, is no movement;
* **cascade**: many particles on a coarse grid, because a hypothesis that is far off
  needs no fine look (fast motion);
* **several starts**: the last estimate moved by its velocity, then the best particles,
  until the optimiser finds the target (blur);
* **one start anywhere**: where none of these finds it, the particle that looks most
  alike, a hypothesis of its own: no prior of the place, a size and a turn that are
  its own; its end is believed where its distance leaves no doubt (a target that comes
  back beside the estimate, which may have shrunk to whatever was still seen);
* **trust**: in the optimiser, kernels that look unlike their reference count less, so
  that a covered part does not pull (occlusion);
* **wandering**: in every frame in which the target is seen, a few particles chosen by
  lot begin anew at the estimate; all others go on, each as far as chance has taken it
  since its own beginning.  So the crowd is dense near the target and thin far away,
  wherever the target has been, and while it is hidden nobody comes back and the crowd
  spreads (occlusion);
* **light**: three gains follow the light (`mkt.trackers.gains`), so that the reference
  itself never changes and cannot drift (illumination);
* **close-ups**: what is binned is the part of the frame in which the target can be
  (`mkt.trackers.close_up`), so that the cost follows the target and not the frame;
* **a last word by pixels**: where the estimate still looks like the picture of the
  first frame, two steps on pixels say more exactly where it is
  (`mkt.trackers.last_word`); a turn that they take is said where the kernels believe
  one.  The tracker itself goes on from where the kernels ended (rigid things).

Where the time goes, on 200 frames of F: 36 % in the starts (7 of them in the one
anywhere), 20 in the particles, 18 in the close-up, 11 in the other model of the turn, 7
in the last word.

How the settings were chosen, what else was tried, and when the report set was looked at
is told in ``data/trials_of_guided.md``.

There is no resampling: drawing by weight was tried, and the sharper the weights the
more often a hidden target stayed lost, because the crowd had gathered on whatever
looked a little like it.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mkt import checks
from mkt.checks import checked_region
from mkt.colors import BinImage, Bins, ColorBins, Joined, of_bins
from mkt.edges import EdgeBins
from mkt.histograms import Target, learn
from mkt.kernels import Kernels, of_kernels
from mkt.particles import Motion, Particles, covariance, effective_sample_size
from mkt.regions import THETA, area, wrap_angle
from mkt.trackers.close_up import close_up, fitting_pitch
from mkt.trackers.gains import Light, first_light, followed
from mkt.trackers.last_word import aligned, picture_of
from mkt.trackers.newton import HEAVIEST, Prior, distance_at, is_weight
from mkt.trackers.search import Optimum, Search
from mkt.tracking import Info, report
from mkt.types import Array, Frame, NDArray, Region, Regions, Rng

FULL_GRID = 4800  # samples of a region whose cost counts as one evaluation
MEMORY = 0.9  # of the surprise, for one frame
FADING = 0.9  # share of the velocity that outlives a hidden frame
COLORS = ColorBins()  # of the light
WEIGHT = f"a weight of a prior lies between 0 and {HEAVIEST:g}"


class GuidedState(NamedTuple):
    """What is carried from frame to frame.

    Attributes
    ----------
    particles : Particles
    coarse, fine : Target
        The references, for the particles and for the optimiser.
    light : Light
    picture : (h, w) float32 array
        Of the object in the first frame, for the last word.
    pitch : int
        Of the close-ups.
    first, region : (5,) array [px, rad]
        The first region and the last estimate.
    velocity : (2,) array [px/frame]
    turned : bool
        Whether the orientation was last believed to be another one than the first.
    missed : int
        Frames since the target was last seen beyond doubt.
    surprise : float
        Mean squared distance from where the velocity led to where the target was, over
        the last sure looks, in units of hx hy.
    """

    particles: Particles
    coarse: Target
    fine: Target
    light: Light
    picture: NDArray
    pitch: int
    first: Region
    region: Region
    velocity: Array
    turned: bool = False
    missed: int = 0
    surprise: float = 0.0


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
        The distance below which no further start is tried, and the light and how well
        the velocity predicts are learnt.
    sure : float
        The distance below which an optimum is the target wherever it lies.
    lost_above : float
        The distance beyond which the target is said to be lost.
    hidden_above : float
        The distance beyond which the optimum is not believed: the estimate goes on as
        it went, and no particle begins anew.
    doubtful : float
        The distance beyond which the target may be elsewhere: the prior of its place
        widens.
    place, size : float
        The priors' weights lambda, place in units of sqrt(hx hy).  That of the place
        falls where the velocity leads astray by more than the particles' own step.
    widening : float
        How fast the prior of the place loses weight in doubt: 1 / (1 + frames times
        this).
    turn : float
        The share of O(x) below which a turn must bring it: 0 never believes one, and
        infinity always.
    alike : float
        The correlation with the first picture above which pixels have the last word.
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
    sure: float = 0.25
    lost_above: float = 0.525
    hidden_above: float = 0.6
    doubtful: float = 0.45
    place: float = 1.0
    size: float = 5.0
    widening: float = 0.25
    turn: float = 0.7
    alike: float = 0.8
    motion: Motion = Motion(position=0.1)
    bins: Bins = Joined((COLORS, EdgeBins()), (2.0, 1.0))

    def __post_init__(self):
        of_bins(self.bins)
        of_kernels(self.coarse, "coarse")
        of_kernels(self.fine, "fine")
        checks.counts(self, "n", "steps")
        checks.counts(self, "starts", least=0)
        checks.shares(self, "renewed")
        checks.not_negative(self, "widening")
        checks.numbers(self, "place", "size", fits=is_weight, need=WEIGHT)
        checks.numbers(self, "found", "sure", "lost_above", "hidden_above", "doubtful")
        checks.numbers(self, "turn", "alike")
        checks.of_kind(self.motion, Motion, "motion", "give a Motion, such as Motion()")
        checks.positive(self.motion, "position")
        self.fine.check_slopes()

    def init(self, frame: Frame, region: Region, rng: Rng) -> GuidedState:
        """Learn the references from the part of the region that is in the frame."""
        region = checked_region(region)
        region[THETA] = wrap_angle(region[THETA])
        pitch = fitting_pitch(self.fine, region)
        ones = np.ones(3)
        here = region[None]
        image = close_up(self.bins, frame, ones, here, pitch)
        coarse, fine = (learn(image, region, k, True) for k in (self.coarse, self.fine))
        colors = close_up(COLORS, frame, ones, here, pitch)
        seen = learn(colors, region, self.fine, True)
        light = first_light(seen, COLORS, frame, region)
        picture = picture_of(frame, region, pitch)
        particles = self.motion.scatter(region, self.n, rng)
        return GuidedState(
            particles,
            coarse,
            fine,
            light,
            picture,
            pitch,
            region,
            region,
            velocity=np.zeros(2),
        )

    def step(
        self, state: GuidedState, frame: Frame, rng: Rng
    ) -> tuple[GuidedState, Info]:
        """Look widely, then closely, then decide whether the target was seen at all."""
        particles = self.motion.predict(state.particles, rng)
        prior = self._prior(state)
        everywhere = np.vstack([particles.regions, prior.region])
        gains, light = state.light.gains, state.light
        image = close_up(self.bins, frame, gains, everywhere, state.pitch)
        rho = state.coarse.coefficients(image, particles.regions)
        likeness = np.maximum(rho.mean(-1), 1e-9)
        search = self._search(state, image)
        known, d, steps, turned = search.turned(
            *self._optimum(search, prior, particles.regions, likeness, state.turned)
        )
        lost, hidden = d > self.lost_above, d > self.hidden_above
        sure = d < self.found
        if sure:
            light = followed(light, frame, known)
        missed = state.missed + 1 if d > self.doubtful else 0
        region = _drifted(state, FADING) if hidden else known
        velocity = _velocity(state, region, hidden, missed)
        weights = likeness / likeness.sum()
        said = region if hidden else self._said(state, frame, region, turned)
        info = report(
            said,
            d if said is known else distance_at(state.fine, image, said),
            lost,
            self._cost(state, steps),
            covariance=covariance(particles.regions, weights, said),
            n_eff=effective_sample_size(weights),
            particles=particles.regions,
            weights=weights,
            steps=steps,
        )
        if not hidden:
            particles = self._renewed(particles, region, velocity, rng)
        return state._replace(
            particles=particles,
            light=light,
            region=region,
            velocity=velocity,
            turned=turned,
            missed=missed,
            surprise=_surprise(state, region, sure),
        ), info

    def _prior(self, state: GuidedState) -> Prior:
        """Round the last estimate moved by its velocity, with a free turn."""
        off = state.surprise / self.motion.position**2
        place = self.place / (1 + self.widening * state.missed) / (1 + off**2)
        return Prior(_drifted(state), np.array([place, place, 0.0, self.size]))

    def _cost(self, state: GuidedState, steps: int) -> float:
        """The work of a frame in regions looked at with the full grid of samples."""
        coarse, fine = state.coarse.kernels.points, state.fine.kernels.points
        samples = self.n * len(coarse) + steps * len(fine)
        return samples / FULL_GRID

    def _said(
        self, state: GuidedState, frame: Frame, region: Region, turned: bool
    ) -> Region:
        """The estimate, or where pixels lead from it, if that looks like the picture.

        In any case with the estimate's own orientation, unless a turn is believed.  The
        tracker itself goes on from the estimate.
        """
        said, correlation = aligned(frame, state.picture, region, state.pitch)
        if correlation <= self.alike:
            return region
        return said if turned else np.array([*said[:2], region[THETA], *said[3:]])

    def _renewed(
        self, particles: Particles, region: Region, velocity: Array, rng: Rng
    ) -> Particles:
        """The particles, of which a few chosen by lot begin anew at the estimate."""
        chosen = rng.random(self.n) < self.renewed
        regions = np.where(chosen[:, None], region, particles.regions)
        velocities = np.where(chosen[:, None], velocity, particles.velocities)
        return Particles(regions, velocities)

    def _search(self, state: GuidedState, image: BinImage) -> Search:
        """What the starts of a frame share."""
        return Search(
            state.fine,
            image,
            state.first[THETA],
            self.steps,
            self.found,
            self.sure,
            self.turn,
        )

    def _optimum(
        self,
        search: Search,
        prior: Prior,
        regions: Regions,
        likeness: Array,
        free: bool,
    ) -> tuple[Prior, Optimum]:
        """The optimum over the starts, or over one anywhere, behind its prior."""
        favour = likeness - prior.cost(regions) / search.full
        best = regions[np.argsort(favour)[::-1][: self.starts]]
        optimum = search.over(prior, [prior.region, *best], free)
        if optimum.distance < self.found:
            return prior, optimum
        return search.anywhere(prior, optimum, regions[np.argmax(likeness)])


def _velocity(state: GuidedState, region: Region, hidden: bool, missed: int) -> Array:
    """Learnt between two sure looks; kept in doubt, less and less while hidden.

    A jump to a look-alike, or back from one, is no movement of the target.
    """
    if hidden:
        return FADING * state.velocity
    if missed or state.missed:
        return state.velocity
    return 0.5 * state.velocity + 0.5 * (region[:2] - state.region[:2])


def _surprise(state: GuidedState, region: Region, sure: bool) -> float:
    """How far the velocity led astray; what is not surely the target tells nothing."""
    if state.missed or not sure:
        return state.surprise
    off = region[:2] - _drifted(state)[:2]
    return MEMORY * state.surprise + (1 - MEMORY) * float(4 * off @ off / area(region))


def _drifted(state: GuidedState, share: float = 1.0) -> Region:
    """The last estimate, moved by a share of its velocity."""
    return state.region + np.concatenate([share * state.velocity, np.zeros(3)])
