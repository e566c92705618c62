"""Video files written by OpenCV, in formats that it reads again everywhere.

What a picture of 1920x1080 costs the writer, in ms of CPU on the machine on which this
was measured: .webm 133, .avi 21, .mp4 15.  Browsers play only .webm.  The file that a
killed program leaves can be played, except for the last pictures.
"""

import os
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np

from mkt.checks import is_number
from mkt.sequences.quiet import quiet
from mkt.types import Frame

CODECS = {".webm": "VP80", ".mkv": "FFV1", ".avi": "MJPG", ".mp4": "mp4v"}
# [px]: the longest side that these formats can say; the others take what can be read.
LONGEST_SIDE = {".webm": 16_383, ".mp4": 8_191}
# [px]: less cannot be read again, and in .avi may end the program; the others take 2.
SHORTEST_SIDE = {".webm": 4, ".avi": 8}
# Pictures a second: what is slower cannot be read again, what is faster not be written;
# the others take 0.01 to 30,000.
SLOWEST, FASTEST = {".webm": 0.06}, {".avi": 1_000}


class Writer:
    """A video file that is open for writing.

    A second thread packs one picture while the next one is made.

    Parameters
    ----------
    path : path
    size : (width, height) [px]
    opened : cv2.VideoWriter
    """

    def __init__(
        self, path: str | os.PathLike, size: tuple[int, int], opened: cv2.VideoWriter
    ):
        self._path, self._opened, self._frames = path, opened, 0
        self._shape = (size[1], size[0], 3)
        self._thread = ThreadPoolExecutor(1)
        self._under_way: Future[bool] | None = None

    def write(self, picture: Frame) -> None:
        """Write the next picture (H, W, 3) uint8 BGR, which must not change any more.

        Raises ValueError for any other picture, and OSError when the disk is full.
        That may come late: the thread has one picture under way, and the encoder holds
        some back.
        """
        if picture.shape != self._shape or picture.dtype != np.uint8:
            raise ValueError(
                f"{self._path}: a picture is {picture.shape} {picture.dtype}, and the "
                f"film takes {self._shape} uint8; convert it first"
            )
        self.settle()
        self._under_way = self._thread.submit(self._opened.write, picture)

    def settle(self) -> None:
        """Wait until all pictures were handed on.  Raises OSError on a full disk."""
        under_way, self._under_way = self._under_way, None
        if under_way is None:
            return
        if not under_way.result():
            raise OSError(
                f"{self._path}: frame {self._frames} could not be written; "
                "make room there, or choose another place"
            )
        self._frames += 1

    def close(self) -> None:
        """End the thread, then the file."""
        self._thread.shutdown()
        self._opened.release()


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
        When the file cannot be written, its ending is another one, or the pictures are
        too large or too small, too fast or too slow for its format.
    """
    path = Path(path).absolute()  # FFmpeg takes what is before a colon for a protocol
    ending = path.suffix.lower()
    if ending not in CODECS:
        raise OSError(f"{path}: cannot be written; choose one of {', '.join(CODECS)}")
    _refuse_size(path, size)
    _refuse_rate(path, fps)
    codec = cv2.VideoWriter.fourcc(*CODECS[ending])
    with quiet(), _in_pieces(path) as name:
        writer = cv2.VideoWriter(str(name), cv2.CAP_FFMPEG, codec, fps, size)
    if not writer.isOpened():
        raise OSError(
            f"{path}: cannot be written; is the folder writable, and is there room?"
        )
    opened = Writer(path, size, writer)
    try:
        yield opened
        opened.settle()
    finally:
        opened.close()


def _refuse_size(path: Path, size: tuple[int, int]) -> None:
    ending = path.suffix.lower()
    shortest = SHORTEST_SIDE.get(ending, 2)
    if min(size) < shortest:
        other = "; choose .mp4 or .mkv" if min(size) >= 2 else ""
        raise OSError(
            f"{path}: cannot be written: the pictures are {size[0]}x{size[1]} px, and "
            f"{ending} needs {shortest} px a side{other}"
        )
    longest = LONGEST_SIDE.get(ending)
    if longest and max(size) > longest:
        raise OSError(
            f"{path}: cannot be written: {ending} takes pictures of up to "
            f"{longest} px a side, and these are {size[0]}x{size[1]} px; "
            "choose .avi or .mkv"
        )


def rates(path: Path) -> tuple[float, float]:
    """The slowest and the fastest pictures a second that a film can have."""
    ending = path.suffix.lower()
    return SLOWEST.get(ending, 0.01), FASTEST.get(ending, 30_000)


def _refuse_rate(path: Path, fps: float) -> None:
    least, most = rates(path)
    if not (is_number(fps, least) and fps <= most):
        raise OSError(
            f"{path}: cannot be written with {fps} pictures a second; "
            f"for {path.suffix.lower()} choose from {least} to {most}"
        )


@contextmanager
def _in_pieces(path: Path) -> Iterator[Path]:
    """The name under which FFmpeg opens a file that can be read without its end.

    FFmpeg chooses the container by the name, and puts the index of an .mp4 last.  An
    .ismv is the same container in pieces, each with its index; once it is open it gets
    the name that was asked for.  Windows cannot rename an open file.
    """
    if path.suffix.lower() != ".mp4" or os.name == "nt":
        yield path
        return
    pieces = path.with_name(f".{path.stem}-{os.getpid()}.ismv")
    try:
        yield pieces
    except BaseException:  # such as Ctrl-C
        pieces.unlink(missing_ok=True)
        raise
    if pieces.exists():
        pieces.replace(path)
