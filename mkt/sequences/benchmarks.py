"""The public benchmarks: where each is expected, what is there, what can be used.

None is needed, and none comes with the library: their licences differ, and they are
large.  `listing` is what ``python3 -m mkt data`` prints, `check` opens a sequence and
says what is wrong with it, `check_frames` looks at all of it, `sequences` is what the
leaderboard runs over.  The formats are those of `mkt.sequences.truth_formats` and
`mkt.sequences.mot`; the folders lie below the one that the environment variable
MKT_DATA names.

Explained in notebook 14.
"""

import hashlib
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from tqdm import tqdm

from mkt.evaluation import scored_frames
from mkt.files import DataError
from mkt.sequences.mot import mot_ids, mot_main, mot_part
from mkt.sequences.truth_formats import (
    Text,
    bobot,
    bobot_regions,
    otb,
    otb_regions,
    vot,
    vot_regions,
)
from mkt.tracking import Sequence

# Files of which a fingerprint takes the content: texts, and pictures that are not
# packed, so that all have one size.
WHOLE = {".txt", ".csv", ".json", ".ini", ".bmp"}


@dataclass(frozen=True)
class Archive:
    """A benchmark.

    Parameters
    ----------
    name : str
    pattern : str
        Of its sequences' folders below MKT_DATA.
    layout : str
        What a sequence's folder holds, in words.
    reader : callable
        folder -> `Sequence`.
    regions : callable or None
        (text, clip) -> the rows and the regions of a text in the form of its truth, for
        boxes that were found elsewhere; None for MOT, whose rows are of many targets.
    size : str
        How many sequences it has, in words.
    licence : str
    get : str
        How to get it.
    """

    name: str
    pattern: str
    layout: str
    reader: Callable[[Path], Sequence]
    regions: Callable[[Path, Sequence], Text] | None
    size: str
    licence: str
    get: str


# Functions with names, because an archive goes to other processes.
def _bobot_text(text: Path, clip: Sequence) -> Text:
    return bobot_regions(text, clip.frames)


def _otb_text(text: Path, _: Sequence) -> Text:
    return otb_regions(text)


def _vot_text(text: Path, _: Sequence) -> Text:
    return vot_regions(text)[:2]


ARCHIVES = (
    Archive(
        "BoBoT",
        "bobot/*/",
        "one truth file .txt, and frames/ or one .avi",
        bobot,
        _bobot_text,
        "12 sequences",
        "CC BY-SA 3.0 DE",
        "the Bonn Benchmark on Tracking, D. A. Klein, University of Bonn: "
        "www.iai.uni-bonn.de/~kleind/tracking",
    ),
    Archive(
        "OTB",
        "otb/*/",
        "img/ and groundtruth_rect.txt",
        otb,
        _otb_text,
        "100 targets",
        "none stated; for research",
        "the Visual Tracker Benchmark, Y. Wu, J. Lim, M.-H. Yang: "
        "cvlab.hanyang.ac.kr/tracker_benchmark",
    ),
    Archive(
        "VOT",
        "vot/*/",
        "groundtruth.txt, and the frames or color/ with them",
        vot,
        _vot_text,
        "60 sequences in 2018",
        "that of each sequence's source; for research",
        "the Visual Object Tracking challenge, votchallenge.net; "
        "its toolkit downloads a year's sequences with `vot initialize`",
    ),
    Archive(
        "MOT15",
        "mot15/train/*/",
        "img1/ and gt/gt.txt",
        mot_main,
        None,
        "11 sequences with truth",
        "CC BY-NC-SA 3.0",
        "the Multiple Object Tracking Benchmark: motchallenge.net/data/MOT15",
    ),
)


@dataclass(frozen=True)
class Found:
    """A sequence's folder on disk and the `Archive` it belongs to.

    Parameters
    ----------
    archive : Archive
    folder : path
    target : int, optional
        Of MOT: the id of the target, that with the most frames by default.
    """

    archive: Archive
    folder: Path
    target: int | None = None

    @property
    def name(self) -> str:
        """What it is called in tables, "BoBoT/..." or "MOT15/...:id"."""
        target = "" if self.target is None else f":{self.target}"
        return f"{self.archive.name}/{self.folder.name}{target}"

    def sequence(self) -> Sequence:
        """The `Sequence`.

        Raises
        ------
        DataError
            Naming the file, the line and the remedy.
        """
        if self.target is None:
            return self.archive.reader(self.folder)
        return mot_part(self.folder, self.target)[0]

    @property
    def first(self) -> int:
        """The first frame that is shown, in the whole sequence, counted from 0."""
        if self.archive.reader is not mot_main:
            return 0
        target = mot_ids(self.folder)[0] if self.target is None else self.target
        return mot_part(self.folder, target)[1]

    def identity(self) -> str:
        """Its name and fingerprint, the same wherever the folder lies."""
        return f"{self.name} {self.fingerprint()}"

    def fingerprint(self) -> str:
        """A hash of the files: of the content of `WHOLE`, of the size of all others.

        The names count too; the place of the folder does not.  To read all takes two
        to four times as long, in every `python3 -m mkt book`.
        """
        digest = hashlib.sha256()
        for path in sorted(path for path in self.folder.rglob("*") if path.is_file()):
            name = path.relative_to(self.folder).as_posix()
            whole = path.suffix.lower() in WHOLE
            content = path.read_bytes() if whole else b"%d" % path.stat().st_size
            digest.update(f"{name}\n".encode() + content)
        return digest.hexdigest()[:16]


