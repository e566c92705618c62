"""Tracks as text: a row for each frame; boxes that were found elsewhere; MOT's rows.

`COLUMNS` and `row` are the table of our own tracks, which has the angle too.  `read`
takes such a table, or boxes in the form of the truth of the sequence that they belong
to: what a tracker for OTB writes is counted from 1 as OTB's truth is, and so on.
"""

import csv
import os
import re
from pathlib import Path
from typing import Any

import numpy as np

from mkt.evaluation import overlap
from mkt.files import DataError, existing_file, whole
from mkt.regions import HX, to_box
from mkt.sequences import mot
from mkt.sequences.benchmarks import Found
from mkt.sequences.rows import read_rows
from mkt.sequences.truth import refuse_no_region
from mkt.sequences.video import ImageFolder
from mkt.tracking import Info, Sequence, Track
from mkt.types import NDArray, Regions

COLUMNS = (
    "frame",
    "cx [px]",
    "cy [px]",
    "theta [deg]",
    "hx [px]",
    "hy [px]",
    "score",
    "lost",
)
NOTHING = "correct the row, with NaN or zeros for all of it where nothing was found"
TARGET = 1  # its id in MOT's rows


def row(k: int, info: Info) -> list[Any]:
    """The info of frame k as the numbers of `COLUMNS`."""
    cx, cy, theta, hx, hy = info["region"]
    numbers = [f"{x:.3f}" for x in (cx, cy, np.degrees(theta), hx, hy)]
    return [k, *numbers, f"{info['score']:.4g}", int(info["lost"])]


def mot_row(k: int, info: Info) -> list[Any]:
    """The info of frame k as a row of MOT's results: the upright box round it.

    It is ``frame,id,left,top,width,height,confidence,-1,-1,-1``.
    """
    x, y, w, h = to_box(info["region"])
    numbers = [f"{number:.3f}" for number in (x + mot.FIRST, y + mot.FIRST, w, h)]
    return [k + mot.FIRST, TARGET, *numbers, f"{info['score']:.4g}", -1, -1, -1]


def rows_of(k: int, info: Info, as_mot: bool) -> list[list[Any]]:
    """The rows for frame k: `row`, or `mot_row`.

    MOT has none where the target is said to be lost, or to be nowhere.
    """
    if not as_mot:
        return [row(k, info)]
    found = not info["lost"] and np.isfinite(info["region"]).all()
    return [mot_row(k, info)] if found else []


def write(track: Track, path: str | os.PathLike, first: int = 0) -> None:
    """Write a track: as MOT's rows where the name ends in .txt, else as a table.

    Parameters
    ----------
    track : Track
    path : path
    first : int
        The track's first frame in the whole sequence of MOT, counted from 0.  MOT's
        rows count frames in the whole sequence; they leave out frames in which the
        target is said to be lost, or to be nowhere.

    Raises
    ------
    OSError
        Where the file cannot be written.
    """
    path = Path(path)
    infos = [
        {"region": region, "score": score, "lost": lost}
        for region, score, lost in zip(*track[:3], strict=True)
    ]
    as_mot = path.suffix.lower() == ".txt"
    begin = first if as_mot else 0
    rows = [
        line for k, info in enumerate(infos, begin) for line in rows_of(k, info, as_mot)
    ]
    with whole(path) as half, half.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows(
            rows if as_mot else [COLUMNS, *rows]
        )


def read(path: Path, found: Found) -> tuple[Track, Sequence]:
    """A track in a file, for a sequence of a benchmark, and that sequence.

    Parameters
    ----------
    path : Path
        Our table, with its head; or rows in the form of the sequence's own truth.  If
        MOT's rows have several ids, the one counts whose first box is nearest to the
        target's, because a tracker is told where that is.
    found : Found

    Returns
    -------
    track : Track
        NaN in frames without a row or with a box of zeros, and lost there; its score
        is NaN.
    clip : Sequence

    Raises
    ------
    DataError
        Naming the file, the line and the remedy.
    """
    path = existing_file(path)
    clip = found.sequence()
    head = path.read_text("utf-8-sig", "replace").lstrip('"')
    if head.startswith(COLUMNS[0]):
        _refuse_other_columns(path, head.splitlines()[0])
        regions, lost = _ours(path, found)
    else:
        regions = _regions(path, found, clip)
        lost = np.asarray(np.isnan(regions).any(1))
    if len(regions) != len(clip):
        last = found.first + len(clip) - 1
        raise DataError(
            path,
            f"{len(regions)} rows for the {len(clip)} frames of {found.name}",
            "every frame needs one row, NaN where nothing was found, and none may be "
            f"left; a longer film can be tracked with --to {last}",
        )
    return Track(regions, np.full(len(clip), np.nan), lost, {}), clip


