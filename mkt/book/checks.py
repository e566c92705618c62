"""What a notebook must be: `stored` as it is committed, `executed` once it has run; and `strip`, which makes it so."""

import ast
import copy

import nbformat
from IPython.core.inputtransformer2 import TransformerManager

from mkt.files import whole

HELPERS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda)
PICTURES = ("image/png", "text/html")
KEPT = ("tags", "nbgrader", "slideshow")  # of a cell's metadata; the rest is what a session left behind


def strip(notebook):
    """A copy without outputs, execution counts and what else a session leaves behind."""
    clean = copy.deepcopy(notebook)
    for cell in clean.cells:
        cell.metadata = nbformat.from_dict({key: value for key, value in cell.metadata.items() if key in KEPT})
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    clean.metadata = nbformat.from_dict({"kernelspec": kernel, "language_info": {"name": "python"}})
    return clean


def strip_file(path):
    """Strip one notebook file in place, in one move.  Returns whether anything changed."""
    before = nbformat.read(path, 4)
    after = strip(before)
    if after == before:
        return False
    with whole(path) as half:
        half.write_text(nbformat.writes(after) + "\n", encoding="utf-8")
    return True


def stored(notebook):
    """What keeps a notebook from being committed, as a list of sentences."""
    ids = [cell.get("id") for cell in notebook.cells]
    troubles = [f"cell id {id} is missing or there twice" for id in dict.fromkeys(ids) if not id or ids.count(id) > 1]
    for cell in _code(notebook):
        if cell.outputs or cell.execution_count is not None:
            troubles.append(f"cell {cell.id} has stored outputs or a count; `python3 -m mkt strip` removes them")
        if any(isinstance(node, HELPERS) for node in ast.walk(_tree(cell))):
            troubles.append(f"cell {cell.id} defines a function or class; it belongs into the library")
    return troubles


def executed(notebook):
    """Which figures did not appear when a notebook ran, as a list of sentences."""
    return [f"cell {cell.id} draws {', '.join(ids)}, but no picture came out" for cell, ids in figure_cells(notebook)
            if not any(kind in output.get("data", {}) for output in cell.outputs for kind in PICTURES)]


def figure_cells(notebook):
    """The cells that call show("id") or explore("id"), as a list of (cell, [ids])."""
    found = [(cell, [node.args[0].value for node in ast.walk(_tree(cell)) if _is_figure(node)]) for cell in _code(notebook)]
    return [(cell, ids) for cell, ids in found if ids]


def _is_figure(node):
    return (isinstance(node, ast.Call) and getattr(node.func, "id", None) in ("show", "explore")
            and bool(node.args) and isinstance(node.args[0], ast.Constant))


def _code(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def _tree(cell):
    return ast.parse(TransformerManager().transform_cell(cell.source))
