"""Every figure of the chapters in JupyterLab, in a real browser.

They run, their sliders move the pictures there and back, films play.  All cells of all
chapters have run already when the book was made, and all films have played on its
pages; here run two chapters with films, that with the workbench, and the first, while
of the others the figures will do.
"""

import shutil

import nbformat
import pytest

from mkt.course.book import checks, contents
from tests.browser import jupyterlab

pytestmark = pytest.mark.slow

BOOK = contents.read()
WHOLE = (
    "01_color_histograms",
    "03_your_own_video",
    "07_interaction_matrix",
    "09_moving_target",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A copy of the notebooks."""
    copied = tmp_path_factory.mktemp("lab") / "notebooks"
    shutil.copytree(contents.NOTEBOOKS, copied)
    for one in BOOK.chapters:
        if one.name not in WHOLE:
            keep_figures(copied / one.notebook.name)
    return copied


def keep_figures(path):
    """Leave a notebook its figures alone."""
    notebook = nbformat.read(path, 4)
    shown = [cell for cell, _ in checks.figure_cells(notebook)]
    notebook.cells = [nbformat.v4.new_code_cell("import mkt", id="import"), *shown]
    nbformat.write(notebook, path)


@pytest.fixture(scope="module")
def address(folder):
    """Of a JupyterLab on the notebooks."""
    with jupyterlab.serving(folder) as address:
        yield address


@pytest.fixture(scope="module", params=BOOK.chapters, ids=lambda chapter: chapter.name)
def chapter(request, folder, address, browser, pictures):
    """A chapter that was opened and run."""
    page = browser.new_page(viewport={"width": 1400, "height": 1000})
    notebook = folder / request.param.notebook.name
    opened = jupyterlab.Chapter(page, address, notebook)
    opened.run_all(request.param.timeout)
    yield opened
    page.screenshot(path=pictures / f"jupyterlab-{request.param.name}.png")
    opened.close()


def test_every_cell_runs(chapter):
    assert chapter.errors() == []


# Controls of live figures that are left out, by a control that tells the figure.
LEFT_OUT = {
    # The film keeps its past: what is changed holds from that frame on.
    "beats a second": {"beats a second", "frame", "particles", "wall [px]"},
    # Each is twenty-five runs anew.
    "frames behind the wall": {"frames behind the wall", "path"},
}


def test_every_slider_changes_the_picture_and_changes_it_back(chapter):
    still = []
    for figure in chapter.figures():
        controls = jupyterlab.controls(figure)
        out = [LEFT_OUT.get(control.name, set()) for control in controls]
        for control in controls:
            if control.name in set().union(*out):
                continue
            position, before = control.position(), control.picture()
            control.step()
            moved = control.picture(other_than=before)
            control.put(position)
            back = control.picture_again(before)
            if moved == before:
                still.append(control.name)
            if back != before:
                still.append(f"{control.name}, back")
    assert still == []


def test_chapters_with_films_are_among_those_that_run_whole():
    films = {c.name for c in BOOK.chapters if "play(" in c.notebook.read_text()}
    assert len(films & set(WHOLE)) == 2


def test_every_film_plays(chapter):
    films = [
        film.evaluate(jupyterlab.PLAYED) for film in chapter.page.locator("video").all()
    ]
    assert all(after > before for before, after in films)
    assert len(films) == chapter.source.count("play(")
