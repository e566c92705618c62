"""The shape of a target, seen in its first frame, as weights of a kernel's samples.

A rectangle also counts what lies in a hole and between limbs.  That is background,
which changes from frame to frame.  `grabbed` and `by_colour` look for the target inside
the region, as an image of the canonical square, 1 where it is; `Silhouette` is a kernel
that looks nowhere else.

Explained in notebook 17.
"""

from dataclasses import asdict, dataclass, replace
from typing import Any

import cv2
import numpy as np

from mkt.checks import checked_frame, checked_region, in_words, is_number, of_kind
from mkt.colors import ColorBins
from mkt.kernels import Kernels
from mkt.regions import outside, warp_matrices
from mkt.types import Array, ArrayLike, Frame, NDArray

SIDE = 48  # pixels of a mask
AROUND = 1.6  # side of the square in which a mask is sought, in that of the region
ROUNDS = 5  # of grab-cut
LEAST = 0.05  # share of a region; a smaller target was not found
BORDER = 1e-3  # weight of samples outside: a kernel that sees nothing is an error


@dataclass(frozen=True)
class Silhouette(Kernels):
    """Kernels whose weights are those of their parent times a mask.

    Parameters
    ----------
    mask : bytes
        SIDE x SIDE numbers from 0 to 255 over the canonical square, row by row, such
        as `as_bytes` makes; without it everything counts.

    Raises
    ------
    ValueError
        Naming the field.
    """

    mask: bytes = b"\xff" * SIDE**2

    def __post_init__(self):
        super().__post_init__()
        of_kind(self.mask, bytes, "mask", "make it with as_bytes")
        if len(self.mask) != SIDE**2:
            raise ValueError(
                f"mask has {len(self.mask)} bytes; make it with as_bytes: {SIDE**2}"
            )

    @property
    def image(self) -> Array:
        """The mask as numbers (SIDE, SIDE) in [0, 1]."""
        return np.frombuffer(self.mask, np.uint8).reshape(SIDE, SIDE) / 255

    def weigh(self, plane: Array) -> Array:
        """k(r^2) of every kernel times the mask, (J, n), see `Kernels.weigh`."""
        places = (plane / self.half_sides + 1) / 2 * SIDE
        column, row = np.clip(places.astype(int), 0, SIDE - 1).T
        return super().weigh(plane) * np.maximum(self.image[row, column], BORDER)

    def check_slopes(self) -> None:
        """Refuse to give slopes: a mask has none."""
        raise ValueError(
            "kernels times a silhouette have no slope; use plain Epanechnikov ones"
        )


def as_bytes(mask: ArrayLike) -> bytes:
    """A mask (SIDE, SIDE) in [0, 1] as a `Silhouette` keeps it.

    Raises
    ------
    ValueError
        For any other shape or number.
    """
    mask = np.asarray(mask, float)
    if mask.shape != (SIDE, SIDE) or not ((mask >= 0) & (mask <= 1)).all():
        raise ValueError(
            f"mask has the shape {mask.shape}, or numbers beyond 0 and 1; "
            f"give {SIDE} x {SIDE} numbers from 0 to 1"
        )
    return np.rint(255 * mask).astype(np.uint8).tobytes()


def masked(kernels: Kernels, mask: ArrayLike) -> Silhouette:
    """Kernels times a mask (SIDE, SIDE) in [0, 1]; ValueError for any other.

    The mask of a `Silhouette` is multiplied, too.
    """
    fields: dict[str, Any] = asdict(kernels)
    fields["mask"] = as_bytes(mask)
    shown = Silhouette(**fields)
    if not isinstance(kernels, Silhouette):
        return shown
    return replace(shown, mask=as_bytes(shown.image * kernels.image))


def patch(frame: Frame, region: ArrayLike, around: float = AROUND) -> Frame:
    """The square round a region, upright and about SIDE `around` wide: (n, n, 3).

    The region is its SIDE x SIDE pixels in the middle.  Beyond the image the pixels of
    its border are repeated.  ValueError for an array that is not a frame, for a region
    without area or outside the image, and for an `around` below 1.

    Parameters
    ----------
    frame : (H, W, 3) uint8 array, RGB
    region : (5,) array_like [px, rad]
    around : float
        Side of the square, in that of the region.
    """
    if not is_number(around, 1):
        raise ValueError(f"around is {around}; it must be finite, and at least 1")
    frame = checked_frame(frame)
    region = checked_region(region)
    if outside(region, frame.shape):
        raise ValueError(
            f"the region {in_words(region)} lies outside the image; "
            "choose a box inside it"
        )
    n = SIDE + 2 * round(SIDE * (around - 1) / 2)
    to_canonical = np.array([[2 / SIDE, 0, 0], [0, 2 / SIDE, 0], [0, 0, 1.0]])
    to_canonical[:2, 2] = (1 - n) / SIDE
    A = warp_matrices(region) @ to_canonical
    how = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(frame, A, (n, n), flags=how, borderMode=cv2.BORDER_REPLICATE)


def grabbed(frame: Frame, region: ArrayLike) -> NDArray:
    """The target by grab-cut (Rother, Kolmogorov and Blake, 2004), from OpenCV.

    What lies outside the region is known to be background.  If grab-cut finds less than
    a twentieth of the region, all of the region counts.

    Parameters
    ----------
    frame : (H, W, 3) uint8 array, RGB
    region : (5,) array_like [px, rad]

    Returns
    -------
    (SIDE, SIDE) array of 0 and 1

    Raises
    ------
    ValueError
        As `patch` does.
    """
    seen = np.ascontiguousarray(patch(frame, region))
    labels = np.zeros(seen.shape[:2], np.uint8)
    edge = _edge(len(seen))
    cv2.setRNGSeed(0)  # it starts from random clusters
    rect = (edge, edge, SIDE, SIDE)
    how = cv2.GC_INIT_WITH_RECT
    target, background = np.zeros((2, 1, 65))
    cv2.grabCut(seen, labels, rect, background, target, ROUNDS, how)
    mask = (_inner(labels) % 2).astype(float)  # odd: surely or probably the target
    return mask if mask.mean() > LEAST else np.ones_like(mask)


def by_colour(frame: Frame, region: ArrayLike) -> NDArray:
    """The share of each pixel's colour that lies inside: p_in / (p_in + p_around).

    Parameters
    ----------
    frame : (H, W, 3) uint8 array, RGB
    region : (5,) array_like [px, rad]

    Returns
    -------
    (SIDE, SIDE) array in [0, 1]
        Smoothed over three pixels.

    Raises
    ------
    ValueError
        As `patch` does.
    """
    bins = ColorBins()
    labels = bins(patch(frame, region)).labels
    inside = _inner(labels)
    within = np.bincount(inside.ravel(), minlength=bins.m)
    beside = np.bincount(labels.ravel(), minlength=bins.m) - within
    p, around = within / within.sum(), beside / beside.sum()
    ratio = p / np.maximum(p + around, 1e-12)
    return np.clip(cv2.blur(ratio[inside], (3, 3)), 0, 1)  # which it is but rounded


def _edge(n: int) -> int:
    return (n - SIDE) // 2


def _inner(image: NDArray) -> NDArray:
    """The part (SIDE, SIDE) of an image of a patch that is the region."""
    edge = _edge(len(image))
    return image[edge : edge + SIDE, edge : edge + SIDE]


SHAPES = {"grab-cut": grabbed, "colour ratio": by_colour}
