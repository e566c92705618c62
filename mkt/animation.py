"""Films in notebooks and in the book: `play` puts one on the page, inside the page, so that neither a network nor a kernel is needed.

Written as WebM with VP8, which browsers play and OpenCV can write by itself, at about one bit for each pixel of each picture.
"""

import base64
import html
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
from IPython.display import HTML

from mkt.recording import video


def play(frames, fps, alt):
    """Show pictures as a film with the browser's own controls.  It waits to be started, and until then shows its last picture.

    frames: (H, W, 3) uint8 RGB pictures of one size, any iterable, at least one; fps: how many a second; alt: what is to be seen, in words.
    Returns an `IPython.display.HTML`.  Raises ValueError where a picture has another size than the first.
    """
    film, last = webm(frames, fps)
    poster = cv2.imencode(".webp", cv2.cvtColor(last, cv2.COLOR_RGB2BGR), (cv2.IMWRITE_WEBP_QUALITY, 85))[1].tobytes()
    text = html.escape(alt, quote=True)
    return HTML(f'<video controls muted playsinline width="{last.shape[1]}" style="max-width: 100%; height: auto" aria-label="{text}" '
                f'poster="{_uri("image/webp", poster)}" src="{_uri("video/webm", film)}">{text}</video>')


def webm(frames, fps):
    """Pictures as the bytes of a film, and the last of them.  Arguments and errors as of `play`."""
    frames = iter(frames)
    first = picture = next(frames)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "film.webm"
        with video(path, first.shape[1::-1], fps) as writer:
            for picture in chain([first], frames):
                if picture.shape != first.shape:
                    raise ValueError(f"a picture is {picture.shape}, the first was {first.shape}; all pictures of a film need one size")
                writer.write(cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
        return path.read_bytes(), picture


def _uri(kind, data):
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"
