"""Teaching figures of the chapters on servoing: what a motion does to the image, how a loop closes, and where it is best tuned."""

from functools import lru_cache

import numpy as np
from scipy.signal import dlsim

from mkt.figures import figure
from mkt.figures.teuliere2009_servoing import while_it_sees
from mkt.kalman import OFF, RAW, Kalman, closed_loop
from mkt.loop import Experiment, Servo
from mkt.plotting import CONTRAST, CURRENT, DASHES, DESIRED, draw_box, draw_map, draw_region, show_frame
from mkt.robot import Workspace, move
from mkt.servo import interaction_matrix

AXES = ("$v_x$", "$v_y$", "$v_z$", r"$\omega_x$", r"$\omega_y$", r"$\omega_z$")
MOTIONS = ("moves right", "moves down", "moves forward", "looks up", "looks right", "rolls clockwise")
NAMES = ("$x_n$", "$y_n$", "$a_n$", r"$\theta$")
MOVED = CONTRAST[1]
STYLES = [{"color": color, "ls": dash} for dash in DASHES[:2] for color in CONTRAST]  # of motions along and, dashed, about the three axes
PUSH = np.array([0.06] * 3 + [0.1, 0.1, 0.25])  # [m] and [rad]: far enough to be seen
FILTERS = {"off": OFF, "raw": RAW, "Kalman": Kalman()}
CAR = (0.0, 0.0, np.pi / 2)  # a place [m, rad]
STILL = ((0.0, *CAR),)


