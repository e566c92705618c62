"""A camera's pictures as a video file, which is then tracked in as any other.

Used in notebook 03.
"""

from collections.abc import Generator
from itertools import chain
from pathlib import Path

import cv2

from mkt.files import DataError
from mkt.sequences.quiet import quiet
from mkt.sequences.video import FPS
from mkt.sequences.writing import video_writer
from mkt.types import Frame

SLOWEST, FASTEST = 1, 240  # frames a second, between which a camera is believed
REMEDY = (
    "plug one in, close other programs that use it, or choose a file; "
    "a kernel on another machine cannot see yours"
)


def record(path: Path, seconds: float, camera: int = 0) -> Generator[Frame]:
    """Write what a camera sees into a video file, and yield each picture once written.

    Parameters
    ----------
    path : Path
        Ends as one of `mkt.sequences.writing.CODECS`; a file that is there is replaced.
    seconds : float
        How long.
    camera : int
        Its number for OpenCV.

    Yields
    ------
    (H, W, 3) uint8 array, RGB

    Raises
    ------
    DataError
        When the kernel sees no such camera, or its pictures stop; the file keeps those
        that came.
    OSError
        When the file cannot be written.
    """
    with quiet():
        capture = cv2.VideoCapture(camera)
    try:
        first = _read(capture)
        fps = capture.get(cv2.CAP_PROP_FPS)
        if first is None:
            what = "this kernel sees no camera, or it gives no picture"
            raise DataError(f"webcam {camera}", what, REMEDY)
        if not SLOWEST <= fps <= FASTEST:  # some cameras answer 0, some nonsense
            fps = FPS
        length = max(1, round(seconds * fps))
        pictures = chain([first], (_read(capture) for _ in range(1, length)))
        with video_writer(path, first.shape[1::-1], fps) as writer:
            for done, picture in enumerate(pictures):
                if picture is None:
                    what = f"its pictures stopped; {path} has {done} of {length}"
                    raise DataError(f"webcam {camera}", what, REMEDY)
                writer.write(picture)
                yield cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
    finally:
        capture.release()


def _read(capture: cv2.VideoCapture) -> Frame | None:
    """The camera's next picture (H, W, 3) uint8 BGR; None if there is none."""
    good, picture = capture.read() if capture.isOpened() else (False, None)
    return picture if good else None
