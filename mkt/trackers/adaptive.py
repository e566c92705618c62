"""The adaptive colour particle filter of [N03].

Ellipses as particles, a model that learns, and a way to wait for the target.

While *tracking*, each frame is processed as in Figure 1 of the paper: `select`,
`propagate`, `observe`, `estimate`; then the model is `updated`.  When for a couple of
frames too few particles appear to be the target (`mkt.trackers.appearance`), the mode
is *initialising*: every frame places particles anew where the target may come, until
enough of them appear.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mkt import checks
from mkt.checks import checked_region, in_words
from mkt.colors import BinImage, Bins, ColorBins, binned, of_bins
from mkt.histograms import coefficient
from mkt.particles import (
    EllipseMotion,
    covariance,
    effective_sample_size,
    multinomial,
    normalised,
)
from mkt.trackers.appearance import (
    Zone,
    background,
    check_zones,
    place,
    threshold,
)
from mkt.trackers.ellipses import Disc
from mkt.tracking import Info, report
from mkt.types import Array, Frame, NDArray, Region, Regions, Rng

TRACKING, INITIALISING = "tracking", "initialising"
SPREAD = 0.1  # of the size of placed particles, about the model's own


def equivalent_rho(pi_t: float, sigma: float) -> dict[str, float]:
    """The coefficient that the printed condition pi > pi_T asks for.

    Section 5 of [N03] prints pi_T = .9 and no sigma, so there are several readings of
    (10) and (11).

    Parameters
    ----------
    pi_t : float
        pi_T.
    sigma : float
        Of the likelihood (10).

    Returns
    -------
    dict of float, NaN for never
        density : pi with 1 / (sqrt(2 pi) sigma) before the exponential.
        printed : with 1 / sqrt(2 pi sigma).
        relative : with 1.
        coefficient : pi_T is compared with rho itself.
    """
    factors = {
        "density": 1 / (np.sqrt(2 * np.pi) * sigma),
        "printed": 1 / np.sqrt(2 * np.pi * sigma),
        "relative": 1.0,
    }
    result = {"coefficient": pi_t}
    for name, factor in factors.items():
        rho = 1 - 2 * sigma**2 * np.log(factor / pi_t)
        result[name] = float(rho) if rho <= 1 else np.nan
    return result


class Model(NamedTuple):
    """What is looked for.

    Attributes
    ----------
    q : (m,) array
        The histogram.
    half_axes : (2,) array [px]
        The half axes that it was learnt with.
    """

    q: NDArray
    half_axes: Array


class AdaptiveState(NamedTuple):
    """What is carried from frame to frame.

    Attributes
    ----------
    model : Model
    particles : (N, 7) array
        (x, y, vx, vy, Hx, Hy, va), see `mkt.particles.EllipseMotion`.
    weights : (N,) array
        Of sum 1.
    background : (I, m) array
        See `mkt.trackers.appearance.background`.
    limit : float
        The coefficient with the model above which a particle appears.
    region : (5,) array [px, rad]
        The last estimate.
    mode : str
    missing : int
        For how many frames in a row too few particles appeared.
    """

    model: Model
    particles: Array
    weights: Array
    background: NDArray
    limit: float
    region: Region
    mode: str
    missing: int


@dataclass(frozen=True)
class Adaptive:
    """The tracker of [N03].

    Parameters
    ----------
    n : int
        Number of particles, the paper's samples.
    bins : Bins
    disc : Disc
        The radius in the kernel, and how finely it is sampled.
    sigma : float
        Of (10), a standard deviation of d.
    motion : EllipseMotion
        The prediction.
    alpha : float
        Share of each frame in the model; 0 for a model that never changes.
    rho_min : float
        The model is updated where the coefficient of the mean state exceeds it, see
        `equivalent_rho`.
    b : float
        Kick-off fraction.
    patience : int
        "A couple of frames".
    zones : tuple
        Where particles wait, see `mkt.trackers.appearance.place`.

    Raises
    ------
    ValueError
        Naming the field.
    """

    n: int = 100  # printed, Section 7
    bins: Bins = ColorBins("rgb")  # printed, Section 3: 8x8x8
    disc: Disc = Disc()
    sigma: float = 0.1  # ours: the paper prints none
    motion: EllipseMotion = EllipseMotion()
    alpha: float = 0.1  # ours: the paper prints none
    # Ours: noise in 512 bins alone costs .03 to .05, more where the target is small.
    rho_min: float = 0.8
    b: float = 0.1  # printed, Section 6
    patience: int = 5  # ours: "a couple of frames"
    zones: tuple[Zone, ...] = ("borders", "anywhere")

    def __post_init__(self):
        of_bins(self.bins)
        checks.of_kind(self.motion, EllipseMotion, "motion", "give an EllipseMotion()")
        checks.of_kind(self.disc, Disc, "disc", "give a Disc()")
        checks.counts(self, "n", "patience")
        checks.positive(self, "sigma")
        checks.shares(self, "alpha", "rho_min", "b")
        check_zones(self.zones)

    def learn(self, frame: Frame, region: Region) -> Model:
        """The model of what is inside the upright ellipse of a region (5,).

        Parameters
        ----------
        frame : (H, W, 3) uint8 array, RGB
        region : (5,) array [px, rad]

        Raises
        ------
        ValueError
            Where that lies outside the image.
        """
        return self._learnt(binned(self.bins, frame), upright(region))

    def _learnt(self, image: BinImage, region: Region) -> Model:
        q = self.disc.histograms(image, region[None])[0]
        if not q.any():
            raise ValueError(
                f"the region {in_words(region)} lies outside the image; "
                "choose a box inside it"
            )
        return Model(q, region[3:])

    def init(self, frame: Frame, region: Region, rng: Rng) -> AdaptiveState:
        """Start where a user or a detector says: learn the model, spread particles."""
        region = upright(region)
        image = binned(self.bins, frame)
        model = self._learnt(image, region)
        half_axes = model.half_axes
        around = background(self.disc, image, half_axes, without=region)
        here = [*region[:2], 0, 0, *region[3:], 0]
        particles = self.motion.predict(np.tile(here, (self.n, 1)), half_axes, rng)
        return self._begun(model, particles, around, region, TRACKING)

    def expect(self, frame: Frame, model: Model, rng: Rng) -> AdaptiveState:
        """Wait for a known model, before the target is there.

        Parameters
        ----------
        frame : (H, W, 3) uint8 array
            Of the background.
        model : Model
        rng : numpy.random.Generator
        """
        around = background(self.disc, binned(self.bins, frame), model.half_axes)
        particles = self.place(model, frame.shape, rng)
        region = as_regions(particles).mean(0)
        return self._begun(model, particles, around, region, INITIALISING)

    def _begun(
        self, model: Model, particles: Array, around: NDArray, region: Region, mode: str
    ) -> AdaptiveState:
        weights = np.full(self.n, 1 / self.n)
        limit = threshold(around, model.q)
        return AdaptiveState(model, particles, weights, around, limit, region, mode, 0)

    def step(
        self, state: AdaptiveState, frame: Frame, rng: Rng
    ) -> tuple[AdaptiveState, Info]:
        """One frame in the mode of the state; "lost" while initialising."""
        image = binned(self.bins, frame)
        if state.mode == TRACKING:
            chosen = self.select(state, rng)
            particles = self.propagate(chosen, state.model, rng)
            rho = self.observe(image, particles, state.model)
            weights = self.weigh(rho)
        else:
            particles = self.place(state.model, frame.shape, rng)
            rho = self.observe(image, particles, state.model)
            weights = self.weigh(np.where(rho > state.limit, rho, -np.inf))
        positives = int(np.sum(rho > state.limit))
        limit = state.limit
        state = self.switched(state, positives)
        state = state._replace(particles=particles, weights=weights)
        state, seen, learnt = self._estimated(state, image)
        info = self._report(state, seen)
        return state, info | {
            "positives": positives,
            "threshold": limit,
            "updated": learnt,
        }

    def _estimated(
        self, state: AdaptiveState, image: BinImage
    ) -> tuple[AdaptiveState, float, bool]:
        """The state with its estimate and its model after a frame while tracking.

        Returns it, the coefficient of the mean state, NaN while initialising, and
        whether the model learnt.
        """
        if state.mode != TRACKING:
            return state, np.nan, False
        region = self.estimate(state.particles, state.weights)
        model, seen = self.updated(state.model, image, region)
        learnt = model is not state.model
        limit = threshold(state.background, model.q) if learnt else state.limit
        return state._replace(model=model, region=region, limit=limit), seen, learnt

    def _report(self, state: AdaptiveState, seen: float) -> Info:
        """The info of a step, in which the mean state has the coefficient `seen`."""
        regions = as_regions(state.particles)
        weights = state.weights
        nothing = np.isnan(seen)
        d = 1.0 if nothing else np.sqrt(max(1 - seen, 0.0))
        return report(
            state.region,
            d,
            state.mode != TRACKING,
            self.n + 1,  # while initialising, too, where no mean state is looked at
            covariance=covariance(regions, weights, state.region),
            n_eff=effective_sample_size(weights),
            particles=regions,
            weights=weights,
            model=state.model.q,
            rho=seen,
            mode=state.mode,
        )

    def select(self, state: AdaptiveState, rng: Rng) -> Array:
        """Step 1 of Figure 1: (N, 7) particles with replacement, by binary search."""
        return state.particles[multinomial(state.weights, rng)]

    def propagate(self, particles: Array, model: Model, rng: Rng) -> Array:
        """Step 2: A s + w, (N, 7).

        Parameters
        ----------
        particles : (N, 7) array
            See `mkt.particles.EllipseMotion`.
        model : Model
            Its half axes count.
        rng : numpy.random.Generator
        """
        return self.motion.predict(particles, model.half_axes, rng)

    def observe(self, image: BinImage, particles: Array, model: Model) -> Array:
        """Step 3 a and b: the coefficients (N,) of particles with the model, (6).

        Parameters
        ----------
        image : BinImage
        particles : (N, 7) array
        model : Model
        """
        p = self.disc.histograms(image, as_regions(particles))
        return coefficient(p, model.q)

    def weigh(self, rho: Array) -> Array:
        """Step 3 c: the weights of (10), of sum 1: (N,).

        Parameters
        ----------
        rho : (N,) array
            The coefficients of `observe`.
        """
        return normalised((rho - 1) / (2 * self.sigma**2))

    def estimate(self, particles: Array, weights: Array) -> Region:
        """Step 4: the mean state, (1), as a region (5,).

        Parameters
        ----------
        particles : (N, 7) array
        weights : (N,) array
            Of sum 1.
        """
        return as_regions(weights @ particles)

    def updated(
        self, model: Model, image: BinImage, region: Region
    ) -> tuple[Model, float]:
        """The model after (11) and (12), and the coefficient of the mean state.

        The mean state is that of a region (5,); the model stays the same where the
        condition fails.
        """
        p = self.disc.histograms(image, region[None])[0]
        rho = float(coefficient(p, model.q))
        if self.alpha > 0 and rho > self.rho_min:
            model = model._replace(q=(1 - self.alpha) * model.q + self.alpha * p)
        return model, rho

    def switched(self, state: AdaptiveState, positives: int) -> AdaptiveState:
        """The state in its mode after a frame in which so many particles appear."""
        limit = round(self.b * self.n, 9)  # .29 x 100 is a little less than 29
        if state.mode == INITIALISING:
            found = positives > limit
            return state._replace(mode=TRACKING if found else INITIALISING, missing=0)
        missing = state.missing + 1 if positives < limit else 0
        mode = TRACKING if missing < self.patience else INITIALISING
        return state._replace(mode=mode, missing=missing)

    def place(self, model: Model, shape: tuple[int, ...], rng: Rng) -> Array:
        """Particles (N, 7) that stand still in the zones of an image of that shape."""
        centres = place(self.zones, shape, model.half_axes, self.n, rng)
        growth = np.exp(SPREAD * rng.standard_normal((self.n, 1)))
        still = np.zeros((self.n, 2))
        none = np.zeros(self.n)
        return np.column_stack([centres, still, model.half_axes * growth, none])


def as_regions(particles: Array) -> Regions:
    """The ellipses of particles (..., 7) as regions (..., 5)."""
    regions = particles[..., [0, 1, 2, 4, 5]]
    regions[..., 2] = 0
    return regions


def upright(region: Region) -> Region:
    """The upright ellipse in the upright box round the ellipse of a region (5,).

    Raises
    ------
    ValueError
        For a region that is not finite or has no area.
    """
    x, y, theta, hx, hy = checked_region(region)
    c, s = np.cos(theta), np.sin(theta)
    return np.array([x, y, 0.0, np.hypot(hx * c, hy * s), np.hypot(hx * s, hy * c)])
