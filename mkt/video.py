"""Frames from video files and image folders, decoded when they are asked for.

A `Frames` is a series of (H, W, 3) uint8 RGB arrays: it has a length, an index, slices and a loop, but only the last `KEPT` frames
are ever in memory.  Several threads may read it.  Going forward decodes each frame once; going back re-opens the file, which is rare because of the cache.
Whatever cannot be used is refused with one `DataError` that names the file, the line and the remedy.

Explained in notebook 03.
"""

import re
import threading
from collections import OrderedDict
from collections.abc import Sequence as Series
from pathlib import Path

import cv2
import numpy as np

KEPT = 32  # frames: one slider's worth of scrubbing, 7 MB at 320x240
IMAGES = {".jpg", ".jpeg", ".png", ".bmp", ".webp"}
FPS = 25.0  # of folders, and of files that do not say
_DECODING = threading.RLock()  # a decoder asked by two threads at once takes the process down; a frame can be part of another series
_GREY_VIDEO = {b"Y800", b"Y16 ", b"GREY"}
_TO_RGB = "convert it to 8-bit RGB, for example with: ffmpeg -i {} -pix_fmt {} {}"


class DataError(ValueError):
    """Input that cannot be used, told as "<file>, line <n>: <what is wrong>; <remedy>"."""

    def __init__(self, path, what, remedy, line=None):
        super().__init__(path, what, remedy, line)  # all four, so that the error survives the way back from a worker process

    def __str__(self):
        path, what, remedy, line = self.args
        return f"{path}{'' if line is None else f', line {line}'}: {what}; {remedy}"

    def _render_traceback_(self):
        """What a notebook shows: the message alone, for the mistake is in the data and not in the code."""
        return [f"DataError: {self}"]


def existing_file(path):
    """The path as a `Path`; raises DataError when no such file exists."""
    path = Path(path).expanduser()
    if not path.is_file():
        raise DataError(path, "no such file", "check the spelling, or give the full path")
    return path


def existing_folder(path):
    """The path as a `Path`; raises DataError when no such folder exists."""
    path = Path(path).expanduser()
    if not path.is_dir():
        raise DataError(path, "no such folder", "check the spelling, or give the full path")
    return path


class Frames(Series):
    """T frames (H, W, 3) uint8 RGB, read-only, decoded on demand.

    A slice is again a `Frames` and decodes nothing.  Subclasses give `_read`, which decodes one frame.
    """

    fps = FPS

    def __init__(self, length):
        self._length, self._cache = length, OrderedDict()

    def __len__(self):
        return self._length

    def __getitem__(self, index):
        if isinstance(index, slice):
            return _Part(self, range(len(self))[index])
        index = range(len(self))[index]  # counts negative ones from the end, raises IndexError beyond it
        with _DECODING:
            if index not in self._cache:
                self._keep(index, self._read(index))
            self._cache.move_to_end(index)
            return self._cache[index]

    def _keep(self, index, frame):
        frame.flags.writeable = False  # everybody who asks for it gets the same array
        self._cache[index] = frame
        if len(self._cache) > KEPT:
            self._cache.popitem(last=False)

    def _read(self, index):
        raise NotImplementedError


class _Part(Frames):
    """Some frames of another series, in the order of `indices`; the cache is that of the whole."""

    def __init__(self, whole, indices):
        self._whole, self._indices, self.fps = whole, indices, whole.fps

    def __len__(self):
        return len(self._indices)

    def __getitem__(self, index):
        chosen = self._indices[index]
        return _Part(self._whole, chosen) if isinstance(index, slice) else self._whole[chosen]


