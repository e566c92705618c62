"""Points for all that was handed in: ``labs grade``, a table and a page for each.

The table is only ever written here.  A row that it has stays as it is, with what a
teacher has typed into it, even while this runs, so that a run that was stopped can be
started again; only its state, and what its note says of other files, are said anew.  A
file that was handed in again has another row; the older ones have the state "older",
those of files that are not there any more "gone", and none of them has a page.
"""

import re
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from nbformat import NotebookNode
from tqdm import tqdm

from mkt.course.labs import LIMIT, pages, sandbox, table
from mkt.course.labs.alike import compared, is_blank
from mkt.course.labs.borrowed import borrowed
from mkt.course.labs.judge import end_all
from mkt.course.labs.marks import (
    answers,
    edited,
    failures_of,
    faults,
    marks,
    merged,
    missing,
    other_text,
    reasons,
    title_of,
)
from mkt.course.labs.marks import read as read_notebook
from mkt.course.labs.notebooks import of_role, points, solved
from mkt.course.labs.submissions import (
    BESIDE,
    NOTHING,
    Submission,
    coincidences,
    handed_in,
)
from mkt.course.labs.sums import Labs, counts, sum_up, unread
from mkt.course.labs.table import COLUMNS, FORMERLY, GONE, OLDER, Row
from mkt.course.labs.variants import written_name
from mkt.files import alone, existing_folder, new_file

AT_ONCE = 2  # submissions, each of which has two processes
OFTEN = 0.2  # [s] between two looks at those that are to end
OURS = "not graded, and not by the student's fault"
UNREAD = "this file cannot be read: save the notebook again and hand it in"
UNANSWERED = "not answered"
# Which a person has to read.
IN_ANOTHER_PLACE = "not answered in its place; other text of the student's:"
BEGINNING = 200  # [letters] of it in the note; all of it is among the answers
NAMELESS = "no student's name in that of the file; the folder's stands for it"
Odd = Mapping[Path, list[str]]


def grade(
    folder: Path,
    output: Path,
    limit: float = LIMIT,
    *,
    trusted: bool = False,
    comma: str | None = None,
) -> list[str]:
    """Grade all notebooks of a folder into a table, and a page for each beside it.

    Which these are `mkt.course.labs.submissions` says.  A row has the points of each
    check and their sum, an empty place for those of each question that a person reads,
    the answers, and a note on what went wrong.

    Parameters
    ----------
    folder, output : Path
    limit : float [s]
        What a cell or a check may take.
    trusted : bool
        Whether the students' code may run without bubblewrap's box.
    comma : str, optional
        What stands between two cells of the table; as in a table that is there, or a
        comma.

    Returns
    -------
    list of str
        What could not be graded through a failure that is not the student's.

    Raises
    ------
    ValueError
        Where there is nothing to grade, no box, no labs with their solutions, another
        file in the table's place, or something else than points typed into it.
    InterruptedError
        At Ctrl-C; it says what is in the table.
    """
    if not trusted and (why := sandbox.refusal()):
        raise ValueError(f"{why}; or say --trust-the-students")
    # Both refuse what is not there, before anything is written.
    folder = existing_folder(folder)
    _rows_so_far(output)
    grader = _Grader(solved(), limit, boxed=not trusted)
    with (
        alone(pages.lock_of(output), "grading"),
        tempfile.TemporaryDirectory(prefix="mkt-labs-") as copies,
    ):
        ours = output, *pages.beside(output)
        found = handed_in(folder, grader.sources, Path(copies), ours)
        found = [_recognised(one, grader.sources) for one in found]
        rows = _graded(found, output, grader, comma)
    troubles = [row for row in rows if counts(row) and row["note"].startswith(OURS)]
    _name_unmarked([row for row in rows if row not in troubles])
    return [f"{row['file']}: {row['note']}" for row in troubles]


