"""book.toml, the single catalogue: which chapters there are, in which order, with which figures."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

from mkt import figures

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = ROOT / "notebooks"


class BookError(Exception):
    """The book cannot be built; the message says where and why."""


@dataclass(frozen=True)
class Chapter:
    """One notebook: its path, its title and one-sentence summary, the ids of its figures, and the seconds it may take."""

    notebook: Path
    title: str
    summary: str
    figures: tuple[str, ...]
    timeout: float

    @property
    def name(self):
        """The notebook's name without its ending; the page is called the same."""
        return self.notebook.stem


@dataclass(frozen=True)
class Book:
    """Title and description of the book, the id of the figure on its first page, and its `Chapter` objects in order."""

    title: str
    description: str
    cover: str
    chapters: tuple[Chapter, ...]


def read(path=ROOT / "book.toml", notebooks=NOTEBOOKS):
    """The `Book` of a catalogue.  Raises BookError for a missing key or notebook, and for a figure that is unknown, forgotten or named twice."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
        chapters = tuple(_chapter(entry, notebooks) for entry in table["chapter"])
        book = Book(table["title"], table["description"].strip(), table["cover"], chapters)
    except (KeyError, tomllib.TOMLDecodeError) as error:
        raise BookError(f"{path.name}: {f'no key {error}' if isinstance(error, KeyError) else error}") from None
    troubles = [f"no notebook {c.notebook.name} in {notebooks}" for c in chapters if not c.notebook.is_file()] + _figure_troubles(book)
    if troubles:
        raise BookError("\n".join(f"{path.name}: {trouble}" for trouble in troubles))
    return book


def _chapter(entry, notebooks):
    for key in ("notebook", "title", "summary", "figures", "timeout"):
        if key not in entry:
            raise BookError(f"book.toml: no key {key!r} in the chapter {entry.get('notebook', entry)}")
    return Chapter(notebooks / entry["notebook"], entry["title"], entry["summary"], tuple(entry["figures"]), float(entry["timeout"]))


def _figure_troubles(book):
    known, named = list(figures.registry()), [id for chapter in book.chapters for id in chapter.figures]
    unknown = [f"unknown figure {id}; there are {', '.join(known)}" for id in dict.fromkeys([*named, book.cover]) if id not in known]
    forgotten = [f"figure {id} is in no chapter" for id in known if id not in named]
    twice = [f"figure {id} is in two chapters" for id in dict.fromkeys(named) if named.count(id) > 1]
    return unknown + forgotten + twice
