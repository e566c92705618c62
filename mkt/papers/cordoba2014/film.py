"""Two filters behind pillars as a film: a cloud that opens, and one that does not.

`mkt.figures.film.play` shows it.  Explained in notebook 13.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from mkt.evaluation import SEEN
from mkt.figures.film import drawn, stage
from mkt.papers.cordoba2014.printed import COLORS, NAMES
from mkt.plotting import draw_box, in_style, shade_frames, show_frame
from mkt.tracking import Sequence, Track
from mkt.types import Array, Frame


def width(track: Track) -> Array:
    """The width of the middle 80 % of the particles of a track, (T,) [px]."""
    x = track.info["particles"][..., 0]
    return np.quantile(x, 0.9, axis=1) - np.quantile(x, 0.1, axis=1)


def film(
    clip: Sequence, tracks: Mapping[str, Track], every: int = 4
) -> Iterator[Frame]:
    """The boxes of trackers with their particles; the truth is dashed.

    The curves at the right show how wide the clouds are.  Frames in which more than
    half of the target is hidden are shaded.

    Parameters
    ----------
    clip : Sequence
    tracks : {name: Track}
        By the names of Table 1 of [C14], with their particles.
    every : int
        Frames from one picture to the next.

    Yields
    ------
    (H, W, 3) uint8 RGB array
    """
    fig, left, right = stage(3.0, len(clip))
    widths = {name: width(track) for name, track in tracks.items()}
    hidden = clip.visibility <= SEEN
    with in_style():
        for name in tracks:
            right.plot([], [], color=COLORS[name], lw=2, label=NAMES[name])
        right.legend(loc="lower left", ncols=3, bbox_to_anchor=(0, 1))
        tallest = max(np.nanmax(values) for values in widths.values())
        right.set(ylabel="width of the cloud [px]", ylim=(0, 1.05 * tallest))

    def draw(k: int) -> None:
        show_frame(left, clip.frames[k], f"frame {k}")
        draw_box(left, clip.truth[k], "white", lw=1.4, ls="--")
        times = np.arange(k + 1)
        shade_frames(right, times, hidden[: k + 1])
        for name, track in tracks.items():
            x, y = track.info["particles"][k][:, :2].T
            left.plot(x, y, ".", color=COLORS[name], ms=2.5)
            draw_box(left, track.regions[k], COLORS[name], lw=2)
            right.plot(times, widths[name][: k + 1], color=COLORS[name], lw=2)

    return drawn(fig, draw, range(0, len(clip), every))
