"""Figures 1 to 6 of [C14]: window matching, SIR and PFHR in clutter and behind things.

Two kinds of drawing are shared by the six: `film`, a strip of eight frames, and
`curves`, the positions over the whole sequence.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.evaluation import HIT, SEEN, overlaps, true_positives
from mkt.figures.registry import REGION, Shown, figure, shown
from mkt.papers import runs
from mkt.papers.cordoba2014.printed import COLORS, NAMES, said, source
from mkt.plotting import (
    TRUTH,
    draw_box,
    draw_name,
    draw_truth,
    shade_frames,
    show_frame,
)
from mkt.trackers.by_name import TRACKERS
from mkt.tracking import Sequence as Clip
from mkt.tracking import Source, Tracker
from mkt.types import Array, NDArray, Regions

RUNS = 4  # of a figure over one sequence: the tracker's random numbers differ
# Seen frames after an occlusion in which the target must be found again.
BACK = slice(5, 15)
SHOWN = 8  # frames of a film strip
LATER = 10  # frames after an occlusion: the moment that shows who is back
APART = 6  # frames between two moments of a film strip, at least
_OCCLUSION = {"particles": [25, 75, 200], "n_lim": [0.1, 0.5, 1.0]}


def contenders(particles: int = 200, n_lim: float = 0.5) -> dict[str, Tracker]:
    """WM, SIR and PFHR by name, the filters with so many particles."""
    pfhr = replace(TRACKERS["pfhr"], n=particles, n_lim=n_lim)
    sir = replace(TRACKERS["sir"], n=particles)
    return {"wm": TRACKERS["wm"], "sir": sir, "pfhr": pfhr}


def repeated(tracker: Tracker, source: Source, n: int) -> Regions:
    """The regions (n, T, 5) of n runs with other random numbers.

    A tracker without particles would only repeat itself: it runs once.
    """
    seeds = range(n) if hasattr(tracker, "n") else range(1)
    return runs.regions([tracker], source, seeds)[0]


def occlusions(clip: Clip) -> list[tuple[int, int]]:
    """The first hidden and the next seen frame of all occlusions that come to an end.

    In frame 0 the target counts as seen, because a tracker is told where it is.
    """
    seen = clip.visibility > SEEN
    seen[0] = True
    starts = np.flatnonzero(seen[:-1] & ~seen[1:]) + 1
    ends = np.flatnonzero(~seen[:-1] & seen[1:]) + 1
    return list(zip(starts.tolist(), ends.tolist(), strict=False))


def found_again(iou: Array, clip: Clip) -> tuple[NDArray, int]:
    """After how many of the occlusions a tracker is back on the target.

    Back is a hit in most of the sixth to fifteenth seen frame after it.

    Parameters
    ----------
    iou : (..., T) array
        Of `mkt.evaluation.overlaps`.
    clip : Sequence

    Returns
    -------
    counts : (...) array
    occlusions : int
        Those after which a frame is left in which it must be found again.
    """
    seen = clip.visibility > SEEN
    counts = np.zeros(iou.shape[:-1], int)
    number = 0
    for _, end in occlusions(clip):
        after = iou[..., end:][..., seen[end:]][..., BACK]
        if after.shape[-1]:
            counts = counts + (np.mean(after > HIT, -1) > 0.5)
            number += 1
    return counts, number


def moments(clip: Clip, n: int = SHOWN) -> list[int]:
    """At most n frames to show, evenly spread, but occlusions come first.

    Of each of these, the middle and the tenth frame after its end are shown.
    """
    chosen: list[int] = []
    for start, end in occlusions(clip)[: (n - 2) // 2]:
        chosen += [(start + end) // 2, min(end + LATER, len(clip) - 1)]
    spread = np.linspace(0, len(clip) - 1, n + 2).round().astype(int)[1:]
    for k in spread.tolist():
        apart = all(abs(k - other) >= APART for other in chosen)
        if len(set(chosen)) < n and apart:
            chosen.append(k)
    return sorted(set(chosen))[:n]


def film(fig: Figure, kind: str, trackers: Mapping[str, Tracker]) -> Shown:
    """A film strip of eight frames with the boxes of all trackers."""
    origin = source(kind)
    clip = runs.clip(origin)
    regions = {name: runs.run(one, origin).regions for name, one in trackers.items()}
    frames = moments(clip)
    fig.subplots_adjust(left=0.005, right=0.995, bottom=0.005, top=0.86)
    fig.subplots_adjust(hspace=0.18, wspace=0.03)
    for ax, k in zip(fig.subplots(2, SHOWN // 2).flat, frames, strict=False):
        _draw_moment(ax, clip, k, regions)
    _draw_legend(fig, list(trackers), said(origin))
    share = {
        name: float(true_positives(overlaps(found, clip), hidden=True))
        for name, found in regions.items()
    }
    table = _boxes(regions | {"truth": clip.truth}, frames)
    return shown(table, frames=frames, **{"true positives": share})


def _draw_moment(ax: Axes, clip: Clip, k: int, regions: Mapping[str, Regions]) -> None:
    """A frame with the truth, where it is known, and a box of each tracker."""
    hidden = "" if clip.visibility[k] > SEEN else ", hidden"
    show_frame(ax, clip.frames[k], f"frame {k}{hidden}")
    if np.isfinite(clip.truth[k]).all():
        draw_truth(ax, clip.truth[k])
    for name, found in regions.items():
        draw_box(ax, found[k], COLORS[name], lw=2)


def _draw_legend(fig: Figure, names: Sequence[str], data: str) -> None:
    fig.text(0.005, 0.945, data, va="bottom")
    fig.text(0.62, 0.945, "truth (dashed)", va="bottom")
    for k, name in enumerate(names):
        bold = {"fontweight": "bold", "va": "bottom"}
        draw_name(fig, 0.77 + 0.08 * k, 0.945, NAMES[name], COLORS[name], **bold)


def _boxes(regions: Mapping[str, Regions], frames: Sequence[int]) -> pd.DataFrame:
    """A row for each box of a film strip: those of frames out of regions (T, 5)."""
    parts = []
    for name, found in regions.items():
        numbers = dict(zip(REGION, found[frames].T, strict=True))
        parts.append(pd.DataFrame({"tracker": name, "frame": frames} | numbers))
    return pd.concat(parts, ignore_index=True).dropna()


def curves(fig: Figure, kind: str, trackers: Mapping[str, Tracker]) -> Shown:
    """Position of all trackers in shares of the image, against the frame."""
    origin = source(kind)
    clip = runs.clip(origin)
    found = {name: repeated(one, origin, RUNS) for name, one in trackers.items()}
    seen = clip.visibility > SEEN
    truth = np.where(seen[:, None], clip.truth, np.nan)[None]
    size = clip.frames[0].shape[1::-1]
    courses = {
        name: regions[..., :2] / size
        for name, regions in (*found.items(), ("truth", truth))
    }
    _draw_courses(fig, courses)
    fig.text(0.075, 0.93, said(origin))
    numbers = {}
    number = 0
    for k, (name, regions) in enumerate(found.items()):
        iou = overlaps(regions, clip)
        share = 100 * true_positives(iou, hidden=True)
        back, number = found_again(iou, clip)
        numbers[name] = {"true positives": share, "found again": back}
        _draw_lines(fig, k, name, _lines(share, back, number))
    draw_name(fig, 0.767, 0.06, "truth", TRUTH, fontsize=9)
    return shown(_positions(courses), **numbers, occlusions=number)


def _draw_courses(fig: Figure, courses: Mapping[str, Array]) -> None:
    """Both coordinates of positions (R, T, 2) by name, run 0 thick; the truth last."""
    fig.subplots_adjust(left=0.075, right=0.76, bottom=0.1, top=0.9, hspace=0.12)
    upper, lower = fig.subplots(2, 1, sharex=True)
    frames = np.arange(courses["truth"].shape[1])
    for axis, ax in enumerate((upper, lower)):
        for name, course in courses.items():
            first, others = course[0, :, axis], course[1:, :, axis]
            color = COLORS.get(name, TRUTH)
            ax.plot(others.T, color=color, lw=0.6, alpha=0.6)
            # What needs no luck is often right: dashed, over the truth below it.
            style = {"ls": (0, (4, 4)), "zorder": 3} if name == "wm" else {}
            ax.plot(first, color=color, lw=1.4 if name == "truth" else 1.8, **style)
        shade_frames(ax, frames, np.isnan(courses["truth"][0, :, axis]))
        ax.set_xlim(0, frames[-1])
    for axis, ax in enumerate((upper, lower)):
        _fit_shares(ax, [course[..., axis] for course in courses.values()])
    lower.invert_yaxis()
    upper.set(ylabel="(a) horizontal")
    lower.set(ylabel="(b) vertical", xlabel="frame")


def _fit_shares(ax: Axes, shares: Sequence[Array]) -> None:
    """Limits round the image, 0 to 1, and round what goes beyond its border."""
    low = min(0.0, *(np.nanmin(share) for share in shares))
    high = max(1.0, *(np.nanmax(share) for share in shares))
    if low < 0 or high > 1:
        for border in (0, 1):
            ax.axhline(border, color="0.6", lw=0.8, zorder=0)
    ax.set_ylim(low, high)


def _draw_lines(fig: Figure, k: int, name: str, lines: Sequence[str]) -> None:
    """The k-th tracker's name and what is said about it, beside the curves."""
    text = "\n".join([NAMES[name], *lines])
    style: dict[str, Any] = {"va": "top", "linespacing": 1.4, "fontsize": 9}
    draw_name(fig, 0.767, 0.88 - 0.28 * k, text, COLORS[name], **style)


