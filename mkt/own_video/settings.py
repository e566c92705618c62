"""What reproduces a track: `Settings`, a small JSON file beside video and table.

The video is known by its place and by its SHA-256, so that another one under the same
name is noticed; the tracker by its name and its own numbers, so that another default
of them does not change an old run.  What is inside of it, such as the motion of its
filter, is known by the version of the library, which is written down too.

Explained in notebook 03.
"""

import hashlib
import json
import platform
import reprlib
import shlex
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, is_dataclass, replace
from importlib.metadata import version
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from mkt import tracking
from mkt.checks import are_finite, check_seed, is_number, is_whole
from mkt.files import DataError, existing_file, whole, written_path
from mkt.own_video.typed_box import region_of, with_angle
from mkt.sequences import truth_formats
from mkt.sequences.video import images_in
from mkt.trackers import by_name
from mkt.trackers.scaled import Scaled
from mkt.tracking import Tracker

PACKAGES = ("mkt", "numpy", "scipy", "opencv-python-headless")
# What of the video is looked at, where a file does not say.
WHOLE = {"first": 0, "last": None, "every": 1, "scale": 1.0}
AGAIN = "let `python3 -m mkt track` write it again"

Numbers = dict[str, float]


def versions() -> dict[str, str]:
    """What a track depends on besides its settings, {name: version}."""
    packages = {name: version(name) for name in PACKAGES}
    return {"python": platform.python_version()} | packages


@dataclass(frozen=True)
class Settings:
    """All that a track follows from; also the source of its sequence.

    Parameters
    ----------
    video : str
        Path of a file, or of a folder of images.
    sha256 : str
        See `fingerprint`.
    box : (x, y, w, h, angle)
        Upper left corner and size [px] before the clockwise rotation about its centre
        [deg].
    tracker : str
        A name in `mkt.trackers.by_name`.
    numbers : dict
        Those of its fields, see `numbers_of`.
    seed : int
        Of the tracker's random numbers.
    versions : dict
        What it was run with, for comparison only.
    first, last, every : int, int or None, int
        Which frames, counted from 0: those from the first to the last one, None for the
        last one of the video, and of these one in every so many.  The box is in the
        first.
    scale : float
        Of the frames that the tracker sees, see `mkt.trackers.scaled`.
    """

    video: str
    sha256: str
    box: tuple[float, ...]
    tracker: str = "guided"
    numbers: Numbers = field(default_factory=dict)
    seed: int = 0
    versions: dict[str, str] = field(default_factory=versions)
    first: int = 0
    last: int | None = None
    every: int = 1
    scale: float = 1.0

    @property
    def part(self) -> tuple[int, int]:
        """The number of the first frame, and the step from one to the next."""
        return self.first, self.every

    @property
    def name(self) -> str:
        """What tables call it: the name of the video."""
        return Path(self.video).name

    def identity(self) -> str:
        """What its frames and its start follow from, wherever the video lies."""
        return f"{self.sha256} {self.box} {self.part} {self.last} {self.scale}"

    def configured(self) -> Tracker:
        """The tracker.  Raises ValueError as `with_numbers` and `Scaled` do."""
        tracker = with_numbers(self.tracker, self.numbers)
        return tracker if self.scale == 1 else Scaled(tracker, self.scale)

    def sequence(self) -> tracking.Sequence:
        """The video as a `Sequence`, its first true region the box.

        Raises
        ------
        DataError
            When the video cannot be read.
        ValueError
            When the box is not in it, or it has no such frames.
        """
        clip = truth_formats.video(self.video)
        part = clip.part(chosen_frames(clip, self.first, self.last, self.every))
        truth = part.truth.copy()
        truth[0] = region_of(self.box, part.frames[0])
        return replace(part, truth=truth)

    def save(self, path: Path) -> None:
        """Write the settings as JSON, with the versions that have just been used.

        Raises
        ------
        OSError
        """
        values = asdict(self) | {"versions": versions()}
        with whole(path) as half:
            half.write_text(json.dumps(values, indent=2) + "\n", encoding="utf-8")


def chosen_frames(
    clip: tracking.Sequence, first: int, last: int | None, every: int
) -> slice:
    """Which frames of a video these are; see `Settings`.

    Raises
    ------
    ValueError
        Where the video has no such frames, or one alone of those that were chosen.
    """
    end = len(clip) if last is None else last + 1
    if not 0 <= first < end <= len(clip):
        asked = f"from {first} on" if last is None else f"{first} to {last}"
        raise ValueError(
            f"frames {asked}: {clip.name} has 0 to {len(clip) - 1}; "
            "choose the first one (--from) and the last one (--to) among these"
        )
    if first + every >= end > first + 1:
        raise ValueError(
            f"every {every}-th frame: of {first} to {end - 1} that is one alone; "
            "choose a smaller number (--every)"
        )
    return slice(first, end, every)


