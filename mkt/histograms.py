"""Colour histograms of many regions at once, and how alike two of them are.

The way of a frame: ``bins(frame)`` turns colours into one image of bin numbers, once
(`mkt.colors`); `histograms` looks the kernels' sample points up in it for all regions
in one call; `coefficient` and `distance` compare the result with the reference, which
`learn` keeps as a `Target`.

How the histograms are made, and what was tried (500 regions, 4,800 samples, nine
kernels; ``python3 -m mkt bench`` measures it here):

* sample positions: a float32 matrix product for each chunk of regions, then
  ``cv2.remap`` (nearest) on the bin image;
* constant weights: one two-channel ``cv2.calcHist`` for each chunk, whose first channel
  is the number of the kernel in the chunk;
* other weights: a sparse matrix with one 1 for each sample (bin by sample) times K,
  about twice the cost of constant ones.  Tried and slower: ``np.bincount`` with weights
  once for each kernel (11 x) or once over all pairs of a sample and a kernel (6 x), a
  one-hot matrix product (19 x), and ``calcHist`` over small cells of constant weight
  followed by a product (3 to 4 x, and not exact).

Chunks keep the memory at a few megabytes however many regions there are, for hundreds
of bins; with 4,096 bins, other weights than constant ones take 15 MB.  For a single
region, whose derivatives are wanted too, `mkt.trackers.newton` counts in another way.

Explained in notebook 01.
"""

from collections.abc import Iterator
from functools import lru_cache
from math import floor, isfinite
from threading import get_ident
from typing import NamedTuple

import cv2
import numpy as np
from scipy.sparse import csc_matrix, csr_matrix

from mkt.checks import LONGEST, checked_region, in_words, of_kind
from mkt.colors import BinImage, label_type
from mkt.homographies import HORIZON, angles, as_places, maps
from mkt.kernels import Kernels, of_kernels
from mkt.regions import as_regions
from mkt.types import Array, ArrayLike, NDArray

FAR = 1e9  # px; beyond it single precision has no places left
OUTSIDE = np.array([[0, 0, -1e6], [0, 0, -1e6], [0, 0, 1.0]])  # of every image
IN_CACHE = 130_000  # samples whose positions and labels the processor's cache holds


def histograms(image: BinImage, kernels: Kernels, regions: ArrayLike) -> NDArray:
    """Kernel-weighted histograms, q_u = sum_i K_ji delta(b(l_i) - u).

    Equation (2) of [T09], (3) of [N03].

    Parameters
    ----------
    image : BinImage
        The bins of the frame.
    kernels : Kernels
        Fitted to the object.
    regions : (N, 5) array_like [px, rad]
        Or homographies, (N, 3, 3) array_like, see `mkt.homographies`.

    Returns
    -------
    (N, J, m) float32 array
        Each (n, j) sums to 1.  Samples outside the image are not counted; a kernel with
        all of its samples outside gives zeros, hence the coefficient 0.  A region that
        is not finite lies outside everything.

    Raises
    ------
    ValueError
        For kernels that are not fitted, or of which one covers no sample; regions of
        another shape; and more samples than OpenCV can look up.
    """
    return normalised(counts(image, kernels, regions))


def counts(image: BinImage, kernels: Kernels, regions: ArrayLike) -> NDArray:
    """`histograms` (N, J, m) before they are made to sum to 1.

    The arguments and the errors are the same.
    """
    _check(image, kernels)
    regions = as_places(regions)
    count = _weighted if kernels.parts is None else _constant
    result = np.empty((len(regions), len(kernels.weights), image.m), np.float32)
    for part, labels in _chunks(image, kernels, regions):
        count(labels, kernels, result[part])
    return _voted(result, image, regions)


def _voted(counts: NDArray, image: BinImage, places: Array) -> NDArray:
    """Counts (N, ..., m), each bin times its share, directions turned, in place."""
    if image.shares is not None:
        counts *= image.shares
    for compass in image.compasses:
        turned(counts, angles(places), compass)
    return counts


