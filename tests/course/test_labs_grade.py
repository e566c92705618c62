"""`labs grade` goes through a folder whatever is in it."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
import unicodedata
from pathlib import Path

import nbformat
import psutil
import pytest

from mkt.course.labs import grading, table
from mkt.course.labs.submissions import (
    SAME_FILE,
    Submission,
    _nothing,
    coincidences,
    submissions,
)
from mkt.files import alone
from tests.course.toy_lab import GOOD, answer, graded, hand_in, meta, rows

# Each starts students' programs; a quick loop leaves them out.
pytestmark = pytest.mark.slow

# One file of each kind that forty students hand in.
STUBBORN = """\
import signal
signal.signal(signal.SIGINT, signal.SIG_IGN)
while True: pass"""
HANDED_IN = {
    "good": answer(**GOOD),
    "broken": "{",
    "list": "[1, 2]",
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
DAMAGED = ("broken", "list", "nonsense")
HALF_DONE = ("edited", "no_solution", "endless", "stubborn", "dies", "typo")
NOTES = {
    "broken": "is not a notebook",
    "list": "is not a notebook: no JSON object",
    "nonsense": "is not a notebook",
    "empty": "check_six: was deleted, the original counts",
    "untouched": "why: not answered",
    "edited": "check_add: was edited, the original counts",
    "no_check": "check_add: was deleted, the original counts",
    "no_solution": "name 'add' is not defined",
    "endless": "is there a loop that never ends",
    "stubborn": "could not be interrupted",
    "dies": "add: the program died, perhaps for want of memory",
    "typo": "add: stops with SyntaxError",
}
GOOD_ROW = {
    "student": "good",
    "lab": "toy",
    "points": "3",
    "of": "3",
    "total": "",
    "maximum": "6",
    "check_add": "2",
    "check_six": "1",
    "why": "",
    "state": "",
    "note": "",
    "answers": "why: I do not know.",
    "file": "good/toy/toy.ipynb",
    "sha256": "",
}


@pytest.mark.slow
def test_grade_goes_through_a_folder_whatever_is_in_it(toy):
    """Each is graded by itself."""
    for student, text in HANDED_IN.items():
        hand_in(toy / "submitted" / student / "toy" / "toy.ipynb", text)
    rows = graded(toy / "submitted", toy / "grades.csv", "--limit", "4")
    expected = {"good": "3", "no_check": "3"} | dict.fromkeys(HALF_DONE, "1")
    expected |= dict.fromkeys(DAMAGED, "")
    assert {student: row["points"] for student, row in rows.items()} == dict.fromkeys(
        HANDED_IN, "0"
    ) | expected
    assert {student: row["of"] for student, row in rows.items()} == dict.fromkeys(
        HANDED_IN, "3"
    ) | dict.fromkeys(DAMAGED, "")
    assert rows["good"] | {"sha256": ""} == GOOD_ROW
    assert [
        student
        for student, words in NOTES.items()
        if words not in rows[student]["note"]
    ] == []


def test_grade_takes_flat_folders_and_names_what_is_of_no_lab(toy):
    folder = toy / "flat"
    hand_in(folder / "Ada Lovelace_Toy.ipynb", answer(**GOOD))
    hand_in(folder / "bob" / "toy (1).ipynb", answer(**GOOD))
    hand_in(folder / "eve" / "holiday.ipynb", nbformat.v4.new_notebook())
    hand_in(folder / "bob" / ".ipynb_checkpoints" / "toy.ipynb", "{")
    rows = graded(folder, toy / "grades.csv")
    assert {student: row["points"] for student, row in rows.items()} == {
        "Ada Lovelace": "3",
        "bob": "3",
        "eve": "",
    }
    assert "of no lab" in rows["eve"]["note"]
    assert "not called after" not in rows["Ada Lovelace"]["note"]


def test_files_side_by_side_say_whose_they_are_also_under_shortened_names(toy):
    folder = toy / "sub2"
    students = {
        "zoe_lab_1": "zoe",
        "Li Wei-lab_2 (1)": "Li Wei",
        "lab_3": "sub2",
        "lab_3_par": "sub2",
        "tom_toy": "tom",
        "Dora_Toy": "Dora",
        "toy_cora": "cora",
        "TOY - Zoë (1)": "Zoë",
        "toy (2)": "sub2",
        "toy-Copy1": "sub2",
        "toy_v2": "sub2",
        "toy (final)": "sub2",
        "collab_tim": "collab_tim",
        "bob homework": "bob homework",
    }
    for file in students:
        hand_in(folder / f"{file}.ipynb", answer(**GOOD))
    found = submissions(folder, ["toy"], ())
    assert {one.path.stem: one.student for one in found} == students
    unnamed = {one.path.stem for one in found if not one.named}
    nobodys = {file for file, student in students.items() if student == "sub2"}
    assert unnamed == nobodys
    assert {one.path.stem for one in found if one.lab} == {
        file for file in students if "toy" in file.lower()
    }


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
        graded(toy / "nothing", toy / "grades.csv")
    assert not (toy / "grades.csv").exists()


def test_a_table_in_the_folder_of_the_submissions_is_none_itself(toy, monkeypatch):
    """Nor are its rubrics and pages, however often it is graded and by what path."""
    folder = toy / "submitted"
    hand_in(folder / "ada" / "toy.ipynb", answer(**GOOD))
    monkeypatch.chdir(folder)
    (toy / "link").symlink_to(folder)
    for place in (folder, toy / "link", Path()):
        assert list(graded(place, folder / "grades.csv")) == ["ada"]
        assert list(graded(folder, place / "grades.csv")) == ["ada"]


@pytest.mark.parametrize(
    "folder, output, said",
    [
        (
            "submitted",
            "grades.csv",
            "is there already, and no table of marks",
        ),
        ("submitted", "no/x.csv", "no folder .*no for x.csv; make it"),
        ("no", "x.csv", "no such folder; check the spelling"),
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
    assert not [*toy.glob("*.lock")]
    assert (toy / "grades.csv").read_text(
        encoding="utf-8"
    ) == "marks typed by the teacher"


def test_grade_says_at_ctrl_c_how_many_rows_the_table_has_and_goes_on_from_there(
    toy,
    monkeypatch,
):
    graded_one = grading._Grader.graded

    def interrupted(self, one, copy, lab):
        if one.student == "bob":
            raise KeyboardInterrupt
        return graded_one(self, one, copy, lab)

    for student in ("ada", "bob"):
        hand_in(toy / "submitted" / student / "toy.ipynb", answer(**GOOD))
    monkeypatch.setattr(grading, "AT_ONCE", 1)
    with monkeypatch.context() as until_bob:
        until_bob.setattr(grading._Grader, "graded", interrupted)
        with pytest.raises(SystemExit, match="grades.csv has 1 rows; .* goes on"):
            graded(toy / "submitted", toy / "grades.csv")
    assert list(rows(toy / "grades.csv")) == ["ada"]
    typed = (toy / "grades.csv").read_text(encoding="utf-8-sig")
    (toy / "grades.csv").write_text(typed.replace(",2,1,,", ",2,1,2.5,"))
    table = graded(toy / "submitted", toy / "grades.csv")
    assert {one: row["total"] for one, row in table.items()} == {
        "ada": "5.5",
        "bob": "",
    }


@pytest.mark.skipif(os.name == "nt", reason="there a program is ended at once")
@pytest.mark.parametrize("blow", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_to_the_grading_alone_ends_what_it_has_started(toy, blow):
    slow = answer(**GOOD | {"add": "import time\ntime.sleep(50)"})
    for student in ("ada", "bob", "eve"):
        hand_in(toy / "submitted" / student / "toy.ipynb", slow)
    code = (
        "import sys; from pathlib import Path; from mkt.__main__ import prepare; "
        "prepare(); from mkt.course.labs import grading, notebooks; "
        "notebooks.FOLDER = Path(sys.argv[1]); "
        "grading.grade(*map(Path, sys.argv[2:4]), trusted=True)"
    )
    places = (toy / "labs", toy / "submitted", toy / "grades.csv")
    with subprocess.Popen([sys.executable, "-c", code, *places]) as grading_:
        below = psutil.Process(grading_.pid)
        for _ in range(300):
            started = below.children(recursive=True)
            if sum("mkt.course.labs.accused" in one.cmdline() for one in started) == 2:
                break
            time.sleep(0.1)
        time.sleep(1)
        began = time.monotonic()
        grading_.send_signal(blow)
        code = grading_.wait(40)
        assert code != 0 and time.monotonic() - began < 15
    left = psutil.wait_procs(started, timeout=10)[1]
    assert [(one.status(), one.cmdline()) for one in left] == []


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


def test_who_handed_in_nothing_has_a_row_until_there_is_something(toy):
    folder = toy / "submitted"
    hand_in(folder / "ada" / "toy.ipynb", answer(**GOOD))
    (folder / "bob" / "toy.ipynb").mkdir(parents=True)
    (folder / ".git").mkdir()
    noted = graded(folder, toy / "grades.csv")
    assert list(noted) == ["ada", "bob"]
    assert noted["bob"]["note"] == "nothing was handed in"
    again = graded(folder, toy / "grades.csv")
    assert again == noted
    (folder / "bob" / "toy.ipynb").rmdir()
    hand_in(folder / "bob" / "toy.ipynb", answer(**GOOD))
    assert graded(folder, toy / "grades.csv")["bob"]["points"] == "3"
    assert len(table.read(toy / "grades.csv")) == 2
    hand_in(toy / "flat" / "ada_toy.ipynb", answer(**GOOD))
    (toy / "flat" / "old").mkdir()
    assert list(graded(toy / "flat", toy / "flat.csv")) == ["ada"]


@pytest.mark.parametrize("change", [{"remark": "ill"}, {"student": "Bob B."}])
def test_what_a_teacher_wrote_beside_nothing_stays_when_a_file_comes(toy, change):
    folder, output = toy / "submitted", toy / "grades.csv"
    hand_in(folder / "ada" / "toy.ipynb", answer(**GOOD))
    (folder / "bob").mkdir()
    graded(folder, output)
    ada, bob = table.read(output)
    table.write(output, list(ada | change), [ada, bob | change], ",")
    hand_in(folder / "bob" / "toy.ipynb", answer(**GOOD))
    graded(folder, output)
    rows = [row for row in table.read(output) if row["file"].startswith("bob")]
    assert change.items() <= rows[0].items() and rows[0]["total"] == ""
    assert rows[1]["points"] == "3"


def test_a_folder_that_is_a_link_is_called_that(toy):
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(**GOOD))
    hand_in(toy / "elsewhere" / "toy.ipynb", answer(**GOOD))
    (toy / "submitted" / "bob").symlink_to(toy / "elsewhere")
    found = submissions(toy / "submitted", ["toy"], ())
    assert [one.student for one in found] == ["ada", "bob"]
    rows = graded(toy / "submitted", toy / "grades.csv")
    assert rows["bob"]["note"].startswith("a link to somewhere else")


def test_a_folder_that_cannot_be_read_is_not_called_empty(tmp_path):
    assert _nothing(tmp_path) == "nothing was handed in"
    assert _nothing(tmp_path / "gone").startswith("cannot be read: ")


def test_a_cell_that_calls_exit_costs_nothing(toy):
    mine = answer(**GOOD | {"six": f"{GOOD['six']}\n\n\nexit()"})
    hand_in(toy / "submitted" / "eve" / "toy.ipynb", mine)
    row = graded(toy / "submitted", toy / "grades.csv")["eve"]
    said = "six: calls exit(), which ends the program: take it out"
    assert (row["points"], row["note"]) == ("3", said)


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
        student: (row["answers"].strip(), row["why"]) for student, row in rows.items()
    } == {
        "above": ("why: Because I say so.", ""),
        "below": ("why: Look below.", ""),
        "stub": ("", "0"),
    }


def test_text_in_another_place_than_the_answer_waits_for_a_person(toy):
    """Above the question, or in comments; but not what was written about the code."""
    stub = GOOD | {"why": "Why?\n\nYOUR ANSWER HERE"}
    above, comment, code = (answer(**stub) for _ in range(3))
    above.cells.insert(0, nbformat.v4.new_markdown_cell("Because I\n\nsay so."))
    comments, tried = "# Because I\n# say so.", "# Try it.\nadd(1, 2)"
    comment.cells.append(nbformat.v4.new_code_cell(comments))
    code.cells.append(nbformat.v4.new_code_cell(tried))
    for student, notebook in {"above": above, "comment": comment, "code": code}.items():
        hand_in(toy / "submitted" / student / "toy.ipynb", notebook)
    rows = graded(toy / "submitted", toy / "grades.csv")
    assert {one: (row["why"], row["total"]) for one, row in rows.items()} == {
        "above": ("", ""),
        "comment": ("", ""),
        "code": ("0", "3"),
    }
    said = "why: not answered in its place; other text of the student's:"
    assert f"{said} Because I say so." in rows["above"]["note"].splitlines()
    assert f"{said} # Because I # say so." in rows["comment"]["note"].splitlines()
    assert rows["above"]["answers"] == "elsewhere: Because I\nsay so."
    assert rows["code"]["note"] == "why: not answered"


def test_a_lab_without_one_of_its_cells_may_be_an_older_version(toy):
    old = answer(**GOOD | {"six": None, "why": None})
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", old)
    note = graded(toy / "submitted", toy / "grades.csv")["ada"]["note"]
    for cell in ("six", "why"):
        assert f"the cell {cell} is missing: was it deleted, or is this an" in note


def test_a_cell_of_ones_own_that_takes_too_long_is_said_to_cost_nothing(toy):
    slow = answer(**GOOD)
    slow.cells.append(nbformat.v4.new_code_cell("while True:\n    pass"))
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", slow)
    (row,) = graded(toy / "submitted", toy / "grades.csv", "--limit", "2").values()
    assert row["points"] == "3" and "(this cell costs no points)" in row["note"]
    slow.cells[0].source = "while True:\n    pass"
    hand_in(toy / "submitted" / "bob" / "toy.ipynb", slow)
    rows = graded(toy / "submitted", toy / "grades.csv", "--limit", "2")
    assert "costs no points" not in rows["bob"]["note"].partition("check_add: ")[0]


def test_one_line_names_the_files_without_marks(toy, capsys):
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(**GOOD))
    graded(toy / "submitted", toy / "grades.csv")
    assert "no marks" not in capsys.readouterr().err
    for student in ("bob", "eve"):
        hand_in(toy / "submitted" / student / "toy.zip", student)
    graded(toy / "submitted", toy / "grades.csv")
    line = "no marks, see the notes in the table: bob/toy.zip, eve/toy.zip\n"
    assert line in capsys.readouterr().err
    (toy / "submitted" / "bob").rename(toy / "aside")
    hand_in(toy / "submitted" / "eve" / "toy.zip", "another")
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", "{")
    graded(toy / "submitted", toy / "grades.csv")
    line = "no marks, see the notes in the table: ada/toy.ipynb, eve/toy.zip\n"
    assert line in capsys.readouterr().err
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer())
    graded(toy / "submitted", toy / "grades.csv")
    line = "no marks, see the notes in the table: eve/toy.zip\n"
    assert line in capsys.readouterr().err


def test_a_damaged_notebook_has_no_marks_and_its_page_says_so(toy, capsys):
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(**GOOD))
    whole = nbformat.writes(answer(**GOOD))
    hand_in(toy / "submitted" / "bob" / "toy.ipynb", whole[: len(whole) // 2])
    row = graded(toy / "submitted", toy / "grades.csv")["bob"]
    assert row["note"] == (
        "this file cannot be read: save the notebook again and hand it in: "
        "toy.ipynb is not a notebook: no JSON object"
    )
    given = [row[one] for one in ("points", "total", "check_add", "check_six", "why")]
    assert given == [""] * 5
    assert "no marks, see the notes in the table: bob/toy" in capsys.readouterr().err
    (page,) = (toy / "grades_pages" / "bob").glob("*.html")
    text = page.read_text(encoding="utf-8")
    assert "Not graded yet." in text and row["note"] in text
    assert "<table>" not in text  # of nothing but question marks


def test_an_accent_makes_no_second_student(toy):
    names = [unicodedata.normalize(form, "Zoë") for form in ("NFC", "NFD")]
    for name, text in zip(names, (answer(**GOOD), answer()), strict=True):
        hand_in(toy / "submitted" / name / "toy.ipynb", text)
    graded(toy / "submitted", toy / "grades.csv")
    found = table.read(toy / "grades.csv")
    assert [row["student"] for row in found] == [names[0]] * 2
    assert all("another file of this lab by this student" in r["note"] for r in found)


def test_notes_of_other_files_are_said_anew_in_every_row(toy):
    """Also in rows that were there before; what a teacher has added to one stays."""
    folder, output = toy / "submitted", toy / "grades.csv"

    def notes():
        graded(folder, output)
        return {row["file"]: row["note"].splitlines() for row in table.read(output)}

    hand_in(folder / "ada" / "toy.ipynb", answer(**GOOD))
    assert notes() == {"ada/toy.ipynb": []}
    hand_in(folder / "bob" / "toy.ipynb", answer(**GOOD))
    hand_in(folder / "ada" / "toy (1).ipynb", "{")
    of_ada = [
        "the same file, byte for byte, as bob/toy.ipynb",
        "there is another file of this lab by this student: ada/toy (1).ipynb",
    ]
    found = notes()
    assert found["ada/toy.ipynb"] == of_ada
    assert found["bob/toy.ipynb"] == [of_ada[0].replace("bob", "ada")]
    assert "this student: ada/toy.ipynb" in found["ada/toy (1).ipynb"][0]
    first = output.read_bytes()
    assert notes() == found and output.read_bytes() == first
    text = output.read_text(encoding="utf-8-sig").replace(of_ada[0], f"{of_ada[0]}: no")
    output.write_text(text, encoding="utf-8-sig")
    assert notes()["ada/toy.ipynb"] == [*of_ada, f"{of_ada[0]}: no"]
    (folder / "bob" / "toy.ipynb").unlink()
    found = notes()
    assert found["ada/toy.ipynb"] == [of_ada[1], f"{of_ada[0]}: no"]
    assert found["bob/toy.ipynb"] == [of_ada[0].replace("bob", "ada")]  # as it was


def test_a_second_grading_of_a_table_waits_for_the_first(toy, capfd):
    """Or both would grade what is in the folder, and one would lose its rows."""
    folder, output = toy / "submitted", toy / "grades.csv"
    hand_in(folder / "ada" / "toy.ipynb", answer(**GOOD))
    graded(folder, output)
    hand_in(folder / "bob" / "toy.ipynb", answer(**GOOD))
    before = output.read_bytes()
    for second, students in (
        (lambda: grading.merge(output), ["ada"]),
        (lambda: grading.grade(folder, output, trusted=True), ["ada", "bob"]),
    ):
        waiting = threading.Thread(target=second)
        with alone(toy / "grades.csv.lock", "test"):
            waiting.start()
            waiting.join(1)
            assert waiting.is_alive() and output.read_bytes() == before
        waiting.join(60)
        assert [row["student"] for row in table.read(output)] == students
        before = output.read_bytes()
        assert "Another grading is under way" in capfd.readouterr().err


def test_a_note_of_a_file_that_has_no_row_any_more_is_taken_back():
    """It had none where a grading was stopped, or somebody took its row away."""
    mine = Submission("ada", "toy", Path("ada/toy.ipynb"), sha256="1")
    others = [
        Submission(one, "toy", Path(one, "toy.IPYNB"), sha256="1") for one in "bcdef"
    ]
    for count in range(1, 6):
        found = [mine, *others[:count]]
        odd = coincidences(found, {one.path: "Ada" for one in found}, {})
        row = {"file": "ada/toy.ipynb", "sha256": "1", "note": "by hand"}
        grading._tell([row], found, odd)
        assert len(row["note"].splitlines()) == 3
        assert ("and 2 more" in row["note"]) == (count == 5)
        assert (" more" in row["note"]) == (count > 3)
        grading._tell([row], [mine], {})
        assert row["note"] == "by hand"


def test_a_note_has_a_line_for_each_matter_whatever_files_are_called():
    found = [
        Submission("a", "toy", Path(f"{one}\nx.ipynb"), sha256="1") for one in "ab"
    ]
    for lines in coincidences(found, {}, {}).values():
        assert [line for line in lines if "\n" in line] == []


def test_what_systems_leave_beside_the_files_is_no_students(toy):
    folder = toy / "submitted"
    hand_in(folder / "ada" / "toy.ipynb", answer(**GOOD))
    for left in ("Thumbs.db", "desktop.ini", "~$toy.ipynb", ".DS_Store", "__MACOSX/x"):
        hand_in(folder / left, "")
        hand_in(folder / "bob" / left, "")
    found = submissions(folder, ["toy"], ())
    assert {one.student: one.trouble for one in found} == {
        "ada": "",
        "bob": "nothing was handed in",
    }


def test_what_is_too_large_for_a_notebook_is_told_the_remedy(toy, monkeypatch):
    monkeypatch.setattr("mkt.course.labs.submissions.LARGEST", 1e4)
    large = answer(**GOOD)
    large.cells.append(nbformat.v4.new_markdown_cell("x" * 10_000))
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", large)
    hand_in(toy / "submitted" / "bob" / "toy.ipynb", answer(**GOOD))
    rows = graded(toy / "submitted", toy / "grades.csv")
    assert "Clear Outputs of All Cells), save, grade again" in rows["ada"]["note"]


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


def test_a_failure_of_ours_stays_first_in_the_note_of_a_file_that_others_have_too():
    """So it is graded again the next time."""
    row = {"file": "a.ipynb", "sha256": "1", "note": f"{grading.OURS}: no room"}
    one = Submission("a", "toy", Path("a.ipynb"), sha256="1")
    grading._tell([row], [one], {one.path: [f"{SAME_FILE} b.ipynb"]})
    assert row["note"].startswith(grading.OURS)
