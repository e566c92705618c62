"""``book`` builds the book, ``strip`` makes its notebooks ready to be committed."""

import os
import sys

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
    parser = command(
        commands,
        "strip",
        run_strip,
        "remove outputs from the notebooks",
        "Removes outputs and execution counts from the notebooks of book.toml and\n"
        "from the labs, as they are to be committed.  With - it is a filter, which\n"
        "`lab` has git use: a chapter that was run is no change then.",
        clone=True,
    )
    parser.add_argument(
        "stream", nargs="?", choices=["-"], help="from standard input to output"
    )


def run_book(args) -> None:
    """Build the book and say where it is."""
    from mkt.course import book

    with alone(BUILD / "book.lock", "book"):
        print(f"The book is ready: open {book.build().as_uri()}")


def run_strip(args) -> None:
    """Strip the notebooks and name those that changed, or the one that is read."""
    if args.stream:
        import nbformat

        from mkt.course.book import checks

        notebook = nbformat.reads(sys.stdin.buffer.read().decode("utf-8"), 4)
        text = nbformat.writes(checks.strip(notebook)) + "\n"
        sys.stdout.buffer.write(text.encode("utf-8"))
        return
    from mkt.course import book

    for path in book.strip_all():
        print(f"stripped {os.path.relpath(path)}")
