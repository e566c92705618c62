"""The site: Sphinx's sources are laid out under _build/source, then Sphinx writes _build/html.  Nothing is executed here."""

import copy
import os
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import nbformat
from joblib import Parallel, delayed
from tqdm import tqdm

from mkt import export, figures, page
from mkt.book import pages
from mkt.book.catalogue import NOTEBOOKS, BookError
from mkt.book.checks import figure_cells
from mkt.book.execute import library_key
from mkt.files import named

STYLE = Path(__file__).with_name("mkt.css")
THUMBNAIL_DPI, LARGEST_PDF = 100, 500_000  # [bytes]


def make(book, notebooks, results, boards, folder):
    """Write the site of a `Book` with its executed notebooks, {name: notebook}, the judged claims and the boards of the trackers.

    Returns the path of the first page.
    """
    source = folder / "source"
    with named(source):
        write(_sources(book, notebooks, results, boards), source)
        draw_all(source / page.FILES)
    return render(source, folder)


def _sources(book, notebooks, results, boards):
    """{path below the source folder: text} of everything that Sphinx reads."""
    names = pages.modules()
    texts = {"conf.py": pages.configuration(book), "index.md": pages.first(book), "gallery.md": pages.gallery(book),
             "claims.md": pages.claims(results), "leaderboard.md": pages.leaderboard(boards),
             "symbols.md": (NOTEBOOKS / "symbols.md").read_text(encoding="utf-8"), "_static/mkt.css": STYLE.read_text(encoding="utf-8"),
             "api/index.rst": pages.library(names)}
    texts |= {f"api/{name}.rst": pages.module(name) for name in names[1:]}
    return texts | {f"{name}.ipynb": nbformat.writes(prepare(notebook)) for name, notebook in notebooks.items()}


def write(texts, folder):
    """Make a folder hold these texts, {path: text}, beside the drawn figures, touching only what differs, so that Sphinx reads no page twice."""
    for path in folder.rglob("*"):
        if path.is_file() and path.parent != folder / page.FILES and path.relative_to(folder).as_posix() not in texts:
            path.unlink()
    for name, text in texts.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def prepare(notebook):
    """An executed notebook as the page shows it: a place to jump to before each figure, alternative texts, no reprs of drawing calls."""
    shown, seen = copy.deepcopy(notebook), set()
    calls = {cell.id: ids for cell, ids in figure_cells(shown)}
    cells = []
    for cell in shown.cells:
        fresh = [id for id in calls.get(cell.id, ()) if id not in seen]
        cells += [nbformat.v4.new_markdown_cell(f'<span id="{pages.anchor(id)}"></span>', id=pages.anchor(id)) for id in fresh]
        seen.update(fresh)
        cells.append(_described(cell) if cell.cell_type == "code" else cell)
    shown.cells = cells
    return shown


def _described(cell):
    pictures = [output for output in cell.outputs if "image/png" in output.get("data", {})]
    if pictures:
        cell.outputs = [output for output in cell.outputs if output.output_type != "execute_result" or output in pictures]
        alt = pictures[0].metadata.get("image/png", {}).get("alt", "What the cell above draws")
        cell.metadata["mystnb"] = {"image": {"alt": alt}}
    return cell


def draw_all(folder):
    """Draw every registered figure with its defaults into folder/ID.webp, .pdf and .csv, unless those are what lies there: the mark comes last."""
    mark = folder / "drawn-from"
    if mark.is_file() and mark.read_text() == library_key():
        return
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    known = figures.registry()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "A worker stopped")  # joblib replaces one that has grown large, and nothing is lost
        drawn = Parallel(n_jobs=-1, return_as="generator_unordered")(delayed(_draw)(id, folder) for id in known)
        for _ in tqdm(drawn, desc="figures", unit="figure", total=len(known), disable=None):
            pass
    mark.write_text(library_key())


def _draw(id, folder):
    entry = figures.get(id)
    canvas, numbers = entry.draw(THUMBNAIL_DPI)
    canvas.savefig(folder / f"{id}.webp", pil_kwargs={"quality": 80})
    for ending in (".pdf", ".csv"):
        export.save(canvas, numbers, folder / f"{id}{ending}", export.facts(entry, {}), LARGEST_PDF)


def render(source, folder):
    """Let Sphinx write the site beside the old one, then put it in its place.  Returns the path of the first page."""
    fresh, site = folder / "html.fresh", folder / "html"
    shutil.rmtree(fresh, ignore_errors=True)
    quiet = [] if sys.stdout.isatty() else ["-q"]
    command = [sys.executable, "-m", "sphinx", "-b", "html", *quiet, "-d", folder / "doctrees", source, fresh]
    if subprocess.call(command):
        raise BookError("Sphinx could not write the site, see above")
    shutil.rmtree(site, ignore_errors=True)
    os.replace(fresh, site)
    return site / "index.html"
