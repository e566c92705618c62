"""Figures of the chapter on planes in space: what is felt, and how far it pulls."""

from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from mkt.checks import locked
from mkt.colors import Bins, ColorBins, Joined
from mkt.edges import EdgeBins
from mkt.figures.registry import Shown, figure, shown
from mkt.histograms import distance, learn
from mkt.homographies import (
    PARAMETERS,
    corner_error,
    corners,
    moved,
    through,
)
from mkt.kernels import Kernels
from mkt.plotting import CONTRAST, TRACKERS, TRUTH, draw_map, pale, show_frame
from mkt.regions import rotation
from mkt.scenes.cards import CARDS, card
from mkt.scenes.drawn import HELD_BACK
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Frames, Scene, homographies, regions
from mkt.servoing import planes
from mkt.servoing.features import Camera
from mkt.trackers.homography import PlaneSSD, felt
from mkt.trackers.homography_esm import PlaneESM
from mkt.types import Array, Frame, Region

RGB = ColorBins("rgb", (5, 5, 5))
BINS: dict[str, Bins] = {
    "colours": RGB,
    "edges": EdgeBins(),
    "both": Joined((RGB, EdgeBins()), (2, 1)),
}
SIDES = ("one", "3x3", "5x5")
TILTS = np.linspace(-0.4, 0.4, 17)  # in object units
GOAL = 2.0  # [px] a start has converged where the corners are off by less
LATER = 45  # the frame in which a card is looked for


def facing(item: str, tilt: float = 0.0) -> Scene:
    """A card in the middle, turned about its y axis by degrees."""
    path = ((0.0, 160.0, 120.0, 0.0, 1.0),)
    way = ((0.0, 0.0, float(np.deg2rad(tilt))),)
    return Scene(Layer(item, 120.0, path, tilt=way), "tissue", 2)


@figure(
    "own.tilt",
    size=(10, 5.4),
    tilt=(0, 60, 15),
    item=list(CARDS),
    bins=list(BINS),
)
def tilt_felt(
    fig: Figure, *, tilt: float = 30, item: str = "cat", bins: str = "colours"
) -> Shown:
    """What one, nine and twenty-five kernels feel of a plane in space.

    Above, the frame and d_m^2 over the two tilts, in object units, round the truth,
    which is in the middle; the cross is the lowest point, all three maps have one
    scale.  Below, how much of each parameter is felt: the length of what is left of its
    column of J_U when the seven others have explained what they can, for one kernel's
    share of the sum.  Learnt on the card facing the camera; synthetic data.
    """
    before, after = facing(item), facing(item, tilt)
    image = BINS[bins](after.sequence().frames[1])
    learnt = BINS[bins](before.sequence().frames[1])
    region = before.sequence().truth[1]
    truth = homographies(after, after.target, 1.0)
    targets = {
        side: learn(learnt, region, Kernels(side, samples=1600)) for side in SIDES
    }
    offsets = np.zeros((len(TILTS), len(TILTS), 8))
    offsets[..., 6], offsets[..., 7] = np.meshgrid(TILTS, TILTS)
    maps, strengths = {}, {}
    for side, target in targets.items():
        places = moved(truth, offsets.reshape(-1, 8), target.kernels.half_sides)
        rho = target.coefficients(image, places)
        maps[side] = (distance(rho, -1) ** 2).reshape(offsets.shape[:2])
        strengths[side] = felt(target, image, truth, "homography")
    upper, lower = fig.subfigures(2, 1, height_ratios=(1.15, 1))
    _draw_maps(upper, after.sequence().frames[1], truth, maps)
    _draw_strengths(lower.add_axes((0.07, 0.14, 0.9, 0.7)), strengths)
    table = pd.DataFrame({"parameter": PARAMETERS} | strengths)
    low = {f"off_{side}": _lowest(surface) for side, surface in maps.items()}
    return shown(table, **{f"map_{s}": m for s, m in maps.items()}, **low)