def _positions(courses: Mapping[str, Array]) -> pd.DataFrame:
    """A row for each position (R, T, 2), by the name of the tracker, or "truth"."""
    parts = []
    for name, course in courses.items():
        run, frame = np.indices(course.shape[:2])
        columns = {
            "tracker": name,
            "run": run.ravel(),
            "frame": frame.ravel(),
            "x [image width]": course[..., 0].ravel(),
            "y [image height]": course[..., 1].ravel(),
        }
        parts.append(pd.DataFrame(columns))
    return pd.concat(parts, ignore_index=True).dropna()


def _lines(share: Array, back: NDArray, occlusions: int) -> list[str]:
    """What is written beside the curves about the runs of a tracker."""
    spread = "(one run, no chance in it)"
    if len(share) > 1:
        spread = f"({share.min():.1f} to {share.max():.1f})"
    lines = [f"  true positives {share.mean():.1f} %", f"  {spread}"]
    if occlusions:
        lines.append(f"  found again {np.mean(back):.1f} of {occlusions}")
    return lines


@figure("cordoba2014.fig1", size=(10, 4.5), **_OCCLUSION)
def fig1(fig: Figure, *, particles: int = 200, n_lim: float = 0.5) -> Shown:
    """Tracking in a cluttered environment: window matching, SIR and PFHR.

    On the synthetic twin "clutter", or on BoBoT's blue mug where MKT_DATA has it, as in
    the paper.  Run 0 of figure 2.  The paper's WM is misled by things that look alike,
    its SIR gets the size wrong.  PFHR has our bins and kernel, SIR the paper's.  N_lim
    is that of Algorithm 2 as a share of the particles.
    """
    return film(fig, "clutter", contenders(particles, n_lim))


