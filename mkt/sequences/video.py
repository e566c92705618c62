"""Frames from video files and image folders, decoded when they are asked for.

A `Frames` is a series of (H, W, 3) uint8 RGB arrays: it has a length, an index, slices
and a loop, but only the last `KEPT` frames are ever in memory.  Several threads may
read it.  Going forward decodes each frame once; going back re-opens the file, which is
rare because of the cache.  Whatever cannot be used is refused with one `DataError` that
names the file, the line and the remedy.

Explained in notebook 03.
"""

import os
import shlex
import threading
from collections import OrderedDict
from collections.abc import Sequence as Series
from pathlib import Path
from typing import overload

import cv2
import numpy as np

from mkt.files import DataError, existing_file, existing_folder
from mkt.registry import natural
from mkt.types import Frame, NDArray

KEPT = 32  # frames: one slider's worth of scrubbing, 7 MB at 320x240
ROOM = 5e7  # bytes that they may take where frames are large, 8 of 1920x1080
FEWEST = 2
IMAGES = {".jpg", ".jpeg", ".png", ".bmp", ".webp"}
JPEG, SCAN, END = b"\xff\xd8", b"\xff\xda", b"\xff\xd9"  # no scan has END inside
FPS = 25.0  # of folders, and of files that do not say
# A decoder asked by two threads at once takes the process down.  The same thread may
# take the lock twice: a frame can be part of another series.
_DECODING = threading.RLock()
_GREY_VIDEO = {b"Y800", b"Y16 ", b"GREY"}
_TO_RGB = "convert it to 8-bit RGB, for example with: ffmpeg -i {} -pix_fmt {} {}"


class Frames(Series):
    """T frames (H, W, 3) uint8 RGB, read-only, decoded on demand.

    A slice is again a `Frames` and decodes nothing.  Subclasses give `_read`, which
    decodes one frame.

    Parameters
    ----------
    length : int
        Number of frames.

    Attributes
    ----------
    fps : float
        Frames a second.
    """

    fps = FPS

    def __init__(self, length: int):
        self._length = length
        self._cache: OrderedDict[int, Frame] = OrderedDict()

    def __len__(self) -> int:
        return self._length

    @overload
    def __getitem__(self, index: int) -> Frame: ...

    @overload
    def __getitem__(self, index: slice) -> "Frames": ...

    def __getitem__(self, index: int | slice) -> "Frame | Frames":
        # A range counts negative numbers from the end, and raises IndexError beyond it.
        chosen = range(len(self))[index]
        if isinstance(chosen, range):
            return _Part(self, chosen)
        with _DECODING:
            if chosen not in self._cache:
                self._keep(chosen, self._read(chosen))
            self._cache.move_to_end(chosen)
            return self._cache[chosen]

    def _keep(self, index: int, frame: Frame) -> None:
        frame.flags.writeable = False  # everybody who asks for it gets the same array
        self._cache[index] = frame
        while len(self._cache) > _room(frame):
            self._cache.popitem(last=False)

    def _read(self, index: int) -> NDArray:
        raise NotImplementedError


class _Part(Frames):
    """Some frames of another series, in the order of `indices`.

    The cache is that of the whole series.
    """

    def __init__(self, whole: Frames, indices: range):
        self._whole = whole
        self._indices = indices
        self.fps = whole.fps

    def __len__(self):
        return len(self._indices)

    def __getitem__(self, index):
        chosen = self._indices[index]
        if isinstance(chosen, range):
            return _Part(self._whole, chosen)
        return self._whole[chosen]


