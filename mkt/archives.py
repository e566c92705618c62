"""The public benchmarks: where each is expected under MKT_DATA, what is there, and whether it can be used.

None is needed and none comes along: their licences differ, and they are large.  `listing` is what ``python3 -m mkt data`` prints,
`check` opens every sequence and says what is wrong with it, `sequences` is what the leaderboard runs over.  The formats are those of
`mkt.datasets`.

Explained in notebook 14.
"""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import numpy as np

from mkt.datasets import bobot, data_root, mot_main, otb, vot
from mkt.evaluation import judged
from mkt.video import DataError


@dataclass(frozen=True)
class Archive:
    """A benchmark: its name, the pattern of its sequences' folders below MKT_DATA, their reader, how many there are, the licence, how to get it.

    layout: what a sequence's folder holds.
    """

    name: str
    pattern: str
    layout: str
    reader: Callable
    size: str
    licence: str
    get: str


ARCHIVES = (
    Archive("BoBoT", "bobot/*/", "one truth file .txt, and frames/ or one .avi", bobot, "12 sequences", "CC BY-SA 3.0 DE",
            "the Bonn Benchmark on Tracking, D. A. Klein, University of Bonn: www.iai.uni-bonn.de/~kleind/tracking"),
    Archive("OTB", "otb/*/", "img/ and groundtruth_rect.txt", otb, "100 targets", "none stated; for research",
            "the Visual Tracker Benchmark, Y. Wu, J. Lim, M.-H. Yang: cvlab.hanyang.ac.kr/tracker_benchmark"),
    Archive("VOT", "vot/*/", "groundtruth.txt, and the frames or color/ with them", vot, "60 sequences in 2018", "that of each sequence's source; for research",
            "the Visual Object Tracking challenge, votchallenge.net; its toolkit downloads a year's sequences with `vot initialize`"),
    Archive("MOT15", "mot15/train/*/", "img1/ and gt/gt.txt", mot_main, "11 sequences with truth", "CC BY-NC-SA 3.0",
            "the Multiple Object Tracking Benchmark: motchallenge.net/data/MOT15"),
)


@dataclass(frozen=True)
class Found:
    """A sequence's folder on disk and the `Archive` it belongs to."""

    archive: Archive
    folder: Path

    @property
    def name(self):
        """What it is called in tables, "BoBoT/..."."""
        return f"{self.archive.name}/{self.folder.name}"

    def read(self):
        """The `Sequence`.  Raises DataError."""
        return self.archive.reader(self.folder)

    def fingerprint(self):
        """A hash of its text files' contents and of all other files' names and sizes, wherever the folder lies."""
        digest = hashlib.sha256()
        for path in sorted(path for path in self.folder.rglob("*") if path.is_file()):
            content = path.read_bytes() if path.suffix == ".txt" else str(path.stat().st_size).encode()
            digest.update(f"{path.relative_to(self.folder).as_posix()}\n".encode() + content)
        return digest.hexdigest()[:16]


def sequences():
    """The sequences of all benchmarks that are there, usable or not: a list of `Found`.

    Raises DataError when MKT_DATA names no folder.
    """
    root = data_root()
    return [Found(archive, folder) for archive in ARCHIVES for folder in sorted(root.glob(archive.pattern))] if root else []


def check(found):
    """Open a sequence: its truth, the number of its frames, the first and the last of them.  Returns what it is, in words.

    Raises DataError that names the file, what is wrong and the remedy.
    """
    sequence = found.read()
    shape = sequence.frames[0].shape
    if sequence.frames[-1].shape != shape:
        raise DataError(found.folder, "the last frame is not of the first one's size", "download the sequence again")
    if not np.isfinite(sequence.truth[0]).all():
        raise DataError(found.folder, "the target is not visible in the first frame, where a tracker must learn it", "cut the sequence, or leave it out")
    if not judged(sequence).any():
        raise DataError(found.folder, "the target is visible in no further frame", "check that the truth belongs to these frames")
    hidden = int(np.sum(sequence.visibility == 0))
    return f"{len(sequence)} frames of {shape[1]}x{shape[0]}, hidden in {hidden}" + "; reconstructed frames" * ("reconstructed" in sequence.source)


def usable():
    """The sequences that pass `check`.  Returns {`Found`: what it is, in words} and a list of what is wrong with the others."""
    good, troubles = {}, []
    for found in sequences():
        try:
            good[found] = check(found)
        except DataError as error:
            troubles.append(str(error))
    return good, troubles


def listing():
    """The known benchmarks, where each is expected, what is there and how to get the rest, as text."""
    root, there = data_root(), sequences()
    lines = [f"MKT_DATA is {root}" if root else "MKT_DATA is not set: set it to a folder of benchmarks, laid out as below.  All of them are optional.", ""]
    for archive in ARCHIVES:
        names = [found.folder.name for found in there if found.archive is archive]
        lines += [f"{archive.name}: {f'{len(names)} found' if names else 'missing'}; the benchmark has {archive.size}",
                  f"  expected  {Path(root or 'MKT_DATA') / archive.pattern.replace('*', 'NAME')}/: {archive.layout}"]
        lines += [f"  there     {', '.join(names)}"] * bool(names)
        lines += [f"  licence   {archive.licence}", f"  get it    {archive.get}", ""]
    return "\n".join([*lines, "`python3 -m mkt data check` opens all that is there."])
