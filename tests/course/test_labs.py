"""The labs: what solutions, empty labs and wrong answers get, and what is handed in.

The commands survive whatever that is.
"""

import ast
import asyncio
import copy
import csv
import functools
import json
import tomllib
from pathlib import Path

import nbformat
import pytest

from mkt.course import cli
from mkt.course.book import checks
from mkt.course.labs import grading, marks, notebooks
from mkt.course.labs.notebooks import STUBS, of_role, points, released
from mkt.course.labs.process import UNWRITTEN, kernel, run

LABS = notebooks.labs()
each_lab = pytest.mark.parametrize("lab", LABS)


def wrong_answers(lab):
    """{title: what a student might write, and which checks must notice it}."""
    path = Path(__file__).parent / "labs" / f"{lab}.toml"
    if not path.is_file():
        return {}
    mistakes = tomllib.loads(path.read_text(encoding="utf-8"))["mistake"]
    return {mistake["title"]: mistake for mistake in mistakes}


def returning_nothing(lab):
    """(title, cell, code) of each function to write, as if its return were forgotten.

    The title is what a check must say.
    """
    return [
        (
            f"{node.name} returns nothing: is there a `return`",
            cell,
            f"{solution.source}\n\n\ndef {node.name}(*_, **__):\n    pass",
        )
        for cell, solution in of_role(lab, "solution").items()
        for node in ast.parse(solution.source).body
        if isinstance(node, ast.FunctionDef)
    ]


@functools.cache
def tried(lab):
    """What failed in the empty lab, in the solved one, and with each wrong answer.

    As {title: {cell: words}}, all in one kernel.
    """
    return asyncio.run(_tried(LABS[lab], wrong_answers(lab)))


async def _tried(lab, mistakes):
    async with kernel() as client:
        result = {
            "empty": await run(client, released(lab).cells),
            "solved": await run(client, lab.cells),
        }
        wrong = [(title, one["cell"], one["code"]) for title, one in mistakes.items()]
        for title, cell, code in wrong + returning_nothing(lab):
            solution = of_role(lab, "solution")[cell]
            answer = nbformat.from_dict(solution | {"source": code})
            result[title] = await run(client, [answer, *of_role(lab, "check").values()])
            await run(client, [solution])
        return result


def lost(lab, failures):
    given = marks.marks(LABS[lab], LABS[lab], failures)
    return [mark.check for mark in given if mark.words]


# The labs


@pytest.mark.slow
@each_lab
def test_the_solution_gets_full_marks_and_every_cell_of_it_runs(lab):
    assert tried(lab)["solved"] == {}


@pytest.mark.slow
@each_lab
def test_the_empty_lab_gets_no_points_and_every_check_says_that_something_is_not_written(  # noqa: E501
    lab,
):
    given = marks.marks(LABS[lab], LABS[lab], tried(lab)["empty"])
    assert [mark for mark in given if mark.points or mark.words != UNWRITTEN] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "lab, title", [(lab, title) for lab in LABS for title in wrong_answers(lab)]
)
def test_a_typical_wrong_answer_loses_its_points_and_no_others(lab, title):
    assert lost(lab, tried(lab)[title]) == wrong_answers(lab)[title]["loses"]


@pytest.mark.slow
@each_lab
def test_a_forgotten_return_is_called_that(lab):
    words = {title: tried(lab)[title] for title, _, _ in returning_nothing(LABS[lab])}
    assert words
    assert [
        title
        for title, said in words.items()
        if not any(title in line for line in said.values())
    ] == []


@each_lab
def test_the_teachers_version_says_so_first_and_the_students_does_not(lab):
    assert (
        LABS[lab].cells[0].source.startswith("*The teacher's version, with solutions.")
    )
    assert "teacher's version" not in nbformat.writes(released(LABS[lab]))


@pytest.mark.slow
@each_lab
def test_the_empty_lab_has_no_faults_outside_its_checks(lab):
    assert marks.faults(LABS[lab], tried(lab)["empty"]) == []


