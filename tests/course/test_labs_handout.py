"""`labs handout`: what a student gets runs by itself, and gives nothing away."""

import os
import re
import shutil
import subprocess
import sys
import urllib.parse
import zipfile
from pathlib import Path

import nbformat
import pytest

from mkt.course import cli
from mkt.course.labs import handout, notebooks, table
from mkt.files import ROOT
from tests.course.toy_lab import hand_in


@pytest.fixture(scope="module")
def given(tmp_path_factory):
    """The folder that students get."""
    folder = tmp_path_factory.mktemp("handout") / "course"
    assert handout.write(folder) == [folder, folder.with_name("course.zip")]
    return folder


def test_nothing_in_it_knows_a_solution_or_a_hidden_check(given):
    assert not (given / "notebooks" / "labs").exists()
    assert not (given / "tests").exists() and not (given / ".git").exists()
    assert not (given / "COURSE.md").exists()  # it is the teacher's
    for title, lab in notebooks.labs().items():
        for folder in ("handout", "handout/.originals"):
            path = given / "notebooks" / folder / f"{title}.ipynb"
            text = path.read_text(encoding="utf-8")
            assert nbformat.reads(text, 4).cells == notebooks.released(lab).cells
            assert "BEGIN SOLUTION" not in text and "HIDDEN TESTS" not in text


def test_it_has_chapters_labs_and_the_two_commands_also_in_the_zip(given):
    names = zipfile.ZipFile(given.with_name("course.zip")).namelist()
    assert "course/notebooks/01_color_histograms.ipynb" in names
    assert "course/notebooks/handout/lab_1_histograms_and_kernels.ipynb" in names
    text = (given / "README.md").read_text(encoding="utf-8")
    assert "python3 -m mkt lab\n" in text and "python3 -m mkt labs check" in text


def test_its_readme_names_the_papers_that_the_labs_cite(given):
    labs = (given / "notebooks" / "handout").glob("*.ipynb")
    cited = {
        paper
        for lab in labs
        for paper in re.findall(r"\[[A-Z]\d\d\]", lab.read_text(encoding="utf-8"))
    }
    text = (given / "README.md").read_text(encoding="utf-8")
    assert cited == {"[T09]", "[N03]", "[C14]"}
    assert [paper for paper in sorted(cited) if paper not in text] == []


def test_what_the_links_for_servers_open_is_in_it(given):
    course = (ROOT / "COURSE.md").read_text(encoding="utf-8")
    links = [
        urllib.parse.unquote(link)
        for link in re.findall(r"https://[^`)]+", course)
        if "urlpath=" in link
    ]
    assert {urllib.parse.urlsplit(link).netloc for link in links} == {
        "mybinder.org",
        "HUB",
    }
    for link in links:
        opened = link.partition("urlpath=")[2].partition("&")[0]
        path = opened.removeprefix("lab/tree/").removeprefix("REPOSITORY/")
        assert (given / path).is_file(), link
    assert (given / ".binder" / "requirements.txt").is_file()


def test_a_repository_made_of_it_has_the_labs(given, tmp_path):
    """For Binder and nbgitpuller; what a session leaves is still no part of it."""
    course = tmp_path / "course"
    shutil.copytree(given, course)
    (course / ".venv").mkdir()
    (course / ".venv" / "pyvenv.cfg").write_text("")
    git = ["git", "-C", str(course)]
    for words in (["init", "-q"], ["add", "-A"]):
        subprocess.run([*git, *words], check=True)
    listed = subprocess.run([*git, "ls-files"], capture_output=True, text=True)
    names = listed.stdout.split()
    for title in notebooks.labs():
        assert f"notebooks/handout/{title}.ipynb" in names
        assert f"notebooks/handout/.originals/{title}.ipynb" in names
    assert "mkt/__init__.py" in names and ".binder/postBuild" in names
    assert not [name for name in names if name.startswith((".venv", ".github"))]


def run_alone(given, *words, command="labs"):
    """What a command says that is run in the handout, and with nothing else."""
    code = "import sys; from mkt.course.cli import *; run(parse(sys.argv[1:]))"
    done = subprocess.run(
        [sys.executable, "-c", code, command, *words],
        cwd=given,
        env=os.environ | {"PYTHONPATH": str(given)},
        capture_output=True,
        text=True,
    )
    return done.stdout + done.stderr


@pytest.mark.slow
def test_a_lab_is_checked_from_it_alone_and_what_was_deleted_is_restored(given):
    lab = given / "notebooks" / "handout" / "lab_1_histograms_and_kernels.ipynb"
    notebook = nbformat.read(lab, 4)
    gone = {"imports", "check-kernel"}
    notebook.cells = [cell for cell in notebook.cells if cell.id not in gone]
    mine = given.with_name("mine.ipynb")
    nbformat.write(notebook, mine)
    said = run_alone(given, "check", str(mine))
    assert "0 of 3  check_kernel: not written yet" in said, said
    assert "imports: was deleted, the original counts" in said


def test_a_fresh_copy_of_a_lab_comes_from_it_alone(given, tmp_path):
    run_alone(given, "release", "-o", str(tmp_path))
    title, lab = next(iter(notebooks.labs().items()))
    fresh = nbformat.read(tmp_path / f"{title}.ipynb", 4)
    assert fresh.cells == notebooks.released(lab).cells