def _check(image: BinImage, kernels: Kernels) -> None:
    of_kind(image, BinImage, "image", "give bins(frame), not the frame itself")
    of_kernels(kernels, "kernels")


def turned(counts: NDArray, theta: Array, compass: tuple[int, int]) -> None:
    """Count directions from the x axes of regions instead of that of the image.

    A turn by a whole sector moves the counts by one bin; for smaller turns neighbouring
    counts are mixed linearly, so that the histogram has a derivative by the turn.

    Parameters
    ----------
    counts : (N, ..., m) array
        Of N regions, changed in place.
    theta : (N,) array [rad]
        Their orientations.
    compass : (first, n)
        The bins that are directions, see `mkt.colors.BinImage`.
    """
    first, n = compass
    turns = np.where(np.isfinite(theta), theta, 0) * n / (2 * np.pi)
    whole = np.floor(turns)
    shares = (turns - whole).astype(counts.dtype)
    shares = shares.reshape(-1, *(1,) * (counts.ndim - 1))
    bins = counts[..., first : first + n]
    sectors = whole.astype(int) % n
    for sector in set(sectors.tolist()):
        rows = sectors == sector
        bins[rows] = _mixed(bins[rows], sector, shares[rows], -1)[0]


def turned_once(counts: Array, theta: float, compass: tuple[int, int]) -> Array:
    """`turned` for one region and several columns of counts, and the derivative.

    For so few numbers it takes a fifth of the time.

    Parameters
    ----------
    counts : (J, m, k) array
        Changed in place.
    theta : float [rad]
    compass : (first, n)

    Returns
    -------
    (J, n, k) array
        The derivative of the bins that are directions by theta.
    """
    first, n = compass
    turns = theta * n / (2 * np.pi) if isfinite(theta) else 0.0
    whole = floor(turns)
    bins = counts[:, first : first + n]
    bins[:], change = _mixed(bins, whole % n, turns - whole, 1)
    return change * (n / (2 * np.pi))


def _mixed(
    bins: NDArray, sector: int, share: float | NDArray, axis: int
) -> tuple[NDArray, NDArray]:
    """Directions counted from a sector, a share of each from the next; the change."""
    ring = np.arange(sector, sector + bins.shape[axis])
    near = bins.take(ring, axis, mode="wrap")
    change = bins.take(ring + 1, axis, mode="wrap") - near
    return near + share * change, change


def mixed_histograms(
    image: BinImage, kernels: Kernels, regions: ArrayLike, shares: ArrayLike
) -> NDArray:
    """One histogram for each region, each under its own mixture of the kernels.

    Counted by unpacking a sparse matrix of all weights, which adds up what falls into
    one place: .8 ms for 100 ellipses of 942 samples and 512 bins, where the two
    histograms that could be mixed afterwards take 1.7, and ``np.bincount`` 1.2.

    Parameters
    ----------
    image, kernels, regions
        As for `histograms`, which also says what is refused.
    shares : (N, J) array_like
        The share of each kernel in the weight of each region; the sum does not matter.

    Returns
    -------
    (N, m) float32 array
        Each of sum 1, or all zero.
    """
    _check(image, kernels)
    regions = as_places(regions)
    wanted = len(regions), len(kernels.weights)
    if np.shape(shares) != wanted:
        raise ValueError(
            f"shares has the shape {np.shape(shares)}; give a share of each kernel for "
            f"each region, {wanted}"
        )
    weights = np.asarray(shares, np.float32) @ kernels.weights.astype(np.float32)
    result = np.empty((len(regions), image.m), np.float32)
    for part, labels in _chunks(image, kernels, regions):
        layers, k, n = labels.shape
        starts = np.arange(0, labels.size + 1, layers * n, dtype=np.int32)
        indices = np.swapaxes(labels, 0, 1).ravel().astype(np.int32)
        entries = (np.tile(weights[part], layers).ravel(), indices, starts)
        table = csr_matrix(entries, (k, image.m + 1)).toarray()
        result[part] = table[:, : image.m]
    return normalised(_voted(result, image, regions))


