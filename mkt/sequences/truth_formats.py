"""Readers that turn the field's ground-truth formats into one `Sequence`.

Each reader is: read the numbers, turn them into regions, check them against the frames.
Frames in which the target is hidden have NaN as their region and 0 as their visibility.
Ground truth comes from strangers: it is read as numbers and nothing else, and file
names written in it are ignored.  Whatever is wrong is a `DataError` that names the
file, the line and the remedy.

=======  ==============================================  =====================
reader   ground truth                                    pixel coordinates
=======  ==============================================  =====================
`bobot`  index, left, top, width, height;                fractions of the
         also left, top, right, bottom                   image; px
`otb`    left, top, width, height                        first pixel is 1
`vot`    four corners; also left, top, width, height     image corner is (0, 0)
`mot`    frame, id, left, top, width, height,            first pixel is 1
         confidence, class, visibility
=======  ==============================================  =====================

`mkt.sequences.benchmarks` says where the data are found.

Explained in notebook 03.
"""

import os
import re
from collections.abc import Sequence as Series
from dataclasses import replace
from pathlib import Path

import numpy as np

from mkt.checks import LONGEST
from mkt.files import DataError, existing_file, existing_folder, written_path
from mkt.regions import HX, HY, from_box, to_box
from mkt.sequences.video import Frames, ImageFolder, VideoFile
from mkt.tracking import Sequence
from mkt.types import Array, ArrayLike, NDArray, Regions

Text = tuple[NDArray, Regions]  # the line of each row (T,), the regions (T, 5)
_ONE_BASED = np.array([1.0, 1.0, 0.0, 0.0])
_LARGEST_ID = 2.0**53  # beyond it not every whole number is a float
_WRONG = "the box is wrong: "
_NO_TRUTH = ("source", "license", "readme")  # text files beside those with a truth


def video(path: str | os.PathLike, box: ArrayLike | None = None) -> Sequence:
    """A video file, or a folder of images, without ground truth.

    Parameters
    ----------
    path : path
    box : (4,) array_like [px], optional
        Left, top, width, height of the target in the first frame.  The truth is NaN
        elsewhere, the visibility too.

    Raises
    ------
    DataError
        As `VideoFile` and `ImageFolder` do, and for a box without size or outside the
        image.
    """
    path = written_path(path)
    frames = ImageFolder(path) if path.is_dir() else VideoFile(path)
    truth = np.full((len(frames), 5), np.nan)
    visibility = np.full(len(frames), np.nan)
    if box is not None:
        truth[0] = from_box(box)
        visibility[0] = 1
        _check("the box of the first frame", None, truth[:1], frames, hidden=False)
    return Sequence(
        path.stem, frames, truth, visibility, path.name, upright=True, fps=frames.fps
    )


def bobot(folder: str | os.PathLike) -> Sequence:
    """A sequence of BoBoT, the Bonn Benchmark on Tracking, or its relative BoBoT-D.

    Parameters
    ----------
    folder : path
        Holds one truth file .txt and the frames, either in frames/ or as one .avi.
        Rows are `index left top width height` in fractions of the image, all zero when
        hidden, under the video's name or no header; or four numbers, NaN when hidden:
        `left top width height` under a header, `left,top,right,bottom` [px] without
        one.  An .avi may have one frame more than rows.

    Raises
    ------
    DataError
        Naming the file, the line and the remedy.
    """
    folder = existing_folder(folder)
    path = _only(folder, _truth_files(folder), "truth file .txt")
    frames = _bobot_frames(folder)
    lines, regions = bobot_regions(path, frames)
    if isinstance(frames, VideoFile) and len(frames) == len(regions) + 1:
        frames = frames[:-1]
    source = "BoBoT (CC BY-SA 3.0 DE)"
    if _reconstructed(folder):
        source += ", reconstructed frames"
    return _sequence(folder, frames, regions, path, lines, source)


def bobot_regions(path: Path, frames: Series) -> Text:
    """Lines and regions of a text as BoBoT writes them, see `bobot`."""
    lines, rows, headed = _read(path, (4, 5), header=True)
    return lines, from_box(_bobot_boxes(path, lines, rows, frames, headed))


def _bobot_frames(folder: Path) -> Frames:
    if (folder / "frames").is_dir():
        return ImageFolder(folder / "frames")
    videos = sorted(folder.glob("*.avi"))
    return VideoFile(_only(folder, videos, ".avi or folder frames/"))


def _reconstructed(folder: Path) -> bool:
    """Whether the file on the source of the frames says that they are reconstructed."""
    source = folder / "SOURCE.txt"
    return source.is_file() and "RECONSTRUCTED" in source.read_text("utf-8", "replace")


