"""One door to every figure.

Notebook, book, command line and tests use the same registry.

``@figure("teuliere2009.fig3", size=(9, 4), span=(0.4, 1.4, 0.1), bins=["hsv", "rgb"])``
registers a drawing function ``fig3(fig, *, span=1.0, bins="hsv", ...)``.  Its *defaults
are the paper's values* where the paper prints any, the decorator's keyword arguments
are the *sliders*: ``(low, high, step)`` for numbers, a list for choices; a parameter
that is annotated ``int`` takes whole numbers alone.  ``grid=("span", "bins")`` names
two that move together where every position is drawn beforehand
(`mkt.figures.static_panel`), and ``live=("own.beats", ...)`` says that the book's page
computes the figure by itself, and from which data it begins (`mkt.figures.live`).

The function draws on the `matplotlib.figure.Figure` it is given and returns what it
shows as `Shown`: a tidy table, which is what a CSV file of the figure holds, and single
facts, so that a test can measure what a reader sees.
"""

import inspect
import math
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from numbers import Real
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from mkt.checks import are_finite, is_number
from mkt.experiments.timing import one_thread
from mkt.plotting import in_style, new_figure
from mkt.registry import Registry, by_group
from mkt.tracking import Progress

# In the order of the book, as the text calls them; those of no paper are called "own".
PAPERS = {"teuliere2009": "T09", "nummiaro2003": "N03", "cordoba2014": "C14", "own": ""}

# The columns of a table for regions (n, 5).
REGION = ("cx [px]", "cy [px]", "theta [rad]", "hx [px]", "hy [px]")

# So begins the paragraph of a docstring on the figure that computes in the page.
IN_THE_PAGE = "In the page: "

# Parameters that take less than their sliders show: those of which 0 means none, never
# or the first; those that may point the other way; and one that its figure looks at.
ZERO = ("alpha", "b", "believed_below", "limit", "n_lim", "noise", "seed", "speed")
SIGNED = ("dx", "shift", "tilt", "turn", "turned")
LEAST = dict.fromkeys((*ZERO, "threshold"), 0.0)
LEAST |= dict.fromkeys((*SIGNED, "epsilon"), -math.inf)

_listener: ContextVar[Progress | None] = ContextVar("listener", default=None)

#: The figures by name, such as "teuliere2009.fig3".
#:
#: :meta hide-value:
FIGURES = Registry(
    "figure",
    "mkt.papers",
    order=by_group(tuple(PAPERS), "."),
    listing="python3 -m mkt figure --list",
)


@dataclass(frozen=True)
class Shown:
    """What a figure shows, as numbers.

    ``shown["x"]`` is the column x of the table, or the fact of that name.

    Parameters
    ----------
    table : DataFrame
        Tidy: a row for each point that is drawn, its columns named with their units
        where they have any, such as "x [px]".
    facts : dict
        Numbers, arrays, words and further tables that titles state or that follow from
        the table.
    """

    table: pd.DataFrame
    facts: dict[str, Any] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Any:
        if name in self.facts:
            return self.facts[name]
        return self.table[name].to_numpy()


def shown(table: Mapping[str, Any] | pd.DataFrame, **facts: Any) -> Shown:
    """What a figure returns: columns that broadcast to one length, and facts."""
    return Shown(pd.DataFrame(table), facts)


def grid_columns(
    rows: Mapping[str, Any], columns: Mapping[str, Any], **values: Any
) -> pd.DataFrame:
    """A surface as a tidy table.

    Parameters
    ----------
    rows, columns : one-entry dict
        The name and the values (m,) or (n,) of each axis.
    **values : (m, n) arrays

    Returns
    -------
    DataFrame
        With m n rows.
    """
    (down, y), (across, x) = *rows.items(), *columns.items()
    x, y = np.meshgrid(x, y)
    flat = {name: np.ravel(value) for name, value in values.items()}
    return pd.DataFrame({down: y.ravel(), across: x.ravel()} | flat)


