"""Slides that are made of chapters."""

import base64
import io
import re

import nbformat
import pytest
from PIL import Image

from mkt.course import cli, slides
from mkt.course.book import contents
from mkt.figures.registry import FIGURES
from mkt.plotting import in_style

BOOK = contents.read()
each_chapter = pytest.mark.parametrize(
    "chapter", BOOK.chapters, ids=lambda chapter: chapter.name
)


@each_chapter
def test_every_chapter_has_a_question_goals_all_of_its_figures_and_takeaways(chapter):
    found = slides.slides(chapter)
    titles = [slide.title for slide in found]
    assert {"The question", "Afterwards you can", "Takeaways"} <= {*titles}
    shown = {one.figure for one in found if one.figure}
    assert shown | {"own.video"} == {*chapter.figures, "own.video"}  # that is a panel
    assert [
        slide.title for slide in found if slide.kind == "text" and not slide.text
    ] == []


def test_a_figure_that_a_chapter_shows_twice_has_one_slide():
    again = [nbformat.v4.new_code_cell('mkt.show("teuliere2009.fig1")') for _ in "ab"]
    found = [slide.figure for slide in slides._body(again)]
    assert found == ["teuliere2009.fig1"]


def test_an_answer_follows_the_first_figure_alone():
    predict = "## Predict: more?\n\nLook.\n<details><summary>A</summary>Yes.</details>"
    figures = [f'mkt.show("teuliere2009.fig{k}")' for k in (1, 2)]
    cells = [nbformat.v4.new_markdown_cell(predict)]
    cells += map(nbformat.v4.new_code_cell, figures)
    kinds = [slide.kind for slide in slides._body(cells)]
    assert kinds == ["text", "figure", "text", "figure"]


def test_equations_of_exercises_are_no_slide():
    text = "## Exercises\n\n$$ x = 1 $$\n"
    assert not list(slides._equations(text, ""))
    assert list(slides._equations(text.replace("Exercises", "The sum"), ""))


def test_equations_of_a_folded_answer_are_no_slide():
    text = "## The sum\n\n$$ x = 1 $$\n\n<details>\n\n$$ y = 2 $$\n\n</details>\n"
    (slide,) = slides._equations(text, "")
    assert "x = 1" in slide.text and "y = 2" not in slide.text


def test_a_prediction_comes_before_its_figure_and_its_answer_after_it():
    kinds = [slide.title for slide in slides.slides(slides.chosen(BOOK, [2])[0])]
    ask = next(k for k, title in enumerate(kinds) if title.startswith("Predict"))
    assert kinds[ask + 2] == "What you should have seen"


def test_equations_are_drawn_and_no_link_leads_to_a_notebook(monkeypatch):
    monkeypatch.setattr(slides, "_picture", lambda name: "data:," if name else "")
    page = slides.page(BOOK, slides.chosen(BOOK, [1])[0])
    assert page.count("<svg") > 5 and "$" not in re.sub(r'aria-label="[^"]*"', "", page)
    assert ".ipynb" not in page and "http://" not in re.sub(r"xmlns\S+", "", page)
    assert page.count("<section") == page.count("<footer>") > 6


def test_the_command_writes_the_chapters_that_are_named_and_nothing_over(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(slides, "_picture", lambda name: "")
    words = ["slides", "2", "-o", str(tmp_path / "deck")]
    assert not cli.run(cli.parse(words))
    assert capsys.readouterr().out.strip().endswith("02_cost_surfaces.html")
    with pytest.raises(SystemExit, match="is there already"):
        cli.run(cli.parse(words))
    words = ["slides", "1", "2", "-o", str(tmp_path / "deck")]
    with pytest.raises(SystemExit, match="02_cost_surfaces.html is there already"):
        cli.run(cli.parse(words))
    assert [path.stem for path in (tmp_path / "deck").iterdir()] == ["02_cost_surfaces"]
    with pytest.raises(SystemExit, match="no chapter 99"):
        cli.run(cli.parse(["slides", "99", "-o", str(tmp_path / "deck")]))
    assert [one.part for one in slides.chosen(BOOK, [])] == [*BOOK.parts]


def test_a_figure_is_in_the_page_itself_and_lighter_than_matplotlibs():
    kind, picture = slides._picture("teuliere2009.fig1").split(",")
    assert kind == "data:image/png;base64"
    plain = io.BytesIO()
    with in_style():
        FIGURES["teuliere2009.fig1"].draw(slides.DPI)[0].savefig(plain, format="png")
    light = base64.b64decode(picture)
    assert len(light) < len(plain.getvalue())
    mine, theirs = (
        Image.open(each).convert("RGB").tobytes() for each in (io.BytesIO(light), plain)
    )
    assert mine == theirs


def test_a_drawn_formula_does_not_make_a_short_text_a_long_one(monkeypatch):
    """Chapter 14 asks one line with a formula in it; chapter 4 has a long answer."""
    monkeypatch.setattr(slides, "_picture", lambda name: "")
    fair, ssd = (slides.page(BOOK, slides.chosen(BOOK, [n])[0]) for n in (14, 4))
    (asked,) = re.findall(
        r'<section class="([^"]*)"[^>]*>\s*<h2>[^<]*every limit', fair
    )
    assert asked == "text" and 'class="text long"' in ssd
