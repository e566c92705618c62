"""A figure on a page without a kernel: a few positions of each slider, drawn beforehand, and a few lines of script.

Most sliders move one at a time.  Two that a figure's decorator names as its ``grid`` move together: all pairs of their positions are drawn.

Explained in notebook 01.
"""

import base64
import html
import itertools
import json

import cv2
import numpy as np

WIDTH = 80  # [px] on the screen for an inch of figure
PAGE_DPI, QUALITY = 100, 52
POSITIONS, IN_A_GRID = 9, 5  # of a slider, at most
FILES = "_static/figures"  # of the site: ID.webp, ID.pdf and ID.csv of each figure with its defaults
_serial = itertools.count(1)


class Page:
    """The figure in the book.  Sliders that do not move together with the one that is moved go back to where they began.

    values: {name: value} of every parameter; numbers: what the figure's function returned for them.
    """

    def __init__(self, entry, fixed):
        self._entry, self.values = entry, entry.defaults | fixed
        self._frames, self._drawn = [], {}
        self.numbers = self._draw({})
        groups = _groups(entry, fixed)
        positions = {name: _spread(entry.values(name), self.values[name], POSITIONS if len(group) == 1 else IN_A_GRID) for group in groups for name in group}
        self._sliders = {name: {"labels": [label(value) for value in values], "start": values.index(self.values[name])} for name, values in positions.items()}
        self._groups = [{"names": group, "frames": [self._frame(dict(zip(group, change))) for change in itertools.product(*map(positions.get, group))]}
                        for group in groups]

    def _repr_html_(self):
        entry, id = self._entry, f"{self._entry.id.replace('.', '-')}-{next(_serial)}"
        shown = {name: label(value) for name, value in self.values.items() if value != ""}
        data = {"file": entry.id, "title": entry.title, "shown": shown, "sliders": self._sliders, "groups": self._groups, "frames": self._frames}
        return _PAGE.format(id=id, controls=self._html_controls(id) if self._groups else "", image=self._frames[0], width=width(entry),
                            alt=html.escape(self._description(shown), quote=True), files=FILES, figure=entry.id,
                            caption=f"<figcaption>{caption(entry)}</figcaption>\n" if self._groups else "",
                            script=_SCRIPT % (json.dumps(id), json.dumps(data).replace("</", "<\\/")))

    def _description(self, shown):
        """What the picture shows: its title with the values, or where nothing moves the whole caption, which then is not beside it."""
        text = ", ".join(f"{name} = {value}" for name, value in shown.items()) + "." if self._groups else self._entry.caption.replace("\n", " ")
        return f"{self._entry.title} {text}"

    def _html_controls(self, id):
        text = ""
        for names in (group["names"] for group in self._groups):
            fields = "".join(_html_control(f"{id}-{name}", name, self._sliders[name], isinstance(self._entry.sliders[name], list)) for name in names)
            text += _GRID.format(fields=fields) if len(names) > 1 else fields
        return _CONTROLS.format(controls=text)

    def _frame(self, change):
        """The number of the frame that shows a change of the values; each is drawn once."""
        key = tuple((self.values | change).values())
        if key not in self._drawn:
            self._draw(change)
        return self._drawn[key]

    def _draw(self, change):
        values = self.values | change
        canvas, numbers = self._entry.draw(PAGE_DPI, **values)
        self._drawn[tuple(values.values())] = len(self._frames)
        image = base64.b64encode(encoded(canvas, ".webp", cv2.IMWRITE_WEBP_QUALITY, QUALITY)).decode()
        self._frames.append(f"data:image/webp;base64,{image}")
        return numbers


def _groups(entry, fixed):
    """The sliders that are free, as tuples of names: those of the grid in one, each of the others in its own."""
    free = [name for name in entry.sliders if name not in fixed]
    grid = entry.grid if set(entry.grid) <= set(free) else ()
    return [grid] * bool(grid) + [(name,) for name in free if name not in grid]


