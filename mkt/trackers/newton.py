"""Gauss-Newton steps on kernels: the optimiser of Section III of [T09].

After Hager, Dewan and Stewart.  The sum of squared differences ``O(x) = |sqrt(q*) -
sqrt(q(x))|^2``, (6), is minimised by Gauss-Newton steps, (9):

    Delta x = -2 J_U^+ e,                e = sqrt(q(x)) - sqrt(q*),
    J_U = d(q)^(-1/2) [U^T J_K1; ...; U^T J_K9].

The step is taken in the *object's* frame: a shift (tau_x, tau_y) in the object plane, a
turn and a factor on the size.  There the kernels and their derivatives J_K are
constants, so an iteration is one look-up, one weighted count and a 4 x 4 solve.

The tracker that does nothing else is `mkt.trackers.ssd.SSD`.  Explained in notebook 04.
"""

from functools import lru_cache
from math import cos, exp, inf, isfinite, sin, sqrt
from threading import get_ident
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_matrix

from mkt.checks import in_words, locked
from mkt.colors import BinImage
from mkt.histograms import (
    Target,
    coefficient,
    distance,
    sample,
    turned_once,
)
from mkt.homographies import angles, turning
from mkt.kernels import Kernels
from mkt.regions import HX, HY, THETA, wrap_angle
from mkt.types import Array, NDArray, Region

EMPTY = 1e-6  # bins with less carry no first-order information: zero rows of J_U
FLAT = 1e-3  # share of the largest curvature of O below which a direction gets no step
LARGEST_STEP = 0.5  # of a component of Delta x, in object units, radians and log size
# Of a prior's weights: beside ten times as much, what O sees of a place is flat.
HEAVIEST = 1e4
SHORT = 1e-2  # a step below this ends the iteration, in the same units
TRUST = 8  # power of rho_j in the trust of a kernel; ours, with `robust`


class Template(NamedTuple):
    """What a step needs and no frame changes.

    There are P pairs of a sample and a kernel that sees it.

    Attributes
    ----------
    sample, kernel : (P,) int arrays
        Their indices.
    columns : (P, 5) array
        The weight K and its derivatives by tau_x, tau_y, theta and log s, with C held
        fixed.
    """

    sample: NDArray
    kernel: NDArray
    columns: Array


@lru_cache(maxsize=64)
def template(kernels: Kernels) -> Template:
    """Weights and slopes of kernels, for `differentiate`.

    With p a point of the object plane: dK/dtau = -grad K, dK/dtheta = K_x p_y - K_y
    p_x, dK/dlog s = -p . grad K.
    """
    weights, (kx, ky) = kernels.weights, kernels.slopes
    x, y = (kernels.points * kernels.half_sides).T
    columns = np.stack([weights, -kx, -ky, kx * y - ky * x, -(x * kx + y * ky)], -1)
    kernel, sample = np.nonzero(weights)
    pairs = np.ascontiguousarray(columns[kernel, sample])
    return Template(locked(sample), locked(kernel), locked(pairs))


def count(target: Target, labels: NDArray, columns: Array) -> Array:
    """Weighted histograms of the bins under the samples, for several weights at once.

    How, and what was tried for five columns of 2,844 pairs and 110 bins (CPU time on
    one thread): a sparse matrix, one 1 for each pair, times the columns, its structure
    kept and its row numbers exchanged: 46 us.  Slower: one ``np.bincount`` over a
    combined index of all columns (58), one for each column (68), the same product with
    a fresh matrix (96) or over samples and 45 columns (95), sorted sums (218), a dense
    one-hot product (291).  For 4,774 pairs in two layers, on a slower machine, it is 60
    us with the row numbers of one layer after the other, and 118 with all at once.

    Parameters
    ----------
    target : Target
    labels : (n,) or (L, n) array
        Bins, of `mkt.histograms.sample`.
    columns : (P, k) array
        Weights for the pairs of a `Template`.

    Returns
    -------
    (J, m, k) array
    """
    pairs = template(target.kernels)
    m = target.m
    layers = np.atleast_2d(labels)
    shape = len(target.q) * (m + 1), len(pairs.sample)
    rows = np.empty((shape[1], len(layers)), np.int32)
    offsets = _offsets(target.kernels, m)
    for k, layer in enumerate(layers):
        np.add(layer[pairs.sample], offsets, out=rows[:, k])
    membership = _membership(get_ident(), len(layers), shape)
    membership.indices = rows.ravel()
    return (membership @ columns).reshape(len(target.q), m + 1, -1)[:, :m]


