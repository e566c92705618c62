"""What has been computed already, kept on disk.

These are runs, their numbers, chapters and pictures.

A `Shelf` keeps results of one kind under a `key` of all that they depend on.  Each is
written as a whole, and whatever cannot be read counts as missing, so that two programs
may use a shelf at once and an interrupted one leaves nothing half-done.
"""

import hashlib
import io
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
from tqdm import tqdm

from mkt.files import ROOT, is_clone, whole

SEAL = 16  # bytes
MOST = 2e9  # bytes of a shelf; beyond it, what is unused for longest is removed
OBJECTS = "O"  # the kind of arrays that are not kept: reading them could run code
# What prints all that it is.
PLAIN = type(None), int, float, complex, str, bytes, np.generic, Path, Enum, range


def folder() -> Path:
    """Where everything is kept: MKT_CACHE, or ``.cache`` in the clone.

    For an installed library, or a clone that cannot be written, it is the user's own
    folder for such things.
    """
    if place := os.environ.get("MKT_CACHE"):
        return Path(place)
    if is_clone() and os.access(ROOT, os.W_OK):
        return ROOT / ".cache"
    return platformdirs.user_cache_path("mkt", appauthor=False)


def key(*parts: Any) -> str | None:
    """A name for what depends on these parts and nothing else.

    None where one of them cannot be spelled out, see `spelled`.
    """
    try:
        text = "\n".join(map(spelled, parts))
    except (TypeError, RecursionError):
        return None
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def spelled(thing: Any) -> str:
    """All that a thing consists of, as text: equal texts are equal things.

    What an object prints will not do: it may leave out fields, or give nothing but an
    address, which the next object may have.

    Raises
    ------
    TypeError
        For what keeps something that Python cannot see, and for functions.
    """
    if isinstance(thing, PLAIN):
        return repr(thing)
    if isinstance(thing, np.ndarray) and thing.dtype.kind != OBJECTS:
        # In full: in short two can look the same.
        with np.printoptions(threshold=sys.maxsize, floatmode="unique"):
            return repr(thing)
    kind = type(thing)
    more = _beside(thing)
    inside = f"{kind.__module__}.{kind.__qualname__}({_inside(thing)})"
    return inside + spelled(more) if more else inside


def _inside(thing: Any) -> str:
    """What an object is made of, spelled out.  Raises TypeError where that is hidden.

    A source that says itself what identifies it is taken at its word.
    """
    if hasattr(thing, "identity"):
        return _word_of(thing)
    if isinstance(thing, dict):
        return ", ".join(f"{spelled(k)}: {spelled(v)}" for k, v in thing.items())
    if isinstance(thing, set | frozenset):
        return ", ".join(sorted(map(spelled, thing)))
    if isinstance(thing, tuple | list):
        return ", ".join(map(spelled, thing))
    if isinstance(thing, partial):
        return spelled((thing.func, thing.args, thing.keywords))
    if is_dataclass(thing) and not isinstance(thing, type):
        return spelled({one.name: getattr(thing, one.name) for one in fields(thing)})
    return spelled(_state(thing))


def _word_of(thing: Any) -> str:
    """What a thing says itself that it is; ValueError for a mistake in that."""
    try:
        return thing.identity()
    except (TypeError, RecursionError) as error:
        raise ValueError(f"identity of {type(thing).__name__}: {error}") from error


def _beside(thing: Any) -> dict[str, Any]:
    """What a class that was made of a dataclass or a container keeps beside it.

    What was computed from fields and is remembered (`cached_property`) says nothing.
    """
    if hasattr(thing, "identity") or not (
        is_dataclass(thing) or isinstance(thing, dict | set | frozenset | tuple | list)
    ):
        return {}
    known = {one.name for one in fields(thing)} if is_dataclass(thing) else set()
    return {
        name: value
        for name, value in getattr(thing, "__dict__", {}).items()
        if name not in known
        if not isinstance(getattr(type(thing), name, None), cached_property)
    }


def _state(thing: Any) -> Any:
    """What an object of a class in Python keeps; TypeError for any other."""
    kind = type(thing)
    usual = kind.__reduce_ex__ is object.__reduce_ex__
    if not (usual and kind.__reduce__ is object.__reduce__):
        raise TypeError(f"{kind.__qualname__} has a state of its own kind")
    return thing.__reduce_ex__(2)[2]


