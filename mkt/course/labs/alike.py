"""What two students hardly ever write alike: a long answer, and all their code.

A copy is found by it that has other comments, another layout, or one cell more.
"""

import ast
from collections.abc import Collection

from nbformat import NotebookNode

from mkt.course.labs.borrowed import NUMBER
from mkt.course.labs.marks import answers
from mkt.course.labs.notebooks import name, of_role, released
from mkt.course.labs.source import LONGEST, parsed
from mkt.course.labs.submissions import Work
from mkt.course.labs.variants import NAME, plain_name

OWN = {NAME, NUMBER}  # pieces that differ even in copies
LONG = 40  # [letters] beyond which an answer is not the same by chance


def compared(lab: NotebookNode, notebook: NotebookNode) -> dict[str, Work]:
    """What a student's notebook has in common with copies of it alone, {what: texts}.

    That is neither a short answer nor the model answer, and the code only where each
    piece is written and not all are the model solutions: one short piece, such as a
    formula, is the same in many honest files.  Of a piece with several cells a copy
    need have but one.

    Parameters
    ----------
    lab : NotebookNode
        With its solutions.
    notebook : NotebookNode
        A student's.
    """
    questions = of_role(lab, "question")
    said = {
        question: plain_name(text) for question, text in answers(lab, notebook).items()
    }
    found: dict[str, Work] = {
        f"the answer to {question}": [{text}]
        for question, text in said.items()
        if len(text) > LONG and text not in plain_name(questions[question].source)
    }
    pieces = sorted(of_role(lab, "solution").keys() - OWN)
    written = _written(lab, notebook, pieces)
    if all(written) and _code(notebook, pieces) != _code(lab, pieces):
        found["all its code"] = written
    return found


def is_blank(lab: NotebookNode, notebook: NotebookNode) -> bool:
    """Whether a student has written nothing; two of these are no copies."""
    pieces = of_role(lab, "solution")
    return not answers(lab, notebook) and not any(_written(lab, notebook, pieces))


def _written(
    lab: NotebookNode, notebook: NotebookNode, pieces: Collection[str]
) -> Work:
    """What a student has written in each piece of code."""
    theirs, stubs = (_code(one, pieces) for one in (notebook, released(lab)))
    return [codes - stub for codes, stub in zip(theirs, stubs, strict=True)]


def _code(notebook: NotebookNode, pieces: Collection[str]) -> list[set[str]]:
    """What Python reads in the cells of each piece of code."""
    return [
        {_tree(cell.source[:LONGEST]) for cell in notebook.cells if name(cell) == piece}
        for piece in pieces
    ]


class _Bare(ast.NodeTransformer):
    """Takes away what does nothing: docstrings, other constants, and `pass`."""

    def visit_Expr(self, node: ast.Expr) -> ast.Expr | None:
        """Leave what is more than a constant."""
        return None if isinstance(node.value, ast.Constant) else node

    def visit_Pass(self, node: ast.Pass) -> None:
        """Leave nothing of it."""


def _tree(source: str) -> str:
    """Code without texts and layout, or as it is where Python cannot read it."""
    try:
        tree = _Bare().visit(parsed(source))
        return ast.dump(tree) if tree.body else source
    except RecursionError:
        return source
