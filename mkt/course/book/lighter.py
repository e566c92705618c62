"""Pages that load faster: what they carry inside becomes files, loaded when seen.

A notebook's output holds its pictures and films as text, a third longer than their
bytes, and a page that has them all inside must be loaded whole.
"""

import base64
import hashlib
import os
import re
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import cv2

from mkt.course.book.punctuation import with_signs, with_units
from mkt.experiments.cache import Shelf, key

FOLDER = "_static/data"
INSIDE = re.compile(
    r"data:(?:image|video)/(avif|svg|webp|webm)(?:\+xml)?;base64,"
    r"([A-Za-z0-9+/=]{2000,})"
)
DRAWINGS = "_images"  # of cells, as Sphinx lays them out
DRAWING = re.compile(rf"({DRAWINGS}/(\w+))\.png")
# What the theme writes in the colour of all code needs nothing round it.
PLAIN = re.compile(r'<span class="(?:n|p|w)">([^<]*)</span>')
# The theme's icons are in every page, even those that it does not use.
ICON = re.compile(r'<symbol id="(svg-[\w-]+)".*?</symbol>\s*', re.DOTALL)
# Indentation means nothing except where it is shown as it is, and in scripts; nor do
# comments, and the type of style sheets, of which there is but one.
AS_IT_IS = r"(<(pre|script|textarea)\b.*?</\2>)"
BLANKS = re.compile(rf"{AS_IT_IS}|\n\s+", re.DOTALL)
SPARE = re.compile(rf'{AS_IT_IS}|<!--.*?-->| type="text/css"', re.DOTALL)
# Lines and letters are smaller without loss, photographs with some.
ENCODINGS = [
    (".webp", (cv2.IMWRITE_WEBP_QUALITY, 101)),
    (".avif", (cv2.IMWRITE_AVIF_QUALITY, 65, cv2.IMWRITE_AVIF_SPEED, 8)),
]
# A picture as ENDING, a new line, and its bytes.
LIGHTER = Shelf("lighter", ".picture", bytes, bytes)


def lighten(folder: Path) -> None:
    """Take pictures and films out of the pages of a site, and make both smaller."""
    (folder / FOLDER).mkdir(parents=True, exist_ok=True)
    drawings = list((folder / DRAWINGS).glob("*.png"))
    with ThreadPoolExecutor(os.cpu_count()) as pool:  # OpenCV lets other threads run
        encoded = pool.map(_reduce, drawings)
    endings = {
        path.stem: ending for path, ending in zip(drawings, encoded, strict=True)
    }
    for origin in folder.rglob("*.map"):  # of the theme, for those who make it
        origin.unlink()
    for page in folder.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        beside = Path(os.path.relpath(folder / FOLDER, page.parent)).as_posix()
        lighter = INSIDE.sub(partial(_moved, folder / FOLDER, beside), text)
        lighter = DRAWING.sub(lambda found: found[1] + endings[found[2]], lighter)
        lighter = with_units(with_signs(_shorter(lighter)))
        if lighter != text:
            page.write_text(lighter, encoding="utf-8")


def _shorter(page: str) -> str:
    """A page without what no reader sees."""
    page = ICON.sub(lambda found: found[0] * (f'"#{found[1]}"' in page), page)
    page = SPARE.sub(lambda found: found[1] or "", page)
    page = BLANKS.sub(lambda found: found[1] or "\n", page)
    return PLAIN.sub(r"\1", page)


def address(inside: str) -> str:
    """Where a picture that a page carries inside will lie, from the top of the site."""
    found = INSIDE.fullmatch(inside)
    if not found:
        raise ValueError(f"no picture inside a page: {inside[:40]}")
    return f"{FOLDER}/{_name(*found.groups())}"


def _name(ending: str, text: str) -> str:
    """The name of the file of a picture or a film, given its text."""
    return f"{hashlib.sha256(base64.b64decode(text)).hexdigest()[:20]}.{ending}"


def _moved(folder: Path, beside: str, found: re.Match) -> str:
    """The address of a file that holds what was found in a page."""
    name = _name(*found.groups())
    (folder / name).write_bytes(base64.b64decode(found[2]))
    return f"{beside}/{name}"


def _reduce(picture: Path) -> str:
    """Replace a PNG by the smallest of its encodings, and return its new ending."""
    known = key(picture.read_bytes(), ENCODINGS, cv2.__version__)
    made = LIGHTER.kept(known, lambda: _smallest(picture))
    ending, _, content = made.partition(b"\n")
    picture.with_suffix(ending.decode()).write_bytes(content)
    picture.unlink()
    return ending.decode()


def _smallest(picture: Path) -> bytes:
    """The smallest encoding, as `LIGHTER` keeps it."""
    pixels = cv2.imread(str(picture), cv2.IMREAD_UNCHANGED)
    made = (
        ending.encode() + b"\n" + cv2.imencode(ending, pixels, options)[1].tobytes()
        for ending, options in ENCODINGS
    )
    return min(made, key=len)
