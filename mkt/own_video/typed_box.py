"""The box that is drawn or typed round the target: x, y, w, h, angle [px, deg]."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from mkt import tracking
from mkt.regions import from_box, outside
from mkt.sequences.carphone import annotated, clip_path
from mkt.types import Frame, Region


def parse_box(text: str) -> tuple[float, ...]:
    """The five numbers x, y, w, h, angle of "x,y,w,h" or "x,y,w,h,angle".

    Raises
    ------
    ValueError
        With the remedy.
    """
    box = with_angle(text.split(","))
    if not box:
        raise ValueError(
            f"--box {text}: give four or five numbers x,y,w,h[,angle] without spaces, "
            "such as 120,80,60,40 or 120,80,60,40,30"
        )
    return box


def with_angle(box: Iterable[Any]) -> tuple[float, ...]:
    """The numbers x, y, w, h, angle of five, or of four; empty where these are none."""
    try:
        numbers = [float(number) for number in box]
    except (TypeError, ValueError, OverflowError):
        return ()
    fits = len(numbers) in (4, 5) and np.isfinite(numbers).all()
    return (*numbers, 0.0)[:5] if fits else ()


def in_words(box: Sequence[float]) -> str:
    """A box as it is typed: "120,80,60,40,30".

    Parameters
    ----------
    box : five numbers x, y, w, h, angle [px, deg]
    """
    return ",".join(f"{number:g}" for number in box)


def region_of(box: Sequence[float], frame: Frame) -> Region:
    """The region (5,) [px, rad] of a box x, y, w, h, angle [px, deg] in a frame.

    Raises
    ------
    ValueError
        Where the box is less than a pixel wide or high, or lies outside the frame.
    """
    text = in_words(box)
    if min(box[2:4]) <= 0:
        raise ValueError(
            f"the box {text}: its width or height is zero or negative; "
            "give x,y,w,h, not two corners"
        )
    if min(box[2:4]) < 1:
        raise ValueError(
            f"the box {text}: its width or height is less than a pixel; "
            "draw it round the target"
        )
    region = from_box(box[:4], np.radians(box[4]))
    height, width = frame.shape[:2]
    if outside(region, frame.shape):
        raise ValueError(
            f"the box {text}: it lies outside the image of {width}x{height} px; "
            "the upper left corner of the image is 0,0"
        )
    return region


def first_box(clip: tracking.Sequence) -> tuple[int, ...]:
    """A box to begin with, x, y, w, h, angle in whole pixels.

    In the clip of the book it is the head, upright; elsewhere it is no box, of size 0.
    """
    if clip.frames.path == clip_path():
        cx, cy, _, hx, hy = annotated(len(clip))[0]
        corner = cx - hx + 0.5, cy - hy + 0.5
        return tuple(round(number) for number in (*corner, 2 * hx, 2 * hy, 0))
    return (0, 0, 0, 0, 0)
