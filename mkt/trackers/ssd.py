"""Multiple kernel tracking with SSD: the deterministic framework, Section III of [T09] (after Hager, Dewan and Stewart).

The sum of squared differences O(x) = |sqrt(q*) - sqrt(q(x))|^2, (6), is minimised by Gauss-Newton steps, (9):

    Delta x = -2 J_U^+ e,        e = sqrt(q(x)) - sqrt(q*),        J_U = d(q)^(-1/2) [U^T J_K1; ...; U^T J_K9].

The step is taken in the *object's* frame: a shift (tau_x, tau_y) in the object plane, a turn and a factor on the size.  There the
kernels and their derivatives J_K are constants, so an iteration is one look-up, one weighted count and a 4 x 4 solve.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from mkt.histograms import ColorBins, Target, coefficient, learn, sample
from mkt.kernels import Kernels
from mkt.regions import rotation
from mkt.tracking import report


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


def differentiate(target, image, region, derivative_of_c=True):
    """Histograms at a region and their derivatives by (tau_x, tau_y, theta, log s).

    image: (H, W) bins; region: (5,).  Returns q (J, m) and dq (4, J, m).  The quotient rule for q = counts / total brings in the derivative
    of C in (8), without which the size column is more than half wrong; derivative_of_c=False leaves it out, as a literal reading might.
    """
    m, (j, n) = target.bins.m, target.kernels.weights.shape
    pairs = template(target.kernels)
    labels = sample(image, m, target.kernels, region)
    place = labels[pairs.sample] + (m + 1) * pairs.kernel
    size = j * (m + 1)
    counts = np.bincount((place + size * np.arange(5)[:, None]).ravel(), pairs.columns.ravel(), 5 * size).reshape(5, j, m + 1)[..., :m]
    total = np.maximum(counts[0].sum(-1, keepdims=True), EMPTY)
    q, dq = counts[0] / total, counts[1:] / total
    return q, dq - q * dq.sum(-1, keepdims=True) if derivative_of_c else dq


def newton_step(q, dq, reference, trust=None):
    """Delta x = -2 J_U^+ e, (9): the Gauss-Newton step for (tau_x, tau_y, theta, log s).

    q, reference: (J, m); dq: (4, J, m); trust: (J,) weights of the kernels in the sum of squares, all equal by default.  Returns (4,).  Rows of empty bins are zero; directions without curvature, such as the
    orientation under one round kernel, get no step.
    """
    root = np.sqrt(q)
    jacobian = np.divide(dq, root, out=np.zeros_like(dq), where=q > EMPTY)
    error = root - np.sqrt(reference)
    if trust is not None:
        jacobian, error = jacobian * np.sqrt(trust)[:, None], error * np.sqrt(trust)[:, None]
    jacobian, error = jacobian.reshape(4, -1), error.ravel()
    curvature, directions = np.linalg.eigh(jacobian @ jacobian.T)
    kept = directions[:, curvature > FLAT * curvature[-1]]
    return -2 * kept @ ((kept.T @ (jacobian @ error)) / curvature[curvature > FLAT * curvature[-1]])


def moved(region, step):
    """A region (5,) after a step (4,) taken in its own frame: c += s R(theta) tau, theta += dtheta, s *= exp(dlog s)."""
    tau_x, tau_y, turn, growth = np.clip(step, -LARGEST_STEP, LARGEST_STEP)
    size = np.sqrt(region[3] * region[4])
    centre = region[:2] + size * rotation(region[2]) @ [tau_x, tau_y]
    return np.concatenate([centre, [region[2] + turn], region[3:] * np.exp(growth)])


def minimise(target, image, start, iterations, derivative_of_c=True, tolerance=1e-2, robust=False):
    """Repeat the step from a region (5,) until it is shorter than the tolerance.  Returns the region and the number of steps.

    robust: trust each kernel by its likeness, rho_j^8, so that hidden parts of the object do not pull.
    """
    region = np.asarray(start, float)
    for k in range(1, iterations + 1):
        q, dq = differentiate(target, image, region, derivative_of_c)
        step = newton_step(q, dq, target.q, coefficient(q, target.q) ** 8 if robust else None)
        region = moved(region, step)
        if np.abs(step).max() < tolerance:
            break
    return region, k


@dataclass(frozen=True)
class SSD:
    """The deterministic tracker: in every frame, minimise from the last estimate.

    kernels: nine Epanechnikov kernels, (10) of [T09]; spans: factors on their span, from coarse to fine, one pass each (the paper has one).
    iterations: steps a pass, at most; the paper says "a few".  derivative_of_c: see `differentiate`.
    lost_above: the distance d_m beyond which the target is said to be lost.  sizes: bounds on its size against the first frame.
    """

    kernels: Kernels = Kernels("3x3")
    spans: tuple[float, ...] = (1.0,)
    iterations: int = 10  # ours: the paper prints no number
    derivative_of_c: bool = True
    bins: ColorBins = ColorBins()
    lost_above: float = 0.65
    sizes: tuple[float, float] = (0.3, 3.0)

    def init(self, frame, region, rng):
        """Learn the reference at every span.  Returns `SSDState`."""
        image = self.bins(frame)
        targets = tuple(learn(image, region, self.bins, replace(self.kernels, span=span)) for span in self.spans)
        return SSDState(targets, np.asarray(region, float), np.sqrt(region[3] * region[4]))

    def step(self, state, frame, rng):
        """Minimise from the last estimate."""
        region, distance, steps = self.refine(state, self.bins(frame), state.region)
        return state._replace(region=region), report(region, distance, self.lost_above, steps=steps, evaluations=steps + 1)

    def refine(self, state, image, start):
        """Minimise from any start (5,), span after span.  Returns the region, its distance d_m, and the number of steps."""
        region, steps = start, 0
        for target in state.targets:
            region, k = minimise(target, image, region, self.iterations, self.derivative_of_c)
            steps += k
        factor = np.clip(np.sqrt(region[3] * region[4]) / state.size, *self.sizes) * state.size / np.sqrt(region[3] * region[4])
        region = np.concatenate([region[:3], region[3:] * factor])
        return region, float(state.targets[-1].distances(image, region)), steps


class SSDState(NamedTuple):
    """The references, one a span; the last estimate (5,); the size sqrt(hx hy) of the first one [px]."""

    targets: tuple[Target, ...]
    region: np.ndarray
    size: float