def _refuse_other_columns(path: Path, head: str) -> None:
    """Refuse a head that is not ours, whatever separates its words.

    Swapped columns would give numbers that are wrong and look right.
    """
    said, wanted = (re.sub(r'[,;\s"]', "", text) for text in (head, "".join(COLUMNS)))
    if said != wanted:
        raise DataError(
            path,
            "its columns are not those of a table of `track`, or in another order",
            f"put them in this order, under this head: {','.join(COLUMNS)}",
            1,
        )


def _ours(path: Path, found: Found) -> tuple[Regions, NDArray]:
    """The regions (T, 5) and where they are lost (T,), in our own table."""
    rows, numbers = read_rows(path, (len(COLUMNS),), header=True)
    # Of MOT a part of the sequence is shown, which `track` counts in the whole.
    first = found.first if numbers[0, 0] else 0
    rows.refuse_misnumbered(numbers[:, 0], ",".join(COLUMNS), first)
    regions = _without_zeros(numbers[:, 1:6])
    regions[:, 2] = np.radians(regions[:, 2])
    refuse_no_region(rows, regions, NOTHING)
    return regions, (numbers[:, 7] > 0) | np.isnan(regions).any(1)


def _without_zeros(regions: Regions) -> Regions:
    """NaN for regions of zeros, with which many trackers say that nothing was found."""
    return np.where(regions[:, HX:].any(1, keepdims=True), regions, np.nan)


def _regions(path: Path, found: Found, clip: Sequence) -> Regions:
    """The regions in a text of the form that a benchmark's truth has."""
    if found.archive.regions is None:
        return _mot_regions(path, found, clip)
    commas = path.read_text("utf-8-sig", "replace").partition("\n")[0].count(",")
    if commas == 9:
        raise DataError(
            path,
            f"these are rows of MOT, which {found.name} is not",
            "give the .csv that stands beside it, or boxes as its own truth has them",
        )
    if commas == len(COLUMNS) - 1 and found.archive.name != "VOT":  # not four corners
        raise DataError(
            path,
            f"{len(COLUMNS)} numbers in a row, as `track` writes them, but no head",
            f"put it back as the first line: {','.join(COLUMNS)}",
        )
    rows, regions = found.archive.regions(path, clip)
    regions = _without_zeros(regions)
    refuse_no_region(rows, regions, NOTHING)
    return regions


def _mot_regions(path: Path, found: Found, clip: Sequence) -> Regions:
    rows, numbers = read_rows(path, (10, 9, 7))
    rows.refuse_nan(numbers[:, :6])  # a confidence may be unknown
    first = found.first
    length = len(ImageFolder(found.folder / "img1"))
    index = mot.frame_index(rows, numbers, length) - first
    boxes = mot.regions(numbers)
    begun = index == 0
    if not begun.any():
        raise DataError(
            path,
            f"no box in frame {first + mot.FIRST}, with which {found.name} begins",
            "give the rows of the whole sequence",
        )
    shared = overlap(boxes[begun], clip.truth[0], upright=True)
    nearest = np.argmax(np.nan_to_num(shared))  # NaN of a box without a size
    mine = numbers[:, 1] == numbers[begun][nearest, 1]
    remedy = "correct the row, or remove it where nothing was found"
    refuse_no_region(rows.of(mine), boxes[mine], remedy)
    inside = mine & (index >= 0) & (index < len(clip))
    regions = np.full((len(clip), 5), np.nan)
    regions[index[inside]] = boxes[inside]
    return regions