class VideoFile(Frames):
    """The frames of a video file, in any format that OpenCV's FFmpeg reads.

    Opening counts the frames by walking through them (0.1 s for 700 of 320x240),
    because the length in a file's header is often an estimate.  Alpha is dropped and
    more than 8 bits are rounded by FFmpeg.

    Parameters
    ----------
    path : path

    Attributes
    ----------
    fps : float
        What the file says, 25 when it says nothing.

    Raises
    ------
    DataError
        No such file, not a video, grey, or cut short.
    OSError
        Where it may not be read.
    """

    def __init__(self, path: str | os.PathLike):
        self.path = existing_file(path)
        if (
            self.path.suffix.lower() == ".txt"
        ):  # FFmpeg would make a film of its letters
            raise DataError(self.path, "a text, not a video", "give a video")
        self._open()
        self.fps = self._said(cv2.CAP_PROP_FPS) or FPS
        super().__init__(self._count())
        self._open()

    def __reduce__(self):
        # A decoder cannot be pickled; worker processes open their own.
        return VideoFile, (self.path,)

    def _open(self) -> None:
        self._capture = cv2.VideoCapture(str(self.path), cv2.CAP_FFMPEG)
        self._next = 0
        if not self._capture.isOpened():
            with self.path.open("rb"):  # raises what the system says, if it refuses
                pass
            raise DataError(
                self.path,
                "not a video, or cut short",
                "download it again, or convert it to mp4 or avi with ffmpeg",
            )
        pixels = int(self._capture.get(cv2.CAP_PROP_CODEC_PIXEL_FORMAT)) & 0xFFFFFFFF
        if pixels.to_bytes(4, "little") in _GREY_VIDEO:
            name = shlex.quote(self.path.name)
            remedy = _TO_RGB.format(name, "yuv420p", "colour.mp4")
            raise DataError(
                self.path,
                "a grey video, but colours are what we track by",
                f"{remedy} if grey is what you want",
            )

    def _said(self, what: int) -> float:
        """What the file's header says, 0 for nonsense."""
        value = self._capture.get(what)
        return value if np.isfinite(value) and value > 0 else 0

    def _count(self) -> int:
        said = int(self._said(cv2.CAP_PROP_FRAME_COUNT))
        length = 0
        while self._capture.grab():
            length += 1
        # Estimates from the duration are off by a frame or a few; a download that broke
        # off lacks more.
        if length == 0:
            raise DataError(
                self.path,
                "no frame of this video can be decoded",
                "convert it to mp4 or avi, or download it again",
            )
        if length < 0.95 * said - 1:
            raise DataError(
                self.path,
                f"the video is truncated: {length} of {said} frames can be decoded",
                "download it again, or keep the good part: "
                f"ffmpeg -i {shlex.quote(self.path.name)} -c:v ffv1 good.mkv",
            )
        return length

    def _read(self, index: int) -> NDArray:
        if index < self._next:
            self._open()
        # The cache would forget earlier ones at once; of large frames it holds fewer.
        kept = _room(next(iter(self._cache.values()))) if self._cache else KEPT
        while self._next < index:
            place = self._next
            self._advance()
            if index - place < kept:
                self._keep(place, self._decoded())
        self._advance()
        return self._decoded()

    def _decoded(self) -> NDArray:
        """The frame to which `_advance` went."""
        return cv2.cvtColor(self._capture.retrieve()[1], cv2.COLOR_BGR2RGB)

    def _advance(self) -> None:
        """Go one frame on, without decoding it."""
        if not self._capture.grab():
            raise DataError(
                self.path,
                f"frame {self._next} cannot be decoded any more",
                "do not change a video while it is open",
            )
        self._next += 1


