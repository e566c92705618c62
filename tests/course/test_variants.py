"""A scene for each student, made of the name."""

from pathlib import Path

import nbformat
import pytest

from mkt.course.labs import notebooks, variants
from mkt.course.labs.notebooks import of_role
from mkt.course.labs.submissions import Submission, coincidences
from mkt.course.labs.variants import FIRST, NOBODYS, own_seed, seed_of, written_name
from mkt.scenes.drawn import HELD_BACK, TUNING
from tests.course.toy_lab import GOOD, answer, graded, hand_in, meta


def with_name(name, **sources):
    """The toy lab handed in, with a name in it."""
    source = f"def my_name():\n    '''Your name.'''\n    return {name!r}"
    notebook = answer(**sources)
    notebook.cells.append(
        nbformat.v4.new_code_cell(source, metadata=meta("my_name", True, False))
    )
    return notebook


def test_a_name_has_one_seed_however_it_is_written_and_others_have_others():
    assert seed_of("Ada Lovelace") == seed_of(" ada  LOVELACE ")
    assert seed_of("Zoë") == seed_of("Zoe\u0308")
    # As one who has just written Chinese or Japanese types it.
    assert seed_of("\uff21\uff24\uff21") == seed_of("Ada")
    assert len({seed_of(f"student {k}") for k in range(500)}) == 500


def test_a_name_keeps_its_seed():
    """Else students who are half-way through a lab would find other numbers in it."""
    assert seed_of("Zoe") == 571_815


def test_no_student_gets_a_scene_on_which_trackers_were_tuned_or_are_judged():
    seeds = {seed_of(f"student {k}") for k in range(500)}
    assert not seeds & {*HELD_BACK, *TUNING, NOBODYS}


def test_a_name_needs_no_letters_and_an_empty_one_is_called_so():
    assert seed_of("123") >= FIRST
    with pytest.raises(ValueError, match="the name is empty; write yours"):
        seed_of("  ")


def raising():
    raise NotImplementedError


@pytest.mark.parametrize("my_name", [raising, lambda: None, lambda: "  ", lambda: 7])
def test_without_a_name_the_rest_of_the_lab_has_nobodys_scene(my_name):
    assert own_seed(my_name) == NOBODYS


def test_at_least_three_labs_have_a_scene_for_each_student():
    labs = notebooks.labs()
    own = [lab for lab in labs if written_name(labs[lab])]
    assert len(own) >= 3
    for lab in own:
        assert {"my_number", "my_name"} <= {*of_role(labs[lab], "solution")}


@pytest.mark.slow
def test_two_students_with_one_name_are_noted_and_one_whose_cell_is_broken_is_not(toy):
    for student, notebook in {
        "anna": with_name("Anna", **GOOD),
        "ben": with_name("Anna", add="def add(a, b):\n    return b + a"),
        "cara": with_name("Cara", **GOOD),
        "dora": with_name("Dora", **GOOD | {"six": "def six("}),
    }.items():
        hand_in(toy / "in" / f"{student}_toy.ipynb", notebook)
    rows = graded(toy / "in", toy / "grades.csv")
    said = {student: "the name in it" in row["note"] for student, row in rows.items()}
    assert said == {"anna": True, "ben": True, "cara": False, "dora": False}


def test_a_whole_course_with_one_name_is_noted_in_one_line_each():
    """As where nobody has changed an example; another lab of one's own is no twin."""
    found = [
        Submission(f"s{k}", lab, Path(f"s{k}/{lab}.ipynb"), sha256=f"{k}{lab}")
        for k in range(6)
        for lab in ("lab_1", "lab_3")
    ]
    names = dict.fromkeys((one.path for one in found), "Ada Lovelace")
    noted = coincidences(found, names, {})
    assert noted[Path("s0/lab_1.ipynb")] == [
        "the name in it, 'Ada Lovelace', is also in "
        "s1/lab_1.ipynb, s2/lab_1.ipynb, s3/lab_1.ipynb and 2 more"
    ]
    assert all(len(sentences) == 1 for sentences in noted.values())


def test_one_name_written_in_two_ways_is_noted_for_it_has_one_scene():
    names = {"a": "Li Wei", "b": "li  wei", "c": "Lí Wei", "d": " ", "e": " "}
    found = [Submission(one, "lab_1", Path(one), sha256=one) for one in names]
    noted = coincidences(found, {Path(one): name for one, name in names.items()}, {})
    assert {str(path): sentences for path, sentences in noted.items()} == {
        "a": ["the name in it, 'Li Wei', is also in b"],
        "b": ["the name in it, 'li  wei', is also in a"],
        "c": [],
        "d": [],
        "e": [],
    }


def test_a_name_that_cannot_be_read_is_none():
    notebook = with_name("Anna")
    for source in ("def my_name(", "def my_name():\n    return 3", "x = '\0'"):
        notebook.cells[-1].source = source
        assert written_name(notebook) == ""
    assert variants.written_name(nbformat.v4.new_notebook()) == ""
