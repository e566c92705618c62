"""What moves before a camera that stands still.

It is the third way to start the tracker of [N03]: by a detector.

The paper used support vector machines that know faces.  Here OpenCV's background
subtraction says which pixels changed, and their connected components are the targets:
they need not be known beforehand.
"""

from collections.abc import Sequence
from itertools import chain, islice

import cv2
import numpy as np

from mkt.checks import checked_frame, of_frames
from mkt.regions import from_box
from mkt.types import Frame, Regions

LEARN = 0.02  # share by which a frame changes the background
FIRST = 8  # frames until what stands in the first one alone is background no more
# Joins the parts of one object, and removes the sensor's noise.
CLOSED = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (7, 7))
OPENED = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))


def moving(frames: Sequence[Frame], smallest: int = 100) -> Regions:
    """What moves in the last of some frames.

    What covers a pixel in more than five of them is background: an object is found
    whole where it moves by a fifth of its length or more from each frame to the next,
    and not at all at half as much, or less.  Of a slow one take every k-th frame.  Of
    two frames nothing says in which of its places it is, and both are found.

    Parameters
    ----------
    frames : sequence of (H, W, 3) uint8 RGB arrays
    smallest : int [px^2]
        Area below which a component is noise.

    Returns
    -------
    (K, 5) array [px, rad]
        Upright regions, the largest first.

    Raises
    ------
    ValueError
        For fewer than two frames, frames without a length, what is no frame, and frames
        of several sizes.
    """
    of_frames(frames)
    if len(frames) < 2:
        raise ValueError(f"{len(frames)} frames show no motion; give at least two")
    if others := {checked_frame(frame).shape for frame in frames} - {frames[0].shape}:
        raise ValueError(
            f"frames have the shapes {frames[0].shape} and {others.pop()}; give frames "
            "of one camera"
        )
    subtractor = cv2.createBackgroundSubtractorMOG2(detectShadows=False)
    # Or what stands in the first frame would be background, and its place found.
    first = np.median(list(islice(frames, FIRST)), axis=0).astype(np.uint8)
    for frame in chain([first], frames):
        mask = subtractor.apply(frame, learningRate=LEARN)
    clean = cv2.morphologyEx(mask, cv2.MORPH_OPEN, OPENED)
    joined = cv2.morphologyEx(clean, cv2.MORPH_CLOSE, CLOSED)
    _, _, stats, _ = cv2.connectedComponentsWithStats(joined)
    boxes = stats[1:][stats[1:, cv2.CC_STAT_AREA] >= smallest]
    largest = np.argsort(-boxes[:, cv2.CC_STAT_AREA], kind="stable")
    return from_box(boxes[largest, :4])
