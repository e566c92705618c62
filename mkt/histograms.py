"""Colour histograms of many regions at once, and how alike two of them are.

The way of a frame: ``bins(frame)`` turns colours into one image of bin numbers, once; `histograms` looks the kernels' sample points
up in it for all regions in one call; `coefficient` and `distance` compare the result with the reference, which `learn` keeps as
a `Target`.

How the histograms are made, and what was tried (500 regions, 4,800 samples, nine kernels; ``python3 -m mkt bench`` measures it here):

* sample positions: a float32 matrix product a chunk of regions, then ``cv2.remap`` (nearest) on the bin image;
* constant weights: one two-channel ``cv2.calcHist`` a chunk, whose first channel is the number of the kernel in the chunk;
* other weights: a sparse matrix with one 1 a sample (bin by sample) times K: about twice the cost of constant ones.  Tried and
  slower: ``np.bincount`` with weights once a kernel (11 x) or once over all (sample, kernel) pairs (6 x), a one-hot matrix product
  (19 x), and ``calcHist`` over small cells of constant weight followed by a product (3 to 4 x, and not exact).

Chunks keep the memory at a few megabytes however many regions there are.  Explained in notebook 01.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from threading import get_ident
from typing import NamedTuple

import cv2
import numpy as np
from scipy.sparse import csc_matrix

from mkt.kernels import Kernels
from mkt.regions import as_regions, checked, warp_matrices

# Two threads help on an idle machine and stall on a busy one; repeated runs use processes instead.
cv2.setNumThreads(1)

SPACES = {"hsv": (10, 10, 10), "rgb": (8, 8, 8), "hs": (10, 10)}
MOST_BINS = 65_535  # bin numbers, and one more for what lies outside the image, fit 16 bits
LONGEST = 32_766  # px a side, and samples: cv2.remap counts with 16 bits and a sign
FAR = 1e9  # px; beyond it single precision has no places left


def checked_frame(frame):
    """The frame as an array.  Raises ValueError unless it is (H, W, 3) uint8 with at least one pixel, and no side too long for OpenCV."""
    frame = np.asarray(frame)
    if frame.ndim != 3 or frame.shape[2] != 3 or frame.dtype != np.uint8 or not frame.size:
        raise ValueError(f"a frame must be (H, W, 3) uint8 RGB with at least one pixel, not {frame.shape} {frame.dtype}; convert it first")
    if max(frame.shape) > LONGEST:
        raise ValueError(f"a frame of {frame.shape[1]}x{frame.shape[0]} px is too large; scale it down to at most {LONGEST} px a side")
    return frame


@dataclass(frozen=True)
class ColorBins:
    """The bin map b(l) of a colour: frame (H, W, 3) uint8 RGB -> bin image (H, W), uint8 where the numbers fit, else uint16.

    space:  "hsv", N_h N_s + N_v bins: colourful pixels by hue and saturation, grey or dark ones (S <= s_min or V <= v_min) by value;
            "rgb", all three channels jointly; "hs", hue and saturation jointly.
    counts: bins a channel; None takes 10, 10, 10 for hsv, 8, 8, 8 for rgb [N03], 10, 10 for hs [C14].

    Raises ValueError naming the field.  Notebook 01.

    >>> bins = ColorBins()
    >>> bins(np.array([[[255, 0, 0], [200, 0, 0], [128, 128, 128]]], np.uint8)).tolist()  # two reds of one hue and saturation; a grey
    [[9, 9, 105]]
    """

    space: str = "hsv"
    counts: tuple[int, ...] | None = None
    s_min: float = 0.1
    v_min: float = 0.2

    def __post_init__(self):
        if self.space not in SPACES:
            raise ValueError(f"space is {self.space!r}; it must be one of {', '.join(SPACES)}")
        needed = len(SPACES[self.space])
        if self.counts is not None and (len(self.counts) != needed or not all(1 <= c <= 64 for c in self.counts)):
            raise ValueError(f"counts is {self.counts}; {self.space} takes {needed} numbers from 1 to 64")
        if self.m > MOST_BINS:
            raise ValueError(f"counts is {self.counts}, which makes {self.m} bins; take fewer, at most {MOST_BINS} in all")
        for field in ("s_min", "v_min"):
            if not 0 <= getattr(self, field) <= 1:
                raise ValueError(f"{field} is {getattr(self, field)}; it must lie between 0 and 1")

    @property
    def _counts(self):
        return SPACES[self.space] if self.counts is None else self.counts

    @cached_property
    def m(self):
        """Number of bins."""
        if self.space == "hsv":
            h, s, v = self._counts
            return h * s + v
        return int(np.prod(self._counts))

    @cached_property
    def dtype(self):
        """Type of the bin image; one number more than the bins is needed, for what lies outside the image."""
        return np.uint8 if self.m < 256 else np.uint16

    @cached_property
    def _tables(self):
        """One look-up table (256,) a channel, whose entries add up to the bin number."""
        ranges = (256, 256, 256) if self.space == "rgb" else (180, 256, 256)
        steps = [np.minimum(np.arange(256) * c // r, c - 1) for c, r in zip(self._counts, ranges)]
        if self.space == "hsv":
            h, s, v = steps
            return [t.astype(self.dtype) for t in (h * self._counts[1], s, v + self.m - self._counts[2])]
        strides = np.cumprod([1, *self._counts[:0:-1]])[::-1]
        return [(step * stride).astype(self.dtype) for step, stride in zip(steps, strides)]

    def __call__(self, frame):
        """frame (H, W, 3) uint8 RGB -> (H, W) bin numbers in 0 ... m - 1.  Raises ValueError for any other shape or type."""
        frame = checked_frame(frame)
        channels = cv2.split(frame if self.space == "rgb" else cv2.cvtColor(frame, cv2.COLOR_RGB2HSV))
        looked_up = [cv2.LUT(channel, table) for channel, table in zip(channels, self._tables)]
        if self.space == "hsv":
            grey = (channels[1] <= 255 * self.s_min) | (channels[2] <= 255 * self.v_min)
            return cv2.copyTo(looked_up[2], grey.view(np.uint8), looked_up[0] + looked_up[1])  # several times as fast as numpy's where
        return sum(looked_up[1:], looked_up[0])


def histograms(image, m, kernels, regions):
    """Kernel-weighted histograms, q_u = sum_i K_ji delta(b(l_i) - u): (2) of [T09], (3) of [N03].

    image: (H, W) bin numbers below m, from `ColorBins`; m: number of bins; kernels: `Kernels`; regions: (N, 5) [px, rad].
    Returns (N, J, m) float32.  Each (n, j) sums to 1.  Samples outside the image count for nothing; a kernel with all of its
    samples outside gives zeros, hence the coefficient 0.  A region that is not finite lies outside everything.
    Raises ValueError for an image that is not one of m bins, regions of another shape, or more samples than OpenCV can look up.
    """
    _check(image, m, kernels)
    regions = as_regions(regions).reshape(-1, 5)
    count = _weighted if kernels.parts is None else _counted
    q = np.empty((len(regions), len(kernels.weights), m), np.float32)
    rows, matrices = _chunk(kernels), _finite_matrices(regions)
    for start in range(0, len(regions), rows):
        part = q[start:start + rows]
        count(_look_up(image, m, kernels, matrices[start:start + rows]), m, kernels, part)
        part /= np.maximum(part @ np.ones((m, 1), np.float32), 1e-9)  # the product is three times as fast as sum(-1)
    return q


def _check(image, m, kernels):
    """A number beyond m would be counted in foreign memory."""
    if not (isinstance(image, np.ndarray) and image.ndim == 2 and image.size and max(image.shape) <= LONGEST and image.dtype in (np.uint8, np.uint16)):
        raise ValueError(f"image must be (H, W) bin numbers, uint8 or uint16, from 1 to {LONGEST} px a side; make it from a frame with ColorBins")
    if not image.max() < m <= np.iinfo(image.dtype).max:
        raise ValueError(f"m is {m}, but the image has bin numbers up to {image.max()}, as {image.dtype}; give the m of the ColorBins that made it")
    if len(kernels.points) > LONGEST:
        raise ValueError(f"samples is {kernels.samples}, too many; take at most {LONGEST}")


def _chunk(kernels):
    """Regions a chunk: as many as the processor's cache holds labels and positions of, and kernel numbers that fit uint8."""
    j, n = kernels.weights.shape
    cached = max(130_000 // n, 1)
    return cached if kernels.parts is None else max(min(cached, 255 // j), 1)


def sample(image, m, kernels, region):
    """Bin number under every sample point of one region (5,), m where it lies outside the image.  Returns (n,)."""
    return _look_up(image, m, kernels, _finite_matrices(region[None]))[0]


def _finite_matrices(regions):
    """The maps (N, 2, 3) from canonical points to the image; what is not finite, or nearly so, goes far outside."""
    matrices = warp_matrices(regions)
    near = np.abs(matrices) < FAR
    if not near.all():
        matrices[~near] = -1e6
    return matrices.astype(np.float32)


def _look_up(image, m, kernels, matrices):
    """Bin numbers under the sample points, (k, n), for maps (k, 2, 3); the next call overwrites them."""
    x, y, labels = _room(get_ident(), len(matrices), len(kernels.points), image.dtype)
    np.matmul(matrices[:, 0], kernels.homogeneous, out=x)
    np.matmul(matrices[:, 1], kernels.homogeneous, out=y)
    return cv2.remap(image, x, y, cv2.INTER_NEAREST, labels, cv2.BORDER_CONSTANT, m)


@lru_cache(maxsize=32)
def _room(_thread, k, n, dtype):
    """Arrays to work in, kept: asking the system for fresh memory for every chunk can take longer than the work itself."""
    return np.empty((k, n), np.float32), np.empty((k, n), np.float32), np.empty((k, n), dtype)


def _counted(labels, m, kernels, out):
    """Histograms for constant weights, unnormalised: labels (k, n) -> out (k, J, m)."""
    k, j = len(labels), len(kernels.weights)
    number = _numbers(kernels, labels.dtype)[:k]
    cv2.calcHist([number, labels], [0, 1], None, [k * j, m], [0, k * j, 0, m], out.reshape(k * j, m))


@lru_cache(maxsize=64)
def _numbers(kernels, dtype):
    """The kernel that each sample of a whole chunk counts for, numbered through the chunk.  Returns (chunk, n)."""
    j = len(kernels.weights)
    return (kernels.parts + j * np.arange(_chunk(kernels))[:, None]).astype(dtype)


def _weighted(labels, m, kernels, out):
    """Histograms for any weights, unnormalised: labels (k, n) -> out (k, J, m), as one product of a sparse matrix with K."""
    k, n = labels.shape
    rows = (labels.T + (m + 1) * np.arange(k, dtype=np.int32)).ravel()
    ones = np.ones(rows.size, np.float32)
    membership = csc_matrix((ones, rows, np.arange(0, rows.size + 1, k, dtype=np.int32)), shape=(k * (m + 1), n))
    counts = membership @ kernels.weights.T.astype(np.float32)
    out[:] = counts.reshape(k, m + 1, -1)[:, :m].swapaxes(1, 2)


def coefficient(q, reference):
    """Bhattacharyya coefficient rho = sum_u sqrt(q_u q*_u) in [0, 1]: (3) of [T09], (5) of [N03], (7) of [C14].

    q: (..., m) and reference: broadcastable to it, each of sum 1 or all zero.  Returns (...).

    >>> coefficient([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.0, 0.0, 1.0]], [0.5, 0.5, 0.0]).round(9)  # all alike, half, nothing
    array([1. , 0.5, 0. ])
    """
    return np.einsum("...m,...m->...", np.sqrt(q), np.sqrt(reference))


def distance(rho, axis=None):
    """Bhattacharyya distance d = sqrt(1 - rho), (4) of [T09]; over an axis of kernels d_m = sqrt(mean_j d_j^2), our reading of (5).

    rho: (...) coefficients; axis: that of the kernels, or None.  Returns distances in [0, 1]; never NaN, rounding is clipped.
    """
    d2 = np.maximum(1.0 - np.asarray(rho, float), 0.0)
    return np.sqrt(d2 if axis is None else d2.mean(axis))


def log_likelihood(rho, lam=20.0, combine="sum"):
    """ln p(z | x) = -lam sum_j d_j^2 up to a constant: (13) of [T09], (9) of [C14]; with lam = 1 / (2 sigma^2) also (10) of [N03].

    rho: (..., J) coefficients; lam: 20 as printed; combine: "sum" over the kernels, or their "mean", which is flatter.  Returns (...).
    """
    return -lam * getattr(np, combine)(np.maximum(1.0 - np.asarray(rho, float), 0.0), axis=-1)


class Target(NamedTuple):
    """The reference: how the object is looked at (`bins`, `kernels` fitted to it) and what was seen, q* (J, m)."""

    bins: ColorBins
    kernels: Kernels
    q: np.ndarray

    def coefficients(self, image, regions):
        """Bhattacharyya coefficients of regions (N, 5) with the reference.  image: (H, W) bins of the frame.  Returns (N, J)."""
        return coefficient(histograms(image, self.bins.m, self.kernels, regions), self.q)

    def distances(self, image, regions):
        """d_m of regions (..., 5) [px, rad] to the reference, over all kernels, (5) of [T09].  Returns (...) in [0, 1]."""
        regions = np.asarray(regions, float)
        rho = self.coefficients(image, regions.reshape(-1, 5))
        return distance(rho, axis=-1).reshape(regions.shape[:-1])


def learn(image, region, bins, kernels):
    """Take the object inside a region (5,) as the reference.  image: (H, W) bins of the frame.  Returns a `Target`.

    Raises ValueError for a region that is not finite or has no area, and where a kernel sees nothing of the image, since such a part could
    never be found again.
    """
    region = checked(region)
    fitted = kernels.fitted(region)
    q = histograms(image, bins.m, fitted, region)[0]
    if not q.any(-1).all():
        raise ValueError(f"part of the region {np.round(region, 1)} lies outside the image; choose a box inside it")
    return Target(bins, fitted, q)
