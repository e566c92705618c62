"""The workbench on a page without a kernel: a run as the live one leaves it."""

from collections.abc import Iterator

import cv2

from mkt.figures.film import play
from mkt.own_video.overlay import annotated
from mkt.own_video.settings import settled
from mkt.own_video.typed_box import first_box
from mkt.sequences.carphone import carphone
from mkt.tracking import follow
from mkt.types import Frame

ALT = "A man talks in a moving car; a green outline follows his head through the clip."
TEXT = (
    "Here the tracker <i>guided</i> has followed the head in the clip of the book.  In "
    "JupyterLab (<code>python3 -m mkt lab</code>) this is a panel: choose a video, "
    "draw a box on its first frame with the mouse, choose a tracker, press "
    "<i>track</i>."
)
ENLARGED = 2
EVERY = 2  # frames from one picture to the next: half the bytes, and smooth enough


class Finished:
    """A run with the default settings.

    Attributes
    ----------
    settings : mkt.own_video.settings.Settings
    clip : mkt.tracking.Sequence
    """

    def __init__(self):
        clip = carphone()
        self.settings = settled(clip.frames.path, first_box(clip))
        self.clip = self.settings.sequence()

    def _repr_html_(self) -> str:
        film = play(self._pictures(), self.clip.fps / EVERY, ALT).data
        caption = f"<figcaption>{TEXT}</figcaption>"
        return f'<figure class="mkt-panel">{film}{caption}</figure>'

    def _pictures(self) -> Iterator[Frame]:
        settings = self.settings
        infos = follow(settings.configured(), self.clip, settings.seed)
        for k, (frame, info) in enumerate(zip(self.clip.frames, infos, strict=True)):
            if k % EVERY == 0:
                picture = annotated(frame, info, f"{k} {settings.tracker}")
                yield cv2.resize(picture, None, fx=ENLARGED, fy=ENLARGED)
