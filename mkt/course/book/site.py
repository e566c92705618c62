"""The site: Sphinx's sources are laid out in a folder, then Sphinx makes pages of them.

Nothing is executed here.
"""

import ast
import copy
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import nbformat
from nbformat import NotebookNode

from mkt.course.book import lighter, live, pages, pictures, positions, security
from mkt.course.book.checks import figure_cells, strip, tree
from mkt.course.book.contents import Book, BookError
from mkt.course.labs.notebooks import HANDOUT, labs, released
from mkt.experiments import claims, leaderboard, shipped
from mkt.figures.static_panel import FILES, SCRIPT
from mkt.files import NOTEBOOKS, named

PICTURE = "image/png"
IMPORTS = ast.Import, ast.ImportFrom
HEADING = re.compile(r"^#{1,6} (.+)$", re.MULTILINE)


def make(
    book: Book,
    notebooks: Mapping[str, NotebookNode],
    folder: Path,
) -> Path:
    """Write the site.

    Parameters
    ----------
    book : Book
    notebooks : dict
        Name of each chapter -> its executed notebook.
    folder : Path

    Returns
    -------
    Path
        Of the first page.

    Raises
    ------
    BookError
        When Sphinx fails.
    DataError
        When the numbers of the release cannot be read.
    OSError
        When there is no room.
    """
    source = folder / "source"
    texts = (
        _pages(book, notebooks)
        | _scripts()
        | _reference()
        | _chapters(notebooks)
        | _labs()
    )
    files = {name: text.encode() for name, text in texts.items()}
    with named(source):
        write(files, source)
    with rendered(source, folder) as fresh:
        # Sphinx leaves the other cores alone, and pages only name these files.
        drawn = pictures.drawn() | pictures.film()
        data = live.data()
    with named(fresh):
        write(drawn, fresh / FILES)
        write(data, fresh / live.FILES)
        lighter.lighten(fresh)
        security.seal(fresh)
    site = folder / "html"
    shutil.rmtree(site, ignore_errors=True)
    fresh.replace(site)
    return site / "index.html"


def _pages(book: Book, notebooks: Mapping[str, NotebookNode]) -> dict[str, str]:
    """{path below the source folder: text} of what stands round the chapters."""
    measured, made = shipped.read_claims()
    results = [claims.judge(one) for one in measured]
    again = [claims.judge(one) for one in shipped.claimed(table=shipped.AGAIN)]
    boards = leaderboard.shipped()
    return {
        "conf.py": pages.configuration(book),
        "index.md": pages.first(book, results, again),
        "gallery.md": pages.gallery(book, positions.of_first_sliders(notebooks)),
        "claims.md": pages.claims(book, results, again, made),
        "leaderboard.md": pages.leaderboard(boards),
        "after.md": pages.after(boards),
        "tasks.md": pages.tasks(),
        "track.md": pages.track(),
        "symbols.md": (NOTEBOOKS / "symbols.md").read_text(encoding="utf-8"),
    }


def _scripts() -> dict[str, str]:
    """The same for the styles, and for what moves the figures."""
    files = *pages.STYLES, SCRIPT, pages.TEXT, pages.PLAYS
    texts = {path.name: path.read_text("utf-8") for path in files}
    texts[live.SCRIPT] = live.script()
    return {f"_static/{name}": text for name, text in texts.items()}


def _reference() -> dict[str, str]:
    """The same for the pages of the library, under their new and their old names."""
    _, *names = pages.modules()
    reference = {f"api/{name}.rst": pages.module(name) for name in names}
    old = {f"moved/{name}": text for name, text in pages.moved().items()}
    return {"api/index.rst": pages.library(names)} | reference | old


def _chapters(notebooks: Mapping[str, NotebookNode]) -> dict[str, str]:
    """The same for the chapters, and for their notebooks, to be downloaded."""
    shown = {
        f"{name}.ipynb": nbformat.writes(_with_link(prepare(notebook), name))
        for name, notebook in notebooks.items()
    }
    return shown | {
        f"{pages.NOTEBOOKS}/{name}.ipynb": nbformat.writes(strip(notebook), indent=None)
        for name, notebook in notebooks.items()
    }


