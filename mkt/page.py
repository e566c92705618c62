"""A figure on a page without a kernel: a few positions of each slider, drawn beforehand, and a few lines of script.

Explained in notebook 01.
"""

import base64
import html
import itertools
import json

import cv2
import numpy as np

WIDTH = 80  # [px] on the screen for an inch of figure
PAGE_DPI = 140
POSITIONS = 9  # of each slider in the book
_serial = itertools.count(1)


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
                            width=width(self._entry), caption=caption(self._entry), script=_SCRIPT % (json.dumps(id), data))

    def _slider(self, name):
        values, start = _spread(self._entry.values(name), self.values[name]), self.values[name]
        frames = [0 if value == start else self._add(name, value) for value in values]
        return {"labels": [label(value) for value in values], "frames": frames, "start": values.index(start),
                "list": isinstance(self._entry.sliders[name], list)}

    def _add(self, name, value):
        self._frames.append(self._frame({name: value}))
        return len(self._frames) - 1

    def _frame(self, change):
        canvas, self._numbers = self._entry.draw(PAGE_DPI, **(self.values | change))
        return "data:image/webp;base64," + base64.b64encode(encoded(canvas, ".webp", cv2.IMWRITE_WEBP_QUALITY, 80)).decode()


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


def encoded(canvas, extension, *options):
    """The drawn Figure as bytes of an image file."""
    canvas.canvas.draw()
    pixels = np.asarray(canvas.canvas.buffer_rgba())
    return cv2.imencode(extension, cv2.cvtColor(pixels, cv2.COLOR_RGBA2BGR), options)[1].tobytes()


def width(entry):
    """Of a figure on the screen [px]."""
    return round(WIDTH * entry.size[0])


def caption(entry):
    """Title and caption as HTML."""
    return f"<b>{html.escape(entry.title)}</b> {html.escape(entry.caption)}"


def label(value):
    """A value as a slider shows it."""
    return f"{value:g}" if isinstance(value, float) else str(value)
