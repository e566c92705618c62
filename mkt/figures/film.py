"""Films in notebooks and in the book: `play` puts one inside the page.

So neither a network nor a kernel is needed.  They are WebM with VP8, which browsers
play and OpenCV can write by itself, at about one bit for each pixel of each picture.
"""

import html
from collections.abc import Iterable
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
from IPython.display import HTML

from mkt.figures.data_uri import data_uri
from mkt.sequences.writing import video_writer
from mkt.types import Frame

QUALITY = 85  # of the picture that stands there until the film is started


def play(frames: Iterable[Frame], fps: float, alt: str) -> HTML:
    """Show pictures as a film with the browser's own controls.

    It waits to be started, and until then shows its last picture.

    Parameters
    ----------
    frames : iterable of (H, W, 3) uint8 RGB arrays
        Of one size, at least one.
    fps : float
        How many a second.
    alt : str
        What is to be seen, in words.

    Raises
    ------
    ValueError
        Where a picture has another size than the first.
    """
    film, last = webm(frames, fps)
    options = (cv2.IMWRITE_WEBP_QUALITY, QUALITY)
    poster = cv2.imencode(".webp", cv2.cvtColor(last, cv2.COLOR_RGB2BGR), options)[1]
    text = html.escape(alt, quote=True)
    return HTML(
        f'<video controls muted playsinline width="{last.shape[1]}" '
        f'style="max-width: 100%; height: auto" aria-label="{text}" '
        f'poster="{data_uri("image/webp", poster.tobytes())}" '
        f'src="{data_uri("video/webm", film)}">{text}</video>'
    )


def webm(frames: Iterable[Frame], fps: float) -> tuple[bytes, Frame]:
    """Pictures as the bytes of a film, and the last of them.

    The arguments and errors are those of `play`.
    """
    frames = iter(frames)
    first = picture = next(frames)
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
