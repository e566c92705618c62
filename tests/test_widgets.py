"""Sliders: the picture follows them, live and in the page, and nothing is asked of a network."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mkt import figures, page
from mkt.widgets import explore, show


@pytest.fixture(autouse=True)
def toy(monkeypatch):
    """A registered figure of one line, which fails at slope 3."""
    monkeypatch.setattr(figures, "_REGISTRY", dict(figures.registry()))
    drawn = []

    @figures.figure("toy.line", size=(3, 2), slope=(0, 20, 1), color=["red", "blue"])
    def line(canvas, *, slope=1, color="red", title="<a & b>"):
        """A line.

        Drawn for tests, with <angles>.
        """
        if slope == 3:
            raise ArithmeticError("no slope <three>")
        drawn.append(slope)
        canvas.subplots().plot([0, 1], [0, slope], color=color)
        return {"rise": slope}

    return drawn


@pytest.fixture
def static(monkeypatch):
    monkeypatch.setenv("MKT_STATIC", "1")


@pytest.fixture(autouse=True)
def live(monkeypatch):
    monkeypatch.delenv("MKT_STATIC", raising=False)


def test_show_is_a_picture_that_says_what_it_shows():
    data, metadata = show("toy.line", slope=2)._repr_png_()
    assert data.startswith("iVBOR")  # base64 of a PNG's first bytes
    assert metadata["alt"] == "A line. Drawn for tests, with <angles>."


def test_the_picture_follows_a_slider_and_comes_back():
    panel = explore("toy.line")
    first, slider = panel._image.value, panel._controls["slope"]
    slider.value = 7
    assert panel._image.value != first
    assert (panel.values["slope"], panel.numbers) == (7, {"rise": 7})
    slider.value = 1
    assert panel._image.value == first


def test_reset_draws_once(toy):
    panel = explore("toy.line")
    first = panel._image.value
    panel._controls["slope"].value, panel._controls["color"].value = 5, "blue"
    del toy[:]
    panel.reset()
    assert toy == [1]
    assert panel._image.value == first


def test_an_error_is_shown_in_the_panel_until_it_is_over():
    panel = explore("toy.line")
    panel._controls["slope"].value = 3
    assert "ArithmeticError: no slope &lt;three&gt;" in panel._trouble.value
    panel._controls["slope"].value = 4
    assert panel._trouble.value == ""


def test_two_panels_do_not_move_each_other():
    one, other = explore("toy.line"), explore("toy.line")
    before = other._image.value
    one._controls["slope"].value = 9
    assert other._image.value == before


@pytest.mark.parametrize("mode", ["0", "1"])
def test_fixed_parameters_keep_their_value_and_have_no_slider(mode, monkeypatch):
    monkeypatch.setenv("MKT_STATIC", mode)
    result = explore("toy.line", slope=6)
    assert (result.values["slope"], result.numbers) == (6, {"rise": 6})
    if mode == "1":
        assert 'data-name="slope"' not in result._repr_html_()
    else:
        assert list(result._controls) == ["color"]


@pytest.mark.parametrize("mode", ["0", "1"])
def test_mistakes_end_the_cell_with_the_known_names(mode, monkeypatch):
    monkeypatch.setenv("MKT_STATIC", mode)
    with pytest.raises(KeyError, match="no figure 'toy.circle'; there are .*toy.line"):
        explore("toy.circle")
    with pytest.raises(ValueError, match="no parameter 'slop'; it takes slope, color, title"):
        explore("toy.line", slop=1)
    with pytest.raises(ArithmeticError):
        explore("toy.line", slope=3)


def test_the_page_asks_nothing_of_a_network_and_keeps_its_ids_apart(static, monkeypatch):
    monkeypatch.setattr(page, "POSITIONS", 5)  # of which none is slope 3
    shown = explore("toy.line", title="x")
    text = shown._repr_html_() + shown._repr_html_()
    assert not re.search(r"https?:|src=[\"']//|url\(", text)
    ids = re.findall(r' id="([^"]+)"', text)
    assert len(ids) == len(set(ids)) == 6
    assert all(f'for="{id}"' in text for id in ids if id.count("-") > 2)


def test_the_page_has_a_frame_for_each_position_and_the_default_only_once(static, monkeypatch):
    monkeypatch.setattr(page, "POSITIONS", 5)
    shown = explore("toy.line")
    slope = shown._sliders["slope"]
    assert slope["labels"] == ["0", "1", "10", "15", "20"]
    assert slope["frames"][slope["start"]] == 0
    assert len(set(shown._frames)) == len(shown._frames) == 1 + 4 + 1


@given(st.integers(1, 300), st.data())
def test_the_positions_in_the_page_keep_first_last_and_default(count, data):
    values, default = list(range(count)), data.draw(st.integers(0, count - 1))
    chosen = page._spread(values, default)
    assert {0, count - 1, default} <= set(chosen)
    assert chosen == sorted(set(chosen)) and len(chosen) == min(count, page.POSITIONS)


@pytest.mark.parametrize("id", figures.registry())
def test_every_slider_of_the_book_stands_at_a_value_it_has(id):
    entry = figures.get(id)
    assert all(entry.defaults[name] in entry.values(name) for name in entry.sliders)
