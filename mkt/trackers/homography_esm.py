"""The pixel-based rival: second-order steps, ESM of Benhimane and Malis (2004).

Let s be the frame as the homography H shows it over the object, and s* the object's own
picture.  With the generators of `mkt.homographies`, H <- H exp(x), the difference
e = s - s* has the derivatives

    J(0) = grad s . v,    J(x*) = grad s* . v

here and at the solution x*, both by the same flow v of the object plane.  A step with
their mean, Delta x = -((J(0) + J(x*)) / 2)^+ e, is exact to second order, and needs no
second derivative.

Tried before: OpenCV's ``findTransformECC`` on the same eight numbers.  On the tuning
cards of notebook 16 it comes back from fewer starts (56 % for 62; on the held-back ones
34 for 75), and its corners end .13 to .16 px off where these end .07 off, with the same
two blurs in both: blur carries background over the border of the picture, a different
one in each frame, and the algorithm follows it.  With the inner nine tenths of an
object both end within .1 px of the truth, so there it is an oracle for the tests.

Used in notebook 16.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from mkt import checks
from mkt.checks import checked_frame, checked_region, in_words, locked
from mkt.homographies import as_region, flow, moved, of_regions
from mkt.regions import from_box
from mkt.trackers.homography import plausible
from mkt.trackers.newton import LARGEST_STEP
from mkt.tracking import Info, report
from mkt.types import Array, Frame, NDArray, Region, Rng

SHORT = 1e-3  # a step below this ends a pass, in object units, radians and log size
UNSEEN = 0.75  # share of the object that may lie outside the frame
COARSE = 32, 32  # [px] of the first look at how much of it does


class ESMState(NamedTuple):
    """The pictures of the object, its aspect, the last place and the first one.

    Attributes
    ----------
    pictures : tuple of (h, w) float32 arrays
        What faced the camera in the first frame, in grey, one for each pass; NaN in
        what was outside of it.
    aspect : float
        hx / hy.
    homography : (3, 3) array
        The last estimate.
    first : (3, 3) array
        That of the first frame.
    """

    pictures: tuple[NDArray, ...]
    aspect: float
    homography: Array
    first: Array


@dataclass(frozen=True)
class PlaneESM:
    """ESM on a homography, from the last estimate.

    Both pictures are brought to mean 0 and variance 1 first, so the strength of the
    light does not matter.

    Parameters
    ----------
    iterations : int
        Steps in a pass, at most.
    blurs : tuple of int [px]
        Widths of the Gaussians that smooth both pictures, odd, one pass each, from
        coarse to fine.
    lost_below : float
        The correlation below which the target is said to be lost.

    Raises
    ------
    ValueError
        Naming the field.
    """

    iterations: int = 50
    # On the cards of the tuning seeds, from 15 px, 25 degrees and 20 %, these find the
    # card in 75 % of starts, one pass of 5 in 28, (15, 5) in 66 and (41, 5) in 72.
    blurs: tuple[int, ...] = (25, 5)
    lost_below: float = 0.5

    def __post_init__(self):
        checks.counts(self, "iterations")
        checks.numbers(self, "lost_below")
        widths = self.blurs if isinstance(self.blurs, tuple) else ()
        odd = all(checks.is_whole(width, 1) and width % 2 for width in widths)
        if not widths or not odd:
            raise ValueError(
                f"blurs is {self.blurs}; give a tuple of odd widths, such as (25, 5)"
            )

    def init(self, frame: Frame, region: Region, rng: Rng) -> ESMState:
        """Keep the object's pictures, at the resolution at which it is seen.

        Raises
        ------
        ValueError
            Where too little of it is in the frame.
        """
        region = checked_region(region)
        hx, hy = region[3:]
        size = max(round(2 * hx), 8), max(round(2 * hy), 8)
        first = of_regions(region)
        smoothed = self._smoothed(frame)
        if not in_view(facing(smoothed[0], first, np.zeros(COARSE, np.float32))):
            raise ValueError(
                f"most of the region {in_words(region)} lies outside the image; "
                "choose a box inside it"
            )
        blank = np.zeros(size[::-1], np.float32)
        pictures = tuple(facing(each, first, blank) for each in smoothed)
        return ESMState(pictures, hx / hy, first, first)

    def step(self, state: ESMState, frame: Frame, rng: Rng) -> tuple[ESMState, Info]:
        """Align from the last estimate."""
        homography, correlation, steps = self.refine(state, frame, state.homography)
        d = np.sqrt(1 - min(max(correlation, 0.0), 1.0))
        lost = correlation < self.lost_below
        region = as_region(homography, state.aspect)
        info = report(region, d, lost, steps, homography=homography, steps=steps)
        return state._replace(homography=homography), info

    def refine(
        self, state: ESMState, frame: Frame, start: Array
    ) -> tuple[Array, float, int]:
        """Align from any start (3, 3), pass after pass.

        If it finds what no camera could see, or what lies outside the frame, it returns
        the start, with a correlation of 0.

        Returns
        -------
        homography : (3, 3) array
        correlation : float
            With the picture, before the last step.
        steps : int
            How many were taken.
        """
        found, correlation, taken = start, 0.0, 0
        for picture, smooth in zip(state.pictures, self._smoothed(frame), strict=True):
            h, w = picture.shape
            sides = np.sqrt([w / h, h / w])
            steps, short = 0, False
            while steps < self.iterations and not short:
                seen = facing(smooth, found, picture)
                if not in_view(seen + picture):
                    return start, 0.0, taken
                step, correlation = esm_step(picture, seen)
                taken += 1
                bounded = np.clip(step, -LARGEST_STEP, LARGEST_STEP)
                found = moved(found, bounded, sides)
                if not plausible(found, state.first):
                    return start, 0.0, taken
                short = np.abs(step).max() < SHORT
                steps += 1
        return found, correlation, taken

    def _smoothed(self, frame: Frame) -> list[NDArray]:
        """A frame in grey for each pass, (H, W) float32."""
        grey = cv2.cvtColor(checked_frame(frame), cv2.COLOR_RGB2GRAY)
        exact = grey.astype(np.float32)
        return [cv2.GaussianBlur(exact, (blur, blur), 0) for blur in self.blurs]


def in_view(seen: NDArray) -> bool:
    """Whether enough of what `facing` saw of an object, (h, w), is in the frame.

    Of the sum of two such pictures: whether enough is in both.
    """
    return bool(np.isnan(seen).mean() <= UNSEEN)


def esm_step(
    picture: NDArray, seen: NDArray, motions: tuple[int, ...] = tuple(range(8))
) -> tuple[Array, float]:
    """The step Delta x that brings what is seen nearer to the picture.

    Parameters
    ----------
    picture, seen : (h, w) float32 arrays
        s* and s, over the object; NaN in what lies outside the frame, now or when the
        picture was taken, which is left out.
    motions : tuple of int
        Which of the parameters of `mkt.homographies` to step in, all by default.

    Returns
    -------
    step : (k,) array
        Of these parameters, in object units.
    correlation : float
        Of the two pictures before the step, in [-1, 1].
    """
    h, w = picture.shape
    finite = np.isfinite(seen + picture)
    if not finite.all():
        picture, seen = _filled(picture, seen), _filled(seen, picture)
    inside = finite.ravel().astype(np.float32)
    wanted, found = (_standard(each.ravel(), inside) for each in (picture, seen))
    mean = (wanted + found) / 2
    slopes = _slopes(mean.reshape(h, w)) * inside
    jacobian = np.einsum("cn,cin->in", slopes, _motions(w, h, motions))
    # What brings pictures to mean 0 and variance 1 does the same to their derivatives:
    # without it a step left four times as much of a small displacement.
    light = np.array([inside, mean * inside])
    light /= np.maximum(np.sqrt((light**2).sum(1, keepdims=True)), 1e-9)  # flat: 0
    jacobian -= (jacobian @ light.T) @ light
    normal, slope = jacobian @ jacobian.T, jacobian @ (found - wanted)
    step = -np.linalg.lstsq(normal.astype(float), slope.astype(float), rcond=1e-9)[0]
    return step, float(_mean(wanted * found, inside))


def _filled(picture: NDArray, other: NDArray) -> NDArray:
    """A picture with another one where it is NaN, so that no slopes begin there."""
    return np.where(np.isfinite(picture), picture, np.nan_to_num(other))


def _slopes(image: NDArray) -> NDArray:
    """Central differences along x and y, (2, h w)."""
    along = [cv2.Sobel(image, -1, *to, ksize=1, scale=0.5) for to in ((1, 0), (0, 1))]
    return np.array(along).reshape(2, -1)


@lru_cache(maxsize=8)
def _motions(w: int, h: int, motions: tuple[int, ...]) -> NDArray:
    """How each pixel of a picture moves under some generators, (2, k, w h) [px].

    A unit of the object plane is the root of a quarter of the area.
    """
    x, y = np.meshgrid(np.arange(w), np.arange(h))
    centre = from_box([0, 0, w, h])[:2]
    unit = (w * h) ** 0.5 / 2
    points = (np.column_stack([x.ravel(), y.ravel()]) - centre) / unit
    v, _ = flow(points, 8)
    moves = unit * np.moveaxis(v[list(motions)], 2, 0)
    return locked(np.ascontiguousarray(moves, np.float32))


def facing(frame: NDArray, homography: Array, picture: NDArray) -> NDArray:
    """The frame over the object, of a picture's size (h, w); NaN outside the frame."""
    size = picture.shape[::-1]
    to_image = homography @ _to_square(*size)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpPerspective(frame, to_image, size, flags=flags, borderValue=np.nan)


@lru_cache(maxsize=8)
def _to_square(w: int, h: int) -> Array:
    """From the pixels of a picture to the canonical square, (3, 3)."""
    return locked(np.linalg.inv(of_regions(from_box([0, 0, w, h]))))


def _standard(picture: NDArray, inside: NDArray) -> NDArray:
    """A picture (n,) with mean 0 and variance 1 inside of the frame."""
    centred = picture - _mean(picture, inside)
    return centred / max(_mean(centred**2, inside) ** 0.5, 1e-6)


def _mean(values: NDArray, inside: NDArray) -> NDArray:
    """The mean of (n,) values over those inside, where (n,) is 1; elsewhere it is 0.

    As a product: numpy's own means over a part take five times as long.
    """
    return values @ inside / inside.sum()
