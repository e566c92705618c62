"""From notebooks to a book: `build` goes the whole way, one module for each station.

`mkt.course.book.contents` reads book.toml, `mkt.course.book.execute` runs the notebooks
(with `mkt.course.book.client`), `mkt.course.book.checks` says what a notebook must be
before and after, `mkt.course.book.pages` writes the pages round them,
`mkt.course.book.pictures` draws the figures, `mkt.course.book.positions` finds those of
their sliders, `mkt.course.book.agreement` says which agree with the printed ones,
`mkt.course.book.live` writes the scripts that compute in the pages, and
`mkt.course.book.site` lets Sphinx make the site of it all, with extensions for it
beside them: `mkt.course.book.reference` for the pages of the library,
`mkt.course.book.math_svg` for formulas, `mkt.course.book.accessibility`;
`mkt.course.book.lighter` takes pictures and films out of the pages,
`mkt.course.book.punctuation` keeps formulas and signs, numbers and units together, and
`mkt.course.book.security` says what these may do.
`mkt.course.book.depends` says what has to be made again.
"""

from pathlib import Path

from mkt.course.book import checks, contents, execute, site
from mkt.course.book.contents import BookError
from mkt.files import BUILD, NOTEBOOKS


def build(folder: Path = BUILD) -> Path:
    """Execute the chapters and make the site.

    What is known already is not done again; claims and trackers were run for the
    release (`mkt.experiments.shipped`).

    Parameters
    ----------
    folder : Path
        Where to put the site.

    Returns
    -------
    Path
        Of the first page.

    Raises
    ------
    BookError
        When a chapter fails, naming notebook and cell, or when the catalogue is wrong.
    """
    book = contents.read()
    notebooks = execute.execute_all(book.chapters)
    without_pictures = [
        f"{name}: {trouble}"
        for name, notebook in notebooks.items()
        for trouble in checks.executed(notebook)
    ]
    if without_pictures:
        raise BookError("\n".join(without_pictures))
    return site.make(book, notebooks, folder)


def strip_all() -> list[Path]:
    """Strip every notebook of the book, and every lab, in place.

    Returns
    -------
    list of Path
        Those that changed.
    """
    chapters = [chapter.notebook for chapter in contents.read().chapters]
    labs = sorted((NOTEBOOKS / "labs").glob("*.ipynb"))
    return [path for path in [*chapters, *labs] if checks.strip_file(path)]
