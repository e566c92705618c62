"""A figure as a file that says how it came about.

It is a picture (.png, .pdf, .svg), a moving one (.gif), or what it shows as a table
(.csv).  Every file carries four facts: the title, the parameters, the versions, and the
data.  It has no date in it, so that the same figure makes the same file.
"""

import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import matplotlib
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from PIL import Image
from tqdm import tqdm

import mkt
from mkt.figures import light_pdf
from mkt.figures.registry import Entry, Shown
from mkt.files import DataError, new_file, whole
from mkt.plotting import in_style
from mkt.sequences import benchmarks

KEYS = {  # what each format calls the four facts
    ".png": ("Title", "Comment", "Software", "Source"),
    ".pdf": ("Title", "Keywords", "Creator", "Subject"),
    ".svg": ("Title", "Keywords", "Creator", "Source"),
    ".csv": ("Title", "Parameters", "Versions", "Data"),
    ".gif": ("Title", "Parameters", "Versions", "Data"),  # lines of its comment
}
UNDATED = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
SHARP_DPI = 200
MOVING = ".gif"  # of a figure with a parameter `frame`
MOVING_DPI, MOVING_MS, COLORS = 56, 120, 32
PLACES = "%.6g"  # of the numbers in a table


class Facts(NamedTuple):
    """Title, parameters, versions and data of a figure, in words."""

    title: str
    parameters: str
    versions: str
    data: str


def checked(path: Path | str) -> Path:
    """The path of a file to write, checked before the long work and not after it.

    Raises
    ------
    ValueError
        For another ending.
    OSError
        As `mkt.files.new_file` does.
    """
    path = Path(path)
    if path.suffix.lower() not in KEYS:
        raise ValueError(
            f"{path}: the ending says what to write; take one of {', '.join(KEYS)}"
        )
    return new_file(path)


def write(entry: Entry, path: Path | str, parameters: Mapping[str, Any]) -> None:
    """Draw a figure, with its defaults except for some parameters, into a file.

    Its format is the one that the ending of the file names.

    Raises
    ------
    ValueError
        For another ending, an unknown parameter, or one that leaves nothing to draw.
    FileNotFoundError
        For a missing folder.
    OSError
    """
    path = checked(path)
    try:
        if path.suffix.lower() == MOVING:
            return _write_moving(entry, path, parameters)
        about = facts(entry, parameters)  # before the work: it may refuse MKT_DATA
        fig, shown = entry.draw(SHARP_DPI, **parameters)
    except DataError:
        raise
    except (ValueError, IndexError, ArithmeticError, MemoryError, cv2.error) as error:
        values = ", ".join(f"{name}={value}" for name, value in parameters.items())
        raise ValueError(
            f"{entry.name} cannot be drawn with {values or 'its defaults'}: {error}"
        ) from error
    with whole(path) as half:
        save(fig, shown, half, about)


def _write_moving(entry: Entry, path: Path, parameters: Mapping[str, Any]) -> None:
    """A figure at every second position of its parameter `frame`, as a film."""
    if "frame" not in entry.sliders:
        raise ValueError("it has no parameter 'frame', over which a .gif could move")
    if "frame" in parameters:
        raise ValueError("a .gif moves over 'frame'; leave it out, or take a .png")
    pictures = [
        picture.quantize(COLORS, dither=0)
        for picture in moving(entry, parameters, MOVING_DPI)
    ]
    frames = _moments(entry)
    shown = facts(entry, {**parameters, "frame": f"{frames[0]} to {frames[-1]}"})
    with whole(path) as half:
        pictures[0].save(
            half,
            save_all=True,
            append_images=pictures[1:],
            duration=MOVING_MS,
            loop=0,
            comment="\n".join(_lines(dict(zip(KEYS[MOVING], shown, strict=True)))),
        )


def moving(
    entry: Entry, parameters: Mapping[str, Any], dpi: int
) -> Iterator[Image.Image]:
    """The RGB pictures of a figure at every second position of its `frame`."""
    for k in tqdm(_moments(entry), desc="frames", disable=None):
        fig, _ = entry.draw(dpi, **{**parameters, "frame": k})
        drawn = io.BytesIO()
        with in_style():
            fig.savefig(drawn, format="png")
        yield Image.open(drawn).convert("RGB")


