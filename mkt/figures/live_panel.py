"""A live figure in JupyterLab that computes in the browser, as it does in the book.

`mkt.figures.explore` makes a `LivePanel`.  Explained in notebook 01.
"""

from pathlib import Path
from typing import Any

import anywidget
import traitlets

from mkt.figures.captions import caption, label
from mkt.figures.live import bundle, content
from mkt.figures.registry import Entry, Shown
from mkt.figures.static_panel import STYLE

THEME = Path(__file__).with_name("jupyterlab.css")


class LivePanel(anywidget.AnyWidget):
    """The live figure, computed by the modules of `mkt/live`.

    Parameters
    ----------
    entry : Entry
        A live one.

    Attributes
    ----------
    name, caption : str
        Of the figure; the caption as HTML.
    first : dict
        The data that it begins with, {name: content}; for others the browser asks.
    moved : dict
        Where its controls stand, once one was moved: numbers, and choices by their
        labels.
    """

    _esm = f"{bundle('widget')}export default widget_js;\n"
    _css = THEME.read_text("utf-8") + STYLE.read_text("utf-8")
    name = traitlets.Unicode().tag(sync=True)
    caption = traitlets.Unicode().tag(sync=True)
    first = traitlets.Dict().tag(sync=True)
    moved = traitlets.Dict().tag(sync=True)

    def __init__(self, entry: Entry):
        super().__init__(
            name=entry.name,
            caption=caption(entry, live=True),
            first={name: content(name) for name in entry.live},
        )
        self._entry = entry
        self.on_msg(self._asked)

    def _asked(self, _widget: Any, message: dict[str, str], _buffers: Any) -> None:
        name = message["name"]
        try:
            answer = {"data": content(name)}
        except BaseException as error:  # of an interrupt, too: the browser waits
            words = str(error) or "the kernel was interrupted"
            self.send({"name": name, "error": words})
            raise
        self.send({"name": name} | answer)

    @property
    def values(self) -> dict[str, Any]:
        """The figure's parameters as they stand, {name: value}."""
        values = dict(self._entry.defaults)
        for name in self._entry.sliders:
            if name in self.moved:
                values[name] = self._value(name, self.moved[name])
        return values

    def _value(self, name: str, told: Any) -> Any:
        """The value of a control in the browser, as the figure's function takes it."""
        positions = self._entry.sliders[name]
        if isinstance(told, str):
            return {label(each): each for each in positions}[told]
        # The browser moves some freely that Python offers as a list of numbers.
        whole = all(isinstance(number, int) for number in positions)
        return int(told) if whole else float(told)

    @property
    def shown(self) -> Shown:
        """What the figure's function returns for these values, drawn by Python."""
        return self._entry.draw(**self.values)[1]
