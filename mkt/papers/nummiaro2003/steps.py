"""Figures 2 and 3 of [N03]: what its filter sees, and what it draws.

The paper is by K. Nummiaro, E. Koller-Meier and L. Van Gool, 2003.  The real video is
the clip "carphone" that comes inside a pip package (`mkt.sequences.carphone`), with our
annotation of the head.
"""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.colors import Bins, ColorBins, JointHSV
from mkt.figures.registry import Shown, at_most, figure, grid_columns, shown
from mkt.papers import runs
from mkt.plotting import (
    CONTRAST,
    TRUTH,
    draw_box,
    draw_ellipse,
    draw_surface,
    show_frame,
)
from mkt.regions import displaced
from mkt.scenes.nummiaro2003 import TREE, doors, students
from mkt.scenes.rendering import Scene
from mkt.sequences.carphone import Carphone
from mkt.trackers.adaptive import Adaptive, Model, as_regions
from mkt.trackers.appearance import Zone
from mkt.trackers.ellipses import Disc
from mkt.types import Array, Frame, NDArray, Region, Regions

BINS: dict[str, Bins] = {
    "rgb 8x8x8": ColorBins("rgb"),
    "rgb 4x4x4": ColorBins("rgb", (4, 4, 4)),
    "hsv 8x8x4": JointHSV(),
}
SAMPLE, MEAN, FOUND, MISSED = "black", "white", "#d62728", "#737373"
ANNOTATED, PLAIN, PALE = "#f0e442", "0.3", "0.55"
PERSON, CAR, _ = CONTRAST
TARGETS = {"person": PERSON, "car": CAR}  # of the parking place
EXTENT = 40  # [px] of the surface of figure 2, to each side of the truth


@figure(
    "nummiaro2003.fig2",
    size=(10, 4.4),
    frame=(0, 105, 35),
    particles=[25, 100, 400],
    sigma=[0.05, 0.1, 0.3],
    bins=list(BINS),
    elliptic=[False, True],
)
def fig2(
    fig: Figure,
    *,
    frame: int = 35,
    particles: int = 100,
    sigma: float = 0.1,
    bins: str = "rgb 8x8x8",
    elliptic: bool = False,
) -> Shown:
    """The samples on a face, and the surface of the Bhattacharyya coefficient round it.

    Real video, a head in a car.  At the left some samples (black ellipses), the mean
    state (white) and our annotation (yellow).  At the right the coefficient with the
    model of the first frame, an ellipse of the annotated size standing at each place of
    the dotted rectangle; the samples' centres are black, their mean is white, the
    highest place red.  The tracker does not learn here, so that model and surface
    belong together.  As in the print, which has another face, the samples crowd round
    the top of the surface, and so does their mean.  With the printed kernel radius (the
    root of the sum of both squared half axes) the weight does not vanish on the border
    of the ellipse; with the elliptic one it does.
    """
    disc = Disc(elliptic)
    tracker = Adaptive(particles, BINS[bins], disc, sigma, alpha=0.0)
    clip = runs.clip(Carphone())
    at_most(len(clip) - 1, frame=frame)
    truth = clip.truth[frame]
    mean, samples = _on_the_face(tracker, frame)
    offsets = np.arange(-EXTENT, EXTENT + 1.0)
    places = displaced(truth, offsets, offsets[:, None])
    model = tracker.learn(clip.frames[0], clip.truth[0])
    rho = coefficients(tracker, clip.frames[frame], places, model)
    best = places[np.unravel_index(np.argmax(rho), rho.shape)]

    left = fig.add_axes((0.01, 0.08, 0.46, 0.82))
    off = [np.hypot(*region[:2] - truth[:2]) for region in (mean, best)]
    named = "frame 0, samples of frame 1" if frame == 0 else f"frame {frame}"
    title = (
        f"{named}; from the annotation: mean of\nthe samples {off[0]:.0f} px, "
        f"top of the hill {off[1]:.0f} px"
    )
    show_frame(left, clip.frames[frame], title)
    _draw_ellipses(left, samples[:30], mean, truth)
    place = (0.48, 0.02, 0.52, 0.92)
    right = fig.add_axes(place, projection="3d", computed_zorder=False)
    points = {"sample": samples, "mean": mean[None], "top": best[None]}
    standing = _on_the_surface(points, truth, rho)
    _draw_coefficients(right, offsets, rho, standing)
    surface = grid_columns({"y [px]": offsets}, {"x [px]": offsets}, coefficient=rho)
    surface.insert(0, "drawn", "surface")
    return shown(
        pd.concat([surface, standing], ignore_index=True),
        rho=rho,
        offset=best[:2] - truth[:2],
        mean=mean[:2] - truth[:2],
        size=mean[3:] / truth[3:],
        x=offsets,
        y=offsets,
    )


