"""Solutions that use what does the work already: said, and never graded.

A lab needs the library for its own checks and figures, so a piece can be "solved" by
one call of it.  Whether that is a student's own work is for a person to say: the note
of the teacher's table names it, and so does ``labs check`` to the student.
"""

import ast
import re
from collections.abc import Iterator

from nbformat import NotebookNode

from mkt.course.labs.notebooks import name, of_role
from mkt.course.labs.source import LONGEST, parsed

LENDERS = "mkt", "scipy"  # packages in which the pieces of a lab are ready-made
USES = "{}: uses {}, ready-made; what the piece asks for is to be own work"
LONG = f"{{}}: has more than {LONGEST} letters, of which the rest was not read"
NUMBER = "my_number"  # a piece that may be typed, or computed with whatever is there


def borrowed(lab: NotebookNode, notebook: NotebookNode) -> list[str]:
    """Which cells use what the lab has for itself, in sentences.

    Of a solution that is all that it imports from `LENDERS`, what it uses of what the
    lab or a cell of the student's own imports from there, under whatever name, and the
    lab's own functions, without those that its own solutions use.  Of a cell of the
    student's own it is an import that may take the place of a solution.

    Parameters
    ----------
    lab : NotebookNode
        With its solutions.
    notebook : NotebookNode
        A student's.
    """
    solutions = of_role(lab, "solution")
    ours = of_role(lab, "given", "check")
    codes = [cell for cell in notebook.cells if cell.cell_type == "code"]
    theirs = [(name(cell), cell.source) for cell in codes if name(cell) not in ours]
    lent = {one for cell in ours.values() for one in _lent(cell)}
    lent -= {_first(one) for cell in solutions.values() for one in _used(cell.source)}
    lent |= {
        here
        for cell, source in theirs
        for here, _ in _imported(source)
        if cell not in solutions
    }
    pieces = {one for cell in solutions.values() for one in _functions(cell.source)}
    said = []
    for cell, source in theirs:
        if cell in solutions:
            names = _ready_made(source, lent) if cell != NUMBER else set()
        else:
            names = _put_in(source, pieces)
        if names:
            said.append(USES.format(cell, " and ".join(sorted(names))))
        if len(source) > LONGEST:
            said.append(LONG.format(cell))
    return list(dict.fromkeys(said))


def _lent(cell: NotebookNode) -> Iterator[str]:
    """The names of functions and modules that a cell of the lab lends."""
    if cell.cell_type == "code":
        yield from _functions(cell.source)
        yield from (here for here, _ in _imported(cell.source))


def _functions(source: str) -> list[str]:
    """The functions that a cell defines."""
    body = parsed(source).body
    return [node.name for node in body if isinstance(node, ast.FunctionDef)]


def _ready_made(source: str, lent: set[str]) -> set[str]:
    """What a solution uses that is lent, and all that it imports itself."""
    imported = _imported(source)
    lent = lent | {here for here, _ in imported}
    used = {one for one in _used(source) if _first(one) in lent}
    told = {_first(one) for one in used}
    return used | {there for here, there in imported if here not in told}


def _put_in(source: str, pieces: set[str]) -> set[str]:
    """What a cell of the student's own may put in the place of pieces by an import."""
    return {there for here, there in _imported(source) if here in {"*", *pieces}}


def _imported(source: str) -> list[tuple[str, str]]:
    """What a cell imports from `LENDERS`: its name here, and the whole one there."""
    found = []
    for node in ast.walk(parsed(source[:LONGEST])):
        if isinstance(node, ast.Import):
            found += [(one.asname or _first(one.name), one.name) for one in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found += [
                (one.asname or one.name, f"{node.module}.{one.name}")
                for one in node.names
            ]
    return [(here, there) for here, there in found if _first(there) in LENDERS]


def _used(source: str) -> set[str]:
    """What a cell uses and does not make itself, with its dots: `mkt.errors`."""
    nodes = list(ast.walk(parsed(source[:LONGEST])))
    names = [node for node in nodes if isinstance(node, ast.Name)]
    made = {node.id for node in names if not isinstance(node.ctx, ast.Load)}
    made |= {node.arg for node in nodes if isinstance(node, ast.arg)}
    within = {node.value for node in nodes if isinstance(node, ast.Attribute)}
    asked = [node for node in nodes if isinstance(node, ast.Name | ast.Attribute)]
    whole = [ast.unparse(node) for node in asked if node not in within]
    # Without what is asked of something that has no name, such as `f(x).y`.
    dotted = [one for one in whole if re.fullmatch(r"[\w.]+", one)]
    return {one for one in dotted if _first(one) not in made}


def _first(dotted: str) -> str:
    """The name that a dotted name begins with."""
    return dotted.partition(".")[0]
