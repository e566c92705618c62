"""No module of a live figure holds what another has, or what nobody takes."""

import ast
import re

from mkt.figures.live import COMMENT, EXPORT, IMPORT, MODULES, imports, source
from mkt.files import PACKAGE

PATHS = (path.relative_to(MODULES) for path in MODULES.rglob("*.js"))
TEXTS = {name: source(name) for name in (it.with_suffix("").as_posix() for it in PATHS)}
TAKEN_BY_ANYWIDGET = {("widget", "initialize"), ("widget", "render")}
# What the method exports under names that Python has not, and why.
IN_OTHER_WORDS = {
    "combinedInit": "Combined.init",
    "combinedStep": "Combined.step",
    "filterInit": "ParticleFilter.init",
    "filterStep": "ParticleFilter.step",
    "ssdInit": "SSD.init",
    "ssdStep": "SSD.step",
    "refinedTrack": "track of a Combined, from what its filter found once",
    "approached": "close_loop, whose rows are those of a figure",
    "linspace": "numpy's",
    "rint": "numpy's",
    "total": "numpy's sum",
    "random": "numpy's default_rng",
    "replay": "numbers that numpy drew",
}
CONSTANT = re.compile(
    r"^(?:export )?const ((?:[A-Z_]+ =|\w+ = .*=>).*?;)", re.MULTILINE
)


def test_what_a_module_exports_is_taken_by_another():
    exported = {
        (module, name)
        for module, text in TEXTS.items()
        for _, name in EXPORT.findall(text)
    }
    taken = {
        (module, name)
        for taker in TEXTS
        for names, module in imports(taker)
        for name in re.findall(r"\w+", names)
    }
    assert exported == taken | TAKEN_BY_ANYWIDGET


def defined(tree):
    """Names of the functions, classes, fields and constants that a module defines."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.AnnAssign):
            yield ast.unparse(node.target)
    for node in tree.body:
        if isinstance(node, ast.Assign):
            yield from re.findall(r"\w+", " ".join(map(ast.unparse, node.targets)))


def bare(name):
    """A name as it is in every language: colorBins, ColorBins and color_bins."""
    return name.replace("_", "").lower()


def test_the_method_has_pythons_names():
    """After a new name in Python it has another one, which nobody would see."""
    trees = [ast.parse(path.read_bytes()) for path in PACKAGE.rglob("*.py")]
    pythons = {bare(name) for tree in trees for name in defined(tree)}
    method = [text for name, text in TEXTS.items() if name.startswith("method/")]
    exported = [name for text in method for _, name in EXPORT.findall(text)]
    assert {n for n in exported if bare(n) not in pythons} == {*IN_OTHER_WORDS}


def test_what_a_module_takes_it_needs():
    for text in TEXTS.values():
        code = COMMENT.sub("", IMPORT.sub("", text))
        for names, _ in IMPORT.findall(text):
            for name in re.findall(r"\w+", names):
                assert re.search(rf"\b{name}\b", code)


def test_no_constant_stands_in_two_modules():
    found = [line for text in TEXTS.values() for line in set(CONSTANT.findall(text))]
    assert sorted(found) == sorted(set(found))


def test_the_method_knows_no_page():
    method = [name for name in TEXTS if name.startswith("method/")]
    assert method
    for name in method:
        assert {module for _, module in imports(name)} <= {*method}
        assert not re.search(r"\b(document|window)\b", COMMENT.sub("", TEXTS[name]))
