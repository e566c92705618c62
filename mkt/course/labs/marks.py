"""What a student's notebook is worth, and what is to be said about it.

A submission runs as the student left it, but each given cell is replaced by the lab's
own, found by its grade_id, and the checks are the lab's own: one that was edited or
deleted is neither of help nor of harm.  Names that the student gives to something else
below a check do not change what it says.
"""

import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import nbformat
from nbformat import NotebookNode
from nbformat.reader import NotJSONError

from mkt.course.labs.judge import judged
from mkt.course.labs.notebooks import headings, name, of_role, points, released, role
from mkt.course.labs.student import UNWRITTEN, Cell

SLOW = "not finished after"  # says `mkt.course.labs.student`
FREE = " (this cell costs no points)"
ORIGINAL = "the original counts"


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
            text = path.read_text(encoding="utf-8-sig")  # some editors put a mark
            notebook = nbformat.v4.upgrade(nbformat.reads(text, 4))
            nbformat.validate(notebook)
        for cell in notebook.cells:
            cell.source = cell.source.replace("\r\n", "\n")  # as Windows ends a line
        return notebook
    except OSError:
        raise
    except UnicodeDecodeError:
        raise ValueError(f"{path} is not a notebook: it is no text") from None
    except (AttributeError, NotJSONError):  # it asks a list, or a number, for its parts
        raise ValueError(f"{path} is not a notebook: no JSON object") from None
    except nbformat.ValidationError:  # which shows the whole cell
        raise ValueError(f"{path} is not a notebook: of another form") from None
    except Exception as error:  # nbformat raises about anything for a file that is none
        why = str(error).splitlines()[0]
        raise ValueError(f"{path} is not a notebook: {why}") from None


def title_of(notebook: NotebookNode, labs: Mapping[str, NotebookNode]) -> str | None:
    """The lab that a notebook has the most cells of, None where it has none of any."""
    names = {name(cell) for cell in notebook.cells}
    shared = {
        title: len(names & {*of_role(lab, "check", "solution", "question")})
        for title, lab in labs.items()
    }
    best = max(shared, key=shared.__getitem__, default=None)
    return best if best and shared[best] else None


def failures_of(
    lab: NotebookNode, notebook: NotebookNode, limit: float, *, boxed: bool
) -> dict[str, str]:
    """What fails in a student's notebook, {name of the cell: why}.

    Parameters
    ----------
    lab, notebook : NotebookNode
        The lab, and what a student made of it.
    limit : float [s]
        What a cell or a check may take.
    boxed : bool
        Whether the student's code runs in bubblewrap's box.

    Raises
    ------
    mkt.course.labs.judge.Trouble
        Where the judge itself failed.
    """
    given, checks = (
        _cells(of_role(lab, which).values()) for which in ("given", "check")
    )
    code = [cell for cell in merged(lab, notebook).cells if cell.cell_type == "code"]
    theirs = [
        Cell(name(cell), "" if role(cell) == "check" else cell.source) for cell in code
    ]
    return judged(given, checks, theirs, limit, boxed=boxed)


def _cells(cells: Iterable[NotebookNode]) -> list[Cell]:
    return [Cell(name(cell), cell.source) for cell in cells]


def marks(lab: NotebookNode, failures: Mapping[str, str]) -> list[Mark]:
    """The marks of all checks of a lab.

    Parameters
    ----------
    lab : NotebookNode
    failures : dict
        Of `failures_of`.
    """
    result = []
    for check, cell in of_role(lab, "check").items():
        words = failures.get(check, "")
        result.append(Mark(check, 0 if words else points(cell), points(cell), words))
    return result