@each_lab
def test_every_lab_has_wrong_answers_a_question_and_points(lab):
    assert len(wrong_answers(lab)) >= 3
    assert of_role(LABS[lab], "question")
    assert all(
        points(cell) > 0 for cell in of_role(LABS[lab], "check", "question").values()
    )


@each_lab
def test_the_empty_lab_has_neither_solutions_nor_hidden_tests(lab):
    text = nbformat.writes(released(LABS[lab]))
    assert "BEGIN " not in text and "END " not in text
    for cell in of_role(released(LABS[lab]), "solution", "question").values():
        assert STUBS[cell.cell_type].split("\n")[-1] in cell.source


@each_lab
def test_every_assertion_of_a_check_says_in_words_what_is_wrong(lab):
    wordless = [
        cell.id
        for cell in of_role(LABS[lab], "check").values()
        for node in ast.walk(ast.parse(cell.source))
        if isinstance(node, ast.Assert) and node.msg is None
    ]
    assert wordless == []


@each_lab
def test_a_lab_is_stored_clean(lab):
    ids = [cell.id for cell in LABS[lab].cells]
    assert checks.strip(LABS[lab]) == LABS[lab]
    assert len(set(ids)) == len(ids)


@each_lab
def test_nbgrader_makes_the_same_version_for_students(lab):
    preprocessors = pytest.importorskip("nbgrader.preprocessors")
    theirs = copy.deepcopy(LABS[lab])
    for step in (
        preprocessors.CheckCellMetadata,
        preprocessors.ClearSolutions,
        preprocessors.ClearHiddenTests,
        preprocessors.LockCells,
    ):
        theirs, _ = step().preprocess(theirs, {})
    assert [cell for cell in theirs.cells if cell.id != "teacher"] == released(
        LABS[lab]
    ).cells


# The commands, on a made-up lab


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


@pytest.fixture
def toy(tmp_path, monkeypatch):
    """A folder of labs with only the toy in it."""
    folder = tmp_path / "labs"
    folder.mkdir()
    nbformat.write(TOY, folder / "toy.ipynb")
    monkeypatch.setattr(notebooks, "FOLDER", folder)
    return tmp_path


def hand_in(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        text if isinstance(text, str) else nbformat.writes(text), encoding="utf-8"
    )


def graded(folder, output, *words):
    """The rows of the table that `labs grade` writes, {student: row}."""
    assert not cli.run(
        cli.parse(["labs", "grade", str(folder), "-o", str(output), *words])
    )
    with output.open(newline="", encoding="utf-8-sig") as file:
        return {row["student"]: row for row in csv.DictReader(file)}


def test_release_writes_the_students_version_and_never_over_the_solutions(toy, capsys):
    assert not cli.run(cli.parse(["labs", "release", "-o", str(toy / "handout")]))
    assert nbformat.read(toy / "handout" / "toy.ipynb", 4).cells == released(TOY).cells
    assert capsys.readouterr().out.strip() == str(toy / "handout" / "toy.ipynb")
    with pytest.raises(SystemExit, match="choose another folder"):
        cli.run(cli.parse(["labs", "release", "-o", str(toy / "labs")]))
    assert nbformat.read(toy / "labs" / "toy.ipynb", 4) == TOY


def test_check_tells_a_student_in_words_what_is_wrong(toy, capsys):
    hand_in(
        toy / "mine.ipynb",
        answer(add="def add(a, b):\n    return a - b", why=GOOD["why"]),
    )
    assert cli.run(cli.parse(["labs", "check", str(toy / "mine.ipynb")])) == 1
    assert capsys.readouterr().out.splitlines() == [
        "  0 of 2  check_add: 1 + 2 is 3, not -1",
        "  0 of 1  check_six: not written yet",
        "  ? of 3  why: a person reads your answer",
        "0 of 3 points so far, and 3 for what a person reads; "
        "the hidden checks may find more",
    ]