def data_root() -> Path | None:
    """The folder of data sets, which the environment variable MKT_DATA names.

    Returns
    -------
    Path or None
        None when the variable is not set.

    Raises
    ------
    DataError
        When it is set, but is no folder.
    """
    root = os.environ.get("MKT_DATA")
    if not root:
        return None
    if not Path(root).is_dir():
        raise DataError(
            root,
            "MKT_DATA names a folder that does not exist",
            "set it to the folder that holds the benchmarks, or unset it: "
            "`python3 -m mkt data` then lists what is expected",
        )
    return Path(root)


def sequences() -> list[Found]:
    """The sequences of all benchmarks that are there, usable or not.

    Raises
    ------
    DataError
        When MKT_DATA names no folder.
    """
    root = data_root()
    if root is None:
        return []
    return [
        Found(archive, folder)
        for archive in ARCHIVES
        for folder in sorted(root.glob(archive.pattern))
    ]


def named(name: str) -> Found:
    """The sequence of a name such as ``BoBoT/Vid_A``, or ``PETS09-S2L1:9`` of MOT.

    The benchmark may be left out; behind the colon is the target's id.

    Raises
    ------
    ValueError
        For a name that is not there, or of several; DataError as `data_root` does.
    """
    name, _, target = name.partition(":")
    there = sequences()
    good = [one for one in there if name in (one.name, one.folder.name)]
    if len(good) > 1:
        names = " or ".join(one.name for one in good)
        raise ValueError(f"several sequences are called {name!r}; say {names}")
    if not good:
        names = ", ".join(one.name for one in there) or "none; set MKT_DATA"
        raise ValueError(f"no sequence {name!r}; there are {names}")
    [found] = good
    if found.archive.reader is not mot_main:
        if target:
            raise ValueError(f"{name}: only targets of MOT have an id")
        return found
    ids = mot_ids(found.folder)
    known = [str(number) for number in ids]
    if target and target not in known:
        raise ValueError(f"{name} has no target {target}; its ids: {', '.join(known)}")
    return replace(found, target=int(target or ids[0]))


def check(found: Found) -> str:
    """Open a sequence: its truth, the number of its frames, the first and the last one.

    Returns
    -------
    str
        What it is, in words.

    Raises
    ------
    DataError
        Naming the file, what is wrong and the remedy.
    """
    clip = found.sequence()
    shape = clip.frames[0].shape
    if clip.frames[-1].shape != shape:
        raise DataError(
            found.folder,
            "the last frame is not of the first one's size",
            "download the sequence again",
        )
    if not np.isfinite(clip.truth[0]).all():
        raise DataError(
            found.folder,
            "the target is not visible in the first frame, where a tracker must learn "
            "it",
            "cut the sequence, or leave it out",
        )
    if not scored_frames(clip).any():
        raise DataError(
            found.folder,
            "the target is visible in no further frame",
            "check that the truth belongs to these frames",
        )
    hidden = np.sum(clip.visibility == 0)
    words = f"{len(clip)} frames of {shape[1]}x{shape[0]}, hidden in {hidden}"
    if "reconstructed" in clip.source:
        words += "; reconstructed frames"
    return words


def check_frames(found: Found) -> str:
    """`check`, and decode every frame, with a progress bar."""
    words = check(found)
    frames = found.sequence().frames
    for _ in tqdm(frames, desc=found.name, unit="frame", leave=False, disable=None):
        pass
    return words


def usable(
    chosen: Iterable[Found] = (), look: Callable[[Found], str] = check
) -> tuple[dict[Found, str], list[str]]:
    """The sequences that pass a check, of those that are chosen or of all.

    Parameters
    ----------
    chosen : iterable of Found
        All that are there where there are none.
    look : callable
        `check`, or `check_frames`, which takes a minute for 50,000 small frames.

    Returns
    -------
    good : dict
        `Found` -> what it is, in words.
    troubles : list of str
        What is wrong with the others.
    """
    good: dict[Found, str] = {}
    troubles: list[str] = []
    for found in list(chosen) or sequences():
        try:
            good[found] = look(found)
        except (DataError, OSError) as error:
            troubles.append(str(error))
    return good, troubles


def listing() -> str:
    """The benchmarks, where each is expected, what is there and how to get the rest."""
    root = data_root()
    there = sequences()
    first = f"MKT_DATA is {root}"
    if root is None:
        first = (
            "MKT_DATA is not set: set it to a folder of benchmarks, laid out as below."
            "  All of them are optional."
        )
    lines = [first, ""]
    for archive in ARCHIVES:
        names = [found.folder.name for found in there if found.archive is archive]
        lines += [*_about(archive, root, names), ""]
    return "\n".join([*lines, "`python3 -m mkt data check` opens all that is there."])


def _about(archive: Archive, root: Path | None, names: list[str]) -> list[str]:
    """The lines of `listing` for one benchmark, of which these sequences are there."""
    number = f"{len(names)} found" if names else "missing"
    folder = Path(root or "MKT_DATA") / archive.pattern.replace("*", "NAME")
    lines = [
        f"{archive.name}: {number}; the benchmark has {archive.size}",
        f"  expected  {folder}/: {archive.layout}",
    ]
    if names:
        lines.append(f"  there     {', '.join(names)}")
    return [*lines, f"  licence   {archive.licence}", f"  get it    {archive.get}"]
