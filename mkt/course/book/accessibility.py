"""A Sphinx extension: what the theme leaves out for some readers.

Readers who hear the page meet the captions in the list of pages as headings, which need
a level.  Code, outputs and tables that are wider than the page scroll: readers without
a mouse can scroll only what the keyboard can reach.
"""

from typing import Any

from sphinx.application import Sphinx

# How what scrolls begins.
SCROLLING = (
    "<pre",
    '<div class="table-wrapper colwidths-auto docutils container"',
    '<div class="mkt-scroll"',
)
# A drawing that stands in a cell alone.
DRAWING = '<div class="output text_html"><img '
FRAMED = '<div class="output text_html mkt-scroll" tabindex="0"><img '
AFTER_THE_THEME = 900  # which makes the list


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("html-page-context", _complete, priority=AFTER_THE_THEME)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _complete(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: Any
) -> None:
    context["furo_navigation_tree"] = context["furo_navigation_tree"].replace(
        'role="heading"', 'role="heading" aria-level="2"'
    )
    if "body" in context:  # the search page has none
        for start in SCROLLING:
            context["body"] = context["body"].replace(start, f'{start} tabindex="0"')
        context["body"] = context["body"].replace(DRAWING, FRAMED)
