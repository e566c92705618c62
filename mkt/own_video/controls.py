"""The parts of the workbench.

`Source` says which video, `Method` how it is tracked, `Report` what comes of it.
"""

import asyncio
import html
import inspect
import re
import shlex
import time
import traceback
from collections.abc import Generator
from pathlib import Path
from typing import Any

import ipywidgets
import numpy as np
import traitlets

from mkt.figures.pictures import image_file
from mkt.own_video.settings import numbers_of
from mkt.sequences.carphone import clip_path
from mkt.trackers import by_name
from mkt.tracking import Tracker
from mkt.types import Frame

VIDEOS = {
    ".mp4",
    ".avi",
    ".mov",
    ".mkv",
    ".webm",
    ".m4v",
    ".mpg",
    ".mpeg",
    ".wmv",
}
FIRST = "guided"  # the tracker to begin with
PEEK = 0.25  # [s] between two looks at what is going on
LARGEST = 40e6  # bytes of a film that is still shown in the page
WRAPPED = {"flex_flow": "row wrap"}
IN_THE_PANEL = "here, with this box and seed; no command knows a notebook's own tracker"
ALERT = (
    "color: var(--jp-error-color0, #b00020); white-space: pre-wrap; line-height: 1.5"
)


class Source(ipywidgets.VBox):
    """Which video: one in the notebook's folder, any other, or the webcam's.

    The second is chosen by its path.

    Attributes
    ----------
    path : str
        What is chosen.
    """

    path = traitlets.Unicode()

    def __init__(self):
        self.listed = ipywidgets.Dropdown(
            description="video",
            tooltip="the clip of the book, or a video beside this notebook",
            layout={"width": "24em"},
        )
        self.again = ipywidgets.Button(
            icon="refresh",
            tooltip="look again for videos in this folder",
            layout={"width": "3em"},
        )
        self.other = ipywidgets.Text(
            description="or a path",
            placeholder="/home/me/ball.mp4, or a folder of images",
            tooltip="where another video lies",
            continuous_update=False,
            layout={"width": "28em"},
        )
        self.seconds = ipywidgets.BoundedIntText(
            10,
            min=1,
            max=600,
            description="or record",
            tooltip="how many seconds",
            layout={"width": "11em"},
        )
        self.camera = ipywidgets.Button(
            description="seconds of webcam",
            icon="video-camera",
            tooltip="record with the camera that the kernel sees, into a file",
            layout={"width": "auto"},
        )
        self.camera.add_class("mkt-webcam")
        self.typed: dict[str, str] = {}  # paths that are no videos of the folder
        self.listed.observe(self._choose, "value")
        self._look()
        film = ipywidgets.HBox([self.seconds, self.camera])
        row = [self.listed, self.again, self.other, film]
        super().__init__([ipywidgets.HBox(row, layout=WRAPPED)])
        self.again.on_click(self._look)
        self.other.observe(self._choose, "value")

    def enable(self, on: bool) -> None:
        """Let the reader choose, or not."""
        own = self.listed, self.again, self.other, self.seconds, self.camera
        for control in own:
            control.disabled = not on

    def offer(self, path: str) -> None:
        """Put a path into the list, choose it, and empty the field of other paths."""
        if path not in dict(self.listed.options).values():
            self.typed[path] = path
        self._list(path)
        self.other.value = ""

    def _look(self, _button: Any = None) -> None:
        self._list(self.listed.value)
        self._choose()

    def _list(self, chosen: str | None) -> None:
        clip = str(clip_path())
        found = sorted(p for p in Path().iterdir() if p.suffix.lower() in VIDEOS)
        options = {"carphone, the clip of this book": clip}
        options |= {path.name: str(path) for path in found} | self.typed
        known = list(options.values())
        # New options choose the first for a moment.
        self.listed.unobserve(self._choose, "value")
        self.listed.options = options.items()
        self.listed.value = chosen if chosen in known else known[0]
        self.listed.observe(self._choose, "value")

    def _choose(self, change: Any = None) -> None:
        if change and change.owner is self.listed:
            self.other.value = ""  # the last choice counts
        self.path = self.other.value.strip() or self.listed.value


class Method(ipywidgets.HBox):
    """The tracker, its numbers, and the seed of its random numbers."""

    def __init__(self):
        options = [(by_name.LABELS[name], name) for name in by_name.TRACKERS]
        self.tracker = ipywidgets.Dropdown(
            options=options,
            value=FIRST,
            description="tracker",
            tooltip="who follows the target",
            layout={"width": "24em"},
        )
        self.seed = ipywidgets.BoundedIntText(
            0,
            min=0,
            max=2**31 - 1,
            description="seed",
            tooltip="another one draws other random numbers; the same gives the same",
            layout={"width": "12em"},
        )
        self._fields = ipywidgets.HBox(layout=WRAPPED)
        super().__init__([self.tracker, self.seed, self._fields], layout=WRAPPED)
        self.tracker.observe(self._offer, "value")
        self._offer()

    @property
    def numbers(self) -> dict[str, float]:
        """The tracker's numbers as the fields have them, {name: value}."""
        return {field.description: field.value for field in self._fields.children}

    def enable(self, on: bool) -> None:
        """Let the reader choose, or not."""
        for control in self.tracker, self.seed, *self._fields.children:
            control.disabled = not on

    def _offer(self, _change: Any = None) -> None:
        tracker = by_name.TRACKERS[self.tracker.value]
        self._fields.children = [
            _number(name, value, meaning(tracker, name))
            for name, value in numbers_of(tracker).items()
        ]


