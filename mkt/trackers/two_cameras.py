"""Two particle filters on one ground plane that tell each other what they see.

[N03] ends with several cameras.  Each filter works in its own image and sends, once a
frame, where on the ground its likelihood says that the target is: mean and covariance,
five numbers.  The other multiplies its own likelihood by it.  A camera that sees
nothing sends nothing, so that when a wall hides the target from one camera, the other
one helps it.

The constants were set by a look at scenes 500 to 505, with 40 and 80 for lambda of the
mean and for `HIDDEN`; no other values were tried.

Explained in notebook 17.
"""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from mkt import checks
from mkt.colors import binned
from mkt.histograms import log_likelihood
from mkt.particles import Particles, mean_region, normalised
from mkt.trackers.particle_filter import FilterState, ParticleFilter
from mkt.types import Array, Frame, Region, Rng

HIDDEN = 40.0  # -ln of the own likelihood at most, since a target may be hidden
FLOOR = 1e-3  # of the other's, since a message may be wrong
NEWLY_PLACED = 0.1  # share of the particles that go where the other camera says
SLACK = 3.0  # [px on the ground] how uncertain the place of a middle is at least
BYTES = 20  # of a message: five numbers of four bytes


class Message(NamedTuple):
    """The message of a camera.

    Attributes
    ----------
    mean : (2,) array [px on the ground]
    covariance : (2, 2) array
        Symmetric: three numbers.
    """

    mean: Array
    covariance: Array


class Seen(NamedTuple):
    """What a step found.

    Attributes
    ----------
    regions : (2, 5) array [px, rad]
        In both images.
    places : (2, 2) array [px on the ground]
        Of both filters, through the homographies that they believe.
    bytes : int
        The number of bytes that were sent.
    """

    regions: Array
    places: Array
    bytes: int


States = tuple[FilterState, ...]


@dataclass(frozen=True, eq=False)
class TwoCameras:
    """Two filters and the homographies by which they believe to see the ground.

    Each weighs its particles by (floor + own likelihood) (floor + the other's): a
    camera whose target is hidden gives the same likelihood to all places, and leaves
    the decision to the other.  A tenth of its particles then go where the other sees
    the target.

    Parameters
    ----------
    homographies : two (3, 3) arrays
        From the ground to each image.
    filter : ParticleFilter
        Of each camera.
    talking : bool
        Whether they exchange messages.

    Raises
    ------
    ValueError
        Naming the field, such as a filter with other weights.
    """

    homographies: tuple[Array, Array]
    filter: ParticleFilter = ParticleFilter(n=100)
    talking: bool = True

    def __post_init__(self):
        checks.of_kind(self.filter, ParticleFilter, "filter", "give a ParticleFilter()")
        checks.flags(self, "talking")
        given = checks.are_finite(self.homographies, 2, 3, 3)
        checks.require(self, homographies=(given, "two maps of 3 x 3 finite numbers"))
        if type(self.filter).weigh is not ParticleFilter.weigh:
            raise ValueError(
                f"filter is a {type(self.filter).__name__}, which weighs in its own "
                "way; give a ParticleFilter, whose likelihoods can be said"
            )

    def init(
        self, frames: tuple[Frame, Frame], regions: tuple[Region, Region], rng: Rng
    ) -> States:
        """Learn the object in both images."""
        pairs = zip(frames, regions, strict=True)
        return tuple(self.filter.init(frame, region, rng) for frame, region in pairs)

    def step(
        self, states: States, frames: tuple[Frame, Frame], rng: Rng
    ) -> tuple[States, Seen]:
        """Predict and weigh in both images, exchange messages, estimate, draw."""
        looks = [self._look(k, states[k], frames[k], rng) for k in (0, 1)]
        sent = [look.said if self.talking else None for look in looks]
        ends = [self._end(k, looks[k], sent[1 - k], rng) for k in (0, 1)]
        regions = np.array([region for region, _ in ends])
        places = [on_ground(self.homographies[k], regions[k, None, :2]) for k in (0, 1)]
        targets = [state.target for state in states]
        following = [
            FilterState(target, cloud)
            for target, (_, cloud) in zip(targets, ends, strict=True)
        ]
        cost = BYTES * sum(message is not None for message in sent)
        return tuple(following), Seen(regions, np.concatenate(places), cost)

    def _look(self, k: int, state: FilterState, frame: Frame, rng: Rng) -> "_Look":
        """What a camera sees by itself, and says of it; nothing where it is lost."""
        pf, target = self.filter, state.target
        image = binned(pf.bins, frame)
        cloud = pf.motion.predict(state.particles, rng)
        rho = target.coefficients(image, cloud.regions)
        logs = log_likelihood(rho, pf.lam, pf.combine)
        ground = on_ground(self.homographies[k], cloud.regions[:, :2])
        weights = normalised(logs)
        mean = weights @ ground
        off = ground - mean
        d = target.distances(image, mean_region(cloud.regions, weights))
        said = None if d > pf.lost_above else Message(mean, (weights * off.T) @ off)
        return _Look(cloud, np.logaddexp(logs, -HIDDEN), ground, said)

    def _end(
        self, k: int, look: "_Look", told: Message | None, rng: Rng
    ) -> tuple[Region, Particles]:
        """The estimate of a camera that was told something, and its next cloud."""
        logs = look.logs + (0 if told is None else heard(told, look.ground))
        weights = normalised(logs)
        region = mean_region(look.cloud.regions, weights)
        cloud = look.cloud.take(self.filter.resample(weights, rng))
        if told is not None:
            moved = slice(round(NEWLY_PLACED * len(weights)))
            image = self.homographies[k]
            cloud.regions[moved, :2] = _through(image, told.mean[None])
        return region, cloud


class _Look(NamedTuple):
    """A camera's particles, their log weights (N,), places (N, 2), and its message."""

    cloud: Particles
    logs: Array
    ground: Array
    said: Message | None


def heard(message: Message, ground: Array) -> Array:
    """The logarithm of the other camera's likelihood at places (n, 2) on the ground."""
    off = ground - message.mean
    spread = message.covariance + SLACK**2 * np.eye(2)
    squared = np.einsum("ni,ni->n", off, np.linalg.solve(spread, off.T).T)
    return np.log(FLOOR + np.exp(-squared / 2))


def on_ground(H: Array, points: Array) -> Array:
    """Points (n, 2) of an image on the ground, through the inverse of (3, 3)."""
    return _through(np.linalg.inv(H), points)


def _through(H: Array, points: Array) -> Array:
    return cv2.perspectiveTransform(points[None], H)[0]
