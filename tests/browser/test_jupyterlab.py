"""Every figure of the chapters in JupyterLab, in a real browser.

They run, a slider of each moves the picture there and back, films play.  All cells of
all chapters have run already when the book was made, and all films have played on its
pages; here run a chapter with films and another one, and the figures of
half of the others, which stand together in two notebooks: the other half tomorrow.
"""

import shutil

import nbformat
import pytest

from mkt.course.book import checks, contents
from tests.browser import jupyterlab
from tests.lot import DAY

pytestmark = pytest.mark.slow

BOOK = contents.read()
PATIENCE = 600  # [s] for all cells of a notebook
WITH_FILMS = "07_interaction_matrix", "09_moving_target"
WITHOUT = "01_color_histograms", "03_your_own_video"  # that with the workbench
WHOLE = WITH_FILMS[DAY % 2], WITHOUT[DAY % 2]
OTHERS = [c for c in BOOK.chapters if c.name not in WITH_FILMS + WITHOUT]
# A kernel and a JupyterLab for each chapter take longer than its figures do.
TOGETHER = {f"figures_{k}": OTHERS[DAY % 2 + 2 * k :: 4] for k in range(2)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Copies of the notebooks that run whole, and the figures of the others."""
    copied = tmp_path_factory.mktemp("lab") / "notebooks"
    copied.mkdir()
    for name in WHOLE:
        shutil.copy(contents.NOTEBOOKS / f"{name}.ipynb", copied)
    for name, chapters in TOGETHER.items():
        nbformat.write(figures_of(chapters), copied / f"{name}.ipynb")
    return copied


def figures_of(chapters):
    """A notebook of nothing but the figures of some chapters."""
    notebook = nbformat.v4.new_notebook()
    notebook.cells.append(nbformat.v4.new_code_cell("import mkt", id="import"))
    for chapter in chapters:
        source = nbformat.read(chapter.notebook, 4)
        notebook.metadata = source.metadata
        for cell, _ in checks.figure_cells(source):
            cell.id = f"{chapter.name[:2]}-{cell.id}"
            notebook.cells.append(cell)
    return notebook


@pytest.fixture(scope="module")
def address(folder):
    """Of a JupyterLab on the notebooks."""
    with jupyterlab.serving(folder) as address:
        yield address


@pytest.fixture(scope="module", params=[*WHOLE, *TOGETHER])
def opened(request, folder, address, browser, pictures):
    """A notebook that was opened and run."""
    page = browser.new_page(viewport={"width": 1400, "height": 1000})
    notebook = jupyterlab.Notebook(page, address, folder / f"{request.param}.ipynb")
    notebook.run_all(PATIENCE)
    yield notebook
    page.screenshot(path=pictures / f"jupyterlab-{request.param}.png")
    notebook.close()


def test_every_cell_runs(opened):
    assert opened.errors() == []


# Controls of live figures that are left out, by a control that tells the figure.
LEFT_OUT = {
    # The film keeps its past: what is changed holds from that frame on.
    "beats per second": {"beats per second", "frame", "particles", "wall [px]"},
    # Each is twenty-five runs anew.
    "frames behind the wall": {"frames behind the wall", "path"},
}


def movable(controls):
    """The controls of a figure without those that are left out."""
    out = [LEFT_OUT.get(control.name, set()) for control in controls]
    return [each for each in controls if each.name not in set().union(*out)]


def test_a_slider_of_every_figure_changes_the_picture_and_changes_it_back(opened):
    """Another one each day: one program joins all sliders of a figure to its picture.

    On the pages of the book every slider of a drawn figure is moved, and what all of
    them change together is drawn without a browser.
    """
    still = []
    for figure in opened.figures():
        controls = movable(jupyterlab.controls(figure))
        if not controls:
            continue
        control = controls[DAY % len(controls)]
        figure.scroll_into_view_if_needed()  # or nobody may have drawn it yet
        before, position = control.picture(), control.position()
        control.step()
        if control.picture(other_than=before) == before:
            still.append(control.name)
        control.put(position)
        if control.picture_again(before) != before:
            still.append(f"{control.name}, back")
    assert still == []


def test_chapters_with_films_are_among_those_that_run_whole():
    films = {c.name for c in BOOK.chapters if "play(" in c.notebook.read_text()}
    assert films >= set(WITH_FILMS)


def test_every_film_plays(opened):
    films = [
        film.evaluate(jupyterlab.PLAYED) for film in opened.page.locator("video").all()
    ]
    assert all(after > before for before, after in films)
    assert len(films) == opened.source.count("play(")
