"""Films in notebooks and in the book: `play` puts one inside the page.

`drawn` makes the pictures of one from a figure, such as a `stage`.  Neither a network
nor a kernel is needed to see a film.  Films are WebM with VP8, which browsers play and
OpenCV can write by itself, at about one bit for each pixel of each picture.
"""

import html
from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, cast

import cv2
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from mkt.checks import checked_frame, is_number
from mkt.figures.pictures import data_uri, image_file
from mkt.plotting import in_style, new_figure
from mkt.sequences.writing import video_writer
from mkt.types import Frame

if TYPE_CHECKING:
    from IPython.display import HTML  # a figure on the disk needs no notebook

WIDTH, DPI = 7.6, 80  # of a picture [inch], and dots an inch
QUALITY = 85  # of the picture that stands there until the film is started
BAR = 72  # [px] below the pictures, for the browser's controls, which lie over a film


def stage(height: float, length: int) -> tuple[Figure, Axes, Axes]:
    """A figure of a height [inch], with axes for a frame, and for curves beside it.

    The curves are over so many frames.
    """
    with in_style():
        fig = new_figure((WIDTH, height), DPI)
        left = fig.add_axes((0.01, 0.02, 0.465, 0.87))
        right = fig.add_axes((0.57, 0.17, 0.415, 0.7))
        left.set_axis_off()
        right.set(xlabel="frame", xlim=(0, length - 1))
    return fig, left, right


def drawn(
    fig: Figure, draw: Callable[[int], None], moments: Iterable[int]
) -> Iterator[Frame]:
    """The pictures of a film, each drawn on a figure that itself stays as it is.

    Only what moves is drawn anew; the rest is restored from a background.

    Parameters
    ----------
    fig : Figure
        With what all pictures share.
    draw : callable
        Puts on its axes what belongs to a moment; titles may be set, too.
    moments : iterable of int

    Yields
    ------
    (H, W, 3) uint8 RGB array
    """
    canvas = cast(FigureCanvasAgg, fig.canvas)
    titles = [ax.title for ax in fig.axes]
    _leave_out(titles, True)  # drawn with each picture, and not below it too
    with in_style():
        canvas.draw()
    _leave_out(titles, False)
    background = canvas.copy_from_bbox(fig.bbox)
    fixed = {artist for ax in fig.axes for artist in ax.get_children()}
    for moment in moments:
        canvas.restore_region(background)
        # Not round the whole loop: between two pictures the caller may draw, too.
        with in_style():
            draw(moment)
            moving = _moving(fig, fixed)
            for artist in [*moving, *titles]:
                fig.draw_artist(artist)
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()
        for artist in moving:
            artist.remove()


def _leave_out(artists: list[Text], out: bool) -> None:
    """Draw a figure without these, or with them; its layout has them in any case."""
    for artist in artists:
        artist.set_animated(out)


def _moving(fig: Figure, fixed: set[Artist]) -> list[Artist]:
    """What was put on the axes, from below upwards."""
    new = [each for ax in fig.axes for each in ax.get_children() if each not in fixed]
    return sorted(new, key=lambda artist: artist.zorder)


def play(frames: Iterable[Frame], fps: float, alt: str) -> "HTML":
    """Show pictures as a film with the browser's own controls.

    It waits to be started, and until then shows its last picture.

    Parameters
    ----------
    frames : iterable of (H, W, 3) uint8 RGB arrays
        Of one size, at least one.
    fps : float
        Pictures a second.
    alt : str
        What is to be seen, in words.

    Raises
    ------
    ValueError
        Where there is no picture, one is not of uint8 or has another size than the
        first, and where fps is not above 0.
    """
    from IPython.display import HTML

    film, last = webm(frames, fps)
    poster = image_file(last, ".webp", cv2.IMWRITE_WEBP_QUALITY, QUALITY)
    text = html.escape(alt, quote=True)
    high, wide = last.shape[:2]
    height = f"calc(min({wide}px, 100vw) * {high / wide:.4f} + {BAR}px)"
    place = "object-fit: contain; object-position: left top"
    return HTML(
        f'<video controls muted playsinline width="{wide}" '
        f'style="max-width: 100%; height: {height}; {place}" aria-label="{text}" '
        f'poster="{data_uri("image/webp", poster)}" '
        f'src="{data_uri("video/webm", film)}">{text}</video>'
    )


def webm(frames: Iterable[Frame], fps: float) -> tuple[bytes, Frame]:
    """Pictures as the bytes of a film, and the last of them.

    The arguments and errors are those of `play`.
    """
    if not (is_number(fps, 0) and fps > 0):
        raise ValueError(f"fps is {fps!r}; give pictures a second, above 0")
    frames = map(checked_frame, frames)
    first = picture = next(frames, None)
    if first is None:
        raise ValueError("there are no pictures, so there is no film")
    with TemporaryDirectory() as folder:
        path = Path(folder) / "film.webm"
        with video_writer(path, first.shape[1::-1], fps) as writer:
            for picture in chain([first], frames):
                if picture.shape != first.shape:
                    raise ValueError(
                        f"a picture is {picture.shape}, the first was {first.shape}; "
                        "all pictures of a film need one size"
                    )
                writer.write(cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
        return path.read_bytes(), picture