def _moments(entry: Entry) -> Sequence[Any]:
    """Where its film shows a figure: every second position of `frame`."""
    return entry.values("frame")[::2]


def write_all(entries: Iterable[Entry], folder: Path, ending: str) -> None:
    """Draw figures with their defaults into folder/NAME.ending, under a progress bar.

    Raises
    ------
    ValueError
        For the name of a file.
    OSError
    """
    if (suffix := folder.suffix).lower() in KEYS:
        raise ValueError(
            f"{folder}: all figures go into a folder; give its name without {suffix}, "
            "and say what is written with --format"
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        what = f"{folder} cannot be made a folder: {error.strerror}"
        raise OSError(f"{what}; give the name of another") from error
    for entry in tqdm(list(entries), desc="figures", unit="figure", disable=None):
        write(entry, folder / f"{entry.name}.{ending}", {})


def facts(entry: Entry, parameters: Mapping[str, Any]) -> Facts:
    """The four facts of a figure.

    The data are what the caption says, and which benchmarks are there.

    Parameters
    ----------
    entry : Entry
    parameters : dict
        Those that differ from the defaults.
    """
    values = entry.defaults | dict(parameters)
    names = {found.archive.name for found in benchmarks.sequences()}
    there = ", ".join(sorted(names)) or "none"
    versions = (
        f"mkt {mkt.__version__}, numpy {np.__version__}, "
        f"matplotlib {matplotlib.__version__}, opencv {cv2.__version__}"
    )
    return Facts(
        f"{entry.name}: {entry.title}",
        ", ".join(f"{name}={value}" for name, value in values.items()),
        versions,
        " ".join(f"{entry.caption} Benchmarks at hand: {there}.".split()),
    )


def save(
    fig: Figure, shown: Shown, path: Path, facts: Facts, light: bool = False
) -> None:
    """Write a drawn figure, or what it shows, into a file.

    Parameters
    ----------
    fig : Figure
    shown : Shown
    path : Path
    facts : Facts
    light : bool
        Whether a PDF has its photographs as JPEG.
    """
    ending = path.suffix.lower()
    named = dict(zip(KEYS[ending], facts, strict=True))
    if ending == ".csv":
        path.write_text(as_csv(shown, named), encoding="utf-8")
        return
    # Not the file itself: a PDF that cannot be written ends in an error that says
    # nothing.
    picture = io.BytesIO()
    with in_style(), matplotlib.rc_context({"svg.hashsalt": "mkt"}):
        metadata = named | UNDATED.get(ending, {})
        fig.savefig(picture, format=ending[1:], metadata=metadata)
    content = picture.getvalue()
    if light and ending == ".pdf":
        content = light_pdf.lighter(content)
    path.write_bytes(content)


def as_csv(shown: Shown, named: Mapping[str, str]) -> str:
    """What a figure shows as a table, under lines that begin with #.

    These say how the figure came about, and which facts it has, if they are short.
    """
    short = {name: fact for name, fact in shown.facts.items() if np.size(fact) <= 20}
    lines = _lines(named)
    lines += [f"{name}: {_in_a_line(fact)}" for name, fact in short.items()]
    head = "".join(f"# {line}\n" for line in lines)
    return head + _rounded(shown.table).to_csv(index=False, lineterminator="\n")


def _lines(named: Mapping[str, str]) -> list[str]:
    return [f"{name}: {text}" for name, text in named.items()]


def _in_a_line(fact: Any) -> str:
    words = np.array2string(np.asarray(fact), precision=6, separator=", ")
    return " ".join(words.split())


def _rounded(table: pd.DataFrame) -> pd.DataFrame:
    """The table with numbers of a few places, so that it is no larger than it needs."""
    numbers = table.select_dtypes("floating")
    text = numbers.map(lambda value: "" if np.isnan(value) else PLACES % value)
    return table.assign(**{str(name): text[name] for name in text})
