"""`labs release` and `labs check`, on a made-up lab."""

import time

import nbformat
import pytest

from mkt.course import cli
from mkt.course.labs import checking
from mkt.course.labs.borrowed import USES
from mkt.course.labs.judge import SAID, judged
from mkt.course.labs.marks import faults, merged
from mkt.course.labs.notebooks import headings, labs, of_role, released
from mkt.course.labs.student import CELLS, DIED, ENDS, OVER, Cell
from tests.course.toy_lab import GOOD, TOY, answer, graded, hand_in

pytestmark = pytest.mark.slow


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


def test_what_is_ready_made_is_told_as_to_the_teacher_and_costs_nothing(toy, capsys):
    add = "from scipy.special import comb\n\ndef add(a, b):\n    return comb(a, 1) + b"
    hand_in(toy / "mine.ipynb", answer(**GOOD | {"add": add}))
    assert cli.run(cli.parse(["labs", "check", str(toy / "mine.ipynb")])) == 0
    said = capsys.readouterr().out.splitlines()
    assert "  2 of 2  check_add" in said and USES.format("add", "comb") in said


def test_an_answer_above_its_place_or_in_a_cell_of_ones_own_is_one(toy, capsys):
    """As where it is graded."""
    beside = answer()
    place = of_role(beside, "question")["why"]
    place.source = f"Because of it.\n\n{place.source}"
    below = answer()
    below.cells.append(nbformat.v4.new_markdown_cell("Because of it."))
    for mine, words in (
        (beside, "a person reads your answer"),
        (below, "a person reads your answer"),
        (answer(), "no answer yet, it goes in the place of YOUR ANSWER HERE"),
    ):
        hand_in(toy / "mine.ipynb", mine)
        cli.run(cli.parse(["labs", "check", str(toy / "mine.ipynb")]))
        assert f"  ? of 3  why: {words}" in capsys.readouterr().out.splitlines()


def test_what_was_deleted_or_edited_counts_as_we_wrote_it_as_where_it_is_graded(
    toy, capsys
):
    mine = answer(**GOOD | {"add": "def add(a, b):\n    return 0", "check_six": None})
    of_role(mine, "check")["check_add"].source = "print('ok')"
    hand_in(toy / "in" / "ada" / "toy.ipynb", mine)
    assert cli.run(cli.parse(["labs", "check", str(toy / "in/ada/toy.ipynb")])) == 1
    assert capsys.readouterr().out.splitlines()[:-1] == [
        "  0 of 2  check_add: 1 + 2 is 3, not 0",
        "  1 of 1  check_six",
        "  ? of 3  why: a person reads your answer",
        "check_add: was edited, the original counts",
        "check_six: was deleted, the original counts",
    ]
    assert graded(toy / "in", toy / "grades.csv")["ada"]["points"] == "1"


def test_a_check_that_was_deleted_judges_what_stands_where_it_stood(toy, capsys):
    """And not what is tried at the end."""
    mine = answer(**GOOD | {"check_add": None})
    mine.cells.append(nbformat.v4.new_code_cell("add = 5"))
    hand_in(toy / "mine.ipynb", mine)
    cli.run(cli.parse(["labs", "check", str(toy / "mine.ipynb")]))
    assert "  2 of 2  check_add" in capsys.readouterr().out.splitlines()


def test_a_check_that_was_deleted_never_comes_before_its_answer(toy, capsys):
    """Wherever that was moved."""
    mine = answer(**GOOD | {"check_add": None})
    add, six, check_six, why = mine.cells
    first = nbformat.v4.new_code_cell("def add(a, b):\n    return a - b")
    mine.cells = [first, six, check_six, add, why]
    hand_in(toy / "mine.ipynb", mine)
    cli.run(cli.parse(["labs", "check", str(toy / "mine.ipynb")]))
    assert "  2 of 2  check_add" in capsys.readouterr().out.splitlines()


def test_the_cells_of_a_solution_and_of_an_answer_that_are_gone_are_named(toy, capsys):
    hand_in(toy / "mine.ipynb", answer(**GOOD | {"six": None, "why": None}))
    assert cli.run(cli.parse(["labs", "check", str(toy / "mine.ipynb")])) == 1
    said = capsys.readouterr().out
    for cell in ("six", "why"):
        assert f"the cell {cell} is missing: was it deleted, or is this an" in said


