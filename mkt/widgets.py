"""Figures in notebooks: `show` draws one, `explore` gives it its sliders.

In JupyterLab `explore` is a `Panel`: the running kernel draws every slider position that is asked for.  In the book there is no kernel, so
with ``MKT_STATIC=1`` in the environment it is a `mkt.page.Page`: a few positions of each slider, drawn beforehand, and a few lines of script.
Both have ``values``, the parameters as they stand, so that a later cell reads the same in either.

Explained in notebook 01.
"""

import asyncio
import gc
import html
import os
import threading
import time
import traceback
from contextlib import suppress
from functools import lru_cache

import cv2
import ipywidgets
from IPython.display import Image

from mkt import figures
from mkt.page import Page, caption, encoded, label, width
from mkt.tracking import heard

LIVE_DPI, SHARP_DPI = 100, 160
KEPT = 64  # pictures of a panel, about 15 MB
QUICK, PAUSE = 0.5, 0.01  # [s] of CPU for a drawing that may be made ahead; before it begins, so that a waiting move comes first
TELL = 0.15  # [s] between two words on how far a run over a sequence is
_DRAWING = threading.Lock()  # JupyterLab has some moves answered by a second thread of the kernel, while the first one draws another


def show(id, **parameters):
    """Draw a registered figure with its defaults, but for `parameters`.

    Returns an `IPython.display.Image` with the caption as its alternative text, or a `mkt.page.Page` without sliders where MKT_STATIC=1.
    Raises KeyError for an unknown figure and ValueError for an unknown parameter, both listing the known ones.
    """
    entry = figures.get(id)
    if _static():
        return Page(entry, entry.defaults | parameters)
    canvas, _ = entry.draw(SHARP_DPI, **parameters)
    return Image(encoded(canvas, ".png"), format="png", width=width(entry), alt=f"{entry.title} {entry.caption}".replace("\n", " "))


def explore(id, **fixed):
    """A registered figure with its sliders; parameters named in `fixed` keep their value and lose their slider.

    Returns a `Panel`, or a `Page` where MKT_STATIC=1.  Raises KeyError for an unknown figure and ValueError for an unknown parameter.
    """
    return (Page if _static() else Panel)(figures.get(id), fixed)


def _static():
    return os.environ.get("MKT_STATIC") == "1"


class Panel(ipywidgets.VBox):
    """The live figure: sliders, and one image that follows every move.

    What was drawn is kept.  Where drawing is quick, the next step the same way is drawn while the reader looks at this one.

    values: {name: value} of every parameter; numbers: what the figure's function returned for them.
    """

    def __init__(self, entry, fixed):
        self._entry, self._fixed = entry, fixed
        self._controls = {name: _control(entry, name) for name in entry.sliders if name not in fixed}
        self._image = ipywidgets.Image(format="png", width=width(entry), layout={"max_width": "100%", "object_fit": "contain"})
        self._trouble = ipywidgets.HTML()
        self._progress = ipywidgets.FloatProgress(max=1.0, layout={"visibility": "hidden", "width": "24em"})
        self._drawn = lru_cache(KEPT)(self._draw)
        reset = ipywidgets.Button(description="reset", tooltip="back to where the sliders began", layout={"width": "6em"})
        row = ipywidgets.HBox([*self._controls.values(), reset, self._progress], layout={"flex_flow": "row wrap"})
        self._show()  # a mistake in `fixed` ends the cell, as any mistake does
        super().__init__([row, self._image, self._trouble, ipywidgets.HTML(caption(entry))])
        self.add_class("mkt-panel")
        self._listen(True)
        reset.on_click(self.reset)

    @property
    def values(self):
        """The parameters as they stand, {name: value}."""
        return self._entry.defaults | self._fixed | {name: control.value for name, control in self._controls.items()}

    def reset(self, _button=None):
        """Move every slider back to where it began, and show that at once."""
        self._listen(False)
        for name, control in self._controls.items():
            control.value = self._entry.defaults[name]
        self._listen(True)
        self._redraw()

    def _listen(self, on):
        for control in self._controls.values():
            (control.observe if on else control.unobserve)(self._redraw, names="value")

    # A slider that is dragged never runs ahead of the drawing: the browser sends the newest value once the last one is answered.
    def _redraw(self, change=None):
        try:
            self._show()
            self._trouble.value = ""
            if change and self._cost < QUICK:
                self._look_ahead(change)
        except Exception:
            self._trouble.value = f'<pre style="color: #b00020; white-space: pre-wrap">{html.escape(traceback.format_exc(limit=-3))}</pre>'

    def _show(self):
        with _DRAWING:
            self._image.value, self.numbers, self._cost = self._drawn(tuple(self.values.items()))

    def _draw(self, values):
        """The picture as PNG, the numbers that it shows, and the CPU time [s] that both took.  What takes long shows how far it is."""
        start, self._told = time.process_time(), time.monotonic()
        gc.disable()  # a figure is thousands of small objects; looking for garbage among them takes a tenth of the time
        try:
            with heard(self._tell):
                canvas, numbers = self._entry.draw(LIVE_DPI, **dict(values))
            return encoded(canvas, ".png", cv2.IMWRITE_PNG_COMPRESSION, 1), numbers, time.process_time() - start
        finally:
            gc.enable()
            self._progress.layout.visibility = "hidden"

    def _tell(self, done, length):
        if time.monotonic() > self._told + TELL:
            self._told, self._progress.value, self._progress.description = time.monotonic(), done / length, f"{done} of {length}"
            self._progress.layout.visibility = "visible"

    def _look_ahead(self, change):
        options = [value for _, value in change.owner.options]
        at = options.index(change.new)
        beyond = 2 * at - options.index(change.old)
        if abs(beyond - at) == 1 and 0 <= beyond < len(options):
            name = change.owner.description
            with suppress(RuntimeError):  # no event loop, so no reader either
                asyncio.get_running_loop().call_later(PAUSE, self._draw_ahead, self.values | {name: options[beyond]})

    def _draw_ahead(self, values):
        with suppress(Exception), _DRAWING:  # an error will be told if it is ever asked for
            self._drawn(tuple(values.items()))


def _control(entry, name):
    options = [(label(value), value) for value in entry.values(name)]
    kind = ipywidgets.Dropdown if isinstance(entry.sliders[name], list) else ipywidgets.SelectionSlider
    return kind(options=options, value=entry.defaults[name], description=name, style={"description_width": "5.5em"}, layout={"width": "24em"})
