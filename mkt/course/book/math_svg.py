"""A Sphinx extension: formulas as SVG inside the page.

They are drawn by ziamath, so that no page ever asks a network for MathJax.
"""

import html
from typing import Any
from xml.etree import ElementTree

from docutils.nodes import Node, SkipNode
from sphinx.application import Sphinx
from sphinx.util import logging
from ziamath.config import config
from ziamath.zmath import Latex

config.svg2 = False  # no shared symbols, whose ids would clash on a page
config.math.color = "currentColor"
SIZE = 18  # [px]
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
        formula = Latex(tex, size=SIZE, inline=inline)
    except Exception as error:  # its parsers raise whatever they trip over
        _log.warning("formula not understood: %s (%s)", tex, error, location=node)
        return f"<code>{html.escape(tex)}</code>"
    drawing = formula.svgxml()
    drawing.attrib |= {"role": "img", "aria-label": tex, "class": "mkt-math"}
    for side in ("width", "height"):
        drawing.set(side, f"{float(drawing.attrib[side]) / SIZE:.3f}em")
    drawing.set("style", f"vertical-align: {formula.getyofst() / SIZE:.3f}em")
    return ElementTree.tostring(drawing, encoding="unicode")
