"""A made-up lab of two functions and a question, and students who hand it in."""

import csv

import nbformat

from mkt.course import cli
from mkt.course.labs import sandbox, table
from mkt.course.labs.notebooks import released


def meta(name, solution, grade, points=None):
    """nbgrader's metadata of a cell."""
    more = {} if points is None else {"points": points}
    return {
        "nbgrader": {
            "schema_version": 3,
            "grade_id": name,
            "solution": solution,
            "grade": grade,
            "locked": grade and not solution,
            "task": False,
        }
        | more
    }


ADD = "def add(a, b):\n    ### BEGIN SOLUTION\n    return a + b\n    ### END SOLUTION"
CHECK = """\
assert add(1, 2) == 3, f'1 + 2 is 3, not {add(1, 2)}'
### BEGIN HIDDEN TESTS
assert add(2, 2) == 4, '2 + 2 is 4'
### END HIDDEN TESTS"""
TOY = nbformat.v4.new_notebook(
    cells=[
        nbformat.v4.new_code_cell(ADD, id="add", metadata=meta("add", True, False)),
        nbformat.v4.new_code_cell(
            CHECK, id="check-add", metadata=meta("check_add", False, True, 2)
        ),
        nbformat.v4.new_code_cell(
            "def six():\n    ### BEGIN SOLUTION\n    return 6\n    ### END SOLUTION",
            id="six",
            metadata=meta("six", True, False),
        ),
        nbformat.v4.new_code_cell(
            "assert six() == 6, 'six is 6'",
            id="check-six",
            metadata=meta("check_six", False, True, 1),
        ),
        nbformat.v4.new_markdown_cell(
            "Why?\n\n### BEGIN SOLUTION\nBecause.\n### END SOLUTION",
            id="why",
            metadata=meta("why", True, True, 3),
        ),
    ]
)


def answer(**sources):
    """The toy lab as a student hands it in, with these sources of cells.

    None deletes a cell.
    """
    student = released(TOY)
    for cell in student.cells:
        cell.source = sources.get(cell.id.replace("-", "_"), cell.source)
    student.cells = [cell for cell in student.cells if cell.source is not None]
    return student


GOOD = {
    "add": "def add(a, b):\n    return a + b",
    "six": "def six():\n    return 6",
    "why": "Why?\n\nI do not know.",
}


def hand_in(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        text if isinstance(text, str) else nbformat.writes(text), encoding="utf-8"
    )


def graded(folder, output, *words):
    """The rows of the table that `labs grade` writes, {student: row}."""
    if not sandbox.program():
        words = (*words, "--trust-the-students")
    command = ["labs", "grade", str(folder), "-o", str(output), *words]
    assert not cli.run(cli.parse(command))
    return rows(output)


def rows(output):
    """The rows of a table, {student: row}."""
    with output.open(newline="", encoding="utf-8-sig") as file:
        found = csv.DictReader(file, delimiter=table.separator(output))
        return {row["student"]: row for row in found}
