"""Sliders: the picture follows them, live and in the page; no network is asked."""

import asyncio
import gc
import json
import re
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mkt.figures import captions, explore, show
from mkt.figures import panel as panels
from mkt.figures import static_panel as page
from mkt.figures.live import fields
from mkt.figures.registry import FIGURES, figure, listener, shown
from mkt.figures.tooltips import WORDS, title
from mkt.scenes.drawn import Drawn
from mkt.trackers.particle_filter import ParticleFilter
from mkt.tracking import track


@pytest.fixture(autouse=True)
def toy():
    """A registered figure of one line, which fails at slope 3."""
    drawn = []

    @figure("toy.line", size=(3, 2), slope=(0, 20, 1), color=["red", "blue"])
    def line(fig, *, slope=1, color="red", title="<a & b>"):
        """A line.

        Drawn for tests, with <angles>.
        """
        if slope == 3:
            raise ArithmeticError("no slope <three>")
        drawn.append(slope)
        fig.subplots().plot([0, 1], [0, slope], color=color)
        return shown({"x": [0, 1], "y": [0, slope]}, rise=slope)

    sliders = {"z": [0, 1], "x": (0, 20, 1), "y": [1, 2]}

    @figure("toy.grid", size=(3, 2), grid=("x", "y"), **sliders)
    def grid(fig, *, x=7, y=1, z=0, title=""):
        """A place."""
        drawn.append((x, y, z))
        fig.subplots().plot([x], [y], "o", ms=10 + 30 * z)
        return shown({"x": [x], "y": [y]})

    return drawn


@pytest.fixture
def static(monkeypatch):
    monkeypatch.setenv("MKT_STATIC", "1")


@pytest.fixture(autouse=True)
def live(monkeypatch):
    monkeypatch.delenv("MKT_STATIC", raising=False)


def test_show_is_a_picture_that_says_what_it_shows():
    page = show("toy.line", slope=2)._repr_html_()
    assert 'src="data:image/png;base64,iVBOR' in page  # a PNG's first bytes
    assert 'alt="A line."' in page
    assert "<p><b>A line.</b> Drawn for tests, with &lt;angles&gt;.</p>" in page


def test_the_picture_follows_a_slider_and_comes_back():
    panel = explore("toy.line")
    first, slider = panel._image.value, panel._controls["slope"]
    slider.value = 7
    assert panel._image.value != first
    assert (panel.values["slope"], panel.shown["rise"]) == (7, 7)
    slider.value = 1
    assert panel._image.value == first


@pytest.mark.parametrize("typed, counts", [(7, 7), (7.25, 7.25), (99, 20)])
def test_a_number_that_is_typed_beside_a_slider_counts(typed, counts):
    @figure("toy.typed", size=(3, 2), slope=(0.0, 20.0, 0.5))
    def line(fig, *, slope=1.0):
        """A line."""
        return shown({"x": [0, 1]}, rise=slope)

    panel = explore("toy.typed")
    panel._controls["slope"].value = typed  # as its read-out sends it
    assert panel.shown["rise"] == panel.values["slope"] == counts


@pytest.mark.slow
def test_every_control_of_every_figure_says_in_words_what_it_does():
    unknown = {
        name
        for entry in FIGURES.values()
        for name in entry.sliders
        if not entry.name.startswith("toy.") and name not in WORDS
    }
    assert not unknown, "write these into WORDS of mkt/figures/tooltips.py"
    unused = set(WORDS) - {name for e in FIGURES.values() for name in e.sliders}
    assert not unused, "take these out of WORDS of mkt/figures/tooltips.py"
    assert explore("own.basin")._controls["turn"].tooltip == WORDS["turn"]


def test_a_slider_has_its_unit_in_the_notebook_and_in_the_page():
    assert explore("own.basin")._controls["turn"].description == "turn [deg]"
    assert fields(FIGURES["own.approach"])["delay"]["title"] == "delay [frames]"
    assert title("scale") == "scale" and title("n") == "particles"


def test_a_control_is_called_by_a_word_or_a_symbol_and_not_by_a_name_of_code():
    called = {title(name) for entry in FIGURES.values() for name in entry.sliders}
    assert {name for name in called if "_" in name} == {"T_lim", "N_lim"}
    assert explore("own.two_cameras")._controls["k"].description == "frame"


@pytest.mark.slow  # for its picture alone
def test_a_symbol_beside_a_slider_is_set_as_one():
    control = explore("cordoba2014.fig1")._controls["n_lim"]
    assert control.description == "N<sub>lim</sub>" and control.description_allow_html