@figure("cordoba2014.fig2", size=(10, 4.8), **_OCCLUSION)
def fig2(fig: Figure, *, particles: int = 200, n_lim: float = 0.5) -> Shown:
    """Cluttered environment: horizontal and vertical position, as a share of the image.

    On the synthetic twin "clutter", or on BoBoT's blue mug where MKT_DATA has it. Black
    is the truth, dashed WM, thick run 0, thin are three more, which the paper does not
    show.  There WM is misled and both filters follow; on the twin, which is a hard one
    of its kind, both filters are misled in most runs, with the defaults.  PFHR has our
    bins and kernel, SIR the paper's.  True positives are frames with an overlap above
    20 %, out of all frames: their mean, the smallest and the largest.
    """
    return curves(fig, "clutter", contenders(particles, n_lim))


@figure("cordoba2014.fig3", size=(10, 4.5), **_OCCLUSION)
def fig3(fig: Figure, *, particles: int = 200, n_lim: float = 0.5) -> Shown:
    """Outdoors with total occlusions by look-alikes: window matching, SIR and PFHR.

    On the synthetic twin "passers", or on BoBoT's dark coat where MKT_DATA has it,
    probably the paper's.  Run 0 of figure 4.  In the paper WM loses the person, PFHR
    finds the person again after a few frames, and of SIR the text says both that it
    misses the person and that it follows, with large swings.  Here PFHR has our bins
    and kernel, SIR the paper's.
    """
    return film(fig, "passers", contenders(particles, n_lim))


@figure("cordoba2014.fig4", size=(10, 4.8), **_OCCLUSION)
def fig4(fig: Figure, *, particles: int = 200, n_lim: float = 0.5) -> Shown:
    """Outdoors with total occlusions: horizontal and vertical position in the image.

    On the synthetic twin "passers", or on BoBoT's dark coat where MKT_DATA has it.
    Positions are shares of the image, whose border is drawn where something goes beyond
    it.  Grey: the target is hidden; the paper plots a position of 0 there, here the
    truth has gaps.  In the paper SIR swings to and fro and PFHR comes back after a few
    frames; here PFHR does come back.  It has our bins and kernel, SIR the paper's; on
    the twin SIR comes back, too, when it has ours.  Hidden frames count in the
    denominator, as the printed fractions suggest (the text says otherwise), and nobody
    can score in them.  Found again: a
    hit in most of the sixth to fifteenth seen frame after an occlusion, mean over the
    runs.
    """
    return curves(fig, "passers", contenders(particles, n_lim))


@figure("cordoba2014.fig5", size=(10, 4.5), **_OCCLUSION)
def fig5(fig: Figure, *, particles: int = 200, n_lim: float = 0.5) -> Shown:
    """Indoors with total occlusions: window matching, SIR and PFHR.

    On the synthetic twin "pillars", or on BoBoT's person in a hall where MKT_DATA has
    it (frames reconstructed from re-encoded copies), probably the paper's, in which
    people and obstacles hide the person.  Run 0 of figure 6.  The camera goes along, so
    that what hides the target comes towards it. In the paper WM and SIR lose the
    person.  Here PFHR has our bins and kernel, SIR the paper's.
    """
    return film(fig, "pillars", contenders(particles, n_lim))


@figure("cordoba2014.fig6", size=(10, 4.8), **_OCCLUSION)
def fig6(fig: Figure, *, particles: int = 200, n_lim: float = 0.5) -> Shown:
    """Indoors with total occlusions: horizontal and vertical position in the image.

    On the synthetic twin "pillars", or on BoBoT's person in a hall where MKT_DATA has
    it (frames reconstructed).  Drawn as figure 4 is.  In the paper WM and SIR miss the
    person after an occlusion; here they do, too, and where SIR drifts to the right side
    it comes back too late to count.  PFHR has our bins and kernel, SIR the paper's.
    """
    return curves(fig, "pillars", contenders(particles, n_lim))
