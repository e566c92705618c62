"""Points for labs: `check` one notebook for a student, `grade` a folder of them for a teacher.

A submission runs as the student left it, but each check and given cell is replaced by the lab's own, found by its grade_id: an edited check is
of no help, a deleted one costs its points.  Cells that must fail are run last, and tell when asserts no longer do; that is no proof against intent.
"""

import asyncio
import csv
import warnings
from pathlib import Path
from typing import NamedTuple

import nbformat
from tqdm import tqdm

from mkt.book.execute import KERNELS
from mkt.files import whole
from mkt.labs.kernel import NOT_RUN, UNWRITTEN, kernel, run
from mkt.labs.notebooks import HANDOUT, STUBS, headings, labs, name, of_role, points, released

ASIDE = {"__pycache__", "__MACOSX", "timestamp.txt"}  # what systems and nbgrader leave beside what was handed in
MUST_FAIL = [nbformat.v4.new_code_cell(f"assert {wrong}") for wrong in (
    "False", "all([False])", "abs(1) == 0", "np.all([False])", "np.isclose(0, 1)", "np.allclose([0, 1], [0, 2])", "np.array_equal([0], [1])")]


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
    """A student's notebook with the checks and given cells of the lab in place of its own, under the ids that they have there."""
    ours = of_role(lab, "check", "given")
    return nbformat.v4.new_notebook(cells=[nbformat.from_dict(ours.get(name(cell), cell) | {"id": cell.id}) for cell in notebook.cells])


def answers(lab, notebook):
    """What a student wrote to each question, {grade_id: text}: in its cell, without the lab's own lines, and in text cells of the student's own below it."""
    ours = {line.strip() for cell in released(lab).cells for line in cell.source.splitlines()}
    said, question = {}, None
    for cell in notebook.cells:
        question = name(cell) if name(cell) in of_role(lab, "question") else question
        if question and (cell.cell_type == "markdown" or name(cell) == question):
            said[question] = said.get(question, []) + [line for line in cell.source.splitlines() if line.strip() not in ours]
    return {question: "\n".join(lines) for question, lines in said.items() if lines}


def faults(notebook, failures):
    """What went wrong outside the checks, in words, without what only follows: in the cells that the student writes, and in whatever failed first."""
    where, written, first = headings(notebook), of_role(notebook, "solution"), next(iter(failures), None)
    told = (written | {first: None}).keys() - of_role(notebook, "check").keys()
    return [f"{where[cell]}: {words}" for cell, words in failures.items() if cell in told and words != UNWRITTEN and not words.startswith(NOT_RUN)]


async def _failures(cells, limit):
    async with kernel(limit) as client:
        return await run(client, cells)


def check(path, limit=60):
    """Run a student's notebook with the checks that it has, and say how each went; limit: seconds a cell may take.

    path: of the notebook, also as seen from notebooks/handout.  Returns lines of text, and whether all checks gave their points.
    Raises ValueError for a file that is no lab, or not there.
    """
    notebook = _read(_found(path))
    if not of_role(notebook, "check"):
        raise ValueError(f"{path}: this notebook has no checks; `python3 -m mkt labs release` makes notebooks that have")
    failures = asyncio.run(_failures(notebook.cells, limit))
    results = marks(notebook, notebook, failures)
    lines = [f"{mark.points:3g} of {mark.of:g}  {mark.check}" + (f": {mark.words}" if mark.words else "") for mark in results]
    lines += [f"  ? of {points(cell):g}  {question}: " + ("a person reads your answer" if _answered(cell) else f"no answer yet, it goes in the place of {STUBS['markdown']}")
              for question, cell in of_role(notebook, "question").items()]
    lines += faults(notebook, failures)
    to_read = sum(points(cell) for cell in of_role(notebook, "question").values())
    read = f", and {to_read:g} for what a person reads" if to_read else ""
    lines.append(f"{sum(mark.points for mark in results):g} of {sum(mark.of for mark in results):g} points so far{read}; the hidden checks may find more")
    return lines, all(not mark.words for mark in results)


def _answered(question):
    return question.source.strip() and not question.source.rstrip().endswith(STUBS["markdown"])


def _found(path):
    for place in (path, HANDOUT / path):
        if place.is_file():
            return place
    raise ValueError(f"{path}: there is no such file, seen from this folder or from {HANDOUT}; `python3 -m mkt labs release` writes the labs into that one")


def submissions(folder, names):
    """The files handed in: STUDENT/[.../]LAB.ipynb, as nbgrader's ``submitted`` has them, or STUDENT_LAB.ipynb; names: of the labs.

    The name of the lab may stand anywhere in that of the file.  Returns a list of `Submission`, also of files that are no notebooks, but not of hidden ones.
    """
    inside = [path.relative_to(folder) for path in sorted(folder.rglob("*")) if path.is_file()]
    paths = [folder / path for path in inside if not any(part.startswith(".") or part in ASIDE for part in path.parts)]
    return [_submission(folder, path, next((lab for lab in names if lab in path.stem), None)) for path in paths]


