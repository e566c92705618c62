"""Figures that compute by themselves: the scripts of `mkt/live` as one, and their data.

Those in `mkt/live/method` are the method in the reader's browser: what mkt's Python
computes, each file after the modules that its head names, and no page is known there.
Python is the reference; tests/live holds both to the same numbers.  Every function is
pure but for the random numbers that it is handed.  All others are figures, and what
these share.

The book's page and a cell of JupyterLab run the same modules.  A browser neither
imports modules nor starts workers from pages on a disk, so the modules are joined into
one plain script, each a function, in the order of their imports.  The worker is a
second script, whose text the first puts together from the texts of these functions.

What a figure computes from comes under a name from `content`: the positions of its
sliders, and what its paper's modules register in `DATA`.
"""

import posixpath
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
IMPORT = re.compile(r'^import (\{[^}]*\}) from "(\.[./\w]+)\.js";', re.MULTILINE)
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
    makers = ", ".join(f"{_word(name)}_make" for name in worker)
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
    before = [module for _, other in imports(name) for module in needed(other)]
    return list(dict.fromkeys([*before, name]))


def imports(name: str) -> list[tuple[str, str]]:
    """What a module takes from others: names in braces, and the other's name."""
    found = IMPORT.findall(source(name))
    return [(words, _beside(name, path)) for words, path in found]


def _beside(name: str, path: str) -> str:
    """The module at a path that is seen from another one."""
    return posixpath.normpath(posixpath.join(posixpath.dirname(name), path))


def maker(name: str) -> str:
    """A module as the function NAME_make, which returns what the module exports.

    In NAME an underscore takes the place of a slash.
    """
    text = source(name)
    exported = ", ".join(found for _, found in EXPORT.findall(text))
    # A third of what a reader would load, and a tenth of the rest.
    text = INDENTATION.sub("", COMMENT.sub("", text))
    text = EXPORT.sub(r"\1", IMPORT.sub(lambda found: _taken(name, found), text))
    made = f"return {{ {exported} }};"
    return f"const {_word(name)}_make = () => {{\n{text}\n{made}\n}};\n"


def _taken(name: str, found: re.Match[str]) -> str:
    """What stands in the place of an import."""
    words, path = found.groups()
    return f"const {words} = {_word(_beside(name, path))}_js;"


def _word(name: str) -> str:
    return name.replace("/", "_")


def calls(modules: list[str]) -> str:
    """The modules' exports, each as NAME_js."""
    words = map(_word, modules)
    return "".join(f"const {word}_js = {word}_make();\n" for word in words)


def source(name: str) -> str:
    """The text of a module, such as "page" or "method/regions"."""
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
