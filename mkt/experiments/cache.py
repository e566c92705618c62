"""What has been computed already, kept on disk.

These are runs, their numbers, chapters and pictures.

A `Shelf` keeps results of one kind under a `key` of all that they depend on.  Each is
written as a whole, and whatever cannot be read counts as missing, so that two programs
may use a shelf at once and an interrupted one leaves nothing half-done.

`code_of` says which code a result depends on: the files of the package that can be
reached from a tracker or a source by its imports.  Comments, docstrings and layout are
no part of it, nor are figures and pages, which trackers do not import.
"""

import ast
import functools
import hashlib
import importlib.metadata
import inspect
import io
import json
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

import mkt
from mkt.files import PACKAGE, ROOT, is_clone, named, whole

NUMERICAL = (
    "numpy",
    "scipy",
    "opencv-python-headless",
    "shapely",
    "scikit-image",
    "control",
)
SEAL = 16  # bytes
MOST = 2e9  # bytes of a shelf; beyond it, what is unused for longest is removed
PICKLES = (
    "O",
)  # kinds of arrays that are not kept, because reading them could run code


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


def key(*parts: Any) -> str:
    """A name for what depends on these parts and nothing else, by what they print."""
    return hashlib.sha256("\n".join(map(_printed, parts)).encode()).hexdigest()[:32]


def _printed(thing: Any) -> str:
    """What a thing prints, its arrays in full: in short two can look the same."""
    with np.printoptions(threshold=sys.maxsize, floatmode="unique"):
        return repr(thing)


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
        """Keep a result under a key.  Raises OSError, as on a full disk."""
        place = self.place(key)
        data = self._write(result)
        with named(place):
            place.parent.mkdir(parents=True, exist_ok=True)
        with whole(place) as half:
            half.write_bytes(_seal(key, data) + data)
        self._tidy(place.parent)

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
    wrong = [name for name, a in arrays.items() if np.asarray(a).dtype.kind in PICKLES]
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


def identity(source: Any) -> str:
    """What identifies a source: its own word for this, or what it prints."""
    return source.identity() if hasattr(source, "identity") else _printed(source)


def code_of(*things: Any) -> str | None:
    """A hash of the code that trackers, sources or modules can reach.

    Their parts are looked at too, see `homes`.  The versions of the packages that
    numbers depend on go into it.  Returns None if the code of one cannot be read, for
    example of a class that was written in a notebook, or if it has been written since
    this program began, which may run what was there before: its results cannot be kept.
    """
    files = homes(*things)
    if files is None or any(map(_rewritten, _reached(files))):
        return None
    return _hash(files)


def _rewritten(path: Path) -> bool:
    with suppress(OSError):
        return mkt.BEGUN < path.stat().st_mtime < time.time()
    return True  # it has been removed


def homes(*things: Any) -> tuple[Path, ...] | None:
    """The files of modules, and of the classes of trackers or sources.

    The parts that a tracker is made of, its bins or its motion, may be of classes that
    its own module does not import, so theirs count too.  Returns None if one has no
    file, or is a function, whose name says too little.
    """
    files: set[Path] = set()
    for thing in _parts(things):
        module = thing if inspect.ismodule(thing) else inspect.getmodule(type(thing))
        path = getattr(module, "__file__", None)
        if path is None:
            return None
        files.add(Path(path))
    return tuple(sorted(files))


def _parts(things: Iterable[Any]) -> Iterator[Any]:
    """Things, and what has code of its own within them, however deep."""
    for thing in things:
        yield thing
        for part in _parts(_inside(thing)):
            if is_dataclass(type(part)) or callable(part):
                yield part


def _inside(thing: Any) -> Iterable[Any]:
    """The fields of a dataclass, and what a tuple, a list or a dict holds.

    Nothing of a source that says itself what identifies it.
    """
    if hasattr(thing, "identity"):
        return ()
    if is_dataclass(type(thing)):
        return [getattr(thing, field.name) for field in fields(thing)]
    if isinstance(thing, dict):
        return thing.values()
    return thing if isinstance(thing, tuple | list) else ()


@functools.lru_cache(maxsize=256)
def _reached(files: tuple[Path, ...]) -> list[Path]:
    return reachable(files)