@lru_cache(maxsize=64)
def _membership(_thread, layers: int, shape: tuple[int, int]) -> csc_matrix:
    """A matrix with `layers` ones in a column, whose row numbers `count` exchanges."""
    size = layers * shape[1]
    start = np.arange(0, size + 1, layers, dtype=np.int32)
    return csc_matrix((np.ones(size), np.zeros(size, np.int32), start), shape=shape)


@lru_cache(maxsize=64)
def _offsets(kernels: Kernels, m: int) -> NDArray:
    """Where the bins of each pair's kernel begin, (P,)."""
    return ((m + 1) * template(kernels).kernel).astype(np.int32)


def _counts(target: Target, image: BinImage, region: Region, columns: Array) -> Array:
    """`count` in a region (5,), or under a homography (3, 3), of an image.

    Each bin is multiplied by its share, and directions are counted from the region's
    own axis.  Because they turn with the region, the derivative by theta has a further
    term, and so has that by whatever else turns a homography.
    """
    counts = count(target, sample(image, target.kernels, region), columns)
    if image.shares is not None:
        counts *= np.repeat(image.shares, columns.shape[1]).reshape(target.m, -1)
    for first, n in image.compasses:
        theta = float(angles(region[None])[0])
        slope = turned_once(counts, theta, (first, n))
        if columns.shape[1] == 1:
            continue
        if region.ndim == 1:
            counts[:, first : first + n, 1 + THETA] += slope[..., 0]
        else:
            turns = turning(region, target.kernels.half_sides, columns.shape[1] - 1)
            counts[:, first : first + n, 1:] += slope[..., :1] * turns
    return counts


def differentiate(
    target: Target,
    image: BinImage,
    region: Array,
    derivative_of_c: bool = True,
    columns: Array | None = None,
) -> tuple[Array, Array]:
    """Histograms at a region and their derivatives by (tau_x, tau_y, theta, log s).

    The quotient rule for q = counts / total brings in the derivative of C in (8),
    without which the size column is more than half wrong.

    Parameters
    ----------
    target : Target
    image : BinImage
    region : (5,) array [px, rad]
    derivative_of_c : bool
        False holds C fixed, as the line after (10) may suggest.
    columns : (P, 1 + k) array, optional
        Weights and slopes under another motion, for the pairs of the `Template`.  The
        region may then be a homography, see `mkt.trackers.homography`.

    Returns
    -------
    q : (J, m) array
    dq : (J, m, 4) array, or (J, m, k)
    """
    if columns is None:
        columns = template(target.kernels).columns
    counts = _counts(target, image, region, columns)
    total = np.maximum(counts[..., 0].sum(-1), EMPTY)
    normalised = counts / total[:, None, None]
    q, dq = normalised[..., 0], normalised[..., 1:]
    if derivative_of_c:
        sums = np.einsum("jmk->jk", dq)  # in a third of the time of dq.sum(1)
        dq = dq - q[..., None] * sums[:, None]
    return q, dq


def is_weight(value: float) -> bool:
    """Whether a component of a `Prior` can have this weight, if it may change."""
    return 0 <= value <= HEAVIEST


