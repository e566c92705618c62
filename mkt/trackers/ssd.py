"""Multiple kernel tracking with SSD: the deterministic framework, Section III of [T09] (after Hager, Dewan and Stewart).

The sum of squared differences O(x) = |sqrt(q*) - sqrt(q(x))|^2, (6), is minimised by Gauss-Newton steps, (9):

    Delta x = -2 J_U^+ e,        e = sqrt(q(x)) - sqrt(q*),        J_U = d(q)^(-1/2) [U^T J_K1; ...; U^T J_K9].

The step is taken in the *object's* frame: a shift (tau_x, tau_y) in the object plane, a turn and a factor on the size.  There the
kernels and their derivatives J_K are constants, so an iteration is one look-up, one weighted count and a 4 x 4 solve.

Explained in notebook 04.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import cos, exp, sin, sqrt
from typing import NamedTuple

import numpy as np

from mkt.histograms import ColorBins, Target, coefficient, distance, learn, sample
from mkt.kernels import Kernels
from mkt.regions import checked
from mkt.tracking import check_counts, report


EMPTY = 1e-6  # bins with less than this carry no first-order information: their rows of J_U are zero
FLAT = 1e-3  # directions in which O curves less than this fraction of its most curved one are left alone
LARGEST_STEP = 0.5  # of a component of Delta x, in object units, radians and log size


class Template(NamedTuple):
    """What a step needs and no frame changes, for the P pairs of a sample and a kernel that sees it.

    sample, kernel: (P,) indices; columns: (5, P), the weight K and its derivatives by tau_x, tau_y, theta and log s, C held fixed.
    """

    sample: np.ndarray
    kernel: np.ndarray
    columns: np.ndarray


@lru_cache(maxsize=64)
def template(kernels):
    """Weights and slopes of `Kernels` as a `Template`.

    With p a point of the object plane: dK/dtau = -grad K, dK/dtheta = K_x p_y - K_y p_x, dK/dlog s = -p . grad K.
    """
    weights, (kx, ky) = kernels.weights, kernels.slopes
    x, y = (kernels.points * kernels.half_sides).T
    columns = np.stack([weights, -kx, -ky, kx * y - ky * x, -(x * kx + y * ky)])
    kernel, sample = np.nonzero(weights)
    return Template(sample, kernel, np.ascontiguousarray(columns[:, kernel, sample]))


def count(target, labels, columns):
    """Weighted histograms of the bins labels (n,) under the samples, one for each column of weights (k, P).  Returns (k, J, m)."""
    m, j, pairs = target.bins.m, len(target.q), template(target.kernels)
    place = labels[pairs.sample] + (m + 1) * pairs.kernel
    return np.stack([np.bincount(place, column, j * (m + 1)) for column in columns]).reshape(-1, j, m + 1)[..., :m]


def differentiate(target, image, region, derivative_of_c=True):
    """Histograms at a region and their derivatives by (tau_x, tau_y, theta, log s).

    image: (H, W) bins; region: (5,).  Returns q (J, m) and dq (4, J, m).  The quotient rule for q = counts / total brings in the derivative
    of C in (8), without which the size column is more than half wrong; derivative_of_c=False leaves it out, as a literal reading might.
    """
    labels = sample(image, target.bins.m, target.kernels, region)
    counts = count(target, labels, template(target.kernels).columns)
    total = np.maximum(counts[0].sum(-1, keepdims=True), EMPTY)
    q, dq = counts[0] / total, counts[1:] / total
    return q, dq - q * dq.sum(-1, keepdims=True) if derivative_of_c else dq


def newton_step(q, dq, reference, trust=None):
    """Delta x = -2 J_U^+ e, (9): the Gauss-Newton step for (tau_x, tau_y, theta, log s).

    q, reference: (J, m); dq: (4, J, m); trust: (J,) weights of the kernels in the sum of squares, all equal by default.  Returns (4,).
    Rows of empty bins are zero; directions without curvature, such as the orientation under one round kernel, get no step.
    """
    seen = np.flatnonzero(q > EMPTY)
    root = np.sqrt(q.ravel()[seen])
    jacobian, error = dq.reshape(4, -1).take(seen, 1) / root, root - np.sqrt(reference.ravel()[seen])
    weighted = jacobian if trust is None else jacobian * trust[seen // q.shape[1]]
    curvature, directions = np.linalg.eigh(weighted @ jacobian.T)
    flat = np.searchsorted(curvature, FLAT * curvature[-1], side="right")
    directions, curvature = directions[:, flat:], curvature[flat:]
    return -2 * directions @ (directions.T @ (weighted @ error) / curvature)


def moved(region, step):
    """A region (5,) after a step (4,) taken in its own frame: c += s R(theta) tau, theta += dtheta, s *= exp(dlog s)."""
    cx, cy, theta, hx, hy = region.tolist()
    tau_x, tau_y, turn, growth = np.minimum(np.maximum(step, -LARGEST_STEP), LARGEST_STEP).tolist()
    size, c, s, factor = sqrt(hx * hy), cos(theta), sin(theta), exp(growth)
    return np.array([cx + size * (c * tau_x - s * tau_y), cy + size * (s * tau_x + c * tau_y), theta + turn, factor * hx, factor * hy])


def minimise(target, image, start, iterations, derivative_of_c=True, tolerance=1e-2, robust=False):
    """Repeat the step from a region (5,) until it is shorter than the tolerance.

    robust: trust each kernel by its likeness, rho_j^8, so that hidden parts of the object do not pull.
    Returns the region, its distance d_m as it was before the last step, and the number of steps.
    """
    region = np.asarray(start, float)
    for k in range(1, iterations + 1):
        q, dq = differentiate(target, image, region, derivative_of_c)
        rho = coefficient(q, target.q)
        step = newton_step(q, dq, target.q, rho**8 if robust else None)
        region = moved(region, step)
        if np.abs(step).max() < tolerance:
            break
    return region, float(distance(rho, axis=-1)), k


@dataclass(frozen=True)
class SSD:
    """The deterministic tracker: in every frame, minimise from the last estimate.

    kernels: nine Epanechnikov kernels, (10) of [T09]; spans: factors on their span, from coarse to fine, one pass each (the paper has one).
    iterations: steps a pass, at most; the paper says "a few".  derivative_of_c: see `differentiate`.
    lost_above: the distance d_m beyond which the target is said to be lost.  sizes: bounds on its size against the first frame.

    Raises ValueError naming the field.
    """

    kernels: Kernels = Kernels("3x3")
    spans: tuple[float, ...] = (1.0,)
    iterations: int = 10  # ours: the paper prints no number
    derivative_of_c: bool = True
    bins: ColorBins = ColorBins()
    lost_above: float = 0.65
    sizes: tuple[float, float] = (0.3, 3.0)

    def __post_init__(self):
        check_counts(self, "iterations")
        if not self.spans:
            raise ValueError("spans is empty; give at least one factor on the kernels' span, such as 1")
        if not 0 < self.sizes[0] <= self.sizes[1] < np.inf:
            raise ValueError(f"sizes is {self.sizes}; give a smaller and a larger positive factor")

    def init(self, frame, region, rng):
        """Learn the reference at every span.  Returns `SSDState`."""
        image, region = self.bins(frame), checked(region)
        targets = tuple(learn(image, region, self.bins, replace(self.kernels, span=span)) for span in self.spans)
        return SSDState(targets, region, np.sqrt(region[3] * region[4]))

    def step(self, state, frame, rng):
        """Minimise from the last estimate."""
        region, d, steps = self.refine(state, self.bins(frame), state.region)
        return state._replace(region=region), report(region, d, self.lost_above, steps=steps, evaluations=steps)

    def refine(self, state, image, start):
        """Minimise from any start (5,), span after span.  Returns the region, its distance d_m, and the number of steps."""
        region, steps = start, 0
        for target in state.targets:
            region, d, k = minimise(target, image, region, self.iterations, self.derivative_of_c)
            steps += k
        size = sqrt(region[3] * region[4])
        smallest, largest = (bound * state.size for bound in self.sizes)
        region[3:] *= min(max(size, smallest), largest) / size
        return region, d, steps


class SSDState(NamedTuple):
    """The references, one a span; the last estimate (5,); the size sqrt(hx hy) of the first one [px]."""

    targets: tuple[Target, ...]
    region: np.ndarray
    size: float
