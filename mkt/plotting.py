"""Drawing primitives and the one style.  Nothing here computes what it draws.

Trackers keep their colour wherever several are drawn (`TRACKERS`), the truth is black,
what is desired is red and what is current is green, as in [T09].  Colours that share an
axes differ for colour-blind readers and in grey print (tests/test_palette.py measures
by how much); where there are too many of them for that, curves differ in their dashes
too.

To import this module changes no setting of matplotlib: registered figures are drawn in
`STYLE`, and `use_style` takes it over for one's own plots.
"""

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from functools import lru_cache
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Rectangle
from matplotlib.patheffects import Normal, Stroke

from mkt.checks import is_whole, locked
from mkt.colors import Bins
from mkt.kernels import Kernels
from mkt.regions import corners
from mkt.tracking import Sequence as Clip
from mkt.tracking import Track
from mkt.types import Array, ArrayLike, Frame, NDArray, Regions

TRUTH, DESIRED, CURRENT = "black", "#cb1118", "#00a751"
# The trackers (1) to (5) of [T09] by their names in `mkt.trackers.by_name`: hues near
# Okabe and Ito's palette, in five steps of lightness; the lightest is dark enough for a
# thin line on white.
TRACKERS = {
    "pf-1": "#589cc3",
    "ssd": "#d25000",
    "pf-500": "#052b7a",
    "pf-75": "#693959",
    "combined": "#007041",
}
# For two or three curves that are no trackers of [T09]: blue, orange, purple.
CONTRAST = "#1e7dc1", "#cf8200", "#b60269"
# Eight particles, each of its own colour: those of Okabe and Ito, the blue a little
# lighter, since black letters lie on it.
EIGHT = (
    "#e69f00",
    "#56b4e9",
    "#009e73",
    "#f0e442",
    "#0080c4",
    "#d55e00",
    "#cc79a7",
    "#999999",
)
# And four more, for the twelve of resampling.
TWELVE = (*EIGHT, "#9a6fcf", "#a8712c", "#fb9a99", "#b2df8a")
DASHES = "-", "--", "-.", ":"
SURFACE = "viridis"

# Any, because matplotlib's own type of these names is provisional.
STYLE: dict[Any, Any] = {
    "font.size": 10,
    "axes.titlesize": 10.5,
    "axes.labelsize": 10,
    "legend.fontsize": 9,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": False,
    "image.interpolation": "nearest",
    # A title that finds its own height measures every tick, which takes an eighth of
    # the time of a slider's step.
    "axes.titley": 1.0,
    # Fixed margins: a layout engine would draw everything twice, and a slider would
    # feel it.
    "figure.subplot.left": 0.07,
    "figure.subplot.right": 0.98,
    "figure.subplot.bottom": 0.13,
    "figure.subplot.top": 0.91,
    "figure.subplot.wspace": 0.2,
    "figure.subplot.hspace": 0.35,
    "legend.frameon": False,
}


def in_style() -> AbstractContextManager:
    """For a while, draw and render in `STYLE`.

    Rendering counts too: it is then that matplotlib chooses the ticks.
    """
    return matplotlib.rc_context(STYLE)


def use_style() -> None:
    """Draw all further plots of this process in the style of the figures."""
    matplotlib.rcParams.update(STYLE)


def new_figure(size: tuple[float, float], dpi: float = 100) -> Figure:
    """A blank Figure of a size (width, height) [inch], unknown to pyplot."""
    fig = Figure(figsize=size, dpi=dpi)
    FigureCanvasAgg(fig)
    return fig


def show_frame(ax: Axes, frame: Frame, title: str = "") -> None:
    """Draw a frame (H, W, 3) uint8 without ticks.

    Pixel centres lie at integers, and the axes end where the image does, whatever is
    drawn on it.
    """
    ax.imshow(frame)
    ax.set_title(title)
    ax.set_axis_off()
    ax.set(xlim=(-0.5, frame.shape[1] - 0.5), ylim=(frame.shape[0] - 0.5, -0.5))


def pale(frame: Frame) -> Frame:
    """A frame (H, W, 3) half way to white: what is drawn on it stands out."""
    return 255 - (255 - frame) // 2


