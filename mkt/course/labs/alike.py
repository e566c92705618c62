"""What two students hardly ever write alike: a long answer, and all their code.

A copy is found by it that has other comments, another layout, or one cell more.
"""

import ast
from collections.abc import Collection

from nbformat import NotebookNode

from mkt.course.labs.borrowed import NUMBER
from mkt.course.labs.marks import answers
from mkt.course.labs.notebooks import name, of_role, released
from mkt.course.labs.variants import plain_name

OWN = {"my_name", NUMBER}  # pieces that differ even in copies
LONG = 40  # [letters] beyond which an answer is not the same by chance
LONGEST = 10_000  # [letters] of a piece of code that are compared


def compared(lab: NotebookNode, notebook: NotebookNode) -> dict[str, str]:
    """What a student's notebook has in common with copies of it alone, {what: text}.

    That is neither a short answer nor the model answer, and the code only where each
    piece is written and not all are the model solutions: one short piece, such as a
    formula, is the same in many honest files.

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
    found = {
        f"the answer to {question}": text
        for question, text in said.items()
        if len(text) > LONG and text not in plain_name(questions[question].source)
    }
    pieces = of_role(lab, "solution").keys() - OWN
    theirs, stubs, model = (
        _code(one, pieces) for one in (notebook, released(lab), lab)
    )
    if theirs.keys() == pieces and theirs != model:
        if not theirs.items() & stubs.items():
            found["all its code"] = str(sorted(theirs.items()))
    return found


def _code(notebook: NotebookNode, pieces: Collection[str]) -> dict[str, str]:
    """What Python reads in pieces of code, {grade_id: text}."""
    return {
        name(cell): _tree(cell.source[:LONGEST])
        for cell in notebook.cells
        if name(cell) in pieces
    }


def _tree(source: str) -> str:
    """Code without comments and layout, or as it is where Python cannot read it."""
    try:
        return ast.dump(ast.parse(source))
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        return source
