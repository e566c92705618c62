"""What a student's notebook is worth, and what is to be said about it.

A submission runs as the student left it, but each check and given cell is replaced by
the lab's own, found by its grade_id: an edited check is of no help, a deleted one costs
its points.
"""

import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import nbformat
from nbformat import NotebookNode

from mkt.course.labs.notebooks import headings, name, of_role, points, released
from mkt.course.labs.process import NOT_RUN, UNWRITTEN, kernel, run


class Mark(NamedTuple):
    """What a check gave.

    Attributes
    ----------
    check : str
        Its grade_id.
    points, of : float
        Those it gave and those it can give.
    words : str
        Why it gave none.
    """

    check: str
    points: float
    of: float
    words: str


def read(path: Path) -> NotebookNode:
    """A notebook from a file; copied cells, and those of old files, get their own ids.

    Raises
    ------
    ValueError
        Where it is none.
    OSError
    """
    try:
        # The warnings name no file, and what they are about is mended here.
        with warnings.catch_warnings(action="ignore"):
            notebook = nbformat.v4.upgrade(nbformat.read(path, 4))
            nbformat.validate(notebook)
        return notebook
    except OSError:
        raise
    except Exception as error:  # nbformat raises about anything for a file that is none
        why = str(error).splitlines()[0]
        raise ValueError(f"{path} is not a notebook: {why}") from None


async def failures_of(cells: Iterable[NotebookNode], limit: float) -> dict[str, str]:
    """Which of some cells fail in a fresh kernel (see `mkt.course.labs.process.run`).

    Parameters
    ----------
    cells : iterable of NotebookNode
    limit : float [s]
        What a cell may take.
    """
    async with kernel(limit) as client:
        return await run(client, cells)


def marks(
    lab: NotebookNode, notebook: NotebookNode, failures: Mapping[str, str]
) -> list[Mark]:
    """The marks of all checks of a lab.

    Parameters
    ----------
    lab, notebook : NotebookNode
        The lab, and what a student made of it.
    failures : dict
        Of `failures_of`.
    """
    present = of_role(notebook, "check")
    result = []
    for check, cell in of_role(lab, "check").items():
        words = "this check is missing from the notebook"
        if check in present:
            words = failures.get(check, "")
        result.append(Mark(check, 0 if words else points(cell), points(cell), words))
    return result


def merged(lab: NotebookNode, notebook: NotebookNode) -> NotebookNode:
    """A student's notebook with the checks and given cells of the lab.

    They take the place of its own, under the ids that those have.
    """
    ours = of_role(lab, "check", "given")
    cells = [
        nbformat.from_dict({**(ours.get(name(cell)) or cell), "id": cell.id})
        for cell in notebook.cells
    ]
    return nbformat.v4.new_notebook(cells=cells)


def answers(lab: NotebookNode, notebook: NotebookNode) -> dict[str, str]:
    """What a student wrote to each question, {grade_id: text}.

    It is looked for in the question's cell, without the lab's own lines, and in text
    cells of the student's own below it.
    """
    ours = {line for cell in released(lab).cells for line in _lines(cell)}
    questions = of_role(lab, "question")
    said: dict[str, list[str]] = {}
    question = None
    for cell in notebook.cells:
        if name(cell) in questions:
            question = name(cell)
        if question and (cell.cell_type == "markdown" or name(cell) == question):
            lines = [
                line for line in cell.source.splitlines() if line.strip() not in ours
            ]
            said[question] = said.get(question, []) + lines
    return {question: "\n".join(lines) for question, lines in said.items() if lines}


def _lines(cell: NotebookNode) -> list[str]:
    return [line.strip() for line in cell.source.splitlines()]


def faults(notebook: NotebookNode, failures: Mapping[str, str]) -> list[str]:
    """What went wrong outside the checks, in sentences, without what only follows.

    That is in the cells that the student writes, and in whatever failed first.
    """
    where = headings(notebook)
    first = list(failures)[:1]
    told = {*of_role(notebook, "solution"), *first} - {*of_role(notebook, "check")}
    return [
        f"{where[cell]}: {words}"
        for cell, words in failures.items()
        if cell in told and words != UNWRITTEN and not words.startswith(NOT_RUN)
    ]


def edited(lab: NotebookNode, notebook: NotebookNode) -> list[str]:
    """Which checks and given cells a student has changed, in sentences."""
    ours = of_role(released(lab), "check", "given")
    return [
        f"{name(cell)}: was edited, the original counts"
        for cell in notebook.cells
        if name(cell) in ours and cell.source.strip() != ours[name(cell)].source.strip()
    ]


def reasons(marks: Iterable[Mark]) -> list[str]:
    """Why checks gave no points; those that were not run are in one sentence."""
    failed = [mark for mark in marks if mark.words]
    idle = [mark.words for mark in failed if mark.words.startswith(NOT_RUN)]
    words = [f"{m.check}: {m.words}" for m in failed if m.words not in idle]
    if not idle:
        return words
    count = "1 check was" if len(idle) == 1 else f"{len(idle)} checks were"
    return [*words, f"{idle[0].removeprefix(NOT_RUN)}, and {count} not run"]
