"""Figures that compute by themselves: the scripts of `mkt/live` as one, and their data.

The book's page and a cell of JupyterLab run the same modules.  A browser neither
imports modules nor starts workers from pages on a disk, so the modules are joined into
one plain script, in the order of their imports, and the worker is a second one, whose
text the first carries.

What a figure computes from comes under a name from `content`: the positions of its
sliders, and what its paper's modules register in `DATA`.
"""

import json
import re
from typing import Any

from mkt.figures.registry import FIGURES, Entry
from mkt.figures.static_panel import label
from mkt.figures.tooltips import WORDS
from mkt.files import PACKAGE
from mkt.registry import Registry

MODULES = PACKAGE / "live"
COMMENT = re.compile(r"^ *//.*\n", re.MULTILINE)
IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./(\w+)\.js";', re.MULTILINE)
EXPORT = re.compile(
    r"^export ((?:async )?(?:const|function|class) (\w+))", re.MULTILINE
)

# {name: function that makes it, as JSON can hold it}
DATA = Registry("data of a live figure", "mkt.papers")


def bundle(start: str) -> str:
    """A module and all that it imports as one text, where the module is START_js.

    The text of the worker is in it as WORKER.
    """
    worker = json.dumps(f'"use strict";\n{joined("worker")}')
    return f"const WORKER = {worker};\n{joined(start)}"


def joined(name: str, known: set[str] | None = None) -> str:
    """A module after all that it imports, each a function that returns its exports."""
    known = set() if known is None else known
    known.add(name)
    text = (MODULES / f"{name}.js").read_text(encoding="utf-8")
    needed = [other for _, other in IMPORT.findall(text) if other not in known]
    before = "".join(joined(other, known) for other in needed if other not in known)
    exported = ", ".join(found for _, found in EXPORT.findall(text))
    text = COMMENT.sub("", text)  # a third of what a reader would load
    text = EXPORT.sub(r"\1", IMPORT.sub(r"const \1 = \2_js;", text))
    body = f"{text}\nreturn {{ {exported} }};"
    return f"{before}const {name}_js = (() => {{\n{body}\n}})();\n"


def names() -> list[str]:
    """The names of all data, those first that have a figure's name."""
    return list(dict.fromkeys([*_of_figures(), *DATA]))


def content(name: str) -> dict[str, Any]:
    """What the modules of `mkt/live` load under a name.

    Raises
    ------
    ValueError
        For an unknown name, with the known ones.
    """
    entry = _of_figures().get(name)
    if entry is None:
        return DATA[name]()
    sliders = {"fields": fields(entry)}
    return sliders | DATA[name]() if name in DATA else sliders


def _of_figures() -> dict[str, Entry]:
    """The live figures by their names without the paper's."""
    live = [entry for entry in FIGURES.values() if entry.live]
    return {entry.name.split(".")[1]: entry for entry in live}


def fields(entry: Entry) -> dict[str, dict[str, Any]]:
    """What the controls of a live figure need to know of its sliders."""
    return {
        slider: _field(positions, entry.defaults[slider])
        | {"words": WORDS.get(slider, slider)}
        for slider, positions in entry.sliders.items()
    }


def _field(positions: Any, value: Any) -> dict[str, Any]:
    if isinstance(positions, list):
        return {"options": [label(each) for each in positions], "value": label(value)}
    low, high, step = positions
    return {"low": low, "high": high, "step": step, "value": value}
