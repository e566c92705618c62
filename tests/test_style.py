"""How the code is written: ruff and basedpyright find nothing, no function is long."""

import ast
import re
import statistics
import subprocess
import sysconfig
from pathlib import Path

import pytest

from mkt.files import PACKAGE, ROOT

SCRIPTS = Path(sysconfig.get_path("scripts"))
LONGEST, USUAL = 45, 8  # lines of a function's body: at most, and in the median
TENTH = 25  # lines that one body in ten may exceed
COLUMNS = 88
PYRIGHT = "basedpyright"  # takes half a minute
CHECKS = {
    "ruff check": ["ruff", "check", "--no-cache", "mkt", "tests", "notebooks"],
    "ruff format": ["ruff", "format", "--no-cache", "--check", "."],
    PYRIGHT: ["basedpyright", "--warnings"],
}


@pytest.mark.parametrize(
    "words",
    [
        pytest.param(words, id=name, marks=[pytest.mark.slow] * (name == PYRIGHT))
        for name, words in CHECKS.items()
    ],
)
def test_the_tools_find_nothing(words):
    program, *rest = words
    done = subprocess.run(
        [SCRIPTS / program, *rest],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("kind", ["js", "css", "html"])
def test_what_the_tools_do_not_read_has_short_lines_too(kind):
    files = list(PACKAGE.rglob(f"*.{kind}"))
    assert files
    for path in files:
        lines = path.read_text(encoding="utf-8").splitlines()
        long = [n for n, line in enumerate(lines, 1) if len(line) > COLUMNS]
        assert not long, f"{path.name}:{long[0]}"


@pytest.mark.parametrize("path", sorted(ROOT.glob("*.md")), ids=lambda path: path.name)
def test_sentences_fit_a_screen(path):
    """Tables and code do not bend, nor do names and addresses."""
    text = re.sub(r"^```.*?^```", "", path.read_text("utf-8"), flags=re.M | re.S)
    text = re.sub(r"`[^`]+`", lambda code: code[0].replace(" ", "_"), text)
    long = [
        line
        for line in text.splitlines()
        if len(line) > COLUMNS and not line.startswith(("|", "    "))
        if " " in line.strip()[2:]
    ]
    assert long == []


def bodies():
    """How many lines the body of each function of the package has, by its name."""
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                code = node.body[ast.get_docstring(node) is not None :]
                lines = node.end_lineno - code[0].lineno + 1 if code else 0
                yield f"{path.stem}.{node.name}", lines


def test_functions_are_short():
    lengths = dict(sorted(bodies(), key=lambda body: body[1]))
    name, most = list(lengths.items())[-1]
    assert most <= LONGEST, name
    assert statistics.median(lengths.values()) <= USUAL
    assert statistics.quantiles(lengths.values(), n=10)[-1] <= TENTH


MADE = (ast.Call, ast.BinOp, ast.BoolOp, ast.Compare, ast.IfExp, ast.Starred)
ALIKE = {"cos", "sin"}, {"min", "max"}


def test_unlike_things_are_made_in_lines_of_their_own():
    """``a, b = f(), g()`` hides the second; what is only named may stand together."""
    packed = [
        f"{path.relative_to(PACKAGE)}:{node.lineno}"
        for path in sorted(PACKAGE.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Tuple)
        if isinstance(node.targets[0], ast.Tuple) and _are_unlike(node.value.elts)
    ]
    assert packed == []


def _are_unlike(values):
    makers = {_maker(value) for value in values}
    made = any(isinstance(value, MADE) for value in values)
    return made and len(makers) > 1 and makers not in ALIKE


def _maker(value):
    """What makes a value: the last name of a function, or the kind of an expression."""
    if isinstance(value, ast.Call):
        return ast.unparse(value.func).split(".")[-1]
    return type(value)
