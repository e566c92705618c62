"""Everything public is documented, and the examples in docstrings and README run."""

import ast
import doctest
import importlib
import inspect
import re
from copy import copy

import pytest
from docutils import nodes
from docutils.core import publish_doctree
from docutils.frontend import get_default_settings
from docutils.parsers.rst import Parser
from docutils.readers.standalone import Reader
from docutils.utils import Reporter
from sphinx.ext.napoleon import Config, NumpyDocstring

from mkt.course.book import pages
from tests.test_structure import FILES, PACKAGE

ROOT = PACKAGE.parent
MODULES = sorted(
    {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for path in FILES
    }
)
SECTIONS = {
    name: value for name, value in pages.SETTINGS.items() if name.startswith("napoleon")
}

# Made once: to describe all of docutils' options takes as long as a docstring does.
QUIET = get_default_settings(Reader, Parser)
QUIET.report_level, QUIET.halt_level = Reporter.SEVERE_LEVEL, 5


def public(body):
    """Functions, classes and their methods that no underscore hides."""
    for node in body:
        if isinstance(
            node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
        ) and not node.name.startswith("_"):
            yield node
            yield from public(node.body) if isinstance(node, ast.ClassDef) else ()


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_everything_public_says_what_it_is(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    assert ast.get_docstring(tree), f"{path.name} does not say what it is about"
    silent = [node.name for node in public(tree.body) if not ast.get_docstring(node)]
    assert not silent, f"{path.name}: {', '.join(silent)} without a docstring"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_no_sign_of_a_formula_is_taken_for_markup(path):
    """Such as |x| or s *= 2: between double backquotes Sphinx lets them be."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    troubles = {
        getattr(node, "name", path.stem): misread(ast.get_docstring(node) or "")
        for node in [tree, *public(tree.body)]
    }
    assert {name: found for name, found in troubles.items() if found} == {}


def misread(docstring):
    """What docutils takes for markup that is none, once the sections are rewritten."""
    text = str(NumpyDocstring(docstring, Config(**SECTIONS)))
    tree = publish_doctree(text, settings=copy(QUIET))
    return [node.astext() for node in tree.findall(nodes.problematic)]


def test_every_public_module_is_on_the_pages_of_the_library():
    assert {
        name for name in MODULES if not name.rpartition(".")[2].startswith("_")
    } <= set(pages.modules())


def with_examples():
    return [
        name
        for name in MODULES
        if name != "mkt.__main__"
        and ">>> " in inspect.getsource(importlib.import_module(name))
    ]


@pytest.mark.parametrize("name", with_examples())
def test_examples_in_docstrings_run(name):
    result = doctest.testmod(
        importlib.import_module(name),
        optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE,
    )
    assert result.attempted > 0 and result.failed == 0


def test_the_core_teaches_by_examples():
    assert {
        "mkt.regions",
        "mkt.kernels",
        "mkt.histograms",
        "mkt.particles",
        "mkt.evaluation",
    } <= set(with_examples())


def test_the_python_of_the_readme_runs():
    blocks = re.findall(
        r"^```python\n(.*?)^```",
        (ROOT / "README.md").read_text(encoding="utf-8"),
        re.M | re.S,
    )
    assert blocks
    for block in blocks:
        *lines, last = block.strip().splitlines()
        room = {}
        exec("\n".join(lines), room)
        distances = eval(last, room)
        # The true place is nearer than ten pixels to either side.
        assert distances.argmin() == 1 and 0 < distances[1] < 1
