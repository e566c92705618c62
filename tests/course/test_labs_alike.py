"""A copy is noted that is not the same file, and honest work is not."""

import copy
from pathlib import Path
from textwrap import indent

import nbformat
import pytest

from mkt.course.labs.alike import OWN, compared
from mkt.course.labs.notebooks import STUBS, labs, of_role, released
from mkt.course.labs.source import LONGEST
from mkt.course.labs.submissions import Submission, coincidences
from mkt.files import ROOT
from tests.course.toy_lab import GOOD, TOY, answer, graded, hand_in

pytestmark = pytest.mark.slow

WHY = "A kernel is one number for each place, and says nothing of turns."
CODE = {
    "add": "def add(a, b):\n    return b + a",
    "six": "def six():\n    return 2 * 3",
}


def test_two_who_have_written_nothing_are_no_copies(toy):
    for student in ("olga", "pete"):
        hand_in(toy / "submitted" / student / "toy.ipynb", answer())
    for student in ("ada", "eve"):
        hand_in(toy / "submitted" / student / "toy.ipynb", answer(six=GOOD["six"]))
    rows = graded(toy / "submitted", toy / "grades.csv")
    assert "byte" not in rows["olga"]["note"] + rows["pete"]["note"]
    assert "byte for byte, as eve" in rows["ada"]["note"]


def test_a_copy_with_other_words_round_it_is_noted_for_both_and_on_no_page(toy):
    other = "def six():  # by me\n\n    return (2 * 3)"
    copy = answer(**CODE | {"why": f"Why?\n\n{WHY.upper()} ", "six": other})
    copy.cells.append(nbformat.v4.new_code_cell(""))
    for student, notebook in {
        "olga": answer(**CODE | {"why": f"Why?\n\n{WHY}"}),
        "pete": copy,
        "ada": answer(**GOOD),
    }.items():
        hand_in(toy / "submitted" / student / "toy.ipynb", notebook)
    rows = graded(toy / "submitted", toy / "grades.csv")
    for student, friend in (("olga", "pete"), ("pete", "olga")):
        assert rows[student]["note"].splitlines() == [
            f"the same work: the answer to why is also in {friend}/toy.ipynb",
            f"the same work: all its code is also in {friend}/toy.ipynb",
        ]
        (page,) = (toy / "grades_pages" / student).iterdir()
        assert "the same work" not in page.read_text(encoding="utf-8")
    assert rows["ada"]["note"] == ""


def test_two_files_of_one_student_and_the_same_file_are_told_as_such_alone(toy):
    notebook = answer(**CODE | {"why": f"Why?\n\n{WHY}"})
    for place in ("ada/toy.ipynb", "bob/toy.ipynb"):
        hand_in(toy / "submitted" / place, notebook)
    notebook.cells.append(nbformat.v4.new_code_cell(""))
    hand_in(toy / "submitted" / "ada" / "toy (1).ipynb", notebook)
    note = graded(toy / "submitted", toy / "grades.csv")["bob"]["note"]
    assert "same work: all its code is also in ada/toy (1).ipynb" in note
    assert "byte for byte, as ada/toy.ipynb" in note
    assert len(note.splitlines()) == 3


@pytest.mark.parametrize(
    "change",
    [
        {"why": "Why?\n\nIt says nothing of turns."},
        {"add": GOOD["add"], "six": GOOD["six"]},  # the model solutions
        {"six": "def six():\n" + indent(STUBS["code"], "    ")},  # not written
        {"six": None},
    ],
)
def test_what_honest_students_share_is_not_compared(change):
    whole = CODE | {"why": f"Why?\n\n{WHY}"}
    assert len(compared(TOY, answer(**whole))) == 2
    assert len(compared(TOY, answer(**whole | change))) == 1


@pytest.mark.parametrize("letters, told", [(40, False), (41, True)])
def test_an_answer_is_compared_from_the_length_that_the_plan_names(letters, told):
    found = compared(TOY, answer(why=f"Why?\n\n{'x' * letters}"))
    assert ("the answer to why" in found) == told
    plan = " ".join((ROOT / "COURSE.md").read_text(encoding="utf-8").split())
    assert "an answer of more than 40 letters" in plan


def noted(one, other):
    """Whether the files of two students are noted as the same code."""
    found = [
        Submission(student, "toy", Path(student), sha256=student) for student in "ab"
    ]
    codes = zip(found, (one, other), strict=True)
    work = {one.path: compared(TOY, notebook) for one, notebook in codes}
    said = coincidences(found, {}, work).values()
    assert len({bool(lines) for lines in said}) == 1
    return any("all its code" in line for lines in said for line in lines)


@pytest.mark.parametrize(
    "six",
    [
        'def six():\n    """Give six."""\n    return 2 * 3',
        'def six():\n    """Give six."""\n    0\n    pass\n    return 2 * 3',
        "def six():\n    # as I say\n    return (2\n            * 3)",
    ],
)
def test_what_does_nothing_hides_no_copy(six):
    assert noted(answer(**CODE), answer(**CODE | {"six": six}))
    assert not noted(answer(**CODE), answer(**CODE | {"six": f"{six} * 1"}))


@pytest.mark.parametrize("place", [0, 4])
@pytest.mark.parametrize("decoy", ["", "pass", "x = 1", released(TOY).cells[2].source])
def test_a_second_cell_of_the_same_name_hides_no_copy(place, decoy):
    copied = answer(**CODE)
    again = copy.deepcopy(copied.cells[2])
    again.source = decoy
    copied.cells.insert(place, again)
    assert noted(answer(**CODE), copied)
    assert noted(copied, copied)
    assert not noted(answer(**CODE | {"six": "six = 6 .__int__"}), copied)


@pytest.mark.parametrize(
    "six",
    [
        f"six = {'-' * 9_000}6",  # too deep to be read
        f"six = {'(' * 500}6{')' * 500}",
        "six = 6\0",
        f"six = lambda: 6{' + x' * 900}",  # can be read, and is too deep to be shown
    ],
)
def test_code_that_python_can_hardly_read_is_compared_too(six):
    assert noted(answer(**CODE | {"six": six}), answer(**CODE | {"six": six}))
    assert not noted(answer(**CODE | {"six": six}), answer(**CODE | {"six": f"{six} "}))


def test_of_code_without_end_the_beginning_is_compared():
    long = f"{CODE['six']}\n{'x = 1; ' * 2_000}"
    (codes,) = compared(TOY, answer(**CODE | {"six": long})).values()
    assert max(len(text) for part in codes for text in part) == LONGEST


@pytest.mark.parametrize("title", labs())
def test_neither_the_untouched_lab_nor_its_model_answers_are_compared(title):
    lab, solved = labs()[title], labs()[title]
    assert compared(lab, released(lab)) == {}
    for cell in of_role(solved, "solution", "question").values():
        lines = cell.source.splitlines()
        cell.source = "\n".join(line for line in lines if "SOLUTION" not in line)
    assert compared(lab, solved) == {}
    for cell in of_role(solved, "solution").values():
        cell.source += "\nmine = 1"
    copied = compared(lab, solved)
    assert list(copied) == ["all its code"]
    for piece, cell in of_role(solved, "solution").items():
        if piece in OWN:
            cell.source += "\nyours = 2"
    assert compared(lab, solved) == copied


def test_code_that_python_cannot_read_is_compared_as_it_is():
    broken = CODE | {"add": "def add(a, b)\n    return a + b"}
    assert compared(TOY, answer(**broken)) == compared(TOY, answer(**broken))
    assert list(compared(TOY, answer(**broken))) == ["all its code"]
