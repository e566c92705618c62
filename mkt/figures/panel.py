"""The live figure in JupyterLab: sliders, and one image that follows every move.

`mkt.figures.explore` makes a `Panel`.  Explained in notebook 01.
"""

import asyncio
import gc
import html
import threading
import time
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import lru_cache
from typing import Any, NamedTuple

import cv2
import ipywidgets
from IPython.display import HTML

from mkt.figures.captions import caption, label, marked
from mkt.figures.pictures import data_uri
from mkt.figures.registry import Entry, Shown
from mkt.figures.static_panel import encoded, width
from mkt.figures.tooltips import WORDS, title

LIVE_DPI, SHARP_DPI = 100, 160
KEPT = 64  # pictures of a panel, about 15 MB
QUICK = 0.5  # [s] of CPU for a drawing that may be made ahead
PAUSE = 0.01  # [s] before it begins, so that a waiting move comes first
TELL = 0.15  # [s] between two messages on how far a run over a sequence is
INTERRUPTED = "Interrupted: the picture is that of the settings before."
# JupyterLab has some moves answered by a second thread of the kernel, while the first
# one draws another.
_DRAWING = threading.Lock()


class Drawing(NamedTuple):
    """A picture as PNG, what it shows, and the CPU time [s] that both took."""

    picture: bytes
    shown: Shown
    cost: float


def picture(entry: Entry, parameters: Mapping[str, Any]) -> HTML:
    """A figure as a still picture, and its caption below."""
    fig, _ = entry.draw(SHARP_DPI, **parameters)
    address = data_uri("image/png", encoded(fig, ".png"))
    about = f'alt="{html.escape(entry.title)}" width="{width(entry)}"'
    image = f'<img src="{address}" {about} style="max-width: 100%">'
    return HTML(f"{image}<p>{caption(entry)}</p>")


class Panel(ipywidgets.VBox):
    """The live figure.

    What was drawn is kept.  Where drawing is quick, the next step the same way is drawn
    while the reader looks at this one.

    Parameters
    ----------
    entry : Entry
    fixed : dict
        Parameters that keep their value and lose their slider.

    Attributes
    ----------
    values : dict
        Every parameter as it stands.
    shown : Shown
        What the figure's function returned for them.
    """

    def __init__(self, entry: Entry, fixed: Mapping[str, Any]):
        self._entry = entry
        self._fixed = dict(fixed)
        free = [name for name in entry.sliders if name not in fixed]
        self._controls = {name: _control(entry, name) for name in free}
        self._image = ipywidgets.Image(
            format="png",
            width=width(entry),
            layout={"max_width": "100%", "object_fit": "contain"},
        )
        self._trouble = ipywidgets.HTML()
        self._progress = ipywidgets.FloatProgress(
            max=1.0, layout={"visibility": "hidden", "width": "24em"}
        )
        self._drawn = lru_cache(KEPT)(self._draw)
        self._show()  # a mistake in `fixed` ends the cell, as any mistake does
        words = ipywidgets.HTML(caption(entry))
        super().__init__([self._row(), self._image, self._trouble, words])
        self.add_class("mkt-drawn")
        self._listen(True)

    def _row(self) -> ipywidgets.HBox:
        reset = ipywidgets.Button(
            description="reset",
            tooltip="back to where the sliders began",
            layout={"width": "6em"},
        )
        reset.on_click(self.reset)
        parts = [*self._controls.values(), reset, self._progress]
        return ipywidgets.HBox(parts, layout={"flex_flow": "row wrap"})

    @property
    def values(self) -> dict[str, Any]:
        """The parameters as they stand, {name: value}."""
        moved = {name: _exact(one.value) for name, one in self._controls.items()}
        return self._entry.defaults | self._fixed | moved

    def reset(self, _button: Any = None) -> None:
        """Move every slider back to where it began, and show that at once."""
        self._listen(False)
        for name, control in self._controls.items():
            control.value = self._entry.defaults[name]
        self._listen(True)
        self._redraw()

    def _listen(self, on: bool) -> None:
        for control in self._controls.values():
            change = control.observe if on else control.unobserve
            change(self._redraw, names="value")

    def _redraw(self, change: Any = None) -> None:
        """Show what the sliders say now.

        One that is dragged never runs ahead of the drawing: the browser sends the
        newest value once the last one is answered.
        """
        try:
            self._show()
            self._trouble.value = ""
            if change and self._cost < QUICK:
                self._look_ahead(change)
        except KeyboardInterrupt:
            self._trouble.value = INTERRUPTED
        except Exception:
            text = html.escape(traceback.format_exc(limit=-3))
            style = "color: #b00020; white-space: pre-wrap"
            self._trouble.value = f'<pre style="{style}">{text}</pre>'

    def _show(self) -> None:
        with _DRAWING:
            drawing = self._drawn(tuple(self.values.items()))
            self._image.value, self.shown, self._cost = drawing

    def _draw(self, values: tuple[tuple[str, Any], ...]) -> Drawing:
        """Draw the figure; what takes long shows how far it is."""
        start = time.process_time()
        self._told = time.monotonic()
        try:
            with _no_garbage():
                fig, shown = self._entry.draw(LIVE_DPI, self._tell, **dict(values))
                png = encoded(fig, ".png", cv2.IMWRITE_PNG_COMPRESSION, 1)
            return Drawing(png, shown, time.process_time() - start)
        finally:
            self._progress.layout.visibility = "hidden"

    def _tell(self, done: int, length: int) -> None:
        if time.monotonic() > self._told + TELL:
            self._told = time.monotonic()
            self._progress.value = done / length
            self._progress.description = f"{done} of {length}"
            self._progress.layout.visibility = "visible"

    def _look_ahead(self, change: Any) -> None:
        name = next(n for n, one in self._controls.items() if one is change.owner)
        positions = self._entry.values(name)
        old, new = _exact(change.old), _exact(change.new)
        if old not in positions or new not in positions:
            return  # a number that was typed
        at = positions.index(new)
        beyond = 2 * at - positions.index(old)
        if abs(beyond - at) == 1 and 0 <= beyond < len(positions):
            values = self.values | {name: positions[beyond]}
            with suppress(RuntimeError):  # no event loop, so no reader either
                loop = asyncio.get_running_loop()
                loop.call_later(PAUSE, self._draw_ahead, values)

    def _draw_ahead(self, values: dict[str, Any]) -> None:
        # An error is reported only if this picture is asked for.
        with suppress(Exception), _DRAWING:
            self._drawn(tuple(values.items()))


def _exact(value: Any) -> Any:
    """A position of a slider without the noise of adding up steps."""
    return round(value, 10) if isinstance(value, float) else value


@contextmanager
def _no_garbage() -> Iterator[None]:
    """No garbage collection, which takes a tenth of the time among small objects."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def _control(entry: Entry, name: str) -> ipywidgets.Widget:
    """A list of what there is, or a slider beside which any number can be typed."""
    words = {
        "value": entry.defaults[name],
        "description": marked(title(name)),
        "description_allow_html": True,
        "tooltip": WORDS.get(name, name),
        "style": {"description_width": "9em"},
        "layout": {"width": "26em"},
    }
    values = entry.values(name)
    if isinstance(entry.sliders[name], list):
        options = [(label(value), value) for value in values]
        return ipywidgets.Dropdown(options=options, **words)
    low, high, step = entry.sliders[name]
    ends = {"min": low, "max": high, "step": step}
    if all(isinstance(value, int) for value in values):
        return ipywidgets.IntSlider(**ends, **words)
    return ipywidgets.FloatSlider(**ends, **words)