def settled(
    video: Path | str,
    box: Sequence[float],
    tracker: str = "guided",
    numbers: Mapping[str, float] | None = None,
    seed: int = 0,
    **part: Any,
) -> Settings:
    """Settings with the fingerprint of the video and all numbers of the tracker.

    Parameters
    ----------
    video, tracker, seed
        See `Settings`; first, last, every and scale too.
    box : (x, y, w, h) or (x, y, w, h, angle)
        The angle is 0 where there is none.
    numbers : dict, optional
        Those that differ from the tracker's own.

    Raises
    ------
    ValueError
        Naming what is wrong; DataError for the video.
    """
    check_seed(seed)
    region = with_angle(box)
    if not region:
        raise ValueError(
            f"box is {reprlib.repr(box)}; give four or five numbers: x, y, w, h, and "
            "the angle if it is turned"
        )
    given = {name: _own(value) for name, value in part.items()}
    for name, value in given.items():
        if name in _POSSIBLE and (wrong := _wrong(name, value, _POSSIBLE[name])):
            raise ValueError(wrong)
    path = written_path(video)
    known = numbers_of(with_numbers(tracker, numbers or {}))
    sha256 = fingerprint(path)  # it refuses what the next line cannot resolve
    seed = _own(seed)
    return Settings(str(path.resolve()), sha256, region, tracker, known, seed, **given)


def _own(value: Any) -> Any:
    """A number of numpy as Python's own, for it cannot be written as JSON."""
    return value.item() if isinstance(value, np.generic) else value


def load(path: Path, video: Path | str | None = None) -> Settings:
    """The settings in a file that `Settings.save` wrote.

    Parameters
    ----------
    path : Path
    video : Path, optional
        Where the video is now, if not where it was; a path in the file is taken from
        the file's own folder when it is relative.

    Raises
    ------
    DataError
        When the file makes no sense, and when the video is gone or another one.
    """
    path = existing_file(path)
    found = _checked(path, _parsed(path))
    place = written_path(video or path.parent / found.video)
    if not place.exists():
        raise DataError(
            place,
            "the video is gone",
            "if it has moved, say where it is now: "
            f"python3 -m mkt track VIDEO --settings {shlex.quote(str(path))}",
        )
    sha256 = fingerprint(place)
    if sha256 != found.sha256:
        raise DataError(
            place,
            f"not the video of {path.name}: its sha256 is {sha256[:12]}..., "
            f"not {found.sha256[:12]}...",
            "take the very file that was tracked, or draw the box in this one",
        )
    return replace(found, video=str(place.resolve()))


def _parsed(path: Path) -> Any:
    try:
        return json.loads(path.read_text("utf-8-sig"))
    except json.JSONDecodeError as error:
        raise DataError(path, f"not JSON: {error.msg}", AGAIN, error.lineno) from None
    except UnicodeDecodeError:
        raise DataError(
            path,
            "not text in UTF-8",
            "give the .json file that was written beside the video",
        ) from None
    except (ValueError, RecursionError):  # thousands of digits, or of brackets
        raise DataError(path, "a number or a list in it is too long", AGAIN) from None


def _checked(path: Path, values: Any) -> Settings:
    """The settings of a parsed file; DataError names what is missing or wrong."""
    wanted = {f.name for f in fields(Settings)}
    there = set(values) if isinstance(values, dict) else set()
    values = WHOLE | values if there else values
    if there | set(WHOLE) != wanted:
        names = ", ".join(sorted(wanted ^ (there | set(WHOLE))))
        raise DataError(path, f"these entries are missing or unknown: {names}", AGAIN)
    for name, value, possible in _parts(values):
        if wrong := _wrong(name, value, possible):
            raise DataError(path, wrong, f"correct it, or {AGAIN}")
    tracker = values["tracker"]
    if ":" in tracker and tracker not in by_name.TRACKERS:
        raise DataError(
            path,
            f"made with a tracker of your own, {tracker}, and a file may not choose "
            "which code runs",
            f"name it again: --tracker {tracker}",
        )
    settings = Settings(**values | {"box": tuple(values["box"])})
    try:
        settings.configured()
    except ValueError as error:
        raise DataError(path, str(error), f"correct it, or {AGAIN}") from error
    return settings


