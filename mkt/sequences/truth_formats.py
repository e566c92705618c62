"""Readers that turn the field's ground-truth formats into one `Sequence`.

Each reader is: read the numbers, turn them into regions, check them against the frames.
Frames in which the target is hidden have NaN as their region and 0 as their visibility.
File names in a truth are ignored: it comes from strangers.

=======  ==============================================  =====================
reader   ground truth                                    pixel coordinates
=======  ==============================================  =====================
`bobot`  index, left, top, width, height;                fractions of the
         also left, top, right, bottom                   image; px
`otb`    left, top, width, height                        first pixel is 1
`vot`    four corners; also left, top, width, height     image corner is (0, 0)
`mot`    many targets, see `mkt.sequences.mot`           first pixel is 1
=======  ==============================================  =====================

`mkt.sequences.benchmarks` says where the data are found.

Explained in notebook 03.
"""

import os
import reprlib
from collections.abc import Sequence as Series
from pathlib import Path

import numpy as np

from mkt.files import DataError, existing_folder, written_path
from mkt.regions import from_box
from mkt.sequences.rows import Rows, read_rows
from mkt.sequences.truth import refuse_untrue, sequence
from mkt.sequences.video import Frames, ImageFolder, VideoFile
from mkt.tracking import Sequence
from mkt.types import Array, ArrayLike, Regions

Text = tuple[Rows, Regions]  # where each row stands, the regions (T, 5)
_ONE_BASED = np.array([1.0, 1.0, 0.0, 0.0])
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
    ValueError
        For what is no box.
    """
    if box is not None and np.shape(box) != (4,):
        raise ValueError(
            f"box is {reprlib.repr(box)}; give four numbers: left, top, width, height"
        )
    path = written_path(path)
    frames = ImageFolder(path) if path.is_dir() else VideoFile(path)
    truth = np.full((len(frames), 5), np.nan)
    visibility = np.full(len(frames), np.nan)
    if box is not None:
        truth[0] = from_box(box)
        visibility[0] = 1
        row = Rows("the box of the first frame", None)
        remedy = "give left, top, width, height inside the first frame"
        refuse_untrue(row, truth[:1], frames, hidden=False, remedy=remedy)
    if path.name in ("", ".."):  # a folder from where one stands
        path = path.resolve()
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
    rows, truth = bobot_regions(path, frames)
    if isinstance(frames, VideoFile) and len(frames) == len(truth) + 1:
        frames = frames[:-1]
    source = "BoBoT (CC BY-SA 3.0 DE)"
    if _reconstructed(folder):
        source += ", reconstructed frames"
    return sequence(folder, frames, rows, truth, source)


def bobot_regions(path: Path, frames: Series) -> Text:
    """The regions in a text as BoBoT writes them, see `bobot`."""
    rows, numbers = read_rows(path, (4, 5), header=True)
    return rows, from_box(_bobot_boxes(rows, numbers, frames))


def _bobot_frames(folder: Path) -> Frames:
    if (folder / "frames").is_dir():
        return ImageFolder(folder / "frames")
    videos = sorted(folder.glob("*.avi"))
    return VideoFile(_only(folder, videos, ".avi or folder frames/"))


def _reconstructed(folder: Path) -> bool:
    """Whether the file on the source of the frames says that they are reconstructed."""
    source = folder / "SOURCE.txt"
    return source.is_file() and "RECONSTRUCTED" in source.read_text("utf-8", "replace")


def _bobot_boxes(rows: Rows, numbers: Array, frames: Series) -> Array:
    """Left, top, width, height [px] from any kind of rows: (T, 4)."""
    height, width = frames[0].shape[:2]
    size = np.array([width, height, width, height])
    if numbers.shape[1] == 5:
        rows.refuse_misnumbered(numbers[:, 0], "index left top width height")
        rows.refuse_nan(numbers)
        boxes = numbers[:, 1:] * size
        boxes[~boxes.any(1)] = np.nan
        return boxes
    if rows.headed:
        return numbers * size if np.nanmax(numbers[:, 2:], initial=0) <= 1 else numbers
    return np.concatenate([numbers[:, :2], numbers[:, 2:] - numbers[:, :2]], 1)


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
    rows, truth = otb_regions(path)
    frames = ImageFolder(path.parent / "img")
    return sequence(folder, frames, rows, truth, "OTB")


def otb_regions(path: Path) -> Text:
    """The regions in a text as OTB writes them, see `otb`."""
    rows, boxes = read_rows(path, (4,))
    return rows, from_box(boxes - _ONE_BASED)


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
    rows, truth, rotated = vot_regions(path)
    color = folder / "color"
    frames = ImageFolder(color if color.is_dir() else folder)
    return sequence(folder, frames, rows, truth, "VOT", upright=not rotated)


def vot_regions(path: Path) -> tuple[Rows, Regions, bool]:
    """The regions in a text as VOT writes them, and whether they are rotated."""
    rows, numbers = read_rows(path, (4, 8))
    missing = np.isnan(numbers)
    rows.refuse(
        missing.any(1) & ~missing.all(1),
        "some of its numbers are NaN",
        "correct the row: a hidden target has NaN in all",
    )
    if numbers.shape[1] == 4:
        return rows, from_box(numbers), False
    return rows, _from_polygons(numbers.reshape(-1, 4, 2)), True


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
