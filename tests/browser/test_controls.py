"""Typing beside a slider, and drawing a box, as a reader does in JupyterLab."""

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_notebook

from mkt.figures.tooltips import WORDS, title
from tests.browser import jupyterlab
from tests.own_video import films

pytestmark = pytest.mark.slow

CELLS = (
    "import mkt\nmkt.explore('own.newton', layout='3x3')",
    "panel = mkt.workbench()\npanel.source.listed.value = 'car.mkv'\npanel",
    # An echo from Python would make a new object of what the browser has changed.
    "from ipywidgets.widgets import widget\nwidget.JUPYTER_WIDGETS_ECHO = False\n"
    "live = mkt.explore('own.root_locus')\n"
    "note = lambda change: open('told.txt', 'a').write(f'{live.values[\"gain\"]} ')\n"
    "live.observe(note, 'moved')\nlive",
)
CANVAS = ".mkt-box-canvas"


@pytest.fixture(scope="module")
def opened(browser, tmp_path_factory, pictures):
    """A notebook with one panel and the workbench, on a film of a car."""
    folder = tmp_path_factory.mktemp("controls")
    films.write(folder / "car.mkv", films.driving(3).frames)
    notebook = new_notebook(cells=[new_code_cell(text) for text in CELLS])
    notebook.metadata.kernelspec = {"name": "python3", "display_name": "Python 3"}
    nbformat.write(notebook, folder / "controls.ipynb")
    with jupyterlab.serving(folder) as address:
        page = browser.new_page(viewport={"width": 1400, "height": 2200})
        notebook = jupyterlab.Notebook(page, address, folder / "controls.ipynb")
        notebook.run_all(120)
        notebook.folder = folder
        yield notebook
        page.screenshot(path=pictures / "jupyterlab-controls.png")
        notebook.close()


@pytest.mark.parametrize(
    "name, typed, shown", [("dx", "41", "40"), ("scale", "1.59", "1.60")]
)
def test_a_number_typed_beside_a_slider_counts_at_the_nearest_step(
    opened, name, typed, shown
):
    figure, _ = opened.figures()
    control = {one.name: one for one in jupyterlab.controls(figure)}[title(name)]
    before = control.picture()
    number = control._box.locator(".widget-readout")
    number.click()
    opened.page.keyboard.press("Control+A")
    opened.page.keyboard.type(typed)
    opened.page.keyboard.press("Enter")
    assert control.picture(other_than=before) != before
    assert number.text_content() == shown
    assert control.position() == float(shown)
    label = control._box.locator("label")
    assert label.get_attribute("title") == WORDS[name]


def test_python_is_told_every_move_of_a_live_figure(opened):
    number = opened.page.get_by_label("gain [1/s], as a number")
    for gain in ("3", "2"):
        number.fill(gain)
        number.press("Enter")
        opened.page.wait_for_timeout(500)
    assert (opened.folder / "told.txt").read_text().split() == ["3.0", "2.0"]


def drag(page, start, end, shift=False):
    """Drag on the picture, in its own pixels; returns the box x, y, w, h."""
    place = page.locator(CANVAS).bounding_box()
    scale = place["width"] / 160

    def at(point):
        return place["x"] + point[0] * scale, place["y"] + point[1] * scale

    page.mouse.move(*at(start))
    page.mouse.down()
    page.mouse.move(*at(end), steps=4)
    page.mouse.up()
    fields = page.locator(".mkt-box-field").all()
    return [float(field.input_value()) for field in fields[:4]]


def test_the_first_drag_draws_the_next_ones_move_resize_or_draw_anew(opened):
    page = opened.page
    page.locator(CANVAS).scroll_into_view_if_needed()
    fields = page.locator(".mkt-box-field").all()
    assert [field.input_value() for field in fields[2:4]] == ["0", "0"]
    # From a corner of the middle third, where a box once stood by itself.
    assert drag(page, (60, 45), (100, 75)) == pytest.approx([60, 45, 40, 30], abs=1)
    assert drag(page, (80, 60), (90, 65)) == pytest.approx([70, 50, 40, 30], abs=1)
    assert drag(page, (110, 80), (120, 100)) == pytest.approx([70, 50, 50, 50], abs=1.5)
    assert drag(page, (10, 10), (30, 40)) == pytest.approx([10, 10, 20, 30], abs=1)
