"""What a notebook must be: `stored` as it is committed, `executed` once it has run.

`read` opens one, and `strip` makes it ready to be committed.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import nbformat
from IPython.core.inputtransformer2 import TransformerManager
from nbformat import NotebookNode, ValidationError

from mkt.course import stripping
from mkt.files import DataError, whole

HELPERS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda)
DOORS = ("show", "explore")  # the functions that put a figure into a notebook
PICTURES = ("image/png", "text/html")
LEFT_OUT = "remove-cell"  # the tag of cells that the page leaves out


def strip(notebook: NotebookNode) -> NotebookNode:
    """A copy without outputs, execution counts and whatever else a session leaves."""
    return nbformat.from_dict(stripping.stripped(notebook))


def read(path: Path) -> NotebookNode:
    """The notebook of a file; DataError where it holds none."""
    try:
        return nbformat.read(path, 4)
    # JSON of another kind is found out only by what nbformat cannot do with it.
    except (ValueError, ValidationError, AttributeError, TypeError) as error:
        remedy = "mend it, or take it from git again"
        raise DataError(path, "is no notebook", remedy) from error


def strip_file(path: Path) -> bool:
    """Strip one notebook file in place, in one move; whether anything changed."""
    before = read(path)
    after = strip(before)
    if after == before:
        return False
    with whole(path) as half:
        half.write_text(nbformat.writes(after) + "\n", encoding="utf-8")
    return True


def stored(notebook: NotebookNode) -> list[str]:
    """What keeps a notebook from being committed, in sentences."""
    code = [trouble for cell in code_cells(notebook) for trouble in _of_cell(cell)]
    return [*_of_ids(notebook), *code]


def _of_ids(notebook: NotebookNode) -> Iterator[str]:
    names = [cell.get("id") for cell in notebook.cells]
    for name in dict.fromkeys(names):
        if not name or names.count(name) > 1:
            yield f"cell id {name} is missing or there twice"


def _of_cell(cell: NotebookNode) -> Iterator[str]:
    if cell.outputs or cell.execution_count is not None:
        yield (
            f"cell {cell.id} has stored outputs or a count; "
            "`python3 -m mkt strip` removes them"
        )
    if any(isinstance(node, HELPERS) for node in ast.walk(tree(cell))):
        yield (
            f"cell {cell.id} defines a function or class; it belongs into the library"
        )


def executed(notebook: NotebookNode) -> list[str]:
    """Which figures did not appear when a notebook ran, in sentences."""
    return [
        f"cell {cell.id} draws {', '.join(names)}, but no picture came out"
        for cell, names in figure_cells(notebook)
        if not _has_picture(cell)
    ]


def _has_picture(cell: NotebookNode) -> bool:
    kinds = {kind for output in cell.outputs for kind in output.get("data", {})}
    return not kinds.isdisjoint(PICTURES)


def figure_cells(notebook: NotebookNode) -> list[tuple[NotebookNode, list[str]]]:
    """The cells that call show("name") or explore("name"), with these names."""
    found = [(cell, _figures(cell)) for cell in code_cells(notebook)]
    return [(cell, names) for cell, names in found if names]


def _figures(cell: NotebookNode) -> list[str]:
    calls = [node for node in ast.walk(tree(cell)) if isinstance(node, ast.Call)]
    named = [call.args[0] for call in calls if call.args and _is_door(call.func)]
    return [
        argument.value
        for argument in named
        if isinstance(argument, ast.Constant) and isinstance(argument.value, str)
    ]


def _is_door(function: ast.expr) -> bool:
    """Whether this is ``show``, or ``mkt.show``."""
    if isinstance(function, ast.Attribute):
        return function.attr in DOORS
    return isinstance(function, ast.Name) and function.id in DOORS


def code_cells(notebook: NotebookNode) -> list[NotebookNode]:
    """The cells of a notebook that are run, in order."""
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def on_page(notebook: NotebookNode) -> list[NotebookNode]:
    """Those that the book runs.

    What the page leaves out, numbers that its text holds, the tests run.
    """
    cells = code_cells(notebook)
    return [cell for cell in cells if LEFT_OUT not in cell.metadata.get("tags", ())]


def tree(cell: NotebookNode) -> ast.Module:
    """The code of a cell as Python reads it, without IPython's own signs."""
    return ast.parse(TransformerManager().transform_cell(cell.source))