def test_check_names_the_first_cell_that_stops_by_the_heading_above_it_and_no_cell_that_only_follows(  # noqa: E501
    toy, capsys
):
    mine = answer(add="def add(a, b)\n    return a + b")
    mine.cells.insert(0, nbformat.v4.new_markdown_cell("## 1. Add\n\nWrite `add`."))
    mine.cells.append(nbformat.v4.new_code_cell("print(add(1, 2))"))
    hand_in(toy / "mine.ipynb", mine)
    assert cli.run(cli.parse(["labs", "check", str(toy / "mine.ipynb")])) == 1
    *_, fault, _ = capsys.readouterr().out.splitlines()
    assert fault.startswith('under "1. Add": stops with SyntaxError')


def test_check_finds_a_lab_of_the_handout_by_its_name_and_says_where_it_looked_for_others(  # noqa: E501
    toy, monkeypatch
):
    monkeypatch.setattr(grading, "HANDOUT", toy / "handout")
    hand_in(toy / "handout" / "toy.ipynb", answer(**GOOD))
    assert cli.run(cli.parse(["labs", "check", "toy.ipynb"])) == 0
    with pytest.raises(
        SystemExit,
        match="no such file, seen from this folder or from .*handout.*labs release",
    ):
        cli.run(cli.parse(["labs", "check", "missing.ipynb"]))


def test_release_leaves_a_students_work_as_it_is_and_says_so(toy, capsys):
    hand_in(toy / "handout" / "toy.ipynb", answer(**GOOD))
    assert not cli.run(cli.parse(["labs", "release", "-o", str(toy / "handout")]))
    assert nbformat.read(toy / "handout" / "toy.ipynb", 4).cells == answer(**GOOD).cells
    assert "is there already and stays as it is" in capsys.readouterr().out


@pytest.mark.parametrize(
    "text, said",
    [
        ("{", "is not a notebook"),
        ("[1]", "is not a notebook"),
        (nbformat.writes(nbformat.v4.new_notebook()), "has no checks"),
    ],
)
def test_check_says_so_when_a_file_is_no_lab(toy, text, said):
    hand_in(toy / "mine.ipynb", text)
    with pytest.raises(SystemExit, match=said):
        cli.run(cli.parse(["labs", "check", str(toy / "mine.ipynb")]))


# One file of each kind that forty students hand in.
STUBBORN = """\
import signal
signal.signal(signal.SIGINT, signal.SIG_IGN)
while True: pass"""
HANDED_IN = {
    "good": answer(**GOOD),
    "broken": "{",
    "nonsense": json.dumps({"cells": 5}),
    "empty": nbformat.v4.new_notebook(),
    "untouched": answer(),
    "edited": answer(
        **GOOD | {"add": "def add(a, b):\n    return 3", "check_add": "pass"}
    ),
    "no_check": answer(**GOOD | {"check_add": None}),
    "no_solution": answer(**GOOD | {"add": None}),
    "endless": answer(**GOOD | {"add": "def add(a, b):\n    while True: pass"}),
    "stubborn": answer(**GOOD | {"add": STUBBORN}),
    "dies": answer(**GOOD | {"add": "import os\nos._exit(1)"}),
    "typo": answer(**GOOD | {"add": "def add(a, b)\n    return a + b"}),
}
HALF_DONE = ("edited", "no_check", "no_solution", "endless", "typo")
NOTES = {
    "broken": "is not a notebook",
    "nonsense": "is not a notebook",
    "empty": "check_six: this check is missing",
    "untouched": "why: not answered",
    "edited": "check_add: was edited, the original counts",
    "no_check": "check_add: this check is missing",
    "no_solution": "name 'add' is not defined",
    "endless": "is there a loop that never ends",
    "stubborn": "could not be interrupted",
    "dies": "or a cell ended it (exit); "
    "add ended the kernel, and 2 checks were not run",
    "typo": "add: stops with SyntaxError",
}
GOOD_ROW = {
    "student": "good",
    "lab": "toy",
    "points": "3",
    "of": "3",
    "to_read": "3",
    "check_add": "2",
    "check_six": "1",
    "note": "",
    "answers": "why: I do not know.",
    "file": "",
}


