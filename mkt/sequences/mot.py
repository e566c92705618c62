"""The Multiple Object Tracking benchmark (MOT): many targets in one truth.

Rows are `frame,id,left,top,width,height,confidence,class,visibility`, or ten columns
without a visibility.  Frames and pixels are counted from `FIRST`.
"""

import configparser
import operator
import os
from pathlib import Path

import numpy as np

from mkt.files import DataError, existing_folder
from mkt.regions import from_box
from mkt.sequences.rows import Rows, read_rows
from mkt.sequences.truth import refuse_untrue
from mkt.sequences.video import ImageFolder
from mkt.tracking import Sequence
from mkt.types import Array, NDArray, Regions

FIRST = 1  # the number of the first frame, the first row and the first column
_LARGEST_ID = 2.0**53  # beyond it not every whole number is a float


def mot(folder: str | os.PathLike, target: int) -> Sequence:
    """One target of a sequence of MOT.

    It is hidden in frames without a row; boxes of visibility 0 are kept as annotated.

    Parameters
    ----------
    folder : path
        Holds img1/ and gt/gt.txt, rows
        `frame,id,left,top,width,height,confidence,class,visibility` (or ten columns,
        without a visibility), frames and pixels counted from 1.
    target : int
        Its id.

    Raises
    ------
    TypeError
        If the target is no whole number.
    DataError
        Naming the file, the line and the remedy.
    """
    target = operator.index(target)
    rows, numbers = _read(folder)
    mine = numbers[:, 1] == target
    if not mine.any():
        known = ", ".join(f"{number:.15g}" for number in np.unique(numbers[:, 1])[:20])
        raise DataError(
            rows.path, f"no target has the id {target}", f"choose one of {known}"
        )
    frames = ImageFolder(Path(folder) / "img1")
    rows = rows.of(mine)
    numbers = numbers[mine]
    index = frame_index(rows, numbers, len(frames))
    truth = np.full((len(frames), 5), np.nan)
    truth[index] = regions(numbers)
    visibility = np.zeros(len(frames))
    visibility[index] = _visibility(rows, numbers)
    refuse_untrue(rows, truth[index], frames)
    name = f"{Path(folder).resolve().name}-{target}"
    fps = _frame_rate(Path(folder) / "seqinfo.ini", frames.fps)
    return Sequence(name, frames, truth, visibility, "MOT", upright=True, fps=fps)


def _frame_rate(path: Path, usual: float) -> float:
    """Frames a second, as a sequence says itself, or as usual where it does not."""
    said = configparser.ConfigParser()
    try:
        said.read(path, encoding="utf-8-sig")
        rate = said.getfloat("Sequence", "frameRate", fallback=usual)
    except (configparser.Error, ValueError):
        rate = 0.0
    if not 0 < rate < float("inf"):
        remedy = "write frameRate=25 under [Sequence], or take the file away"
        raise DataError(path, "no frame rate can be read", remedy)
    return rate


def mot_ids(folder: str | os.PathLike) -> list[int]:
    """The targets of a MOT sequence that are to be scored, the longest first.

    Parameters
    ----------
    folder : path
        As for `mot`.

    Raises
    ------
    DataError
        Naming the file, the line and the remedy.
    """
    rows, numbers = _read(folder)
    to_be_scored = numbers[:, 6] != 0  # the confidence, 0 for targets that are not
    ids, counts = np.unique(numbers[to_be_scored, 1], return_counts=True)
    if not ids.size:
        raise DataError(
            rows.path,
            "no target is to be scored",
            "download it again: each row's seventh number is 0",
        )
    return ids[np.argsort(-counts, kind="stable")].astype(int).tolist()


def mot_main(folder: str | os.PathLike) -> Sequence:
    """The target of a MOT sequence that has the most annotated frames; see `mot`."""
    return mot_part(folder, mot_ids(folder)[0])[0]


def mot_part(folder: str | os.PathLike, target: int) -> tuple[Sequence, int]:
    """One target of a MOT sequence, from the first frame that shows it to the last.

    Parameters
    ----------
    folder, target
        As for `mot`.

    Returns
    -------
    clip : Sequence
    first : int
        Its first frame in the whole sequence, counted from 0.

    Raises
    ------
    DataError
        Naming the file, the line and the remedy.
    """
    clip = mot(folder, target)
    seen = np.flatnonzero(clip.visibility > 0)
    if not seen.size:
        raise DataError(
            Path(folder) / "gt" / "gt.txt",
            f"the target {target} is never visible",
            "choose another one",
        )
    return clip.part(slice(seen[0], seen[-1] + 1)), int(seen[0])


def frame_index(rows: Rows, numbers: Array, length: int) -> NDArray:
    """The frame numbers of MOT's rows as indices.

    Parameters
    ----------
    rows : Rows
    numbers : (T, n) array
        Begin with frame and id; none of these is NaN.
    length : int
        How many frames the whole sequence has.

    Returns
    -------
    (T,) int array

    Raises
    ------
    DataError
        Naming the file, the line and the remedy.
    """
    frame = numbers[:, 0]
    last = length - 1 + FIRST
    wrong = (frame != np.round(frame)) | (frame < FIRST) | (frame > last)
    repeated = np.ones(len(numbers), bool)
    repeated[np.unique(numbers[:, :2], axis=0, return_index=True)[1]] = False
    remedy = "correct or remove the row, or add the missing frames"
    rows.refuse(wrong, f"the frame is not one of {FIRST} to {last}", remedy)
    rows.refuse(repeated, "a second row for the same frame and id", remedy)
    return frame.astype(int) - FIRST


def regions(numbers: Array) -> Regions:
    """The regions (T, 5) of MOT's rows (T, n), none of which is NaN."""
    return from_box(numbers[:, 2:6] - [FIRST, FIRST, 0, 0])


def _read(folder: str | os.PathLike) -> tuple[Rows, Array]:
    """The truth of a MOT sequence, all targets in it."""
    rows, numbers = read_rows(existing_folder(folder) / "gt" / "gt.txt", (9, 10))
    rows.refuse_nan(numbers)
    ids = numbers[:, 1]
    broken = (ids != np.round(ids)) | (np.abs(ids) > _LARGEST_ID)
    rows.refuse(broken, "the id is no whole number", "correct the row")
    return rows, numbers


def _visibility(rows: Rows, numbers: Array) -> Array:
    """The visible fraction in each row, 1 where the format has none: (T,)."""
    visibility = numbers[:, 8] if numbers.shape[1] == 9 else np.ones(len(numbers))
    rows.refuse(
        (visibility < 0) | (visibility > 1),
        "the visibility does not lie between 0 and 1",
        "correct the row",
    )
    return visibility