class Prior(NamedTuple):
    """What is known of the region before the frame is looked at: a term of O(x).

    The sum ``sum_i lambda_i (x_i - x_i*)^2`` is added to the sum of squares: with O as
    minus the logarithm of a likelihood, its minimum is the most probable region a
    posteriori (MAP), and the step is that of Levenberg, whose damping pulls to a place.

    Attributes
    ----------
    region : (5,) array [px, rad]
        The most probable one, x*.
    weights : (4,) array
        lambda for tau_x, tau_y, theta and log s, in object units and radians; infinite
        for a component that must not change, and otherwise `HEAVIEST` at most.
    """

    region: Region
    weights: Array

    def check(self) -> None:
        """Refuse a region that is none, and weights that are not four, from 0 on.

        It looks at plain numbers, as `moved` does: numpy's functions, and with them
        `mkt.checks.checked_region`, cost more for so few.
        """
        if np.shape(self.region) != (5,):
            raise ValueError(
                f"region has the shape {np.shape(self.region)}; "
                "a prior needs one region (cx, cy, theta, hx, hy)"
            )
        numbers = np.asarray(self.region, float).tolist()
        hx, hy = numbers[HX:]
        if not (all(map(isfinite, numbers)) and min(hx, hy, hx * hy) > 0):
            raise ValueError(
                f"region is {in_words(numbers)}; "
                "give the prior finite numbers, and half axes above 0"
            )
        four = np.shape(self.weights) == (4,)
        weights = np.asarray(self.weights).tolist()
        if not (four and all(w == inf or is_weight(w) for w in weights)):
            raise ValueError(
                f"weights are {self.weights}; a prior needs four from 0 to "
                f"{HEAVIEST:g}, or infinite, for tau_x, tau_y, theta and log s"
            )

    def off(self, regions: Array) -> Array:
        """The offsets x - x* of regions (..., 5), in their own frames: (..., 4)."""
        cx, cy, theta, hx, hy = np.asarray(self.region).tolist()
        x, y, angle, wide, high = regions.T
        dx, dy = (x - cx) / sqrt(hx * hy), (y - cy) / sqrt(hx * hy)
        s, c = np.sin(angle), np.cos(angle)
        turn = wrap_angle(angle - theta)
        growth = 0.5 * np.log(wide * high / (hx * hy))
        return np.array([c * dx + s * dy, c * dy - s * dx, turn, growth]).T

    def cost(self, regions: Array) -> Array:
        """The term at regions (..., 5), without components that are fixed: (...)."""
        weights = np.where(np.isfinite(self.weights), self.weights, 0)
        return self.off(regions) ** 2 @ weights


