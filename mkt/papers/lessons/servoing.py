"""Teaching figures of the chapters on servoing.

What a motion does to the image, how a loop closes, and where it is best tuned.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
import scipy
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from mkt.figures.registry import Shown, figure, grid_columns, shown
from mkt.papers import runs
from mkt.plotting import (
    CONTRAST,
    CURRENT,
    DASHES,
    DESIRED,
    SURFACE,
    draw_box,
    draw_region,
    pale,
    show_frame,
)
from mkt.servoing.controller import Servo
from mkt.servoing.features import error, features, interaction_matrix
from mkt.servoing.loop import Experiment, Run
from mkt.servoing.poles import closed_loop, one_feature
from mkt.servoing.robot import Workspace, move
from mkt.servoing.self_motion import OFF, RAW, Kalman
from mkt.types import Array, Frame, NDArray, Region

Poles: TypeAlias = NDArray[np.complexfloating]

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
# Of motions along and, dashed, about the three axes.
STYLES: list[dict[str, Any]] = [
    {"color": color, "ls": dash} for dash in DASHES[:2] for color in CONTRAST
]
PUSH = np.array([0.06] * 3 + [0.1, 0.1, 0.25])  # [m] and [rad]: far enough to be seen
FILTERS = {"off": OFF, "raw": RAW, "Kalman": Kalman()}
CAR = (0.0, 0.0, np.pi / 2)  # a place [m, rad]
HALVES = (50, 31.25)  # [px] of the car's image, half its sides
TABLE = "gravel"  # what one may look down on; the features do not look at it
STILL = ((0.0, *CAR),)
REAL, IMAGINARY = 1.9, 1.6  # how far the plane of the poles is shown
ROUNDING = 1e-6  # of the largest pole
LEAST = 16  # [cm] of the errors shown beside it, either way
MOST = 1e3  # [cm], larger errors are cut off: one that runs away would be infinite


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
    fig: Figure, *, x: int = 40, y: int = -25, turn: int = 90, scale: float = 1.0
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
    turn: int = 30,
) -> Shown:
    """Closing the loop on a car that stands still.

    Exact features, no compensation.  Left, the image: green the car at the start, red
    where it should appear, black the paths of its corners, a dot for each frame.  Right
    above, the errors at the time, which the controller knows only after the delay, and
    dotted the exponentials that (17) promises; below, how fast the camera moves and how
    fast it turns.  A loop that runs away is drawn as far as it sees the car.
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

    left = fig.add_axes((0.01, 0.02, 0.5, 0.9))
    _draw_approach(left, tried, run, outlines)
    left.set_title(f"gain x frame period = {gain / fps:.2f}")
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
    for name, values, ideal, style in curves:
        ax.plot(times, values, marker=".", ms=4, label=name, **style)
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


@figure(
    "own.root_locus",
    size=(10, 4.4),
    live=("own.root_locus",),
    gain=[0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0],
    delay=[0, 1, 2, 3],
    compensation=list(FILTERS),
    fps=[2.5, 5, 10, 25],
    mismatch=[0.25, 0.4, 0.6, 1.0, 1.5, 2.5],
)
def root_locus(
    fig: Figure,
    *,
    gain: float = 1.0,
    delay: int = 0,
    compensation: str = "off",
    fps: float = 5,
    mismatch: float = 1.0,
) -> Shown:
    """The poles of the closed loop against the gain, and its answer to a moving target.

    The target sets off, turns back and stops.  Left: a dot for every gain from 0 (dark)
    to 10 (bright), crosses at the chosen one.  Outside the unit circle the loop runs
    away; near 1 it is slow; at 0 are values that are stored for one frame.  Right: how
    far the camera is behind a target of 5 cm/s, in steps of a frame; grey the target's
    velocity.  Delay: frames from the exposure to the command; mismatch: how many times
    too large the interaction matrix is thought to be.
    """
    gains, poles = locus(compensation, delay, fps, mismatch)
    loop = closed_loop(gain, 1 / fps, FILTERS[compensation], delay, mismatch)
    chosen = loop.poles()
    radius = np.abs(chosen).max()
    times, velocity, error = answer(loop)

    left = fig.add_axes((0.065, 0.12, 0.38, 0.8))
    _draw_poles(left, gains, poles, chosen)
    _say_outside(left, chosen)
    beyond = radius - 1
    verdict = "stable" if beyond < 0 else "runs away"
    if abs(beyond) < ROUNDING:
        verdict = "at the limit"
    left.set_title(f"largest pole {radius:.2f}: {verdict}")
    right = fig.add_axes((0.545, 0.12, 0.435, 0.8))
    _draw_answer(right, times, velocity, error, bool(radius < 1))
    table = _pole_table(np.append(gains, gain), np.vstack([poles, chosen]))
    radii = np.abs(poles).max(1)
    answered = {
        "times": times,
        "velocity": velocity,
        "error": np.clip(error, -MOST, MOST),
    }
    return shown(table, radius=radius, radii=radii, gains=gains, **answered)


