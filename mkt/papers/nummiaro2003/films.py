"""Two runs of [N03]'s tracker as films: its modes, and a model that learns.

Left the frames, at the right a curve that grows with them.  `mkt.figures.film.play`
shows them.  Explained in notebooks 11 and 12.
"""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from mkt.figures.film import drawn, stage
from mkt.papers.nummiaro2003.learning import draw_where, likeness
from mkt.papers.nummiaro2003.losing import draw_line, draw_mode
from mkt.papers.nummiaro2003.sequences import WITH
from mkt.papers.nummiaro2003.steps import PERSON
from mkt.plotting import in_style, shade_frames
from mkt.trackers.adaptive import INITIALISING, Adaptive
from mkt.tracking import Sequence, Track
from mkt.types import Frame


def modes(
    tracker: Adaptive, clip: Sequence, track: Track, every: int = 4
) -> Iterator[Frame]:
    """The two modes of [N03], Section 6: samples that track, and samples that wait.

    At the right, how many of them appear, and the line b N; shaded are the frames in
    the mode "initialising".

    Parameters
    ----------
    tracker : Adaptive
    clip : Sequence
    track : Track
        With its particles.
    every : int
        Frames from one picture to the next.

    Yields
    ------
    (H, W, 3) uint8 RGB array
    """
    waiting = track.info["mode"] == INITIALISING
    fig, left, right = stage(3.0, len(clip))
    with in_style():
        draw_line(right, tracker.b * tracker.n, tracker.n)

    def draw(k: int) -> None:
        draw_mode(left, clip, track, k)
        times = np.arange(k + 1)
        shade_frames(right, times, waiting[: k + 1])
        right.plot(times, track.info["positives"][: k + 1], color=PERSON, lw=1.6)

    # The first frame has no particles yet.
    return drawn(fig, draw, range(1, len(clip), every))


def learning(
    tracker: Adaptive, clip: Sequence, track: Track, every: int = 5
) -> Iterator[Frame]:
    """A model that follows the target's looks, [N03], (11) and (12), or something else.

    The truth is dashed.  The curves at the right show how alike the model is to the van
    as it looks (full) and to what is beside it (dotted), and the tracker's own score
    (thin).

    Parameters
    ----------
    tracker : Adaptive
    clip : Sequence
    track : Track
        With its models.
    every : int
        Frames from one picture to the next.

    Yields
    ------
    (H, W, 3) uint8 RGB array
    """
    fig, left, right = stage(2.7, len(clip))
    alike = likeness(tracker, clip, track)
    score = pd.Series(track.info["rho"], range(len(clip)))
    lines = {
        "van": (alike.set_index("frame")["target"], {"lw": 2}),
        "beside it": (alike.set_index("frame")["beside"], {"lw": 2, "ls": ":"}),
        "own score": (score, {"lw": 0.8}),
    }
    with in_style():
        for name, (_, style) in lines.items():
            right.plot([], [], color=WITH, label=name, **style)
        right.legend(loc="lower left", ncols=3, bbox_to_anchor=(0, 1))
        right.set(ylabel=r"$\rho$ with the model", ylim=(0, 1.02))

    def draw(k: int) -> None:
        draw_where(left, clip, track, k, WITH)
        left.set_title(f"frame {k}, alpha = {tracker.alpha:g}")
        for values, style in lines.values():
            right.plot(values.loc[:k], color=WITH, **style)

    return drawn(fig, draw, range(0, len(clip), every))
