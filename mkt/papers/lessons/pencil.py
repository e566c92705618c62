"""What draws the drawings of mechanisms: crisp at any size, and with words.

A drawing stands at the head of a chapter.  It is no figure of a paper and has no
sliders.  Where it has numbers, they are computed by the library, so that it cannot show
what the code does not do.  `drawing` makes a picture for a page of a function that
draws on a Figure; `DRAWINGS` has all that are imported.

The drawings: `mkt.papers.lessons.drawings_of_looks` (chapters 1 to 3, 15 and 17),
`drawings_of_cameras` (7, 8 and 16) and `drawings` (all others).
"""

import html
from collections.abc import Callable, Sequence
from functools import wraps
from io import BytesIO
from typing import TYPE_CHECKING, Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.figures.pictures import data_uri
from mkt.plotting import CONTRAST, TRUTH, in_style
from mkt.plotting import new_figure as blank

if TYPE_CHECKING:
    from IPython.display import HTML  # only what a notebook shows needs it

BLUE, ORANGE, PURPLE = CONTRAST
ARROW: dict[str, Any] = {"arrowstyle": "-|>", "color": TRUTH, "lw": 1.2}
BOX = {"boxstyle": "round,pad=0.5", "fc": "aliceblue", "ec": BLUE}
MIDDLE = {"ha": "center", "va": "center"}
PIXELS = 80  # for each inch: 10 pt are 11 px
DRAWINGS: dict[str, "Callable[[], HTML]"] = {}  # the number of a chapter -> its drawing


def vector(fig: Figure, alt: str) -> "HTML":
    """A Figure as a picture of lines and curves, sharp on every screen.

    Parameters
    ----------
    fig : matplotlib.figure.Figure
    alt : str
        What is to be seen, in words.
    """
    from IPython.display import HTML

    data = BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "mkt", "svg.fonttype": "path"}):
        fig.savefig(data, format="svg", metadata={"Date": None})
    uri = data_uri("image/svg+xml", data.getvalue())
    width = round(fig.get_figwidth() * PIXELS)
    text = html.escape(alt, quote=True)
    return HTML(
        f'<img src="{uri}" alt="{text}" width="{width}" '
        'style="max-width: 100%; height: auto; background: white">'
    )


def drawing(chapter: str, width: float, height: float) -> Callable:
    """Decorator: a function that draws on a Figure of this size [inch].

    Its docstring's second paragraph says in words what is to be seen.  The function
    that results takes no arguments and returns the picture; its `figure` returns the
    Figure.

    Parameters
    ----------
    chapter : str
        Its number, under which it is found in `DRAWINGS`.
    width, height : float [inch]
    """

    def decorate(function: Callable[[Figure], None]) -> "Callable[[], HTML]":
        def figure() -> Figure:
            with in_style():
                fig = blank((width, height))
                function(fig)
                return fig

        @wraps(function)
        def picture() -> "HTML":
            words = (function.__doc__ or "").split("\n\n")[1]
            with in_style():
                return vector(figure(), " ".join(words.split()))

        picture.figure = figure  # pyright: ignore[reportFunctionMemberAccess]
        DRAWINGS[chapter] = picture
        return picture

    return decorate


def canvas(
    fig: Figure,
    width: float,
    height: float,
    box: tuple[float, float, float, float] = (0, 0, 1, 1),
) -> Axes:
    """Axes without lines, in units of our own.

    Parameters
    ----------
    fig : Figure
    width, height : float
        What stands at the right and the upper end.
    box : left, bottom, width, height
        In fractions of the Figure; by default all of it.
    """
    ax = fig.add_axes(box)
    ax.set(xlim=(0, width), ylim=(0, height))
    ax.set_axis_off()
    return ax


def arrow(ax: Axes, start: Sequence[float], end: Sequence[float], **style: Any) -> None:
    """An arrow between two points."""
    ax.annotate("", end, start, arrowprops=ARROW | {"shrinkA": 0} | style)


def boxes(ax: Axes, words: Sequence[str], x: Sequence[float], y: float) -> None:
    """Words in boxes, in a row."""
    for text, place in zip(words, x, strict=True):
        ax.text(place, y, text, bbox=BOX, **MIDDLE)
