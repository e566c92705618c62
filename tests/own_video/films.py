"""Small videos for the tests of this folder."""

import cv2
import numpy as np

from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene

SIZE = (160, 120)  # width, height [px]
LENGTH = 12
BOX = (55.0, 48.0, 50.0, 24.0, 0.0)


def driving(length, last=12.0, degrees=0.0):
    """The car on its way over gravel till frame `last`, turning by 6 degrees."""
    first, then = np.radians([degrees, degrees + 6])
    path = ((0.0, 80.0, 60.0, first, 1.0), (last, 95.0, 66.0, then, 1.0))
    return Scene(Layer("car", 50.0, path), "gravel", length, size=SIZE).sequence()


def write(path, frames):
    """Frames (H, W, 3) RGB as a video file, without loss where its ending allows it."""
    codec = cv2.VideoWriter.fourcc(*"FFV1")
    writer = cv2.VideoWriter(str(path), codec, 30, frames[0].shape[1::-1])
    for frame in frames:
        writer.write(frame[..., ::-1])
    writer.release()
    return path


def black():
    return np.zeros((48, 64, 3), np.uint8)
