"""Figures 4 and 10 of [N03], and what the figures of whole sequences share.

The sequences are rebuilt in `mkt.scenes.nummiaro2003`, except for a real head; where
the target gets lost is in `mkt.papers.nummiaro2003.losing`, where it comes to look
otherwise in `mkt.papers.nummiaro2003.learning`.  Explained in notebook 10.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.evaluation import HIT, SEEN, overlap
from mkt.figures.registry import Shown, figure, shown
from mkt.papers import runs
from mkt.papers.nummiaro2003.steps import ANNOTATED, BINS, TARGETS
from mkt.particles import EllipseMotion
from mkt.plotting import TRUTH, draw_ellipse, show_frame
from mkt.scenes.nummiaro2003 import parking
from mkt.sequences.carphone import HEAD
from mkt.trackers.adaptive import Adaptive
from mkt.tracking import Sequence as Clip
from mkt.tracking import Track
from mkt.types import Array, NDArray, Regions

RUNS = 2  # of figures 9 and 10; they differ in the tracker's random numbers
PATHS = 5  # runs of figure 4: with one, luck alone says whether both are followed
PRINTED = 25  # frames from one ellipse of figure 4 to the next
WITH, WITHOUT = "#008862", "#d275aa"
PAPER = Adaptive()


def tiles(
    fig: Figure,
    rows: int,
    columns: int,
    top: float,
    bottom: float = 0.005,
    hspace: float = 0.16,
) -> NDArray:
    """Axes (rows, columns) for frames, from the left edge to the right one."""
    margins = {"left": 0.005, "right": 0.995, "bottom": bottom, "top": top}
    spaces = {"wspace": 0.03, "hspace": hspace}
    return fig.subplots(rows, columns, squeeze=False, gridspec_kw=margins | spaces)


def held(track: Track, truth: Regions) -> Array:
    """The overlap with the truth, 0 while the tracker itself searches for the target.

    Its ellipse stays behind then, and a target that comes by is not tracked by it.

    Parameters
    ----------
    track : Track
    truth : (T, 5) array [px, rad]

    Returns
    -------
    (T,) array
    """
    return np.where(track.lost, 0, overlap(track.regions, truth))


def estimates(track: Track) -> Regions:
    """The regions (T, 5) of a track, NaN while the tracker searches for the target."""
    return np.where(track.lost[:, None], np.nan, track.regions)


def ellipses(track: Track) -> pd.DataFrame:
    """The estimates of a track, a row for each frame."""
    x, y, _, hx, hy = track.regions.T
    places = {"x [px]": x, "y [px]": y, "H_x [px]": hx, "H_y [px]": hy}
    return pd.DataFrame({"frame": np.arange(len(x))} | places)


@figure(
    "nummiaro2003.fig4",
    size=(10, 6.0),
    particles=[25, 100, 250],
    noise=[0.5, 1.0, 2.0],
    alpha=[0.0, 0.1, 0.3],
)
def fig4(
    fig: Figure, *, particles: int = 100, noise: float = 1.0, alpha: float = PAPER.alpha
) -> Shown:
    """Trajectories of a person and of a car, with the mean state in every 25th frame.

    Synthetic data: a parking place seen from a window.  The car, a van, comes closer
    and turns out of the image plane, a box whose side comes to sight.  Coloured five
    runs that differ in the tracker's random numbers, the first one thick and with its
    ellipses; black the truth, of which the caption says nothing; the picture is the
    last frame.  Below, how far off the centre and the half axis are in each frame;
    where the tracker says that it is lost there is no estimate.  noise: of the motion,
    in multiples of our values, as the paper prints none; alpha: how fast the model
    learns.  In the print, of a real parking place, both are followed; here the person
    is, and the van's ellipse stays with the side of it that it knows.
    """
    motion = _with_noise(PAPER.motion, noise)
    tracker = replace(PAPER, n=particles, motion=motion, alpha=alpha)
    followed = {name: _followed(tracker, name) for name in TARGETS}
    for k, (name, found) in enumerate(followed.items()):
        ax = fig.add_axes((0.01 + 0.5 * k, 0.41, 0.48, 0.53))
        off = np.nanmedian(found.off[:, 1:])
        held = np.mean(found.iou[:, 1:] > HIT)
        title = f"{name}: {off:.1f} px off in the median,"
        title += f" held in {held:.0%} of the frames"
        show_frame(ax, found.clip.frames[-1], title)
        _draw_trajectories(ax, found, TARGETS[name])
    _draw_errors(fig, followed)
    facts = {f"{name} position": found.off for name, found in followed.items()}
    facts |= {f"{name} size": found.ratio for name, found in followed.items()}
    facts |= {f"{name} overlap": found.iou for name, found in followed.items()}
    tables = [_trajectories(name, found) for name, found in followed.items()]
    return shown(pd.concat(tables, ignore_index=True), **facts)


class _Followed(NamedTuple):
    """Some runs, their regions (R, T, 5), and three arrays (R, T) of them.

    off : the error of the centre [px]; ratio : H_x over the true one; iou : overlap.
    Where a tracker says that it is lost all are NaN but the overlap, which is 0.
    """

    clip: Clip
    tracks: list[Track]
    regions: Regions
    off: Array
    ratio: Array
    iou: Array


def _with_noise(motion: EllipseMotion, factor: float) -> EllipseMotion:
    """The motion with its noise multiplied by a factor."""
    return replace(
        motion,
        position=factor * motion.position,
        velocity=factor * motion.velocity,
        axes=factor * motion.axes,
        growth=factor * motion.growth,
    )


def _followed(tracker: Adaptive, target: str) -> _Followed:
    """Runs on the parking place."""
    scene = parking(0, target)
    clip = runs.clip(scene)
    tracks = [runs.run(tracker, scene, seed) for seed in range(PATHS)]
    found = np.array([estimates(track) for track in tracks])
    off = np.linalg.norm(found[..., :2] - clip.truth[:, :2], axis=-1)
    iou = np.array([held(track, clip.truth) for track in tracks])
    return _Followed(clip, tracks, found, off, found[..., 3] / clip.truth[:, 3], iou)


def _draw_trajectories(ax: Axes, followed: _Followed, color: str) -> None:
    """All paths, and ellipses along the first."""
    first, *others = followed.regions
    ax.plot(*followed.clip.truth[:, :2].T, color=TRUTH, lw=3)
    for regions in others:
        ax.plot(*regions[:, :2].T, color=color, lw=0.7)
    ax.plot(*first[:, :2].T, color=color, lw=1.8)
    for region in first[::PRINTED][np.isfinite(first[::PRINTED, 0])]:
        draw_ellipse(ax, region, "white", lw=2.6)
        draw_ellipse(ax, region, color, lw=1.5)


def _draw_errors(fig: Figure, followed: Mapping[str, _Followed]) -> None:
    """Two charts below: the centre's error, and H_x over the true one."""
    left, right = (fig.add_axes((x, 0.09, 0.425, 0.24)) for x in (0.065, 0.565))
    for name, found in followed.items():
        for ax, values in ((left, found.off), (right, found.ratio)):
            ax.plot(values[1:].T, color=TARGETS[name], lw=0.7)
            ax.plot(values[0], color=TARGETS[name], lw=2, label=name)
            ax.set(xlabel="frame", xlim=(0, values.shape[1] - 1))
    largest = max(np.nanmax(found.off) for found in followed.values())
    left.set(ylabel="centre error [px]", ylim=(0, 1.3 * largest))
    left.legend(loc="upper left", ncols=2)
    right.axhline(1, color=TRUTH, lw=1)
    right.set(ylabel="$H_x$ over the true one", ylim=(0, 2))


