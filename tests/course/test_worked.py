"""Worked answers of the chapters run, and numbers in prose come out of their cells."""

import ast
import re

import nbformat
import pytest

from mkt.course.book import checks, contents
from mkt.papers.lessons import (  # noqa: F401, they enter what they draw into pencil
    drawings,
    drawings_of_cameras,
    drawings_of_looks,
    pencil,
)
from tests.course import worked

BOOK = contents.read()
# The share of a chapter's numbers that must be held: what was reached, rounded down.  A
# number that no cell puts out lowers it.
HELD = {
    "01_color_histograms": 0.9,
    "02_cost_surfaces": 0.9,
    "03_your_own_video": 0.9,
    "04_multiple_kernel_ssd": 0.8,
    "05_particle_filter": 0.8,
    "06_combining_both": 0.8,
    "07_interaction_matrix": 0.9,
    "08_closing_the_loop": 0.9,
    "09_moving_target": 0.8,
    "10_color_particle_filter": 0.8,
    "11_losing_and_finding": 0.8,
    "12_learning_model": 0.8,
    "13_hybrid_resampling": 0.9,
    "14_fair_benchmark": 0.7,
    "15_more_than_colour": 0.8,
    "16_a_plane_in_space": 0.8,
    "17_four_wishes": 0.9,
}
every = pytest.mark.parametrize("chapter", BOOK.chapters, ids=lambda c: c.name)
# Letters of a first paragraph: half of a telephone's screen, see the test of pages.
SHORT = 480


def text(chapter):
    return nbformat.read(chapter.notebook, 4)


@pytest.mark.parametrize(
    "chapter", worked.of_today(BOOK.chapters), ids=lambda c: c.name
)
def test_answers_run_and_numbers_in_prose_are_held(chapter, answered, record_property):
    values = worked.values_of(worked.outputs(answered[chapter.name]))
    numbers = worked.in_prose(text(chapter))
    loose = [each for each in numbers if not worked.is_held(each[1], values)]
    share = 1 - len(loose) / len(numbers)
    record_property("held", share)
    print(f"{chapter.name}: {share:.0%} of {len(numbers)} numbers are held")
    print("\n".join(f"  {cell}: {number}" for cell, number in loose))
    assert share >= HELD[chapter.name]


@every
def test_cells_that_only_hold_numbers_are_not_on_the_page(chapter):
    on_page = {cell.id for cell in checks.on_page(text(chapter))}
    assert not [name for name in on_page if name.startswith("numbers")]


@every
def test_answers_are_python_and_no_lines_too_long(chapter):
    for cell, block in worked.answers(text(chapter)):
        ast.parse(block)
        assert max(map(len, block.splitlines())) <= 88, cell


@every
def test_every_exercise_has_stars_a_hint_and_an_answer(chapter):
    source = next(c.source for c in text(chapter).cells if c.id == "exercises")
    for exercise in re.split(r"^\*\*\d+\.\*\* ", source, flags=re.M)[1:]:
        assert re.match("★{1,3} ", exercise)
        assert exercise.count("<summary>Hint</summary>") == 1
        assert exercise.count("<summary>Answer</summary>") == 1


@every
def test_every_prediction_opens_to_an_answer(chapter):
    for cell in text(chapter).cells:
        for part in cell.source.split("### Predict before you move")[1:]:
            asked = re.findall(r"^\* ", part.partition("\n#")[0], re.M)
            opened = part.partition("\n#")[0].count("<summary>Answer")
            assert max(1, len(asked)) == opened, cell.id


@every
def test_a_chapter_says_for_whom_and_shows_its_mechanism_first(chapter):
    cells = {cell.id: cell for cell in text(chapter).cells}
    for words in ("**The question:**", "*For whom:*", "*Needs:*", "*Takes:*"):
        assert words in cells["opening"].source
    assert "Afterwards you can" in cells["opening"].source
    assert list(cells)[:2] == ["title", "drawing"]
    heading, paragraph = cells["title"].source.split("\n\n")
    assert heading.startswith("# ") and len(paragraph) <= SHORT
    number = chapter.name[:2]
    assert f".{pencil.DRAWINGS[number].__name__}()" in cells["drawing"].source


@every
def test_cells_are_short_and_no_figure_is_shown_twice(chapter):
    notebook = text(chapter)
    long = [c.id for c in checks.code_cells(notebook) if c.source.count("\n") >= 15]
    assert long == []
    shown = [name for _, names in checks.figure_cells(notebook) for name in names]
    assert len(set(shown)) == len(shown)


@every
def test_a_cell_that_draws_shows_no_name_of_an_object_of_matplotlib(chapter):
    """JupyterLab prints what the last line of a cell returns, unless it ends in ";"."""
    for cell in checks.code_cells(text(chapter)):
        last = ast.parse(cell.source).body[-1]
        names = {n.id for n in ast.walk(last) if isinstance(n, ast.Name)}
        if isinstance(last, ast.Expr) and names & {"ax", "axes", "left", "right"}:
            drawn_on = cell.source.splitlines()[-1].startswith(("mkt.", "print("))
            assert drawn_on or cell.source.endswith(";"), cell.id


@every
def test_under_every_printed_figure_stands_what_agrees(chapter):
    shown = [name for _, names in checks.figure_cells(text(chapter)) for name in names]
    printed = sum(not name.startswith("own.") for name in shown)
    said = sum("**Printed / ours" in cell.source for cell in text(chapter).cells)
    assert said >= min(printed, 1) and (printed < 2 or said >= printed // 2)


def test_a_number_is_held_as_it_is_rounded():
    assert worked.is_held(".58", [0.5849]) and not worked.is_held(".58", [0.5851])
    assert worked.is_held("94", [0.9375]) and worked.is_held("18.5", [-18.46])
    assert not worked.is_held("95", [0.9375, 94.4])


def test_what_counts_as_a_number_of_prose():
    cell = nbformat.v4.new_markdown_cell(
        "# 4. Title 55\n\nIn chapter 12 it is .58 px, $x = 3.5$ and `f(77)`, equation "
        "(13), by frame 40; 20 % are lost.\n\n```python\nx = 99\n```",
        id="a",
    )
    notebook = nbformat.v4.new_notebook(cells=[cell])
    assert worked.in_prose(notebook) == [("a", ".58"), ("a", "20")]
    assert worked.answers(notebook) == [("a", "x = 99\n")]
