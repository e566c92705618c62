"""A video of your own in the notebook: choose it, draw a box, track, keep the result.

`workbench` gives the live `Workbench`, or a `Finished` run in the book, where no kernel
will answer.  Both have ``settings``, so that a later cell reads the same in either.

Explained in notebook 03.
"""

import asyncio
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import ipywidgets
import traitlets

from mkt.figures import is_static
from mkt.own_video import webcam
from mkt.own_video.box_picker import BoxPicker
from mkt.own_video.controls import Method, Report, Source
from mkt.own_video.recording import Recorder, begun, free
from mkt.own_video.settings import Settings, settled
from mkt.own_video.static import Finished
from mkt.own_video.typed_box import first_box, region_of
from mkt.sequences.truth_formats import video
from mkt.sequences.video import ImageFolder
from mkt.tracking import Sequence

FOLDER = Path("tracked")  # where results go, beside the notebook
# [s]: the browser holds back its newest box until the kernel has answered the one
# before, so it may come after the click.
SETTLED = 0.3
EMPTY, READY, BUSY = "empty", "ready", "busy"
HALF = {"flex": "1 1 380px", "max_width": "490px", "overflow": "hidden"}
BESIDE = {"flex_flow": "row wrap", "grid_gap": "12px"}


def workbench() -> "Workbench | Finished":
    """A `Workbench`; in the book a `Finished` run on its clip."""
    return Finished() if is_static() else Workbench()


class Workbench(ipywidgets.VBox):
    """The panel.

    Attributes
    ----------
    state : str
        EMPTY without a video, READY with one, BUSY while it records or tracks.
    clip : mkt.tracking.Sequence or None
        None while EMPTY.
    task : asyncio.Task or None
        What runs or ran last, in the kernel's own loop, so that the stop button works
        between two frames.
    output : Path or None
        The last film that was written; the table and the settings lie beside it.
    """

    state = traitlets.Enum([EMPTY, READY, BUSY], EMPTY)

    def __init__(self):
        self.clip: Sequence | None = None
        self.task: asyncio.Task | None = None
        self.output: Path | None = None
        self.source = Source()
        self.picker = BoxPicker()
        self.method = Method()
        self.report = Report()
        self.track = _button(
            "track", "play", "follow what is in the box, to the end of the video"
        )
        self.track.button_style = "primary"
        self.stop = _button("stop", "stop", "end it and keep what was done")
        halves = [ipywidgets.VBox([p], layout=HALF) for p in (self.picker, self.report)]
        buttons = ipywidgets.HBox([self.track, self.stop])
        pictures = ipywidgets.HBox(halves, layout=BESIDE)
        super().__init__([self.source, self.method, buttons, pictures])
        self.add_class("mkt-workbench")
        self._listen()
        self._opened()
        self._enter()

    def _listen(self) -> None:
        self.source.observe(self._opened, "path")
        self.source.camera.on_click(lambda _: self._begin(self._record))
        self.track.on_click(lambda _: self._begin(self._follow))
        self.stop.on_click(lambda _: self._cancel())
        self.observe(self._enter, "state")

    @property
    def settings(self) -> Settings:
        """The settings as they stand.  Raises ValueError where they make no sense."""
        if self.clip is None:
            raise ValueError("there is no video; choose one in the panel")
        if not any(self.picker.box[2:4]):
            raise ValueError("there is no box yet; draw one round the target")
        region_of(self.picker.box, self.clip.frames[0])
        return settled(
            self.clip.frames.path,
            self.picker.box,
            self.method.tracker.value,
            self.method.numbers,
            self.method.seed.value,
        )

    def _enter(self, _change: Any = None) -> None:
        """What can be touched in which state."""
        self.track.disabled = self.state != READY
        self.stop.disabled = self.state != BUSY
        self.picker.enabled = self.state == READY
        self.source.enable(self.state != BUSY)
        self.method.enable(self.state != BUSY)

    def _forget(self) -> None:
        """No path is chosen, so that a file which is mended can be chosen again."""
        self.source.unobserve(self._opened, "path")
        self.source.path = ""
        self.source.observe(self._opened, "path")

    def _opened(self, _change: Any = None) -> None:
        try:
            clip = video(self.source.path)
            self.picker.show(clip.frames[0], first_box(clip))
        except (ValueError, OSError) as error:
            self.clip, self.state = None, EMPTY
            self.report.say(error)
            self._forget()
            return
        self.clip = clip
        self.source.offer(self.source.path)
        self.state = READY
        height, width = clip.frames[0].shape[:2]
        many = "1 frame" if len(clip) == 1 else f"{len(clip)} frames"
        self.report.clear(
            f"{clip.source}: {many} of {width}x{height} px{_ends(clip)}, "
            f"{clip.fps:.4g} a second.  Draw a box round the target."
        )

    def _begin(self, work: Callable[[], Awaitable[None]]) -> None:
        # A second click may be under way when the first one disables the button.
        if self.state != BUSY:
            loop = asyncio.get_running_loop()
            self.state = BUSY
            self.task = loop.create_task(self._guarded(work))

    def _cancel(self) -> None:
        if self.task is not None:  # the click may come in another thread
            self.task.get_loop().call_soon_threadsafe(self.task.cancel)

    async def _guarded(self, work: Callable[[], Awaitable[None]]) -> None:
        """Do the work; whatever ends it, the panel says so and can be used again."""
        try:
            await work()
        except asyncio.CancelledError:
            self.report.clear("Stopped before the first frame; nothing was written.")
        except Exception as error:
            self.report.say(error)
        finally:
            self.state = EMPTY if self.clip is None else READY

    async def _follow(self) -> None:
        await asyncio.sleep(SETTLED)
        settings, clip = self.settings, self.clip
        start = region_of(settings.box, clip.frames[0])
        infos = begun(settings.configured(), clip, settings.seed, start, settings)
        output = free(_folder() / f"{clip.name}-{settings.tracker}.webm")
        with Recorder(output, clip, settings.tracker, settings) as recorder:
            pictures = (
                recorder.add(frame, info)
                for frame, info in zip(clip.frames, infos, strict=True)
            )
            whole = await self.report.watch(pictures, len(clip), "tracking")
        self.output = output
        stopped = f"Stopped: {recorder.done} of {len(clip)} frames are in the files.  "
        self.report.finish(output, settings.tracker, "" if whole else stopped)

    async def _record(self) -> None:
        output = free(_folder() / time.strftime("webcam-%Y%m%d-%H%M%S.avi"))
        pictures = webcam.record(output, self.source.seconds.value)
        try:
            await self.report.watch(pictures, None, "recording")
        finally:
            if output.exists():  # also what a camera saw before it stopped
                self.source.other.value = str(output)


def _folder() -> Path:
    """`FOLDER`, made where it is not there."""
    try:
        FOLDER.mkdir(exist_ok=True)
    except OSError as error:
        raise OSError(
            f"no folder {FOLDER} can be made for the results: {error.strerror}; move "
            "away what has this name, or copy the notebook into a folder of your own "
            "and start it there"
        ) from error
    return FOLDER


def _ends(clip: Sequence) -> str:
    """The names of the first and the last image: their numbers tell if some lack."""
    if not isinstance(clip.frames, ImageFolder):
        return ""
    return f", {clip.frames.files[0].name} to {clip.frames.files[-1].name}"


def _button(name: str, icon: str, tooltip: str) -> ipywidgets.Button:
    button = ipywidgets.Button(description=name, icon=icon, tooltip=tooltip)
    button.add_class(f"mkt-{name}")
    return button
