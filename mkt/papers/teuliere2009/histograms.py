"""Figures 1 to 4 of [T09]: histograms, kernels, and the distance that they make.

C. Teulière, E. Marchand, L. Eck, ICRA 2009.  Our copy lacks the page with figure 1 and
equations (1) to (5); what stands here in their place says so.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.colors import SPACES, ColorBins
from mkt.figures.registry import Shown, figure, grid_columns, shown
from mkt.histograms import histograms, learn
from mkt.kernels import PROFILES, Kernels
from mkt.plotting import (
    CONTRAST,
    TRUTH,
    draw_histogram,
    draw_kernels,
    draw_map,
    draw_region,
    draw_surface,
    show_frame,
)
from mkt.regions import HY, displaced, warp
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene
from mkt.scenes.textures import OBJECTS
from mkt.tracking import Sequence
from mkt.types import Array, Frame, NDArray, Region

WIDTH = 96.0  # of the object [px]; ours, the paper does not say
# Of the image, between two pixels: the edges of an object of even width fall between
# pixels too.
MIDDLE = (159.5, 119.5)
HIGH = 0.9  # where the colours of the distance end, but for larger ones
# The largest spans with which kernels stay inside an object of any aspect.
WIDEST = {"one": 1.0, "2x2": 1.25, "tiles": 1.0}
HIGHEST = 0.65  # a bar of figure 1, over all its sliders


def still(item: str, seed: int = 0) -> Sequence:
    """Two frames of an object that stands still before the workshop.

    Only the sensor noise differs.

    Parameters
    ----------
    item : str
        One of `mkt.scenes.textures.OBJECTS`.
    seed : int
        Of the noise.
    """
    layer = Layer(item, WIDTH, ((0.0, *MIDDLE, 0.0, 1.0),))
    return Scene(layer, length=2, seed=seed).sequence()


def _crossing(item: str, exposure: float, speed: float, seed: int) -> Scene:
    """An object that moves along x at a constant speed [px/frame].

    In frame 1 it is at the middle of the image.
    """
    x, y = MIDDLE
    path = ((0.0, x - speed, y, 0.0, 1.0), (2.0, x + speed, y, 0.0, 1.0))
    return Scene(Layer(item, WIDTH, path), length=2, shutter=exposure, seed=seed)


def _cells(kernels: Kernels, n: int) -> Array:
    """Canonical centres (ny, n, 2) of the pixels of a picture of the object."""
    half_width, half_height = kernels.half_sides
    ny = round(n * half_height / half_width)
    x = (2 * np.arange(n) + 1) / n - 1
    y = (2 * np.arange(ny) + 1) / ny - 1
    return np.stack(np.meshgrid(x, y), -1)


def _pulled_back(frame: Frame, region: Region, cells: Array) -> Frame:
    """The object in its own frame, f_x: a picture of the nearest pixels, (ny, n, 3)."""
    places = np.rint(warp(region, cells.reshape(-1, 2))).astype(int)
    columns, rows = np.clip(places, 0, [frame.shape[1] - 1, len(frame) - 1]).T
    return frame[rows, columns].reshape(*cells.shape[:2], 3)


def _weight_maps(kernels: Kernels, cells: Array) -> Array:
    """Each kernel's weights over the whole object, as pictures (J, ny, n)."""
    weights = kernels.weigh(cells.reshape(-1, 2) * kernels.half_sides)
    return weights.reshape(-1, *cells.shape[:2])


def _dimmed(picture: Frame, weights: Array) -> Frame:
    """A picture (ny, n, 3), to a quarter where the weights (ny, n) are nothing."""
    brightness = 0.25 + 0.75 * weights / weights.max()
    return (picture * brightness[..., None]).astype(np.uint8)


