"""A Sphinx extension: what the reference of the library leaves out, or does only once.

The fields of a NamedTuple are in the Attributes of its docstring; Python's own text on
each, "Alias for field number 0", says nothing more.  What a module has imported stands
on the page of another: autodoc would read its source to find that out.  And most pages
have the sidebar of the others in their folder, since it does not list them.  The pages
of sources are told apart from those of the reference by their titles.
"""

import inspect
from typing import Any

from sphinx.application import Sphinx

BEFORE_THE_THEME = 400  # which has Sphinx's usual 500
NOT_LISTED = ("_modules/", "api/mkt")  # beginnings of pages


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("autodoc-skip-member", _skipped)
    app.connect("html-page-context", _Sidebars().serve, priority=BEFORE_THE_THEME)
    app.connect("html-page-context", _told_apart)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _skipped(
    app: Sphinx, kind: str, name: str, thing: Any, skip: bool, options: Any
) -> bool | None:
    """Whether to leave a member out; None leaves it to Sphinx."""
    if kind == "module" and (inspect.isfunction(thing) or inspect.isclass(thing)):
        elsewhere = thing.__module__ != app.env.current_document.autodoc_module
        is_alias = thing.__name__ != name  # which is documented where it is made
        return True if elsewhere and not is_alias else None
    return True if type(thing).__name__ == "_tuplegetter" else None


def _told_apart(
    app: Sphinx, page: str, template: str, context: dict[str, Any], tree: Any
) -> None:
    """The source of a module has the title of its reference; let it say so."""
    if page.startswith("_modules/mkt"):
        context["title"] = f"Source of {context['title']}"


class _Sidebars:
    """One list of pages for each folder whose own pages are not on it."""

    def __init__(self):
        self._known: dict[str, str] = {}

    def serve(
        self, app: Sphinx, page: str, template: str, context: dict[str, Any], tree: Any
    ) -> None:
        """Replace the function that makes the list for the theme."""
        if page.startswith(NOT_LISTED) and "toctree" in context:
            folder, make = page.rpartition("/")[0], context["toctree"]

            def listed(**options: Any) -> str:
                """What `make` returned for the first page of this folder."""
                if folder not in self._known:
                    self._known[folder] = make(**options)
                return self._known[folder]

            context["toctree"] = listed