@lru_cache(maxsize=64)
def locus(
    compensation: str, delay: int, fps: float, mismatch: float
) -> tuple[Array, Poles]:
    """The poles of the closed loop for gains from 0 to 10.

    Parameters
    ----------
    compensation : str
        One of `FILTERS`.
    delay, fps, mismatch
        As for `mkt.servoing.poles.closed_loop`, at so many frames a second.

    Returns
    -------
    gains : (n,) array [1/s]
    poles : (n, p) array, complex
    """
    gains = np.linspace(0, 10, 26)
    kalman = FILTERS[compensation]
    loops = [closed_loop(gain, 1 / fps, kalman, delay, mismatch) for gain in gains]
    return gains, np.array([loop.poles() for loop in loops])


def answer(loop: Any) -> tuple[Array, Array, Array]:
    """What a loop makes of a target that sets off, turns back and stops.

    It does so after 1 s, 8 s and 12 s.

    Parameters
    ----------
    loop : control.StateSpace
        Of `mkt.servoing.poles.closed_loop`.

    Returns
    -------
    times : (T,) array [s]
    velocity : (T,) array [cm/s]
        Of the target.
    error : (T,) array [cm]
    """
    t = np.arange(0, 18, loop.dt)
    velocity = 5.0 * (t >= 1) - 10.0 * (t >= 8) + 5.0 * (t >= 12)
    error = scipy.signal.dlsim((loop.A, loop.B, loop.C, loop.D, loop.dt), velocity)[1]
    return t, velocity, error[:, 0]


def _draw_poles(ax: Axes, gains: Array, poles: Poles, chosen: Poles) -> None:
    """The unit circle, poles (n, p) in the colours of their gains, and crosses (p,)."""
    turn = np.linspace(0, 2 * np.pi, 100)
    ax.plot(np.cos(turn), np.sin(turn), color="0.5", lw=1)
    ax.axhline(0, color="0.8", lw=0.8, zorder=0)
    ax.axvline(0, color="0.8", lw=0.8, zorder=0)
    brightness = np.broadcast_to(gains[:, None], poles.shape)
    dots = ax.scatter(poles.real, poles.imag, c=brightness, s=9, cmap=SURFACE)
    bar = ax.inset_axes((1.03, 0.25, 0.03, 0.5))  # beside it: poles can be anywhere
    ax.figure.colorbar(dots, cax=bar, ticks=[0, 10])
    bar.set_title("gain\n[1/s]", fontsize=9, pad=5)
    ax.plot(chosen.real, chosen.imag, "x", color=MOVED, ms=9, mew=2.2)
    ax.set(xlim=(-REAL, REAL), ylim=(-IMAGINARY, IMAGINARY), aspect="equal")
    ax.set(xlabel="real part", ylabel="imaginary part")


