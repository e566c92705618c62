"""Figures that no paper printed: ours, for the reader's own material."""

import numpy as np

from mkt.datasets import carphone, video
from mkt.figures import figure
from mkt.histograms import ColorBins, histograms, learn
from mkt.kernels import Kernels
from mkt.plotting import DESIRED, draw_histogram, draw_map, draw_region, show_frame
from mkt.regions import displaced, from_box

_FRACTION = (0.0, 0.95, 0.01)


@figure("own.video", size=(10, 6.2), left=_FRACTION, top=_FRACTION, width=(0.05, 1.0, 0.01), height=(0.05, 1.0, 0.01), start=_FRACTION,
        later=(0, 50, 1), layout=["one", "2x2", "3x3", "4x4"])
def video_box(canvas, *, path="", left=0.34, top=0.1, width=0.3, height=0.58, start=0.0, later=10, layout="3x3"):
    """A box in a video of your own: its histogram, and how well it can be found again.

    The video is the real clip of the book unless the path names another file or a folder of images.  The box and the frame in which it is
    learnt are given as fractions of the image and of the clip.  Above, the learnt frame and the histogram of everything in the box; below,
    a later frame with the best place in red, and the distance over displacements of the box there, the lowest point marked with a cross.
    """
    clip, bins = video(path) if path else carphone(), ColorBins()
    first = round(start * (len(clip) - 1))
    then = min(first + later, len(clip) - 1)
    frames = clip.frames[first], clip.frames[then]
    region = _box(frames[0].shape, left, top, width, height)
    target = learn(bins(frames[0]), region, bins, Kernels(layout))
    dx, dy = np.linspace(-1, 1, 41) * region[3], np.linspace(-1, 1, 41) * region[4]
    distances = target.distances(bins(frames[1]), displaced(region, dx, dy[:, None]))

    axes = canvas.subplots(2, 2, width_ratios=(1, 1.25), gridspec_kw={"left": 0.01, "right": 0.9, "bottom": 0.09, "top": 0.95})
    for ax, frame, title in zip(axes[:, 0], frames, (f"learnt in frame {first}", f"found in frame {then}" + " (the last)" * (then == len(clip) - 1))):
        show_frame(ax, frame, title)
    draw_region(axes[0, 0], region)
    row, column = np.unravel_index(np.argmin(distances), distances.shape)
    draw_region(axes[1, 0], displaced(region, dx[column], dy[row]), color=DESIRED)
    whole = histograms(bins(frames[0]), bins.m, Kernels("tiles", "uniform"), region)[0].mean(0)
    draw_histogram(axes[0, 1], whole, bins, title="histogram of the box")
    mesh = draw_map(axes[1, 1], dx, dy, distances, (0, 1), xlabel="x [px]", ylabel="y [px]", title=f"lowest distance {distances.min():.2f}")
    axes[1, 1].invert_yaxis()
    canvas.colorbar(mesh, cax=canvas.add_axes((0.92, 0.09, 0.015, 0.37)), label="distance")
    return {"distances": distances, "x": dx, "y": dy}


def _box(shape, left, top, width, height):
    """The region of a box given in fractions of the image, cut where it would leave it."""
    h, w = shape[:2]
    return from_box([left * w, top * h, min(width, 1 - left) * w, min(height, 1 - top) * h])