def _lowest(surface: Array) -> float:
    """How far the lowest point of a map over `TILTS` is from its middle."""
    row, column = np.unravel_index(surface.argmin(), surface.shape)
    return float(np.hypot(TILTS[row], TILTS[column]))


def _draw_maps(part: Any, frame: Frame, truth: Array, maps: dict[str, Array]) -> None:
    """The frame, and the maps of all layouts on one scale."""
    margins = {"left": 0.01, "right": 0.93, "bottom": 0.17, "top": 0.9}
    axes = part.subplots(1, 4, width_ratios=(1.35, 1, 1, 1), gridspec_kw=margins)
    show_frame(axes[0], frame)
    draw_outline(axes[0], truth)
    highest = max(surface.max() for surface in maps.values())
    for ax, (side, surface) in zip(axes[1:], maps.items(), strict=True):
        draw_map(ax, TILTS, TILTS, surface, (0, highest), xlabel="tilt_x")
        ends = f"{surface.min():.3f} to {surface.max():.3f}"
        ax.set(title=f"{side}: {ends}", yticks=[])
    axes[-1].yaxis.tick_right()  # at the left they would lie on the frame
    axes[-1].yaxis.set_label_position("right")
    axes[-1].set(yticks=[-0.4, 0, 0.4], ylabel="tilt_y")


def _draw_strengths(ax: Axes, strengths: dict[str, Array]) -> None:
    """Bars over the parameters, one colour for each layout."""
    x = np.arange(len(PARAMETERS))
    for k, (side, values) in enumerate(strengths.items()):
        ax.bar(x + 0.27 * (k - 1), values, 0.25, color=CONTRAST[k], label=side)
    ax.set_xticks(x, PARAMETERS)
    ax.set(title="how much of each parameter the kernels feel", ylabel="length")
    ax.legend(ncols=3, loc="upper right")


def draw_outline(ax: Axes, seen: Array, color: str = TRUTH, **style: Any) -> None:
    """The quadrilateral that a homography (3, 3) makes of the object."""
    outline = corners(seen)
    ax.plot(*outline[[0, 1, 2, 3, 0]].T, color=color, **{"lw": 2, **style})


@lru_cache(maxsize=256)
def look(kind: str, seed: int) -> tuple[Frame, Region, Frame, Array]:
    """The first frame with its region, and a later one with its true homography."""
    scene = card(kind, seed)
    frames = Frames(scene)
    first = regions(scene, scene.target, 0.0)
    truth = homographies(scene, scene.target, float(LATER))
    return frames[0], locked(first), frames[LATER], locked(truth)


def start_from(
    kind: str, seed: int, shift: float, turn: float, growth: float, tilt: float
) -> Array:
    """A homography (3, 3) off the truth: by px, degrees, a share, degrees of tilt.

    The seed of the scene draws all directions and signs.
    """
    _, region, _, truth = look(kind, seed)
    rng = np.random.default_rng((LATER, seed))
    way, axis = rng.uniform(0, 2 * np.pi, 2)
    sign, larger = rng.choice([-1, 1], 2)
    camera = Camera()
    sides = 2 * region[3:] / camera.focal
    pose = planes.pose_of(truth, camera, sides)
    about = np.deg2rad(tilt) * np.array([np.cos(axis), np.sin(axis), 0])
    pose[:3, :3] = pose[:3, :3] @ Rotation.from_rotvec(about).as_matrix()
    tilted = planes.homography(pose, camera, sides) if tilt else truth
    about_middle = np.eye(3)
    middle = through(truth, [[0, 0]])[0]
    about_middle[:2, :2] = (1.0 + growth) ** larger * rotation(sign * np.deg2rad(turn))
    about_middle[:2, 2] = middle - about_middle[:2, :2] @ middle
    about_middle[:2, 2] += shift * np.array([np.cos(way), np.sin(way)])
    return about_middle @ tilted


