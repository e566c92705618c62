"""Whether a figure agrees with the printed one, as the text below it says."""

from nbformat import NotebookNode

from mkt.course.book.checks import figure_cells, read
from mkt.course.book.contents import Book

MARK = "**Printed / ours"
NOT_PRINTED = "no printed figure", "this figure is ours"
WORDS = ("agrees", "in part", "differs", "ours")


def said(book: Book) -> dict[str, str]:
    """{name of a figure: one of `WORDS`} for all figures of the book.

    The paragraph "Printed / ours" nearest below a figure speaks of it.  It mentions an
    agreement, a difference, or both; a figure that no paper prints is ours.
    """
    return {
        name: word
        for chapter in book.chapters
        for name, word in _in(read(chapter.notebook)).items()
    }


def _in(notebook: NotebookNode) -> dict[str, str]:
    shown = {cell.id: names for cell, names in figure_cells(notebook)}
    words: dict[str, str] = {}
    waiting: list[str] = []
    for cell in notebook.cells:
        waiting += [name for name in shown.get(cell.id, ()) if name not in words]
        if cell.cell_type == "markdown" and MARK in cell.source:
            text = cell.source.partition(MARK)[2].partition("\n\n")[0]
            words |= {name: _word(name, text) for name in waiting}
            waiting = []
    return words | {name: _word(name, "") for name in waiting}


def _word(name: str, text: str) -> str:
    text = text.lower()
    if name.startswith("own.") or any(words in text for words in NOT_PRINTED):
        return "ours"
    agrees = "agrees" in text
    differs = "differs" in text or "except" in text
    if agrees and differs:
        return "in part"
    return "differs" if differs else "agrees" if agrees else "ours"
