"""Drawing primitives and the one style.  Nothing here computes what it draws.

Trackers keep their colour in every figure (`TRACKERS`), the truth is black, what is desired is red and what is current is green,
as in [T09].  Colours that share an axes differ for colour-blind readers and in grey print (tests/test_palette.py measures by how much); where
there are too many of them for that, curves differ in their dashes too.
"""

from functools import lru_cache

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Rectangle

from mkt.regions import corners

TRUTH, DESIRED, CURRENT = "black", "#cb1118", "#33b24d"
# The trackers (1) to (5) of [T09] by their names in `mkt.trackers.catalogue`: hues of Okabe and Ito's palette, in five steps of lightness.
TRACKERS = {"pf-1": "#7bc8f9", "ssd": "#d65b07", "pf-500": "#35427c", "pf-75": "#cf88b0", "combined": "#137353"}
CONTRAST = "#1e7dc1", "#e49c00", "#b60269"  # for two or three curves that are no trackers of [T09]: blue, orange, purple
DASHES = "-", "--", "-.", ":"
SURFACE = "viridis"

matplotlib.rcParams.update({
    "font.size": 10, "axes.titlesize": 10.5, "axes.labelsize": 10, "legend.fontsize": 9, "xtick.labelsize": 9, "ytick.labelsize": 9,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": False, "image.interpolation": "nearest",
    "axes.titley": 1.0,  # titles that look for their height measure every tick, an eighth of the time of a slider's step
    # Fixed margins: a layout engine would draw everything twice, and a slider would feel it.
    "figure.subplot.left": 0.07, "figure.subplot.right": 0.98, "figure.subplot.bottom": 0.13, "figure.subplot.top": 0.91,
    "figure.subplot.wspace": 0.2, "figure.subplot.hspace": 0.35, "legend.frameon": False,
})


def canvas(size, dpi=100):
    """A blank matplotlib Figure, size (width, height) [inch], with its own canvas and unknown to pyplot."""
    fig = Figure(figsize=size, dpi=dpi)
    FigureCanvasAgg(fig)
    return fig


def show_frame(ax, frame, title=""):
    """Draw a frame (H, W, 3) uint8 without ticks; pixel centres at integers."""
    ax.imshow(frame)
    ax.set_title(title)
    ax.set_axis_off()


def draw_region(ax, region, color=CURRENT, **style):
    """Outline a region (5,) [px, rad], with a tick from its centre to the middle of its right side, so that its angle shows."""
    draw_box(ax, region, color, **style)
    tick = np.stack([np.asarray(region)[:2], corners(region)[1:3].mean(0)])
    ax.plot(*tick.T, color=color, **{"lw": 1.2} | style)


def draw_box(ax, region, color=CURRENT, **style):
    """Outline a region (5,) [px, rad]."""
    ax.plot(*corners(region)[[0, 1, 2, 3, 0]].T, color=color, **{"lw": 1.8} | style)


def draw_tracked(ax, frame, truth, estimate, color, title=""):
    """A frame with the true region (5,), black and white so that it shows on any ground, and an estimate (5,) in its tracker's colour."""
    show_frame(ax, frame, title)
    draw_box(ax, truth, TRUTH, lw=2.2)
    draw_box(ax, truth, "white", lw=1.1, ls=(0, (3, 3)))
    draw_region(ax, estimate, color, lw=2)
    ax.set(xlim=(-0.5, frame.shape[1] - 0.5), ylim=(frame.shape[0] - 0.5, -0.5))


def draw_runs(ax, truth, runs, color, **labels):
    """Curves over the frame number: the truth (T,) in black, several runs (R, T) thin, the first of them thick.  labels: as for ``Axes.set``."""
    ax.plot(np.transpose(runs[1:]), color=color, lw=0.8, alpha=0.8, label=[f"run {k}" for k in range(1, len(runs))])
    ax.plot(runs[0], color=color, lw=2.2, label="run 0")
    ax.plot(truth, color=TRUTH, lw=1.1, label="truth")
    ax.set(xlim=(0, len(truth) - 1), **labels)