def normalised(counts: NDArray) -> NDArray:
    """Counts (..., m), changed in place so that each sums to 1 or is all zero."""
    sums = counts @ np.ones((counts.shape[-1], 1), np.float32)  # faster than sum(-1)
    # Less than this is the rounding error of a weight on the border of a support.
    sums[sums < 1e-9] = np.inf
    counts /= sums
    return counts


def sample(image: BinImage, kernels: Kernels, region: Array) -> NDArray:
    """Bin number under every sample point of one region.

    Parameters
    ----------
    image : BinImage
    kernels : Kernels
    region : (5,) array [px, rad]
        Or a homography (3, 3).

    Returns
    -------
    (n,) array, or (L, n) for an image of L layers
        m where a point lies outside the image.
    """
    labels = _look_up(image, kernels, _matrices(image, region[None]))[:, 0].copy()
    return labels if image.others else labels[0]


def _chunks(
    image: BinImage, kernels: Kernels, regions: Array
) -> Iterator[tuple[slice, NDArray]]:
    """Regions or homographies in parts, each with the bins under its samples (L, k, n).

    The bins are overwritten with each part, so they never leave this module.
    """
    rows = _chunk(kernels)
    matrices = _matrices(image, regions)
    for start in range(0, len(regions), rows):
        part = slice(start, start + rows)
        yield part, _look_up(image, kernels, matrices[part])


