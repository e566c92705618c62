"""Video files written by OpenCV, in formats that it reads again everywhere."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2

from mkt.types import Frame

CODECS = {".webm": "VP80", ".mkv": "FFV1", ".avi": "MJPG"}


class Writer:
    """A video file that is open for writing.

    Parameters
    ----------
    path : path
    opened : cv2.VideoWriter
    """

    def __init__(self, path: str | os.PathLike, opened: cv2.VideoWriter):
        self._path, self._opened, self._frames = path, opened, 0

    def write(self, picture: Frame) -> None:
        """Write the next picture (H, W, 3) uint8 BGR.  Raises OSError without room.

        That may come late: the encoder holds some pictures back.
        """
        if not self._opened.write(picture):
            raise OSError(
                f"{self._path}: frame {self._frames} could not be written; "
                "make room there, or choose another place"
            )
        self._frames += 1


@contextmanager
def video_writer(
    path: str | os.PathLike, size: tuple[int, int], fps: float
) -> Iterator[Writer]:
    """A new video, closed when the ``with`` ends.

    Parameters
    ----------
    path : path
        Ends as one of `CODECS`.
    size : (width, height) [px]
        Of the pictures; an odd width or height loses its last pixel.
    fps : float
        Pictures a second.

    Raises
    ------
    OSError
        When the file cannot be written.
    """
    codec = cv2.VideoWriter.fourcc(*CODECS[Path(path).suffix.lower()])
    with quiet():
        writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, codec, fps, size)
    if not writer.isOpened():
        raise OSError(
            f"{path}: cannot be written; is the folder writable, and is there room?"
        )
    try:
        yield Writer(path, writer)
    finally:
        writer.release()


@contextmanager
def quiet() -> Iterator[None]:
    """Nothing on stderr.

    FFmpeg's C code remarks there that it does not know OpenCV's tag of VP8, and writes
    it all the same; OpenCV, that it has found no camera.
    """
    kept = os.dup(2)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)