def aligned(kind: str, seed: int, start: Array) -> dict[str, Array]:
    """Where kernels and pixels end from a start (3, 3), learnt in the first frame."""
    first, region, frame, _ = look(kind, seed)
    rng = np.random.default_rng(seed)
    ssd = PlaneSSD()
    esm = PlaneESM()
    by_kernels, _, _ = ssd.refine(ssd.init(first, region, rng), ssd.bins(frame), start)
    by_pixels, _, _ = esm.refine(esm.init(first, region, rng), frame, start)
    return {"kernels": by_kernels, "pixels": by_pixels}


@figure(
    "own.basin",
    size=(10, 4.0),
    shift=(0, 45, 15),
    turn=(0, 75, 25),
    growth=(0.0, 0.6, 0.2),
    tilt=(0, 60, 20),
    kind=["base", "blur", "noise", "occlusion"],
)
def basin(
    fig: Figure,
    *,
    shift: float = 15,
    turn: float = 25,
    growth: float = 0.2,
    tilt: float = 0,
    kind: str = "base",
    seed: int = 1001,
) -> Shown:
    """From how far kernels and pixels find a plane in space.

    Left, the card of one scene in a later frame: the truth (black), the start that the
    sliders displace (thin), and where the kernels' steps lead (orange) and those of
    pixels (blue, dashed).  Right, of 32 scenes on which nothing was tuned the share
    whose corners end nearer to the truth than the error below; the dotted line is what
    we call converged.  Errors above 100 px are drawn at 100.  The direction of each
    displacement is drawn by lot.  Synthetic data.
    """
    off = (shift, turn, growth, tilt)
    errors: dict[str, list[float]] = {"kernels": [], "pixels": []}
    for each in HELD_BACK:
        truth = look(kind, each)[3]
        found = aligned(kind, each, start_from(kind, each, *off))
        for name, homography in found.items():
            errors[name].append(float(corner_error(homography, truth)))
    left, right = fig.subplots(
        1,
        2,
        width_ratios=(1.3, 1),
        gridspec_kw={"left": 0.01, "right": 0.98, "bottom": 0.14, "top": 0.87},
    )
    _draw_start(left, kind, seed, off)
    columns = {name: np.array(values) for name, values in errors.items()}
    _draw_shares(right, columns)
    converged = {f"converged_{n}": values < GOAL for n, values in columns.items()}
    return shown(pd.DataFrame({"seed": HELD_BACK} | columns), **converged)


COLORS = {"kernels": TRACKERS["ssd"], "pixels": CONTRAST[0]}
# Where all end at one place, all are seen: the truth between both.
STYLES = {"kernels": {"lw": 6.0}, "pixels": {"lw": 1.2, "ls": "--", "zorder": 3}}


def _draw_start(ax: Axes, kind: str, seed: int, off: tuple[float, ...]) -> None:
    """The truth, the start and both ends of one scene."""
    _, _, frame, truth = look(kind, seed)
    start = start_from(kind, seed, *off)
    show_frame(ax, pale(frame), f"scene {seed}")
    for name, homography in aligned(kind, seed, start).items():
        draw_outline(ax, homography, COLORS[name], **STYLES[name])
    draw_outline(ax, truth, lw=2.6)
    draw_outline(ax, start, "0.4", lw=1.2, zorder=4)


def _draw_shares(ax: Axes, errors: dict[str, Array]) -> None:
    """The share of scenes below an error, for both methods."""
    for name, values in errors.items():
        label = f"{name}: {np.mean(values < GOAL):.0%}"
        ax.ecdf(np.clip(values, 0.01, 100), color=COLORS[name], lw=2.5, label=label)
    ax.axvline(GOAL, color="0.3", ls=":")
    ax.set(xscale="log", xlim=(0.02, 130), ylim=(0, 1.02))
    ax.set(xlabel="error of the corners [px]", ylabel="share of 32 scenes")
    ax.xaxis.set_major_formatter("{x:g}")
    place = {"loc": "lower center", "bbox_to_anchor": (0.5, 1), "borderaxespad": 0.2}
    ax.legend(ncols=2, title=f"within {GOAL:g} px:", **place)
