"""Small videos, folders of images and truths, as benchmarks lay them out."""

import re
from contextlib import contextmanager

import cv2
import numpy as np
import pytest

from mkt.files import DataError

WIDTH, HEIGHT = 64, 48
# Left, top, width, height, the image corner being (0, 0); and the same as a region.
BOX = np.array([20.0, 8.0, 16.0, 24.0])
REGION = np.array([27.5, 19.5, 0.0, 8.0, 12.0])
ONE_BASED = BOX + [1, 1, 0, 0]  # the same where the first pixel is 1


@contextmanager
def refused(file, what, remedy, line=None):
    """Check for one DataError in which file, line, fault and remedy are all named."""
    with pytest.raises(DataError) as caught:
        yield
    message = str(caught.value)
    where = re.escape(str(file)) + (f", line {line}: " if line else ": ")
    assert re.fullmatch(f".*{where}.*{what}.*; .*{remedy}.*", message), message


def picture(k):
    """Frame k (HEIGHT, WIDTH, 3): red is its number, green grows to the right."""
    frame = np.full((HEIGHT, WIDTH, 3), (k, 0, 90), np.uint8)
    frame[..., 1] = np.arange(WIDTH)
    return frame


def noise(k):
    """Frame k of noise, which is hard to pack."""
    return np.random.default_rng(k).integers(0, 256, (HEIGHT, WIDTH, 3), np.uint8)


def write_video(path, n, pixels=picture, color=True):
    codec = cv2.VideoWriter.fourcc(*"FFV1")
    writer = cv2.VideoWriter(str(path), codec, 30, (WIDTH, HEIGHT), color)
    for k in range(n):
        writer.write(pixels(k)[..., ::-1] if color else pixels(k)[..., 0])
    writer.release()
    return path


def write_images(folder, n, name="{:04d}.png", first=1):
    folder.mkdir(parents=True, exist_ok=True)
    for k in range(n):
        cv2.imwrite(str(folder / name.format(k + first)), picture(k)[..., ::-1])
    return folder


def write_rows(path, *rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(rows) + "\n")
    return path


def numbers(values, separator=","):
    return separator.join(f"{value:g}" for value in np.ravel(values))


def otb_folder(folder, *rows, n=None):
    write_images(folder / "img", len(rows) if n is None else n)
    return write_rows(folder / "groundtruth_rect.txt", *rows).parent


def vot_folder(folder, *rows, frames="."):
    write_images(folder / frames, len(rows), "{:08d}.jpg")
    return write_rows(folder / "groundtruth.txt", *rows).parent


def mot_folder(folder, *rows, n=4):
    write_images(folder / "img1", n, "{:06d}.jpg")
    return write_rows(folder / "gt" / "gt.txt", *rows).parents[1]


def bobot_folder(folder, *rows, n=None, avi=False):
    n = len(rows) if n is None else n
    if avi:
        write_video(folder / "Vid_X.avi", n)
    else:
        write_images(folder / "frames", n, "img{:04d}.png", first=2)
    write_rows(folder / "SOURCE.txt", "where it comes from")
    return write_rows(folder / "Vid_X.txt", *rows).parent


def bobot_row(k, box=BOX):
    return f"{k} " + numbers(box / [WIDTH, HEIGHT, WIDTH, HEIGHT], " ")
