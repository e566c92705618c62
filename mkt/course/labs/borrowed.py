"""Solutions that use what does the work already: told to the teacher, never graded.

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
    """Which solutions use what the lab has for itself, in sentences.

    That is what it imports from `LENDERS`, under whatever name, what a solution imports
    from the library, and the lab's own functions, without those that its own solutions
    use.

    Parameters
    ----------
    lab : NotebookNode
        With its solutions.
    notebook : NotebookNode
        A student's.
    """
    solutions = of_role(lab, "solution")
    lent = {
        one
        for cell in of_role(lab, "given", "check").values()
        if cell.cell_type == "code"
        for one in _lent(cell.source)
    }
    lent -= {_first(one) for cell in solutions.values() for one in _used(cell.source)}
    found = {
        name(cell): _ready_made(cell.source, lent)
        for cell in notebook.cells
        if name(cell) in solutions.keys() - {NUMBER}
    }
    return [
        f"{cell}: uses {' and '.join(names)}, and own work is asked for"
        for cell, names in found.items()
        if names
    ]


def _lent(source: str) -> Iterator[str]:
    """The names of functions and modules that a cell of the lab lends."""
    for node in _parsed(source).body:
        if isinstance(node, ast.FunctionDef):
            yield node.name
    yield from (here for here, _, _ in _imported(source))


def _ready_made(source: str, lent: set[str]) -> list[str]:
    """What a solution uses that is lent, or that it imports itself."""
    own = {
        here
        for here, there, module in _imported(source)
        if there in lent or module == LENDERS[0]
    }
    return sorted(one for one in _used(source) if _first(one) in lent | own)


def _imported(source: str) -> Iterator[tuple[str, str, str]]:
    """What a cell imports from `LENDERS`: its name here and there, and from which."""
    for node in ast.walk(_parsed(source)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            for alias in node.names:
                module = _first(getattr(node, "module", alias.name) or "")
                if module in LENDERS:
                    yield alias.asname or _first(alias.name), alias.name, module


def _used(source: str) -> set[str]:
    """What a cell uses and does not make itself, with its dots: `mkt.errors`."""
    nodes = list(ast.walk(_parsed(source)))
    names = [node for node in nodes if isinstance(node, ast.Name)]
    made = {node.id for node in names if not isinstance(node.ctx, ast.Load)}
    made |= {node.arg for node in nodes if isinstance(node, ast.arg)}
    within = {node.value for node in nodes if isinstance(node, ast.Attribute)}
    whole = [
        node for node in nodes if isinstance(node, ast.expr) and node not in within
    ]
    return {one for one in map(_dotted, whole) if one and _first(one) not in made}


def _dotted(node: ast.expr) -> str:
    """A name with what is asked of it; "" where it is of something without a name."""
    asked: list[str] = []
    while isinstance(node, ast.Attribute):
        asked.insert(0, node.attr)
        node = node.value
    return ".".join([node.id, *asked]) if isinstance(node, ast.Name) else ""


def _first(dotted: str) -> str:
    """The name that a dotted name begins with."""
    return dotted.partition(".")[0]


def _parsed(source: str) -> ast.Module:
    """A cell as Python reads it; empty where it cannot, which others say."""
    try:
        return ast.parse(source)
    except (SyntaxError, ValueError):
        return ast.Module([], [])
