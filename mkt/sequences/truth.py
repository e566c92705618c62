"""What a truth must be: regions with a size, in the image, one for each frame."""

import os
from pathlib import Path

import numpy as np

from mkt.checks import LONGEST
from mkt.files import DataError
from mkt.regions import HX, HY, outside
from mkt.sequences.rows import Rows
from mkt.sequences.video import Frames
from mkt.tracking import Sequence
from mkt.types import Regions

_WRONG = "the box is wrong: "


def sequence(
    folder: str | os.PathLike,
    frames: Frames,
    rows: Rows,
    truth: Regions,
    source: str,
    upright: bool = True,
) -> Sequence:
    """The sequence of a truth (T, 5) with one row for each frame.

    A row all of NaN is a hidden target.

    Raises
    ------
    DataError
        Naming the file, the line and the remedy.
    """
    if len(truth) != len(frames):
        raise DataError(
            rows.path,
            f"{len(truth)} rows for {len(frames)} frames",
            "every frame needs one row: add or remove rows or frames",
            None if rows.lines is None else int(rows.lines[-1]),
        )
    refuse_untrue(rows, truth, frames)
    hidden = np.isnan(truth).any(1)
    truth[hidden] = np.nan  # the angle too, which boxes leave at 0
    visibility = np.ones(len(truth))
    visibility[hidden] = 0
    name = Path(folder).resolve().name
    return Sequence(name, frames, truth, visibility, source, upright, frames.fps)


def refuse_untrue(
    rows: Rows,
    regions: Regions,
    frames: Frames,
    hidden: bool = True,
    remedy: str = "correct the row, or check that the format is the right one",
) -> None:
    """Refuse the first of the regions (T, 5) that cannot be true in these frames.

    A row all of NaN is a hidden target, where `hidden` is allowed.

    Raises
    ------
    DataError
        Naming the file, the line and the remedy.
    """
    refuse_no_region(rows, regions, remedy, hidden)
    height, width = frames[0].shape[:2]
    what = f"{_WRONG}it lies outside the image of {width}x{height} px"
    rows.refuse(outside(regions, (height, width)), what, remedy)


def refuse_no_region(
    rows: Rows, regions: Regions, remedy: str, hidden: bool = True
) -> None:
    """Refuse the first of the regions (T, 5) that has not a centre and a size.

    Parameters
    ----------
    rows : Rows
    regions : (T, 5) array
    remedy : str
        What to do about it.
    hidden : bool
        Whether one may be all of NaN.

    Raises
    ------
    DataError
        Naming the file, the line and the remedy.
    """
    part = np.isnan(regions).any(1)
    if hidden:
        part &= ~np.isnan(regions[:, [0, 1, HX, HY]]).all(1)
    faults = {
        "some of its numbers are NaN": part,
        "its width or height is zero or negative": (regions[:, [HX, HY]] <= 0).any(1),
        "it is larger than any image": (regions[:, [HX, HY]] > LONGEST).any(1),
    }
    for what, bad in faults.items():
        rows.refuse(bad, _WRONG + what, remedy)