def draw_ellipse(ax, region, color=CURRENT, **style):
    """Outline the ellipse inside a region (5,) [px, rad], as [N03] draws its samples."""
    cx, cy, theta, hx, hy = region
    ax.add_patch(Ellipse((cx, cy), 2 * hx, 2 * hy, angle=np.rad2deg(theta), fill=False, edgecolor=color, **{"lw": 1.8} | style))


def draw_surface(ax, x, y, z, levels=None, **labels):
    """A surface z (len(y), len(x)) over x and y, drawn with every other line so that a slider can follow.

    ax: a 3D axes; levels: (low, high) of z and of its colours; labels: as for ``Axes.set``.
    """
    low, high = levels or (z.min(), z.max())
    thin = slice(None, None, 2)
    ax.plot_surface(*np.meshgrid(x[thin], y[thin]), z[thin, thin], cmap=SURFACE, vmin=low, vmax=high, rstride=1, cstride=1, lw=0.15, edgecolor="0.2")
    ax.set(zlim=(low, high), **labels)
    ax.locator_params(nbins=4)
    ax.view_init(28, -58)
    ax.set_box_aspect((1.15, 1, 0.75), zoom=0.9)


def draw_map(ax, x, y, z, levels=None, **labels):
    """The same surface seen from above, as a coloured map with contour lines; the lowest point gets a white cross."""
    low, high = levels or (z.min(), z.max())
    mesh = ax.pcolormesh(x, y, z, cmap=SURFACE, vmin=low, vmax=high, shading="nearest")
    ax.contour(x, y, z, np.linspace(low, high, 8)[1:], colors="white", linewidths=0.5, alpha=0.6)
    row, column = np.unravel_index(np.argmin(z), z.shape)
    ax.plot(x[column], y[row], "x", color="white", ms=9, mew=2.5)
    ax.set(**labels)
    return mesh


@lru_cache(maxsize=16)
def bin_colors(bins):
    """The mean colour of each bin of a `ColorBins`, (m, 3) in [0, 1]; bins that no colour reaches are white."""
    lattice = np.stack(np.meshgrid(*[np.arange(0, 256, 6, dtype=np.uint8)] * 3), -1).reshape(43, -1, 3)
    labels = bins(lattice).ravel()
    count = np.bincount(labels, minlength=bins.m)
    total = np.stack([np.bincount(labels, lattice[..., c].ravel(), bins.m) for c in range(3)], -1)
    return np.where(count[:, None] > 0, total / np.maximum(count, 1)[:, None] / 255, 1.0)


def draw_histogram(ax, q, bins, **labels):
    """A histogram q (m,) as bars in the colours of their bins."""
    u = np.flatnonzero(q)
    bars = np.stack([np.stack([u + side, q[u] * top], -1) for side, top in ((-0.5, 0), (-0.5, 1), (0.5, 1), (0.5, 0))], 1)
    ax.add_collection(PolyCollection(bars, facecolors=bin_colors(bins)[u], edgecolors="0.35", linewidths=0.25))
    ax.set(xlim=(-0.5, bins.m - 0.5), ylim=(0, 1.05 * q.max()), xlabel="bin $u$", ylabel="$q_u$", **labels)


def draw_kernels(ax, kernels, **style):
    """Centres and supports of kernels over the object plane."""
    for centre in kernels.centres:
        width, height = 2 * kernels.radii
        if kernels.layout == "tiles":
            patch = Rectangle(centre - kernels.radii, width, height, fill=False)
        else:
            patch = Ellipse(centre, width, height, fill=False)
        patch.set(**{"edgecolor": "white", "lw": 1.3} | style)
        ax.add_patch(patch)
    ax.plot(*kernels.centres.T, "+", color=style.get("edgecolor", "white"), ms=7, mew=1.6)
