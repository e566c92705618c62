"""A run of the servo loop as a film: the camera's view, and the errors growing beside it.  `mkt.animation.play` shows it."""

import numpy as np

from mkt.figures.teuliere2009_servoing import draw_view
from mkt.plotting import CONTRAST, DESIRED, canvas

COLORS = {"$x_n$": CONTRAST[1], "$y_n$": CONTRAST[0]}


def film(experiment, run, size=(7.6, 3.0), dpi=80):
    """The pictures (H, W, 3) uint8 of a run, one after the other; size [inch], dpi dots an inch.

    Drawn anew is only what moves, the rest is restored from a background.
    """
    fig = canvas(size, dpi)
    left, right = fig.add_axes((0.015, 0.02, 0.458, 0.87)), fig.add_axes((0.59, 0.15, 0.395, 0.74))  # the view fills its axes
    lines = _curves(right, experiment, run)
    left.set_axis_off()
    fig.canvas.draw()
    background = fig.canvas.copy_from_bbox(fig.bbox)
    for k in range(len(run.times)):
        fig.canvas.restore_region(background)
        draw_view(left, experiment, run, k, f"frame {k}{', target lost' if run.lost[k] else ''}")
        left.draw_artist(left.title)
        for artist in [*left.images, *left.lines]:
            left.draw_artist(artist)
            artist.remove()
        for line, errors in zip(lines, run.errors.T):
            line.set_data(np.arange(k + 1), errors[:k + 1])
            right.draw_artist(line)
        yield np.asarray(fig.canvas.buffer_rgba())[..., :3].copy()


def _curves(ax, experiment, run):
    """The axes of the errors, with a line for x_n and one for y_n that are empty yet."""
    largest = 1.1 * np.abs(run.errors[:, :2]).max()
    ax.axhline(0, color=DESIRED, lw=1)
    ax.set(xlim=(0, len(run.times) - 1), ylim=(-largest, largest), xlabel=f"frame, {1 / experiment.servo.dt:g} a second", ylabel="error")
    lines = [ax.plot([], [], color=color, lw=2, label=name)[0] for name, color in COLORS.items()]
    ax.legend(loc="lower left", ncols=2, bbox_to_anchor=(0, 1), borderaxespad=0.1)
    return lines