@pytest.mark.slow
def test_grade_goes_through_a_folder_whatever_is_in_it(toy, monkeypatch):
    """Each is graded by itself."""
    monkeypatch.setattr("mkt.course.labs.process.PATIENCE", 3)
    for student, text in HANDED_IN.items():
        hand_in(toy / "submitted" / student / "toy" / "toy.ipynb", text)
    rows = graded(toy / "submitted", toy / "grades.csv", "--limit", "4")
    expected = {"good": "3"} | dict.fromkeys(HALF_DONE, "1")
    assert {student: row["points"] for student, row in rows.items()} == dict.fromkeys(
        HANDED_IN, "0"
    ) | expected
    assert {student: row["of"] for student, row in rows.items()} == dict.fromkeys(
        HANDED_IN, "3"
    )
    assert rows["good"] | {"file": ""} == GOOD_ROW
    assert [
        student
        for student, words in NOTES.items()
        if words not in rows[student]["note"]
    ] == []


def test_grade_takes_flat_folders_and_names_what_is_of_no_lab(toy):
    folder = toy / "flat"
    hand_in(folder / "Ada Lovelace_toy.ipynb", answer(**GOOD))
    hand_in(folder / "bob" / "toy (1).ipynb", answer(**GOOD))
    hand_in(folder / "eve" / "holiday.ipynb", answer(**GOOD))
    hand_in(folder / "bob" / ".ipynb_checkpoints" / "toy.ipynb", "{")
    rows = graded(folder, toy / "grades.csv")
    assert {student: row["points"] for student, row in rows.items()} == {
        "Ada Lovelace": "3",
        "bob": "3",
        "eve": "",
    }
    assert "of no lab" in rows["eve"]["note"]


def test_a_submission_cannot_pass_a_check_under_another_cells_name(toy):
    cheat = answer()
    cheat.cells.append(nbformat.v4.new_code_cell("pass", id="check_add"))
    cheat.cells.append(
        nbformat.v4.new_code_cell(
            "pass", id="x", metadata=meta("check_add", True, False)
        )
    )
    hand_in(toy / "submitted" / "eve" / "toy.ipynb", cheat)
    assert graded(toy / "submitted", toy / "grades.csv")["eve"]["points"] == "0"


def test_grade_says_so_when_there_is_nothing_to_grade(toy):
    (toy / "nothing").mkdir()
    with pytest.raises(SystemExit, match="no notebooks in there"):
        cli.run(
            cli.parse(
                ["labs", "grade", str(toy / "nothing"), "-o", str(toy / "grades.csv")]
            )
        )
    assert not (toy / "grades.csv").exists()


@pytest.mark.parametrize(
    "folder, output, said",
    [
        (
            "submitted",
            "grades.csv",
            "is there already, perhaps with marks that you typed",
        ),
        ("submitted", "no/x.csv", "there is no folder .*no; make it"),
        ("no", "x.csv", "there is no such folder"),
        ("submitted/ada/toy.ipynb", "x.csv", "this is a file; give the folder"),
    ],
)
def test_grade_refuses_before_it_starts_what_it_cannot_read_or_write(
    toy, folder, output, said
):
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(**GOOD))
    hand_in(toy / "grades.csv", "marks typed by the teacher")
    with pytest.raises(SystemExit, match=said):
        graded(toy / folder, toy / output)
    assert (toy / "grades.csv").read_text(
        encoding="utf-8"
    ) == "marks typed by the teacher"


def test_grade_says_at_ctrl_c_how_many_rows_the_table_has(toy, monkeypatch):
    async def row(submission, lab, limit):
        if submission.student == "bob":
            raise KeyboardInterrupt
        return {
            "student": submission.student,
            "lab": submission.lab,
            "file": str(submission.path),
        }

    monkeypatch.setattr(grading, "_row", row)
    for student in ("ada", "bob"):
        hand_in(toy / "submitted" / student / "toy.ipynb", answer(**GOOD))
    with pytest.raises(SystemExit, match="grades.csv has 1 of 2 rows"):
        graded(toy / "submitted", toy / "grades.csv")
    assert len((toy / "grades.csv").read_text(encoding="utf-8-sig").splitlines()) == 2