def test_it_is_written_nowhere_where_something_is(given):
    with pytest.raises(SystemExit, match="is there already; choose another name"):
        cli.run(cli.parse(["labs", "handout", "-o", str(given)]))
    with pytest.raises(SystemExit, match="choose a place outside"):
        cli.run(cli.parse(["labs", "handout", "-o", str(handout.ROOT / "course")]))


def test_a_file_that_is_missing_is_named_before_anything_is_written(
    tmp_path, monkeypatch
):
    clone = tmp_path / "clone"
    clone.mkdir()
    (clone / "LICENSE").write_text("free")
    (clone / "CITATION.cff").write_text("cite")
    for words in (["init", "-q"], ["add", "-A"]):
        subprocess.run(["git", "-C", str(clone), *words], check=True)
    (clone / "CITATION.cff").unlink()
    monkeypatch.setattr(handout, "ROOT", clone)
    for _ in range(2):
        with pytest.raises(ValueError, match=r"CITATION.cff: not there, .*git restore"):
            handout.write(tmp_path / "course")
    assert [path.name for path in tmp_path.iterdir()] == ["clone"]


def test_what_the_teacher_ran_is_not_in_it(tmp_path, monkeypatch):
    """Neither in a chapter nor in a lab."""
    clone = tmp_path / "clone"
    session = nbformat.v4.new_notebook(
        metadata={"mine": 1},
        cells=[
            nbformat.v4.new_code_cell(
                "1 + 1",
                execution_count=7,
                outputs=[nbformat.v4.new_output("stream", text="secret")],
            )
        ],
    )
    for place in ("notebooks/01_x.ipynb", "notebooks/labs/lab_1_x.ipynb"):
        hand_in(clone / place, session)
    hand_in(clone / ".gitignore", "")
    for words in (["init", "-q"], ["add", "-Af"]):
        subprocess.run(["git", "-C", str(clone), *words], check=True)
    monkeypatch.setattr(notebooks, "FOLDER", clone / "notebooks" / "labs")
    monkeypatch.setattr(handout, "ROOT", clone)
    for place in ("HANDOUT", "ORIGINALS"):
        monkeypatch.setattr(handout, place, clone / "notebooks" / place.lower())
    folder, archive = handout.write(tmp_path / "course")
    found = sorted(folder.rglob("*.ipynb"))
    assert len(found) == 3
    for path in found:
        assert "secret" not in path.read_text(encoding="utf-8")
        (cell,) = nbformat.read(path, 4).cells
        assert cell.execution_count is None and cell.source == "1 + 1"
    assert "secret" not in zipfile.ZipFile(archive).read(
        "course/notebooks/01_x.ipynb"
    ).decode("utf-8")


def test_what_only_the_makers_need_is_left_out():
    assert not [name for name in handout._files() if name.startswith(".ci")]
    for one in ("tests", ".ci", ".github", "notebooks/labs"):
        assert handout._left_out(f"{one}/x") and not handout._left_out(f"{one}x")


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_nothing_is_left_behind_when_the_writing_stops(tmp_path, monkeypatch, error):
    def stops(*_):
        (tmp_path / "course.zip").write_text("half")
        raise error

    monkeypatch.setattr(handout.shutil, "make_archive", stops)
    with pytest.raises(error):
        handout.write(tmp_path / "course")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "written, what",
    [
        (notebooks.release, "labs to release; ask your teacher"),
        (notebooks.for_nbgrader, "labs with their solutions; a teacher's clone"),
    ],
)
def test_where_there_are_no_labs_nothing_is_written(
    written, what, tmp_path, monkeypatch
):
    monkeypatch.setattr(notebooks, "FOLDER", tmp_path / "none")
    with pytest.raises(ValueError, match=f"there are no {what}"):
        written(tmp_path / "new")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("more", [["--merge"], [".", "--trust-the-students"]])
def test_without_the_solutions_nothing_is_graded_and_no_total_is_lost(
    more, tmp_path, monkeypatch
):
    monkeypatch.setattr(notebooks, "FOLDER", tmp_path / "none")
    grades = tmp_path / "grades.csv"
    row = dict.fromkeys(table.NEEDED, "") | {"student": "ada", "total": "3"}
    table.write(grades, row, [row], ",")
    before = grades.read_bytes()
    with pytest.raises(SystemExit, match="no labs with their solutions; a teacher's"):
        cli.run(cli.parse(["labs", "grade", *more, "-o", str(grades)]))
    assert grades.read_bytes() == before


def test_the_tests_are_said_to_be_in_a_clone_alone(given):
    said = run_alone(given, command="test")
    assert "has no tests, which only a clone of the repository has" in said


def test_a_course_that_was_stopped_half_way_is_not_in_the_way(tmp_path, monkeypatch):
    write, written = Path.write_text, []

    def stopped(path, *args, **more):
        written.append(path)
        if len(written) == 3:
            raise KeyboardInterrupt
        return write(path, *args, **more)

    monkeypatch.setattr(Path, "write_text", stopped)
    with pytest.raises(KeyboardInterrupt):
        notebooks.for_nbgrader(tmp_path / "course")
    assert len(written) == 3 and not (tmp_path / "course").exists()
