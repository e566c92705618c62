"""Figures in notebooks: `show` draws one, `explore` gives it its sliders.

In JupyterLab `explore` is a `Panel`: every slider position is drawn afresh by the running kernel.  In the book there is no kernel, so
with ``MKT_STATIC=1`` in the environment it is a `Page`: a few positions of each slider, drawn beforehand, and a few lines of script.
Both have ``values``, the parameters as they stand, so that a later cell reads the same in either.

Explained in notebook 01.
"""

import base64
import html
import itertools
import json
import os
import traceback

import cv2
import ipywidgets
import numpy as np
from IPython.display import Image

from mkt import figures

WIDTH = 80  # [px] on the screen for an inch of figure
LIVE_DPI, PAGE_DPI, SHARP_DPI = 100, 140, 160
POSITIONS = 9  # of each slider in the book
_serial = itertools.count(1)


def show(id, **parameters):
    """Draw a registered figure with its defaults, but for `parameters`.

    Returns an `IPython.display.Image` with the caption as its alternative text.  Raises KeyError for an unknown figure and ValueError
    for an unknown parameter, both listing the known ones.
    """
    entry = figures.get(id)
    canvas, _ = entry.draw(SHARP_DPI, **parameters)
    return Image(_encode(canvas, ".png"), format="png", width=_width(entry), alt=f"{entry.title} {entry.caption}".replace("\n", " "))


def explore(id, **fixed):
    """A registered figure with its sliders; parameters named in `fixed` keep their value and lose their slider.

    Returns a `Panel`, or a `Page` where MKT_STATIC=1.  Raises KeyError for an unknown figure and ValueError for an unknown parameter.
    """
    return (Page if os.environ.get("MKT_STATIC") == "1" else Panel)(figures.get(id), fixed)


class Panel(ipywidgets.VBox):
    """The live figure: sliders, and one image that every move draws afresh.

    values: {name: value} of every parameter; numbers: what the figure's function returned for them.
    """

    def __init__(self, entry, fixed):
        self._entry, self._fixed = entry, fixed
        self._controls = {name: _control(entry, name) for name in entry.sliders if name not in fixed}
        self._image = ipywidgets.Image(format="png", width=_width(entry), layout={"max_width": "100%", "object_fit": "contain"})
        self._trouble = ipywidgets.HTML()
        reset = ipywidgets.Button(description="reset", tooltip="back to where the sliders began", layout={"width": "6em"})
        row = ipywidgets.HBox([*self._controls.values(), reset], layout={"flex_flow": "row wrap"})
        self._draw()  # a mistake in `fixed` ends the cell, as any mistake does
        super().__init__([row, self._image, self._trouble, ipywidgets.HTML(_caption(entry))])
        self._listen(True)
        reset.on_click(self.reset)

    @property
    def values(self):
        """The parameters as they stand, {name: value}."""
        return self._entry.defaults | self._fixed | {name: control.value for name, control in self._controls.items()}

    def reset(self, _button=None):
        """Move every slider back to where it began, drawing once."""
        self._listen(False)
        for name, control in self._controls.items():
            control.value = self._entry.defaults[name]
        self._listen(True)
        self._redraw()

    def _listen(self, on):
        for control in self._controls.values():
            (control.observe if on else control.unobserve)(self._redraw, names="value")

    # A slider that is dragged never runs ahead of the drawing: the browser sends the newest value once the last one is answered.
    def _redraw(self, _change=None):
        try:
            self._draw()
            self._trouble.value = ""
        except Exception:
            self._trouble.value = f'<pre style="color: #b00020; white-space: pre-wrap">{html.escape(traceback.format_exc(limit=-3))}</pre>'

    def _draw(self):
        canvas, self.numbers = self._entry.draw(LIVE_DPI, **self.values)
        self._image.value = _encode(canvas, ".png", cv2.IMWRITE_PNG_COMPRESSION, 1)


def _control(entry, name):
    options = [(_label(value), value) for value in entry.values(name)]
    kind = ipywidgets.Dropdown if isinstance(entry.sliders[name], list) else ipywidgets.SelectionSlider
    return kind(options=options, value=entry.defaults[name], description=name, style={"description_width": "5.5em"}, layout={"width": "24em"})


