"""Video files written by OpenCV, in formats that it reads again everywhere."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2

CODECS = {".webm": "VP80", ".mkv": "FFV1", ".avi": "MJPG"}


@contextmanager
def video_writer(
    path: str | os.PathLike, size: tuple[int, int], fps: float
) -> Iterator[cv2.VideoWriter]:
    """A `cv2.VideoWriter`, closed when the ``with`` ends.

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
        yield writer
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