def draw_region(
    ax: Axes, region: ArrayLike, color: str = CURRENT, **style: Any
) -> None:
    """Outline a region (5,) [px, rad], with a tick towards its right side.

    The tick shows its angle.
    """
    draw_box(ax, region, color, **style)
    tick = np.stack([np.asarray(region)[:2], corners(region)[1:3].mean(0)])
    style = {"lw": 1.2} | style
    ax.plot(*tick.T, color=color, **style)


def draw_box(ax: Axes, region: ArrayLike, color: str = CURRENT, **style: Any) -> None:
    """Outline a region (5,) [px, rad]."""
    style = {"lw": 1.8} | style
    ax.plot(*corners(region)[[0, 1, 2, 3, 0]].T, color=color, **style)


def draw_truth(ax: Axes, truth: ArrayLike) -> None:
    """Outline the true region (5,) in black and white, to be seen on any ground.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    truth : (5,) array_like [px, rad]
    """
    draw_box(ax, truth, TRUTH, lw=2.2)
    draw_box(ax, truth, "white", lw=1.1, ls=(0, (3, 3)))


def draw_tracked(
    ax: Axes,
    frame: Frame,
    truth: ArrayLike,
    estimate: ArrayLike,
    color: str,
    title: str = "",
) -> None:
    """A frame with the true region (5,), and an estimate (5,) in its colour.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    frame : (H, W, 3) uint8 array, RGB
    truth, estimate : (5,) array_like [px, rad]
    color : str
        Of the estimate.
    title : str
    """
    show_frame(ax, frame, title)
    draw_truth(ax, truth)
    # A white rim, because a colour may be that of the ground or of the target.
    rim = [Stroke(linewidth=3.0, foreground="white"), Normal()]
    draw_region(ax, estimate, color, lw=1.7, path_effects=rim)


def plot_track(fig: Figure, track: Track, clip: Clip, frame: int) -> None:
    """A frame of a track on its sequence, and below it the course of the distance.

    Parameters
    ----------
    fig : matplotlib.figure.Figure
    track : Track
    clip : Sequence
        That the track was made on.
    frame : int
        Its number, from 0 on.

    Raises
    ------
    ValueError
        For a frame that the sequence does not have.
    """
    _check_frame("frame", frame, clip)
    upper, lower = fig.subplots(2, 1, height_ratios=(3, 1))
    title = f"{clip.name}, frame {frame}{', lost' if track.lost[frame] else ''}"
    image, truth = clip.frames[frame], clip.truth[frame]
    draw_tracked(upper, image, truth, track.regions[frame], CURRENT, title)
    times = np.arange(len(track.lost))
    distances = track.info.get("distance", np.full(len(times), np.nan))
    lower.plot(distances, color=CURRENT)
    shade_frames(lower, times, track.lost, color=DESIRED, alpha=0.2)
    lower.axvline(frame, color=TRUTH, lw=1)
    end = max(times[-1], 1)
    lower.set(xlim=(0, end), ylim=(0, 1), xlabel="frame", ylabel="distance")


def _check_frame(field: str, k: Any, clip: Clip) -> None:
    """Refuse the number of a frame that a sequence does not have."""
    if not (is_whole(k, 0) and k < len(clip)):
        raise ValueError(
            f"{field} is {k!r}; {clip.name} has {len(clip)} frames, so give a whole "
            f"number from 0 to {len(clip) - 1}"
        )


def shade_frames(ax: Axes, times: ArrayLike, where: NDArray, **style: Any) -> None:
    """Shade the frames (T,) in which a condition holds, from edge to edge.

    Each is as wide as the way from one frame to the next, one alone, too, and times
    follow one another by 1.
    """
    first = np.asarray(times)[0]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], where, [False]])))
    spans = [(float(first + k) - 0.5, int(n - k)) for k, n in edges.reshape(-1, 2)]
    ax.broken_barh(
        spans,
        (0, 1),
        transform=ax.get_xaxis_transform(),
        **{"color": "0.85", "lw": 0} | style,
    )