def _graded(
    found: list[Submission], output: Path, grader: "_Grader", comma: str | None
) -> list[Row]:
    """The rows of a table that has all of these submissions, as it was written."""
    sources = grader.sources
    odd = _odd(found, sources)
    rows = _rows_so_far(output)
    before = [_on_page(row) for row in rows]
    rows = _without_late(rows, found)
    _tell(rows, found, odd)
    done = {_version(row) for row in rows if not row["note"].startswith(OURS)}
    if rows:
        _write(output, rows, [], sources, comma)
    try:
        for row in grader.rows([one for one in found if _key(one) not in done]):
            rows = _rows_so_far(output) if rows else []
            _carry_over(row, rows, sources)
            _tell([row], found, odd)
            rows = [one for one in rows if _version(one) != _version(row)] + [row]
            _write(output, rows, [row], sources, comma)
        rows = _rows_so_far(output) if rows else []
        sum_up(rows, sources)
        changed = [
            row
            for row in rows
            if _on_page(row) not in before or not pages.is_there(output, row)
        ]
        _write(output, rows, changed, sources, comma)
        pages.remove_others(output, rows)
    except KeyboardInterrupt:
        state = f"has {len(rows)} rows" if rows else "was not begun"
        raise InterruptedError(
            f"stopped: {output} {state}; the same command goes on from there"
        ) from None
    return rows


def _name_unmarked(rows: Iterable[Row]) -> None:
    """Say which of the rows that count have no marks."""
    unmarked = [row for row in rows if counts(row) and not row["points"]]
    if unmarked:
        files = ", ".join(row["file"] for row in unmarked)
        print(f"no marks, see the notes in the table: {files}", file=sys.stderr)


def _on_page(row: Row) -> Row:
    """What the page of a row depends on."""
    note = "\n".join(pages.for_students(row))
    return {key: text for key, text in row.items() if text} | {"note": note}


def merge(output: Path) -> None:
    """Sum up a table that a teacher has typed points into, and write the pages anew.

    It names the rows that have no total yet.  Pages of rows with a total show the model
    answers now, and not before: as long as work is handed in, one such page would give
    the lab away.

    Raises
    ------
    ValueError
        Where there is no table, or no column of its states, or something else than
        points in it, and where there are no labs with their solutions.
    """
    if not output.is_file():
        raise ValueError(f"{output}: there is no such table; `labs grade` makes it")
    sources = solved()
    with alone(pages.lock_of(output), "grading"):
        rows = _rows_so_far(output)
        if not all("state" in row for row in rows):
            raise ValueError(
                f"{output}: no column is called state; `labs grade` writes it anew"
            )
        _write(output, rows, rows, sources, None, models=True)
        pages.remove_others(output, rows)
    if waiting := list(filter(None, (unread(row, sources) for row in rows))):
        whose = "; ".join(waiting)
        print(f"no total yet, points missing: {whose}", file=sys.stderr)


def _rows_so_far(output: Path) -> list[Row]:
    if output.exists():
        return table.read(output)
    new_file(output)
    return []


def _without_late(rows: list[Row], found: Iterable[Submission]) -> list[Row]:
    """The rows without those of nothing where there is something now.

    But for what a teacher has written into such a row.
    """
    there = dict(map(_key, found))
    return [
        row
        for row in rows
        if row["note"] != NOTHING or row["file"] in there or _has_more(row)
    ]


def _has_more(row: Row) -> bool:
    """Whether there is more in a row than a file, its student and a note."""
    ours = "student", "file", "state", "note"
    more = any(text for name, text in row.items() if name not in ours)
    return more or row["student"] != row["file"]


def _tell(rows: list[Row], found: Iterable[Submission], odd: Odd) -> None:
    """Say in each row whether its file has been handed in again, or is gone.

    The notes of the other rows, which count, say what is odd about their files now.
    """
    newest = dict(map(_key, found))
    now = {
        table.harmless(str(path)): [*map(table.harmless, lines)]
        for path, lines in odd.items()
    }
    for row in rows:
        if not row["file"]:  # a teacher's own, such as one of averages
            continue
        lines = [one for one in row["note"].splitlines() if one not in FORMERLY]
        row["note"] = "\n".join(lines)
        if row["file"] not in newest:
            row["state"] = GONE
        elif row["sha256"] != newest[row["file"]]:
            row["state"] = OLDER
        else:
            row["state"] = ""
            if not row["note"].startswith(OURS):
                said = now.get(row["file"], [])
                rest = [one for one in lines if not _is_of_files(one)]
                new = [one for one in rest if one not in said]
                row["note"] = "\n".join(said + new)