@figure(
    "teuliere2009.fig1",
    size=(10, 3.6),
    live=("teuliere2009.fig1", "surfaces-car-hsv"),
    profile=list(PROFILES),
    span=(0.4, 1.0, 0.1),
    bins=list(SPACES),
    item=list(OBJECTS),
)
def fig1(
    fig: Figure,
    *,
    profile: str = "epanechnikov",
    span: float = 1.0,
    bins: str = "hsv",
    item: str = "car",
) -> Shown:
    """A kernel-weighted colour histogram.

    Left, a rendered frame with the object's region; middle, the object pulled back into
    its own frame by the deformation f_x of equation (1), dimmed where the kernel gives
    no weight; right, its histogram, equation (2), each bar in the mean colour of its
    bin.

    In the page: Above, a rendered frame with the object's region, and the object pulled
    back into its own frame by the deformation f_x of equation (1), as bright as the
    kernel weighs it; below, its histogram, equation (2), each bar in the mean colour of
    its bin.

    Our copy of the paper lacks the page with figure 1, so this one is ours.
    """
    clip = still(item)
    region, frame = clip.truth[0], clip.frames[0]
    color_bins = ColorBins(bins)
    kernels = Kernels("one", profile, span).fitted(region)
    q = histograms(color_bins(frame), kernels, region)[0, 0]
    filled = int(np.count_nonzero(q))

    spaces = {"left": 0.01, "bottom": 0.15, "wspace": 0.25}
    widths = (1.15, 1, 1.8)
    left, middle, right = fig.subplots(1, 3, width_ratios=widths, gridspec_kw=spaces)
    show_frame(left, frame, "frame and region")
    draw_region(left, region)
    cells = _cells(kernels, 160)
    picture = _dimmed(
        _pulled_back(frame, region, cells), _weight_maps(kernels, cells)[0]
    )
    show_frame(middle, picture, "pulled back and weighted")
    title = f"{filled} of {color_bins.m} bins filled"
    draw_histogram(right, q, color_bins, title=title)
    right.set_ylim(0, HIGHEST)
    table = {"bin": np.arange(color_bins.m), "q": q}
    return shown(table, sum=float(q.sum()), filled=filled)


@figure(
    "teuliere2009.fig2",
    size=(10, 4.2),
    live=("teuliere2009.fig2",),
    layout=["one", "2x2", "3x3", "4x4", "tiles"],
    span=(0.4, 1.4, 0.1),
    profile=list(PROFILES),
    item=list(OBJECTS),
)
def fig2(
    fig: Figure,
    *,
    layout: str = "3x3",
    span: float = 1.0,
    profile: str = "epanechnikov",
    item: str = "car",
) -> Shown:
    """The multiple-kernel configuration.

    Left, centres and supports of the kernels over the object; right, the weight that
    each kernel gives to each place, the bluer the more.

    In the page: Centres and supports of the kernels over the object, and the weight
    that the chosen one gives to each place, the bluer the more.

    The paper draws nine kernels without saying where they end: here they stay inside
    the object, neighbours half a radius apart along its shorter side.  Tiles are the
    nine parts of the particle filter, which have constant weight.  One kernel and the
    tiles fill the object at a span of 1, and 2x2 at 1.25: beyond that they grow no
    more.
    """
    clip = still(item)
    region, frame = clip.truth[0], clip.frames[0]
    if layout == "tiles":
        profile = "uniform"
    span = min(span, WIDEST.get(layout, span))
    kernels = Kernels(layout, profile, span).fitted(region)
    maps = _weight_maps(kernels, _cells(kernels, 120))
    picture = _pulled_back(frame, region, _cells(kernels, 160))
    x, y = kernels.half_sides
    extent = -x, x, y, -y

    ax = fig.add_axes((0.01, 0.02, 0.46, 0.88))
    ax.imshow(picture, extent=extent)
    draw_kernels(ax, kernels)
    number = "one kernel" if len(maps) == 1 else f"{len(maps)} kernels"
    ax.set(xticks=[], yticks=[], title=f"{number}, {profile}")
    _draw_weights(fig, maps, extent)
    covered = float((maps > 0).any(0).mean())
    return shown(_kernel_table(kernels), kernels=len(maps), covered=covered)


def _draw_weights(fig: Figure, maps: Array, extent: tuple) -> None:
    """The pictures (J, ny, n) in a square of panels in the right half of the figure."""
    side = round(len(maps) ** 0.5)
    margins = {"left": 0.5, "right": 0.99, "bottom": 0.03, "top": 0.97}
    spaces = margins | {"wspace": 0.05, "hspace": 0.05}
    panels = fig.subplots(side, side, squeeze=False, gridspec_kw=spaces)
    for panel, weights in zip(panels.ravel(), maps, strict=True):
        panel.imshow(weights, cmap="Blues", vmin=0, vmax=1, extent=extent)
        panel.set(xticks=[], yticks=[])
        panel.spines[:].set(visible=True, color="0.6")


def _kernel_table(kernels: Kernels) -> pd.DataFrame:
    """Centres and supports in the object plane, in which the object has the area 4."""
    x, y = kernels.centres.T
    half_width, half_height = kernels.radii
    columns = {
        "kernel": np.arange(len(x)),
        "x": x,
        "y": y,
        "half width": half_width,
        "half height": half_height,
    }
    return pd.DataFrame(columns)


