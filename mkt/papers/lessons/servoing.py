"""Teaching figures of the robot: what its motion does to the image, and an approach."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.figures.registry import Shown, figure, shown
from mkt.papers import runs
from mkt.plotting import (
    CONTRAST,
    CURRENT,
    DASHES,
    DESIRED,
    draw_box,
    draw_region,
    pale,
    show_frame,
)
from mkt.servoing.controller import Servo
from mkt.servoing.features import error, features, interaction_matrix
from mkt.servoing.loop import Experiment, Run
from mkt.servoing.robot import Workspace, move
from mkt.servoing.self_motion import OFF
from mkt.types import Array, Frame, Region

AXES = ("$v_x$", "$v_y$", "$v_z$", r"$\omega_x$", r"$\omega_y$", r"$\omega_z$")
UNITS = ("m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s")
MOTIONS = (
    "moves right",
    "moves down",
    "moves forward",
    "looks up",
    "looks right",
    "rolls clockwise",
)
NAMES = ("$x_n$", "$y_n$", "$a_n$", r"$\theta$")
MOVED = CONTRAST[1]
FEW = 60  # frames of a curve with a dot for each
# Of motions along and, dashed, about the three axes.
STYLES: list[dict[str, Any]] = [
    {"color": color, "ls": dash} for dash in DASHES[:2] for color in CONTRAST
]
PUSH = np.array([0.06] * 3 + [0.1, 0.1, 0.25])  # [m] and [rad]: far enough to be seen
CAR = (0.0, 0.0, np.pi / 2)  # a place [m, rad]
HALVES = (50, 31.25)  # [px] of the car's image, half its sides
TABLE = "gravel"  # what one may look down on; the features do not look at it
STILL = ((0.0, *CAR),)


def _plain(name: str) -> str:
    r"""A name of the figures as tables have it: "theta" for "$\theta$"."""
    return name.strip("$").lstrip("\\")


def pale_view(workspace: Workspace, pose: Array) -> Frame:
    """What the camera sees of the car that stands still, pale, to draw on."""
    rng = np.random.default_rng(0)
    return pale(workspace.frame(pose, np.zeros(6), STILL, 0, rng))


@figure(
    "own.interaction",
    size=(10, 6.1),
    live=("own.interaction",),
    x=(-80, 80, 1),
    y=(-50, 50, 1),
    turn=(0, 180, 1),
    scale=(0.5, 1.25, 0.05),
)
def interaction(
    fig: Figure, *, x: float = 40, y: float = -25, turn: float = 90, scale: float = 1.0
) -> Shown:
    """The columns of the interaction matrix, as motions in the image.

    Each is the motion that one velocity of the camera causes.  Green: the car now.
    Orange: where it is after the camera alone has moved by 6 cm or turned by 0.1 rad
    (0.25 rad about its optical axis); arrows: the paths of its corners.  Below each
    view its column of L: by how much the features change in a second at 1 m/s or 1
    rad/s.  The sliders place, turn and scale the car in the image.
    """
    workspace = Workspace(table=TABLE, exposure=0.0)
    place = 159.5 + x, 119.5 + y, np.deg2rad(turn)
    region = np.array([*place, HALVES[0] * scale, HALVES[1] * scale])
    pose = workspace.facing(region, CAR)
    L = interaction_matrix(region, workspace.camera, workspace.surface)
    outlines = [paths_of_corners(workspace, pose, k) for k in range(6)]

    image = pale_view(workspace, pose)
    margins = {"left": 0.01, "right": 0.99, "bottom": 0.09, "top": 0.95}
    spaces = margins | {"hspace": 0.34, "wspace": 0.04}
    axes = fig.subplots(2, 3, gridspec_kw=spaces)
    for k, ax in enumerate(axes.flat):
        show_frame(ax, image, f"{AXES[k]}: the camera {MOTIONS[k]}")
        _draw_motion(ax, region, outlines[k])
        style = {"transform": ax.transAxes, "ha": "center", "va": "top"}
        ax.text(0.5, -0.03, column(L[:, k]), **style)
    return shown(_motion_table(L, np.array(outlines)), L=L, outlines=outlines)


def paths_of_corners(
    workspace: Workspace, pose: Array, k: int, steps: int = 8
) -> Array:
    """The car's corners while the camera moves by `PUSH` along or about one axis.

    Parameters
    ----------
    workspace : Workspace
    pose : (4, 4) array
        Where the camera begins.
    k : int
        Which component of the twist acts.
    steps : int

    Returns
    -------
    (steps + 1, 4, 2) array [px]
    """
    push = PUSH * (np.arange(6) == k)
    parts = np.linspace(0, 1, steps + 1)
    return np.array([workspace.outline(move(pose, push, part), CAR) for part in parts])


def column(values: Array) -> str:
    """A column of L (4,) as text, every entry behind its feature."""
    return ",  ".join(
        f"{name} {_signed(value)}" for name, value in zip(NAMES, values, strict=True)
    )


def _signed(value: float) -> str:
    """A number with its sign, a true minus; 0 without."""
    return f"{value:+.2f}".replace("-", "−") if abs(value) >= 5e-3 else "0"


def _draw_motion(ax: Axes, region: Region, outlines: Array) -> None:
    """A region (5,), and outlines (n, 4, 2) on the way to the last of them."""
    draw_box(ax, region, CURRENT, lw=2)
    ax.plot(*outlines[-1][[0, 1, 2, 3, 0]].T, color=MOVED, lw=2)
    arrow = {"arrowstyle": "-|>", "color": "black", "lw": 1.2}
    whole = {"shrinkA": 0, "shrinkB": 0}  # from end to end
    for path in np.swapaxes(outlines, 0, 1):
        ax.plot(*path.T, color="black", lw=1.2)
        if np.hypot(*(path[-1] - path[0])) > 3:
            ax.annotate("", path[-1], path[-2], arrowprops=arrow | whole)


def _motion_table(L: Array, outlines: Array) -> pd.DataFrame:
    """A row for each corner on its way, and behind it the column of L.

    The ways (6, n, 4, 2) are those of the corners under each of the velocities.
    """
    velocity, step, corner = np.indices(outlines.shape[:3]).reshape(3, -1)
    columns = {
        "velocity": np.array([_plain(name) for name in AXES])[velocity],
        "step": step,
        "corner": corner,
        "x [px]": outlines[..., 0].ravel(),
        "y [px]": outlines[..., 1].ravel(),
    }
    columns |= {
        f"L of {_plain(name)}": row[velocity]
        for name, row in zip(NAMES, L, strict=True)
    }
    return pd.DataFrame(columns)


@figure(
    "own.approach",
    size=(10, 5.2),
    live=("own.approach",),
    gain=(0.05, 10.0, 0.05),
    fps=(1.0, 30.0, 0.5),
    delay=(0, 6, 1),
    dof=[6, 4],
    turn=(-90, 90, 1),
)
def approach(
    fig: Figure,
    *,
    gain: float = 1.0,
    fps: float = 5,
    delay: int = 0,
    dof: int = 6,
    turn: float = 30,
) -> Shown:
    """Closing the loop on a car that stands still.

    Exact features, no compensation.  First the image: green the car at the start, red
    where it should appear, black the paths of its corners, a dot for each frame.  Then
    the errors at the time, which the controller knows only after the delay, and dotted
    the exponentials that (17) promises; last how fast the camera moves and how fast it
    turns.  A loop that runs away is drawn as far as it sees the car.
    """
    tried = Experiment(
        Servo(gain=gain, dt=1 / fps, delay=delay, dof=dof, filter=OFF),
        path=STILL,
        start=(0.05, -0.06, -0.12, 0.0, 0.0, np.deg2rad(turn)),
        frames=round(6 * fps) + 1,
    )
    run = runs.loop_run(tried, until_lost=True)
    outlines = np.array([tried.workspace.outline(pose, CAR) for pose in run.poses])
    # The controller knows them `delay` frames later.
    errors = error(features(run.truths, tried.servo.camera), tried.servo.goal)
    promised = np.exp(-gain * run.times)[:, None] * errors[0]

    left = fig.add_axes((0.01, 0.02, 0.48, 0.9))
    _draw_approach(left, tried, run, outlines)
    left.set_title(f"gain × frame period = {gain / fps:.2g}")
    margins = {"left": 0.59, "right": 0.985, "bottom": 0.11, "top": 0.93}
    spaces = margins | {"hspace": 0.28}
    upper, *lower = fig.subplots(3, 1, sharex=True, gridspec_kw=spaces)
    _draw_errors(upper, run.times, errors, promised)
    _draw_velocities(lower, run)
    for ax in (upper, *lower):
        ax.axhline(0, color="0.6", lw=0.8, zorder=0)
        _add_legend(ax)
    table = _approach_table(run, errors, promised, outlines)
    facts = {"errors": errors, "velocities": run.velocities, "times": run.times}
    return shown(table, **facts)


def _draw_approach(ax: Axes, experiment: Experiment, run: Run, outlines: Array) -> None:
    """The image at the start, and the ways of the corners (T, 4, 2)."""
    show_frame(ax, pale_view(Workspace(table=TABLE), run.poses[0]))
    draw_region(ax, experiment.servo.desired, DESIRED, lw=2.5)
    draw_region(ax, run.truths[0], CURRENT, lw=2.5)
    for path in np.swapaxes(outlines, 0, 1):
        ax.plot(*path.T, ".-", color="black", lw=1, ms=3.5)


def _draw_errors(ax: Axes, times: Array, errors: Array, promised: Array) -> None:
    """The errors (T, 4) over time, and dotted those that the law promises."""
    styles = [*STYLES[:3], STYLES[5]]
    curves = zip(NAMES, errors.T, promised.T, styles, strict=True)
    dots = "." if len(times) <= FEW else ""  # many would fill the gaps of a dashed line
    for name, values, ideal, style in curves:
        ax.plot(times, values, marker=dots, ms=4, label=name, **style)
        ax.plot(times, ideal, ":", color=style["color"], lw=1.2)
    largest = 1.3 * np.abs(errors[0]).max()
    ax.set(xlim=(0, 6), ylim=(-largest, largest), ylabel="error")


def _draw_velocities(axes: Sequence[Axes], run: Run) -> None:
    """The six components of the camera's twist over time: three ways, three turns."""
    curves = list(zip(AXES, run.velocities.T, STYLES, strict=True))
    for ax, three in zip(axes, (curves[:3], curves[3:]), strict=True):
        for name, velocity, style in three:
            ax.step(run.times, velocity, where="post", label=name, **style)
    axes[0].set_ylabel("[m/s]")
    axes[1].set(xlabel="time [s]", ylabel="[rad/s]")


def _add_legend(ax: Axes) -> None:
    """One line above the axes, close together."""
    place = {"loc": "lower right", "bbox_to_anchor": (1, 0.97), "borderaxespad": 0}
    spaces = {"columnspacing": 1, "handlelength": 1.2, "handletextpad": 0.4}
    ax.legend(ncols=6, **place, **spaces)


def _approach_table(
    run: Run, errors: Array, promised: Array, outlines: Array
) -> pd.DataFrame:
    """A row for each frame: errors, what is promised, velocities, corners."""
    times = {"frame": np.arange(len(run.times)), "time [s]": run.times}
    names = [_plain(name) for name in NAMES]
    twist = [f"{_plain(name)} [{unit}]" for name, unit in zip(AXES, UNITS, strict=True)]
    corners = [f"corner {k} {axis} [px]" for k in range(4) for axis in "xy"]
    parts = [
        pd.DataFrame(times),
        pd.DataFrame(errors, columns=[f"error of {name}" for name in names]),
        pd.DataFrame(promised, columns=[f"promised of {name}" for name in names]),
        pd.DataFrame(run.velocities, columns=twist),
        pd.DataFrame(outlines.reshape(-1, 8), columns=corners),
    ]
    return pd.concat(parts, axis=1)
