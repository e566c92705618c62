"""A Sphinx extension: formulas as SVG inside the page, drawn by ziamath, so that no page ever asks a network for MathJax."""

import html

import ziamath
from docutils.nodes import SkipNode
from sphinx.util import logging

ziamath.config.svg2 = False  # no shared symbols, whose ids would clash on a page
ziamath.config.math.color = "currentColor"
SIZE = 18  # [px]
_log = logging.getLogger(__name__)


def setup(app):
    """Called by Sphinx."""
    app.add_html_math_renderer("svg", inline_renderers=(_visit_inline, None), block_renderers=(_visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _visit_inline(translator, node):
    translator.body.append(svg(node.astext(), node, inline=True))
    raise SkipNode


def _visit_block(translator, node):
    ids = "".join(f'<span id="{id}"></span>' for id in node.get("ids", ()))
    translator.body.append(f'<div class="mkt-formula">{ids}{svg(node.astext(), node)}</div>\n')
    raise SkipNode


def svg(tex, node=None, inline=False):
    """TeX as an <svg> that sits on the line of text around it; the TeX itself, with a warning, where ziamath cannot read it."""
    try:
        formula = ziamath.Latex(tex, size=SIZE, inline=inline)
    except Exception as error:  # its parsers raise whatever they trip over
        _log.warning("formula not understood: %s (%s)", tex, error, location=node)
        return f"<code>{html.escape(tex)}</code>"
    drawing = formula.svgxml()
    drawing.attrib |= {"role": "img", "aria-label": tex, "class": "mkt-math"}
    for side in ("width", "height"):
        drawing.set(side, f"{float(drawing.get(side)) / SIZE:.3f}em")
    drawing.set("style", f"vertical-align: {formula.getyofst() / SIZE:.3f}em")
    return ziamath.zmath.ET.tostring(drawing, encoding="unicode")