def _say_outside(ax: Axes, chosen: Poles) -> None:
    """In words, that a chosen pole (p,) is not drawn: it decides the verdict."""
    if (np.abs(chosen.real) > REAL).any() or (np.abs(chosen.imag) > IMAGINARY).any():
        style = {"ha": "center", "va": "top", "color": "0.25"}
        ax.text(0, 0.95 * IMAGINARY, "a cross lies outside of this picture", **style)


def _draw_answer(
    ax: Axes, times: Array, velocity: Array, error: Array, settles: bool
) -> None:
    """The velocity of the target and the error of the loop, each (T,)."""
    label = "target's velocity [cm/s]"
    ax.step(times, velocity, where="post", color="0.6", lw=1.2, label=label)
    ax.step(times, error, where="post", color=CURRENT, lw=2, label="error [cm]")
    # Of one that runs away the beginning is shown.
    reach = max(LEAST, 1.05 * np.abs(error).max()) if settles else LEAST
    ax.set(xlim=(0, times[-1]), ylim=(-reach, reach), xlabel="time [s]")
    ax.legend(loc="lower left", ncols=2, bbox_to_anchor=(0, 1), borderaxespad=0.1)


def _pole_table(gains: Array, poles: Poles) -> pd.DataFrame:
    """A row for each pole (n, p), those of the chosen gain at the end."""
    axes = {"gain [1/s]": gains}, {"pole": np.arange(poles.shape[1])}
    parts = {"real part": poles.real, "imaginary part": poles.imag}
    chosen = np.arange(len(gains)) == len(gains) - 1
    marked = np.broadcast_to(chosen[:, None], poles.shape)
    return grid_columns(*axes, **parts, chosen=marked)


GAINS = np.array([0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0])  # [1/s]
RATIOS = np.array([0, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, np.inf])
COLORED = 0.2, 20.0  # [cm], errors below and above have the last colours
BRIGHT = 1.5  # [cm], from here on black letters are read more easily than white ones
AWAY = 100.0  # [cm], a loop that runs away
FEW = 8  # fields that are framed as the best; of more none is
SPEED, BACK = 5.0, 12.0  # of the target [cm/s], and when it turns back [s]
SETTLED = 3.0  # [s] before it turns back, longer than any swing of the loops
HANDS = 12  # the first exact; the right map averages over the noise of the others
# [cm] on the table, at the desired distance: the car is 20 cm and 100 px long.
PIXEL = 20 / 100


@figure(
    "own.loop_map",
    size=(10, 3.9),
    fps=[2.5, 5, 10, 25],
    rho=[0.0, 0.3, 0.9],
    delay=[0, 1, 2],
    jitter=[0.0, 1.0, 2.0, 5.0],
)
def loop_map(
    fig: Figure,
    *,
    fps: float = 5,
    rho: float = 0.3,
    delay: int = 0,
    jitter: float = 2.0,
) -> Shown:
    """Where to tune the loop: how far the camera is off, over the gain and Q / R.

    A target of 5 cm/s that turns back after 12 s.  Left, the largest error in the three
    seconds before it turns back, and in the middle that after it, both with exact
    features. Right, the root mean square of the true error all the way, when the
    features have a jitter of some pixels.  Q / R = 0 is no compensation, infinity the
    raw measurement. The numbers are the errors [cm], a dash one of more than a metre;
    white frames are round the smallest ones, where these are few.  The colours are
    logarithmic.
    """
    maps = [np.minimum(z, MOST) for z in loop_errors(fps, rho, delay, jitter)]
    noise = f"RMS, {jitter:g} px of noise"
    titles = ("before it turns back", "largest after it", noise)

    margins = {"left": 0.065, "right": 0.91, "bottom": 0.15, "top": 0.88}
    spaces = margins | {"wspace": 0.1}
    axes = fig.subplots(1, 3, sharey=True, gridspec_kw=spaces)
    meshes = [
        _draw_tuning(ax, z, title)
        for ax, z, title in zip(axes, maps, titles, strict=True)
    ]
    axes[0].set(ylabel="gain [1/s]", yticklabels=[f"{gain:g}" for gain in GAINS])
    bar = fig.add_axes((0.925, 0.15, 0.012, 0.73))
    scale = fig.colorbar(meshes[-1], cax=bar, label="error [cm]")
    ticks = (0.2, 0.5, 1, 2, 5, 10, 20)
    scale.set_ticks(ticks, labels=map(_short, ticks))
    steady, peak, noisy = maps
    columns = {"steady [cm]": steady, "peak [cm]": peak, "noisy [cm]": noisy}
    table = grid_columns({"gain [1/s]": GAINS}, {"Q / R": RATIOS}, **columns)
    return shown(table, steady=steady, peak=peak, noisy=noisy)