class Page:
    """The figure in the book: up to `POSITIONS` positions of each slider, the other parameters at their defaults.

    values: {name: value} of every parameter; numbers: what the figure's function returned for them.
    """

    def __init__(self, entry, fixed):
        self._entry = entry
        self.values = entry.defaults | fixed
        self._frames = [self._frame({})]
        self.numbers = self._numbers
        self._sliders = {name: self._slider(name) for name in entry.sliders if name not in fixed}

    def _repr_html_(self):
        id = f"{self._entry.id.replace('.', '-')}-{next(_serial)}"
        controls = "".join(_html_control(f"{id}-{name}", name, slider) for name, slider in self._sliders.items())
        data = json.dumps({"frames": self._frames, "sliders": self._sliders}).replace("</", "<\\/")
        return _PAGE.format(id=id, controls=controls, image=self._frames[0], alt=html.escape(self._entry.title, quote=True),
                            width=_width(self._entry), caption=_caption(self._entry), script=_SCRIPT % (json.dumps(id), data))

    def _slider(self, name):
        values, start = _spread(self._entry.values(name), self.values[name]), self.values[name]
        frames = [0 if value == start else self._add(name, value) for value in values]
        return {"labels": [_label(value) for value in values], "frames": frames, "start": values.index(start),
                "list": isinstance(self._entry.sliders[name], list)}

    def _add(self, name, value):
        self._frames.append(self._frame({name: value}))
        return len(self._frames) - 1

    def _frame(self, change):
        canvas, self._numbers = self._entry.draw(PAGE_DPI, **(self.values | change))
        return "data:image/webp;base64," + base64.b64encode(_encode(canvas, ".webp", cv2.IMWRITE_WEBP_QUALITY, 80)).decode()


def _spread(values, default):
    """At most `POSITIONS` of the values, evenly spread, with the first, the last and the default among them."""
    last, at = len(values) - 1, values.index(default)
    if last < POSITIONS:
        return values
    chosen = {round(i * last / (POSITIONS - 1)) for i in range(POSITIONS)}
    nearest = min(chosen - ({0, last} - {at}), key=lambda i: abs(i - at))
    return [values[i] for i in sorted(chosen - {nearest} | {at})]


def _html_control(id, name, slider):
    """A labelled <select> or range input; its value is the position in the slider's lists."""
    common = f'id="{id}" data-name="{name}"'
    if slider["list"]:
        options = "".join(f'<option value="{i}"{" selected" * (i == slider["start"])}>{html.escape(text)}</option>'
                          for i, text in enumerate(slider["labels"]))
        field = f"<select {common}>{options}</select>"
    else:
        start, last = slider["start"], len(slider["labels"]) - 1
        field = f'<input type="range" {common} min="0" max="{last}" step="1" value="{start}"><output>{slider["labels"][start]}</output>'
    return f'<span class="mkt-control"><label for="{id}">{name}</label>{field}</span>'


_PAGE = """<figure class="mkt-panel" id="{id}">
<div class="mkt-controls">{controls}<button type="button">reset</button></div>
<img src="{image}" alt="{alt}" width="{width}">
<p class="mkt-note" aria-live="polite">Every slider stands where it began.</p>
<figcaption>{caption}</figcaption>
<script>{script}</script>
</figure>"""

_SCRIPT = """(() => {
  const panel = document.getElementById(%s), data = %s;
  const image = panel.querySelector("img"), note = panel.querySelector(".mkt-note"), controls = [...panel.querySelectorAll("[data-name]")];
  const put = (control, position) => {
    const label = data.sliders[control.dataset.name].labels[position];
    control.value = position;
    if (control.type === "range") { control.nextElementSibling.value = label; control.setAttribute("aria-valuetext", label); }
    return label;
  };
  const show = (changed) => {
    const position = changed ? +changed.value : 0;
    for (const control of controls) if (control !== changed) put(control, data.sliders[control.dataset.name].start);
    image.src = data.frames[changed ? data.sliders[changed.dataset.name].frames[position] : 0];
    note.textContent = changed
      ? `${changed.dataset.name} = ${put(changed, position)}; the others are back where they began. In JupyterLab they move together.`
      : "Every slider stands where it began.";
  };
  for (const control of controls) control.addEventListener("input", () => show(control));
  panel.querySelector("button").addEventListener("click", () => show());
  show();
})();"""


def _encode(canvas, extension, *options):
    """The drawn Figure as bytes of an image file."""
    canvas.canvas.draw()
    pixels = np.asarray(canvas.canvas.buffer_rgba())
    return cv2.imencode(extension, cv2.cvtColor(pixels, cv2.COLOR_RGBA2BGR), options)[1].tobytes()


def _width(entry):
    return round(WIDTH * entry.size[0])


def _caption(entry):
    return f"<b>{html.escape(entry.title)}</b> {html.escape(entry.caption)}"


def _label(value):
    return f"{value:g}" if isinstance(value, float) else str(value)