def _is_of_files(line: str) -> bool:
    """Whether a line says what is odd, and no teacher has written behind the files.

    They are notebooks, and perhaps in no row: it may have been taken away.
    """
    files = r".* .*\.(?i:ipynb)( and \d+ more)?"
    return any(re.fullmatch(re.escape(words) + files, line) for words in BESIDE)


def _carry_over(row: Row, rows: list[Row], sources: Labs) -> None:
    """Give a new row what was typed for this file, or an older one with its answers.

    That is also one under another name: files are moved, and given other names.  Where
    points were typed for other answers of this file alone, it has a note.  Of a row
    that had failed through us all stays that the new one has not.
    """
    for old in rows:
        if _version(old) == _version(row):
            kept = [key for key in old if key != "note" and not row.get(key)]
            row |= {key: old[key] for key in kept}
    questions = of_role(sources[row["lab"]], "question") if row["lab"] else ()
    same_file = [old for old in rows if old["file"] == row["file"]]
    whose = row["student"], row["lab"]
    moved = [  # and read: what could not be is no more alike than anything else
        old
        for old in rows
        if old not in same_file
        and (old["student"], old["lab"]) == whose
        and old["sha256"]
        and row["sha256"]
    ]
    for one in questions:
        typed = [
            old
            for old in moved + same_file  # what was typed for the file itself counts
            if old.get(one) and f"{one}: {UNANSWERED}" not in old["note"].splitlines()
        ]
        same = [
            old[one]
            for old in typed
            if old["sha256"] == row["sha256"] or old["answers"] == row["answers"]
        ]
        if same:
            row[one] = same[-1]
        elif any(old["file"] == row["file"] for old in typed):
            lines = dict.fromkeys([*row["note"].splitlines(), pages.TYPED_ELSEWHERE])
            row["note"] = "\n".join(lines)


def _write(
    output: Path,
    rows: list[Row],
    new: list[Row],
    sources: Labs,
    comma: str | None,
    *,
    models: bool = False,
) -> None:
    """Write the table with its totals, and the pages of its new rows.

    Without a separator it has that of the table that is there, or a comma.
    """
    comma = comma or (table.separator(output) if output.exists() else ",")
    sum_up(rows, sources)
    table.write(output, _columns(rows, sources), rows, comma)
    for row in new:
        if not counts(row):
            pages.remove(output, row)
        elif row["lab"] in sources:
            pages.write(output, row, sources[row["lab"]], models)
    present = {row["lab"] for row in rows}
    in_it = {title: lab for title, lab in sources.items() if title in present}
    pages.write_rubrics(output, in_it)


def _columns(rows: list[Row], sources: Labs) -> list[str]:
    """The columns of the table: all checks and questions of the labs that it has.

    Behind them are those that a teacher has added.
    """
    before, after = COLUMNS
    present = {row["lab"] for row in rows}
    pieces = [
        of_role(lab, "check", "question")
        for title, lab in sources.items()
        if title in present
    ]
    ours = [*before, *(one for each in pieces for one in each), *after]
    return list(dict.fromkeys([*ours, *(one for row in rows for one in row)]))


def _recognised(one: Submission, sources: Labs) -> Submission:
    """A submission with the lab that its cells are of, whatever the file is called."""
    if one.copy is None:
        return one
    try:
        title = title_of(read_notebook(one.copy), sources)
    except Exception:  # `_Grader.row` says what is wrong with it
        return one
    return replace(one, lab=title or one.lab)


def _odd(found: Iterable[Submission], sources: Labs) -> Odd:
    """What is odd about submissions beside one another, where they can be read."""
    names, work = {}, {}
    blank = set()
    for one in found:
        with suppress(Exception):  # one failure must not stop the others
            if one.copy and one.lab:
                notebook = read_notebook(one.copy)
                names[one.path] = written_name(notebook)
                work[one.path] = compared(sources[one.lab], notebook)
                if is_blank(sources[one.lab], notebook):
                    blank.add(one.path)
    return coincidences(found, names, work, blank)


