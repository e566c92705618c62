"""A scene for each student: a seed made of a name.

A lab with a function ``my_name`` draws the student's own scene with `own_seed`.  So
neighbours have different numbers, and a check, which draws the same scene, knows them.
"""

import ast
import hashlib
import unicodedata
from collections.abc import Callable

from nbformat import NotebookNode

from mkt.course.labs.notebooks import name
from mkt.course.labs.source import LONGEST, parsed

NOBODYS = 1  # the seed while no name is written
FIRST = 2000  # beyond those that trackers were tuned and are judged on
MANY = 10**6  # so two of sixty students share a scene in one class of six hundred

NAME = "my_name"  # the function, and the cell in which it is written


def own_seed(my_name: Callable[[], str]) -> int:
    """The seed for the name that a student's function returns.

    While it returns none, it is `NOBODYS`, so that the rest of the lab can be done.
    """
    try:
        return seed_of(my_name())
    except Exception:  # not written yet, or whatever a student's function does
        return NOBODYS


def seed_of(text: str) -> int:
    """The seed for a name, from `FIRST` on, the same however it is written.

    Raises
    ------
    TypeError
        For a name that is no text.
    ValueError
        For an empty name.
    """
    plain = plain_name(text)
    if not plain:
        raise ValueError("the name is empty; write yours")
    digest = hashlib.sha256(plain.encode("utf-8", "replace")).digest()
    return FIRST + int.from_bytes(digest[:8], "big") % MANY


def plain_name(text: str) -> str:
    """What is the same in a name however it is written, without capitals and blanks."""
    return "".join(unicodedata.normalize("NFKC", text).casefold().split())


def written_name(notebook: NotebookNode) -> str:
    """The name that stands in a notebook's ``my_name``, "" where none can be read."""
    sources = [cell.source for cell in notebook.cells if name(cell) == NAME]
    nodes = ast.walk(parsed("\n".join(sources)[:LONGEST]))
    returned = [node.value for node in nodes if isinstance(node, ast.Return)]
    texts = [one.value for one in returned if isinstance(one, ast.Constant)]
    return next((text for text in texts if isinstance(text, str)), "")
