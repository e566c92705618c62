"""Figures 8 to 11 of [T09]: a camera on a robot's hand follows a car that is driven to and fro."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from mkt import loop
from mkt.figures import figure
from mkt.kalman import OFF, RAW, Kalman
from mkt.loop import Experiment, Servo, view
from mkt.plotting import CONTRAST, CURRENT, DESIRED, TRUTH, draw_box, draw_region, show_frame
from mkt.regions import corners, wrap_angle
from mkt.robot import circle, to_and_fro
from mkt.trackers.catalogue import get

REVERSALS = 6.0, 7.4  # [s], printed: frames 30 and 37 at 5 frames a second
LENGTH = 17.0  # [s]; the car stops after 13
PATHS = {"to and fro": lambda speed, seed: to_and_fro(seed, speed), "circle": lambda speed, seed: circle(period=2 * np.pi * 0.08 / speed)}
FEATURES = {"tracker": 0.0, "exact": 0.0, "1 px": 1.0, "2 px": 2.0, "3 px": 3.0, "5 px": 5.0}  # how far off a perfect tracker's are made
COLOR, OFF_COLOR, _ = CONTRAST
_GAIN, _SPEED, _FPS = [0.5, 1.0, 2.0], [0.02, 0.05, 0.08], [2.5, 5, 10, 25]
_COMPENSATION = ["off", "raw", "Kalman"]


def experiment(gain=1.0, compensation="Kalman", ratio=1.0, rho=0.3, fps=5, dof=6, features="tracker", speed=0.05, motion="to and fro", seed=0):
    """The `Experiment` behind a figure: with the combination of 75 particles in the loop, or with features that are exact or a little off."""
    filter = {"off": OFF, "raw": RAW, "Kalman": Kalman(ratio, rho)}[compensation]
    tracker = get("combined") if features == "tracker" else None
    return Experiment(Servo(gain=gain, filter=filter, dt=1 / fps, dof=dof), path=PATHS[motion](speed, seed), frames=round(LENGTH * fps),
                      tracker=tracker, jitter=FEATURES[features], seed=seed)


@lru_cache(maxsize=512)
def run(experiment):
    """`mkt.loop.run`, each experiment once in a process.  Returns a `Run`."""
    return loop.run(experiment)


def while_it_sees(experiment):
    """The `Run` of an experiment, cut short where a loop runs away until the car is behind the camera."""
    try:
        return run(experiment)
    except ValueError:
        return while_it_sees(replace(experiment, frames=experiment.frames * 4 // 5))


def self_motion(run, surface):
    """The true de/dt of y_n, (T - 1,) [1/s], from every frame to the next: the car's velocity along the image's y over the root of its area [m^2]."""
    velocity = np.diff(run.cars[:, :2], axis=0) / np.diff(run.times)[:, None]
    return np.sum(velocity * run.poses[:-1, :2, 1], 1) / np.sqrt(surface)


@figure("teuliere2009.fig8", size=(10, 4.6), frame=(0, 84, 1), motion=list(PATHS), gain=_GAIN, seed=[0, 1, 2])
def fig8(canvas, *, frame=33, motion="to and fro", gain=1.0, seed=0):
    """Tracking a moving object.

    Simulated: the paper has a photograph of its gantry robot.  Left, the table with the car (blue) and its path (black), and above it the camera with what
    it sees (green); its own path is green too, drawn up to the frame.  Right, the camera's view: red where the car should appear, green where the
    combination of 75 particles finds it.
    """
    x = experiment(gain=gain, motion=motion, seed=seed)
    r = run(x)
    scene = canvas.add_axes((0.0, 0.03, 0.5, 0.97), projection="3d")
    _draw_scene(scene, x, r, frame)
    ax = canvas.add_axes((0.51, 0.03, 0.48, 0.85))
    draw_view(ax, x, r, frame, f"frame {frame}: $e_{{xn}}$ = {r.errors[frame, 0]:.3f}, $e_{{yn}}$ = {r.errors[frame, 1]:.3f}")
    return {"camera": r.poses[:, :3, 3], "car": r.cars, "error": r.errors[frame], "lost": r.lost}


def _draw_scene(ax, x, r, k):
    camera, pose, car = x.workspace.camera, r.poses[k], r.cars[k]
    width, height = camera.size
    rays = np.linalg.solve(camera.matrix, np.array([[0, 0, 1], [width, 0, 1], [width, height, 1], [0, height, 1.0]]).T)
    centre, rays = pose[:3, 3], (pose[:3, :3] @ rays).T
    seen, hand = centre - rays * centre[2] / rays[:, 2:], centre + 0.12 * rays  # where the table is, and a small pyramid round the lens
    ax.add_collection3d(Poly3DCollection([seen], facecolor=CURRENT, alpha=0.12))
    body = np.column_stack([corners(np.array([*car, *(x.workspace.sides / 2)])), np.zeros(4)])
    ax.add_collection3d(Poly3DCollection([body], facecolor="#3b6fb6", edgecolor="black", lw=0.8))
    ax.add_collection3d(Poly3DCollection([[centre, a, b] for a, b in zip(hand, np.roll(hand, -1, 0))], facecolor=CURRENT, edgecolor="black", lw=0.8, alpha=0.7))
    for corner in seen:
        ax.plot(*np.transpose([centre, corner]), color=CURRENT, lw=0.6, alpha=0.7)
    ax.plot(r.cars[:, 0], r.cars[:, 1], 0, color=TRUTH, lw=1.1)
    ax.plot(*r.poses[:k + 1, :3, 3].T, color=CURRENT, lw=2)
    span = np.concatenate([r.cars[:, :2], r.poses[:, :2, 3]])
    middle, half = (span.min(0) + span.max(0)) / 2, max(np.ptp(span, 0).max() / 2, 0.1) + 0.2
    ax.set(xlim=middle[0] + np.array([-half, half]), ylim=middle[1] + np.array([half, -half]), zlim=(0, -1.0), xlabel="X [m]", ylabel="Y [m]", zlabel="Z [m]")
    ax.zaxis.labelpad = 9  # clear of the ticks
    ax.locator_params(nbins=4)
    ax.set_box_aspect((2 * half, 2 * half, 1.0), zoom=0.88)
    ax.view_init(22, -35)


def draw_view(ax, experiment, run, k, title):
    """What the camera sees in frame k of a run: red where the car should appear, green where it was found."""
    show_frame(ax, view(experiment, run, k), title)
    draw_box(ax, experiment.servo.desired, DESIRED, lw=2)
    draw_region(ax, run.regions[k], CURRENT, lw=2)
    width, height = experiment.workspace.camera.size
    ax.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))


@figure("teuliere2009.fig9", size=(10, 4.2), grid=("ratio", "features"), ratio=[0.0, 0.05, 0.2, 1.0, 100.0], rho=[0.0, 0.3, 0.9], features=list(FEATURES), speed=_SPEED,
        seed=[0, 1, 2])
def fig9(canvas, *, ratio=1.0, rho=0.3, features="tracker", speed=0.05, seed=0):
    """Measured and estimated velocity of y_n due to the object's self-motion.

    Simulated: the car is driven to and fro along y at 5 frames a second, with sudden reversals (dashed) at the printed frames 30 and 37.
    Dots: (18) and (19); blue: the Kalman filter; black: the truth, which the paper could not know, from each frame to the next.
    """
    x = experiment(ratio=ratio, rho=rho, features=features, speed=speed, seed=seed)
    r, truth = run(x), self_motion(run(x), x.workspace.surface)
    measured, estimated = r.measured[1:, 1], r.estimated[1:, 1]
    ax = canvas.add_axes((0.07, 0.13, 0.91, 0.76))
    _mark_reversals(ax, 5)
    ax.axhline(0, color="0.6", lw=0.8)
    ax.step(np.arange(1, len(r.times)), truth, where="pre", color=TRUTH, lw=1.1, label="truth")
    ax.plot(np.arange(1, len(r.times)), measured, "o", ms=3.5, color=OFF_COLOR, label="measured")
    ax.plot(np.arange(len(r.times)), r.estimated[:, 1], color=COLOR, lw=2, label="estimated")
    off = rms(measured - truth), rms(estimated - truth)
    ax.set(xlim=(0, len(r.times) - 1), ylim=(-1, 1), xlabel="frame", ylabel=r"velocity of $y_n$ [1/s]")
    ax.set_title(f"RMS off the truth: {off[0]:.3f} measured, {off[1]:.3f} estimated", loc="right")
    ax.legend(loc="lower left", ncols=3, bbox_to_anchor=(0, 1), borderaxespad=0.1)
    return {"measured": measured, "estimated": estimated, "truth": truth, "off": off}


def rms(values):
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def _mark_reversals(ax, fps):
    for time in REVERSALS:
        ax.axvline(time * fps, color="0.4", lw=0.9, ls="--")


@figure("teuliere2009.fig10", size=(10, 5.4), compensation=_COMPENSATION, gain=_GAIN, fps=_FPS, dof=[6, 4], features=list(FEATURES), speed=_SPEED, seed=[0, 1, 2])
def fig10(canvas, *, compensation="Kalman", gain=1.0, fps=5, dof=6, features="tracker", speed=0.05, seed=0):
    """Error of the x_n and y_n features.

    Simulated: the run of figure 9, reversals dashed.  Thick: with the compensation that is chosen; thin, orange: without any.  Dotted: the error V / gain
    that the theory foretells without compensation, V the car's mean speed in units of y_n.  At the right the same errors as the car's distance from
    where it should appear, in pixels.  The paper shows the compensated error only.
    A loop that runs away is drawn as far as it sees the car.
    """
    chosen, without = (experiment(gain=gain, compensation=c, fps=fps, dof=dof, features=features, speed=speed, seed=seed) for c in (compensation, "off"))
    surface, camera = chosen.workspace.surface, chosen.workspace.camera
    errors, reference = while_it_sees(chosen).errors, while_it_sees(without).errors
    lag = speed / np.sqrt(surface) / gain
    pixels = camera.focal / chosen.servo.goal[2]  # of one unit, at the desired distance
    axes = canvas.subplots(2, 1, sharex=True, gridspec_kw={"left": 0.075, "right": 0.92, "bottom": 0.1, "top": 0.9, "hspace": 0.12, "height_ratios": (1.6, 1)})
    for ax, k, name in zip(axes, (1, 0), "yx"):
        _mark_reversals(ax, fps)
        ax.axhline(0, color=DESIRED, lw=1)
        ax.plot(reference[:, k], color=OFF_COLOR, lw=1.2, label="compensation off")
        ax.plot(errors[:, k], color=COLOR, lw=2.2, label=f"compensation {compensation}")
        ax.set(xlim=(0, chosen.frames - 1), ylabel=f"error of ${name}_n$")
        ax.secondary_yaxis("right", functions=(lambda e: e * pixels, lambda px: px / pixels)).set_ylabel("[px]")
    for sign in (-1, 1):
        axes[0].axhline(sign * lag, color="0.3", lw=1, ls=":")
    largest = max(np.abs(reference[:, :2]).max(), np.abs(errors[:, :2]).max(), lag)
    axes[0].set(ylim=(-1.1 * largest, 1.1 * largest))
    axes[1].set(ylim=(-0.55 * largest, 0.55 * largest), xlabel=f"frame, {fps:g} a second")
    axes[0].legend(loc="lower left", ncols=2, bbox_to_anchor=(0, 1), borderaxespad=0.1)
    found = rms(errors[:, 1]), rms(reference[:, 1])
    axes[0].set_title(f"RMS of $e_{{yn}}$: {found[0]:.3f}, off {found[1]:.3f}", loc="right")
    return {"errors": errors[:, :2], "without": reference[:, :2], "lag": lag, "rms": found}


@figure("teuliere2009.fig11", size=(10, 2.6), compensation=_COMPENSATION, gain=_GAIN, dof=[6, 4], speed=_SPEED, seed=[0, 1, 2])
def fig11(canvas, *, compensation="Kalman", gain=1.0, dof=6, speed=0.05, seed=0):
    """Internal view.

    Simulated: the run of figures 9 and 10.  Red where the car should appear, green where the tracker finds it: (a) and (b) in steady motion, (c) soon after
    the second reversal, when the error is largest, (d) the final position.  The camera turns with the car, so that the table seems to move.
    """
    x = experiment(gain=gain, compensation=compensation, dof=dof, speed=speed, seed=seed)
    r = run(x)
    frames = instants(r)
    off = np.hypot(*(r.truths - x.servo.desired)[frames, :2].T)
    axes = canvas.subplots(1, 4, gridspec_kw={"left": 0.005, "right": 0.995, "bottom": 0.01, "top": 0.88, "wspace": 0.03})
    for ax, letter, k, px in zip(axes, "abcd", frames, off):
        draw_view(ax, x, r, k, f"({letter}) frame {k}: {px:.1f} px off")
    return {"frames": frames, "off": off, "turn": np.rad2deg(wrap_angle(r.truths[frames, 2] - x.servo.desired[2])), "lost": r.lost}


def instants(run):
    """The frames of figure 11: twice in steady motion, the largest error in the second after the second reversal, the last."""
    before, reversal = np.searchsorted(run.times, (4.0, REVERSALS[1]))
    after = run.times[reversal:] <= REVERSALS[1] + 1
    worst = reversal + np.argmax(np.abs(run.errors[reversal:, 1]) * after)
    return [int(before), int(np.searchsorted(run.times, REVERSALS[0])) - 1, int(worst), len(run.times) - 1]
