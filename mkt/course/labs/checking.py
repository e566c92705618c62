"""What a student is told about one notebook: ``labs check``."""

from pathlib import Path

from nbformat import NotebookNode

from mkt.course.labs import LIMIT
from mkt.course.labs.borrowed import borrowed
from mkt.course.labs.marks import (
    Mark,
    answers,
    edited,
    failures_of,
    faults,
    marks,
    merged,
    missing,
    read,
    title_of,
)
from mkt.course.labs.notebooks import (
    HANDOUT,
    STUBS,
    name,
    of_role,
    originals,
    points,
)

UNKNOWN = "the original of this lab is not here: its checks count as they are"


def check(path: Path, limit: float = LIMIT) -> tuple[list[str], bool]:
    """Run a student's notebook with the lab's own checks, and say how each went.

    Parameters
    ----------
    path : Path
        Of the notebook, also as seen from notebooks/handout.
    limit : float [s]
        What a cell or a check may take.

    Returns
    -------
    lines : list of str
    passed : bool
        Whether all checks gave their points.

    Raises
    ------
    ValueError
        For a file that is no lab, or not there.
    """
    notebook = read(found(path))
    known = originals()
    # By its cells, or where these have lost their marks, by the name of its file.
    title = title_of(notebook, known) or (path.stem if path.stem in known else None)
    lab = known[title] if title else notebook
    if not of_role(lab, "check"):
        raise ValueError(
            f"{path}: this notebook has no checks; "
            "`python3 -m mkt labs release` makes notebooks that have"
        )
    failures = failures_of(lab, notebook, limit, boxed=False)
    results = marks(lab, failures)
    questions = of_role(lab, "question")
    answered = {*answers(lab, notebook)} if title else _begun(questions)
    lines = [
        *map(_line, results),
        *(_question(cell, asked in answered) for asked, cell in questions.items()),
        *([] if title else [UNKNOWN]),
        *missing(lab, notebook),
        *edited(lab, notebook),
        *faults(merged(lab, notebook), failures),
        *borrowed(lab, notebook),
        _sum(results, sum(points(cell) for cell in questions.values())),
    ]
    return lines, not any(mark.words for mark in results)


def found(path: Path) -> Path:
    """Where a notebook is, seen from here or from notebooks/handout.

    Raises ValueError where there is none.
    """
    for place in (path, HANDOUT / path, HANDOUT / f"{path}.ipynb"):
        if place.is_file():
            return place
        if place.is_dir():
            raise ValueError(f"{place}: this is a folder; give the notebook in it")
    raise ValueError(
        f"{path}: there is no such file, seen from this folder or from {HANDOUT}; "
        + _there()
    )


def _there() -> str:
    """What is in notebooks/handout, or what writes it."""
    names = [path.stem for path in sorted(HANDOUT.glob("*.ipynb"))]
    if names:
        return f"there are {', '.join(names)}"
    return "`python3 -m mkt labs release` writes the labs into that one"


def _line(mark: Mark) -> str:
    """How a check went."""
    words = f": {mark.words}" if mark.words else ""
    return f"{mark.points:3g} of {mark.of:g}  {mark.check}{words}"


def _begun(questions: dict[str, NotebookNode]) -> set[str]:
    """Those without a stub, where no original says what a student has added."""
    stub = STUBS["markdown"]
    return {asked for asked, cell in questions.items() if stub not in cell.source}


def _question(cell: NotebookNode, answered: bool) -> str:
    """What becomes of a question, which no check can judge."""
    words = f"no answer yet, it goes in the place of {STUBS['markdown']}"
    if answered:
        words = "a person reads your answer"
    return f"  ? of {points(cell):g}  {name(cell)}: {words}"


def _sum(results: list[Mark], to_read: float) -> str:
    so_far = sum(mark.points for mark in results)
    of = sum(mark.of for mark in results)
    read = f", and {to_read:g} for what a person reads" if to_read else ""
    return f"{so_far:g} of {of:g} points so far{read}; the hidden checks may find more"
