"""Multiple kernel tracking of a plane in space: SSD on a homography's parameters.

Equations (6) to (9) of [T09], for the motion that its authors name and do not write
down.  The kernels stay where they are in the object plane and so do their weights; the
homography H carries their samples p into the image,

    q_u(H) = int K(p) [b(H p) = u] dp.

A step is taken in the object plane, H <- H exp(A) with A = sum_i x_i G_i.  Substitute
p' = exp(A) p: what moves now is the kernel over a fixed picture, with the determinant
of the map that brought it there, and the derivative at x = 0 is

    dq_u / dx_i = int -div(K v_i)(p) [b(H p) = u] dp,
    div(K v_i)  = grad K . v_i + K div v_i,

with v_i(p) the velocity of p under G_i.  It needs neither H nor the frame: one
`Template` serves all frames, as in `mkt.trackers.newton`.  Where div v_i is constant,
as for a change of size, the second term is what the derivative of C brings in.

A group is a number of generators, so the similarity and the affine map are the first
four and the first six columns of the same template.

Explained in notebook 16.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from mkt import checks
from mkt.checks import checked_region, locked
from mkt.colors import BinImage, Bins, ColorBins, binned, of_bins
from mkt.histograms import Target, coefficient, learn
from mkt.homographies import (
    GROUPS,
    as_region,
    flow,
    moved,
    of_regions,
    slope_at_middle,
)
from mkt.kernels import Kernels, of_kernels
from mkt.regions import SQUARE
from mkt.trackers.newton import (
    EMPTY,
    LARGEST_STEP,
    SHORT,
    TRUST,
    differentiate,
    distance_at,
    newton_step,
    template,
)
from mkt.tracking import Info, report
from mkt.types import Array, Frame, Region, Rng

# A step below this ends an earlier pass, from which the next one goes on (`SHORT` ends
# the last).  On the cards of the tuning seeds .05 takes 4 to 6 steps a frame where .01
# takes 10 to 12, and is as exact: it converges in 84 % of the starts of all kinds (.01:
# 82, .1: 83, .2: 75).
NEARLY = 5e-2
NEAREST = 0.3  # of the distances of the corners, as a share of that of the middle


def columns_at(weights: Array, slopes: Array, points: Array, k: int) -> Array:
    """Weights and their derivatives -div(K v_i) by the first k parameters.

    Parameters
    ----------
    weights : (J, n) array
        K of every kernel at every point.
    slopes : (2, J, n) array
        grad K.
    points : (n, 2) array
        In the object plane.
    k : int

    Returns
    -------
    (1 + k, J, n) array
    """
    v, divergence = flow(points, k)
    along = np.einsum("cjn,inc->ijn", slopes, v)
    return np.concatenate([weights[None], -along - weights * divergence[:, None]])


@lru_cache(maxsize=64)
def columns(kernels: Kernels, group: str) -> Array:
    """`columns_at` the samples of kernels, (pairs, 1 + k), see `Template`.

    Raises
    ------
    ValueError
        For an unknown group.
    """
    checks.check_known("group", group, GROUPS)
    points = kernels.points * kernels.half_sides
    dense = columns_at(kernels.weights, kernels.slopes, points, GROUPS[group])
    pairs = template(kernels)
    return locked(np.ascontiguousarray(dense[:, pairs.kernel, pairs.sample].T))


def step_from(target: Target, image: BinImage, homography: Array, group: str) -> Array:
    """The Gauss-Newton step (9) on the parameters of a group, (k,).

    Each kernel is trusted according to its likeness, rho_j^8, as in
    `mkt.trackers.newton`, so that hidden parts of the object do not pull.

    Parameters
    ----------
    target : Target
    image : BinImage
    homography : (3, 3) array
    group : str
        One of `mkt.homographies.GROUPS`.
    """
    by = columns(target.kernels, group)
    q, dq = differentiate(target, image, homography, columns=by)
    return newton_step(q, dq, target.q, coefficient(q, target.q) ** TRUST)


def minimise(
    target: Target,
    image: BinImage,
    start: Array,
    iterations: int,
    group: str,
    short: float = SHORT,
) -> tuple[Array, int]:
    """Repeat the step until it is shorter than `short`, in object units.

    Parameters
    ----------
    target : Target
    image : BinImage
    start : (3, 3) array
        A homography.
    iterations : int
        Steps, at most.
    group : str
        One of `mkt.homographies.GROUPS`.
    short : float

    Returns
    -------
    homography : (3, 3) array
    steps : int
        How many were taken.
    """
    target.check(image)
    homography, half_sides = start, target.kernels.half_sides
    steps, done = 0, False
    while steps < iterations and not done:
        step = step_from(target, image, homography, group)
        bounded = np.clip(step, -LARGEST_STEP, LARGEST_STEP)
        homography = moved(homography, bounded, half_sides)
        done = np.abs(step).max() < short
        steps += 1
    return homography, steps


def jacobian(target: Target, image: BinImage, homography: Array, group: str) -> Array:
    """J_U / 2 over the root of the number of kernels, (rows, k), at a homography.

    So it is the derivative of the root of the mean of their d^2, and layouts of many
    kernels and of few can be compared.

    Parameters
    ----------
    target, image, homography, group
        As for `step_from`.
    """
    by = columns(target.kernels, group)
    q, dq = differentiate(target, image, homography, columns=by)
    seen = q > EMPTY
    return dq[seen] / np.sqrt(q[seen])[:, None] / (2 * len(q) ** 0.5)


def felt(target: Target, image: BinImage, homography: Array, group: str) -> Array:
    """How much of each parameter the kernels feel that no other explains, (k,).

    It is the length of what is left of a column of `jacobian` after a projection away
    from the others: 0 for a motion that looks like a mixture of other ones, or like
    nothing at all.  Raises as `columns` does.

    Parameters
    ----------
    target, image, homography, group
        As for `step_from`.
    """
    _, triangle = np.linalg.qr(jacobian(target, image, homography, group))
    left = [_last_diagonal(triangle, i) for i in range(triangle.shape[1])]
    return np.array(left)


def _last_diagonal(triangle: Array, i: int) -> float:
    """What is left of column i when all others come before it."""
    others = np.delete(triangle, i, axis=1)
    _, r = np.linalg.qr(np.column_stack([others, triangle[:, i]]))
    return float(abs(r[-1, -1]))


def plausible(homography: Array, first: Array) -> bool:
    """Whether a camera could see the object like this, given how it was seen at first.

    Both are homographies (3, 3).  No corner is at the horizon, and at its middle the
    object is at most four times as large as at first along any direction, and at least
    an eighth, which is a quarter of the size at a tilt of 60 degrees.
    """
    depths = SQUARE @ homography[2, :2] + homography[2, 2]
    now, then = (slope_at_middle(h) for h in (homography, first))
    sizes = np.linalg.svd(now @ np.linalg.inv(then), compute_uv=False)
    return bool(depths.min() > NEAREST and 1 / 8 < sizes[-1] and sizes[0] < 4)


class PlaneState(NamedTuple):
    """What is carried from frame to frame.

    Attributes
    ----------
    targets : tuple of Target
        The references, one for each pass.
    homography : (3, 3) array
        The last estimate.
    first : (3, 3) array
        That of the first frame.
    """

    targets: tuple[Target, ...]
    homography: Array
    first: Array


@dataclass(frozen=True)
class PlaneSSD:
    """The deterministic tracker of a plane: minimise from the last estimate.

    Its info has the homography (3, 3) besides the region that fits at its middle.

    Parameters
    ----------
    passes : tuple of Kernels
        From coarse to fine, one minimisation each.
    group : str
        One of `mkt.homographies.GROUPS`: how the object may move.
    iterations : int
        Steps in a pass, at most.
    bins : Bins
        What the frames are binned with.
    lost_above : float
        The distance d_m beyond which the target is said to be lost.

    Raises
    ------
    ValueError
        Naming the field.
    """

    # Chosen with the bins on the cards of the tuning seeds, from 15 px, 25 degrees and
    # 20 %: the fine pass alone converges less often, the coarse one less precisely,
    # and half the samples in the fine one, or finer bins, are less precise, too.
    passes: tuple[Kernels, ...] = (
        Kernels("3x3", samples=1600),
        Kernels("5x5", span=0.7, samples=4800),
    )
    group: str = "homography"
    iterations: int = 8
    bins: Bins = ColorBins("rgb", (5, 5, 5))
    lost_above: float = 0.65

    def __post_init__(self):
        of_bins(self.bins)
        checks.counts(self, "iterations")
        checks.numbers(self, "lost_above")
        checks.one_of(self, group=GROUPS)
        if not (isinstance(self.passes, tuple) and self.passes):
            raise ValueError(
                f"passes is {self.passes}; give a tuple with the kernels of at least "
                "one pass"
            )
        for kernels in self.passes:
            of_kernels(kernels, "passes")
            kernels.check_slopes()

    def init(self, frame: Frame, region: Region, rng: Rng) -> PlaneState:
        """Learn the reference for each pass, of an object that faces the camera."""
        image = binned(self.bins, frame)
        region = checked_region(region)
        targets = tuple(learn(image, region, kernels) for kernels in self.passes)
        first = of_regions(region)
        return PlaneState(targets, first, first)

    def step(
        self, state: PlaneState, frame: Frame, rng: Rng
    ) -> tuple[PlaneState, Info]:
        """Minimise from the last estimate."""
        image = binned(self.bins, frame)
        homography, d, steps = self.refine(state, image, state.homography)
        lost = d > self.lost_above
        info = plane_report(state, homography, d, lost, steps, steps=steps)
        return state._replace(homography=homography), info

    def refine(
        self, state: PlaneState, image: BinImage, start: Array
    ) -> tuple[Array, float, int]:
        """Minimise from any start (3, 3), pass after pass.

        If no camera could see the result, the start is returned instead.

        Returns
        -------
        homography : (3, 3) array
        distance : float
            Its d_m.
        steps : int
            How many were taken.
        """
        homography, steps = start, 0
        shorts = (*[NEARLY] * (len(state.targets) - 1), SHORT)
        for target, short in zip(state.targets, shorts, strict=True):
            homography, k = minimise(
                target, image, homography, self.iterations, self.group, short
            )
            steps += k
        if not plausible(homography, state.first):
            homography = start
        return homography, distance_at(state.targets[-1], image, homography), steps


def plane_report(
    state: PlaneState,
    homography: Array,
    d: float,
    lost: bool,
    evaluations: float,
    **more: Any,
) -> Info:
    """The info of a step that found a homography (3, 3), see `mkt.tracking.report`."""
    half_width, half_height = state.targets[0].kernels.half_sides
    region = as_region(homography, half_width / half_height)
    return report(region, d, lost, evaluations, homography=homography, **more)
