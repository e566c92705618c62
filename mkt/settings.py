"""What reproduces a track: `Settings`, kept as a small JSON file beside the video and the table that came out.

The video is known by its place and by its SHA-256, so that another one under the same name is noticed; the tracker by its name and all of its
numbers, so that a later default does not change an old run.

Explained in notebook 03.
"""

import hashlib
import json
import math
import platform
from dataclasses import asdict, dataclass, field, fields, replace
from importlib.metadata import version
from pathlib import Path

import numpy as np

from mkt import datasets
from mkt.files import whole
from mkt.regions import from_box, to_box
from mkt.trackers import catalogue
from mkt.video import IMAGES, DataError, existing_file

PACKAGES = ("mkt", "numpy", "scipy", "opencv-python-headless")


def versions():
    """{name: version} of what a track depends on besides its settings."""
    return {"python": platform.python_version()} | {name: version(name) for name in PACKAGES}


@dataclass(frozen=True)
class Settings:
    """All that a track follows from.

    video: path of a file, or of a folder of images; sha256: see `fingerprint`.
    box: x, y, w, h, angle: upper left corner and size [px] before the clockwise rotation about its centre [degrees].
    tracker: a name in `mkt.trackers.catalogue`; numbers: those of its fields that differ from the catalogue's, see `numbers_of`.
    seed: of the tracker's chance; versions: what it was run with, for comparison only.
    """

    video: str
    sha256: str
    box: tuple[float, ...]
    tracker: str = "guided"
    numbers: dict = field(default_factory=dict)
    seed: int = 0
    versions: dict = field(default_factory=versions)

    def configured(self):
        """The `mkt.tracking.Tracker`.  Raises KeyError and ValueError as `with_numbers` does."""
        return with_numbers(self.tracker, self.numbers)

    def sequence(self):
        """The video as a `Sequence`, its first true region (5,) [px, rad] the box.

        Raises DataError when the video cannot be read, ValueError when the box is not in it.
        """
        clip = datasets.video(self.video)
        truth = clip.truth.copy()
        truth[0] = region_of(self.box, clip.frames[0])
        return replace(clip, truth=truth)

    def save(self, path):
        """Write the settings as JSON, with the versions that have just been used.  Raises OSError."""
        with whole(path) as half:
            half.write_text(json.dumps(asdict(self) | {"versions": versions()}, indent=2) + "\n", encoding="utf-8")


def settled(video, box, tracker="guided", numbers=None, seed=0):
    """`Settings` with the fingerprint of the video, and with all numbers of the tracker spelt out.

    numbers: {name: value} of those that differ from the catalogue's.  Raises KeyError, ValueError or DataError naming what is wrong.
    """
    path = Path(video).expanduser().resolve()
    known = numbers_of(with_numbers(tracker, numbers or {}))
    return Settings(str(path), fingerprint(path), tuple(map(float, box)), tracker, known, seed)


def load(path, video=None):
    """The `Settings` in a file that `Settings.save` wrote.

    video: where the video is now, if not where it was; a path in the file is taken from the file's own folder when it is relative.
    Raises DataError when the file makes no sense, and when the video is gone or another one.
    """
    path = existing_file(path)
    found = _checked(path, _parsed(path))
    place = Path(video).expanduser() if video else path.parent / found.video
    if not place.exists():
        raise DataError(place, "the video is gone", f"if it has moved, say where it is now: python3 -m mkt track VIDEO --settings {path}")
    sha256 = fingerprint(place)
    if sha256 != found.sha256:
        raise DataError(place, f"not the video of {path.name}: its sha256 is {sha256[:12]}..., not {str(found.sha256)[:12]}...",
                        "take the very file that was tracked, or draw the box in this one")
    return replace(found, video=str(place.resolve()))


def _parsed(path):
    try:
        return json.loads(path.read_text("utf-8"))
    except json.JSONDecodeError as error:
        raise DataError(path, f"not JSON: {error.msg}", "let `python3 -m mkt track` write it again", error.lineno) from None
    except UnicodeDecodeError:
        raise DataError(path, "not text in UTF-8", "give the .json file that was written beside the video") from None


