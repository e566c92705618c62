"""A figure on a page without a kernel: some positions of its sliders, drawn beforehand.

Most sliders move one at a time.  Two that a figure's decorator names as its ``grid``
move together: all pairs of their positions are drawn.  The page is static_panel.html
with the pictures as data; static_panel.js, which the book loads once, moves the
sliders.  Of a live figure, which the page computes by itself, only the picture with the
default values is drawn: it is shown until the page is ready.

Explained in notebook 01.
"""

import itertools
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import jinja2
import numpy as np
from matplotlib.figure import Figure

from mkt.figures.captions import caption, label, marked
from mkt.figures.pictures import data_uri, image_file
from mkt.figures.registry import Entry, Shown
from mkt.figures.tooltips import title
from mkt.plotting import in_style

WIDTH = 80  # [px] on the screen for an inch of figure
PAGE_DPI = 100
# Speed 8 would make pictures a quarter smaller, those of lines 30 %, and take four
# times as long, a fifteenth of all CPU time of the book.
AVIF = cv2.IMWRITE_AVIF_QUALITY, 50, cv2.IMWRITE_AVIF_SPEED, 9
POSITIONS, IN_A_GRID = 9, 5  # of a slider, at most
# Of the site: NAME.avif, NAME.pdf and NAME.csv of each figure with its defaults.
FILES = "_static/figures"
SCRIPT = Path(__file__).with_suffix(".js")
STYLE = Path(__file__).with_name("panel.css")
_TEMPLATES = jinja2.Environment(
    loader=jinja2.FileSystemLoader(Path(__file__).parent),
    autoescape=True,
    trim_blocks=True,
    lstrip_blocks=True,
)
_serial = itertools.count(1)


class StaticPanel:
    """The figure in the book.

    Sliders that do not move together with the one that is moved go back to where they
    began.

    Parameters
    ----------
    entry : Entry
    fixed : dict
        Parameters that keep their value and lose their slider.

    Attributes
    ----------
    values : dict
        Every parameter with its value.
    shown : Shown
        What the figure's function returned for them.
    """

    def __init__(self, entry: Entry, fixed: Mapping[str, Any]):
        self._entry = entry
        self.values = entry.defaults | dict(fixed)
        self._frames: list[str] = []
        self._drawn: dict[tuple, int] = {}
        self.shown = self._draw(self.values)
        self._live = bool(entry.live) and not fixed
        free = [] if self._live else groups(entry, fixed)
        self._positions = self._chosen(free)
        self._groups = [
            {"names": names, "frames": self._frames_of(names)} for names in free
        ]

    def _chosen(self, groups: list[tuple[str, ...]]) -> dict[str, list[Any]]:
        """The positions of each slider that are drawn."""
        return {
            name: spread(
                self._entry.values(name),
                self.values[name],
                POSITIONS if len(names) == 1 else IN_A_GRID,
            )
            for names in groups
            for name in names
        }

    def _frames_of(self, names: tuple[str, ...]) -> list[int]:
        """The pictures of all positions of some sliders that move together."""
        positions = [self._positions[name] for name in names]
        changes = itertools.product(*positions)
        return [self._frame(dict(zip(names, c, strict=True))) for c in changes]

    def _frame(self, change: dict[str, Any]) -> int:
        """The number of the picture that shows a change; each is drawn once."""
        values = self.values | change
        if tuple(values.values()) not in self._drawn:
            self._draw(values)
        return self._drawn[tuple(values.values())]

    def _draw(self, values: dict[str, Any]) -> Shown:
        fig, shown = self._entry.draw(PAGE_DPI, **values)
        picture = encoded(fig, ".avif", *AVIF)
        self._drawn[tuple(values.values())] = len(self._frames)
        self._frames.append(data_uri("image/avif", picture))
        return shown

    def _repr_html_(self) -> str:
        entry = self._entry
        return _TEMPLATES.get_template("static_panel.html").render(
            id=f"{entry.name.replace('.', '-')}-{next(_serial)}",
            entry=entry,
            caption=caption(entry),
            computed=caption(entry, live=True),
            files=FILES,
            width=width(entry),
            image=self._frames[0],
            alt=self._description(),
            held=self._held(),
            live=self._live,
            groups=[self._controls(group["names"]) for group in self._groups],
            data=self._data(),
        )

    def _held(self) -> str:
        """The parameters whose values on this page are not the default ones."""
        return ", ".join(
            f"{title(name)} = {label(value)}"
            for name, value in self.values.items()
            if value != self._entry.defaults[name]
        )

    def _description(self) -> str:
        """What the picture shows: its title with the values."""
        labels = self._labels().items()
        words = ", ".join(f"{title(name)} = {value}" for name, value in labels)
        return f"{self._entry.title} {words}." if words else self._entry.title

    def _labels(self) -> dict[str, str]:
        return {
            name: label(value) for name, value in self.values.items() if value != ""
        }

    def _controls(self, names: tuple[str, ...]) -> list[dict[str, Any]]:
        """What the template needs to know of some sliders that move together."""
        return [
            {
                "name": name,
                "title": title(name),
                "labels": [label(value) for value in positions],
                "start": positions.index(self.values[name]),
                "choice": not is_ordered(positions),
            }
            for name, positions in ((name, self._positions[name]) for name in names)
        ]

    def _data(self) -> str:
        """What the script needs, as JSON that cannot end the element it stands in."""
        sliders = {
            c["name"]: c for g in self._groups for c in self._controls(g["names"])
        }
        data = {
            "file": self._entry.name,
            "title": self._entry.title,
            "live": self._live,
            "shown": self._labels(),
            "titles": {name: title(name) for name in self._labels()},
            "marked": {name: marked(title(name)) for name in sliders},
            "sliders": sliders,
            "groups": self._groups,
            # The first one is the picture that stands there.
            "frames": [None, *self._frames[1:]],
        }
        return json.dumps(data).replace("<", "\\u003c")


def groups(entry: Entry, fixed: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """The sliders that are free: those of the grid together, each other for itself."""
    free = [name for name in entry.sliders if name not in fixed]
    if entry.grid and set(entry.grid) <= set(free):
        return [entry.grid, *((name,) for name in free if name not in entry.grid)]
    return [(name,) for name in free]


def spread(values: list[Any], default: Any, most: int) -> list[Any]:
    """At most so many of the values, evenly spread.

    The first, the last and the default are among them.
    """
    last = len(values) - 1
    at = values.index(default)
    if last < most:
        return values
    chosen = {round(i * last / (most - 1)) for i in range(most)}
    nearest = min(chosen - ({0, last} - {at}), key=lambda i: abs(i - at))
    return [values[i] for i in sorted(chosen - {nearest} | {at})]


def is_ordered(values: list[Any]) -> bool:
    """Whether values are numbers in order, along which a slider moves."""
    return (
        not any(isinstance(v, str | bool) for v in values) and sorted(values) == values
    )


def encoded(fig: Figure, ending: str, *options: int) -> bytes:
    """The drawn figure as an image file."""
    with in_style():
        fig.canvas.draw()
    pixels = np.asarray(fig.canvas.buffer_rgba())  # type: ignore[attr-defined]
    return image_file(pixels[..., :3], ending, *options)


def width(entry: Entry) -> int:
    """The width of a figure on the screen [px]."""
    return round(WIDTH * entry.size[0])


_TEMPLATES.filters["marked"] = marked
