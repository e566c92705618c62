"""A Sphinx extension: formulas as SVG inside the page.

They are drawn by ziamath, so that no page ever asks a network for MathJax.
"""

import html
import re
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from docutils.nodes import Node, SkipNode
from sphinx.application import Sphinx
from sphinx.util import logging
from ziamath.config import config
from ziamath.zmath import Latex

from mkt.course.book.depends import PACKAGES
from mkt.experiments.cache import Shelf, key

config.svg2 = False  # no shared symbols, whose ids would clash on a page
config.math.color = "currentColor"
SIZE = 18  # [px]
# Of a path: the numbers that a command takes; and how fine they are, in a pixel.
TAKES = {"M": 2, "L": 2, "Q": 4, "C": 6, "Z": 0}
FINE = 100
WORDS = re.compile(r"[A-Z]|-?[\d.]+")
FORMULAS = Shelf("formulas", ".svg", str.encode, bytes.decode)
_log = logging.getLogger(__name__)


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_html_math_renderer(
        "svg",
        inline_renderers=(_visit_inline, None),
        block_renderers=(_visit_block, None),
    )
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _visit_inline(translator: Any, node: Any) -> None:
    translator.body.append(svg(node.astext(), node, inline=True))
    raise SkipNode


def _visit_block(translator: Any, node: Any) -> None:
    anchors = "".join(f'<span id="{name}"></span>' for name in node.get("ids", ()))
    formula = svg(node.astext(), node)
    translator.body.append(f'<div class="mkt-formula">{anchors}{formula}</div>\n')
    raise SkipNode


def svg(tex: str, node: Node | None = None, inline: bool = False) -> str:
    """TeX as an <svg> that sits on the line of the text around it.

    Where ziamath cannot read it, it is the TeX itself, with a warning.

    Parameters
    ----------
    tex : str
    node : docutils node, optional
        Where it stands, for the warning.
    inline : bool
        Whether it stands in a line of text.
    """
    try:
        return _drawn(tex, inline)
    except Exception as error:  # its parsers raise whatever they trip over
        _log.warning("formula not understood: %s (%s)", tex, error, location=node)
        return f"<code>{html.escape(tex)}</code>"


@cache
def _drawn(tex: str, inline: bool) -> str:
    """The <svg>; half of the book's formulas have been there before on its pages."""
    known = key(tex, inline, *_surroundings())
    return FORMULAS.kept(known, lambda: _draw(tex, inline))


@cache
def _surroundings() -> tuple[str, str]:
    """What every drawing depends on."""
    return Path(__file__).read_text("utf-8"), PACKAGES.read_text("utf-8")


def _draw(tex: str, inline: bool) -> str:
    formula = Latex(tex, size=SIZE, inline=inline)
    drawing = formula.svgxml()
    drawing.attrib |= {"role": "img", "aria-label": tex, "class": "mkt-math"}
    for side in ("width", "height"):
        drawing.set(side, f"{float(drawing.attrib[side]) / SIZE:.3f}em")
    drawing.set("style", f"vertical-align: {formula.getyofst() / SIZE:.3f}em")
    for path in drawing.iter("path"):
        path.set("d", shorter(path.attrib["d"]))
    return ElementTree.tostring(drawing, encoding="unicode")


def shorter(path: str) -> str:
    """The data of a path in less than half as many letters.

    Each point is given by the way from the one before, to a hundredth of a pixel.

    Parameters
    ----------
    path : str
        Of the commands in ``TAKES`` alone, with points of the drawing.
    """
    words = iter(WORDS.findall(path))
    written, here, start = [], (0, 0), (0, 0)
    for command in words:
        if command == "Z":
            written.append("z")
            here = start
            continue
        numbers = [round(float(next(words)) * FINE) for _ in range(TAKES[command])]
        way = [number - here[i % 2] for i, number in enumerate(numbers)]
        written.append(command.lower() + "".join(map(_number, way)).strip())
        here = numbers[-2], numbers[-1]
        if command == "M":
            start = here
    return "".join(written)


def _number(hundredths: int) -> str:
    """A number as short as a path may have it, a sign or a space before it."""
    text = f"{hundredths / FINE:g}".replace("0.", ".", abs(hundredths) < FINE)
    return text if hundredths < 0 else f" {text}"
