"""Figures 6 and 7 of [N03]: a student behind a tree, lost and found.

Explained in notebook 11.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.evaluation import overlap
from mkt.figures.registry import Shown, figure, shown
from mkt.papers import runs
from mkt.papers.nummiaro2003.sequences import PAPER, WITH, ellipses, tiles
from mkt.papers.nummiaro2003.steps import FOUND, MISSED, PERSON, SAMPLE, placements
from mkt.plotting import TRUTH, draw_ellipse, shade_frames, show_frame
from mkt.scenes.nummiaro2003 import PASSES, TREE, students
from mkt.trackers.adaptive import INITIALISING
from mkt.tracking import Sequence as Clip
from mkt.tracking import Track
from mkt.types import Array, NDArray

_LOST = {
    "b": [0.02, 0.1, 0.5],
    "placement": ["doors and borders", "borders", "anywhere"],
    "particles": [25, 100, 250],
    "tree": [76, 100],
}


def student_run(
    b: float, placement: str, particles: int, tree: float
) -> tuple[Clip, Track, NDArray]:
    """What figures 6 and 7 draw.

    Returns
    -------
    clip : Sequence
    track : Track
    waiting : (T,) bool array
        Where the mode is "initialising".
    """
    scene = students(0, tree)
    zones = placements(scene)[placement]
    tracker = replace(PAPER, alpha=0.0, b=b, n=particles, zones=zones)
    track = runs.run(tracker, scene, keep=("particles",))
    return runs.clip(scene), track, track.info["mode"] == INITIALISING


def _student_table(clip: Clip, track: Track, waiting: NDArray) -> pd.DataFrame:
    """A row for each frame; the estimate is the last one while initialising."""
    return ellipses(track).assign(
        **{"samples that appear": track.info["positives"]},
        initialising=waiting,
        visibility=clip.visibility,
        overlap=overlap(track.regions, clip.truth),
    )


@figure("nummiaro2003.fig6", size=(10, 4.35), **_LOST)
def fig6(
    fig: Figure,
    *,
    b: float = 0.1,
    placement: str = "doors and borders",
    particles: int = 100,
    tree: float = 76,
) -> Shown:
    """The student sequence: passed by others, lost behind a tree, found again, gone.

    Synthetic data, 222 frames as in the print: two others pass before the student
    around frames 45 and 165, a tree hides the student around frame 101, and in the end
    the student leaves.  Dashed the true place.  Green is the estimate in the mode
    "tracking", with the samples' centres as black points; in the mode "initialising"
    there is no estimate, and white points are where the samples wait.  In the first
    frame of a mode they still stand as the other one placed them.  The square in a
    title is green in the one mode and grey in the other.  tree: its width [px], which
    sets how long the student is hidden.  The model does not learn here.  As in the
    print the student is lost behind the tree and found again; the real sequence cannot
    be had.
    """
    clip, track, waiting = student_run(b, placement, particles, tree)
    again = found_again(waiting, TREE)
    first, second = PASSES
    frames = sorted([30, first, first + 12, TREE, again, again + 15, second, 215])
    for ax, k in zip(tiles(fig, 2, 4, top=0.935).flat, frames, strict=True):
        draw_mode(ax, clip, track, k)
    return shown(_student_table(clip, track, waiting), frames=frames)


def found_again(waiting: NDArray, frame: int) -> int:
    """The first frame after one in which the mode is "tracking" again.

    20 frames later when there is none near.

    Parameters
    ----------
    waiting : (T,) bool array
        Where the mode is "initialising".
    frame : int
    """
    near = waiting[frame : frame + 60]
    ahead = np.flatnonzero(~near & np.maximum.accumulate(near))
    return frame + (int(ahead[0]) if len(ahead) else 20)


def draw_mode(ax: Axes, clip: Clip, track: Track, k: int) -> None:
    """A frame after the first with the samples, and the estimate where there is one."""
    show_frame(ax, clip.frames[k])
    before, waiting = track.info["mode"][[k - 1, k]] == INITIALISING
    color = MISSED if waiting else WITH
    dots = "white" if before else SAMPLE  # a mode is changed once they are placed
    mode, positives = track.info["mode"][k], track.info["positives"][k]
    ax.set_title("\N{BLACK SQUARE}", loc="left", color=color, fontsize=9.5)
    ax.set_title(f"{k}: {mode}, {positives:.0f} appear", fontsize=9.5)
    ax.plot(*track.info["particles"][k][:, :2].T, ".", color=dots, ms=2)
    draw_ellipse(ax, clip.truth[k], "white", lw=1.4, ls="--")
    if not waiting:
        draw_ellipse(ax, track.regions[k], WITH, lw=2.2)


@figure("nummiaro2003.fig7", size=(10, 4.2), **_LOST)
def fig7(
    fig: Figure,
    *,
    b: float = 0.1,
    placement: str = "doors and borders",
    particles: int = 100,
    tree: float = 76,
) -> Shown:
    """How many samples fulfil the appearance condition in each frame of figure 6.

    The run of figure 6.  The dashed line is b N: tracking starts above it, and ends
    after a couple of frames, ours are five, below it.  Shaded are the frames in the
    mode "initialising".  The curve below is how much of the student can be seen, which
    only a synthetic sequence knows.  As in the print there are one wide gap, two narrow
    ones that change no mode, and the end; there both narrow ones are after the wide
    one.
    """
    clip, track, waiting = student_run(b, placement, particles, tree)
    positives = track.info["positives"]
    switches = np.flatnonzero(np.diff(waiting.astype(int))) + 1
    margins = {"left": 0.07, "right": 0.98, "bottom": 0.12, "top": 0.9}
    grid = margins | {"height_ratios": [3, 1], "hspace": 0.12}
    upper, lower = fig.subplots(2, 1, sharex=True, gridspec_kw=grid)
    times = np.arange(len(waiting))
    for ax in (upper, lower):
        shade_frames(ax, times, waiting)
    draw_positives(upper, positives, b * particles, particles)
    listed = ", ".join(map(str, switches)) or "none"
    upper.set_title(f"frames in which the mode switches: {listed}")
    lower.plot(clip.visibility, color=TRUTH)
    ticks = 0, PASSES[0], TREE, PASSES[1], times[-1]
    limits = {"xlim": (0, times[-1]), "ylim": (0, 1.1), "xticks": ticks}
    lower.set(xlabel="frame", ylabel="visible", **limits)
    return shown(
        _student_table(clip, track, waiting),
        positives=positives[1:],
        line=b * particles,
        switches=switches,
    )


def draw_positives(ax: Axes, positives: Array, line: float, n: int) -> None:
    """How many of n samples appear, and the line b N."""
    ax.plot(positives, color=PERSON, lw=1.6)
    draw_line(ax, line, n)


def draw_line(ax: Axes, line: float, n: int) -> None:
    """The line b N, for n samples."""
    ax.axhline(line, color=FOUND, ls="--", lw=1.4)
    ax.text(1, line + 0.01 * n, "$b\\,N$", color=FOUND, va="bottom")
    ax.set(ylabel="samples that appear", ylim=(0, 1.05 * n))
