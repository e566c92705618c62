"""Figures in words: what the command line lists, and what NAME=VALUE means."""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from mkt.course.own_tracker import enter
from mkt.figures.captions import label
from mkt.figures.registry import FIGURES, Entry

ALL_TRACKERS = "own.success"  # draws whatever is registered
LARGEST = 2**53  # up to here a float holds every whole number, and tables have floats
SHORT = {"n": "particles"}  # as the papers call the number of particles
ANY = (
    "Numbers need not be one of those listed, which are the positions of a slider, but "
    "of a sign and a size that make sense."
)


def listing(name: str | None = None) -> str:
    """The names of all figures with their titles, or the parameters of one, as text.

    Raises
    ------
    ValueError
        For an unknown figure.
    """
    if name is None:
        return "\n".join(f"{e.name:24} {e.title}" for e in FIGURES.values())
    entry = FIGURES[name]
    rows = [_parameter(entry, name, value) for name, value in entry.defaults.items()]
    short = [f"{word} means {name}." for word, name in _short(entry).items()]
    return "\n".join([f"{entry.name}: {entry.title}", *rows, ANY, *short])


def _parameter(entry: Entry, name: str, value: Any) -> str:
    if name not in entry.sliders:
        return f"  {name}={value}"
    positions = ", ".join(map(str, entry.values(name)))
    return f"  {name}={value}    one of {positions}"


def _short(entry: Entry) -> dict[str, str]:
    """{short name: parameter} as far as the figure has it and no other of that name."""
    known = entry.defaults
    return {
        word: name
        for word, name in SHORT.items()
        if name in known and word not in known
    }


def parameters(entry: Entry, assignments: Iterable[str]) -> dict[str, Any]:
    """The parameters of a figure from words ``name=value``.

    What counts is a whole number, and other numbers are floats.  Numbers need not be
    positions of a slider, but words must be.

    Raises
    ------
    ValueError
        That names what is wrong.
    """
    result = {}
    for word in assignments:
        name, equals, text = word.partition("=")
        if not equals:
            raise ValueError(f"{word!r} is not NAME=VALUE")
        name = _short(entry).get(name, name)
        if name not in entry.defaults:
            short = [f"{word} for {known}" for word, known in _short(entry).items()]
            raise ValueError(
                f"{entry.name} has no parameter {name!r}; "
                f"it takes {', '.join([*entry.defaults, *short])}"
            )
        result[name] = _value(entry, name, text)
    return result


def own_tracker(entry: Entry, name: str) -> tuple[Entry, dict[str, str]]:
    """A figure with a tracker of the user's own among its choices, and how to show it.

    Raises
    ------
    ValueError
        For no tracker, and for a figure of the paper's own trackers.
    """
    if "tracker" not in entry.defaults and entry.name != ALL_TRACKERS:
        raise ValueError(
            f"{entry.name} shows the trackers of its paper; own.run shows one of your "
            f"own, and {ALL_TRACKERS} all"
        )
    enter(name)
    if "tracker" not in entry.defaults:
        return entry, {}
    choices = {"tracker": [*entry.values("tracker"), name]}
    return replace(entry, sliders=entry.sliders | choices), {"tracker": name}


def _value(entry: Entry, name: str, text: str) -> Any:
    positions = entry.values(name) if name in entry.sliders else []
    known = [entry.defaults[name], *positions]
    if entry.is_number(name):
        return _number(name, text, int if entry.is_whole(name) else float)
    choices = {label(value): value for value in known}  # as a page writes them
    choices |= {str(value): value for value in known}
    if positions and text not in choices:
        raise ValueError(f"{name}={text}: choose from {', '.join(map(str, positions))}")
    return choices.get(text, text)


def _number(name: str, text: str, kind: type) -> float:
    try:
        number = kind(text)
    except ValueError:
        raise ValueError(
            f"{name}={text}: not a number of type {kind.__name__}"
        ) from None
    if kind is int and abs(number) > LARGEST:
        raise ValueError(f"{name}={text}: beyond 2^53; choose a smaller number")
    if not math.isfinite(number):
        raise ValueError(f"{name}={text}: not a finite number")
    return number
