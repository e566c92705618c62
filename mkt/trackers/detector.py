"""What moves before a camera that stands still: the third way to start the tracker of [N03], by a detector.

The paper used support vector machines that know faces.  Here OpenCV's background subtraction says which pixels changed, and their connected
components are the targets: they need not be known beforehand.
"""

import cv2
import numpy as np

from mkt.regions import from_box

LEARN = 0.02  # share by which a frame changes the background
CLOSED = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (7, 7))  # joins the parts of one object
OPENED = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))  # removes the sensor's noise


def moving(frames, smallest=100):
    """Regions (K, 5) [px] of what moves in the last of some frames (H, W, 3) uint8 RGB, the largest first.

    smallest: area [px^2] below which a component is noise.  Raises ValueError for fewer than two frames.
    """
    if len(frames) < 2:
        raise ValueError(f"{len(frames)} frames show no motion; give at least two")
    subtractor = cv2.createBackgroundSubtractorMOG2(detectShadows=False)
    for frame in frames:
        mask = subtractor.apply(frame, learningRate=LEARN)
    mask = cv2.morphologyEx(cv2.morphologyEx(mask, cv2.MORPH_OPEN, OPENED), cv2.MORPH_CLOSE, CLOSED)
    _, _, stats, _ = cv2.connectedComponentsWithStats(mask)
    boxes = stats[1:][stats[1:, cv2.CC_STAT_AREA] >= smallest]
    return from_box(boxes[np.argsort(-boxes[:, cv2.CC_STAT_AREA], kind="stable"), :4])
