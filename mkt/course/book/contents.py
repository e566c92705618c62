"""The contents of the book, as book.toml lists them.

Which chapters there are, in which order, and which figures each one shows.
"""

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from mkt.figures.registry import FIGURES
from mkt.files import NOTEBOOKS, ROOT

CATALOGUE = ROOT / "book.toml"
KEYS = ("part", "notebook", "title", "summary", "figures", "timeout")


class BookError(ValueError):
    """The book cannot be built; the message says where and why."""


@dataclass(frozen=True)
class Chapter:
    """One notebook of the book.

    Parameters
    ----------
    notebook : Path
    title : str
    summary : str
        One sentence.
    figures : tuple of str
        Names of the figures that it shows.
    timeout : float [s]
        For the whole chapter.
    part : str
        What the chapters of one part of the book have in common.
    """

    notebook: Path
    title: str
    summary: str
    figures: tuple[str, ...]
    timeout: float
    part: str = ""

    @property
    def name(self) -> str:
        """The notebook's name without its ending; the page is called the same."""
        return self.notebook.stem


@dataclass(frozen=True)
class Book:
    """What the book consists of.

    Parameters
    ----------
    title : str
    description : str
        In Markdown.
    chapters : tuple of Chapter
        In the order in which they are read.
    """

    title: str
    description: str
    chapters: tuple[Chapter, ...]

    @property
    def parts(self) -> dict[str, list[Chapter]]:
        """{title: chapters} of the parts, in the order in which they are read."""
        groups = groupby(self.chapters, key=lambda chapter: chapter.part)
        return {part: list(chapters) for part, chapters in groups}


def read(path: Path = CATALOGUE, notebooks: Path = NOTEBOOKS) -> Book:
    """The `Book` of a catalogue.

    Raises
    ------
    BookError
        For a missing key or notebook, a chapter without figures, and a figure that is
        unknown, forgotten or named twice.
    """
    try:
        book = _book(tomllib.loads(path.read_text(encoding="utf-8")), notebooks)
    except KeyError as error:
        raise BookError(f"{path.name}: no key {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise BookError(f"{path.name}: {error}") from None
    troubles = [*_missing_notebooks(book, notebooks), *_figure_troubles(book)]
    if troubles:
        raise BookError("\n".join(f"{path.name}: {trouble}" for trouble in troubles))
    return book


def _book(table: dict[str, Any], notebooks: Path) -> Book:
    return Book(
        title=table["title"],
        description=table["description"].strip(),
        chapters=tuple(_chapter(entry, notebooks) for entry in table["chapter"]),
    )


def _chapter(entry: dict[str, Any], notebooks: Path) -> Chapter:
    for key in KEYS:
        if key not in entry:
            which = entry.get("notebook", entry)
            raise BookError(f"book.toml: no key {key!r} in the chapter {which}")
    return Chapter(
        notebook=notebooks / entry["notebook"],
        title=entry["title"],
        summary=entry["summary"],
        figures=tuple(entry["figures"]),
        timeout=float(entry["timeout"]),
        part=entry["part"],
    )


def _missing_notebooks(book: Book, notebooks: Path) -> Iterator[str]:
    for chapter in book.chapters:
        if not chapter.notebook.is_file():
            yield f"no notebook {chapter.notebook.name} in {notebooks}"


def _figure_troubles(book: Book) -> Iterator[str]:
    """What is wrong with the names of figures: unknown, forgotten, or there twice.

    The gallery of chapters on the first page shows one of each.
    """
    for chapter in book.chapters:
        if not chapter.figures:
            yield f"no figure in the chapter {chapter.notebook.name}: name one at least"
    known = list(FIGURES)
    named = [name for chapter in book.chapters for name in chapter.figures]
    for name in dict.fromkeys(named):
        if name not in known:
            yield f"unknown figure {name}; there are {', '.join(known)}"
    for name in known:
        if name not in named:
            yield f"figure {name} is in no chapter"
    for name in dict.fromkeys(named):
        if named.count(name) > 1:
            yield f"figure {name} is in two chapters"
