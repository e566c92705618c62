"""A camera's pictures as a video file, which is then tracked in as any other, as often as one likes.

Used in notebook 03.
"""

from itertools import chain

import cv2

from mkt.recording import quiet, video
from mkt.video import FPS, DataError


def record(path, seconds, camera=0):
    """Write what a camera sees into a video file, and yield each picture (H, W, 3) uint8 RGB once it is written.

    path: ends as one of `mkt.recording.CODECS`; seconds: how long; camera: its number for OpenCV.
    Raises DataError when the kernel sees no such camera or its pictures stop, OSError when the file cannot be written.
    """
    with quiet():
        capture = cv2.VideoCapture(camera)
    try:
        first, fps = _read(capture, camera), capture.get(cv2.CAP_PROP_FPS)
        fps = fps if 1 <= fps <= 240 else FPS  # some cameras answer 0, some nonsense
        further = (_read(capture, camera) for _ in range(1, round(seconds * fps)))
        with video(path, first.shape[1::-1], fps) as writer:
            for picture in chain([first], further):
                writer.write(picture)
                yield cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
    finally:
        capture.release()


def _read(capture, camera):
    good, picture = capture.read() if capture.isOpened() else (False, None)
    if not good:
        raise DataError(f"webcam {camera}", "this kernel sees no camera, or its pictures stopped",
                        "plug one in, close other programs that use it, or choose a file; a kernel on another machine cannot see yours")
    return picture