class VideoFile(Frames):
    """The frames of a video file, in any format that OpenCV's FFmpeg reads.

    path: the file.  ``fps`` is what the file says, 25 when it says nothing.  Opening counts the frames by walking through them
    (0.1 s for 700 of 320x240), because the length in a file's header is often an estimate.
    Raises DataError: no such file, not a video, grey, or cut short.  Alpha is dropped and more than 8 bits are rounded by FFmpeg.
    """

    def __init__(self, path):
        self.path = existing_file(path)
        self._open()
        self.fps = self._said(cv2.CAP_PROP_FPS) or FPS
        super().__init__(self._count())
        self._open()

    def __reduce__(self):
        return VideoFile, (self.path,)  # a decoder cannot be pickled; worker processes open their own

    def _open(self):
        self._capture, self._next = cv2.VideoCapture(str(self.path), cv2.CAP_FFMPEG), 0
        if not self._capture.isOpened():
            raise DataError(self.path, "not a video, or cut short", "download it again, or convert it to mp4 or avi with ffmpeg")
        pixels = int(self._capture.get(cv2.CAP_PROP_CODEC_PIXEL_FORMAT)) & 0xFFFFFFFF
        if pixels.to_bytes(4, "little") in _GREY_VIDEO:
            raise DataError(self.path, "a grey video, but colours are what we track by",
                            _TO_RGB.format(self.path.name, "yuv420p", "colour.mp4") + " if grey is what you want")

    def _said(self, what):
        value = self._capture.get(what)
        return value if np.isfinite(value) and value > 0 else 0

    def _count(self):
        length, said = 0, int(self._said(cv2.CAP_PROP_FRAME_COUNT))
        while self._capture.grab():
            length += 1
        # Estimates from the duration are off by a frame or a few; a download that broke off lacks more.
        if length == 0 or length < 0.95 * said - 1:
            raise DataError(self.path, f"the video is truncated: {length} of {said} frames can be decoded",
                            f"download it again, or keep the good part: ffmpeg -i {self.path.name} -c:v ffv1 good.mkv")
        return length

    def _read(self, index):
        if index < self._next:
            self._open()
        while self._next < index:
            self._advance(decode=index - self._next < KEPT)  # earlier ones would be forgotten again at once
        return self._advance()

    def _advance(self, decode=True):
        if not self._capture.grab():
            raise DataError(self.path, f"frame {self._next} cannot be decoded any more", "do not change a video while it is open")
        index, self._next = self._next, self._next + 1
        if decode:
            frame = cv2.cvtColor(self._capture.retrieve()[1], cv2.COLOR_BGR2RGB)
            self._keep(index, frame)
            return frame


class ImageFolder(Frames):
    """The images in a folder (jpg, png, bmp, webp) in natural order of their names: 2.png comes before 10.png.

    path: the folder.  ``fps`` is 25.  Raises DataError: no such folder, no images in it; and when a frame is asked for that is
    broken, grey, 16-bit, transparent, or not of the first one's size.
    """

    def __init__(self, path):
        self.path = existing_folder(path)
        self.files = sorted((f for f in self.path.iterdir() if f.suffix.lower() in IMAGES and f.is_file()), key=_natural)
        if not self.files:
            raise DataError(self.path, "no images in this folder", f"put its frames there as {', '.join(sorted(IMAGES))}")
        super().__init__(len(self.files))
        self._shape = read_image(self.files[0]).shape

    def _read(self, index):
        frame = read_image(self.files[index])
        if frame.shape != self._shape:
            raise DataError(self.files[index], f"{_size(frame.shape)} pixels, but the first frame has {_size(self._shape)}",
                            "resize it, or give it a folder of its own")
        return frame


def read_image(path):
    """An image file as (H, W, 3) uint8 RGB.

    Raises DataError: no such file, not an image, grey, more than 8 bits, or an alpha channel.
    """
    path = existing_file(path)
    data = np.fromfile(path, np.uint8)  # not imread, which cannot open every name on Windows
    image = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if data.size else None
    if image is None:
        raise DataError(path, "not an image, or cut short", "download it again, or remove it")
    wrong = _unlike_rgb(image)
    if wrong:
        raise DataError(path, wrong, _TO_RGB.format(path.name, "rgb24", "colour.png"))
    return cv2.cvtColor(image, cv2.COLOR_BGR2RGB)


def _unlike_rgb(image):
    if image.dtype != np.uint8:
        return f"{8 * image.itemsize} bits a channel, 8 are needed"
    if image.ndim == 2 or image.shape[2] == 1:
        return "a grey image, but colours are what we track by"
    return "" if image.shape[2] == 3 else "it has an alpha channel"


def _size(shape):
    return f"{shape[1]}x{shape[0]}"


def _natural(path):
    return [(0, int(part), "") if part.isdecimal() else (1, 0, part.lower()) for part in re.split(r"(\d+)", path.name)]
