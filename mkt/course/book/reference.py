"""A Sphinx extension: what the reference of the library leaves out.

The fields of a NamedTuple are in the Attributes of its docstring; Python's own text on
each, "Alias for field number 0", says nothing more.
"""

from typing import Any

from sphinx.application import Sphinx


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("autodoc-skip-member", _skipped)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _skipped(
    app: Sphinx, kind: str, name: str, thing: Any, skip: bool, options: Any
) -> bool | None:
    """Whether to leave a member out; None leaves it to Sphinx."""
    return True if type(thing).__name__ == "_tuplegetter" else None