def _submission(folder, path, lab):
    parts = path.relative_to(folder).parts
    student = parts[0] if len(parts) > 1 else path.stem.partition(lab or path.stem)[0].strip("_- ")
    return Submission(student or folder.resolve().name, lab, path)


def grade(folder, output, limit=60):
    """Grade all notebooks of a folder, see `submissions`, into a new CSV file with a row for each, sorted by student and lab; it grows row by row.

    A row has the points of each check, their sum, the points of the questions that a person has to read, the answers, and a note on what
    went wrong.  This executes what the students wrote.  limit: seconds a cell may take.  Raises ValueError where there is nothing to grade or
    the table is there already, InterruptedError that says what is in the table at Ctrl-C.
    """
    sources, rows = labs(), []
    _can_make(output)
    found = _handed_in(folder, sources)
    checks = [check for lab in sources if lab in {one.lab for one in found} for check in of_role(sources[lab], "check")]
    columns = ["student", "lab", "points", "of", "to_read", *checks, "note", "answers", "file"]

    def keep(row):
        rows.append(row)
        _write(output, columns, rows)

    try:
        asyncio.run(_grade_all(found, sources, limit, keep))
    except KeyboardInterrupt:
        raise InterruptedError(f"stopped: {output} " + (f"has {len(rows)} of {len(found)} rows" if rows else "was not begun")) from None


def _can_make(output):
    if output.exists():
        raise ValueError(f"-o {output}: it is there already, perhaps with marks that you typed; choose another name, or remove it")
    if not output.parent.is_dir():
        raise ValueError(f"-o {output}: there is no folder {output.parent}; make it first, or choose another place")


def _handed_in(folder, names):
    if not folder.is_dir():
        raise ValueError(f"{folder}: " + ("this is a file; give the folder that it is in" if folder.exists() else "there is no such folder"))
    found = submissions(folder, names)
    if not any(_is_notebook(one.path) for one in found):
        raise ValueError(f"{folder}: no notebooks in there; it takes STUDENT/LAB/LAB.ipynb, STUDENT/LAB.ipynb or STUDENT_LAB.ipynb")
    return found


def _is_notebook(path):
    return path.suffix.lower() == ".ipynb"


def _write(output, columns, rows):
    """The table as a whole; its first mark (utf-8-sig) tells spreadsheets how to read umlauts."""
    with whole(output) as half, open(half, "w", newline="", encoding="utf-8-sig") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(sorted(rows, key=lambda row: (row["student"], row["lab"] or "", row["file"])))


async def _grade_all(found, sources, limit, keep):
    gate = asyncio.Semaphore(KERNELS)

    async def one(submission):
        async with gate:
            keep(await _row(submission, sources.get(submission.lab), limit))
            bar.update()

    with tqdm(total=len(found), desc="submissions", disable=None) as bar:
        await asyncio.gather(*(one(submission) for submission in found))


async def _row(submission, lab, limit):
    """The row of one submission, whatever it is."""
    row = {"student": submission.student, "lab": submission.lab, "file": str(submission.path)}
    if not _is_notebook(submission.path):
        return row | {"note": f"not a notebook: {submission.path.suffix or submission.path.name}"}
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
    failures = await _failures([*merged(lab, handed_in).cells, *MUST_FAIL], limit)
    genuine = all([failures.pop(name(cell), "") for cell in MUST_FAIL])
    results, said, questions = marks(lab, handed_in, failures), answers(lab, handed_in), of_role(lab, "question")
    row = {mark.check: mark.points for mark in results}
    row |= {"points": sum(row.values()), "of": sum(mark.of for mark in results), "to_read": sum(points(questions[question]) for question in said)}
    notes = [] if genuine else ["the checks were tampered with: read this notebook"]
    notes += [f"{question}: not answered" for question in questions if question not in said]
    notes += _edited(lab, handed_in) + faults(merged(lab, handed_in), failures) + _why(results)
    return row | {"note": "; ".join(notes), "answers": "\n\n".join(f"{question}: {text}" for question, text in said.items())}


def _edited(lab, handed_in):
    ours = of_role(released(lab), "check", "given")
    return [f"{name(cell)}: was edited, the original counts" for cell in handed_in.cells
            if name(cell) in ours and cell.source.strip() != ours[name(cell)].source.strip()]


def _why(results):
    """Why checks gave no points, in words; those that were not run in one sentence."""
    idle = [mark.words for mark in results if mark.words.startswith(NOT_RUN)]
    words = [f"{mark.check}: {mark.words}" for mark in results if mark.words and mark.words not in idle]
    return words + [f"{idle[0].removeprefix(NOT_RUN)}, and {len(idle)} check{'s were' if len(idle) > 1 else ' was'} not run"] if idle else words


def _read(path):
    """A notebook from a file; copied cells, and those of old files, get ids of their own.  Raises ValueError where it is none."""
    try:
        with warnings.catch_warnings(action="ignore"):  # they name no file, and what they are about is mended
            notebook = nbformat.v4.upgrade(nbformat.read(path, 4))
            nbformat.validate(notebook)
        return notebook
    except OSError:
        raise
    except Exception as error:  # nbformat raises about anything for a file that is none
        raise ValueError(f"{path} is not a notebook: {str(error).splitlines()[0]}") from None
