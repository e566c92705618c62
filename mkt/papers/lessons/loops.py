"""Teaching figures of the control loop: its poles, its answer, its best tuning."""

from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
import scipy
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from mkt.checks import locked
from mkt.figures.registry import Shown, figure, grid_columns, shown
from mkt.plotting import CONTRAST, CURRENT, SURFACE
from mkt.servoing.poles import closed_loop, one_feature
from mkt.servoing.self_motion import OFF, RAW, Kalman
from mkt.types import Array, NDArray

Poles: TypeAlias = NDArray[np.complexfloating]

FILTERS = {"off": OFF, "raw": RAW, "Kalman": Kalman()}
CHOSEN = CONTRAST[1]  # the crosses of the gain
REAL, IMAGINARY = 1.9, 1.6  # how far the plane of the poles is shown
ROUNDING = 1e-6  # of the largest pole
LEAST = 16  # [cm] of the errors shown beside it, either way
MOST = 1e3  # [cm], larger errors are cut off: one that runs away would be infinite


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

    The target sets off, turns back and stops.  First a dot for every gain from 0 (dark)
    to 10 (bright), crosses at the chosen one.  Outside the unit circle the loop runs
    away; near 1 it is slow; at 0 are values that are stored for one frame.  Then how
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
    left.set_title(f"largest pole {_in_places(radius)}: {verdict}")
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
    return locked(gains), locked(np.array([loop.poles() for loop in loops]))


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
    ax.plot(chosen.real, chosen.imag, "x", color=CHOSEN, ms=9, mew=2.2)
    ax.set(xlim=(-REAL, REAL), ylim=(-IMAGINARY, IMAGINARY), aspect="equal")
    ax.set(xlabel="real part", ylabel="imaginary part")


def _in_places(radius: float) -> str:
    """Three of them, or more where it would seem to be at the limit."""
    places = next((n for n in range(3, 7) if round(radius, n) != 1), 3)
    return f"{radius:.{places}f}"


def _say_outside(ax: Axes, chosen: Poles) -> None:
    """In words, that a chosen pole (p,) is not drawn: it decides the verdict."""
    outside = (np.abs(chosen.real) > REAL) | (np.abs(chosen.imag) > IMAGINARY)
    if outside.any():
        who = "a cross lies" if outside.sum() == 1 else "crosses lie"
        paper = {"fc": "white", "ec": "none", "pad": 1.5}  # over the dots
        style = {"ha": "center", "va": "top", "color": "0.25", "bbox": paper}
        ax.text(0, 0.95 * IMAGINARY, f"{who} outside of this picture", **style)


def _draw_answer(
    ax: Axes, times: Array, velocity: Array, error: Array, settles: bool
) -> None:
    """The velocity of the target and the error of the loop, each (T,)."""
    label = "target's velocity [cm/s]"
    ax.step(times, velocity, where="post", color="0.6", lw=1.2, label=label)
    # Of one that runs away the beginning is shown, up to where it first goes beyond.
    reach = max(LEAST, 1.05 * np.abs(error).max()) if settles else LEAST
    beyond = np.append(np.flatnonzero(np.abs(error) > reach), len(error))[0] + 1
    style = {"color": CURRENT, "lw": 2, "label": "error [cm]"}
    ax.step(times[:beyond], error[:beyond], where="post", **style)
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