def _checked(path, values):
    """The Settings of a parsed file; raises DataError naming the entry that is missing or wrong."""
    wanted = {f.name for f in fields(Settings)}
    if not isinstance(values, dict) or set(values) != wanted:
        difference = sorted(wanted.symmetric_difference(values if isinstance(values, dict) else ()))
        raise DataError(path, f"these entries are missing or unknown: {', '.join(difference)}", "let `python3 -m mkt track` write it again")
    box, numbers = values["box"], values["numbers"]
    for name, good in (("box", isinstance(box, list) and len(box) == 5 and all(map(_finite, box))),
                       ("numbers", isinstance(numbers, dict) and all(map(_finite, numbers.values()))),
                       ("seed", type(values["seed"]) is int and values["seed"] >= 0), ("video", isinstance(values["video"], str))):
        if not good:
            raise DataError(path, f"{name} is {values[name]!r}, which it cannot be", "correct it, or let `python3 -m mkt track` write it again")
    return Settings(**values | {"box": tuple(box)})


def _finite(value):
    return type(value) in (int, float) and math.isfinite(value)


def fingerprint(path):
    """SHA-256 of a file, as sha256sum prints it; of a folder, that of its images' own, one after the other in the order of their names.

    Raises DataError when there is neither.
    """
    path = Path(path)
    if not path.is_dir():
        return _sha256(existing_file(path))
    images = sorted(file for file in path.iterdir() if file.suffix.lower() in IMAGES)
    return hashlib.sha256("".join(map(_sha256, images)).encode()).hexdigest()


def _sha256(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def drift(settings):
    """What is installed in another version than the settings were written with, in words; empty if all is the same."""
    here = versions()
    return ", ".join(f"{name} {was} is {here.get(name, 'missing')} here" for name, was in settings.versions.items() if here.get(name) != was)


def numbers_of(tracker):
    """{name: value} of the tracker's own fields that are int or float; ``n`` is the number of particles, also of a filter inside it."""
    inner = {"n": tracker.filter.n} if hasattr(tracker, "filter") else {}
    return inner | {f.name: getattr(tracker, f.name) for f in fields(tracker) if type(getattr(tracker, f.name)) in (int, float)}


def with_numbers(name, numbers):
    """The tracker of a name, with some of its numbers changed.

    Raises KeyError listing the trackers; ValueError for a number that it does not have, or that is none.
    """
    tracker = catalogue.get(name)
    if "n" in numbers:
        tracker = catalogue.with_particles(name, int(numbers["n"]))
    known = numbers_of(tracker)
    for field_name, value in numbers.items():
        if field_name not in known:
            raise ValueError(f"the tracker {name!r} has no number {field_name!r}; it has {', '.join(known) or 'none'}")
        if type(known[field_name]) is int and value != int(value):
            raise ValueError(f"{field_name} is {value:g}; it must be a whole number")
    return replace(tracker, **{key: type(known[key])(value) for key, value in numbers.items() if hasattr(tracker, key)})


def parse_box(text):
    """The five numbers x, y, w, h, angle of "x,y,w,h" or "x,y,w,h,angle".  Raises ValueError with the remedy."""
    try:
        box = [float(word) for word in text.split(",")]
    except ValueError:
        box = []
    if len(box) not in (4, 5) or not np.isfinite(box).all():
        raise ValueError(f"--box {text}: give four or five numbers x,y,w,h[,angle] without spaces, such as 120,80,60,40 or 120,80,60,40,30")
    return tuple(box) if len(box) == 5 else (*box, 0.0)


def region_of(box, frame):
    """The region (5,) [px, rad] of a box x, y, w, h, angle [px, degrees] in a frame (H, W, 3).

    Raises ValueError where the box has no size or lies outside the frame.
    """
    text = ",".join(f"{number:g}" for number in box)
    if min(box[2:4]) <= 0:
        raise ValueError(f"the box {text}: its width or height is zero or negative; give x,y,w,h, not two corners")
    region = from_box(box[:4], np.radians(box[4]))
    (x, y, w, h), (height, width) = to_box(region), frame.shape[:2]
    if x >= width or y >= height or x + w <= 0 or y + h <= 0:
        raise ValueError(f"the box {text}: it lies outside the image of {width}x{height} px; the upper left corner of the image is 0,0")
    return region
