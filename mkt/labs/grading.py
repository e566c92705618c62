"""Points for labs: `check` one notebook for a student, `grade` a folder of them for a teacher.

A submission runs as the student left it, but each check and given cell is replaced by the lab's own, found by its grade_id: an edited check is
of no help, a deleted one costs its points.
"""

import asyncio
import csv
from pathlib import Path
from typing import NamedTuple

import nbformat
from tqdm import tqdm

from mkt.book.execute import KERNELS
from mkt.labs.kernel import UNWRITTEN, kernel, run
from mkt.labs.notebooks import HANDOUT, STUBS, headings, labs, name, of_role, points, released


class Mark(NamedTuple):
    """A check's grade_id, the points it gave and those it can give, and why it gave none, in words."""

    check: str
    points: float
    of: float
    words: str


class Submission(NamedTuple):
    """A file that a student handed in; lab: the name of the lab, None where the file's name has none in it."""

    student: str
    lab: str | None
    path: Path


def marks(lab, notebook, failures):
    """The marks of the checks of a lab, as a list of `Mark`; failures: what `mkt.labs.kernel.run` said of the notebook."""
    present, result = of_role(notebook, "check"), []
    for check, cell in of_role(lab, "check").items():
        words = failures.get(check, "") if check in present else "this check is missing from the notebook"
        result.append(Mark(check, 0 if words else points(cell), points(cell), words))
    return result


def merged(lab, notebook):
    """A student's notebook with the checks and given cells of the lab in place of its own."""
    ours = of_role(lab, "check", "given")
    return nbformat.v4.new_notebook(cells=[ours.get(name(cell), cell) for cell in notebook.cells])


def unanswered(notebook):
    """The questions that still end with the stub, or are empty."""
    return [question for question, cell in of_role(notebook, "question").items() if not cell.source.strip() or cell.source.rstrip().endswith(STUBS["markdown"])]


def faults(notebook, failures):
    """What went wrong outside the checks, in words, without what only follows: in the cells that the student writes, and in whatever failed first."""
    where, written, first = headings(notebook), of_role(notebook, "solution"), next(iter(failures), None)
    told = (written | {first: None}).keys() - of_role(notebook, "check").keys()
    return [f"{where[cell]}: {words}" for cell, words in failures.items() if cell in told and words != UNWRITTEN]


async def _failures(notebook, limit):
    async with kernel(limit) as client:
        return await run(client, notebook.cells)


def check(path, limit=60):
    """Run a student's notebook with the checks that it has, and say how each went; limit: seconds a cell may take.

    path: of the notebook, also as seen from notebooks/handout.  Returns lines of text, and whether all checks gave their points.
    Raises ValueError for a file that is no lab, or not there.
    """
    notebook = _read(_found(path))
    if not of_role(notebook, "check"):
        raise ValueError(f"{path}: this notebook has no checks; `python3 -m mkt labs release` makes notebooks that have")
    failures = asyncio.run(_failures(notebook, limit))
    results = marks(notebook, notebook, failures)
    lines = [f"{mark.points:3g} of {mark.of:g}  {mark.check}" + (f": {mark.words}" if mark.words else "") for mark in results]
    lines += [f"  ? of {points(cell):g}  {question}: " + ("not answered yet" if question in unanswered(notebook) else "a person reads your answer")
              for question, cell in of_role(notebook, "question").items()]
    lines += faults(notebook, failures)
    to_read = sum(points(cell) for cell in of_role(notebook, "question").values())
    read = f", and {to_read:g} for what a person reads" if to_read else ""
    lines.append(f"{sum(mark.points for mark in results):g} of {sum(mark.of for mark in results):g} points so far{read}; the hidden checks may find more")
    return lines, all(not mark.words for mark in results)


def _found(path):
    for place in (path, HANDOUT / path):
        if place.is_file():
            return place
    raise ValueError(f"{path}: there is no such file, seen from this folder or from {HANDOUT}; `python3 -m mkt labs release` writes the labs into that one")