def meaning(tracker: Tracker, name: str) -> str:
    """What a tracker's docstring says of one of its parameters, or of its filter's."""
    names = rf"^[\w, ]*\b{name}\b[\w, ]*(?: : .*)?\n"  # "eta, gamma : float"
    for kind in type(tracker).__mro__:  # what it inherits is described there
        text = inspect.getdoc(kind) or ""
        found = re.search(rf"{names}((?:    .*\n?)+)", text, re.MULTILINE)
        if found:
            return " ".join(found[1].split())
    inner = getattr(tracker, "filter", None)
    own = f"{name} of {type(tracker).__name__}"
    return own if inner is None else meaning(inner, name)


def _number(name: str, value: float, tooltip: str) -> ipywidgets.Widget:
    kind = ipywidgets.IntText if type(value) is int else ipywidgets.FloatText
    style = {"description_width": "7em"}
    words = {"tooltip": tooltip, "style": style}
    return kind(value, description=name, layout={"width": "12.5em"}, **words)


def _command(output: Path) -> str:
    """The line that tracks once more, as HTML; it wraps where the panel is narrow."""
    settings = shlex.quote(str(output.with_suffix(".json").resolve()))
    line = html.escape(f"python3 -m mkt track --settings {settings}", quote=False)
    return f'<code style="overflow-wrap: anywhere">{line}</code>'


class Report(ipywidgets.VBox):
    """What the panel says and shows: a sentence, a bar, a picture, the whole film."""

    def __init__(self):
        self.note = ipywidgets.HTML()
        self.bar = ipywidgets.IntProgress(
            layout={"width": "100%", "visibility": "hidden"}
        )
        self.picture = ipywidgets.Image(
            format="jpeg", layout={"width": "100%", "display": "none"}
        )
        super().__init__([self.note, self.bar, self.picture])
        self.note.add_class("mkt-note")

    def clear(self, text: str) -> None:
        """Say something and show nothing else."""
        self.note.value = html.escape(text)
        self.bar.layout.visibility = "hidden"
        self.picture.layout.display = "none"
        self.children = self.children[:3]

    def say(self, error: Exception) -> None:
        """Report an error.

        It is one sentence if the reader can correct it, and has its traceback if the
        fault is ours.
        """
        text = "\n".join([str(error), *getattr(error, "__notes__", ())])
        if not isinstance(error, (ValueError, OSError)):
            text = "".join(traceback.format_exception(error, limit=-3))
        self.clear("")
        escaped = html.escape(text)
        self.note.value = f'<div role="alert" style="{ALERT}">{escaped}</div>'

    async def watch(
        self, pictures: Generator[Frame], length: int | None, doing: str
    ) -> bool:
        """Go through pictures and show some, leaving the kernel a moment after each.

        Parameters
        ----------
        pictures : generator of (H, W, 3) uint8 RGB arrays
        length : int, optional
            How many, if that is known.
        doing : str
            What is being done, in a word.

        Returns
        -------
        bool
            False when it was cancelled.
        """
        self.clear(f"{doing} ...")
        self.bar.layout.visibility = "visible"
        self.bar.max = length or 1
        self.bar.value = 0
        last = -np.inf
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

    def _peek(self, picture: Frame, done: int, length: int | None, doing: str) -> None:
        self.picture.value = image_file(picture, ".jpg")
        self.picture.layout.display = "flex"
        self.bar.value = done
        of = f" of {length}" if length else ""
        self.note.value = f"{doing}: frame {done}{of}"

    def finish(self, output: Path, tracker: str, stopped: str = "") -> None:
        """Say what was written and how to have it again, and show the film.

        Parameters
        ----------
        output : Path
            Of the film.
        tracker : str
            Its name.
        stopped : str, optional
            A sentence if it was stopped.
        """
        self.clear("")
        again = "The whole track" if stopped else "The same track again"
        self.note.value = (
            f"{stopped}Written: <code>{html.escape(str(output))}</code>, "
            f"<code>.csv</code> and <code>.json</code>.<br>{again}: "
            + (_command(output) if tracker in by_name.SHIPPED else IN_THE_PANEL)
        )
        if output.stat().st_size < LARGEST:
            # Made now, because an empty one is an error in the browser.
            film = ipywidgets.Video.from_file(
                output,
                format="webm",
                autoplay=False,
                loop=False,
                layout={"width": "100%"},
            )
            self.children = (*self.children, film)
