"""Figures 8 to 11 of [T09]: a camera on a robot's hand follows a car.

Somebody drives the car to and fro.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from mkt.checks import check_known, is_number
from mkt.figures.registry import REGION, Shown, at_most, figure, shown
from mkt.papers import runs
from mkt.plotting import (
    CONTRAST,
    CURRENT,
    DESIRED,
    TRUTH,
    draw_box,
    draw_region,
    show_frame,
)
from mkt.regions import corners, wrap_angle
from mkt.servoing.controller import Servo
from mkt.servoing.features import Camera
from mkt.servoing.loop import Experiment, Run, view
from mkt.servoing.robot import Path, Workspace, circle, to_and_fro
from mkt.servoing.self_motion import OFF, RAW, Kalman
from mkt.trackers.by_name import TRACKERS
from mkt.types import Array, ArrayLike

# [s]: frames 30 and 37 at 5 frames a second, where the velocity changes in the print;
# that both are reversals is ours.
REVERSALS = (6.0, 7.4)
LENGTH = 17.0  # [s]; the car stops after 13
FEATURES = {  # how far off a perfect tracker's are made [px]
    "tracker": 0.0,
    "exact": 0.0,
    "1 px": 1.0,
    "2 px": 2.0,
    "3 px": 3.0,
    "5 px": 5.0,
}
COLOR, OFF_COLOR, MEASURED_COLOR = CONTRAST  # with compensation, without it, raw
CAR_COLOR = "0.45"
# Columns of tables.
CAR = ("car X [m]", "car Y [m]", "car theta [rad]")
CAMERA = ("camera X [m]", "camera Y [m]", "camera Z [m]")
ERRORS = ("error of x_n", "error of y_n")
_GAINS = [0.5, 1.0, 2.0]
_COMPENSATIONS = ["off", "raw", "Kalman"]
_DRIVEN = {"speed": [0.02, 0.05, 0.08], "seed": [0, 1, 2]}


def _round_and_round(seed: int, speed: float) -> Path:
    """A circle of 8 cm, on which every seed drives alike."""
    return circle(period=2 * np.pi * 0.08 / speed)


PATHS: dict[str, Callable[[int, float], Path]] = {
    "to and fro": to_and_fro,
    "circle": _round_and_round,
}


def experiment(
    gain: float = 1.0,
    compensation: str = "Kalman",
    ratio: float = 1.0,
    rho: float = 0.3,
    fps: float = 5,
    dof: int = 6,
    features: str = "tracker",
    speed: float = 0.05,
    motion: str = "to and fro",
    seed: int = 0,
) -> Experiment:
    """The `Experiment` behind a figure.

    Parameters
    ----------
    gain : float [1/s]
    compensation : str
        "off", "raw" or "Kalman".
    ratio, rho : float
        Of the Kalman filter, see `mkt.servoing.self_motion.Kalman`.
    fps : float [1/s]
        Frames a second.
    dof : int
        6 or 4, see `mkt.servoing.law.twist`.
    features : str
        One of `FEATURES`: "tracker" for the combination of 75 particles in the loop, or
        features that are exact or a little off.
    speed : float [m/s]
    motion : str
        One of `PATHS`.
    seed : int
        Of the path and of all noise.  The noise of features that are a little off is
        the same stream of numbers as the path's, which does not matter: with another
        one, the RMS errors of figure 10 at 1 px change by less than 1 %, over 200 seeds
        and for each compensation.

    Raises
    ------
    ValueError
        Naming the parameter.
    """
    filters = {"off": OFF, "raw": RAW, "Kalman": Kalman(ratio, rho)}
    check_known("compensation", compensation, filters)
    check_known("features", features, FEATURES)
    check_known("motion", motion, PATHS)
    if not (is_number(fps, 0) and fps > 0):
        raise ValueError(f"fps is {fps!r}; it must be positive, and finite")
    return Experiment(
        Servo(gain=gain, filter=filters[compensation], dt=1 / fps, dof=dof),
        path=PATHS[motion](seed, speed),
        frames=round(LENGTH * fps),
        tracker=TRACKERS["combined"] if features == "tracker" else None,
        jitter=FEATURES[features],
        seed=seed,
    )


def self_motion(run: Run, surface: float) -> Array:
    """The true de/dt of y_n, from every frame to the next.

    It is the car's velocity along the image's y over the root of its area.

    Parameters
    ----------
    run : Run
    surface : float [m^2]
        The area of the car.

    Returns
    -------
    (T - 1,) array [1/s]
    """
    velocity = np.diff(run.cars[:, :2], axis=0) / np.diff(run.times)[:, None]
    return np.sum(velocity * run.poses[:-1, :2, 1], 1) / np.sqrt(surface)


def rms(values: ArrayLike) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def draw_view(ax: Axes, experiment: Experiment, run: Run, k: int, title: str) -> None:
    """What the camera sees in frame k of a run.

    Red where the car should appear, green where it was found.
    """
    show_frame(ax, view(experiment, run, k), title)
    draw_box(ax, experiment.servo.desired, DESIRED, lw=2)
    draw_region(ax, run.regions[k], CURRENT, lw=2)


@figure(
    "teuliere2009.fig8",
    size=(10, 4.6),
    frame=(0, 84, 1),
    motion=list(PATHS),
    gain=_GAINS,
    seed=[0, 1, 2],
)
def fig8(
    fig: Figure,
    *,
    frame: int = 33,
    motion: str = "to and fro",
    gain: float = 1.0,
    seed: int = 0,
) -> Shown:
    """Tracking a moving object.

    Simulated: the paper has a photograph of its gantry robot.  Left, the table with the
    car (grey) and its path (black), and above it the camera with what it sees (green);
    its own path is green too, drawn up to the frame.  Right, the camera's view: red
    where the car should appear, green where the combination of 75 particles finds it.
    """
    tried = experiment(gain=gain, motion=motion, seed=seed)
    run = runs.loop_run(tried)
    at_most(len(run.errors) - 1, frame=frame)
    error = run.errors[frame]

    scene = fig.add_axes((0.0, 0.03, 0.5, 0.97), projection="3d")
    _draw_scene(scene, tried.workspace, run, frame)
    ax = fig.add_axes((0.51, 0.03, 0.48, 0.85))
    x, y = (f"{v + 0.0:.3f}".replace("-", "−") for v in error[:2].round(3).tolist())
    errors = f"$e_{{xn}}$ = {x}, $e_{{yn}}$ = {y}"
    draw_view(ax, tried, run, frame, f"frame {frame}: {errors}")
    camera = run.poses[:, :3, 3]
    return shown(_path_table(run), camera=camera, car=run.cars, error=error)


def _path_table(run: Run) -> pd.DataFrame:
    """Where car and camera are in each frame, and the errors."""
    columns = _frames(run)
    columns |= _named(CAR, run.cars)
    columns |= _named(CAMERA, run.poses[:, :3, 3])
    columns |= _named(ERRORS, run.errors[:, :2])
    return pd.DataFrame(columns | {"lost": run.lost})


def _named(names: Sequence[str], values: Array) -> dict[str, Array]:
    """The columns of an array (T, n) by their names."""
    return dict(zip(names, values.T, strict=True))


def _frames(run: Run) -> dict[str, Any]:
    """The columns with which the table of a run begins."""
    return {"frame": np.arange(len(run.times)), "time [s]": run.times}


def _draw_scene(ax: Any, workspace: Workspace, run: Run, k: int) -> None:
    """Car and camera in frame k of a run, in three dimensions."""
    _draw_camera(ax, workspace.camera, run.poses[k])
    _draw_car(ax, workspace, run.cars[k])
    ax.plot(run.cars[:, 0], run.cars[:, 1], 0, color=TRUTH, lw=1.1)
    ax.plot(*run.poses[: k + 1, :3, 3].T, color=CURRENT, lw=2)
    places = np.concatenate([run.cars[:, :2], run.poses[:, :2, 3]])
    _fit_table(ax, places)


def _draw_camera(ax: Any, camera: Camera, pose: Array) -> None:
    """A small pyramid round the lens, and what the camera sees of the table."""
    width, height = camera.size
    pixels = [[0, 0, 1], [width, 0, 1], [width, height, 1], [0, height, 1]]
    rays = np.linalg.solve(camera.matrix, np.array(pixels, float).T)
    centre, rays = pose[:3, 3], (pose[:3, :3] @ rays).T
    seen = centre - rays * centre[2] / rays[:, 2:]
    ax.add_collection3d(Poly3DCollection([seen], facecolor=CURRENT, alpha=0.12))
    base = centre + 0.12 * rays
    edges = zip(base, np.roll(base, -1, 0), strict=True)
    sides = [[centre, *edge] for edge in edges]
    style = {"facecolor": CURRENT, "edgecolor": "black", "lw": 0.8, "alpha": 0.7}
    ax.add_collection3d(Poly3DCollection(sides, **style))
    for corner in seen:
        ax.plot(*np.transpose([centre, corner]), color=CURRENT, lw=0.6, alpha=0.7)


def _draw_car(ax: Any, workspace: Workspace, car: Array) -> None:
    """The car at its place (3,) on the table."""
    outline = corners(np.array([*car, *(workspace.sides / 2)]))
    body = np.column_stack([outline, np.zeros(4)])
    style = {"facecolor": CAR_COLOR, "edgecolor": "black", "lw": 0.8}
    ax.add_collection3d(Poly3DCollection([body], **style))


def _fit_table(ax: Any, places: Array) -> None:
    """Limits and labels of a square of the table round places (n, 2) [m]."""
    middle = (places.min(0) + places.max(0)) / 2
    half = max(np.ptp(places, 0).max() / 2, 0.1) + 0.2
    x, y = middle[:, None] + np.array([[-half, half], [half, -half]])
    ax.set(xlim=x, ylim=y, zlim=(0, -1.0))
    ax.set(xlabel="X [m]", ylabel="Y [m]", zlabel="Z [m]")
    ax.zaxis.set_tick_params(pad=6)  # clear of the ticks, which look like minus signs
    ax.zaxis.labelpad = 12
    ax.locator_params(nbins=4)
    ax.set_box_aspect((2 * half, 2 * half, 1.0), zoom=0.88)
    ax.view_init(22, -35)


@figure(
    "teuliere2009.fig9",
    size=(10, 4.2),
    grid=("ratio", "features"),
    ratio=[0.0, 0.05, 0.2, 1.0, 100.0],
    rho=[0.0, 0.3, 0.9],
    features=list(FEATURES),
    **_DRIVEN,
)
def fig9(
    fig: Figure,
    *,
    ratio: float = 1.0,
    rho: float = 0.3,
    features: str = "tracker",
    speed: float = 0.05,
    seed: int = 0,
) -> Shown:
    """Measured and estimated velocity of y_n due to the object's self-motion.

    Simulated: the car is driven to and fro along y at 5 frames a second, with sudden
    reversals (dashed) at frames 30 and 37, where the printed velocity changes, too.
    Dots: (18) and (19); blue: the
    Kalman filter; black: the truth, which the paper could not know, from each frame to
    the next.
    """
    tried = experiment(ratio=ratio, rho=rho, features=features, speed=speed, seed=seed)
    run = runs.loop_run(tried)
    truth = self_motion(run, tried.workspace.surface)
    measured = run.measured[1:, 1]
    estimated = run.estimated[1:, 1]
    off = rms(measured - truth), rms(estimated - truth)

    ax = fig.add_axes((0.07, 0.13, 0.91, 0.76))
    _mark_reversals(ax, 5)
    ax.axhline(0, color="0.6", lw=0.8)
    _draw_velocities(ax, truth, measured, run.estimated[:, 1])
    title = f"RMS off the truth: {off[0]:.3f} measured, {off[1]:.3f} estimated"
    ax.set_title(title, loc="right")
    velocities = {
        "truth [1/s]": np.append(np.nan, truth),
        "measured [1/s]": run.measured[:, 1],
        "estimated [1/s]": run.estimated[:, 1],
    }
    facts = {"measured": measured, "estimated": estimated, "truth": truth}
    return shown(_frames(run) | velocities, **facts, off=off)


def _draw_velocities(ax: Axes, truth: Array, measured: Array, estimated: Array) -> None:
    """Velocities [1/s] over the frames: true and measured (T - 1,), estimated (T,)."""
    later = np.arange(1, len(estimated))
    ax.step(later, truth, where="pre", color=TRUTH, lw=1.1, label="truth")
    ax.plot(later, measured, "o", ms=3.5, color=MEASURED_COLOR, label="measured")
    ax.plot(estimated, color=COLOR, lw=2, label="estimated")
    ax.set(xlim=(0, later[-1] + 0.5), xlabel="frame")
    largest = max(1, 1.1 * np.nanmax(np.abs([*measured, *estimated])))
    ax.set(ylim=(-largest, largest), ylabel=r"velocity of $y_n$ [1/s]")
    ax.legend(loc="lower left", ncols=3, bbox_to_anchor=(0, 1), borderaxespad=0.1)


def _mark_reversals(ax: Axes, fps: float) -> None:
    for time in REVERSALS:
        ax.axvline(time * fps, color="0.4", lw=0.9, ls="--")


@figure(
    "teuliere2009.fig10",
    size=(10, 5.4),
    compensation=_COMPENSATIONS,
    gain=_GAINS,
    fps=[2.5, 5, 10, 25],
    dof=[6, 4],
    features=list(FEATURES),
    **_DRIVEN,
)
def fig10(
    fig: Figure,
    *,
    compensation: str = "Kalman",
    gain: float = 1.0,
    fps: float = 5,
    dof: int = 6,
    features: str = "tracker",
    speed: float = 0.05,
    seed: int = 0,
) -> Shown:
    """Error of the x_n and y_n features.

    Simulated: the drive of figure 9, reversals dashed.  Thick: with the compensation
    that is chosen; thin, orange: without any.  Dotted: the error V / gain that the
    theory foretells without compensation, V the car's mean speed in units of y_n.  At
    the right the same errors as the car's distance from where it should appear, in
    pixels.  The paper's caption names no second curve.  A loop that runs away is drawn
    as far as it sees the car.
    """
    conditions = {"gain": gain, "fps": fps, "dof": dof, "features": features}
    conditions |= {"speed": speed, "seed": seed}
    chosen, without = (
        experiment(compensation=one, **conditions) for one in (compensation, "off")
    )
    errors, reference = (
        runs.loop_run(one, until_lost=True).errors[:, :2] for one in (chosen, without)
    )
    lag = speed / np.sqrt(chosen.workspace.surface) / gain

    margins = {"left": 0.075, "right": 0.92, "bottom": 0.1, "top": 0.9}
    spaces = margins | {"hspace": 0.12}
    heights = (1.6, 1)
    axes = fig.subplots(2, 1, sharex=True, height_ratios=heights, gridspec_kw=spaces)
    for ax, name, k in zip(axes, ("y", "x"), (1, 0), strict=True):
        _mark_reversals(ax, fps)
        ax.axhline(0, color=DESIRED, lw=1)
        ax.plot(reference[:, k], color=OFF_COLOR, lw=1.2, label="compensation off")
        if compensation != "off":
            words = f"compensation {compensation}"
            ax.plot(errors[:, k], color=COLOR, lw=2.2, label=words)
        ax.set(xlim=(0, chosen.frames - 1), ylabel=f"error of ${name}_n$")
        _add_pixels(ax, _pixels(chosen))
    largest = max(np.abs(reference).max(), np.abs(errors).max(), lag)
    across = max(np.abs(reference[:, 0]).max(), np.abs(errors[:, 0]).max())
    _finish_errors(axes, lag, (largest, across), fps)
    n = min(len(errors), len(reference))  # one may have run away
    found = rms(errors[:n, 1]), rms(reference[:n, 1])
    beside = "" if compensation == "off" else f", off {found[1]:.3f}"
    title = f"RMS of $e_{{yn}}$: {found[0]:.3f}{beside}"
    axes[0].set_title(title, loc="right")
    table = _error_table({compensation: errors, "off": reference}, chosen)
    return shown(table, errors=errors, without=reference, lag=lag, rms=found)


def _pixels(experiment: Experiment) -> float:
    """How many pixels make one unit of x_n and y_n at the desired distance."""
    return experiment.workspace.camera.focal / experiment.servo.goal[2]


def _add_pixels(ax: Axes, pixels: float) -> None:
    """An axis at the right on which so many pixels are one unit."""

    def from_pixels(values):
        return values / pixels

    def to_pixels(values):
        return values * pixels

    axis = ax.secondary_yaxis("right", functions=(to_pixels, from_pixels))
    axis.set_ylabel("[px]")


def _finish_errors(
    axes: Sequence[Axes], lag: float, largest: tuple[float, float], fps: float
) -> None:
    """Limits and legend of figure 10, and the error that the theory foretells.

    The largest errors of all, and of x_n.
    """
    tall = 1.1 * largest[0]
    upper, lower = axes
    for sign in (-1, 1):
        upper.axhline(sign * lag, color="0.3", lw=1, ls=":")
    upper.set(ylim=(-tall, tall))
    upper.legend(loc="lower left", ncols=2, bbox_to_anchor=(0, 1), borderaxespad=0.1)
    low = max(tall / 2, 1.1 * largest[1])
    lower.set(ylim=(-low, low))
    lower.set_xlabel(f"frame, {fps:g} per second")


def _error_table(errors: Mapping[str, Array], experiment: Experiment) -> pd.DataFrame:
    """A row for each frame of the errors (T, 2) of each compensation."""
    tables = [pd.DataFrame(values, columns=ERRORS) for values in errors.values()]
    keys = ["compensation", "frame"]
    table = pd.concat(tables, keys=list(errors), names=keys).reset_index()
    table.insert(2, "time [s]", experiment.servo.dt * table["frame"])
    for name in ERRORS:
        table[f"{name} [px]"] = _pixels(experiment) * table[name]
    return table


@figure(
    "teuliere2009.fig11",
    size=(10, 2.6),
    compensation=_COMPENSATIONS,
    gain=_GAINS,
    dof=[6, 4],
    **_DRIVEN,
)
def fig11(
    fig: Figure,
    *,
    compensation: str = "Kalman",
    gain: float = 1.0,
    dof: int = 6,
    speed: float = 0.05,
    seed: int = 0,
) -> Shown:
    """Internal view.

    Simulated: the run of figure 9.  Red where the car should appear, green where the
    tracker finds it: (a) and (b) in steady motion, (c) where the error is largest in
    the second after the second reversal, (d) the final position.  The camera turns with
    the car, so that the table seems to move.
    """
    tried = experiment(gain, compensation, dof=dof, speed=speed, seed=seed)
    run = runs.loop_run(tried)
    frames = instants(run)
    wrong = (run.truths - tried.servo.desired)[frames]
    off = np.hypot(*wrong[:, :2].T)
    turn = np.rad2deg(wrap_angle(wrong[:, 2]))

    margins = {"left": 0.005, "right": 0.995, "bottom": 0.01, "top": 0.88}
    axes = fig.subplots(1, 4, gridspec_kw=margins | {"wspace": 0.03})
    for ax, letter, k, px in zip(axes, "abcd", frames, off, strict=True):
        draw_view(ax, tried, run, k, f"({letter}) frame {k}: {px:.1f} px off")
    columns = {"panel": list("abcd"), "frame": frames, "time [s]": run.times[frames]}
    columns |= {"off [px]": off, "turned [deg]": turn}
    columns |= _named(REGION, run.regions[frames])
    return shown(columns, frames=frames, off=off, turn=turn, lost=run.lost)


def instants(run: Run) -> list[int]:
    """The frames of figure 11.

    Twice in steady motion, the largest error in the second after the second reversal,
    the last.
    """
    first, second = REVERSALS
    steady, reversal, again = np.searchsorted(run.times, (4.0, first, second))
    soon = run.times[again:] <= second + 1
    worst = again + np.argmax(np.abs(run.errors[again:, 1]) * soon)
    return [int(steady), int(reversal) - 1, int(worst), len(run.times) - 1]
