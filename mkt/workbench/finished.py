"""The workbench on a page without a kernel: a run on the clip of the book, as the live one leaves it."""

import cv2

from mkt.animation import play
from mkt.datasets import carphone
from mkt.recording import annotated
from mkt.settings import settled
from mkt.tracking import follow

ALT = "A man talks in a moving car; a green outline follows his head through the clip."
TEXT = ("Here the tracker <i>guided</i> has followed the head in the clip of the book.  In JupyterLab (<code>python3 -m mkt lab</code>) this is a panel: choose a "
        "video, draw a box on its first frame with the mouse, choose a tracker, press <i>track</i>.")
ENLARGED = 2


class Finished:
    """A run with the default settings.

    settings: its `mkt.settings.Settings`; clip: its `mkt.tracking.Sequence`.
    """

    def __init__(self):
        self.settings = settled(carphone().frames.path, first_box(carphone()))
        self.clip = self.settings.sequence()

    def _repr_html_(self):
        infos = follow(self.settings.configured(), self.clip, self.settings.seed)
        pictures = (annotated(frame, info, f"{k} {self.settings.tracker}") for k, (frame, info) in enumerate(zip(self.clip.frames, infos)))
        large = (cv2.resize(picture, None, fx=ENLARGED, fy=ENLARGED, interpolation=cv2.INTER_LINEAR) for picture in pictures)
        return f'<figure class="mkt-panel">{play(large, self.clip.fps, ALT).data}<figcaption>{TEXT}</figcaption></figure>'


def first_box(clip):
    """A box to begin with, x, y, w, h, angle in whole pixels: the head in the clip of the book, elsewhere the middle of the first frame."""
    if clip.frames.path == carphone().frames.path:
        cx, cy, _, hx, hy = carphone().truth[0]
        return tuple(map(round, (cx - hx + 0.5, cy - hy + 0.5, 2 * hx, 2 * hy, 0)))
    height, width = clip.frames[0].shape[:2]
    return round(width / 3), round(height / 3), round(width / 3), round(height / 3), 0
