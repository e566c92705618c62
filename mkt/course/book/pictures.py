"""The pictures of the gallery, and what can be saved under every figure.

A figure's picture, its PDF and its table are kept under what they depend on, so one
that changed is drawn anew by itself.
"""

import io
import warnings
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from tqdm import tqdm

from mkt.course.book import depends
from mkt.experiments.cache import Shelf
from mkt.experiments.processes import spread
from mkt.figures import export, light_pdf
from mkt.figures.registry import FIGURES, Entry
from mkt.figures.static_panel import AVIF, encoded

THUMBNAIL_DPI = 100
# What is drawn of each figure, by the ending of the file.
DRAWN = {
    ending: Shelf("pictures", ending, bytes, bytes)
    for ending in (".avif", ".pdf", ".csv")
}
# The film of the first page, as large as the page, with all colours: data/tracked.gif
# shows the same, of few colours. And one picture of it, for those who want no motion.
FILM, STILL = "tracked.avif", "tracked-still.avif"
RUN, SETTINGS, FILM_DPI = "own.run", {"tracker": "pf-75"}, 76
MOVING = {"quality": 55, "speed": 8, "duration": export.MOVING_MS}


def drawn() -> dict[str, bytes]:
    """{file name: content} of what is drawn of every figure.

    Those that are not known are drawn, on all cores.
    """
    how = THUMBNAIL_DPI, AVIF, light_pdf.QUALITY
    keys = {name: depends.of_picture(entry, how) for name, entry in FIGURES.items()}
    known = {name: _kept(key) for name, key in keys.items()}
    missing = [name for name, files in known.items() if files is None]
    for name, files in _draw_all(missing):
        known[name] = files
        for ending, content in files.items():
            DRAWN[ending].put(keys[name], content)
    return {
        f"{name}{ending}": content
        for name, files in known.items()
        for ending, content in (files or {}).items()
    }


def film() -> dict[str, bytes]:
    """{file name: content} of the film of the first page, and of a picture of it."""
    entry = FIGURES[RUN]
    makers = {FILM: (MOVING, _filmed), STILL: (AVIF, _still)}
    return {
        name: DRAWN[".avif"].kept(
            depends.of_picture(entry, SETTINGS, FILM_DPI, how), partial(make, entry)
        )
        for name, (how, make) in makers.items()
    }


def _filmed(entry: Entry) -> bytes:
    """A figure as an AVIF, which stores only what changes between pictures."""
    first, *others = export.moving(entry, SETTINGS, FILM_DPI)
    made = io.BytesIO()
    first.save(made, "AVIF", save_all=True, append_images=others, **MOVING)
    return _once(made.getvalue())


def _once(film: bytes) -> bytes:
    """An AVIF that stops at its last picture: one that goes on disturbs a reader.

    Pillow always asks for repetition, by the flag of the edit list (ISO 14496-12, 8.6.6
    and its amendment: 4 letters, 1 byte of version, 3 of flags).
    """
    flag = film.index(b"elst") + 7
    return film[:flag] + b"\0" + film[flag + 1 :]


def _still(entry: Entry) -> bytes:
    """The figure as it is without anybody moving it."""
    fig, _ = entry.draw(FILM_DPI, **SETTINGS)
    return encoded(fig, ".avif", *AVIF)


def _kept(key: str) -> dict[str, bytes] | None:
    """What was drawn of a figure, None where a part of it is missing."""
    files = {ending: shelf.get(key) for ending, shelf in DRAWN.items()}
    return None if None in files.values() else files


def _draw_all(names: list[str]) -> Iterator[tuple[str, dict[str, bytes]]]:
    """What `_draw` returns for each figure, as they come."""
    with warnings.catch_warnings():
        # joblib replaces a worker that has grown large, and nothing is lost.
        warnings.filterwarnings("ignore", "A worker stopped")
        results = spread(_draw, ((name,) for name in names), in_order=False)
        quiet = None if names else True
        yield from tqdm(
            results, "figures", total=len(names), unit="figure", disable=quiet
        )


def _draw(name: str) -> tuple[str, dict[str, bytes]]:
    """The name of a figure, and {ending: content} of what is drawn of it."""
    entry = FIGURES[name]
    fig, shown = entry.draw(THUMBNAIL_DPI)
    files = {".avif": encoded(fig, ".avif", *AVIF)}
    with TemporaryDirectory() as folder:
        for ending in (".pdf", ".csv"):
            path = Path(folder, f"figure{ending}")
            export.save(fig, shown, path, export.facts(entry, {}), light=True)
            files[ending] = path.read_bytes()
    return name, files
