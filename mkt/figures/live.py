"""Figures that compute by themselves: the scripts of `mkt/live` as one, and their data.

The book's page and a cell of JupyterLab run the same modules.  A browser neither
imports modules nor starts workers from pages on a disk, so the modules are joined into
one plain script, each a function, in the order of their imports.  The worker is a
second script, whose text the first puts together from the texts of these functions.

What a figure computes from comes under a name from `content`: the positions of its
sliders, and what its paper's modules register in `DATA`.
"""

import re
from typing import Any

from mkt.figures.captions import label
from mkt.figures.registry import FIGURES, Entry
from mkt.figures.tooltips import WORDS, title
from mkt.files import PACKAGE
from mkt.registry import Registry

MODULES = PACKAGE / "live"
COMMENT = re.compile(r"^ *//.*\n|(?<=[;,]) //.*$", re.MULTILINE)  # also behind code
INDENTATION = re.compile(r"^ +", re.MULTILINE)
IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./(\w+)\.js";', re.MULTILINE)
EXPORT = re.compile(
    r"^export ((?:async )?(?:const|function|class) (\w+))", re.MULTILINE
)

# {name: function that makes it, as JSON can hold it}
DATA = Registry("data of a live figure", "mkt.papers")


def bundle(start: str) -> str:
    """A module and all that it imports as one text, where the module is START_js.

    WORKER in it is the text of the worker, put together from the same functions.
    """
    page, worker = needed(start), needed("worker")
    made = "".join(maker(name) for name in dict.fromkeys([*page, *worker]))
    makers = ", ".join(f"{name}_make" for name in worker)
    text = (
        "const WORKER = ['\"use strict\";', "
        f"...Object.entries({{ {makers} }}).map(([name, make]) => "
        "`const ${name.replace('_make', '_js')} = (${make})();`)].join('\\n');\n"
    )
    return made + text + calls(page)


def joined(start: str) -> str:
    """A module and all that it imports as one text, without a worker."""
    modules = needed(start)
    return "".join(maker(name) for name in modules) + calls(modules)


def needed(name: str) -> list[str]:
    """The modules that one imports, directly or not, each before its importers."""
    imported = [other for _, other in IMPORT.findall(_source(name))]
    before = [module for other in imported for module in needed(other)]
    return list(dict.fromkeys([*before, name]))


def maker(name: str) -> str:
    """A module as the function NAME_make, which returns what the module exports."""
    text = _source(name)
    exported = ", ".join(found for _, found in EXPORT.findall(text))
    # A third of what a reader would load, and a tenth of the rest.
    text = INDENTATION.sub("", COMMENT.sub("", text))
    text = EXPORT.sub(r"\1", IMPORT.sub(r"const \1 = \2_js;", text))
    return f"const {name}_make = () => {{\n{text}\nreturn {{ {exported} }};\n}};\n"


def calls(modules: list[str]) -> str:
    """The modules' exports, each as NAME_js."""
    return "".join(f"const {name}_js = {name}_make();\n" for name in modules)


def _source(name: str) -> str:
    return (MODULES / f"{name}.js").read_text(encoding="utf-8")


def names() -> list[str]:
    """The names of all data, those of figures first."""
    live = [name for name, entry in FIGURES.items() if entry.live]
    return list(dict.fromkeys([*live, *DATA]))


def content(name: str) -> dict[str, Any]:
    """What the modules of `mkt/live` load under a name.

    Raises
    ------
    ValueError
        For an unknown name, with the known ones.
    """
    if name not in FIGURES or not FIGURES[name].live:
        return DATA[name]()
    sliders = {"fields": fields(FIGURES[name])}
    return sliders | DATA[name]() if name in DATA else sliders


def fields(entry: Entry) -> dict[str, dict[str, Any]]:
    """What the controls of a live figure need to know of its sliders."""
    return {
        slider: _field(positions, entry.defaults[slider])
        | {"title": title(slider), "words": WORDS.get(slider, slider)}
        for slider, positions in entry.sliders.items()
    }


def _field(positions: Any, value: Any) -> dict[str, Any]:
    if isinstance(positions, list):
        return {"options": [label(each) for each in positions], "value": label(value)}
    low, high, step = positions
    return {"low": low, "high": high, "step": step, "value": value}
