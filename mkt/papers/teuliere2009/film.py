"""A run of the servo loop as a film: the camera's view, beside it the growing errors.

`mkt.figures.film.play` shows it.
"""

from collections.abc import Iterator, Sequence
from typing import cast

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.lines import Line2D

from mkt.papers.teuliere2009.servoing import draw_view
from mkt.plotting import CONTRAST, DESIRED, STYLE, new_figure
from mkt.servoing.loop import Experiment, Run
from mkt.types import Frame

COLORS = {"$x_n$": CONTRAST[1], "$y_n$": CONTRAST[0]}


def film(
    experiment: Experiment,
    run: Run,
    size: tuple[float, float] = (7.6, 3.0),
    dpi: float = 80,
) -> Iterator[Frame]:
    """The pictures of a run, one after the other.

    Drawn anew is only what moves, the rest is restored from a background.

    Parameters
    ----------
    experiment : Experiment
    run : Run
        Of it.
    size : (width, height) [inch]
    dpi : float
        Dots an inch.

    Yields
    ------
    (H, W, 3) uint8 RGB array
    """
    with matplotlib.rc_context(STYLE):
        fig = new_figure(size, dpi)
        left = fig.add_axes((0.015, 0.02, 0.458, 0.87))  # the view fills its axes
        right = fig.add_axes((0.59, 0.15, 0.395, 0.74))
        left.set_axis_off()
        curves = _curves(right, experiment, run)
        canvas = cast(FigureCanvasAgg, fig.canvas)
        canvas.draw()
    background = canvas.copy_from_bbox(fig.bbox)
    for k in range(len(run.times)):
        canvas.restore_region(background)
        # Not round the whole loop: between two pictures the caller may draw, too.
        with matplotlib.rc_context(STYLE):
            _draw_view(left, experiment, run, k)
        _draw_curves(right, curves, run, k)
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _draw_view(ax: Axes, experiment: Experiment, run: Run, k: int) -> None:
    """The view of frame k on the background; afterwards the axes are empty again."""
    said = ", target lost" if run.lost[k] else ""
    draw_view(ax, experiment, run, k, f"frame {k}{said}")
    ax.draw_artist(ax.title)
    for artist in [*ax.images, *ax.lines]:
        ax.draw_artist(artist)
        artist.remove()


def _draw_curves(ax: Axes, curves: Sequence[Line2D], run: Run, k: int) -> None:
    """The errors up to frame k on the background."""
    for curve, errors in zip(curves, run.errors[: k + 1, :2].T, strict=True):
        curve.set_data(np.arange(k + 1), errors)
        ax.draw_artist(curve)


def _curves(ax: Axes, experiment: Experiment, run: Run) -> list[Line2D]:
    """The axes of the errors, with a line for x_n and one for y_n, still empty."""
    largest = 1.1 * np.abs(run.errors[:, :2]).max()
    ax.axhline(0, color=DESIRED, lw=1)
    ax.set(xlim=(0, len(run.times) - 1), ylim=(-largest, largest))
    ax.set(xlabel=f"frame, {1 / experiment.servo.dt:g} a second", ylabel="error")
    lines = [
        ax.plot([], [], color=color, lw=2, label=name)[0]
        for name, color in COLORS.items()
    ]
    ax.legend(loc="lower left", ncols=2, bbox_to_anchor=(0, 1), borderaxespad=0.1)
    return lines