def _on_the_face(tracker: Adaptive, frame: int) -> tuple[Region, Regions]:
    """The mean state (5,) and the samples (N, 5) in a frame of the clip.

    In the first one the samples are those of the first step.
    """
    track = runs.run(tracker, Carphone(), keep=("particles",))
    return track.regions[frame], track.info["particles"][max(frame, 1)]


def coefficients(
    tracker: Adaptive, frame: Frame, regions: Regions, model: Model
) -> Array:
    """How alike the ellipses of regions (..., 5) in a frame are to a model: (...)."""
    particles = _standing(regions.reshape(-1, 5))
    rho = tracker.observe(tracker.bins(frame), particles, model)
    return rho.reshape(regions.shape[:-1])


def _standing(regions: Regions) -> Array:
    """Particles (N, 7) that stand still, for the ellipses of regions (N, 5)."""
    still = np.zeros((len(regions), 2))
    none = np.zeros(len(regions))
    return np.column_stack([regions[:, :2], still, regions[:, 3:], none])


def _on_the_surface(
    points: Mapping[str, Regions], truth: Region, rho: Array
) -> pd.DataFrame:
    """Where centres stand on the surface round the truth, as far as they are on it."""
    parts = []
    for name, regions in points.items():
        x, y = (regions[:, :2] - truth[:2]).T
        on = (np.abs(x) <= EXTENT) & (np.abs(y) <= EXTENT)
        row, column = np.rint([y[on], x[on]]).astype(int) + EXTENT
        place = {"y [px]": y[on], "x [px]": x[on], "coefficient": rho[row, column]}
        parts.append(pd.DataFrame({"drawn": name} | place))
    return pd.concat(parts)


def _draw_ellipses(ax: Axes, samples: Regions, mean: Region, truth: Region) -> None:
    """The samples, the mean state and the annotation, and where the surface is."""
    for sample in samples:
        draw_ellipse(ax, sample, SAMPLE, lw=0.6)
    draw_ellipse(ax, truth, ANNOTATED, lw=1.5)
    draw_ellipse(ax, mean, MEAN, lw=2.2)
    draw_box(ax, [*truth[:2], 0, EXTENT, EXTENT], color=ANNOTATED, lw=1.2, ls=":")
    for label, color in {
        "samples": SAMPLE,
        "mean": MEAN,
        "annotation": ANNOTATED,
    }.items():
        ax.plot([], [], color=color, lw=2.2, label=label)
    top = {"marker": "o", "mec": "black", "ls": ""}
    ax.plot([], [], color=FOUND, **top, label="highest place")
    ax.legend(loc="lower right", ncols=2, frameon=True, facecolor="0.7")


def _draw_coefficients(
    ax: Axes, offsets: Array, rho: Array, standing: pd.DataFrame
) -> None:
    """The surface, and what stands on it."""
    labels = {"xlabel": "x [px]", "ylabel": "y [px]", "zlabel": r"$\rho$"}
    labels["title"] = f"coefficient, at most {rho.max():.2f}"
    draw_surface(ax, offsets, offsets, rho, (0, 1), **labels)
    styles = {"sample": (SAMPLE, 2.5), "mean": (MEAN, 8), "top": (FOUND, 6)}
    for name, part in standing.groupby("drawn", sort=False):
        color, size = styles[str(name)]
        x, y = part["x [px]"], part["y [px]"]
        dots = {"marker": "o", "mec": "black", "mew": 0.6, "ls": "", "zorder": 9}
        ax.plot(x, y, part["coefficient"] + 0.005, color=color, ms=size, **dots)


def placements(scene: Scene) -> dict[str, tuple[Zone, ...]]:
    """The ways to wait for the student of a scene: name -> zones of a tracker."""
    known = doors(scene)
    return {
        "doors": known[:-1],
        "borders": ("borders",),
        "doors and borders": known,
        "anywhere": ("anywhere",),
    }


PLACEMENTS = list(placements(students(0)))
MANY = 60  # samples that appear: with thick outlines they would hide the frame
IN_FULL_VIEW = 30  # a frame in which the whole student is seen