def _spread(values, default, most):
    """At most so many of the values, evenly spread, with the first, the last and the default among them."""
    last, at = len(values) - 1, values.index(default)
    if last < most:
        return values
    chosen = {round(i * last / (most - 1)) for i in range(most)}
    nearest = min(chosen - ({0, last} - {at}), key=lambda i: abs(i - at))
    return [values[i] for i in sorted(chosen - {nearest} | {at})]


def _html_control(id, name, slider, choice):
    """A labelled <select> or range input; its value is the position in the slider's labels."""
    common, labels, start = f'id="{id}" data-name="{name}"', slider["labels"], slider["start"]
    if choice:
        options = "".join(f'<option value="{i}"{" selected" * (i == start)}>{html.escape(text)}</option>' for i, text in enumerate(labels))
        field = f"<select {common}>{options}</select>"
    else:
        field = (f'<input type="range" {common} min="0" max="{len(labels) - 1}" step="1" value="{start}" aria-valuetext="{labels[start]}">'
                 f'<output for="{id}">{labels[start]}</output>')
    return f'<span class="mkt-control"><label for="{id}">{name}</label>{field}</span>'


_PAGE = """<figure class="mkt-panel" id="{id}">
{controls}<div class="mkt-shown" tabindex="0"><img src="{image}" alt="{alt}" width="{width}"></div>
<p class="mkt-note mkt-files">Save: <button type="button" class="mkt-save">PNG of what is shown</button>
<a href="{files}/{figure}.pdf" download>PDF</a> and <a href="{files}/{figure}.csv" download>CSV of its numbers</a> with the default values</p>
{caption}<script>{script}</script>
</figure>"""

_GRID = '<span class="mkt-grid" role="group" aria-label="two that move together">{fields}</span>'

_CONTROLS = """<div class="mkt-controls">{controls}<button type="button" class="mkt-reset">reset</button></div>
<p class="mkt-note" role="status">Every slider stands where it began.</p>
"""

_SCRIPT = """(() => {
  const panel = document.getElementById(%s), data = %s, shown = {...data.shown};
  const image = panel.querySelector("img"), note = panel.querySelector("[role=status]"), controls = [...panel.querySelectorAll("[data-name]")];
  const said = (names) => names.map((name) => `${name} = ${shown[name]}`).join(", ");
  const put = (control, position) => {
    const name = control.dataset.name, label = shown[name] = data.sliders[name].labels[position];
    control.value = position;
    if (control.type === "range") { control.nextElementSibling.value = label; control.setAttribute("aria-valuetext", label); }
  };
  const show = (moved) => {
    const group = moved ? data.groups.find(({names}) => names.includes(moved.dataset.name)) : {names: [], frames: [0]};
    const [together, others] = [true, false].map((inside) => controls.filter(({dataset}) => group.names.includes(dataset.name) === inside));
    for (const control of others) put(control, data.sliders[control.dataset.name].start);
    for (const control of together) put(control, +control.value);
    const place = group.names.reduce((at, name) => at * data.sliders[name].labels.length + +controls.find(({dataset}) => dataset.name === name).value, 0);
    image.src = data.frames[group.frames[place]];
    if (controls.length) image.alt = `${data.title} ${said(Object.keys(shown))}.`;
    if (note) note.textContent = !moved ? "Every slider stands where it began."
      : said(group.names) + (others.length ? "; the others are back where they began. In JupyterLab all move together." : ".");
  };
  const save = () => {
    const canvas = document.createElement("canvas"), link = document.createElement("a");
    [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
    canvas.getContext("2d").drawImage(image, 0, 0);
    link.href = canvas.toDataURL("image/png");
    link.download = [data.file, ...Object.keys(data.shown).filter((name) => shown[name] !== data.shown[name]).map((name) => `${name}=${shown[name]}`)].join(" ") + ".png";
    link.click();
  };
  for (const control of controls) control.addEventListener("input", () => show(control));
  panel.querySelector(".mkt-reset")?.addEventListener("click", () => show());
  panel.querySelector(".mkt-save").addEventListener("click", save);
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
