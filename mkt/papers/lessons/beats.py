"""One round of the particle filter on a frame, in its four beats, and a wall to move.

Explained in notebook 05; on the book's page the figure is a film (`mkt/live/beats.js`).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.evaluation import overlap
from mkt.figures.registry import Shown, at_most, figure, shown
from mkt.papers import runs
from mkt.particles import (
    SCHEMES,
    Motion,
    effective_sample_size,
    mean_region,
)
from mkt.plotting import CONTRAST, CURRENT, draw_region, draw_truth, pale, show_frame
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene
from mkt.scenes.teuliere2009 import hidden
from mkt.trackers.particle_filter import ParticleFilter
from mkt.tracking import Sequence as Clip
from mkt.types import Array, NDArray, Region, Regions, Rng

LENGTH = 60  # frames
BRICKS = 120.0  # [px] of the wall, its width; two of them are as high as the picture
AWAY = 380.0  # [px] where its middle is out of sight
CLOSE, CLOSER = 60.0, 25.0  # [px] round the crowd: with the car, and for dots alone
SHAPE = np.array([160.0, 120.0])  # [px] half a frame
BEFORE, CROWD = "0.45", CONTRAST[1]


class Round(NamedTuple):
    """One round of a particle filter.

    Attributes
    ----------
    before, predicted : (N, 5) array [px, rad]
        The particles as the last round left them, and moved on.
    weights : (N,) array
        Of sum 1.
    estimate : (5,) array [px, rad]
    distance : float
        d_m there.
    ancestors : (N,) int array
        The particles that live on.
    """

    before: Regions
    predicted: Regions
    weights: Array
    estimate: Region
    distance: float
    ancestors: NDArray


def film(wall: float = AWAY) -> Scene:
    """The car of [T09]'s figure 6 without its screen; instead, a wall that stands.

    Parameters
    ----------
    wall : float [px]
        Its middle along x.
    """
    middles = (BRICKS - 1) / 2, (3 * BRICKS - 1) / 2
    bricks = [Layer("bricks", BRICKS, ((0.0, wall, y, 0.0, 1.0),)) for y in middles]
    return replace(hidden(0), length=LENGTH, shutter=0.0, front=tuple(bricks))


def restless(noise: float) -> Motion:
    """Our motion model with so many times its noise."""
    usual = Motion()
    names = "position", "velocity", "angle", "scale"
    return replace(usual, **{name: noise * getattr(usual, name) for name in names})


def last_round(
    tracker: ParticleFilter, clip: Clip, learnt: Clip, frame: int, rng: Rng
) -> Round:
    """Run a filter up to a frame, and take its last round apart.

    Parameters
    ----------
    tracker : ParticleFilter
    clip : Sequence
    learnt : Sequence
        In whose first frame the target is learnt.
    frame : int
        From 1 on.
    rng : numpy.random.Generator
    """
    state = tracker.init(learnt.frames[0], learnt.truth[0], rng)
    for k in range(1, frame):
        state, _ = tracker.step(state, clip.frames[k], rng)
    image = tracker.bins(clip.frames[frame])
    moved = tracker.motion.predict(state.particles, rng)
    weights = tracker.weigh(state.target, image, moved)
    estimate = mean_region(moved.regions, weights)
    distance = float(state.target.distances(image, estimate))
    ancestors = tracker.resample(weights, rng)
    before = state.particles.regions
    return Round(before, moved.regions, weights, estimate, distance, ancestors)


@figure(
    "own.beats",
    size=(10, 8),
    live=("own.beats", "workshop"),
    frame=(1, LENGTH - 1, 1),
    n=(10, 300, 5),
    noise=(0.2, 4.0, 0.1),
    lam=(0, 60, 1),
    scheme=list(SCHEMES),
    wall=(-60.0, AWAY, 1.0),
)
def beats(
    fig: Figure,
    *,
    frame: int = 20,
    n: int = 75,
    noise: float = 1.0,
    lam: float = 20,
    scheme: str = "multinomial",
    wall: float = AWAY,
    seed: int = 0,
) -> Shown:
    """One round of the particle filter, in four beats.

    1: every particle moves on (a line) from where it was (grey).  2: it weighs as much
    as its place looks like the car; the larger the dot, the heavier.  3: the weighted
    mean is the answer, green; dashed is the truth.  4: the next crowd is drawn; the
    larger the dot, the more offspring, and a cross has none.  All show the part of the
    frame round the crowd, in the file the third with the whole car.  Synthetic data:
    the car of figure 6 of [T09], seen without motion blur, behind a wall of bricks that
    stands where the slider puts its middle [px].  The car is learnt before the wall is
    there.  The page draws random numbers of its own: its crowd is not that of the
    files.
    """
    at_most(LENGTH - 1, frame=frame)
    clip, learnt = runs.clip(film(wall)), runs.clip(film())
    tracker = ParticleFilter(n=n, lam=lam, motion=restless(noise), scheme=scheme)
    made = last_round(tracker, clip, learnt, frame, np.random.default_rng(seed))
    offspring = np.bincount(made.ancestors, minlength=n)
    n_eff = effective_sample_size(made.weights)
    iou = float(overlap(made.estimate, clip.truth[frame]))

    margins = {"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 0.96}
    spaces = margins | {"hspace": 0.1, "wspace": 0.03}
    axes = fig.subplots(2, 2, gridspec_kw=spaces).ravel()
    titles = (
        "1 predict",
        f"2 weigh: $N_{{eff}}$ = {n_eff:.1f} of {n}",
        f"3 estimate: overlap with the truth {iou:.2f}",
        f"4 draw: {np.count_nonzero(offspring)} of {n} live on",
    )
    for ax, title in zip(axes, titles, strict=True):
        show_frame(ax, pale(clip.frames[frame]), title)
    _draw_moves(axes[0], made)
    _draw_crowd(axes[1], made.predicted, made.weights / made.weights.max())
    _draw_crowd(axes[2], made.predicted, made.weights / made.weights.max())
    draw_truth(axes[2], clip.truth[frame])
    draw_region(axes[2], made.estimate, CURRENT, lw=2.5)
    _draw_crowd(axes[3], made.predicted, offspring / offspring.max())
    there = [made.before, made.predicted, clip.truth[None, frame]]
    _come_closer([axes[2]], there, CLOSE)
    _come_closer([*axes[:2], axes[3]], there, CLOSER)

    columns = {"particle": np.arange(n), "weight": made.weights, "offspring": offspring}
    places = {"x [px]": made.predicted[:, 0], "y [px]": made.predicted[:, 1]}
    facts = {"n_eff": n_eff, "overlap": iou, "distance": made.distance}
    return shown(columns | places, **facts)


def _draw_moves(ax: Axes, made: Round) -> None:
    """Where each particle was, and the way that it went."""
    ways = np.stack([made.before, made.predicted])[..., :2]
    ax.plot(*ways[1].T, "o", color=CROWD, ms=5, mec="black", mew=0.4)
    ax.plot(*np.moveaxis(ways, -1, 0), color="black", lw=0.6)
    ax.plot(*ways[0].T, "o", color=BEFORE, ms=2.5)  # over the dots, or they hide it


def _come_closer(axes: Sequence[Axes], there: Sequence[Regions], close: float) -> None:
    """Show the part of the frame with all middles in it, and some [px] on each side."""
    middles = np.concatenate([regions[:, :2] for regions in there])
    low, high = middles.min(0) - close, middles.max(0) + close
    centre = (low + high) / 2
    half = min(max((high - low) / 2 / SHAPE), 1.0) * SHAPE
    x, y = np.clip(centre, half, 2 * SHAPE - half) - 0.5
    for ax in axes:
        ax.set(xlim=(x - half[0], x + half[0]), ylim=(y + half[1], y - half[1]))


def _draw_crowd(ax: Axes, particles: Regions, sizes: Array) -> None:
    """Particles (N, 5) as dots with areas in [0, 1], and as crosses where it is 0."""
    x, y = particles[:, :2].T
    some = sizes > 0
    ax.plot(x[~some], y[~some], "x", color=BEFORE, ms=4)
    dots = {"color": CROWD, "edgecolors": "black", "lw": 0.4, "zorder": 3}
    ax.scatter(x[some], y[some], s=4 + 90 * sizes[some], **dots)
