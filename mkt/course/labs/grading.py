"""Points for labs: `check` one notebook for a student, `grade` a folder for a teacher.

Cells that must fail are run after those of a submission, and tell when asserts no
longer do; that is no proof against intent.
"""

import asyncio
import csv
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import nbformat
from nbformat import NotebookNode
from tqdm import tqdm

from mkt.course.book.client import KERNELS
from mkt.course.labs.marks import (
    Mark,
    answers,
    edited,
    failures_of,
    faults,
    marks,
    merged,
    read,
    reasons,
)
from mkt.course.labs.notebooks import HANDOUT, STUBS, labs, name, of_role, points
from mkt.course.labs.submissions import Submission, handed_in
from mkt.files import whole

WRONG = (
    "False",
    "all([False])",
    "abs(1) == 0",
    "np.all([False])",
    "np.isclose(0, 1)",
    "np.allclose([0, 1], [0, 2])",
    "np.array_equal([0], [1])",
)
MUST_FAIL = [nbformat.v4.new_code_cell(f"assert {wrong}") for wrong in WRONG]
# Of the table, before and after the checks.
COLUMNS = ("student", "lab", "points", "of", "to_read"), ("note", "answers", "file")

Row = dict[str, Any]


def check(path: Path, limit: float = 60) -> tuple[list[str], bool]:
    """Run a student's notebook with the checks that it has, and say how each went.

    Parameters
    ----------
    path : Path
        Of the notebook, also as seen from notebooks/handout.
    limit : float [s]
        What a cell may take.

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
    notebook = read(_found(path))
    if not of_role(notebook, "check"):
        raise ValueError(
            f"{path}: this notebook has no checks; "
            "`python3 -m mkt labs release` makes notebooks that have"
        )
    failures = asyncio.run(failures_of(notebook.cells, limit))
    results = marks(notebook, notebook, failures)
    questions = of_role(notebook, "question")
    lines = [
        *map(_line, results),
        *(_question(question, cell) for question, cell in questions.items()),
        *faults(notebook, failures),
        _sum(results, sum(points(cell) for cell in questions.values())),
    ]
    return lines, not any(mark.words for mark in results)


def _found(path: Path) -> Path:
    for place in (path, HANDOUT / path):
        if place.is_file():
            return place
    raise ValueError(
        f"{path}: there is no such file, seen from this folder or from {HANDOUT}; "
        "`python3 -m mkt labs release` writes the labs into that one"
    )


def _line(mark: Mark) -> str:
    """How a check went."""
    words = f": {mark.words}" if mark.words else ""
    return f"{mark.points:3g} of {mark.of:g}  {mark.check}{words}"


def _question(question: str, cell: NotebookNode) -> str:
    """What becomes of a question, which no check can judge."""
    stub = STUBS["markdown"]
    text = cell.source.strip()
    words = f"no answer yet, it goes in the place of {stub}"
    if text and not text.endswith(stub):
        words = "a person reads your answer"
    return f"  ? of {points(cell):g}  {question}: {words}"


def _sum(results: list[Mark], to_read: float) -> str:
    so_far = sum(mark.points for mark in results)
    of = sum(mark.of for mark in results)
    read = f", and {to_read:g} for what a person reads" if to_read else ""
    return f"{so_far:g} of {of:g} points so far{read}; the hidden checks may find more"


def grade(folder: Path, output: Path, limit: float = 60) -> None:
    """Grade all notebooks of a folder into a new CSV file.

    Which these are `mkt.course.labs.submissions` says.  The table has a row for each,
    sorted by student and lab, and grows row by row.  A row has the points of each
    check, their sum, the points of the questions that a person has to read, the
    answers, and a note on what went wrong.  This executes what the students wrote.

    Parameters
    ----------
    folder, output : Path
    limit : float [s]
        What a cell may take.

    Raises
    ------
    ValueError
        Where there is nothing to grade, or the table is there already.
    InterruptedError
        At Ctrl-C; it says what is in the table.
    """
    sources = labs()
    _can_make(output)
    found = handed_in(folder, sources)
    columns = _columns(found, sources)
    rows: list[Row] = []

    def keep(row: Row) -> None:
        rows.append(row)
        _write(output, columns, rows)

    try:
        asyncio.run(_grade_all(found, sources, limit, keep))
    except KeyboardInterrupt:
        state = f"has {len(rows)} of {len(found)} rows" if rows else "was not begun"
        raise InterruptedError(f"stopped: {output} {state}") from None


def _can_make(output: Path) -> None:
    if output.exists():
        raise ValueError(
            f"-o {output}: it is there already, perhaps with marks that you typed; "
            "choose another name, or remove it"
        )
    if not output.parent.is_dir():
        raise ValueError(
            f"-o {output}: there is no folder {output.parent}; "
            "make it first, or choose another place"
        )


def _columns(found: list[Submission], sources: Mapping[str, NotebookNode]) -> list[str]:
    """Of the table: with all checks of the labs that were handed in."""
    before, after = COLUMNS
    present = {one.lab for one in found}
    checks = [
        of_role(lab, "check") for title, lab in sources.items() if title in present
    ]
    return [*before, *(check for each in checks for check in each), *after]


def _write(output: Path, columns: list[str], rows: list[Row]) -> None:
    """Write the table as a whole."""

    def order(row: Row) -> tuple[str, str, str]:
        return row["student"], row["lab"] or "", row["file"]

    # Its first mark (utf-8-sig) tells spreadsheets how to read umlauts.
    with (
        whole(output) as half,
        half.open("w", newline="", encoding="utf-8-sig") as file,
    ):
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(sorted(rows, key=order))


async def _grade_all(
    found: list[Submission],
    sources: Mapping[str, NotebookNode],
    limit: float,
    keep: Callable[[Row], None],
) -> None:
    gate = asyncio.Semaphore(KERNELS)

    async def one(submission: Submission) -> None:
        async with gate:
            lab = sources.get(submission.lab or "")
            keep(await _row(submission, lab, limit))
            bar.update()

    with tqdm(total=len(found), desc="submissions", disable=None) as bar:
        await asyncio.gather(*map(one, found))


async def _row(submission: Submission, lab: NotebookNode | None, limit: float) -> Row:
    """The row of one submission, whatever it is."""
    student, title, path = submission
    row = {"student": student, "lab": title, "file": str(path)}
    if not submission.is_notebook:
        return row | {"note": f"not a notebook: {path.suffix or path.name}"}
    if lab is None:
        note = "of no lab: the name of the file must have that of the lab in it"
        return row | {"note": note}
    try:
        return row | await _graded(lab, path, limit)
    except Exception as error:  # what is wrong with one file must not stop the others
        of = sum(points(cell) for cell in of_role(lab, "check").values())
        note = f"cannot be graded: {type(error).__name__}: {error}"
        return row | {"points": 0, "of": of, "to_read": 0, "note": note}


async def _graded(lab: NotebookNode, path: Path, limit: float) -> Row:
    """What a row says about a notebook that can be read."""
    handed_in = read(path)
    cells = merged(lab, handed_in).cells
    failures = await failures_of([*cells, *MUST_FAIL], limit)
    failed = [failures.pop(name(cell), "") for cell in MUST_FAIL]
    results = marks(lab, handed_in, failures)
    said = answers(lab, handed_in)
    questions = of_role(lab, "question")
    notes = [
        *([] if all(failed) else ["the checks were tampered with: read this notebook"]),
        *(f"{one}: not answered" for one in questions if one not in said),
        *edited(lab, handed_in),
        *faults(merged(lab, handed_in), failures),
        *reasons(results),
    ]
    return {mark.check: mark.points for mark in results} | {
        "points": sum(mark.points for mark in results),
        "of": sum(mark.of for mark in results),
        "to_read": sum(points(questions[question]) for question in said),
        "note": "; ".join(notes),
        "answers": "\n\n".join(f"{one}: {text}" for one, text in said.items()),
    }
