"""A run of the servo loop as a film: the camera's view, beside it the growing errors.

`mkt.figures.film.play` shows it.
"""

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes

from mkt.figures.film import drawn
from mkt.papers.teuliere2009.servoing import COLOR, OFF_COLOR, draw_view
from mkt.plotting import DASHES, DESIRED, in_style, new_figure
from mkt.servoing.loop import Experiment, Run
from mkt.servoing.self_motion import OFF
from mkt.types import Frame

DPI = 80
STYLES = {"$x_n$": DASHES[1], "$y_n$": DASHES[0]}


def film(
    experiment: Experiment,
    run: Run,
    size: tuple[float, float] = (7.6, 3.0),
    largest: float | None = None,
) -> Iterator[Frame]:
    """The pictures of a run, one after the other.

    Its errors have the colour of figure 10: blue with compensation, orange without.

    Parameters
    ----------
    experiment : Experiment
    run : Run
        Of it.
    size : (width, height) [inch]
    largest : float, optional
        Error at the end of the axis, one for films that are compared; by default a
        little above those of the run.

    Yields
    ------
    (H, W, 3) uint8 RGB array
    """
    color = _color(experiment)
    with in_style():
        fig = new_figure(size, DPI)
        left = fig.add_axes((0.015, 0.02, 0.458, 0.87))  # the view fills its axes
        right = fig.add_axes((0.59, 0.15, 0.395, 0.74))
        left.set_axis_off()
        _prepare(right, experiment, run)
        largest = largest or 1.1 * np.abs(run.errors[:, :2]).max()
        right.set_ylim(-largest, largest)

    def draw(k: int) -> None:
        said = ", target lost" if run.lost[k] else ""
        draw_view(left, experiment, run, k, f"frame {k}{said}")
        for dashes, errors in zip(STYLES.values(), run.errors[: k + 1].T, strict=False):
            right.plot(np.arange(k + 1), errors, dashes, color=color, lw=2)

    return drawn(fig, draw, range(len(run.times)))


def _color(experiment: Experiment) -> str:
    return OFF_COLOR if experiment.servo.filter == OFF else COLOR


def _prepare(ax: Axes, experiment: Experiment, run: Run) -> None:
    """The axes of the errors x_n and y_n, still without them."""
    ax.axhline(0, color=DESIRED, lw=1)
    ax.set_xlim(0, len(run.times) - 1)
    ax.set(xlabel=f"frame, {1 / experiment.servo.dt:g} per second", ylabel="error")
    for name, dashes in STYLES.items():
        ax.plot([], [], dashes, color=_color(experiment), lw=2, label=name)
    ax.legend(loc="lower left", ncols=2, bbox_to_anchor=(0, 1), borderaxespad=0.1)
