"""nbgrader's own flow on our labs, as COURSE.md has it, where nbgrader is installed."""

import csv
import os
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest

from mkt.course import cli
from mkt.course.labs import notebooks
from mkt.course.labs.notebooks import of_role, released, role
from tests.course.toy_lab import GOOD, TOY, answer, graded, hand_in

WARNING = """
def add(a, b):
    import warnings
    warnings.warn("division by zero", RuntimeWarning)
    return a + b"""
STUDENTS = {
    "anna": answer(**GOOD),
    "ben": answer(add="def add(a, b):\n    return 3", why=GOOD["why"]),
    "cara": answer(),
    "dora": answer(**GOOD | {"check_six": "assert True"}),
    "emil": answer(**GOOD | {"add": WARNING}),
}


def nbgrader(course, *words):
    """What nbgrader says to some words, in a course."""
    done = subprocess.run(
        [sys.executable, "-m", "nbgrader", *words],
        cwd=course,
        env=os.environ
        | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stderr


@pytest.fixture
def course(toy):
    """A course of nbgrader's, with the toy lab generated and submitted."""
    pytest.importorskip("nbgrader")
    assert not cli.run(cli.parse(["labs", "nbgrader", "-o", str(toy / "course")]))
    nbgrader(toy / "course", "generate_assignment", "toy")
    for student, notebook in STUDENTS.items():
        hand_in(toy / "course" / "submitted" / student / "toy" / "toy.ipynb", notebook)
    return toy / "course"


def test_the_course_has_every_lab_as_a_source_and_nothing_is_written_over(toy):
    for _ in range(2):
        try:
            cli.run(cli.parse(["labs", "nbgrader", "-o", str(toy / "course")]))
        except SystemExit as error:
            assert "it is there already" in str(error)
    source = nbformat.read(toy / "course" / "source" / "toy" / "toy.ipynb", 4)
    assert source.cells == TOY.cells
    configuration = (toy / "course" / "nbgrader_config.py").read_text()
    compile(configuration, "config", "exec")
    # A check of nbgrader's that writes a warning has no points.
    assert 'os.environ["PYTHONWARNINGS"] = "ignore"\n' in configuration


def test_no_source_of_a_real_lab_says_that_it_is_the_teachers(tmp_path):
    written = notebooks.for_nbgrader(tmp_path / "course")
    assert len(written) == 1 + len(notebooks.labs())
    assert not [path for path in written if "teacher's version" in path.read_text()]


@pytest.mark.slow
def test_nbgrader_releases_what_we_release(course):
    release = nbformat.read(course / "release" / "toy" / "toy.ipynb", 4)
    assert [cell.source for cell in release.cells] == [
        cell.source for cell in released(TOY).cells
    ]
    for theirs, ours in zip(release.cells, released(TOY).cells, strict=True):
        if role(ours):
            meta = theirs.metadata["nbgrader"]
            assert meta["checksum"] == ours.metadata["nbgrader"]["checksum"]


@pytest.mark.slow
def test_nbgrader_gives_the_same_points_and_a_page_for_each_student(course):
    nbgrader(course, "autograde", "toy")
    nbgrader(course, "export")
    with (course / "grades.csv").open(newline="") as file:
        theirs = {
            row["student_id"]: float(row["score"]) for row in csv.DictReader(file)
        }
    trusted = "--trust-the-students"  # in whichever environment nbgrader is
    ours = graded(course / "submitted", course / "ours.csv", trusted)
    assert theirs == {student: float(row["points"]) for student, row in ours.items()}
    assert theirs == {"anna": 3, "ben": 0, "cara": 0, "dora": 3, "emil": 3}
    nbgrader(course, "generate_feedback", "toy")
    for student in STUDENTS:
        page = course / "feedback" / student / "toy" / "toy.html"
        assert "check_add" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize("lab", notebooks.labs())
def test_a_released_lab_has_the_checksums_of_nbgrader(lab):
    utils = pytest.importorskip("nbgrader.utils")
    cells = of_role(
        released(notebooks.labs()[lab]), "check", "question", "solution", "given"
    )
    assert cells
    for cell in cells.values():
        assert utils.compute_checksum(cell) == cell.metadata["nbgrader"]["checksum"]