@dataclass(frozen=True)
class Entry:
    """A registered figure.

    Parameters
    ----------
    name : str
        ``paper.figure``.
    function : callable
    size : (width, height) [inch]
    sliders : dict
    grid : tuple of str
        Two sliders that are one grid, or none.
    live : tuple of str
        Of a figure that computes by itself in a page (`mkt/live`), the names of the
        data that it begins with.
    """

    name: str
    function: Callable
    size: tuple[float, float]
    sliders: dict[str, Any]
    grid: tuple[str, ...] = ()
    live: tuple[str, ...] = ()

    @property
    def defaults(self) -> dict[str, Any]:
        """Every parameter with the value of the paper."""
        return {name: p.default for name, p in self._parameters.items()}

    @property
    def _parameters(self) -> dict[str, inspect.Parameter]:
        """All but the first, which is the Figure."""
        return dict(list(inspect.signature(self.function).parameters.items())[1:])

    @property
    def title(self) -> str:
        """First paragraph of the docstring."""
        return self._text[0].replace("\n", " ")

    @property
    def number(self) -> str:
        """What is printed: "Figure 3 of [T09]", or nothing where it is ours."""
        paper, _, name = self.name.partition(".")
        found = re.fullmatch(r"(fig|table)(\d+)", name)
        if not (found and PAPERS.get(paper)):
            return ""
        kind = {"fig": "Figure", "table": "Table"}[found[1]]
        return f"{kind} {found[2]} of [{PAPERS[paper]}]"

    @property
    def caption(self) -> str:
        """What the figure shows, on which data, and where it differs from the print."""
        return "\n\n".join(p for p in self._text[1:] if not p.startswith(IN_THE_PAGE))

    @property
    def live_caption(self) -> str:
        """The same for the figure that computes in the page, where that lies otherwise.

        There its own paragraph takes the place of the first one.
        """
        paragraphs = self._text[1:]
        own = [p for p in paragraphs if p.startswith(IN_THE_PAGE)]
        rest = [p for p in paragraphs[bool(own) :] if p not in own]
        return "\n\n".join([p.removeprefix(IN_THE_PAGE) for p in own] + rest)

    @property
    def _text(self) -> list[str]:
        return (inspect.getdoc(self.function) or "").split("\n\n")

    def is_number(self, name: str) -> bool:
        """Whether a parameter takes numbers, those of its slider and others."""
        default = self.defaults[name]
        return isinstance(default, Real) and not isinstance(default, bool)

    def is_whole(self, name: str) -> bool:
        """Whether a parameter is annotated ``int``: it counts something, or numbers it.

        Whole numbers are all that it takes.
        """
        return self._parameters[name].annotation in (int, "int")  # the word where late

    def values(self, name: str) -> list[Any]:
        """All positions of a slider; the default is always among them."""
        positions = self.sliders[name]
        if isinstance(positions, list):
            return positions
        low, high, step = positions
        steps = np.arange(round((high - low) / step) + 1)
        whole = all(isinstance(number, int) for number in positions)
        numbers = [
            int(low + k * step) if whole else round(float(low + k * step), 10)
            for k in steps
        ]
        return sorted({*numbers, self.defaults[name]})

    def draw(
        self, dpi: float = 100, progress: Progress | None = None, **parameters: Any
    ) -> tuple[Figure, Shown]:
        """Draw the figure, with its defaults except for some parameters.

        Parameters
        ----------
        dpi : float
            Dots an inch.
        progress : callable, optional
            Called with frames done and in all while a tracker runs for it.
        **parameters

        Returns
        -------
        fig : matplotlib.figure.Figure
            A new one: to clear an old one takes longer.
        shown : Shown

        Raises
        ------
        ValueError
            For an unknown parameter, or a word that is none of its choices, with the
            known ones; and for a number of another kind than those of its slider.
        """
        unknown = sorted(set(parameters) - set(self.defaults))
        if unknown:
            raise ValueError(
                f"{self.name} has no parameter {unknown[0]!r}; "
                f"it takes {', '.join(self.defaults)}"
            )
        for name, value in parameters.items():
            fits, need = self._need(name, value)
            if not fits:
                raise ValueError(f"{self.name}: {name} is {value!r}; {need}")
        counts = {
            name: int(parameters[name]) for name in filter(self.is_whole, parameters)
        }
        with in_style(), one_thread(), _heard(progress):
            fig = new_figure(self.size, dpi)
            return fig, self.function(fig, **(self.defaults | parameters | counts))

    def _need(self, name: str, value: Any) -> tuple[bool, str]:
        """Whether a value is such a one as its slider shows, and in words what is."""
        default = self.defaults[name]
        listed = self.values(name) if name in self.sliders else [default]
        if self.is_number(name):
            least = LEAST.get(name, min(listed))
            return _such_a_number(value, least, self.is_whole(name))
        if isinstance(default, str) and name in self.sliders:
            return value in listed, f"it takes {', '.join(map(repr, listed))}"
        return True, ""


def _such_a_number(value: Any, low: float, whole: bool) -> tuple[bool, str]:
    """Whether a value is a finite number of the sign of the least one."""
    fits = isinstance(value, Real) and -math.inf < value < math.inf
    fits = fits and not (whole and value % 1)
    need = f"it must be a {'whole' if whole else 'finite'} number"
    if low >= 0:
        need += " above 0" if low > 0 else ", at least 0"
        fits = fits and (value > 0 or value == low)
    return fits, need


def at_most(most: float, **values: float) -> None:
    """Refuse parameters of a figure beyond their upper end."""
    for name, value in values.items():
        if value > most:
            raise ValueError(f"{name} is {value}; it must be at most {most}")


@contextmanager
def _heard(progress: Progress | None) -> Iterator[None]:
    token = _listener.set(progress)
    try:
        yield
    finally:
        _listener.reset(token)


def listener() -> Progress | None:
    """The function to call with the progress of runs for the figure being drawn."""
    return _listener.get()


def _trouble(positions: Any, default: Any) -> str:
    """What is wrong with a slider and its default, empty where nothing is."""
    if isinstance(positions, list):
        within = default in positions
    elif isinstance(positions, tuple) and are_finite(positions, 3):
        low, high, step = positions
        if not (low < high and step > 0):
            return f"is {positions}; give low < high, and a step above 0"
        within = is_number(default, low) and default <= high
    else:
        return f"is {positions!r}; give a list of values, or (low, high, step)"
    return "" if within else f"is {positions}, and its default {default!r} is not in it"


def figure(
    name: str,
    size: tuple[float, float] = (8.0, 4.0),
    grid: tuple[str, ...] = (),
    live: tuple[str, ...] = (),
    **sliders: Any,
) -> Callable:
    """Decorator: register a drawing function under ``paper.name``.

    See the module's text for the arguments.
    """

    def register(function):
        entry = Entry(name, function, size, sliders, grid, live)
        stray = sorted(set(sliders) - set(entry.defaults) | set(grid) - set(sliders))
        if stray:
            raise ValueError(f"figure {name}: no parameter for slider {stray[0]!r}")
        for slider, positions in sliders.items():
            if trouble := _trouble(positions, entry.defaults[slider]):
                raise ValueError(f"figure {name}: slider {slider!r} {trouble}")
        FIGURES.add(name, entry)
        return function

    return register
