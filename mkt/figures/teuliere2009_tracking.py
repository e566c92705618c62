"""Figures 5 to 7 of [T09]: its trackers on a blurred sequence, and on one with a total occlusion."""

from dataclasses import replace

import numpy as np

from mkt.evaluation import HIT, SEEN, errors, overlap
from mkt.figures import figure
from mkt.figures.runs import clip, run
from mkt.plotting import TRACKERS as COLORS
from mkt.plotting import draw_runs, draw_tracked
from mkt.regions import wrap_angle
from mkt.scenarios import fast, hidden
from mkt.trackers.catalogue import LABELS, TRACKERS

RUNS = 5  # over one path: the sensor noise and the tracker's random numbers differ
FIRST = 46  # printed, Section VI-A: the frame of the rupture
_SLIDERS = {"particles": [25, 75, 250], "threshold": [0.4, 0.6, 0.8], "occlusion": [5, 10], "seed": [0, 1, 2]}


def contenders(particles, threshold):
    """The trackers (1) to (5), the last two with so many particles, the last one with this threshold on d_m.  Returns dict name -> tracker."""
    both = TRACKERS["combined"]
    changed = {"pf-75": replace(TRACKERS["pf-75"], n=particles),
               "combined": replace(both, filter=replace(both.filter, n=particles), threshold=threshold)}
    return {name: changed.get(name, TRACKERS[name]) for name in COLORS}


def _label(name, particles):
    return LABELS[name].replace("75", str(particles))


def occluded_runs(particles, threshold, occlusion, seed):
    """What figures 6 and 7 draw: the sequence of run 0, and the regions (5, RUNS, T, 5) of all trackers in all runs."""
    scene, trackers = hidden(seed, first=FIRST, frames=occlusion), contenders(particles, threshold)
    regions = [[run(tracker, replace(scene, seed=k), k).regions for tracker in trackers.values()] for k in range(RUNS)]
    return clip(replace(scene, seed=0)), np.swapaxes(regions, 0, 1)


def before_and_after(regions, sequence):
    """Errors of runs (..., T, 5) while the target is seen, before the occlusion and after it.

    Returns position (2, ...) [px] and orientation (2, ...) [deg], medians over the frames; lost (...) bool, where most of the last ten frames are misses.
    """
    e, frames = errors(regions, sequence.truth), np.arange(len(sequence))
    parts = [(sequence.visibility > SEEN) & part for part in ((0 < frames) & (frames < FIRST), frames >= FIRST)]
    position, orientation = ([np.median(value[..., part], -1) for part in parts] for value in e[:2])
    return np.array(position), np.rad2deg(orientation), np.median(overlap(regions[..., -10:, :], sequence.truth[-10:]), -1) <= HIT


@figure("teuliere2009.fig6", size=(10, 9.4), grid=("particles", "threshold"), **_SLIDERS)
def fig6(canvas, *, particles=75, threshold=0.6, occlusion=5, seed=0):
    """Position and orientation from the trackers (1) to (5), through a total occlusion.

    Synthetic data: a toy car, fast translation and rotation at a fixed size, hidden totally in the shaded frames, from frame 46 (dashed) on.  Black is
    the truth, which the print does not have; coloured are five runs over the same path that differ in their sensor noise and random numbers, run 0
    thick: it is the one in figure 7.  Angles are drawn on the turn nearest the truth.  At the right, each run's median error before and after the
    occlusion: the median of the runs, the smallest and the largest in brackets.  A run is lost when it misses the target in most of the last ten
    frames.  The paper shows one run on one real sequence, and its filters come through.  Here that depends on the path, and SSD finds a target
    again that comes out where it went in: move the seed.
    """
    sequence, regions = occluded_runs(particles, threshold, occlusion, seed)
    position, orientation, lost = before_and_after(regions, sequence)
    truth = _curves(sequence.truth, sequence.truth)
    axes = canvas.subplots(5, 3, sharex=True, sharey="col", gridspec_kw={"left": 0.055, "right": 0.8, "bottom": 0.055, "top": 0.94, "hspace": 0.36, "wspace": 0.24})
    quantities = "x [px]", "y [px]", "orientation [deg]"
    limits = [(0, 320), (240, 0), (np.min(truth[2]) - 60, np.max(truth[2]) + 60)]
    for i, (name, row) in enumerate(zip(COLORS, axes)):
        curves = np.array([_curves(r, sequence.truth) for r in regions[i]])
        for k, ax in enumerate(row):
            ax.set_label(f"{_label(name, particles)}; y is {quantities[k]}")
            ax.axvspan(FIRST, FIRST + occlusion - 1, color="0.85", lw=0)
            ax.axvline(FIRST, color="0.4", lw=0.9, ls="--")
            draw_runs(ax, truth[k], curves[:, k], COLORS[name], ylim=limits[k])
        row[0].set_title(_label(name, particles), loc="left", fontweight="bold", color=COLORS[name])
        canvas.text(0.815, row[0].get_position().y1, _summary(position[:, i], orientation[:, i], lost[i]), va="top", fontsize=9, linespacing=1.45)
    for ax, title in zip(axes[0], quantities):
        canvas.text(ax.get_position().x0, 0.975, title)
    for ax in axes[-1]:
        ax.set(xlabel="frame", xticks=(0, 20, FIRST, 60, 79))
    return {"position": position, "orientation": orientation, "lost": lost, "regions": regions[:, 0], "truth": sequence.truth, "visibility": sequence.visibility}


