"""What chapters, pictures and judged claims depend on, as keys of what is kept.

That is code, data and packages.  Code is what can be reached by imports from a
chapter's own imports and from the modules of the figures that it shows.  So a change in
`mkt.course` draws and runs nothing again, and a change in one paper's figures only what
shows them.
"""

import ast
import hashlib
import os
from collections.abc import Iterable, Iterator
from functools import lru_cache
from inspect import getsourcefile
from pathlib import Path
from typing import Any

from nbformat import NotebookNode

from mkt.course.book.checks import figure_cells, on_page, tree
from mkt.experiments import cache, dependencies, shipped
from mkt.experiments.shipped import PAPERS, reachable
from mkt.figures import export
from mkt.figures.registry import FIGURES, Entry
from mkt.files import DATA, ROOT, DataError
from mkt.sequences import benchmarks

PACKAGES = ROOT / "environment.txt"
# What lies beside a module is a template or a table that it reads; scripts and styles
# are for the browser.
NOT_READ = (".py", ".pyc", ".js", ".css")


def of_chapter(notebook: NotebookNode, *how: Any) -> str:
    """The key of a chapter's outputs: its code, not its text, and what that reaches.

    Parameters
    ----------
    notebook : NotebookNode
    *how
        Settings with which it is run.
    """
    code = [(cell.id, cell.source) for cell in on_page(notebook)]
    try:
        files = named_in(notebook)
    except SyntaxError:  # running it will report this
        files = []
    return cache.key("chapter", code, how, *_surroundings(files))


def of_picture(entry: Entry, *how: Any) -> str:
    """The key of a figure's picture, PDF and table, drawn with its defaults.

    Parameters
    ----------
    entry : Entry
    *how
        Settings with which it is drawn.
    """
    facts = export.facts(entry, {})
    files = [home(entry), Path(export.__file__)]
    return cache.key(entry.name, facts, how, *_surroundings(files))


def _surroundings(files: Iterable[Path]) -> Iterator[Any]:
    """What results of code that begins in some files depend on."""
    reached = reachable(files)
    yield _benchmarks(os.environ.get("MKT_DATA"))
    yield dependencies.versions()
    yield PACKAGES.read_text("utf-8")
    yield _digests(reached)
    yield [path.read_bytes() for path in beside(reached)]
    if Path(shipped.__file__) in reached:  # which reads the tables of the release
        tables = sorted([*DATA.glob("*.csv"), *DATA.glob("*.json")])
        yield [table.read_bytes() for table in tables]


@lru_cache(maxsize=4)
def _benchmarks(root: str | None) -> list[str]:
    """The sequences that are below MKT_DATA, with what is in their folders."""
    try:
        return [found.identity() for found in benchmarks.sequences()]
    except DataError:  # what reads them will report this
        return [str(root)]


def _digests(files: set[Path]) -> list[str]:
    """Those parts of some files that count.

    For files in the papers that is everything, because their docstrings are captions;
    for the others it is the code without comments, unless a figure prints source code
    as it stands.
    """
    papers = {path for path in files if PAPERS in path.parents}
    everything = any(_prints_code(path) for path in papers)
    return [_digest(path, everything or path in papers) for path in sorted(files)]


@lru_cache(maxsize=512)
def _prints_code(path: Path) -> bool:
    return "inspect.getsource" in path.read_text("utf-8")


@lru_cache(maxsize=512)
def _digest(path: Path, everything: bool) -> str:
    text = path.read_text("utf-8") if everything else dependencies.stripped(path)
    return hashlib.sha256(text.encode()).hexdigest()


def beside(files: Iterable[Path]) -> list[Path]:
    """Files that are no modules, in the folders of some modules."""
    folders = {path.parent for path in files}
    return sorted(
        path
        for folder in folders
        for path in folder.iterdir()
        if path.is_file() and path.suffix not in NOT_READ
    )


def named_in(notebook: NotebookNode) -> list[Path]:
    """The files whose code or figures the cells name that the book runs."""
    figures = _Figures()
    codes = [figures.visit(tree(cell)) for cell in on_page(notebook)]
    names = [name for code in codes for name in dependencies.names_in(code)]
    files = [file for name in names for file in dependencies.files_of(name)]
    shown = [name for _, names in figure_cells(notebook) for name in names]
    known = [name for name in (*shown, *figures.names) if name in FIGURES]
    return [*files, *(home(FIGURES[name]) for name in known)]


class _Figures(ast.NodeTransformer):
    """Takes each ``mkt.FIGURES["name"]`` out of code, and keeps the name.

    One figure is no reason to depend on all that the registry finds.
    """

    def __init__(self):
        self.names: list[str] = []

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        index = node.slice
        if isinstance(index, ast.Constant) and ast.unparse(node.value) == "mkt.FIGURES":
            self.names.append(str(index.value))
            return index
        return self.generic_visit(node)


def home(entry: Entry) -> Path:
    """The file of a figure's function."""
    return Path(getsourcefile(entry.function) or "")