def test_reset_shows_the_beginning_and_nothing_in_between(toy):
    panel = explore("toy.line")
    first = panel._image.value
    panel._controls["slope"].value, panel._controls["color"].value = 5, "blue"
    del toy[:]
    panel.reset()
    assert toy == []  # the beginning was kept, and (1, "blue") not drawn
    assert panel._image.value == first
    panel._controls["slope"].value = 5  # which is heard again
    assert panel._image.value != first


def test_the_next_step_the_same_way_is_drawn_while_the_reader_looks(toy, monkeypatch):
    monkeypatch.setattr(panels, "QUICK", float("inf"))

    async def look_at(*slopes):
        panel = explore("toy.line")
        del toy[:]
        for slope in slopes:
            panel._controls["slope"].value = slope
            await asyncio.sleep(2 * panels.PAUSE)
        return panel.shown["rise"]

    assert asyncio.run(look_at(2)) == 2 and toy == [
        2
    ]  # slope 3 fails, and nobody is told before they ask for it
    assert asyncio.run(look_at(7)) == 7 and toy == [
        7
    ]  # a leap says nothing about the next move
    assert asyncio.run(look_at(7, 8)) == 8 and toy == [7, 8, 9]
    assert asyncio.run(look_at(7, 6, 5)) == 5 and toy == [7, 6, 5, 4]


@pytest.mark.parametrize("before, end", [(1, 0), (19, 20)])
def test_nothing_is_drawn_beyond_the_end_of_a_slider(before, end, toy, monkeypatch):
    monkeypatch.setattr(panels, "QUICK", float("inf"))

    async def to_the_end():
        panel = explore("toy.line")
        panel._listen(False)
        panel._controls["slope"].value = before
        panel._listen(True)
        del toy[:]
        panel._controls["slope"].value = end
        await asyncio.sleep(2 * panels.PAUSE)
        return panel._trouble.value

    assert asyncio.run(to_the_end()) == ""
    assert toy == [end]


@pytest.mark.parametrize("was_on", [True, False])
def test_after_a_drawing_garbage_is_collected_only_if_it_was_before(was_on):
    gc.enable() if was_on else gc.disable()
    try:
        explore("toy.line")
        assert gc.isenabled() == was_on
    finally:
        gc.enable()


def test_a_still_picture_says_its_title_also_with_marks_of_html():
    @figure("toy.marks", size=(3, 2))
    def marks(fig):
        """A "quick" <b>line</b>."""
        return shown({"x": [0]})

    page = show("toy.marks")._repr_html_()
    assert 'alt="A &quot;quick&quot; &lt;b&gt;line&lt;/b&gt;."' in page


def test_no_word_of_a_figure_can_end_the_data_of_its_page(static):
    @figure("toy.script", size=(3, 2), kind=["</script>", "<!--"])
    def script(fig, *, kind="</script>"):
        """A </script> line."""
        return shown({"x": [0]})

    page = explore("toy.script")._repr_html_()
    (data,) = re.findall(r"<script[^>]*>(.*?)</script>", page, re.DOTALL)
    assert "<" not in data
    assert json.loads(data)["title"] == "A </script> line."
    assert page.count("</script>") == 1


def test_a_run_over_a_sequence_shows_how_far_it_is(monkeypatch):
    clip = replace(Drawn("base").scene(), length=6).sequence()

    @figure("toy.run", size=(3, 2), n=[5, 6])
    def run(fig, *, n=5):
        """A run."""
        track(ParticleFilter(n=n), clip, progress=listener())
        return shown({"n": [n]})

    monkeypatch.setattr(panels, "TELL", -1)  # however quick the frames are
    panel, seen = explore("toy.run"), []
    panel._progress.observe(lambda change: seen.append(change.new), "value")
    panel._controls["n"].value = 6
    assert seen == [k / 6 for k in range(1, 7)]
    assert panel._progress.description == "6 of 6"
    assert panel._progress.layout.visibility == "hidden"
    assert listener() is None


def test_two_threads_never_draw_at_once():
    at_work, most = [], []

    @figure("toy.slow", size=(3, 2), x=(0, 99, 1), y=(0, 99, 1))
    def slow(fig, *, x=0, y=0):
        """Slow."""
        at_work.append(1)
        time.sleep(0.01)
        most.append(len(at_work))
        at_work.pop()
        return shown({"x": [x], "y": [y]}, place=(x, y))

    panel = explore("toy.slow")

    def move(name):
        for value in range(1, 20):
            panel._controls[name].value = value

    with ThreadPoolExecutor() as threads:
        list(threads.map(move, "xy"))
    assert set(most) == {1} and len(most) > 20
    assert panel.shown["place"] == (19, 19)