def _curves(regions, truth):
    """x [px], y [px] and the orientation [deg] on the turn nearest the unwrapped truth.  regions, truth: (T, 5).  Returns (3, T)."""
    angle = np.unwrap(truth[:, 2])
    return np.array([*regions[:, :2].T, np.rad2deg(angle + wrap_angle(regions[:, 2] - angle))])


def _summary(position, orientation, lost):
    """The text at the right of a row, from the errors (2, RUNS) and (RUNS,) bool."""
    lines = [f"{when}\n  {_spread(px)} px\n  {_spread(deg)}°" for when, px, deg in zip(("before", "after"), position, orientation)]
    return "\n".join([*lines, f"lost {lost.sum()} of {len(lost)} runs"])


def _spread(values):
    return f"{np.median(values):.1f}  ({values.min():.1f} to {values.max():.1f})"


@figure("teuliere2009.fig7", size=(10, 7.7), **_SLIDERS)
def fig7(canvas, *, particles=75, threshold=0.6, occlusion=5, seed=0):
    """The frames of figure 6.

    Run 0 of figure 6, the thick one, the same frames in every row: before the occlusion, in its middle, as soon as the target is out again, and on to
    the end.  Synthetic data.  Dashed in black and white the truth, also while the screen hides the target; coloured the estimate, with a tick along the
    object's x.  The paper prints a real sequence and no truth.
    """
    sequence, regions = occluded_runs(particles, threshold, occlusion, seed)
    out = FIRST + occlusion + int(np.argmax(sequence.visibility[FIRST + occlusion:] > 0.9))
    frames = [20, 38, FIRST + occlusion // 2, out, (out + 79) // 2, 79]
    strip(canvas, sequence, frames, {_label(name, particles): (r[0], COLORS[name]) for name, r in zip(COLORS, regions)})
    return {"frames": frames, "regions": regions[:, 0], "visibility": sequence.visibility[frames]}


def strip(canvas, sequence, frames, rows):
    """A film strip: the same frames in every row.  rows: dict title -> (regions (T, 5), colour)."""
    inch = 1 / canvas.get_figheight()
    axes = canvas.subplots(len(rows), len(frames), gridspec_kw={"left": 0.005, "right": 0.995, "bottom": 0.005, "top": 1 - 0.5 * inch, "hspace": 0.2, "wspace": 0.03})
    for row, (title, (regions, color)) in zip(axes, rows.items()):
        for ax, k in zip(row, frames):
            draw_tracked(ax, sequence.frames[k], sequence.truth[k], regions[k], color)
        place = row[0].get_position()
        canvas.text(place.x0, place.y1 + 0.04 * inch, title, color=color, fontweight="bold", va="bottom")
    for ax, k in zip(axes[0], frames):
        place = ax.get_position()
        canvas.text((place.x0 + place.x1) / 2, place.y1 + 0.27 * inch, f"frame {k}", ha="center", va="bottom")


LITERAL = replace(TRACKERS["ssd"], derivative_of_c=False)


@figure("teuliere2009.fig5", size=(10, 6.3), particles=[50, 150, 500], exposure=[0.0, 0.5, 0.9], seed=[0, 1, 2])
def fig5(canvas, *, particles=500, exposure=0.9, seed=0):
    """A fast sequence with translation, rotation and scale, blurred by its motion.

    Synthetic data: a toy car, the shutter open for most of the frame period; shown are the frames of the fastest motion.  Dashed
    in black and white the truth, coloured the estimate.  Above each row, over the whole sequence: mean overlap, median error of the orientation, and the
    size in the last frame against the true one.  The paper has three rows of a real sequence: (1) one-kernel filter, (2) nine-kernel SSD, which shrinks at
    the blur and stays wrong, (3) nine-part filter, which holds.  Here SSD with the full derivative of (8) does not shrink.  The row below it leaves the
    derivative of C out, as a literal reading might: on most paths it shrinks at the blur, as printed, and at exposure 0 it does not.
    """
    scene = fast(seed, exposure=exposure)
    sequence = clip(scene)
    trackers = {
        f"(1) one kernel, {particles} particles": (replace(TRACKERS["pf-1"], n=particles), COLORS["pf-1"]),
        "(2) SSD, nine kernels": (TRACKERS["ssd"], COLORS["ssd"]),
        "(2) SSD without the derivative of C": (LITERAL, COLORS["ssd"]),
        f"(3) nine parts, {particles} particles": (replace(TRACKERS["pf-500"], n=particles), COLORS["pf-500"]),
    }
    regions = np.array([run(tracker, scene, seed).regions for tracker, _ in trackers.values()])
    iou, e = overlap(regions, sequence.truth)[:, 1:].mean(1), errors(regions, sequence.truth)
    turn, size = np.rad2deg(np.median(e.orientation[:, 1:], 1)), np.exp(e.scale[:, -1])
    titles = [f"{label}: overlap {a:.2f}, orientation {b:.0f}° off, size x {c:.2f}" for label, a, b, c in zip(trackers, iou, turn, size)]
    frames = fastest(sequence.truth)
    strip(canvas, sequence, frames, {title: (r, color) for title, r, (_, color) in zip(titles, regions, trackers.values())})
    return {"overlap": iou, "orientation": turn, "size": size, "frames": frames, "regions": regions}


def fastest(truth, n=6):
    """The frame of the fastest motion in the middle of each of n equal parts of the sequence.  truth: (T, 5).  Returns a list of n frames."""
    speed = np.linalg.norm(np.gradient(truth[:, :2], axis=0), axis=1)
    return [int(part[2 + np.argmax(speed[part[2:-2]])]) for part in np.array_split(np.arange(len(truth)), n)]