def test_where_a_lab_has_no_original_its_checks_count_as_they_are(toy, capsys):
    hand_in(toy / "mine.ipynb", answer(**GOOD))
    (toy / "labs" / "toy.ipynb").unlink()
    assert cli.run(cli.parse(["labs", "check", str(toy / "mine.ipynb")])) == 0
    assert checking.UNKNOWN in capsys.readouterr().out.splitlines()


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


def test_commands_of_notebooks_and_a_mark_of_the_editor_cost_nothing(toy, capsys):
    mine = answer(**GOOD | {"add": "%matplotlib inline\n" + GOOD["add"]})
    hand_in(toy / "mine.ipynb", mine)
    marked = b"\xef\xbb\xbf" + (toy / "mine.ipynb").read_bytes()
    (toy / "mine.ipynb").write_bytes(marked)
    cli.run(cli.parse(["labs", "check", str(toy / "mine.ipynb")]))
    assert "  2 of 2  check_add" in capsys.readouterr().out


@pytest.mark.filterwarnings("error")  # of ids that nbformat finds twice
@pytest.mark.parametrize("title", labs())
def test_given_cells_are_put_back_beside_those_that_have_lost_their_marks(title):
    mine = released(labs()[title])
    for cell in mine.cells:
        cell.metadata.clear()
    both = merged(released(labs()[title]), mine).cells
    assert [cell for cell in both if cell.id.endswith("-again")]


@pytest.mark.filterwarnings("error")
def test_a_notebook_that_has_lost_its_marks_is_known_by_its_name(toy, capsys):
    mine = answer(**GOOD)
    for cell in mine.cells:
        cell.metadata.clear()
    hand_in(toy / "toy.ipynb", mine)
    assert cli.run(cli.parse(["labs", "check", str(toy / "toy.ipynb")])) == 0
    assert "  2 of 2  check_add" in capsys.readouterr().out
    hand_in(toy / "other.ipynb", mine)
    with pytest.raises(SystemExit, match="no checks"):
        cli.run(cli.parse(["labs", "check", str(toy / "other.ipynb")]))


def test_a_command_that_is_not_known_is_named(toy, capsys):
    mine = answer(**GOOD | {"add": "%nosuch\n" + GOOD["add"]})
    hand_in(toy / "mine.ipynb", mine)
    assert cli.run(cli.parse(["labs", "check", str(toy / "mine.ipynb")])) == 1
    assert "`%nosuch` not found" in capsys.readouterr().out


FURTHER = """\
def one():
    return 6


def six():
    return 5 + one()"""


def test_what_is_tried_further_down_takes_no_points_away(toy, capsys):
    """Each check has the functions, and all that they use, as they are where it is."""
    mine = answer(**GOOD | {"six": FURTHER.replace("return 6", "return 1")})
    for source in (FURTHER, "def add(a, b):\n    return []", "del six"):
        mine.cells.append(nbformat.v4.new_code_cell(source))
    hand_in(toy / "in" / "ada" / "toy.ipynb", mine)
    assert cli.run(cli.parse(["labs", "check", str(toy / "in/ada/toy.ipynb")])) == 0
    assert "3 of 3 points so far" in capsys.readouterr().out
    assert graded(toy / "in", toy / "grades.csv")["ada"]["points"] == "3"


def test_a_function_that_is_passed_on_is_the_one_above_the_check():
    cells = [Cell("check", ""), Cell("below", "def f():\n    return 2")]
    cells.insert(0, Cell("f", "def call(g):\n    return g()\n\ndef f():\n    return 1"))
    check = Cell("check", "assert call(f) == 1, call(f)")
    assert judged([], [check], cells, boxed=False) == {}
    moved = [cells[0], cells[2], cells[1]]
    assert judged([], [check], moved, boxed=False) == {"check": "2"}


def test_a_check_finds_what_is_defined_below_it_alone_and_so_does_one_that_is_gone():
    define, place = Cell("f", "def f():\n    return 1"), Cell("check", "")
    check = Cell("check", "assert f() == 1")
    for cells in ([place, define], [define]):
        assert judged([], [check], cells, boxed=False) == {}