def _with_link(page: NotebookNode, name: str) -> NotebookNode:
    """The page with a link to its notebook, below what one needs for the chapter."""
    at = [cell.id for cell in page.cells].index("opening") + 1
    link = (
        f'<p class="mkt-notebook"><a href="{pages.NOTEBOOKS}/{name}.ipynb" download>'
        "Download this notebook</a>, or open all of them in JupyterLab with "
        "<code>python3 -m mkt lab</code>.</p>"
    )
    page.cells.insert(at, nbformat.v4.new_markdown_cell(link, id="notebook"))
    return page


def _labs() -> dict[str, str]:
    """The same for the labs as students get them, where chapters look for them."""
    return {
        f"{HANDOUT.name}/{name}.ipynb": nbformat.writes(released(lab))
        for name, lab in labs().items()
    }


def write(files: Mapping[str, bytes], folder: Path) -> None:
    """Make a folder hold these files, {path: content}, and no others.

    It touches only what differs, so that Sphinx reads no page twice.
    """
    for path in folder.rglob("*"):
        if path.is_file() and path.relative_to(folder).as_posix() not in files:
            path.unlink()
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_bytes() != content:
            path.write_bytes(content)


def prepare(notebook: NotebookNode) -> NotebookNode:
    """An executed notebook as the page shows it.

    It has a place to jump to before each figure, alternative texts, and no reprs of
    drawing calls; imports are folded.
    """
    page = copy.deepcopy(notebook)
    figures = {cell.id: names for cell, names in figure_cells(page)}
    placed: set[str] = set()
    cells = []
    heading = ""
    for cell in page.cells:
        if cell.cell_type == "markdown":
            heading = [heading, *HEADING.findall(cell.source)][-1]
        fresh = [name for name in figures.get(cell.id, ()) if name not in placed]
        placed.update(fresh)
        cells += [_place(name) for name in fresh]
        if cell.cell_type == "code":
            _describe(cell, heading)
            _fold_imports(cell)
        cells.append(cell)
    page.cells = cells
    return page


def _place(name: str) -> NotebookNode:
    """A cell to jump to."""
    anchor = pages.anchor(name)
    return nbformat.v4.new_markdown_cell(f'<span id="{anchor}"></span>', id=anchor)


def _fold_imports(cell: NotebookNode) -> None:
    """Fold a cell that does little but import, so that only its place is shown."""
    imports = [isinstance(node, IMPORTS) for node in tree(cell).body]
    if imports and sum(imports) > len(imports) / 2:
        cell.metadata["tags"] = [*cell.metadata.get("tags", ()), "hide-input"]


def _describe(cell: NotebookNode, heading: str) -> None:
    """Give the picture of a cell its text, and leave out what drawing calls return."""
    pictures = [output for output in cell.outputs if PICTURE in output.get("data", {})]
    if not pictures:
        return
    cell.outputs = [
        output
        for output in cell.outputs
        if output.output_type != "execute_result" or output in pictures
    ]
    about = pictures[0].metadata.get(PICTURE, {})
    plain = re.sub(r"[*`$\\]", "", heading)
    text = about.get("alt", f"What the cell above draws, under: {plain}")
    cell.metadata["mystnb"] = {"image": {"alt": text}}


@contextmanager
def rendered(source: Path, folder: Path) -> Iterator[Path]:
    """Let Sphinx write the site beside the old one, while the ``with`` does other work.

    Yields
    ------
    Path
        Of the folder that is complete after the ``with``.

    Raises
    ------
    BookError
        When Sphinx fails.
    """
    fresh = folder / "html.fresh"
    shutil.rmtree(fresh, ignore_errors=True)
    program = [sys.executable, "-m", "sphinx", "-b", "html", "-q"]
    print("Sphinx writes the pages", file=sys.stderr, flush=True)
    with subprocess.Popen([*program, "-d", folder / "doctrees", source, fresh]) as run:
        try:
            yield fresh
        except BaseException:
            run.terminate()
            raise
    if run.returncode:
        raise BookError("Sphinx could not write the site, see above")