def cost_surfaces(
    layout: str, span: float, bins: str, item: str, extent: float, seed: int = 0
) -> tuple[Array, Array, list[Array]]:
    """What figure 3 draws: the distance for one kernel and for a layout.

    Parameters
    ----------
    layout : str
        Of several kernels, see `mkt.kernels.Kernels`.
    span : float
        Of the kernels; a single one has 1 at most.
    bins : str
        A colour space of `mkt.colors.ColorBins`.
    item : str
        One of `mkt.scenes.textures.OBJECTS`.
    extent : float [px]
        The largest displacement.
    seed : int
        Of the sensor noise.

    Returns
    -------
    x : (61,) array [px]
        Displacements.
    theta : (61,) array [rad]
        Rotations.
    surfaces : list of two (61, 61) arrays
        One kernel, and the layout; rotation down, x across.
    """
    clip = still(item, seed)
    color_bins = ColorBins(bins)
    learnt, seen = (color_bins(frame) for frame in clip.frames)
    x = np.linspace(-extent, extent, 61)
    theta = np.deg2rad(np.linspace(-60, 60, 61))
    grid = displaced(clip.truth[0], x, 0, theta[:, None])
    kernels = [
        Kernels("one", span=min(span, 1.0), samples=2400),
        Kernels(layout, span=min(span, 1.0) if layout == "one" else span, samples=2400),
    ]
    targets = [learn(learnt, clip.truth[0], each) for each in kernels]
    return x, theta, [target.distances(seen, grid) for target in targets]


@figure(
    "teuliere2009.fig3",
    size=(10, 6.2),
    live=("teuliere2009.fig3", "surfaces-car-hsv"),
    layout=["one", "2x2", "3x3", "4x4"],
    span=(0.4, 1.4, 0.1),
    bins=list(SPACES),
    item=list(OBJECTS),
    extent=(10, 40, 5),
)
def fig3(
    fig: Figure,
    *,
    layout: str = "3x3",
    span: float = 1.0,
    bins: str = "hsv",
    item: str = "car",
    extent: float = 20,
    seed: int = 0,
) -> Shown:
    """The distance over rotation and x location, for one kernel (a) and several (b).

    Above, the two surfaces over the same axes; below, their cut along rotation through
    the true place.

    In the page: Above, the object in its frame, and the two surfaces over the same
    axes, the darker the nearer: dotted lines meet at the truth, the white cross is the
    lowest point, the red one where the box is, and you can drag it; below, their cut
    along rotation there.

    The object is learnt in one rendered frame and looked for in the next, which differs
    by its sensor noise.  One centred round kernel sees the same histogram whatever the
    angle: its valley is flat, and only several kernels make a pit.  A single kernel
    cannot grow beyond the object: above a span of 1 only (b) changes.
    """
    x, theta, (one, several) = cost_surfaces(layout, span, bins, item, extent, seed)
    degrees = np.rad2deg(theta)
    second = "(b) one kernel again" if layout == "one" else f"(b) {layout} kernels"
    surfaces = {"(a) one kernel": one, second: several}
    levels = 0, max(HIGH, one.max(), several.max())
    for left, (title, z) in zip((-0.02, 0.46), surfaces.items(), strict=True):
        ax = fig.add_axes((left, 0.33, 0.54, 0.63), projection="3d")
        labels = {"xlabel": "x [px]", "ylabel": "rotation [deg]", "zlabel": "distance"}
        draw_surface(ax, x, degrees, z, levels, title=title, **labels)
    cuts = {title: z[:, 30] for title, z in surfaces.items()}
    _draw_cuts(fig.add_axes((0.08, 0.09, 0.88, 0.23)), degrees, cuts)
    table = _surface_table("kernels", x, degrees, surfaces)
    return shown(table, one=one, several=several, x=x, theta=theta)


def _draw_cuts(ax: Axes, degrees: Array, cuts: Mapping[str, Array]) -> None:
    """The distance over rotation, a curve for each title."""
    colors = reversed(CONTRAST[:2])
    for (title, distances), color in zip(cuts.items(), colors, strict=True):
        ax.plot(degrees, distances, color=color, label=title, lw=2)
    ax.set(xlabel="rotation at the true place [deg]", ylabel="distance")
    ax.axvline(0, color=TRUTH, lw=0.8, ls=":")
    ax.set(xlim=(-60, 60), ylim=(0, 1), xticks=range(-60, 61, 20))
    ax.legend(loc="upper left", ncols=2)