def _unanswered(aside: str) -> str:
    """What is said of a question without an answer, and of text in other places."""
    beginning = " ".join(aside[: 10 * BEGINNING].split())[:BEGINNING]
    return f"{IN_ANOTHER_PLACE} {beginning}" if aside else UNANSWERED


def _key(one: Submission) -> tuple[str, str]:
    """By what a row recognises a submission."""
    return table.harmless(str(one.path)), one.sha256


def _version(row: Row) -> tuple[str, str]:
    """Which version of which file a row is of."""
    return row["file"], row["sha256"]


class _Grader:
    """Makes rows of submissions.

    Parameters
    ----------
    sources : dict
        The labs by name.
    limit : float [s]
    boxed : bool
    """

    def __init__(self, sources: Labs, limit: float, *, boxed: bool):
        self.sources, self.limit, self.boxed = sources, limit, boxed

    def rows(self, found: list[Submission]) -> Iterable[Row]:
        """The rows of submissions, as they come."""
        with ThreadPoolExecutor(AT_ONCE) as pool:
            futures = [pool.submit(self.row, one) for one in found]
            try:
                bar = tqdm(total=len(found), desc="submissions", disable=None)
                for future in as_completed(futures):
                    row = future.result()
                    yield {key: table.harmless(text) for key, text in row.items()}
                    bar.update()
                bar.close()
            finally:
                pool.shutdown(wait=False, cancel_futures=True)
                # A signal to this process alone has not reached the judges.
                while not all(future.done() for future in futures):
                    end_all()
                    time.sleep(OFTEN)

    def row(self, one: Submission) -> Row:
        """The row of one submission, whatever it is."""
        file, sha256 = _key(one)
        row = dict.fromkeys([*COLUMNS[0], *COLUMNS[1]], "")
        row |= {"student": one.student, "lab": one.lab or ""}
        row |= {"file": file, "sha256": sha256, "note": one.trouble}
        if one.copy is None:
            return row
        if one.lab is None:
            note = "of no lab: neither its name nor its cells are those of one"
            return row | {"note": note}
        try:
            lab = self.sources[one.lab]
            return row | self.graded(one, one.copy, lab)
        except Exception as error:  # one failure must not stop the others
            return row | {"note": f"{OURS}: {type(error).__name__}: {error}"}

    def graded(self, one: Submission, copy: Path, lab: NotebookNode) -> Row:
        """What a row says about a notebook."""
        try:
            notebook = read_notebook(copy)
        except ValueError as error:
            return {"note": f"{UNREAD}: {error}".replace(str(copy), one.path.name)}
        maxima = [points(cell) for cell in of_role(lab, "check").values()]
        manual = [points(cell) for cell in of_role(lab, "question").values()]
        most = {"of": f"{sum(maxima):g}", "maximum": f"{sum(maxima + manual):g}"}
        failures = failures_of(lab, notebook, self.limit, boxed=self.boxed)
        results = marks(lab, failures)
        said = answers(lab, notebook)
        questions = of_role(lab, "question")
        aside = other_text(lab, notebook) if questions.keys() - said else ""
        texts = said | ({"elsewhere": aside} if aside else {})
        renamed = f"not called after its lab, {one.lab}, but its cells are of it"
        notes = [
            *([] if str(one.lab).lower() in one.path.stem.lower() else [renamed]),
            *([] if one.named else [NAMELESS]),
            *(f"{one}: {_unanswered(aside)}" for one in questions if one not in said),
            *missing(lab, notebook),
            *edited(lab, notebook),
            *faults(merged(lab, notebook), failures),
            *reasons(results),
            *borrowed(lab, notebook),
        ]
        written = {
            "note": "\n".join(notes),
            "answers": "\n\n".join(f"{one}: {text}" for one, text in texts.items()),
        }
        return (
            most
            | {mark.check: f"{mark.points:g}" for mark in results}
            | {one: "" if one in said or aside else "0" for one in questions}
            | {"points": f"{sum(mark.points for mark in results):g}"}
            | written
        )