class ImageFolder(Frames):
    """The images in a folder (jpg, png, bmp, webp) in the natural order of their names.

    2.png comes before 10.png.  Numbers that are missing are not noticed: 1.png, 2.png,
    5.png and 10.png are four frames, one after the other.

    Parameters
    ----------
    path : path
        Of the folder.

    Attributes
    ----------
    fps : float
        25.

    Raises
    ------
    DataError
        No such folder, no images in it; and when a frame is asked for that is broken,
        grey, 16-bit, transparent, or not of the first one's size.
    """

    def __init__(self, path: str | os.PathLike):
        self.path = existing_folder(path)
        self.files = images_in(self.path)
        if not self.files:
            raise DataError(
                self.path,
                "no images in this folder",
                f"put its frames there as {', '.join(sorted(IMAGES))}",
            )
        super().__init__(len(self.files))
        self._shape = read_image(self.files[0]).shape

    def _read(self, index: int) -> NDArray:
        frame = read_image(self.files[index])
        if frame.shape != self._shape:
            size, first = _size(frame.shape), _size(self._shape)
            raise DataError(
                self.files[index],
                f"{size} pixels, but the first frame has {first}",
                "resize it, or give it a folder of its own",
            )
        return frame


def read_image(path: str | os.PathLike) -> NDArray:
    """An image file as a frame, upright where the camera noted how it was held.

    Returns
    -------
    (H, W, 3) uint8 array, RGB

    Raises
    ------
    DataError
        No such file, not an image, grey, more than 8 bits, or an alpha channel.
    """
    path = existing_file(path)
    # Not imread, which cannot open every name on Windows.
    data = np.fromfile(path, np.uint8)
    image, notes = _stored(data) if data.size else (None, ())
    if image is None or _is_cut(data.tobytes()):
        raise DataError(
            path, "not an image, or cut short", "download it again, or remove it"
        )
    wrong = _unlike_rgb(image)
    if wrong:
        name = shlex.quote(path.name)
        raise DataError(path, wrong, _TO_RGB.format(name, "rgb24", "colour.png"))
    if cv2.IMAGE_METADATA_EXIF in notes:  # a camera may say that it was held upright
        return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR_RGB), np.uint8)
    return cv2.cvtColor(image, cv2.COLOR_BGR2RGB)


def _stored(data: NDArray) -> tuple[NDArray | None, Series[int]]:
    """An image as it is stored, None where it is none, and the kinds of its notes.

    Grey, 16 bits and alpha are left in it, and it is not turned.
    """
    try:
        image, notes, _ = cv2.imdecodeWithMetadata(data, cv2.IMREAD_UNCHANGED)
    except cv2.error:  # its head says more pixels than can be
        return None, ()
    return image, notes


def _is_cut(data: bytes) -> bool:
    """Whether a JPEG lacks its end, which decoders fill up without an error.

    The end is looked for behind the beginning of the picture itself: a thumbnail before
    it has an end of its own, and cameras write films behind it.
    """
    if not data.startswith(JPEG):
        return False
    at = len(JPEG)
    while at < len(data) and data[at : at + 2] != SCAN:
        fill = data[at + 1 : at + 2] == b"\xff"
        at += 1 if fill else 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    return END not in data[at:]


def _unlike_rgb(image: NDArray) -> str:
    """What is wrong with a decoded image, empty where nothing is."""
    if image.dtype != np.uint8:
        return f"{8 * image.itemsize} bits in each channel, 8 are needed"
    if image.ndim == 2 or image.shape[2] == 1:
        return "a grey image, but colours are what we track by"
    return "" if image.shape[2] == 3 else "it has an alpha channel"


def images_in(folder: Path) -> list[Path]:
    """The files of the images in a folder, in the natural order of their names.

    Hidden ones are none: beside 1.png a Mac puts ._1.png, in which there is no picture.
    """
    images = (
        file
        for file in folder.iterdir()
        if file.suffix.lower() in IMAGES and file.is_file() and file.name[0] != "."
    )
    return sorted(images, key=_natural)


def _room(frame: Frame) -> int:
    """How many frames of this size are kept."""
    return max(FEWEST, min(KEPT, int(ROOM / frame.nbytes)))


def _size(shape: tuple[int, ...]) -> str:
    return f"{shape[1]}x{shape[0]}"


def _natural(path: Path) -> list:
    """Sort key by which 2.png comes before 10.png."""
    return natural(path.name.lower())