def newton_step(
    q: Array,
    dq: Array,
    reference: Array,
    trust: Array | None = None,
    pull: tuple[Array, Array] | None = None,
) -> Array:
    """Delta x = -2 J_U^+ e, (9): the Gauss-Newton step.

    Its components are those of dq: (tau_x, tau_y, theta, log s), or more.  Rows of
    empty bins are zero; directions without curvature, such as the orientation under one
    round kernel, get no step.

    Parameters
    ----------
    q, reference : (J, m) array
    dq : (J, m, 4) array
        Of `differentiate`.
    trust : (J,) array, optional
        Weights of the kernels in the sum of squares; all equal by default.
    pull : (lambda, offset), two (4,) arrays, optional
        Of a `Prior`: its weights, and how far x is from where it expects it.  With
        J = J_U / 2, the derivative of e, the step solves
        (J^T J + diag(lambda)) Delta x = -(J^T e + lambda offset).

    Returns
    -------
    (4,) array

    Raises
    ------
    ValueError
        For a reference of other kernels or bins than q.
    """
    if reference.shape != q.shape:
        raise ValueError(
            f"reference has the shape {reference.shape} and q {q.shape}; "
            "both must be of the same kernels and bins"
        )
    seen = np.flatnonzero(q > EMPTY)
    root = np.sqrt(q.ravel()[seen])
    jacobian = dq.reshape(-1, dq.shape[-1]).take(seen, 0) / root[:, None]
    error = root - np.sqrt(reference.ravel()[seen])
    weighted = jacobian
    if trust is not None:
        weighted = jacobian * trust[seen // q.shape[1], None]
    normal, slope = weighted.T @ jacobian, error @ weighted
    if pull is not None:
        known = np.isfinite(pull[0])
        weights = np.where(known, pull[0], 0)
        normal *= known & known[:, None]
        normal.flat[:: len(known) + 1] += 4 * weights
        slope = slope * known + 2 * weights * pull[1]
    curvature, directions = np.linalg.eigh(normal)
    flat = np.searchsorted(curvature, FLAT * curvature[-1], side="right")
    directions, curvature = directions[:, flat:], curvature[flat:]
    return -2 * directions @ (directions.T @ slope / curvature)


def moved(region: Region, step: Array) -> Region:
    """A region after a step in its own frame.

    ``c += s R(theta) tau, theta += dtheta, s *= exp(dlog s)``, each component of the
    step bounded by `LARGEST_STEP`.

    Parameters
    ----------
    region : (5,) array [px, rad]
    step : (4,) array
    """
    cx, cy, theta, hx, hy = region.tolist()
    bounded = np.minimum(np.maximum(step, -LARGEST_STEP), LARGEST_STEP)
    tau_x, tau_y, turn, growth = bounded.tolist()
    # Plain numbers: for four of them numpy's functions cost ten times as much.
    s, c = sin(theta), cos(theta)
    size = sqrt(hx * hy)
    factor = exp(growth)
    cx += size * (c * tau_x - s * tau_y)
    cy += size * (s * tau_x + c * tau_y)
    return np.array([cx, cy, theta + turn, factor * hx, factor * hy])


def newton_path(
    target: Target,
    image: BinImage,
    start: Region,
    steps: int,
    derivative_of_c: bool = True,
) -> Array:
    """Regions (steps + 1, 5) from a start (5,), one step (9) after the other.

    Raises
    ------
    ValueError
        As `minimise` does.
    """
    regions = [_checked_start(target, image, start)]
    for _ in range(steps):
        step = _step(target, image, regions[-1], derivative_of_c)
        regions.append(moved(regions[-1], step))
    return np.array(regions)


def _checked_start(target: Target, image: BinImage, start: Region) -> Region:
    """The start, if it is a region with an area, in an image of the target's bins.

    What is not finite leads nowhere.
    """
    target.check(image)
    region = np.asarray(start, float)
    if region.shape != (5,) or region[HX] <= 0 or region[HY] <= 0:
        raise ValueError(
            f"start is {in_words(region)}; the optimiser needs one region (cx, cy, "
            "theta, hx, hy) with half axes above 0"
        )
    return region


def _step(
    target: Target,
    image: BinImage,
    region: Region,
    derivative_of_c: bool,
    robust: bool = False,
    prior: Prior | None = None,
) -> Array:
    """The step (4,) from a region, see `minimise`."""
    q, dq = differentiate(target, image, region, derivative_of_c)
    trust = _trust(target, q, robust)
    pull = None if prior is None else (prior.weights, prior.off(region))
    return newton_step(q, dq, target.q, trust, pull)


def minimise(
    target: Target,
    image: BinImage,
    start: Region,
    iterations: int,
    derivative_of_c: bool = True,
    robust: bool = False,
    prior: Prior | None = None,
) -> tuple[Region, int]:
    """Repeat the step until it is shorter than `SHORT`.

    Parameters
    ----------
    target : Target
    image : BinImage
    start : (5,) array [px, rad]
    iterations : int
        Steps at most.
    derivative_of_c : bool
        See `differentiate`.
    robust : bool
        Trust each kernel according to its likeness, rho_j^8, so that hidden parts of
        the object do not pull.
    prior : Prior, optional
        A further term of O(x).

    Returns
    -------
    region : (5,) array [px, rad]
    steps : int
        How many were taken.

    Raises
    ------
    ValueError
        For an image with other bins than the target's, for a start that is no region or
        has no area, and for such a prior, or one whose weights are not four that it can
        have.
    """
    region = _checked_start(target, image, start)
    if prior is not None:
        prior.check()
    steps = 0
    short = False
    while steps < iterations and not short:
        step = _step(target, image, region, derivative_of_c, robust, prior)
        region = moved(region, step)
        short = np.abs(step).max() < SHORT
        steps += 1
    return region, steps


def _trust(target: Target, q: Array, robust: bool) -> Array | None:
    """The weights of the kernels in the sum, None where all count alike."""
    if robust:
        return coefficient(q, target.q) ** TRUST  # 0 for what is not learnt
    if target.learnt is None:
        return None
    return np.isin(np.arange(len(q)), target.learnt).astype(float)


def distance_at(target: Target, image: BinImage, region: Region) -> float:
    """d_m at a region (5,) or homography (3, 3), counted as the optimiser counts.

    For one of them that is faster than `mkt.histograms.Target.distances`.
    """
    columns = template(target.kernels).columns[:, :1]
    counts = _counts(target, image, region, columns)[..., 0]
    q = counts / np.maximum(counts.sum(-1, keepdims=True), EMPTY)
    rho = coefficient(q, target.q)
    return float(distance(rho if target.learnt is None else rho[target.learnt], -1))