def _bobot_boxes(
    path: Path, lines: NDArray, rows: Array, frames: Series, headed: bool
) -> Array:
    """Left, top, width, height [px] from any kind of rows: (T, 4)."""
    height, width = frames[0].shape[:2]
    size = np.array([width, height, width, height])
    if rows.shape[1] == 5:
        refuse_misnumbered(path, lines, rows[:, 0], "index left top width height")
        refuse_nan(path, lines, rows)
        boxes = rows[:, 1:] * size
        boxes[~boxes.any(1)] = np.nan
        return boxes
    if headed:
        return rows * size if np.nanmax(rows[:, 2:]) <= 1 else rows
    return np.concatenate([rows[:, :2], rows[:, 2:] - rows[:, :2]], 1)


def refuse_misnumbered(
    path: Path, lines: NDArray, index: Array, form: str, first: int = 0
) -> None:
    """Refuse the first row whose number (T,) is not one more than that before it.

    Parameters
    ----------
    path, lines
        See `read_numbers`.
    index : (T,) array
    form : str
        What a row looks like, in words.
    first : int
        The number of the first row.

    Raises
    ------
    DataError
        Naming the file, the line and the remedy.
    """
    wrong = np.flatnonzero(index != first + np.arange(len(index)))
    if wrong.size:
        raise DataError(
            path,
            f"the first column is {index[wrong[0]]:g}, "
            f"but must count the rows {first}, {first + 1}, {first + 2}, ...",
            f"put missing rows back and all in order, as `{form}`",
            int(lines[wrong[0]]),
        )


def otb(folder: str | os.PathLike) -> Sequence:
    """A sequence of the Object Tracking Benchmark (OTB, also TB-50 and TB-100).

    Parameters
    ----------
    folder : path
        Holds img/ and groundtruth_rect.txt, rows `left,top,width,height` [px] whose
        first pixel is 1, separated by commas, tabs or spaces, NaN when hidden.

    Raises
    ------
    DataError
        Naming the file, the line and the remedy.
    """
    path = existing_folder(folder) / "groundtruth_rect.txt"
    lines, regions = otb_regions(path)
    frames = ImageFolder(path.parent / "img")
    return _sequence(folder, frames, regions, path, lines, "OTB")


def otb_regions(path: Path) -> Text:
    """Lines and regions of a text as OTB writes them, see `otb`."""
    lines, boxes = read_numbers(path, (4,))
    return lines, from_box(boxes - _ONE_BASED)


def vot(folder: str | os.PathLike) -> Sequence:
    """A sequence of the Visual Object Tracking challenge (VOT).

    Parameters
    ----------
    folder : path
        Holds the frames, or color/ with them, and groundtruth.txt, rows of four corners
        `x1,y1,...,x4,y4` or `left,top,width,height` [px], NaN when hidden.  Corners
        become the rotated rectangle with the same centre and mean sides.

    Raises
    ------
    DataError
        Naming the file, the line and the remedy.
    """
    folder = existing_folder(folder)
    path = folder / "groundtruth.txt"
    lines, regions, rotated = vot_regions(path)
    color = folder / "color"
    frames = ImageFolder(color if color.is_dir() else folder)
    return _sequence(folder, frames, regions, path, lines, "VOT", upright=not rotated)


def vot_regions(path: Path) -> tuple[NDArray, Regions, bool]:
    """Lines and regions of a text as VOT writes them, and whether those are rotated."""
    lines, rows = read_numbers(path, (4, 8))
    missing = np.isnan(rows)
    _refuse(
        path,
        lines,
        missing.any(1) & ~missing.all(1),
        "some of its numbers are NaN",
        "correct the row: a hidden target has NaN in all",
    )
    if rows.shape[1] == 4:
        return lines, from_box(rows), False
    return lines, _from_polygons(rows.reshape(-1, 4, 2)), True


def _from_polygons(polygons: Array) -> Regions:
    """Rotated rectangles (T, 5) from corners (T, 4, 2).

    They may begin at any corner and turn either way.  A rectangle is itself again after
    a quarter turn: the first angle is taken nearest to 0, each further one nearest to
    the last.
    """
    a, b, c, d = np.moveaxis(polygons, 1, 0)
    along = (b - a + c - d) / 2
    across = (d - a + c - b) / 2
    angle = np.arctan2(along[:, 1], along[:, 0])
    known = ~np.isnan(polygons).any((1, 2))
    theta = angle.copy()
    theta[known] = np.unwrap(np.append(0, angle[known]), period=np.pi / 2)[1:]
    swap = np.round((theta - angle) / (np.pi / 2)) % 2 == 1
    sides = np.stack([np.hypot(*along.T), np.hypot(*across.T)], -1)
    sides[swap] = sides[swap, ::-1]
    centres = polygons.mean(1) - 0.5
    return np.concatenate([centres, theta[:, None], sides / 2], 1)


