"""Less to load: what pages carry inside becomes files, which come when looked at.

A notebook's output holds its pictures and films as text, a third longer than their
bytes, and a page that has them all inside must be loaded whole.
"""

import base64
import hashlib
import os
import re
from functools import partial
from pathlib import Path

import cv2

FOLDER = "_static/data"
INSIDE = re.compile(r"data:(?:image|video)/(webp|webm);base64,([A-Za-z0-9+/=]{2000,})")
DRAWINGS = "_images"  # of cells, as Sphinx lays them out
DRAWING = re.compile(rf"({DRAWINGS}/\w+)\.png")
# Lines and letters are smaller without loss, photographs with some.
ENCODINGS = [(cv2.IMWRITE_WEBP_QUALITY, quality) for quality in (101, 80)]


def lighten(folder: Path) -> None:
    """Take the pictures and films of a site out of its pages, and its PNG for WebP."""
    (folder / FOLDER).mkdir(parents=True, exist_ok=True)
    for picture in (folder / DRAWINGS).glob("*.png"):
        _reduce(picture)
    for page in folder.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        beside = Path(os.path.relpath(folder / FOLDER, page.parent)).as_posix()
        lighter = INSIDE.sub(partial(_moved, folder / FOLDER, beside), text)
        lighter = DRAWING.sub(r"\1.webp", lighter)
        if lighter != text:
            page.write_text(lighter, encoding="utf-8")


def _moved(folder: Path, beside: str, found: re.Match) -> str:
    """The address of a file that holds what was found in a page."""
    ending, text = found.groups()
    content = base64.b64decode(text)
    name = f"{hashlib.sha256(content).hexdigest()[:20]}.{ending}"
    (folder / name).write_bytes(content)
    return f"{beside}/{name}"


def _reduce(picture: Path) -> None:
    """Replace a PNG by the smaller one of two WebP."""
    pixels = cv2.imread(str(picture), cv2.IMREAD_UNCHANGED)
    made = [cv2.imencode(".webp", pixels, each)[1].tobytes() for each in ENCODINGS]
    picture.with_suffix(".webp").write_bytes(min(made, key=len))
    picture.unlink()
