"""Which values of its parameters a figure takes."""

import numpy as np
import pytest

from mkt.figures.registry import FIGURES, Entry, at_most, figure, shown


def drawn(
    fig,
    *,
    n: int = 5,
    share=0.5,
    scale=1,
    turn: float = 20,
    talking=True,
    seed: int = 0,
    terms: "int" = 3,
):
    """A figure of nothing but its parameters."""
    return shown({"n": [n]})


SLIDERS = {
    "n": (1, 9, 1),
    "share": (0.0, 1.0, 0.1),
    "scale": [0.5, 1, 2],
    "turn": (0, 90, 10),
    "talking": [True, False],
}
TOY = Entry("toy.numbers", drawn, (1, 1), SLIDERS)
FINITE = "it must be a finite number"
WHOLE = "it must be a whole number"


@pytest.mark.parametrize(
    "name, value, need",
    [
        ("n", 0, f"{WHOLE} above 0"),
        ("n", -1, f"{WHOLE} above 0"),
        ("share", -0.1, f"{FINITE}, at least 0"),
        ("share", np.nan, f"{FINITE}, at least 0"),
        ("scale", 0, f"{FINITE} above 0"),
        ("scale", np.inf, f"{FINITE} above 0"),
        ("scale", "1", f"{FINITE} above 0"),
        ("turn", np.inf, FINITE),
        ("seed", -1, f"{WHOLE}, at least 0"),
        ("terms", 0, f"{WHOLE} above 0"),
        ("terms", 1.5, f"{WHOLE} above 0"),
    ],
)
def test_numbers_of_another_kind_than_those_of_a_slider_are_refused(name, value, need):
    with pytest.raises(ValueError) as refused:
        TOY.draw(**{name: value})
    assert str(refused.value) == f"toy.numbers: {name} is {value!r}; {need}"


@pytest.mark.parametrize(
    "values",
    [
        {"n": 1000, "share": 0.05, "scale": 0.01, "terms": 1},
        {"n": np.int64(2), "scale": np.float32(2), "seed": 7, "talking": False},
        {"turn": -20.5},
    ],
)
def test_numbers_between_and_beyond_those_of_a_slider_are_taken(values):
    assert TOY.draw(**values)[1]["n"] == [values.get("n", 5)]


def test_a_slider_goes_from_its_first_number_to_its_last_by_its_step():
    sliders = {"n": (2, 9, 3), "share": (0.4, 0.7, 0.1), "turn": (-40, 40, 40)}
    entry = Entry("toy.positions", drawn, (1, 1), sliders)
    assert entry.values("n") == [2, 5, 8]
    assert entry.values("share") == [0.4, 0.5, 0.6, 0.7]
    assert entry.values("turn") == [-40, 0, 20, 40]  # the default is among them


@pytest.mark.parametrize("name", FIGURES)
def test_no_figure_refuses_its_defaults_and_what_its_sliders_show(name):
    entry = FIGURES[name]
    for parameter, default in entry.defaults.items():
        shown = entry.values(parameter) if parameter in entry.sliders else []
        for value in (default, *shown):
            assert entry._need(parameter, value)[0], (parameter, value)


# What the pages of live figures offer beyond the sliders, and zeros that mean nothing.
@pytest.mark.parametrize(
    "name, parameter, value",
    [
        ("own.newton", "dx", -24),
        ("own.newton", "turn", -20),
        ("own.success", "limit", 0),
        ("own.basin", "seed", 0),
        ("teuliere2009.fig6", "threshold", 0),
    ],
)
def test_what_makes_sense_before_a_slider_begins_is_taken(name, parameter, value):
    assert FIGURES[name]._need(parameter, value)[0]


COUNTING = [
    (name, parameter)
    for name, entry in FIGURES.items()
    for parameter in entry.defaults
    if entry.is_whole(parameter)
]


@pytest.mark.parametrize("name, parameter", COUNTING)
def test_what_counts_or_is_numbered_is_whole(name, parameter):
    default = FIGURES[name].defaults[parameter]
    assert type(default) is int
    with pytest.raises(ValueError, match=f"{parameter} is .*must be a whole number"):
        FIGURES[name].draw(**{parameter: default + 0.5})


def test_what_does_not_count_is_not_whole_though_its_slider_is():
    whole = {parameter for _, parameter in COUNTING}
    assert {"seed", "frame", "particles", "delay"} <= whole
    assert not {"turn", "turned", "x", "y", "grain", "off"} & whole


def test_a_whole_number_with_a_point_counts_as_well():
    shown = FIGURES["own.resampling"].draw(n=6.0, seed=1.0)[1]
    assert shown.table.equals(FIGURES["own.resampling"].draw(n=6, seed=1)[1].table)


BEYOND = {
    "own.beats": {"frame": 60},
    "own.run": {"frame": 80},
    "own.learnt_motion": {"k": 59},
    "own.priors": {"covered": 1.1},
    "own.resampling": {"n": 13},
    "own.two_cameras": {"k": 60},
    "own.video": {"start": 1.5},
}


@pytest.mark.parametrize("name", BEYOND)
def test_what_ends_is_asked_for_no_further(name):
    with pytest.raises(ValueError, match="is .*; it must be at most"):
        FIGURES[name].draw(**BEYOND[name])


def test_ahead_of_a_frame_there_are_no_more_than_the_film_has():
    with pytest.raises(ValueError, match="^ahead is 15; it must be at most 14$"):
        FIGURES["own.learnt_motion"].draw(k=45, ahead=15)


def test_an_upper_end_is_named_with_the_value():
    at_most(1, covered=1)
    for name in ("teuliere2009.fig8", "nummiaro2003.fig2", "nummiaro2003.fig3"):
        with pytest.raises(ValueError, match="^frame is 1000; it must be at most"):
            FIGURES[name].draw(frame=1000)
    with pytest.raises(ValueError, match="^covered is 2; it must be at most 1$"):
        at_most(1, covered=2)


@pytest.mark.parametrize(
    "positions, said",
    [
        ((1, 5), "give a list of values, or"),
        ("abc", "give a list of values, or"),
        ((1, 5, 0), "a step above 0"),
        ((5, 1, 1), "give low < high"),
        ((3, 5, 1), "its default 2 is not in it"),
        ([1, 3], "its default 2 is not in it"),
    ],
    ids=repr,
)
def test_a_slider_that_cannot_be_is_named_before_it_is_drawn(positions, said):
    def drawn(fig, *, a=2, b=None):
        """A figure."""

    with pytest.raises(ValueError, match="slider 'b' .*its default None is not in it"):
        figure("own.drawn", b=(1, 5, 1))(drawn)

    with pytest.raises(ValueError, match=f"figure own.drawn: slider 'a' .*{said}"):
        figure("own.drawn", a=positions)(drawn)
    assert "own.drawn" not in FIGURES


@pytest.mark.parametrize("name", ["smith2020.fig1", "own.fig7"])
def test_a_figure_of_no_known_paper_has_no_number(name):
    def drawn(fig):
        """A figure."""

    assert Entry(name, drawn, (8, 4), {}, (), ()).number == ""