@functools.lru_cache(maxsize=256)
def _hash(files: tuple[Path, ...]) -> str:
    return hashlib.sha256("\n".join([*versions(), *_trees(files)]).encode()).hexdigest()


def state(files: Iterable[Path]) -> str:
    """A short hash of the code that files reach, whatever the versions of packages."""
    return hashlib.sha256("\n".join(_trees(files)).encode()).hexdigest()[:16]


def _trees(files: Iterable[Path]) -> list[str]:
    return [stripped(path) for path in reachable(files)]


def versions() -> list[str]:
    """Python and the packages that numbers depend on, each with its version."""
    packages = [f"{name} {importlib.metadata.version(name)}" for name in NUMERICAL]
    return [f"python {sys.version}", *packages]


@functools.lru_cache(maxsize=512)
def stripped(path: Path) -> str:
    """The code of a file without comments, docstrings and layout."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and body and _is_text(body[0]):
            body[0] = ast.Pass()
    return ast.dump(tree)


def _is_text(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def reachable(
    files: Iterable[Path], following: Callable[[Path], list[Path]] | None = None
) -> list[Path]:
    """The files that some files can reach by imports, themselves too.

    What follows from a file is what it has `imported`, unless told otherwise.  What a
    `mkt.registry.Registry` finds in a package is reached from where it is made.
    """
    found: set[Path] = set()
    waiting = list(files)
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += (following or imported)(path)
    return sorted(found)


@functools.lru_cache(maxsize=512)
def imported(path: Path) -> list[Path]:
    """The files of the package that a file imports, anywhere in it.

    For a file from elsewhere, which a user wrote, also the files beside it.
    """
    tree = ast.parse(path.read_text(encoding="utf-8"))
    files: list[Path] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Registry":
            packages = [ast.literal_eval(argument) for argument in node.args[1:2]]
            for package in packages:
                files += PACKAGE.parent.joinpath(*package.split(".")).rglob("*.py")
    for name in names_in(tree):
        files += files_of(name)
        if PACKAGE not in path.parents:
            files += _files_beside(path, name)
    return files


def names_in(code: ast.AST) -> Iterator[str]:
    """Dotted names that code imports, or takes from a module, each spelled out."""
    short: dict[str, str] = {}
    names: list[str] = []
    for node in ast.walk(code):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
            short |= {a.asname: a.name for a in node.names if a.asname}
        elif isinstance(node, ast.ImportFrom):
            module = f"{node.module}." if node.module else ""
            names += [f"{module}{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Attribute):
            names.append(_dotted(node))
    for name in names:
        first, dot, rest = name.partition(".")
        yield _spelled_out(f"{short.get(first, first)}{dot}{rest}")


def _dotted(node: ast.expr) -> str:
    """``a.b.c`` as text, "" for anything but names and dots."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        base = _dotted(node.value)
        return f"{base}.{node.attr}" if base else ""
    return ""


def _spelled_out(name: str) -> str:
    """A dotted name, with the module where mkt.SSD and its like really are."""
    package, _, rest = name.partition(".")
    public = rest.partition(".")[0]
    if package == "mkt" and public in mkt.NAMES:
        return f"{mkt.NAMES[public]}.{rest}"
    return name


def files_of(name: str) -> list[Path]:
    """The files that the import of a dotted name runs, of the package alone."""
    first, _, rest = name.partition(".")
    return _files_in(PACKAGE, rest) if first == "mkt" else []


def _files_beside(path: Path, name: str) -> list[Path]:
    """Those in the folder of a file, and in those of the packages that it is in."""
    folders = [path.parent]
    while (folders[-1] / "__init__.py").is_file():
        folders.append(folders[-1].parent)
    return [file for folder in folders for file in _files_in(folder, name)]


def _files_in(folder: Path, name: str) -> list[Path]:
    """The modules and packages of a folder that a dotted name leads through."""
    parts = name.split(".") if name else []
    places = [folder.joinpath(*parts[:k]) for k in range(1, len(parts) + 1)]
    both = [(place.with_suffix(".py"), place / "__init__.py") for place in places]
    return [file for pair in both for file in pair if file.is_file()]
