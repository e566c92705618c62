"""A figure that no paper printed: ours, for the reader's own material."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.colors import ColorBins
from mkt.figures.registry import Shown, at_most, figure, grid_columns, shown
from mkt.histograms import histograms, learn
from mkt.kernels import Kernels
from mkt.plotting import DESIRED, draw_histogram, draw_map, draw_region, show_frame
from mkt.regions import HX, HY, displaced, from_box
from mkt.sequences.carphone import carphone
from mkt.sequences.truth_formats import video
from mkt.types import Array, Frame, Region

_FRACTION = (0.0, 0.95, 0.01)
_SIDE = (0.05, 1.0, 0.01)
BINS = ColorBins()


@figure(
    "own.video",
    size=(10, 6.2),
    left=_FRACTION,
    top=_FRACTION,
    width=_SIDE,
    height=_SIDE,
    start=_FRACTION,
    later=(0, 50, 1),
    layout=["one", "2x2", "3x3", "4x4"],
)
def video_box(
    fig: Figure,
    *,
    path: str = "",
    left: float = 0.34,
    top: float = 0.1,
    width: float = 0.3,
    height: float = 0.58,
    start: float = 0.0,
    later: int = 10,
    layout: str = "3x3",
) -> Shown:
    """A box in a video of your own: its histogram, and how well it can be found again.

    The video is the real clip of the book; in JupyterLab, any file or folder of images.
    Above, the learnt frame and the histogram of everything in the box; below, a later
    frame with the best place in red, and the distance over displacements of the box
    there, the lowest point marked with a cross.
    """
    at_most(1, left=left, top=top, start=start)
    clip = video(path) if path else carphone()
    last = len(clip) - 1
    first = round(start * last)
    then = min(first + later, last)
    learnt, seen = clip.frames[first], clip.frames[then]
    region = _box(learnt, left, top, width, height)
    x = np.linspace(-1, 1, 41) * region[HX]
    y = np.linspace(-1, 1, 41) * region[HY]
    places = displaced(region, x, y[:, None])
    target = learn(BINS(learnt), region, Kernels(layout))
    distances = target.distances(BINS(seen), places)

    margins = {"left": 0.01, "right": 0.9, "bottom": 0.09, "top": 0.95}
    axes = fig.subplots(2, 2, width_ratios=(1, 1.25), gridspec_kw=margins)
    (frame_ax, histogram_ax), (found_ax, map_ax) = axes
    show_frame(frame_ax, learnt, f"learnt in frame {first}")
    draw_region(frame_ax, region)
    title = f"found in frame {then}{' (the last)' if then == last else ''}"
    show_frame(found_ax, seen, title)
    best = np.unravel_index(np.argmin(distances), distances.shape)
    draw_region(found_ax, places[best], color=DESIRED)
    q = _histogram(learnt, region)
    draw_histogram(histogram_ax, q, BINS, title="histogram of the box")
    labels = {"xlabel": "x [px]", "ylabel": "y [px]"}
    lowest = f"lowest distance {distances.min():.2f}"
    mesh = draw_map(map_ax, x, y, distances, (0, 1), title=lowest, **labels)
    map_ax.invert_yaxis()
    map_ax.set_aspect("equal")
    _thin_ticks(map_ax, x, y)
    fig.colorbar(mesh, cax=fig.add_axes((0.92, 0.09, 0.015, 0.37)), label="distance")
    table = grid_columns({"y [px]": y}, {"x [px]": x}, distance=distances)
    return shown(table, distances=distances, x=x, y=y, histogram=q)


def _thin_ticks(ax: Axes, x: Array, y: Array) -> None:
    """The 0 alone on the side of a map that is much the shorter."""
    for axis, own, other in ((ax.xaxis, x, y), (ax.yaxis, y, x)):
        if np.ptp(own) < np.ptp(other) / 3:
            axis.set_ticks([0])


def _box(frame: Frame, left: float, top: float, width: float, height: float) -> Region:
    """The region of a box in fractions of a frame, cut where it would leave it."""
    h, w = frame.shape[:2]
    cut_width, cut_height = min(width, 1 - left), min(height, 1 - top)
    return from_box([left * w, top * h, cut_width * w, cut_height * h])


def _histogram(frame: Frame, region: Region) -> Array:
    """The histogram (m,) of everything in a region, each pixel with the same weight."""
    tiles = Kernels("tiles", "uniform").fitted(region)
    return histograms(BINS(frame), tiles, region)[0].mean(0)