def draw_name(
    fig: Figure, x: float, y: float, words: str, color: str, **style: Any
) -> None:
    """Words at a place of a figure [share of it], behind a mark in a colour.

    The mark alone has it: words in a pale one cannot be read.
    """
    beside = x + 0.16 / fig.get_figwidth()
    fig.text(x, y, "\N{BLACK SQUARE}", color=color, **style)
    fig.text(beside, y, words, **style)


def film_strip(
    fig: Figure,
    clip: Clip,
    frames: Sequence[int],
    rows: Mapping[str, tuple[Regions, str]],
) -> None:
    """The same frames in every row, each row with the regions of another run.

    Parameters
    ----------
    fig : matplotlib.figure.Figure
    clip : Sequence
    frames : sequence of int
        Their numbers, from 0 on.
    rows : dict
        Title -> (regions (T, 5) [px, rad], colour).

    Raises
    ------
    ValueError
        For a frame that the sequence does not have.
    """
    for k in frames:
        _check_frame("one of frames", k, clip)
    inch = 1 / fig.get_figheight()
    margins = {"left": 0.005, "right": 0.995, "bottom": 0.005, "top": 1 - 0.5 * inch}
    spaces = margins | {"hspace": 0.2, "wspace": 0.03}
    axes = fig.subplots(len(rows), len(frames), squeeze=False, gridspec_kw=spaces)
    for row, (title, (regions, color)) in zip(axes, rows.items(), strict=True):
        for ax, k in zip(row, frames, strict=True):
            draw_tracked(ax, clip.frames[k], clip.truth[k], regions[k], color)
        at = row[0].get_position()
        bold = {"fontweight": "bold", "va": "bottom"}
        draw_name(fig, at.x0, at.y1 + 0.04 * inch, title, color, **bold)
    for ax, k in zip(axes[0], frames, strict=True):
        at = ax.get_position()
        middle, above = (at.x0 + at.x1) / 2, at.y1 + 0.27 * inch
        fig.text(middle, above, f"frame {k}", ha="center", va="bottom")


def draw_runs(
    ax: Axes, truth: ArrayLike, runs: ArrayLike, color: str, **labels: Any
) -> None:
    """Curves over the frame number: the truth in black, the first of the runs thick.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    truth : (T,) array_like
    runs : (R, T) array_like
    color : str
    **labels
        As for ``Axes.set``.
    """
    first, *others = np.asarray(runs)
    for k, run in enumerate(others, 1):
        ax.plot(run, color=color, lw=0.8, alpha=0.8, label=f"run {k}")
    ax.plot(first, color=color, lw=2.2, label="run 0")
    ax.plot(truth, color=TRUTH, lw=1.1, label="truth")
    ax.set(xlim=(0, len(first) - 1), **labels)


def draw_ellipse(
    ax: Axes, region: ArrayLike, color: str = CURRENT, **style: Any
) -> None:
    """Outline the ellipse in a region (5,) [px, rad], as [N03] draws its samples."""
    cx, cy, theta, hx, hy = np.asarray(region)
    shape = Ellipse((cx, cy), 2 * hx, 2 * hy, angle=np.rad2deg(theta), fill=False)
    shape.set(edgecolor=color, **{"lw": 1.8} | style)
    ax.add_patch(shape)


def draw_surface(
    ax: Any,
    x: Array,
    y: Array,
    z: Array,
    levels: tuple[float, float] | None = None,
    **labels: Any,
) -> None:
    """A surface, drawn with every other line so that a slider can follow.

    Parameters
    ----------
    ax : 3D axes
    x, y : (n,) and (m,) arrays
    z : (m, n) array
    levels : (low, high), optional
        Of z and of its colours.
    **labels
        As for ``Axes.set``.
    """
    low, high = levels or (z.min(), z.max())
    thin = slice(None, None, 2)
    grid = np.meshgrid(x[thin], y[thin])
    style = {"cmap": SURFACE, "rstride": 1, "cstride": 1, "lw": 0.15}
    ax.plot_surface(*grid, z[thin, thin], vmin=low, vmax=high, edgecolor="0.2", **style)
    ax.set(zlim=(low, high), **labels)
    ax.locator_params(nbins=4)
    ax.view_init(28, -58)
    ax.set_box_aspect((1.15, 1, 0.75), zoom=0.9)