@figure("own.interaction", size=(10, 6.1), grid=("x", "y"), x=(-80, 80, 20), y=(-50, 50, 25), turn=(0, 180, 30), scale=[0.5, 0.75, 1.0, 1.25])
def interaction(canvas, *, x=40, y=-25, turn=90, scale=1.0):
    """The columns of the interaction matrix, as the motion that each velocity of the camera causes in the image.

    Green: the car now.  Orange: where it is after the camera alone has moved by 6 cm or turned by 0.1 rad (0.25 rad about its optical axis); arrows: the
    paths of its corners.  Below each view its column of L: by how much the features change in a second at 1 m/s or 1 rad/s.  The sliders place, turn and
    scale the car in the image.
    """
    workspace = Workspace(exposure=0.0)
    region = np.array([159.5 + x, 119.5 + y, np.deg2rad(turn), 50 * scale, 31.25 * scale])
    pose = workspace.facing(region, CAR)
    L = interaction_matrix(region, workspace.camera, workspace.surface)
    image = workspace.frame(pose, np.zeros(6), STILL, 0, np.random.default_rng(0))
    axes = canvas.subplots(2, 3, gridspec_kw={"left": 0.01, "right": 0.99, "bottom": 0.09, "top": 0.95, "hspace": 0.34, "wspace": 0.04})
    outlines = []
    for k, ax in enumerate(axes.flat):
        outlines.append(paths_of_corners(workspace, pose, k))
        show_frame(ax, 255 - (255 - image) // 2, f"{AXES[k]}: the camera {MOTIONS[k]}")
        _draw_motion(ax, region, outlines[-1])
        ax.text(0.5, -0.03, column(L[:, k]), transform=ax.transAxes, ha="center", va="top")
    return {"L": L, "outlines": outlines}


def paths_of_corners(workspace, pose, k, steps=8):
    """The car's corners (steps + 1, 4, 2) [px] while the camera moves by `PUSH` along or about one of its axes."""
    return np.array([workspace.outline(move(pose, PUSH * (np.arange(6) == k), part), CAR) for part in np.linspace(0, 1, steps + 1)])


def column(values):
    """A column of L (4,) as text, every entry behind its feature."""
    entries = [f"{name} {value:+.2f}".replace("-", "−") if abs(value) > 5e-4 else f"{name} 0" for name, value in zip(NAMES, values)]
    return ",  ".join(entries)


def _draw_motion(ax, region, outlines):
    draw_box(ax, region, CURRENT, lw=2)
    ax.plot(*outlines[-1][[0, 1, 2, 3, 0]].T, color=MOVED, lw=2)
    for path in np.swapaxes(outlines, 0, 1):
        ax.plot(*path.T, color="black", lw=1.2)
        if np.hypot(*(path[-1] - path[0])) > 3:
            ax.annotate("", path[-1], path[-2], arrowprops={"arrowstyle": "-|>", "color": "black", "lw": 1.2, "shrinkA": 0, "shrinkB": 0})
    ax.set(xlim=(-0.5, 319.5), ylim=(239.5, -0.5))


@figure("own.approach", size=(10, 4.6), grid=("gain", "fps"), gain=[0.25, 0.5, 1.0, 2.0, 4.0, 6.0], fps=[2.5, 5, 10, 25], delay=[0, 1, 2, 3], dof=[6, 4], turn=(-90, 90, 30))
def approach(canvas, *, gain=1.0, fps=5, delay=0, dof=6, turn=30):
    """Closing the loop on a car that stands still.

    Exact features, no compensation.  Left, the image: green the car at the start, red where it should appear, black the paths of its corners, a dot a
    frame.  Right above, the errors, and dotted what (17) promises, their start times exp(-gain t); below, the camera's velocities.  A loop that runs away
    is drawn as far as it sees the car.
    """
    start = (0.05, -0.06, -0.12, 0.0, 0.0, np.deg2rad(turn))
    x = Experiment(Servo(gain=gain, dt=1 / fps, delay=delay, dof=dof, filter=OFF), path=STILL, start=start, frames=round(6 * fps) + 1)
    r = while_it_sees(x)
    left = canvas.add_axes((0.01, 0.02, 0.5, 0.9))
    image = x.workspace.frame(r.poses[0], np.zeros(6), STILL, 0, np.random.default_rng(0))
    show_frame(left, 255 - (255 - image) // 2, f"gain x frame period = {gain / fps:.2f}")
    draw_region(left, x.servo.desired, DESIRED, lw=2.5)
    draw_region(left, r.truths[0], CURRENT, lw=2.5)
    for path in np.swapaxes([x.workspace.outline(pose, CAR) for pose in r.poses], 0, 1):
        left.plot(*path.T, ".-", color="black", lw=1, ms=3.5)
    left.set(xlim=(-0.5, 319.5), ylim=(239.5, -0.5))
    upper, lower = canvas.subplots(2, 1, sharex=True, gridspec_kw={"left": 0.59, "right": 0.985, "bottom": 0.11, "top": 0.93, "hspace": 0.2})
    for e, name, style in zip(r.errors.T, NAMES, [*STYLES[:3], STYLES[5]]):
        upper.plot(r.times, e, marker=".", ms=4, label=name, **style)
        upper.plot(r.times, e[0] * np.exp(-gain * r.times), ":", color=style["color"], lw=1.2)
    for v, name, style in zip(r.velocities.T, AXES, STYLES):
        lower.step(r.times, v, where="post", label=name, **style)
    largest = 1.3 * np.abs(r.errors[0]).max()
    upper.set(ylim=(-largest, largest), ylabel="error", xlim=(0, 6))
    lower.set(ylabel="velocity [m/s, rad/s]", xlabel="time [s]")
    for ax in (upper, lower):
        ax.axhline(0, color="0.6", lw=0.8, zorder=0)
        ax.legend(ncols=6, loc="lower right", bbox_to_anchor=(1, 0.97), borderaxespad=0, columnspacing=1, handlelength=1.2, handletextpad=0.4)
    return {"errors": r.errors, "velocities": r.velocities, "times": r.times}


@figure("own.root_locus", size=(10, 4.4), grid=("gain", "delay"), gain=[0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0], delay=[0, 1, 2, 3], compensation=list(FILTERS), fps=[2.5, 5, 10, 25],
        mismatch=[0.25, 0.4, 0.6, 1.0, 1.5, 2.5])
def root_locus(canvas, *, gain=1.0, delay=0, compensation="off", fps=5, mismatch=1.0):
    """The poles of the closed loop against the gain, and how the loop answers a target that sets off, turns back and stops.

    Left: a dot for every gain from 0 (dark) to 10 (bright), crosses at the chosen one.  Outside the unit circle the loop runs away; near 1 it is slow.
    Right: how far the camera is behind a target of 5 cm/s, in steps of a frame; grey the target's velocity.  Delay: frames from the exposure to
    the command; mismatch: how many times too large the interaction matrix is thought to be.
    """
    gains, poles = locus(compensation, delay, fps, mismatch)
    loop = closed_loop(gain, 1 / fps, FILTERS[compensation], delay, mismatch)
    chosen, (t, velocity, error) = loop.poles(), answer(loop)
    left = canvas.add_axes((0.07, 0.12, 0.38, 0.8))
    left.plot(*np.exp(1j * np.linspace(0, 2 * np.pi, 100)).view(float).reshape(-1, 2).T, color="0.5", lw=1)
    left.axhline(0, color="0.8", lw=0.8, zorder=0)
    left.axvline(0, color="0.8", lw=0.8, zorder=0)
    left.scatter(poles.real, poles.imag, c=np.broadcast_to(gains[:, None], poles.shape), s=9, cmap="viridis")
    left.plot(chosen.real, chosen.imag, "x", color=MOVED, ms=9, mew=2.2)
    left.set(xlim=(-1.9, 1.9), ylim=(-1.6, 1.6), aspect="equal", xlabel="real part", ylabel="imaginary part",
             title=f"largest pole {np.abs(chosen).max():.2f}: {'stable' if np.abs(chosen).max() < 1 else 'runs away'}")
    right = canvas.add_axes((0.53, 0.12, 0.45, 0.8))
    right.step(t, velocity, where="post", color="0.6", lw=1.2, label="target's velocity [cm/s]")
    right.step(t, error, where="post", color=CURRENT, lw=2, label="error [cm]")
    right.set(xlim=(0, t[-1]), ylim=(-16, 16), xlabel="time [s]")
    right.legend(loc="lower left", ncols=2, bbox_to_anchor=(0, 1), borderaxespad=0.1)
    return {"radius": np.abs(chosen).max(), "error": np.clip(error, -1e3, 1e3), "radii": np.abs(poles).max(1), "gains": gains}


@lru_cache(maxsize=64)
def locus(compensation, delay, fps, mismatch):
    """Gains (n,) [1/s] and the poles of the closed loop at each (n, p), complex."""
    gains = np.linspace(0, 10, 26)
    return gains, np.array([closed_loop(gain, 1 / fps, FILTERS[compensation], delay, mismatch).poles() for gain in gains])


def answer(loop):
    """Times (T,) [s], the velocity (T,) [cm/s] of a target that sets off after 1 s, turns back after 8 s and stops after 12 s, and the loop's error (T,) [cm]."""
    t = np.arange(0, 18, loop.dt)
    velocity = 5.0 * (t >= 1) - 10.0 * (t >= 8) + 5.0 * (t >= 12)
    _, error, _ = dlsim((loop.A, loop.B, loop.C, loop.D, loop.dt), velocity)
    return t, velocity, error[:, 0]


GAINS = np.array([0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0])  # [1/s]
RATIOS = np.array([0, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, np.inf])
WORST = 5.0  # [cm], where the colours end
HANDS = 12  # noises, over which the right map averages
PIXEL = 20 / 100  # [cm] on the table, at the desired distance: the car is 20 cm and 100 px long


@figure("own.loop_map", size=(10, 3.9), fps=[2.5, 5, 10, 25], rho=[0.0, 0.3, 0.9], delay=[0, 1, 2], jitter=[0.0, 1.0, 2.0, 5.0])
def loop_map(canvas, *, fps=5, rho=0.3, delay=0, jitter=2.0):
    """Where to tune the loop: how far the camera is off, over the gain and Q / R.

    A target of 5 cm/s that turns back after 12 s.  Left, the error before it turns back, and in the middle the largest one after that, both with exact
    features.  Right, the root mean square of the true error all the way, when the features are off by `jitter` pixels.  Q / R = 0 is no compensation,
    infinity the raw measurement; a cross marks the smallest error.  Bright yellow: 5 cm or more.
    """
    steady, peak, noisy = loop_errors(fps, rho, delay, jitter)
    axes = canvas.subplots(1, 3, sharey=True, gridspec_kw={"left": 0.065, "right": 0.91, "bottom": 0.15, "top": 0.88, "wspace": 0.1})
    for ax, z, title in zip(axes, (steady, peak, noisy), ("before it turns back", "largest after it", f"RMS, {jitter:g} px of noise")):
        mesh = draw_map(ax, np.arange(len(RATIOS)), np.arange(len(GAINS)), np.minimum(z, WORST).round(2), (0, WORST), xlabel="Q / R", title=f"{title}: {z.min():.2f} cm at best",
                        xticks=range(len(RATIOS)), yticks=range(len(GAINS)))
        ax.set_xticklabels([f"{r:g}".replace("inf", "∞").replace("0.", ".") for r in RATIOS])
    axes[0].set(ylabel="gain [1/s]", yticklabels=[f"{g:g}" for g in GAINS])
    canvas.colorbar(mesh, cax=canvas.add_axes((0.925, 0.15, 0.012, 0.73)), label="error [cm]")
    return {"steady": np.minimum(steady, 1e3), "peak": np.minimum(peak, 1e3), "noisy": np.minimum(noisy, 1e3)}


def loop_errors(fps, rho, delay, jitter, speed=5.0, turn=12.0):
    """Three maps (gains, ratios) [cm] of the figure `loop_map`."""
    t = np.arange(0, 2 * turn, 1 / fps)
    velocity, back = speed * np.where(t < turn, 1, -1), np.searchsorted(t, turn)
    noise = jitter * PIXEL * np.random.default_rng(0).standard_normal((len(t), HANDS))
    noise[:, 0] = 0  # the first hand is exact
    gains = np.repeat(GAINS, HANDS)
    e = np.array([one_feature(gains, 1 / fps, Kalman(ratio, rho), velocity, np.tile(noise, len(GAINS)), delay) for ratio in RATIOS])
    e = np.abs(e.reshape(len(RATIOS), len(t), len(GAINS), HANDS)).transpose(2, 0, 1, 3)
    exact, noisy = e[..., 0], e[..., 1:]
    return exact[..., back], exact[..., back:].max(-1), np.sqrt(np.mean(noisy**2, (2, 3)))


def one_feature(gain, dt, filter, velocity, noise, delay=0):
    """The servo loop of one feature for n cases side by side: (17) to (19), as `mkt.loop` closes it and `mkt.kalman.closed_loop` describes it.

    gain: (n,) [1/s]; velocity: (T,) of the target; noise: (T, n) of what is measured.  Returns the true error (T, n).
    """
    n = len(gain)
    e, seen, sent, state, history = np.zeros(n), [], [np.zeros(n)] * (delay + 1), np.zeros((2, n)), []
    for k, v in enumerate(velocity):
        history.append(e)
        seen.append(e + noise[k])
        now, before = seen[max(k - delay, 0)], seen[max(k - delay - 1, 0)]
        if k:
            state = filter.step(state, (now - before) / dt + sent[-1 - delay])
        sent.append(gain * now + state[0])
        e = e + dt * (v - sent[-1])
    return np.array(history)
