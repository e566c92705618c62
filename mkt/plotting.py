"""Drawing primitives and the one style.  Nothing here computes what it draws.

Trackers keep their colour in every figure (`TRACKERS`), the truth is black, what is desired is red and what is current is green,
as in [T09].
"""

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mkt.regions import corners

TRUTH, DESIRED, CURRENT = "black", "#d62728", "#2ca02c"
# The trackers (1) to (5) of [T09], from the colour-blind safe palette of Okabe and Ito.
TRACKERS = ("#56b4e9", "#d55e00", "#0072b2", "#cc79a7", "#009e73")
SURFACE = "viridis"

matplotlib.rcParams.update({
    "font.size": 10, "axes.titlesize": 10.5, "axes.labelsize": 10, "legend.fontsize": 9, "xtick.labelsize": 9, "ytick.labelsize": 9,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": False, "image.interpolation": "nearest",
    "figure.constrained_layout.use": True, "legend.frameon": False,
})


def canvas(size, dpi=100):
    """A blank matplotlib Figure, size (width, height) [inch], with its own canvas and unknown to pyplot."""
    fig = Figure(figsize=size, dpi=dpi)
    FigureCanvasAgg(fig)
    return fig


def show_frame(ax, frame, title=""):
    """Draw a frame (H, W, 3) uint8 without ticks; pixel centres at integers."""
    ax.imshow(frame)
    ax.set(xticks=[], yticks=[], title=title)
    ax.spines[:].set_visible(False)


def draw_region(ax, region, color=CURRENT, **style):
    """Outline a region (5,) [px, rad], with a tick from its centre to the middle of its right side, so that its angle shows."""
    outline = corners(region)[[0, 1, 2, 3, 0]]
    ax.plot(*outline.T, color=color, **{"lw": 1.8} | style)
    tick = np.stack([np.asarray(region)[:2], outline[1:3].mean(0)])
    ax.plot(*tick.T, color=color, **{"lw": 1.2} | style)