def _trajectories(name: str, followed: _Followed) -> pd.DataFrame:
    """A row for each frame of each run: where it was found, and how far off."""
    x, y = followed.clip.truth[:, :2].T
    tables = []
    for k, track in enumerate(followed.tracks):
        columns = {
            "true x [px]": x,
            "true y [px]": y,
            "centre error [px]": followed.off[k],
            "H_x over the true one": followed.ratio[k],
            "overlap": followed.iou[k],
        }
        table = ellipses(track).assign(**columns)
        table.insert(0, "run", k)
        table.insert(0, "target", name)
        tables.append(table)
    return pd.concat(tables)


@figure(
    "nummiaro2003.fig10",
    size=(10, 4.3),
    alpha=[0.0, 0.02, 0.2],
    bins=["rgb 8x8x8", "hsv 8x8x4"],
    particles=[25, 100, 200],
)
def fig10(
    fig: Figure, *, alpha: float = 0.02, bins: str = "hsv 8x8x4", particles: int = 100
) -> Shown:
    """A head over 450 frames.

    Real video, a clip of 120 frames played forward and backward.  Yellow our
    annotation, green the estimate.  Below, the overlap of two runs that differ in the
    tracker's random numbers, the one above thick; the annotation is of every fifth
    frame, with straight lines between.  The paper follows a head in a factory to the
    end; with the defaults this one, in a car before windows and a head-rest, is
    followed to the end too; with the rate of figure 8, an alpha of .1, worse.
    """
    clip = runs.clip(HEAD)
    tracker = replace(PAPER, n=particles, alpha=alpha, bins=BINS[bins])
    tracks = [runs.run(tracker, HEAD, seed) for seed in range(RUNS)]
    iou = np.array([held(track, clip.truth) for track in tracks])
    frames = np.linspace(0, len(clip) - 1, 6).astype(int)
    (row,) = tiles(fig, 1, len(frames), top=0.97, bottom=0.58)
    for ax, k in zip(row, frames, strict=True):
        show_frame(ax, clip.frames[k], f"frame {k}")
        draw_ellipse(ax, clip.truth[k], ANNOTATED, lw=1.5)
        if not tracks[0].lost[k]:
            draw_ellipse(ax, tracks[0].regions[k], WITH, lw=2.2)
    _draw_overlaps(fig.add_axes((0.07, 0.13, 0.92, 0.36)), iou)
    tables = [
        ellipses(track).assign(run=k, overlap=iou[k]) for k, track in enumerate(tracks)
    ]
    seen = np.mean(clip.visibility > SEEN)
    return shown(pd.concat(tables, ignore_index=True), overlap=iou, seen=seen)


def _draw_overlaps(ax: Axes, iou: Array) -> None:
    """The overlap of some runs (R, T), the first one thick."""
    ax.plot(iou[1:].T, color=WITH, lw=0.8, alpha=0.8)
    ax.plot(iou[0], color=WITH, lw=2.2)
    means = ", ".join(f"{value:.2f}" for value in iou[:, 1:].mean(1))
    limits = {"xlim": (0, iou.shape[1] - 1), "ylim": (0, 1)}
    ax.set(xlabel="frame", ylabel="overlap", title=f"mean overlap {means}", **limits)
