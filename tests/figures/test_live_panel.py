"""Live figures in JupyterLab: the kernel's half."""

import json
import re
from unittest.mock import Mock

import pytest

from mkt.figures import explore, live, live_panel
from mkt.figures.captions import marked
from mkt.figures.live_panel import LivePanel
from mkt.figures.panel import Panel
from mkt.figures.registry import FIGURES
from mkt.figures.tooltips import WORDS, title

LIVE = [name for name, entry in FIGURES.items() if entry.live]


@pytest.fixture
def panel():
    """Figure 3, and what it sends."""
    panel = explore("teuliere2009.fig3")
    panel.sent = []
    panel.send = panel.sent.append
    return panel


def test_what_has_a_fixed_value_is_drawn_by_the_kernel():
    assert isinstance(explore("teuliere2009.fig3"), LivePanel)
    assert isinstance(explore("teuliere2009.fig3", seed=0), Panel)


@pytest.mark.parametrize("name", LIVE)
def test_parts_that_a_telephone_shows_one_below_the_other_are_not_left_and_right(name):
    caption = FIGURES[name].live_caption
    assert not re.search(r"\b(left(?! over)|right)\b", caption, re.I)


def test_a_caption_says_where_things_are_in_the_page():
    entry = FIGURES["teuliere2009.fig1"]
    ours = "Our copy of the paper lacks the page with figure 1, so this one is ours."
    assert entry.caption.startswith("Left, a rendered frame") and ours in entry.caption
    assert "In the page" not in entry.caption + entry.live_caption
    assert entry.live_caption.startswith("Above, a rendered frame")
    assert entry.live_caption.endswith(ours) and "Left" not in entry.live_caption
    assert explore(entry.name).caption.endswith(marked(entry.live_caption))
    same = FIGURES["own.beats"]
    assert same.live_caption == same.caption


@pytest.mark.parametrize("name", LIVE)
def test_a_figure_begins_with_what_it_needs(name):
    entry = FIGURES[name]
    first = explore(name).first
    assert set(first) == set(entry.live)
    fields = first[name]["fields"]
    assert set(fields) == set(entry.sliders)
    assert all(fields[slider]["words"] == WORDS[slider] for slider in fields)
    assert all(fields[slider]["title"] == title(slider) for slider in fields)
    json.dumps(first, allow_nan=False)


@pytest.mark.parametrize("name", LIVE)
def test_the_controls_of_a_figure_begin_at_its_defaults(name):
    begun = explore(name)
    fields = begun.first[name]["fields"]
    begun.moved = {slider: field["value"] for slider, field in fields.items()}
    assert begun.values == FIGURES[name].defaults


def test_values_are_as_the_function_takes_them(panel):
    assert panel.values == FIGURES["teuliere2009.fig3"].defaults
    panel.moved = {"layout": "2x2", "span": 1, "extent": 30.0}
    assert panel.values["layout"] == "2x2"
    assert repr(panel.values["span"]) == "1.0"
    assert repr(panel.values["extent"]) == "30"
    newton = explore("own.newton")
    newton.moved = {"derivative_of_c": "no"}
    assert newton.values["derivative_of_c"] is False


def test_numbers_that_python_offers_as_a_list_move_freely_in_the_browser():
    locus = explore("own.root_locus")
    told = {"gain": 1.35, "delay": 5, "compensation": "raw", "fps": 7.5, "mismatch": 1}
    locus.moved = told
    assert locus.values == told
    assert repr(locus.values["delay"]) == "5"
    assert locus.shown.table.equals(locus._entry.draw(**told)[1].table)


def test_shown_is_pythons_for_the_same_values(panel):
    panel.moved = {"layout": "one", "extent": 10}
    wanted = panel._entry.draw(layout="one", extent=10)[1]
    assert panel.shown.table.equals(wanted.table)


def test_the_browser_gets_the_data_that_it_asks_for(panel):
    panel._asked(panel, {"name": "surfaces-cat-rgb"}, [])
    (answer,) = panel.sent
    assert answer["name"] == "surfaces-cat-rgb"
    assert answer["data"] == live.content("surfaces-cat-rgb")
    with pytest.raises(ValueError, match="no data of a live figure 'surfaces-dog-rgb'"):
        panel._asked(panel, {"name": "surfaces-dog-rgb"}, [])
    assert "no data of a live figure" in panel.sent[-1]["error"]


def test_an_interrupt_is_answered_too(panel, monkeypatch):
    monkeypatch.setattr(live_panel, "content", Mock(side_effect=KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        panel._asked(panel, {"name": "surfaces-cat-rgb"}, [])
    words = "the kernel was interrupted"
    assert panel.sent == [{"name": "surfaces-cat-rgb", "error": words}]


def test_every_data_is_known_by_one_name():
    names = live.names()
    assert len(names) == len(set(names))
    for name in {part for figure in LIVE for part in FIGURES[figure].live}:
        assert name in names