def test_an_error_is_shown_in_the_panel_until_it_is_over():
    panel = explore("toy.line")
    panel._controls["slope"].value = 3
    assert "ArithmeticError: no slope &lt;three&gt;" in panel._trouble.value
    panel._controls["slope"].value = 4
    assert panel._trouble.value == ""


def test_a_panel_says_that_its_drawing_was_interrupted(monkeypatch):
    """Its controls stand where they were put, and the picture is another."""

    def stopped(*_):
        raise KeyboardInterrupt

    panel = explore("toy.line")
    before = panel._image.value
    with monkeypatch.context() as patched:
        patched.setattr(panel, "_drawn", stopped)
        panel._controls["slope"].value = 4
    assert "Interrupted" in panel._trouble.value and panel._image.value == before
    panel._controls["slope"].value = 5
    assert panel._trouble.value == "" and panel._image.value != before


def test_two_panels_do_not_move_each_other():
    one, other = explore("toy.line"), explore("toy.line")
    before = other._image.value
    one._controls["slope"].value = 9
    assert other._image.value == before


def test_a_panel_of_a_page_says_that_its_controls_need_javascript(static):
    page = explore("toy.line")._repr_html_()
    [told] = re.findall(r"<noscript>(.*?)</noscript>", page, re.DOTALL)
    assert "controls here work where JavaScript is on" in told


@pytest.mark.parametrize("mode", ["0", "1"])
def test_fixed_parameters_keep_their_value_and_have_no_slider(mode, monkeypatch):
    monkeypatch.setenv("MKT_STATIC", mode)
    result = explore("toy.line", slope=6)
    assert (result.values["slope"], result.shown["rise"]) == (6, 6)
    if mode == "1":
        assert 'data-name="slope"' not in result._repr_html_()
    else:
        assert list(result._controls) == ["color"]


@pytest.mark.parametrize("mode", ["0", "1"])
def test_mistakes_end_the_cell_with_the_known_names(mode, monkeypatch):
    monkeypatch.setenv("MKT_STATIC", mode)
    with pytest.raises(
        KeyError,
        match=r"no figure 'toy.circle', perhaps toy.line; .* lists all",
    ):
        explore("toy.circle")
    with pytest.raises(
        ValueError, match="no parameter 'slop'; it takes slope, color, title"
    ):
        explore("toy.line", slop=1)
    with pytest.raises(ValueError, match="toy.line: color is 'gren'; it takes 'red', "):
        explore("toy.line", color="gren")
    with pytest.raises(ArithmeticError):
        explore("toy.line", slope=3)


def test_the_page_asks_nothing_of_a_network_and_keeps_its_ids_apart(
    static, monkeypatch
):
    monkeypatch.setattr(page, "POSITIONS", 5)  # of which none is slope 3
    panel = explore("toy.line", title="x")
    text = panel._repr_html_() + panel._repr_html_()
    assert not re.search(r"https?:|src=[\"']//|url\(", text)
    ids = re.findall(r' id="([^"]+)"', text)
    assert len(ids) == len(set(ids)) == 6
    assert not re.search(r"<(link|iframe|object)|fetch\(|import\(|XMLHttp", text)
    assert all(f'for="{id}"' in text for id in ids if id.count("-") > 2)


def test_the_page_has_a_frame_for_each_position_and_the_default_only_once(
    static, monkeypatch
):
    monkeypatch.setattr(page, "POSITIONS", 5)
    panel = explore("toy.line")
    assert panel._positions["slope"] == [0, 1, 10, 15, 20]
    assert [group["names"] for group in panel._groups] == [("slope",), ("color",)]
    first, second = (group["frames"] for group in panel._groups)
    assert first[1] == second[0] == 0
    assert len(set(panel._frames)) == len(panel._frames) == 1 + 4 + 1


def test_two_sliders_of_a_grid_move_together_over_all_pairs(static, toy):
    panel = explore("toy.grid", title="fixed")
    assert panel._positions["x"] == [0, 7, 10, 15, 20]
    assert [group["names"] for group in panel._groups] == [("x", "y"), ("z",)]
    assert panel._groups[0]["frames"] == [
        toy[1:].index((x, y, 0)) + 1 if (x, y) != (7, 1) else 0
        for x in (0, 7, 10, 15, 20)
        for y in (1, 2)
    ]
    assert 'role="group"' in panel._repr_html_()


