"""A Sphinx extension: what the theme leaves out for readers who hear the page or have no mouse.

The captions in the list of pages are headings and must say of which level; code and outputs that are wider than the page scroll, and a key can
scroll only what it can reach.
"""


def setup(app):
    """Called by Sphinx."""
    app.connect("html-page-context", _complete, priority=900)  # after the theme has made the list
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _complete(app, page, template, context, doctree):
    context["furo_navigation_tree"] = context["furo_navigation_tree"].replace('role="heading"', 'role="heading" aria-level="2"')
    if "body" in context:  # the search page has none
        context["body"] = context["body"].replace("<pre>", '<pre tabindex="0">')
