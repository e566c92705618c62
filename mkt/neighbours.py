"""Bins that know their neighbours: what a colour just beyond a border is worth.

To Bhattacharyya's coefficient two bins are different, however near their colours lie:
when the light turns red by some degrees, all pixels move into the next bin, and the two
histograms have nothing in common.  Three remedies, each of which gives a squared
distance in [0, 1] like d^2 = 1 - rho, so that a filter can take any
(`mkt.trackers.neighbours`):

* *soft assignment*: each pixel votes in several bin images whose borders are moved by
  parts of a bin (Scott's averaged shifted histogram); no tracker has to be changed;
* *smoothing*: the histogram times a matrix S that gives half of a bin's share, in each
  channel, to its two neighbours, round the circle in hue; the same S makes the
  *quadratic form* (q - q*)^T S (q - q*) / 2;
* the *earth mover's distance*: how far shares must be carried round the circle of hues.

Explained in notebook 17.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from scipy.sparse import block_diag, csr_array, kron

from mkt.checks import locked, of_kind
from mkt.colors import BinImage, ColorBins
from mkt.histograms import coefficient
from mkt.types import Array, ArrayLike, Frame, NDArray

VOTES = 5  # of a pixel; the lattice of `SoftBins` covers the plane evenly for these
LATTICE = 1, 2, 3  # steps of hue, saturation and value from vote to vote, modulo 5


@dataclass(frozen=True)
class SoftBins:
    """Soft assignment: each pixel has five votes, in bins with moved borders.

    A colour in the middle of its bin keeps nearly all votes there; one at the border
    gives half of them to the neighbour.

    Parameters
    ----------
    bins : ColorBins
        Whose borders are moved, up to two fifths of a bin either way.

    Raises
    ------
    ValueError
        For other bins.

    Examples
    --------
    An orange at the border between the first two of ten hues.

    >>> orange = np.array([[[255, 153, 0]]], np.uint8)
    >>> [labels.item() for labels in SoftBins()(orange).layers]
    [19, 19, 19, 9, 9]
    """

    bins: ColorBins = ColorBins()

    def __post_init__(self):
        of_kind(self.bins, ColorBins, "bins", "give ColorBins, such as ColorBins()")

    @property
    def m(self) -> int:
        """Number of bins."""
        return self.bins.m

    @cached_property
    def _moved(self) -> list[ColorBins]:
        steps = np.arange(VOTES)[:, None] * LATTICE + VOTES // 2
        shifts = (steps % VOTES - VOTES // 2) / VOTES + self.bins.shift
        return [replace(self.bins, shift=tuple(s)) for s in shifts.tolist()]

    def __call__(self, frame: Frame) -> BinImage:
        """The bins of a frame (H, W, 3) uint8 RGB; ValueError for anything else."""
        first, *others = (bins(frame).labels for bins in self._moved)
        return BinImage(first, self.m, tuple(others))


@lru_cache(maxsize=16)
def smoothing(bins: ColorBins) -> csr_array:
    """S, by which a histogram is multiplied to share with neighbouring bins.

    In each channel a bin keeps half and gives a quarter to either side: round the
    circle in hue, back to itself at the ends of the others.  S is symmetric, its rows
    sum to 1, and it has no negative eigenvalue, so that it makes a quadratic form.

    Parameters
    ----------
    bins : ColorBins
        Of hue, saturation and value, the space "hsv".

    Returns
    -------
    (m, m) sparse array

    Raises
    ------
    ValueError
        For another space.
    """
    hues, saturations, values = hsv_counts(bins)
    colours = kron(_shared(hues, circular=True), _shared(saturations))
    S = csr_array(block_diag([colours, _shared(values)]), dtype=np.float32)
    for array in (S.data, S.indices, S.indptr):
        locked(array)
    return S


def shared(q: ArrayLike, bins: ColorBins) -> NDArray:
    """Q S for histograms (..., m); ValueError for those of other bins."""
    S = smoothing(bins)
    q = _of_these(q, bins)
    return (q.reshape(-1, bins.m) @ S).reshape(q.shape)


def _of_these(q: ArrayLike, bins: ColorBins) -> NDArray:
    """Histograms (..., m); ValueError for those of other bins."""
    q = np.asarray(q)
    if q.shape[-1:] != (bins.m,):
        raise ValueError(
            f"histograms have the shape {q.shape}, but {bins} makes {bins.m} bins; "
            "give (..., m) of the same bins"
        )
    return q


def _shared(n: int, circular: bool = False) -> Array:
    """S for a channel of n bins alone, (n, n)."""
    one = np.eye(n)
    if circular:
        sides = np.roll(one, 1, 0) + np.roll(one, -1, 0)
    else:
        to = np.arange(n)
        sides = one[np.maximum(to - 1, 0)] + one[np.minimum(to + 1, n - 1)]
    return one / 2 + sides / 4


def hsv_counts(bins: ColorBins) -> tuple[int, int, int]:
    """How many hues, saturations and values; ValueError for another space."""
    of_kind(bins, ColorBins, "bins", "give ColorBins, such as ColorBins()")
    if bins.space != "hsv":
        raise ValueError(
            f"space is {bins.space}; neighbours are known for hsv, take ColorBins()"
        )
    hues, saturations, values = bins.per_channel
    return hues, saturations, values


def circular_emd(p: ArrayLike, q: ArrayLike) -> Array:
    """Earth mover's distance of two histograms on a circle, in half turns.

    The work of carrying p to q is sum_u abs(F_u - c) for the difference F of their
    cumulative sums; the median of F is the best c, the place where the circle is cut
    (Werman, Peleg and Rosenfeld, 1985).

    Parameters
    ----------
    p, q : (..., n) array_like
        Broadcast against each other, of sum 1.

    Returns
    -------
    (...) array in [0, 1]

    Raises
    ------
    ValueError
        For histograms of different lengths, or of no bins.

    Examples
    --------
    A quarter turn; an eighth, across the place where hue begins; half a turn.

    >>> p = np.eye(8)
    >>> circular_emd(p[[2, 7, 4]], p[0])
    array([0.5 , 0.25, 1.  ])
    """
    p, q = np.asarray(p, float), np.asarray(q, float)
    n = p.shape[-1] if p.ndim else 0
    if not n or q.shape[-1:] != (n,):
        raise ValueError(
            f"p and q have the shapes {p.shape} and {q.shape}; give histograms of the "
            "same bins"
        )
    gap = np.cumsum(p - q, -1)
    # The median of n numbers, by a partial sort that is faster than numpy's median.
    middle = np.partition(gap, n // 2, -1)[..., n // 2, None]
    return np.abs(gap - middle).sum(-1) / (n / 2)


def bhattacharyya(q: ArrayLike, reference: ArrayLike, bins: ColorBins) -> Array:
    """d^2 = 1 - rho, (...) in [0, 1]: bins (..., m) have no neighbours."""
    return np.maximum(1 - coefficient(q, reference), 0)  # rounding, as in `distance`


def smoothed(q: ArrayLike, reference: ArrayLike, bins: ColorBins) -> Array:
    """d^2 = 1 - rho(q S, q* S), (...) in [0, 1], of histograms (..., m)."""
    rho = coefficient(shared(q, bins), shared(reference, bins))
    return np.maximum(1 - rho, 0)


def quadratic(q: ArrayLike, reference: ArrayLike, bins: ColorBins) -> Array:
    """d^2 = (q - q*)^T S (q - q*) / 2, (...) in [0, 1], of histograms (..., m).

    1 where q is all zero, because nothing was seen.
    """
    q, reference = _of_these(q, bins), _of_these(reference, bins)
    off = q - reference
    product = np.einsum("...m,...m->...", shared(off, bins), off)
    d2 = np.maximum(product / 2, 0)  # rounding may leave a little less
    return _seen(q, d2)


def earth_mover(q: ArrayLike, reference: ArrayLike, bins: ColorBins) -> Array:
    """d^2 = c EMD(hues) + abs(difference of the colourful shares), (...) in [0, 1].

    c is the smaller colourful share: what is grey in one and coloured in the other has
    nowhere to be carried.  Saturation and value are not looked at.  1 where q is all
    zero, because nothing was seen.

    Parameters
    ----------
    q, reference : (..., m) array_like
        Of sum 1, or all zero; broadcast against each other.
    bins : ColorBins
        Those that made them.
    """
    hues, saturations, _ = hsv_counts(bins)
    q, reference = _of_these(q, bins), _of_these(reference, bins)
    shares = [_hues(each, hues, saturations) for each in (q, reference)]
    total = [each.sum(-1) for each in shares]
    p, r = (
        h / np.maximum(t, 1e-9)[..., None] for h, t in zip(shares, total, strict=True)
    )
    d2 = np.minimum(*total) * circular_emd(p, r) + np.abs(total[0] - total[1])
    return _seen(q, d2)


def _seen(q: NDArray, d2: Array) -> Array:
    """Squared distances of histograms q (..., m): 1, the largest, where all is zero.

    Nothing was seen there, because the region lies outside the image.
    """
    return np.where(q.any(-1), d2, 1.0)


def _hues(q: NDArray, hues: int, saturations: int) -> NDArray:
    """The shares of the hues (..., hues) in histograms (..., m)."""
    colours = q[..., : hues * saturations]
    return colours.reshape(*q.shape[:-1], hues, saturations).sum(-1)


#: The squared distances of this module by name.
#:
#: :meta hide-value:
MEASURES = {
    "bhattacharyya": bhattacharyya,
    "smoothed": smoothed,
    "quadratic": quadratic,
    "earth mover": earth_mover,
}