def test_a_grid_of_which_one_slider_is_fixed_is_none(static):
    panel = explore("toy.grid", y=2)
    assert [group["names"] for group in panel._groups] == [("z",), ("x",)]
    assert 'role="group"' not in panel._repr_html_()


def test_a_grid_names_sliders():
    with pytest.raises(ValueError, match="no parameter for slider 'y'"):
        figure("toy.wrong", grid=("x", "y"), x=(0, 1, 1))(lambda fig, *, x=0, y=0: None)


def test_the_picture_of_a_live_figure_has_its_own_caption_until_the_page_computes():
    """Without JavaScript, and on paper, the picture is all that is there."""
    entry = FIGURES["teuliere2009.fig3"]
    text = page.StaticPanel(entry, {})._repr_html_()
    caption, computed = (
        re.search(rf"<{tag}[^>]*>(.*?)</{tag}>", text, re.S)[1]
        for tag in ("figcaption", "template")
    )
    assert caption == captions.caption(entry)
    assert computed == captions.caption(entry, live=True) != caption


def test_beside_the_files_stands_which_values_the_page_holds(static):
    held = explore("toy.line", slope=2)._repr_html_()
    assert "with the default values; here slope = 2</p>" in held
    for as_it_is in ({}, {"slope": FIGURES["toy.line"].defaults["slope"]}):
        text = explore("toy.line", **as_it_is)._repr_html_()
        assert "with the default values</p>" in text


def test_a_picture_without_sliders_has_files_to_save_and_a_caption(static):
    text = show("toy.line", slope=2)._repr_html_()
    assert 'alt="A line. slope = 2, color = red, title = &lt;a &amp; b&gt;."' in text
    assert "<b>A line.</b> Drawn for tests, with &lt;angles&gt;.</figcaption>" in text
    assert (
        'href="_static/figures/toy.line.pdf"' in text
        and 'href="_static/figures/toy.line.csv"' in text
        and "picture of what is shown" in text
    )
    assert "data-name" not in text and "mkt-reset" not in text


def test_the_words_beside_the_sliders_say_where_they_stand(static, monkeypatch):
    monkeypatch.setattr(page, "POSITIONS", 5)
    text = explore("toy.line")._repr_html_()
    assert 'alt="A line. slope = 1, color = red, title = &lt;a &amp; b&gt;."' in text
    assert 'aria-valuetext="1"' in text and 'role="status"' in text


@given(st.integers(1, 300), st.data(), st.integers(3, 9))
def test_the_positions_in_the_page_keep_first_last_and_default(count, data, most):
    values, default = list(range(count)), data.draw(st.integers(0, count - 1))
    chosen = page.spread(values, default, most)
    assert {0, count - 1, default} <= set(chosen)
    assert chosen == sorted(set(chosen)) and len(chosen) == min(count, most)


@pytest.mark.parametrize("name", FIGURES)
def test_every_slider_of_the_book_stands_at_a_value_it_has(name):
    entry = FIGURES[name]
    assert all(entry.defaults[name] in entry.values(name) for name in entry.sliders)


@pytest.mark.parametrize(
    "words, html",
    [
        (
            "the x_n and y_n, e_yn",
            "the x<sub>n</sub> and y<sub>n</sub>, e<sub>yn</sub>",
        ),
        ("d_m^2, at N_lim", "d<sub>m</sub><sup>2</sup>, at N<sub>lim</sub>"),
        ("in MKT_DATA <1", "in MKT_DATA &lt;1"),
    ],
)
def test_symbols_of_a_caption_are_set_as_symbols(words, html):
    assert page.marked(words) == html


@pytest.mark.parametrize(
    "values, ordered",
    [([0.5, 1, 2], True), ([6, 4], False), (["a", "b"], False), ([False, True], False)],
)
def test_a_slider_moves_along_numbers_in_order_and_all_else_is_a_list(values, ordered):
    assert page.is_ordered(values) == ordered


def test_what_is_printed_is_called_by_its_number():
    numbers = {name: FIGURES[name].number for name in FIGURES}
    assert numbers["cordoba2014.table1"] == "Table 1 of [C14]"
    assert numbers["teuliere2009.fig10"] == "Figure 10 of [T09]"
    assert numbers["own.run"] == numbers["cordoba2014.complexity"] == ""
    said = page.caption(FIGURES["nummiaro2003.fig4"])
    assert said.startswith("<b>Figure 4 of [N03]: Trajectories")


@pytest.mark.parametrize("name", FIGURES)
def test_a_caption_has_no_marks_of_code_which_a_page_would_show(name):
    assert "`" not in page.caption(FIGURES[name])
