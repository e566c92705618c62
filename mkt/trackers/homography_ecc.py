"""The pixel-based rival: a homography aligned with OpenCV's ECC.

``cv2.findTransformECC`` (Evangelidis and Psarakis, 2008) maximises the correlation
between the picture of the first frame and the warped frame, by Gauss-Newton steps on
the eight numbers of a homography.  Like ESM (Benhimane and Malis, 2004) it compares
pixel with pixel, and it does not mind the strength of the light.

Used in notebook 16.
"""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from mkt import checks
from mkt.checks import checked_frame, checked_region
from mkt.homographies import as_region, of_regions
from mkt.regions import from_box
from mkt.trackers.homography import plausible
from mkt.tracking import Info, report
from mkt.types import Array, Frame, NDArray, Region, Rng


class ECCState(NamedTuple):
    """The picture of the object, its map to the square, its aspect, the last place.

    Attributes
    ----------
    picture : (h, w) float32 array
        What faced the camera in the first frame, in grey.
    from_square : (3, 3) array
        From the canonical square to the picture's pixels.
    aspect : float
        hx / hy.
    homography : (3, 3) array
        The last estimate.
    first : (3, 3) array
        That of the first frame.
    """

    picture: NDArray
    from_square: Array
    aspect: float
    homography: Array
    first: Array


@dataclass(frozen=True)
class PlaneECC:
    """ECC on a homography, from the last estimate.

    Parameters
    ----------
    iterations : int
        Steps at most.
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
    # On the cards of the tuning seeds, from 15 px, 25 degrees and 20 %, two passes find
    # the card in 36 % of starts, one of 5 in 16; wider or more passes are no better.
    blurs: tuple[int, ...] = (15, 5)
    lost_below: float = 0.5

    def __post_init__(self):
        checks.counts(self, "iterations")
        if not self.blurs or any(blur < 1 or blur % 2 == 0 for blur in self.blurs):
            raise ValueError(
                f"blurs is {self.blurs}; give at least one odd width, such as 5"
            )

    def init(self, frame: Frame, region: Region, rng: Rng) -> ECCState:
        """Keep the object's picture, at the resolution at which it is seen."""
        region = checked_region(region)
        hx, hy = region[3:]
        size = max(round(2 * hx), 8), max(round(2 * hy), 8)
        from_square = of_regions(from_box([0, 0, *size]))
        to_image = of_regions(region) @ np.linalg.inv(from_square)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        picture = cv2.warpPerspective(_grey(frame), to_image, size, flags=flags)
        first = of_regions(region)
        return ECCState(picture, from_square, hx / hy, first, first)

    def step(self, state: ECCState, frame: Frame, rng: Rng) -> tuple[ECCState, Info]:
        """Align from the last estimate."""
        homography, correlation = self.refine(state, frame, state.homography)
        d = np.sqrt(1 - max(correlation, 0.0))
        lost = correlation < self.lost_below
        region = as_region(homography, state.aspect)
        info = report(region, d, lost, 1, homography=homography)
        return state._replace(homography=homography), info

    def refine(
        self, state: ECCState, frame: Frame, start: Array
    ) -> tuple[Array, float]:
        """Align from any start (3, 3); the homography, and the correlation there.

        Where OpenCV gives up, or finds what no camera could see, the start and 0.
        """
        grey = _grey(frame)
        way = (start @ np.linalg.inv(state.from_square)).astype(np.float32)
        way /= way[2, 2]
        correlation, everywhere = 0.0, np.full(grey.shape, 255, np.uint8)
        ends = cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, self.iterations, 1e-4
        motion = cv2.MOTION_HOMOGRAPHY
        try:
            for blur in self.blurs:
                correlation, way = cv2.findTransformECC(
                    state.picture, grey, way, motion, ends, everywhere, blur
                )
        except cv2.error:  # it has run away, or does not correlate
            return start, 0.0
        homography = np.asarray(way, float) @ state.from_square
        homography /= homography[2, 2]
        if not plausible(homography, state.first):
            return start, 0.0
        return homography, float(correlation)


def _grey(frame: Frame) -> NDArray:
    grey = cv2.cvtColor(checked_frame(frame), cv2.COLOR_RGB2GRAY)
    return grey.astype(np.float32)