def _chunk(kernels: Kernels) -> int:
    """Regions in a chunk: they must fit the cache, and their kernels' numbers uint8.

    Of more kernels than those a chunk has one region, and numbers of 16 bits.
    """
    j, n = kernels.weights.shape
    cached = min(max(IN_CACHE // n, 1), LONGEST)
    return cached if kernels.parts is None else max(min(cached, 255 // j), 1)


def _matrices(image: BinImage, places: Array) -> NDArray:
    """The maps (N, r, 3) to the image; those that are hardly finite go far outside."""
    matrices = maps(places)
    near = np.abs(matrices) < FAR
    if not near.all():
        matrices[~near.all((1, 2))] = OUTSIDE[: matrices.shape[1]]
    rows = matrices[:, :2]
    if places.ndim == 2:
        rows[..., 2] -= image.origin
    else:
        rows -= np.array(image.origin)[:, None] * matrices[:, 2:]
    rows /= image.pitch
    return matrices.astype(np.float32)


def _look_up(image: BinImage, kernels: Kernels, matrices: NDArray) -> NDArray:
    """Bins under the sample points, (L, k, n) in L layers, for maps (k, r, 3).

    Two rows are an affine map, three one in perspective.  The next call in the same
    thread overwrites them.
    """
    if len(kernels.points) > LONGEST:
        raise ValueError(
            f"samples is {kernels.samples}, too many; take at most {LONGEST}"
        )
    rows = len(matrices)
    points = kernels.homogeneous
    layers = image.layers
    shape = len(layers), rows, points.shape[1]
    x, y, labels = _room(get_ident(), shape, image.labels.dtype)
    np.matmul(matrices[:, 0], points, out=x)
    np.matmul(matrices[:, 1], points, out=y)
    if matrices.shape[1] == 3:
        depths = np.maximum(matrices[:, 2] @ points, HORIZON)
        x /= depths
        y /= depths
    border = cv2.BORDER_CONSTANT
    for layer, out in zip(layers, labels, strict=True):
        cv2.remap(layer, x, y, cv2.INTER_NEAREST, out, border, image.m)
    return labels


@lru_cache(maxsize=32)
def _room(
    _thread, shape: tuple[int, int, int], dtype
) -> tuple[NDArray, NDArray, NDArray]:
    """Arrays to work in, kept for each thread.

    To ask the system for fresh memory for every chunk can take longer than the work.
    """
    x, y = np.empty((2, *shape[1:]), np.float32)
    return x, y, np.empty(shape, dtype)


def _constant(labels: NDArray, kernels: Kernels, out: NDArray) -> None:
    """Counts under constant weights: labels (L, k, n) -> out (k, J, m)."""
    k, j, m = out.shape
    number = _numbers(kernels, labels.dtype)[:k]
    ranges, sizes = [0, k * j, 0, m], [k * j, m]
    table = out.reshape(k * j, m)
    for i, layer in enumerate(labels.astype(number.dtype, copy=False)):
        channels = [number, layer]
        cv2.calcHist(channels, [0, 1], None, sizes, ranges, table, accumulate=i > 0)


@lru_cache(maxsize=64)
def _numbers(kernels: Kernels, dtype) -> NDArray:
    """The kernel that each sample of a whole chunk counts for: (chunk, n).

    They are of the labels' type, unless there are more kernels than it has numbers.
    """
    assert kernels.parts is not None  # or their weights are not constant
    j = len(kernels.weights)
    rows = np.arange(_chunk(kernels))[:, None]
    return (kernels.parts + j * rows).astype(np.promote_types(dtype, label_type(j)))


def _weighted(labels: NDArray, kernels: Kernels, out: NDArray) -> None:
    """Counts under any weights: labels (L, k, n) -> out (k, J, m), a sparse product."""
    layers, k, n = labels.shape
    m = out.shape[-1]
    numbers = (m + 1) * np.arange(k, dtype=np.int32)[:, None]
    rows = (labels + numbers).reshape(layers * k, n).T.ravel()
    starts = np.arange(0, rows.size + 1, layers * k, dtype=np.int32)
    ones = np.ones(rows.size, np.float32)
    membership = csc_matrix((ones, rows, starts), shape=(k * (m + 1), n))
    product = membership @ kernels.weights.T.astype(np.float32)
    out[:] = product.reshape(k, m + 1, -1)[:, :m].swapaxes(1, 2)


def coefficient(q: ArrayLike, reference: ArrayLike) -> Array:
    """Bhattacharyya coefficient rho = sum_u sqrt(q_u q*_u).

    Equation (3) of [T09], (6) of [N03], (7) of [C14].

    Parameters
    ----------
    q, reference : (..., m) array_like
        Broadcast against each other; each of sum 1 or all zero.

    Returns
    -------
    (...) array in [0, 1], up to rounding

    Raises
    ------
    ValueError
        For histograms of different lengths.

    Examples
    --------
    All alike, half alike, nothing alike.

    >>> q = [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.0, 0.0, 1.0]]
    >>> coefficient(q, [0.5, 0.5, 0.0]).round(9)
    array([1. , 0.5, 0. ])
    """
    roots, others = np.sqrt(q), np.sqrt(reference)
    if roots.shape[-1:] != others.shape[-1:]:  # or a single bin would fit any number
        raise ValueError(
            f"q has the shape {roots.shape} and reference {others.shape}; make both "
            "with the same bins"
        )
    return np.einsum("...m,...m->...", roots, others)


def distance(rho: ArrayLike, axis: int | None = None) -> Array:
    """Bhattacharyya distance d = sqrt(1 - rho), (7) of [N03] and (8) of [C14].

    Over an axis of kernels d_m = sqrt(mean_j d_j^2), our reading of (5).

    Parameters
    ----------
    rho : (...) array_like
        Coefficients.
    axis : int, optional
        That of the kernels.

    Returns
    -------
    array in [0, 1]
        Never NaN: rounding is clipped.
    """
    d2 = np.maximum(1.0 - np.asarray(rho, float), 0.0)
    return np.sqrt(d2 if axis is None else d2.mean(axis))


def log_likelihood(rho: ArrayLike, lam: float = 20.0, combine: str = "sum") -> Array:
    """Ln p(z | x) = -lam sum_j d_j^2, up to a constant.

    Equation (13) of [T09], (9) of [C14]; with lam = 1 / (2 sigma^2) also (10) of [N03].

    Parameters
    ----------
    rho : (..., J) array_like
        Coefficients of the kernels.
    lam : float
        20 as printed.
    combine : {"sum", "mean"}
        Over the kernels; the mean is flatter.

    Returns
    -------
    (...) array

    Raises
    ------
    ValueError
        For another way to combine.
    """
    if combine not in ("sum", "mean"):
        raise ValueError(f"combine is {combine!r}; it must be sum or mean")
    d2 = np.maximum(1.0 - np.asarray(rho, float), 0.0)
    return -lam * (d2.sum(-1) if combine == "sum" else d2.mean(-1))


class Target(NamedTuple):
    """The reference: how the object is looked at, and what was seen.

    Attributes
    ----------
    kernels : Kernels
        Fitted to the object.
    q : (J, m) array
        The histograms q*.
    learnt : (J',) int array, optional
        The kernels that saw something, where not all did; the others, whose q* is 0,
        count nowhere.
    """

    kernels: Kernels
    q: NDArray
    learnt: NDArray | None = None

    @property
    def m(self) -> int:
        """Number of bins."""
        return self.q.shape[-1]

    @property
    def counted(self) -> int:
        """Number of kernels that count."""
        return len(self.q if self.learnt is None else self.learnt)

    def coefficients(self, image: BinImage, regions: ArrayLike) -> Array:
        """Bhattacharyya coefficients of regions with the reference.

        Parameters
        ----------
        image : BinImage
            Of the frame in which to look.
        regions : (N, 5) array_like [px, rad]
            Or homographies, (N, 3, 3), as for `histograms`.

        Returns
        -------
        (N, J) array, or (N, J') of the kernels that are learnt

        Raises
        ------
        ValueError
            For an image of another number of bins, and as `histograms` does.
        """
        self.check(image)
        q = histograms(image, self.kernels, regions)
        # In place: a second array of this size can double the time, where the system
        # takes both back after every call and gives them anew, page by page.
        rho = np.einsum("njm,jm->nj", np.sqrt(q, out=q), np.sqrt(self.q))
        return rho if self.learnt is None else rho[:, self.learnt]

    def distances(self, image: BinImage, regions: ArrayLike) -> Array:
        """d_m of regions to the reference over all kernels, (5) of [T09].

        Parameters
        ----------
        image : BinImage
            Of the frame in which to look.
        regions : (..., 5) array_like [px, rad]

        Returns
        -------
        (...) array in [0, 1]

        Raises
        ------
        ValueError
            As `coefficients` does.
        """
        regions = as_regions(regions)
        rho = self.coefficients(image, regions.reshape(-1, 5))
        return distance(rho, axis=-1).reshape(regions.shape[:-1])

    def check(self, image: BinImage) -> None:
        """Refuse an image of other bins than those that were learnt."""
        _check(image, self.kernels)
        if image.m != self.m:
            raise ValueError(
                f"the image has {image.m} bins, but the reference {self.m}; "
                "make both with the same bins"
            )


def learn(
    image: BinImage, region: ArrayLike, kernels: Kernels, partly: bool = False
) -> Target:
    """Take the object inside a region as the reference.

    Parameters
    ----------
    image : BinImage
        The bins of the frame.
    region : (5,) array_like [px, rad]
    kernels : Kernels
        They are fitted to the region.
    partly : bool
        Take an object that is partly outside the image: leave out the kernels that see
        nothing of it.

    Raises
    ------
    ValueError
        For a region that is not finite or has no area, and where a kernel sees nothing
        of the image, since such a part could never be found again; with `partly` only
        where all see nothing.
    """
    region = checked_region(region)
    _check(image, kernels)
    fitted = kernels.fitted(region)
    q = histograms(image, fitted, region)[0]
    seen = q.any(-1)
    if not (seen.any() if partly else seen.all()):
        raise ValueError(
            f"part of the region {in_words(region)} lies outside the image; "
            "choose a box inside it"
        )
    return Target(fitted, q, None if seen.all() else np.flatnonzero(seen))
