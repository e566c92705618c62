"""A Sphinx extension: the captions in the list of pages are headings, and say of which level, without which readers of the screen ignore them."""


def setup(app):
    """Called by Sphinx."""
    app.connect("html-page-context", _levels, priority=900)  # after the theme has made the list
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _levels(app, page, template, context, doctree):
    context["furo_navigation_tree"] = context["furo_navigation_tree"].replace('role="heading"', 'role="heading" aria-level="2"')