@figure(
    "nummiaro2003.fig3",
    size=(10, 4.1),
    live=("nummiaro2003.fig3", f"doors-{TREE}"),
    placement=PLACEMENTS,
    particles=(10, 400, 5),
    frame=(TREE, TREE + 40, 5),
    seed=(0, 20, 1),
)
def fig3(
    fig: Figure,
    *,
    placement: str = "doors and borders",
    particles: int = 100,
    frame: int = TREE,
    seed: int = 0,
) -> Shown:
    """Samples that wait where the target may appear, and how they know it.

    Synthetic data: the student sequence of figure 6, with the model of its first frame;
    in frame 101 the student is behind the tree.  First the samples as the
    initialisation mode places them, doors being the two sides of the tree; red ones
    fulfil the appearance condition (15).  Then the coefficient of ellipses all over the
    background, with the mean, the limit of (15) that is two spreads above it, and the
    coefficient at the true place while the student is in view.  The print waits for a
    head at doors and image borders, and promises 95 % of the background below the
    limit; the figure says what it is here.  The page draws samples of its own: for the
    same seed its counts are not quite those of Python.
    """
    scene = students(0)
    clip = runs.clip(scene)
    at_most(len(clip) - 1, frame=frame)
    tracker = Adaptive(n=particles, zones=placements(scene)[placement])
    model = tracker.learn(clip.frames[0], clip.truth[0])
    state = tracker.expect(clip.frames[TREE], model, np.random.default_rng(seed))
    around = state.background @ np.sqrt(model.q)
    rho = tracker.observe(tracker.bins(clip.frames[frame]), state.particles, model)
    k = IN_FULL_VIEW
    student = coefficients(tracker, clip.frames[k], clip.truth[k], model)

    appears = rho > state.limit
    left = fig.add_axes((0.01, 0.04, 0.53, 0.86))
    title = f"frame {frame}: {np.sum(appears)} of {particles} appear, "
    title += f"more than {tracker.b * particles:g} start the tracking"
    show_frame(left, clip.frames[frame], title)
    _draw_waiting(left, as_regions(state.particles), appears)
    right = fig.add_axes((0.61, 0.14, 0.37, 0.72))
    covered = _draw_condition(right, around, state.limit, float(student))
    return shown(
        _waiting(state.particles, rho, around, state.limit),
        samples=state.particles[:, :2],
        positives=int(np.sum(appears)),
        limit=state.limit,
        covered=covered,
        student=student,
    )


def _draw_waiting(ax: Axes, samples: Regions, appears: NDArray) -> None:
    """Samples (N, 5) with their centres, in red those that appear; thin, where many."""
    colors = [FOUND if red else MEAN for red in appears]
    thick = 1.6 if appears.sum() < MANY else 0.5
    for sample, color in zip(samples, colors, strict=True):
        draw_ellipse(ax, sample, color, lw=thick if color == FOUND else 0.5)
    ax.scatter(*samples[:, :2].T, 5, colors)


def _draw_condition(ax: Axes, around: Array, limit: float, student: float) -> float:
    """The coefficients of the background; returns the share below the limit."""
    ax.hist(around, 50, range=(0, 1), density=True, color="0.7")
    for x, color, label in (
        (around.mean(), MISSED, r"$\mu$"),
        (limit, FOUND, r"$\mu + 2 \sigma$"),
        (student, TRUTH, "student"),
    ):
        ax.axvline(x, color=color, lw=1.6, label=f"{label}: {x:.2f}")
    covered = float(np.mean(around <= limit))
    ax.set(
        xlim=(0, 1),
        xlabel=r"coefficient $\rho$ with the model",
        ylabel="density over the background",
        title=f"{covered:.1%} of the background are below the limit",
    )
    # Left of the student's line, which stands near 1.
    ax.legend(loc="upper right", bbox_to_anchor=(min(student, 1), 1))
    return covered


def _waiting(particles: Array, rho: Array, around: Array, limit: float) -> pd.DataFrame:
    """The samples and the ellipses of the background, with their coefficients."""
    x, y = particles[:, :2].T
    places = {"x [px]": x, "y [px]": y}
    samples = pd.DataFrame({"drawn": "sample"} | places | {"coefficient": rho})
    background = pd.DataFrame({"drawn": "background", "coefficient": around})
    table = pd.concat([samples, background], ignore_index=True)
    return table.assign(appears=table["coefficient"] > limit)
