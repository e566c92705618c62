"""Solutions that call what does the work already: told to the teacher, never graded.

A lab needs the library for its own checks and figures, so a piece can be "solved" by
one call of it.  Whether that is a student's own work is for a person to say.
"""

import ast
from collections.abc import Iterator

from nbformat import NotebookNode

from mkt.course.labs.notebooks import name, of_role

LENDERS = "mkt", "scipy"  # packages in which the pieces of a lab are ready-made
NUMBER = "my_number"  # a piece that may be typed, or computed with whatever is there


def borrowed(lab: NotebookNode, notebook: NotebookNode) -> list[str]:
    """Which solutions call what the lab has for itself, in sentences.

    That is what it imports from `LENDERS`, and its own functions, without those that
    its own solutions call.

    Parameters
    ----------
    lab : NotebookNode
        With its solutions.
    notebook : NotebookNode
        A student's.
    """
    solutions = of_role(lab, "solution")
    others = [
        cell
        for cell in of_role(lab, "given", "check").values()
        if cell.cell_type == "code"
    ]
    lent = {one for cell in others for one in _lent(cell.source)}
    lent -= {_first(one) for cell in solutions.values() for one in _called(cell.source)}
    found = {
        name(cell): sorted(one for one in _called(cell.source) if _first(one) in lent)
        for cell in notebook.cells
        if name(cell) in solutions.keys() - {NUMBER}
    }
    return [
        f"{cell}: calls {' and '.join(names)}, and own work is asked for"
        for cell, names in found.items()
        if names
    ]


def _lent(source: str) -> Iterator[str]:
    """The names of functions and modules that a cell of the lab lends."""
    for node in _parsed(source).body:
        if isinstance(node, ast.FunctionDef):
            yield node.name
        elif isinstance(node, ast.Import):
            lenders = [alias for alias in node.names if _lends(alias.name)]
            yield from (alias.asname or alias.name for alias in lenders)
        elif isinstance(node, ast.ImportFrom) and _lends(node.module or ""):
            yield from (alias.asname or alias.name for alias in node.names)


def _lends(module: str) -> bool:
    return module.split(".")[0] in LENDERS


def _called(source: str) -> set[str]:
    """What a cell calls and does not make itself, with its dots: `mkt.errors`."""
    nodes = list(ast.walk(_parsed(source)))
    called = {_dotted(node.func) for node in nodes if isinstance(node, ast.Call)}
    made = {
        node.id
        for node in nodes
        if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load)
    }
    made |= {node.arg for node in nodes if isinstance(node, ast.arg)}
    return {one for one in called if _first(one) not in made}


def _dotted(call: ast.expr) -> str:
    """A name with what is asked of it; "" where it is of something without a name."""
    asked: list[str] = []
    while isinstance(call, ast.Attribute):
        asked.insert(0, call.attr)
        call = call.value
    return ".".join([call.id, *asked]) if isinstance(call, ast.Name) else ""


def _first(dotted: str) -> str:
    """The name that a dotted name begins with."""
    return dotted.partition(".")[0]


def _parsed(source: str) -> ast.Module:
    """A cell as Python reads it; empty where it cannot, which others say."""
    try:
        return ast.parse(source)
    except (SyntaxError, ValueError):
        return ast.Module([], [])