class Shelf:
    """Results of one kind, a file for each.

    Parameters
    ----------
    name : str
        Of its folder below `folder`.
    ending : str
        Of its files.
    write : callable
        A result -> bytes.
    read : callable
        Bytes -> the result.  It is shown only what `write` has made.
    """

    def __init__(
        self,
        name: str,
        ending: str,
        write: Callable[[Any], bytes],
        read: Callable[[bytes], Any],
    ):
        self.name, self._ending = name, ending
        self._write, self._read = write, read
        self._tidied = False

    def place(self, key: str) -> Path:
        """The file of a key, whether it is there or not."""
        return folder() / self.name / f"{key}{self._ending}"

    def get(self, key: str) -> Any:
        """The result under a key, or None where there is none that can be read."""
        place = self.place(key)
        try:
            content = place.read_bytes()
        except OSError:
            return None
        with suppress(OSError):  # of another user's file
            os.utime(place)  # it has been used
        seal, data = content[:SEAL], content[SEAL:]
        return self._read(data) if seal == _seal(key, data) else None

    def put(self, key: str, result: Any) -> None:
        """Keep a result under a key.

        Where the folder cannot be written, or is full, a line says so once: who has a
        result can do without its being kept.
        """
        place = self.place(key)
        data = self._write(result)
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            with whole(place) as half:
                half.write_bytes(_seal(key, data) + data)
            self._tidy(place.parent)
        except OSError as error:
            _not_kept(folder(), _reason(error))

    def kept(self, key: str, make: Callable[[], Any]) -> Any:
        """The result under a key, made and kept where there is none."""
        result = self.get(key)
        if result is None:
            result = make()
            self.put(key, result)
        return result

    def _tidy(self, place: Path) -> None:
        """Once in a program, remove what has not been used for longest."""
        if self._tidied:
            return
        self._tidied = True
        files = sorted(_files(place))
        total = sum(size for _, size, _ in files)
        for used, size, path in files:
            if total <= MOST or used >= time.time() - 3600:
                return
            total -= size
            path.unlink(missing_ok=True)


@cache
def _not_kept(place: Path, why: str) -> None:
    """Say once in a program, and not among the signs of a bar, that nothing is kept."""
    line = (
        f"{place} cannot be written ({why}), so that what is computed now is computed "
        "again the next time; let MKT_CACHE name another folder"
    )
    tqdm.write(line, file=sys.stderr)


def _reason(error: OSError) -> str:
    """What the system said, without what `mkt.files.named` has told round it."""
    cause = error.__cause__ or error
    return getattr(cause, "strerror", None) or str(cause)


def _files(place: Path) -> Iterator[tuple[float, int, Path]]:
    """When each file of a folder was last used, and its size.

    Other programs may remove files meanwhile.
    """
    for path in place.glob("*"):
        with suppress(FileNotFoundError):
            found = path.stat()
            yield found.st_mtime, found.st_size, path


def _seal(key: str, data: bytes) -> bytes:
    """What is written before a result; for another or a damaged one it differs."""
    return hashlib.blake2b(key.encode() + data, digest_size=SEAL).digest()


def as_json(result: Any) -> bytes:
    """A result of numbers, words, lists and dicts as text."""
    return json.dumps(result).encode()


def arrays_as_bytes(arrays: dict[str, np.ndarray]) -> bytes:
    """Arrays by name as numpy's own file.  Raises ValueError for arrays of objects."""
    wrong = [name for name, a in arrays.items() if np.asarray(a).dtype.kind == OBJECTS]
    if wrong:
        raise ValueError(f"{wrong[0]} is an array of objects, which cannot be kept")
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def arrays_of(data: bytes) -> dict[str, np.ndarray]:
    """Arrays by name from the bytes of `arrays_as_bytes`; ValueError for others."""
    with np.load(io.BytesIO(data), allow_pickle=False) as file:
        arrays = dict(file)
    if not all(isinstance(array, np.ndarray) for array in arrays.values()):
        raise ValueError("not arrays")
    return arrays


def identity(source: Any) -> str | None:
    """What identifies a source: its own word for this, or all that it consists of.

    None where that cannot be spelled out.
    """
    if hasattr(source, "identity"):
        return _word_of(source)
    with suppress(TypeError, RecursionError):
        return spelled(source)
    return None
