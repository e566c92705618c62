"""From notebooks to a book: `build` goes the whole way, one module a station.

`mkt.book.catalogue` reads book.toml, `mkt.book.execute` runs the notebooks, `mkt.book.checks` says what a notebook must be before and
after, `mkt.book.judged` puts the claims to the test, `mkt.book.pages` writes the pages around them, `mkt.book.site` lets Sphinx make the site of it all.
"""

from functools import partial

from mkt import leaderboard
from mkt.book import catalogue, checks, execute, judged, site
from mkt.book.catalogue import ROOT, BookError

BUILD = ROOT / "_build"


def build(folder=BUILD, judge=partial(judged.kept, BUILD / "claims.json"), rank=leaderboard.for_the_book):
    """Execute the chapters that changed, put the claims to the test, rank the trackers and make the site in a folder.

    Returns the path of its first page.  Raises BookError when a chapter fails, naming notebook and cell, or when the catalogue is wrong.
    """
    book = catalogue.read()
    notebooks = execute.execute_all(book.chapters, BUILD / "executed")
    pictureless = [f"{name}: {trouble}" for name, notebook in notebooks.items() for trouble in checks.executed(notebook)]
    if pictureless:
        raise BookError("\n".join(pictureless))
    return site.make(book, notebooks, judge(), rank(), folder)


def strip_all():
    """Strip every notebook of the book, and every lab, in place.  Returns the paths of those that changed."""
    labs = sorted((catalogue.NOTEBOOKS / "labs").glob("*.ipynb"))
    return [path for path in [*(chapter.notebook for chapter in catalogue.read().chapters), *labs] if checks.strip_file(path)]