def _parts(values: dict[str, Any]) -> Iterator[tuple[str, Any, Callable]]:
    """Each entry, then each number and version, and whether they can be."""
    for name, possible in _POSSIBLE.items():
        yield name, values[name], possible
    for name, possible in _POSSIBLE_IN.items():
        for key, value in values[name].items():
            yield f"{key} in {name}", value, possible


def _wrong(name: str, value: Any, possible: Callable) -> str:
    """What is wrong with an entry, and what is needed; empty where it can be."""
    if possible(value):
        return ""
    return f"{name} is {reprlib.repr(value)}; it must be {_NEEDED[possible]}"


def _finite(value: Any) -> bool:
    return is_number(value, -sys.float_info.max)


def _is_box(value: Any) -> bool:
    return isinstance(value, list) and are_finite(value, 5)


def _is_dict(value: Any) -> bool:
    return isinstance(value, dict)


def _is_seed(value: Any) -> bool:
    return is_whole(value, 0)


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_step(value: Any) -> bool:
    return is_whole(value, 1)


def _is_share(value: Any) -> bool:
    return _finite(value) and 0 < value <= 1


def _is_end(value: Any) -> bool:
    return value is None or _is_seed(value)


def _is_name(value: Any) -> bool:
    return _is_text(value) and value != ""


_POSSIBLE = {
    "video": _is_name,
    "sha256": _is_text,
    "box": _is_box,
    "tracker": _is_text,
    "numbers": _is_dict,
    "seed": _is_seed,
    "versions": _is_dict,
    "first": _is_seed,
    "last": _is_end,
    "every": _is_step,
    "scale": _is_share,
}
_NEEDED = {
    _is_text: "a text",
    _is_name: "a text that is not empty",
    _is_box: "a list of five finite numbers: x, y, w, h, angle",
    _is_dict: "a table of names and values",
    _is_seed: "a whole number, at least 0",
    _is_end: "a whole number, at least 0, or nothing",
    _is_step: "a whole number, at least 1",
    _is_share: "above 0 and at most 1",
    _finite: "a finite number",
}
_POSSIBLE_IN = {"numbers": _finite, "versions": _is_text}


def fingerprint(path: Path | str) -> str:
    """SHA-256 of a file, as sha256sum prints it.

    Of a folder it is that of its images' own, one after the other, as they are shown.

    Raises
    ------
    DataError
        When there is neither.
    """
    path = Path(path)
    if not path.is_dir():
        return _sha256(existing_file(path))
    hashes = map(_sha256, images_in(path))
    return hashlib.sha256("".join(hashes).encode()).hexdigest()


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def changed_versions(settings: Settings) -> str:
    """What is installed in another version than the settings were written with.

    In words, empty if all is the same.
    """
    here = versions()
    return ", ".join(
        f"{name} {was} is {here.get(name, 'missing')} here"
        for name, was in settings.versions.items()
        if here.get(name) != was
    )


def numbers_of(tracker: Tracker) -> Numbers:
    """The tracker's own fields that are int or float, {name: value}.

    ``n`` is the number of particles, also of a filter inside it.  A class that is no
    dataclass has none that could be set.
    """
    if not is_dataclass(tracker):
        return {}
    own = {f.name: getattr(tracker, f.name) for f in fields(tracker)}
    numbers = {name: v for name, v in own.items() if type(v) in (int, float)}
    inner = {"n": tracker.filter.n} if hasattr(tracker, "filter") else {}
    return inner | numbers


def with_numbers(name: str, numbers: Mapping[str, float]) -> Tracker:
    """The tracker of a name, with some of its numbers changed.

    Raises
    ------
    ValueError
        For an unknown tracker, a number that it does not have, or a value that is no
        finite number.
    """
    tracker = by_name.TRACKERS[name]
    for field_name, value in numbers.items():
        if not (isinstance(value, Real) and abs(value) <= sys.float_info.max):
            raise ValueError(f"{field_name} is {value!r}; it must be a finite number")
    if "n" in numbers:
        tracker = by_name.with_particles(name, int(numbers["n"]))
    known = numbers_of(tracker)
    for field_name, value in numbers.items():
        _refuse_number(name, known, field_name, value)
    own = {key: v for key, v in numbers.items() if hasattr(tracker, key)}
    if not own:
        return tracker
    return replace(tracker, **{key: type(known[key])(v) for key, v in own.items()})


def _refuse_number(name: str, known: Numbers, field_name: str, value: float) -> None:
    if field_name not in known:
        raise ValueError(
            f"the tracker {name!r} has no number {field_name!r}; "
            f"it has {', '.join(known) or 'none'}"
        )
    if type(known[field_name]) is int and value != int(value):
        raise ValueError(f"{field_name} is {value:g}; it must be a whole number")
