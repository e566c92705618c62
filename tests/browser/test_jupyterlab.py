"""Every chapter in JupyterLab, in a real browser.

It runs, its sliders move the pictures there and back, its films play.
"""

import shutil

import pytest

from mkt.course.book import contents
from tests.browser import jupyterlab

pytestmark = pytest.mark.slow

BOOK = contents.read()


@pytest.fixture(scope="module")
def address(browser, tmp_path_factory):
    """Of a JupyterLab on a copy of the notebooks."""
    folder = shutil.copytree(
        contents.NOTEBOOKS, tmp_path_factory.mktemp("lab") / "notebooks"
    )
    with jupyterlab.serving(folder) as address:
        yield address


@pytest.fixture(scope="module", params=BOOK.chapters, ids=lambda chapter: chapter.name)
def chapter(request, address, browser, pictures):
    """A chapter that was opened and run."""
    page = browser.new_page(viewport={"width": 1400, "height": 1000})
    opened = jupyterlab.Chapter(page, address, request.param.notebook)
    opened.run_all(request.param.timeout)
    yield opened
    page.screenshot(path=pictures / f"jupyterlab-{request.param.name}.png")
    opened.close()


def test_every_cell_runs(chapter):
    assert chapter.errors() == []


def test_every_slider_changes_the_picture_and_changes_it_back(chapter):
    still = []
    for figure in chapter.figures():
        for control in jupyterlab.controls(figure):
            position, before = control.position(), control.picture()
            control.step()
            moved = control.picture(other_than=before)
            control.put(position)
            back = control.picture(other_than=moved)
            if moved == before:
                still.append(control.name)
            if back != before:
                still.append(f"{control.name}, back")
    assert still == []


def test_every_film_plays(chapter):
    films = [
        film.evaluate(jupyterlab.PLAYED) for film in chapter.page.locator("video").all()
    ]
    assert all(after > before for before, after in films)
    assert len(films) == chapter.source.count("play(")