def merged(lab: NotebookNode, notebook: NotebookNode) -> NotebookNode:
    """A student's notebook with the checks and given cells of the lab.

    They take the place of the student's own cells, under the ids that those have.
    Of those that are gone, given cells are put back behind what stands before them in
    the lab, and checks before what stands behind them there: what is tried further down
    is not what they judge.  Where a cell that has lost its marks still has their id,
    they get a new one.
    """
    ours = of_role(lab, "check", "given")
    cells = [
        nbformat.from_dict({**(ours.get(name(cell)) or cell), "id": cell.id})
        for cell in notebook.cells
    ]
    names, ids = [name(cell) for cell in cells], {cell.id for cell in cells}
    place = 0
    for at, cell in enumerate(lab.cells):
        if name(cell) in names:
            place = names.index(name(cell)) + 1
            continue
        if role(cell) == "check":
            below = (names.index(n) for n in map(name, lab.cells[at:]) if n in names)
            place = max(place, next(below, len(cells)))
        elif role(cell) != "given":
            continue
        again = f"{cell.id}-again" if cell.id in ids else cell.id
        cells.insert(place, nbformat.from_dict({**cell, "id": again}))
        names.insert(place, name(cell))
        place += 1
    return nbformat.v4.new_notebook(cells=cells)


def answers(lab: NotebookNode, notebook: NotebookNode) -> dict[str, str]:
    """What a student wrote to each question, {grade_id: text}.

    It is looked for in the question's cell, without the lab's own lines, and in text
    cells of the student's own below it.
    """
    ours = _our_lines(lab)
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


def other_text(lab: NotebookNode, notebook: NotebookNode) -> str:
    """What a student wrote that is neither the lab's, nor code, nor an answer.

    Such as a text cell above the question, or a cell of nothing but comments.
    """
    said = "\n".join(answers(lab, notebook).values())
    told = _our_lines(lab) | {line.strip() for line in said.splitlines()}
    return "\n".join(
        line
        for cell in notebook.cells
        if cell.cell_type != "code" or _is_comment(cell)
        for line in cell.source.splitlines()
        if line.strip() and line.strip() not in told
    )


def _is_comment(cell: NotebookNode) -> bool:
    """Whether a cell of the student's own has nothing in it that runs."""
    lines = filter(None, _lines(cell))
    return role(cell) is None and all(line.startswith("#") for line in lines)


def _our_lines(lab: NotebookNode) -> set[str]:
    """The lines of a lab as students get it."""
    return {line for cell in released(lab).cells for line in _lines(cell)}


def _lines(cell: NotebookNode) -> list[str]:
    return [line.strip() for line in cell.source.splitlines()]


def faults(notebook: NotebookNode, failures: Mapping[str, str]) -> list[str]:
    """What went wrong outside the checks, in sentences, without what only follows.

    That is in the cells that the student writes, and in whatever failed first.  Of a
    cell of the student's own that takes too long they say that it costs nothing.
    """
    where = {
        cell: cell if place == cell else f'under "{place}"'
        for cell, place in headings(notebook).items()
    }
    first = list(failures)[:1]
    told = {*of_role(notebook, "solution"), *first} - {*of_role(notebook, "check")}
    own = {name(cell) for cell in notebook.cells if role(cell) is None}
    return [
        f"{where[cell]}: {words}{FREE if cell in own and SLOW in words else ''}"
        for cell, words in failures.items()
        if cell in told and cell in where and words != UNWRITTEN
    ]


def edited(lab: NotebookNode, notebook: NotebookNode) -> list[str]:
    """Which checks and given cells a student has changed or deleted, in sentences."""
    ours = of_role(released(lab), "check", "given")
    theirs = {name(cell): cell.source.strip() for cell in notebook.cells}
    deeds = {
        cell: "edited" if cell in theirs else "deleted"
        for cell, original in ours.items()
        if theirs.get(cell) != original.source.strip()
    }
    return [f"{cell}: was {deed}, {ORIGINAL}" for cell, deed in deeds.items()]


def missing(lab: NotebookNode, notebook: NotebookNode) -> list[str]:
    """Which cells for code and answers a notebook has not, in sentences.

    Or has as text, where JupyterLab runs them no more.
    """
    there = {name(cell) for cell in notebook.cells}
    runs = {name(cell) for cell in notebook.cells if cell.cell_type == "code"}
    gone = [
        f"the cell {cell} is missing: was it deleted, or is this an older version of "
        "the lab?"
        for cell in of_role(lab, "solution", "question")
        if cell not in there
    ]
    text = [
        f"the cell {cell} is text now and does not run: make it a cell of code again"
        for cell in of_role(lab, "solution")
        if cell in there - runs
    ]
    return gone + text


def reasons(marks: Iterable[Mark]) -> list[str]:
    """Why checks gave no points."""
    return [f"{mark.check}: {mark.words}" for mark in marks if mark.words]
