"""A video of your own in the notebook: choose it, draw a box, choose a tracker, watch it run, keep what came out.

`workbench` gives the live `Workbench`, or with ``MKT_STATIC=1`` in the environment, where no kernel will answer, a `Finished` run.  Both have
``settings``, so that a later cell reads the same in either.

Explained in notebook 03.
"""

import asyncio
import os
import time
from itertools import count
from pathlib import Path

import ipywidgets
import traitlets

from mkt import webcam
from mkt.datasets import video
from mkt.recording import Recorder, begun
from mkt.settings import region_of, settled
from mkt.workbench.box_picker import BoxPicker
from mkt.workbench.finished import Finished, first_box
from mkt.workbench.parts import Method, Report, Source

FOLDER = Path("tracked")  # where results go, beside the notebook
SETTLED = 0.3  # [s]: the browser holds back its newest box until the kernel has answered the one before, so it may come after the click
EMPTY, READY, BUSY = "empty", "ready", "busy"


def workbench():
    """A `Workbench`, or with MKT_STATIC=1 a `Finished` run on the clip of the book."""
    return Finished() if os.environ.get("MKT_STATIC") == "1" else Workbench()


class Workbench(ipywidgets.VBox):
    """The panel.

    state: EMPTY without a video, READY with one, BUSY while it records or tracks.  clip: the `Sequence`, None while EMPTY.
    task: what runs or ran last, an `asyncio.Task` of the kernel's own loop, so that the stop button is heard between two frames.
    output: the last film that was written; the table and the settings lie beside it.
    """

    state = traitlets.Enum([EMPTY, READY, BUSY], EMPTY)

    def __init__(self):
        self.clip = self.task = self.output = None
        self.source, self.picker, self.method, self.report = Source(), BoxPicker(), Method(), Report()
        self.track = ipywidgets.Button(description="track", icon="play", button_style="primary", tooltip="follow what is in the box, to the end of the video")
        self.stop = ipywidgets.Button(description="stop", icon="stop", tooltip="end it and keep what was done")
        for name, button in ("track", self.track), ("stop", self.stop):
            button.add_class(f"mkt-{name}")
        half = {"flex": "1 1 380px", "max_width": "490px", "overflow": "hidden"}
        pictures = ipywidgets.HBox([ipywidgets.VBox([part], layout=half) for part in (self.picker, self.report)], layout={"flex_flow": "row wrap", "grid_gap": "12px"})
        super().__init__([self.source, self.method, ipywidgets.HBox([self.track, self.stop]), pictures])
        self.add_class("mkt-workbench")
        self.source.observe(self._opened, "path")
        self.source.camera.on_click(lambda _: self._begin(self._record))
        self.track.on_click(lambda _: self._begin(self._follow))
        self.stop.on_click(lambda _: self.task.get_loop().call_soon_threadsafe(self.task.cancel))  # the click may come in another thread
        self.observe(self._enter, "state")
        self._opened()
        self._enter()

    @property
    def settings(self):
        """The `mkt.settings.Settings` as they stand.  Raises ValueError where they make no sense."""
        if self.clip is None:
            raise ValueError("there is no video; choose one in the panel")
        region_of(self.picker.box, self.clip.frames[0])
        return settled(self.clip.frames.path, self.picker.box, self.method.tracker.value, self.method.numbers, self.method.seed.value)

    def _enter(self, _change=None):
        """What can be touched in which state."""
        self.track.disabled, self.stop.disabled = self.state != READY, self.state != BUSY
        self.picker.enabled = self.state == READY
        self.source.enable(self.state != BUSY)
        self.method.enable(self.state != BUSY)

    def _opened(self, _change=None):
        try:
            self.clip = video(self.source.path)
            self.picker.show(self.clip.frames[0], first_box(self.clip))
        except (ValueError, OSError) as error:
            self.clip, self.state = None, EMPTY
            return self.report.say(error)
        self.source.offer(self.source.path)
        self.state = READY
        height, width = self.clip.frames[0].shape[:2]
        self.report.clear(f"{self.clip.source}: {len(self.clip)} frames of {width}x{height} px, {self.clip.fps:.4g} a second.  Draw a box round the target.")

    def _begin(self, work):
        if self.state != BUSY:  # a second click may be under way when the first one disables the button
            self.state = BUSY
            self.task = asyncio.get_running_loop().create_task(self._guarded(work))

    async def _guarded(self, work):
        """Do the work; whatever ends it, the panel says what happened and can be used again."""
        try:
            await work()
        except Exception as error:
            self.report.say(error)
        finally:
            self.state = EMPTY if self.clip is None else READY

    async def _follow(self):
        await asyncio.sleep(SETTLED)
        settings = self.settings
        infos = begun(settings.configured(), self.clip, settings.seed, region_of(settings.box, self.clip.frames[0]))
        output = self._free(settings.tracker)
        with Recorder(output, self.clip, settings.tracker) as recorder:
            pictures = (recorder.add(frame, info) for frame, info in zip(self.clip.frames, infos))
            whole = await self.report.watch(pictures, len(self.clip), "tracking")
        settings.save(output.with_suffix(".json"))
        self.output = output
        self.report.finish(output, "" if whole else f"Stopped: {recorder.done} of {len(self.clip)} frames are in the files.  ")

    async def _record(self):
        FOLDER.mkdir(exist_ok=True)
        output = FOLDER / time.strftime("webcam-%Y%m%d-%H%M%S.avi")
        await self.report.watch(webcam.record(output, self.source.seconds.value), None, "recording")
        self.source.other.value = str(output)

    def _free(self, word):
        """A path in FOLDER that no earlier run has taken."""
        FOLDER.mkdir(exist_ok=True)
        names = (FOLDER / f"{self.clip.name}-{word}{'' if k == 1 else f'-{k}'}.webm" for k in count(1))
        return next(path for path in names if not path.exists())