def _draw_tuning(ax: Axes, z: Array, title: str) -> Any:
    """A map (gains, ratios) [cm], its axes numbered.  Returns its mesh."""
    x = np.arange(len(RATIOS), dtype=float)
    y = np.arange(len(GAINS), dtype=float)
    drawn = np.clip(z, *COLORED)
    shades = {"cmap": SURFACE, "norm": LogNorm(*COLORED), "shading": "nearest"}
    mesh = ax.pcolormesh(x, y, drawn, **shades)
    style = {"ha": "center", "va": "center_baseline", "fontsize": 9.5}
    for (row, column), value in np.ndenumerate(z):
        color = "black" if value > BRIGHT else "white"
        ax.text(column, row, _in_field(value), color=color, **style)
    best = np.argwhere(z.round(2) == z.min().round(2))  # as the title says it
    for row, column in best if len(best) <= FEW else ():
        low = column - 0.46, row - 0.46
        ax.add_patch(Rectangle(low, 0.92, 0.92, fill=False, ec="white", lw=2))
    ax.set(xlabel="Q / R", title=f"{title}: {z.min():.2f} cm at best")
    ax.set_xticks(x, [_short(ratio) for ratio in RATIOS])
    ax.set_yticks(y)
    return mesh


def _in_field(error: float) -> str:
    """An error [cm] in two digits."""
    if error >= AWAY:
        return "\N{EN DASH}"
    return _short(round(error, 2 if error < 0.995 else 1 if error < 9.95 else 0))


def _short(ratio: float) -> str:
    """A ratio in few letters: ".01", "∞"."""
    return f"{ratio:g}".replace("inf", "∞").replace("0.", ".")


def loop_errors(
    fps: float,
    rho: float,
    delay: int,
    jitter: float,
) -> tuple[Array, Array, Array]:
    """The three maps (gains, ratios) [cm] of the figure `loop_map`.

    Parameters
    ----------
    fps, rho, delay, jitter
        As there.

    Returns
    -------
    steady, peak, noisy : (9, 9) arrays [cm]
        The largest error shortly before the target turns back, so that a swing cannot
        be caught at a zero, the largest one after it, and the root mean square with
        noise.
    """
    times = np.arange(0, 2 * BACK, 1 / fps)
    velocity = SPEED * np.where(times < BACK, 1, -1)
    back = np.searchsorted(times, BACK)
    normal = np.random.default_rng(0).standard_normal((len(times), HANDS))
    noise = jitter * PIXEL * normal
    noise[:, 0] = 0  # the first hand is exact
    cases = np.repeat(GAINS, HANDS), 1 / fps
    noises = np.tile(noise, len(GAINS))
    tried = [
        one_feature(*cases, Kalman(ratio, rho), velocity, noises, delay)
        for ratio in RATIOS
    ]
    e = np.abs(np.reshape(tried, (len(RATIOS), len(times), len(GAINS), HANDS)))
    e = e.transpose(2, 0, 1, 3)  # gains, ratios, times, hands
    exact, noisy = e[..., 0], e[..., 1:]
    steady = exact[..., back - round(SETTLED * fps) : back + 1].max(-1)
    peak = exact[..., back:].max(-1)
    return steady, peak, np.sqrt(np.mean(noisy**2, (2, 3)))