def test_grade_sorts_its_rows_has_one_for_files_that_are_no_notebooks_and_tells_spreadsheets_of_umlauts(  # noqa: E501
    toy,
):
    hand_in(toy / "submitted" / "Zoë" / "toy.ipynb", answer())
    hand_in(toy / "submitted" / "Jürgen" / "toy.pdf", "%PDF")
    hand_in(toy / "submitted" / "Jürgen" / ".DS_Store", "")
    hand_in(toy / "submitted" / "Anna" / "toy.ipynb", "{")
    rows = graded(toy / "submitted", toy / "grades.csv")
    assert list(rows) == ["Anna", "Jürgen", "Zoë"]
    assert rows["Jürgen"]["note"] == "not a notebook: .pdf"
    assert (toy / "grades.csv").read_bytes().startswith("\ufeff".encode())


TAMPERED = {
    "asserts": """
import ast
class Drop(ast.NodeTransformer):
    def visit_Assert(self, node):
        return ast.Pass()
get_ipython().ast_transformers.append(Drop())""",
    "lines": """
def without(lines):
    return ["pass\\n" if line.startswith("assert") else line for line in lines]
get_ipython().input_transformers_cleanup.append(without)""",
    "numpy": """
import numpy as np
np.isclose = lambda *_, **__: True""",
}


def test_grade_notes_when_checks_can_no_longer_fail_and_blames_nobody_else(toy):
    for student, trick in TAMPERED.items():
        hand_in(
            toy / "submitted" / student / "toy.ipynb",
            answer(**GOOD | {"add": f"{GOOD['add']}\n\n\n{trick}"}),
        )
    hand_in(
        toy / "submitted" / "honest" / "toy.ipynb",
        answer(**GOOD | {"add": f"import numpy as np\n{GOOD['add']}"}),
    )
    notes = {
        student: row["note"]
        for student, row in graded(toy / "submitted", toy / "grades.csv").items()
    }
    assert notes == dict.fromkeys(
        TAMPERED, "the checks were tampered with: read this notebook"
    ) | {"honest": ""}


def test_grade_blames_the_cell_that_calls_exit_not_the_next_one(toy):
    hand_in(
        toy / "submitted" / "eve" / "toy.ipynb",
        answer(**GOOD | {"six": f"{GOOD['six']}\n\n\nexit()"}),
    )
    row = graded(toy / "submitted", toy / "grades.csv")["eve"]
    assert row["points"] == "2"
    assert row["note"].startswith("six: the kernel died") and row["note"].endswith(
        "six ended the kernel, and 1 check was not run"
    )


def test_grade_finds_answers_above_the_stub_and_in_cells_below_the_question_and_leaves_out_the_question(  # noqa: E501
    toy,
):
    above, below = answer(why="Why?\n\nBecause I say so.\n\nYOUR ANSWER HERE"), answer()
    below.cells.append(nbformat.v4.new_markdown_cell("Look below."))
    for student, notebook in {
        "above": above,
        "below": below,
        "stub": answer(why="YOUR ANSWER HERE"),
    }.items():
        hand_in(toy / "submitted" / student / "toy.ipynb", notebook)
    rows = graded(toy / "submitted", toy / "grades.csv")
    assert {
        student: (row["answers"].strip(), row["to_read"])
        for student, row in rows.items()
    } == {
        "above": ("why: Because I say so.", "3"),
        "below": ("why: Look below.", "3"),
        "stub": ("", "0"),
    }


def test_a_notebook_of_the_time_before_cells_had_ids_is_graded(toy, recwarn):
    old = json.loads(nbformat.writes(answer(**GOOD)))
    for cell in old["cells"]:
        del cell["id"]
    hand_in(
        toy / "submitted" / "ada" / "toy.ipynb", json.dumps(old | {"nbformat_minor": 4})
    )
    assert graded(toy / "submitted", toy / "grades.csv")["ada"]["points"] == "3"
    assert [warning for warning in recwarn if "id" in str(warning.message)] == []


def test_a_copied_check_gives_its_points_once_and_no_raw_warning(toy, recwarn):
    twice = answer(**GOOD)
    twice.cells.append(twice.cells[1])
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", json.dumps(twice))
    assert graded(toy / "submitted", toy / "grades.csv")["ada"]["points"] == "3"
    assert [warning for warning in recwarn if "cell id" in str(warning.message)] == []