def test_what_ends_the_program_below_a_check_takes_no_points_away_either():
    cells = [Cell("f", "def f():\n    return 1"), Cell("check", "")]
    cells += [Cell("end", "import os\nos._exit(1)"), Cell("f2", "def f(): return 2")]
    said = judged([], [Cell("check", "assert f() == 1")], cells, boxed=False)
    assert said == {"end": DIED}


@pytest.mark.parametrize("end", ["exit()", "quit()", "import sys\nsys.exit(1)"])
def test_a_piece_that_ends_the_program_is_told_so(end):
    body = end.replace("\n", "\n    ")
    for source in (end, f"def f():\n    {body}"):
        said = judged([], [Cell("check", "f()")], [Cell("f", source)], boxed=False)
        assert ENDS in said.values()


def test_of_two_cells_of_one_name_only_the_one_that_ends_the_program_is_left_out():
    deadly, good = Cell("f", "import os\nos._exit(1)"), Cell("f", "f = abs")
    check = Cell("check", "assert f(-1) == 1")
    for cells in ([deadly, good], [good, deadly]):
        assert judged([], [check], cells, boxed=False) == {"f": DIED}


def test_what_is_said_of_a_cell_has_an_end():
    cells = [Cell("f", f"raise ValueError({'x' * 5000!r})")]
    assert len(judged([], [], cells, boxed=False)["f"]) == SAID


def test_a_notebook_as_a_whole_has_a_limit():
    cells = [Cell(f"c{k}", "while True: pass") for k in range(CELLS + 5)]
    began = time.monotonic()
    said = judged([], [], cells, 0.4, boxed=False)
    assert time.monotonic() - began < 2.5 * CELLS * 0.4
    assert [said[f"c{k}"] for k in (-3 + len(cells), -1 + len(cells))] == [OVER] * 2
    assert said["c0"] != OVER


def test_a_cell_is_found_by_the_bare_heading_above_it_or_else_by_its_name():
    mine = answer()
    mine.cells.insert(1, nbformat.v4.new_markdown_cell('## The "six"'))
    places = headings(mine)
    assert places["add"] == "add" and places["six"] == 'The "six"'
    assert faults(mine, {"add": "stops", "six": "stops"}) == [
        "add: stops",
        'under "The "six"": stops',
    ]


def test_check_finds_a_lab_of_the_handout_by_its_name_and_says_where_it_looked_for_others(  # noqa: E501
    toy, monkeypatch
):
    monkeypatch.setattr(checking, "HANDOUT", toy / "handout")
    hand_in(toy / "handout" / "toy.ipynb", answer(**GOOD))
    assert cli.run(cli.parse(["labs", "check", "toy.ipynb"])) == 0
    assert cli.run(cli.parse(["labs", "check", "toy"])) == 0
    seen = "no such file, seen from this folder or from .*handout; "
    with pytest.raises(SystemExit, match=seen + "there are toy"):
        cli.run(cli.parse(["labs", "check", "missing.ipynb"]))
    (toy / "handout" / "toy.ipynb").unlink()
    with pytest.raises(SystemExit, match=seen + ".*labs release"):
        cli.run(cli.parse(["labs", "check", "toy"]))
    with pytest.raises(SystemExit, match="this is a folder; give the notebook in it"):
        cli.run(cli.parse(["labs", "check", str(toy / "handout")]))


def test_release_leaves_a_students_work_as_it_is_and_says_so(toy, capsys):
    hand_in(toy / "handout" / "toy.ipynb", answer(**GOOD))
    assert not cli.run(cli.parse(["labs", "release", "-o", str(toy / "handout")]))
    assert nbformat.read(toy / "handout" / "toy.ipynb", 4).cells == answer(**GOOD).cells
    assert "is there already and stays as it is" in capsys.readouterr().out


def test_a_file_that_is_no_text_is_no_notebook(toy):
    (toy / "mine.ipynb").write_bytes(b"\xff\xd8")
    with pytest.raises(SystemExit, match="mine.ipynb is not a notebook: it is no text"):
        cli.run(cli.parse(["labs", "check", str(toy / "mine.ipynb")]))


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
