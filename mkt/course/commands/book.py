"""``book`` builds the book, ``strip`` makes its notebooks ready to be committed."""

import os

from mkt.course.commands import Commands, command
from mkt.files import BUILD, alone


def add(commands: Commands) -> None:
    """Describe both commands."""
    command(
        commands,
        "book",
        run_book,
        "execute the notebooks and build the book",
        "Executes every notebook of book.toml that changed and builds the site into\n"
        "_build/html; open _build/html/index.html.",
        clone=True,
    )
    command(
        commands,
        "strip",
        run_strip,
        "remove outputs from the notebooks",
        "Removes outputs and execution counts from the notebooks of book.toml and\n"
        "from the labs, as they are to be committed.",
        clone=True,
    )


def run_book(args) -> None:
    """Build the book and say where it is."""
    from mkt.course import book

    with alone(BUILD / "book.lock", "book"):
        print(f"The book is ready: open {book.build().as_uri()}")


def run_strip(args) -> None:
    """Strip the notebooks and name those that changed."""
    from mkt.course import book

    for path in book.strip_all():
        print(f"stripped {os.path.relpath(path)}")