def _surface_table(
    column: str, x: Array, degrees: Array, surfaces: Mapping[str, NDArray]
) -> pd.DataFrame:
    """Surfaces by name, below one another; the name stands in a column of its own."""
    axes = {"rotation [deg]": degrees}, {"x [px]": x}
    tables = {name: grid_columns(*axes, distance=z) for name, z in surfaces.items()}
    return pd.concat(tables, names=[column]).reset_index(level=0)


@figure(
    "teuliere2009.fig4",
    size=(10, 6),
    live=("teuliere2009.fig4", "surfaces-car-hsv", "sprite-car", "workshop"),
    exposure=(0.0, 1.0, 0.1),
    speed=(0, 40, 4),
    layout=["one", "2x2", "3x3", "4x4"],
    item=list(OBJECTS),
)
def fig4(
    fig: Figure,
    *,
    exposure: float = 0.8,
    speed: float = 24,
    layout: str = "3x3",
    item: str = "car",
    seed: int = 0,
) -> Shown:
    """Blurring due to fast motion.

    Above, the object standing still and the same object crossing the same place while
    the shutter is open: the frame is the mean of sub-frame renders over the exposure.
    Below, the distance to the still object over rotation and x location in either
    frame; the dotted lines meet at the truth, the cross is the lowest point.

    In the page: Above, the object crossing while the shutter is open, the mean of
    sub-frame renders over the exposure; beside it the distance to the still object over
    rotation and x location, the darker the nearer, where it stands still and where it
    crosses: dotted lines meet at the truth, the white cross is the lowest point, the
    red one where the box is, and you can drag it; below, both along rotation there.
    The page draws noise of its own, so its numbers differ a little
    from those of the answers.

    Speed and exposure are ours; the paper prints one blurred frame.
    """
    sharp = still(item, seed)
    blurred = _crossing(item, exposure, float(speed), seed + 1).sequence()
    crossing = f"{speed:g} px per frame, exposure {exposure:.0%} of it"
    frames = {"standing still": sharp.frames[1], crossing: blurred.frames[1]}
    bins = ColorBins()
    region = sharp.truth[0]
    x = np.linspace(-30, 30, 41)
    theta = np.deg2rad(np.linspace(-60, 60, 41))
    target = learn(bins(sharp.frames[0]), region, Kernels(layout))
    grid = displaced(region, x, 0, theta[:, None])
    surfaces = [target.distances(bins(frame), grid) for frame in frames.values()]

    margins = {"right": 0.88, "bottom": 0.09, "top": 0.95}
    upper, lower = fig.subplots(2, 2, height_ratios=(1.15, 1), gridspec_kw=margins)
    for ax, (title, frame) in zip(upper, frames.items(), strict=True):
        show_frame(ax, frame, title)
        draw_region(ax, region)
        ax.set(xlim=(80, 240), ylim=_cropped(region))
    degrees = np.rad2deg(theta)
    levels = 0, max(HIGH, *(z.max() for z in surfaces))
    meshes = [
        _draw_distances(ax, x, degrees, z, levels)
        for ax, z in zip(lower, surfaces, strict=True)
    ]
    bar = fig.add_axes((0.905, 0.09, 0.015, 0.36))
    fig.colorbar(meshes[-1], cax=bar, label="distance")
    named = dict(zip(frames, surfaces, strict=True))
    table = _surface_table("object", x, degrees, named)
    return shown(table, sharp=surfaces[0], blurred=surfaces[1], x=x, theta=theta)


def _cropped(region: Region) -> tuple[float, float]:
    """The rows of the image that are shown: about the object, and all of a high one."""
    half = max(50, 1.05 * region[HY])
    return float(region[1] + half), float(region[1] - half)


def _draw_distances(
    ax: Axes, x: Array, degrees: Array, z: Array, levels: tuple[float, float]
) -> Any:
    """A surface (41, 41) round the truth from above.  Returns its mesh."""
    title = f"distance at the truth {z[20, 20]:.2f}"
    labels = {"xlabel": "x [px]", "ylabel": "rotation [deg]", "title": title}
    for draw in (ax.axvline, ax.axhline):
        draw(0, color="white", lw=0.8, ls=":")  # the truth
    return draw_map(ax, x, degrees, z, levels, **labels)