def draw_map(
    ax: Axes,
    x: Array,
    y: Array,
    z: Array,
    levels: tuple[float, float] | None = None,
    **labels: Any,
) -> Any:
    """The same surface from above, with contour lines and a cross at its lowest point.

    Parameters
    ----------
    ax, x, y, z, levels, **labels
        As for `draw_surface`.

    Returns
    -------
    matplotlib.collections.QuadMesh
        For a colour bar.
    """
    low, high = levels or (z.min(), z.max())
    shown = {"cmap": SURFACE, "vmin": low, "vmax": high, "shading": "nearest"}
    mesh = ax.pcolormesh(x, y, z, **shown)
    if low < high:
        heights = np.linspace(low, high, 8)[1:]
        ax.contour(x, y, z, heights, colors="white", linewidths=0.5, alpha=0.6)
    row, column = np.unravel_index(np.argmin(z), z.shape)
    # Whole at the border, too, and its outer half to be seen on white paper.
    rim = [Stroke(linewidth=4.5, foreground="black"), Normal()]
    cross = {"color": "white", "ms": 9, "mew": 2.5, "path_effects": rim}
    ax.plot(x[column], y[row], "x", clip_on=False, **cross)
    ax.set(**labels)
    return mesh


@lru_cache(maxsize=16)
def bin_colors(bins: Bins) -> Array:
    """The mean colour of each bin, (m, 3) in [0, 1]; white where no colour falls.

    Or none of every sixth red, green and blue: these are looked at.
    """
    channel = np.arange(0, 256, 6, dtype=np.uint8)
    lattice = np.stack(np.meshgrid(channel, channel, channel), -1)
    lattice = lattice.reshape(len(channel), -1, 3)
    labels = bins(lattice).labels.ravel()
    count = np.bincount(labels, minlength=bins.m)
    values = lattice.reshape(-1, 3).T
    total = np.stack([np.bincount(labels, v, bins.m) for v in values], -1)
    mean = total / np.maximum(count, 1)[:, None] / 255
    return locked(np.where(count[:, None] > 0, mean, 1.0))


def draw_histogram(ax: Axes, q: ArrayLike, bins: Bins, **labels: Any) -> None:
    """A histogram q (m,), an array or a list, as bars in the colours of their bins.

    ValueError for a histogram of other bins.
    """
    q = np.asarray(q)
    if q.shape != (bins.m,):
        raise ValueError(f"q has the shape {q.shape}, but there are {bins.m} bins")
    u = np.flatnonzero(q)
    outline = ((-0.5, 0), (-0.5, 1), (0.5, 1), (0.5, 0))
    bars = np.stack([np.stack([u + x, q[u] * y], -1) for x, y in outline], 1)
    faces = bin_colors(bins)[u]
    # One array is several times as fast as the list that matplotlib's annotation wants.
    polygons = PolyCollection(
        bars,  # pyright: ignore[reportArgumentType]
        facecolors=faces,
        edgecolors="0.35",
        linewidths=0.25,
    )
    ax.add_collection(polygons)
    limits = {"xlim": (-0.5, bins.m - 0.5), "ylim": (0, 1.05 * (q.max() or 1))}
    ax.set(**limits, xlabel="bin $u$", ylabel="$q_u$", **labels)


def draw_kernels(ax: Axes, kernels: Kernels, **style: Any) -> None:
    """Centres and supports of kernels over the object plane."""
    width, height = 2 * kernels.radii
    for centre in kernels.centres:
        if kernels.layout == "tiles":
            corner = centre - kernels.radii
            patch = Rectangle(tuple(corner), width, height, fill=False)
        else:
            patch = Ellipse(tuple(centre), width, height, fill=False)
        patch.set(**{"edgecolor": "white", "lw": 1.3} | style)
        ax.add_patch(patch)
    color = style.get("edgecolor", "white")
    # A dark rim: an object may be as pale as the crosses are.
    rim = [Stroke(linewidth=3.2, foreground="0.25"), Normal()]
    ax.plot(*kernels.centres.T, "+", color=color, ms=7, mew=1.6, path_effects=rim)
