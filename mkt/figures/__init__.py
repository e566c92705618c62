"""One door to every figure: the registry that notebook, book, command line and tests share.

``@figure("teuliere2009.fig3", size=(9, 4), span=(0.4, 1.4, 0.1), bins=["hsv", "rgb"])`` registers a drawing function
``fig3(canvas, *, span=1.0, bins="hsv", ...)``.  Its *defaults are the paper's values* where the paper prints any, the decorator's keyword
arguments are the *sliders*: ``(low, high, step)`` for numbers, a list for choices; ``grid=("span", "bins")`` names two that move together where
every position is drawn beforehand (`mkt.page`).  The function draws on the
`matplotlib.figure.Figure` it is given and returns the numbers that the picture shows, so that a test can measure what a reader sees.
"""

import importlib
import inspect
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Callable

from mkt.plotting import canvas

MODULES = ("teuliere2009", "teuliere2009_tracking", "teuliere2009_servoing", "nummiaro2003", "nummiaro2003_sequences", "cordoba2014", "cordoba2014_table", "cordoba2014_resampling",
           "own", "lessons", "lessons_benchmark", "lessons_servoing")
_REGISTRY = {}


@dataclass(frozen=True)
class Entry:
    """A registered figure: its identifier ``paper.name``, its function, the size [inch], its sliders, and two of them or none that are one grid."""

    id: str
    function: Callable
    size: tuple[float, float]
    sliders: dict
    grid: tuple = ()

    @property
    def defaults(self):
        """Every parameter with the value of the paper, dict of name -> value."""
        parameters = list(inspect.signature(self.function).parameters.values())[1:]
        return {p.name: p.default for p in parameters}

    @property
    def title(self):
        """First sentence of the docstring."""
        return inspect.getdoc(self.function).split("\n\n")[0].replace("\n", " ")

    @property
    def caption(self):
        """What the figure shows, on which data, and where it differs from the printed one: the docstring after its title."""
        return inspect.getdoc(self.function).partition("\n\n")[2]

    def values(self, name):
        """All positions of one slider, as a list; the default is always among them."""
        spec = self.sliders[name]
        if isinstance(spec, list):
            return spec
        low, high, step = spec
        integer = all(isinstance(v, int) for v in spec)
        values = {low + i * step if integer else round(low + i * step, 10) for i in range(int(round((high - low) / step)) + 1)}
        return sorted(values | {self.defaults[name]})

    def draw(self, dpi=100, **parameters):
        """Draw the figure, with its defaults but for `parameters`, at dpi dots an inch.

        Returns a new matplotlib Figure (clearing an old one takes longer) and the dict of numbers that it shows.  Raises ValueError
        naming an unknown parameter and the known ones.
        """
        unknown = sorted(set(parameters) - set(self.defaults))
        if unknown:
            raise ValueError(f"{self.id} has no parameter {unknown[0]!r}; it takes {', '.join(self.defaults)}")
        drawn = canvas(self.size, dpi)
        return drawn, self.function(drawn, **(self.defaults | parameters))


def figure(id, size=(8.0, 4.0), grid=(), **sliders):
    """Decorator: register a drawing function under ``paper.name`` (see the module's text)."""

    def register(function):
        entry = Entry(id, function, size, sliders, grid)
        stray = sorted(set(sliders) - set(entry.defaults) | set(grid) - set(sliders))
        if stray or id in _REGISTRY:
            raise ValueError(f"figure {id}: " + (f"no parameter for slider {stray[0]!r}" if stray else "registered twice"))
        _REGISTRY[id] = entry
        return function

    return register


def registry():
    """All figures in the order of the papers, dict of id -> `Entry`."""
    for module in MODULES:
        importlib.import_module(f"{__name__}.{module}")
    return dict(_REGISTRY)


def get(id):
    """The `Entry` of one figure.  Raises KeyError that names similar ones and lists all."""
    known = registry()
    if id not in known:
        similar = [other for other in known if other.endswith(f".{id}")] or get_close_matches(id, known)
        raise KeyError(f"no figure {id!r}" + f", perhaps {' or '.join(similar)}?" * bool(similar) + f"; there are {', '.join(known)}")
    return known[id]