def mot(folder: str | os.PathLike, target: int) -> Sequence:
    """One target of a sequence of the Multiple Object Tracking benchmark (MOT).

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
    DataError
        Naming the file, the line and the remedy.
    """
    path, lines, rows = _mot_rows(folder)
    mine = rows[:, 1] == target
    if not mine.any():
        known = ", ".join(f"{number:g}" for number in np.unique(rows[:, 1])[:20])
        raise DataError(
            path, f"no target has the id {target}", f"choose one of {known}"
        )
    frames = ImageFolder(path.parents[1] / "img1")
    lines, rows = lines[mine], rows[mine]
    index = mot_index(path, lines, rows, len(frames))
    truth = np.full((len(frames), 5), np.nan)
    truth[index] = from_box(rows[:, 2:6] - _ONE_BASED)
    visibility = np.zeros(len(frames))
    visibility[index] = _mot_visibility(path, lines, rows)
    _check(path, lines, truth[index], frames)
    name = f"{Path(folder).resolve().name}-{target}"
    return Sequence(
        name, frames, truth, visibility, "MOT", upright=True, fps=frames.fps
    )


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
    path, _, rows = _mot_rows(folder)
    to_be_scored = rows[:, 6] != 0  # the confidence, 0 for targets that are not
    ids, counts = np.unique(rows[to_be_scored, 1], return_counts=True)
    if not ids.size:
        raise DataError(
            path,
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
    part = slice(seen[0], seen[-1] + 1)
    frames, truth, visibility = (
        whole[part] for whole in (clip.frames, clip.truth, clip.visibility)
    )
    clip = replace(clip, frames=frames, truth=truth, visibility=visibility)
    return clip, int(seen[0])


def _mot_rows(folder: str | os.PathLike) -> tuple[Path, NDArray, Array]:
    """The truth file of a MOT sequence, its lines and its rows."""
    path = existing_folder(folder) / "gt" / "gt.txt"
    lines, rows = read_numbers(path, (9, 10))
    refuse_nan(path, lines, rows)
    ids = rows[:, 1]
    broken = (ids != np.round(ids)) | (np.abs(ids) > _LARGEST_ID)
    _refuse(path, lines, broken, "the id is no whole number", "correct the row")
    return path, lines, rows


def mot_index(path: Path, lines: NDArray, rows: Array, length: int) -> NDArray:
    """Frame numbers of MOT, which count from 1, as indices.

    Parameters
    ----------
    path, lines, rows
        See `read_numbers`; rows begin with frame and id, and none is NaN.
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
    numbers = rows[:, 0]
    wrong = (numbers != np.round(numbers)) | (numbers < 1) | (numbers > length)
    repeated = np.ones(len(rows), bool)
    repeated[np.unique(rows[:, :2], axis=0, return_index=True)[1]] = False
    remedy = "correct or remove the row, or add the missing frames"
    _refuse(path, lines, wrong, f"the frame is not one of 1 to {length}", remedy)
    _refuse(path, lines, repeated, "a second row for the same frame and id", remedy)
    return numbers.astype(int) - 1


def _mot_visibility(path: Path, lines: NDArray, rows: Array) -> Array:
    """The visible fraction in each row, 1 where the format has none: (T,)."""
    visibility = rows[:, 8] if rows.shape[1] == 9 else np.ones(len(rows))
    _refuse(
        path,
        lines,
        (visibility < 0) | (visibility > 1),
        "the visibility does not lie between 0 and 1",
        "correct the row",
    )
    return visibility


def _truth_files(folder: Path) -> list[Path]:
    return sorted(
        file
        for file in folder.glob("*.txt")
        if file.is_file() and file.stem.lower() not in _NO_TRUTH
    )


def _only(folder: Path, found: list[Path], what: str) -> Path:
    """The one file that was found; anything but one is refused."""
    if len(found) != 1:
        names = ", ".join(file.name for file in found) or "none"
        raise DataError(
            folder,
            f"needs exactly one {what}, found {names}",
            "add the missing one, or move the others elsewhere",
        )
    return found[0]


def read_numbers(
    path: str | os.PathLike, widths: tuple[int, ...], header: bool = False
) -> tuple[NDArray, Array]:
    """All numbers of a text file.

    They are separated by commas, semicolons, tabs or spaces; blank lines do not count.

    Parameters
    ----------
    path : path
    widths : tuple of int
        How many numbers a row may have; all rows have the same.
    header : bool
        The first line may be words.

    Returns
    -------
    lines : (T,) int array
        The line of each row, counted from 1.
    rows : (T, n) array

    Raises
    ------
    DataError
        For a file that is missing, is no text, or holds no rows, and for the first row
        that is wrong.
    """
    return _read(path, widths, header)[:2]


def _read(
    path: str | os.PathLike, widths: tuple[int, ...], header: bool
) -> tuple[NDArray, Array, bool]:
    """What `read_numbers` returns, and whether the first line was words."""
    table = [
        (number, re.split(r"[,;\s]+", line.strip(" \t,;")))
        for number, line in enumerate(_lines(path), 1)
        if line.strip()
    ]
    headed = header and bool(table) and _number(table[0][1][0]) is None
    table = table[headed:]
    if not table:
        raise DataError(
            path,
            "no rows of numbers",
            "an empty or header-only file cannot be used: download or annotate it "
            "again",
        )
    first = len(table[0][1])
    width = first if first in widths else widths[0]
    rows = [_row(path, number, fields, width) for number, fields in table]
    return np.array([number for number, _ in table]), np.array(rows), headed


def _lines(path: str | os.PathLike) -> list[str]:
    """The lines of a text file.

    What is no text is refused, and so are lines with two signs between numbers.
    """
    text = existing_file(path).read_text("utf-8-sig", "replace")
    if "\0" in text:
        raise DataError(
            path,
            "no plain text: it holds bytes of zero, as UTF-16 does",
            "save it as UTF-8, or download it again",
        )
    lines = text.splitlines()
    for number, line in enumerate(lines, 1):
        if ";" in line.strip(";") and "," in line.strip(","):
            raise DataError(
                path,
                "both commas and semicolons",
                "separate numbers by one of them, and write 9.5, not 9,5",
                number,
            )
    return lines


def _row(
    path: str | os.PathLike, line: int, fields: list[str], width: int
) -> list[float]:
    """The numbers in the fields of a line."""
    if len(fields) != width:
        twice = len(fields) == 2 * width
        hint = ", and write 9.5, not 9,5" if twice else ""
        raise DataError(
            path,
            f"{len(fields)} numbers, but {width} are needed",
            f"correct the row{hint}",
            line,
        )
    values = []
    for field in fields:
        value = _number(field)
        if value is None or np.isinf(value):
            raise DataError(
                path, f"{field[:40]!r} is not a finite number", "correct the row", line
            )
        values.append(value)
    return values


def _number(field: str) -> float | None:
    try:
        return None if "_" in field else float(field)  # Python's own 1_000
    except ValueError:
        return None


def _refuse(
    path: str | os.PathLike,
    lines: NDArray | None,
    bad: ArrayLike,
    what: str,
    remedy: str,
) -> None:
    """Refuse the first of the bad rows (T,) bool, by its line where there are lines."""
    rows = np.flatnonzero(bad)
    if rows.size:
        line = None if lines is None else int(lines[rows[0]])
        raise DataError(path, what, remedy, line)


def refuse_nan(path: Path, lines: NDArray, rows: Array) -> None:
    """Refuse the first row with a NaN.

    Raises
    ------
    DataError
        Naming the file, the line and the remedy.
    """
    bad = np.isnan(rows).any(1)
    _refuse(path, lines, bad, "NaN is not allowed in this format", "correct the row")


def _sequence(
    folder: str | os.PathLike,
    frames: Frames,
    truth: Regions,
    path: Path,
    lines: NDArray,
    source: str,
    upright: bool = True,
) -> Sequence:
    """The sequence of a truth with one row for each frame."""
    if len(truth) != len(frames):
        raise DataError(
            path,
            f"{len(truth)} rows for {len(frames)} frames",
            "every frame needs one row: add or remove rows or frames",
            int(lines[-1]),
        )
    _check(path, lines, truth, frames)
    hidden = np.isnan(truth).any(1)
    truth[hidden] = np.nan  # the angle too, which boxes leave at 0
    visibility = np.ones(len(truth))
    visibility[hidden] = 0
    name = Path(folder).resolve().name
    return Sequence(name, frames, truth, visibility, source, upright, frames.fps)


def _check(
    path: str | os.PathLike,
    lines: NDArray | None,
    regions: Regions,
    frames: Frames,
    hidden: bool = True,
) -> None:
    """Refuse the first region that cannot be true.

    A row all of NaN is a hidden target, where `hidden` is allowed.
    """
    remedy = "correct the row, or check that the format is the right one"
    refuse_no_region(path, lines, regions, remedy, hidden)
    height, width = frames[0].shape[:2]
    x, y, w, h = to_box(regions).T
    outside = (x >= width) | (y >= height) | (x + w <= 0) | (y + h <= 0)
    what = f"{_WRONG}it lies outside the image of {width}x{height} px"
    _refuse(path, lines, outside, what, remedy)


def refuse_no_region(
    path: str | os.PathLike,
    lines: NDArray | None,
    regions: Regions,
    remedy: str,
    hidden: bool = True,
) -> None:
    """Refuse the first of the regions (T, 5) that has not a centre and a size.

    Parameters
    ----------
    path, lines
        See `read_numbers`; None where there are no lines.
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
        _refuse(path, lines, bad, _WRONG + what, remedy)