def submissions(folder, names):
    """The notebooks handed in: STUDENT/[.../]LAB.ipynb, as nbgrader's ``submitted`` has them, or STUDENT_LAB.ipynb; names: of the labs.

    The name of the lab may stand anywhere in that of the file.  Returns a list of `Submission`.
    """
    paths = [path for path in sorted(folder.rglob("*.ipynb")) if ".ipynb_checkpoints" not in path.parts]
    return [_submission(folder, path, next((lab for lab in names if lab in path.stem), None)) for path in paths]


def _submission(folder, path, lab):
    parts = path.relative_to(folder).parts
    student = parts[0] if len(parts) > 1 else path.stem.partition(lab or path.stem)[0].strip("_- ")
    return Submission(student or folder.resolve().name, lab, path)


def grade(folder, output, limit=60):
    """Grade all notebooks of a folder, see `submissions`, and write a row for each into a CSV file, as soon as it is known.

    A row has the points of each check, their sum, the points of the questions that a person has to read, the answers, and a note on what
    went wrong.  This executes what the students wrote.  limit: seconds a cell may take.  Raises ValueError where there is nothing to grade.
    """
    sources = labs()
    found = submissions(folder, sources)
    if not found:
        raise ValueError(f"{folder}: no notebooks in there; it takes STUDENT/LAB/LAB.ipynb, STUDENT/LAB.ipynb or STUDENT_LAB.ipynb")
    checks = [check for lab in sources if lab in {one.lab for one in found} for check in of_role(sources[lab], "check")]
    with open(output, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, ["student", "lab", "points", "of", "to_read", *checks, "note", "answers", "file"])
        writer.writeheader()

        def write(row):
            writer.writerow(row)
            file.flush()

        asyncio.run(_grade_all(found, sources, limit, write))


async def _grade_all(found, sources, limit, write):
    gate = asyncio.Semaphore(KERNELS)

    async def one(submission):
        async with gate:
            write(await _row(submission, sources.get(submission.lab), limit))
            bar.update()

    with tqdm(total=len(found), desc="submissions", disable=None) as bar:
        await asyncio.gather(*(one(submission) for submission in found))


async def _row(submission, lab, limit):
    """The row of one submission, whatever it is."""
    row = {"student": submission.student, "lab": submission.lab, "file": str(submission.path)}
    if lab is None:
        return row | {"note": "of no lab: the name of the file must have that of the lab in it"}
    try:
        return row | await _graded(lab, submission.path, limit)
    except Exception as error:  # whatever is wrong with one file must not stop the others
        of = sum(points(cell) for cell in of_role(lab, "check").values())
        return row | {"points": 0, "of": of, "to_read": 0, "note": f"cannot be graded: {type(error).__name__}: {error}"}


async def _graded(lab, path, limit):
    """What a row says about a notebook that can be read."""
    handed_in = _read(path)
    notebook = merged(lab, handed_in)
    failures = await _failures(notebook, limit)
    results, open_questions = marks(lab, notebook, failures), unanswered(notebook)
    answers = {question: cell for question, cell in of_role(notebook, "question").items() if question not in open_questions}
    row = {mark.check: mark.points for mark in results}
    row |= {"points": sum(row.values()), "of": sum(mark.of for mark in results), "to_read": sum(points(cell) for cell in answers.values())}
    return row | {"note": _note(lab, handed_in, results, failures), "answers": "\n\n".join(f"{question}: {cell.source}" for question, cell in answers.items())}


def _note(lab, handed_in, results, failures):
    """What went wrong with a submission, in words."""
    ours = of_role(released(lab), "check", "given")
    notes = [f"{name(cell)}: was edited, the original counts" for cell in handed_in.cells
             if name(cell) in ours and cell.source.strip() != ours[name(cell)].source.strip()]
    answered = of_role(handed_in, "question").keys() - set(unanswered(handed_in))
    notes += [f"{question}: not answered" for question in of_role(lab, "question") if question not in answered]
    notes += faults(merged(lab, handed_in), failures)
    return "; ".join(notes + [f"{mark.check}: {mark.words}" for mark in results if mark.words])


def _read(path):
    """A notebook from a file.  Raises ValueError where it is none."""
    try:
        notebook = nbformat.read(path, 4)
        nbformat.validate(notebook)
        return notebook
    except OSError:
        raise
    except Exception as error:  # nbformat raises about anything for a file that is none
        raise ValueError(f"{path} is not a notebook: {str(error).splitlines()[0]}") from None
