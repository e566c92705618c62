"""The command line of ``python3 -m mkt``: which commands there are, and one door out.

Reading order: `parser`, `parse`, `run`, `door`.
"""

import argparse
import os
import platform
import re
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any, NoReturn

from mkt import __version__
from mkt.course import environment
from mkt.course.commands import (
    bench,
    book,
    claims,
    data,
    doctor,
    figure,
    lab,
    labs,
    slides,
    test,
    track,
)
from mkt.files import PACKAGE, DataError, is_clone

# In the order in which --help names them.
COMMANDS = (book, test, lab, figure, claims, track, bench, data, doctor, labs, slides)
# One process, and frames of any size; the others have a process for each processor, or
# arrays so small that a second thread only waits, at the cost of a third of the CPU.
THREADED = ("track", "lab")
ONE_THREAD = (
    "OPENCV_FOR_THREADS_NUM",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "OMP_NUM_THREADS",
)
HANDING_ON = ("test", "lab")  # their unknown words go to pytest and to JupyterLab
TOO_LARGE = (
    "there is not enough memory for this; choose smaller numbers, or close other "
    "programs"
)
FAULT = (
    "a fault of mkt itself ({}).  Please send {} to those who look after it; "
    "SECURITY.md says where"
)
NO_CLONE = (
    "this needs notebooks and tests, which only a clone of the repository has: clone "
    "it, and run `python3 -m mkt {}` there"
)
MISSING = (
    "the package {} is missing, for this library was installed without all of its "
    "extras; in the clone, python -m pip install '.[notebooks,book,test]' brings them"
)
NOTE = (
    "The first command sets up .venv from environment.txt (a minute or two; with uv "
    "installed, seconds)."
)


def parser() -> argparse.ArgumentParser:
    """The parser of all commands."""
    top = argparse.ArgumentParser(
        prog="python3 -m mkt",
        epilog=NOTE,
        description="Multiple kernel tracking: the library, its book and its tests.",
    )
    top.add_argument("--version", action="version", version=f"mkt {__version__}")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for module in COMMANDS:
        module.add(commands)
    return top


def parse(words: Sequence[str]) -> argparse.Namespace:
    """Parse command-line words.

    Exits with a message when they make no sense, or after --help.
    """
    top = parser()
    if not words:
        top.print_help()
        sys.exit(2)
    args, args_rest = top.parse_known_args(_joined(words))
    if "names" in args and not any(word.startswith("-") for word in args_rest):
        # argparse takes names behind an option for strange words.
        args.names, args_rest = [*args.names, *args_rest], []
    if args_rest and args.command not in HANDING_ON:
        args.error(f"unrecognized arguments: {' '.join(args_rest)}")
    wrong = args.check(args) if "check" in args else None
    if wrong:
        args.error(wrong)
    args.rest = args_rest
    return args


def _joined(words: Sequence[str]) -> list[str]:
    """The words, "--box -5,30,40,40" as one: a minus makes an option to argparse."""
    joined: list[str] = []
    for word in words:
        option = bool(joined) and re.fullmatch(r"--[^=]+", joined[-1])
        if option and re.match(r"-[\d.]", word):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def run(args: argparse.Namespace) -> int | None:
    """Run a parsed command; returns the exit code, None for 0."""
    with door(args.command):
        if args.clone and not is_clone():
            raise ValueError(NO_CLONE.format(args.command))
        if args.command not in THREADED:
            _use_one_thread()
        return args.run(args)


def _use_one_thread() -> None:
    """In all programs that a command starts; OpenCV and numpy are not loaded yet."""
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")


@contextmanager
def door(command: str) -> Iterator[None]:
    """The way out for every error: the program ends with one sentence.

    Input that cannot be used is a ValueError or an OSError, whose message says what to
    do; a light install lacks packages that some commands need; a tracker of the user's
    own may fail.  Any other is a fault of ours.
    """
    try:
        yield
    except BrokenPipeError:  # a reader who has read enough, see mkt/__main__.py
        raise
    except (ValueError, OSError) as error:
        said = _slip_in_own_tracker(error) or _named_file(error)
        _leave(command, error, said)
    except MemoryError as error:
        _leave(command, error, TOO_LARGE)
    except Exception as error:
        said = _without_extras(error) or _in_own_tracker(error) or _fault(error)
        _leave(command, error, said)


def _leave(command: str, error: BaseException, said: Any) -> NoReturn:
    """End the program with a sentence, and with what was noted at the error."""
    sys.exit("\n".join([f"mkt {command}: {said}", *getattr(error, "__notes__", ())]))


def _slip_in_own_tracker(error: Exception) -> DataError | None:
    """Where a tracker of the user's own raised what we refuse input with.

    None where the library itself refuses, for which a sentence is enough.
    """
    if "mkt.course.own_tracker" not in sys.modules:  # so nobody has entered one
        return None
    from mkt.course import own_tracker

    # What is in the box, or in the figure, is told round what the tracker raised.
    inner = error.__cause__
    cause = inner if isinstance(inner, Exception) and inner.__traceback__ else error
    innermost, _ = own_tracker.way_to(cause)[-1]
    refused = isinstance(cause, ValueError | OSError)
    ours = refused and Path(innermost).is_relative_to(PACKAGE)
    return None if ours or isinstance(cause, DataError) else own_tracker.failed(cause)


def _named_file(error: Exception) -> str:
    """The message, with a remedy for what the system says of a file."""
    bare = isinstance(error, OSError) and error.filename and error.strerror
    if not bare:
        return str(error)
    return (
        f"{error.filename}: {error.strerror}; look whether the path is right, and "
        "whether it may be read or written"
    )


def _without_extras(error: Exception) -> str:
    """Which package a light install lacks, in a sentence; empty for other errors."""
    missing = isinstance(error, ModuleNotFoundError) and environment.is_by_hand()
    name = getattr(error, "name", None) or ""
    return MISSING.format(name) if missing and not name.startswith("mkt") else ""


def _in_own_tracker(error: Exception) -> DataError | None:
    """Where a tracker of the user's own failed; None for other errors."""
    # Heavy, and what it imports may be what is broken: it is there if one was entered.
    own_tracker = sys.modules.get("mkt.course.own_tracker")
    return own_tracker.failed(error) if own_tracker else None


def _fault(error: Exception) -> str:
    return FAULT.format(type(error).__name__, logged())


def logged() -> str:
    """Where the error being handled was written down, for those who correct it."""
    text = "\n".join([platform.platform(), sys.version, *sys.argv])
    try:
        with NamedTemporaryFile(
            "w",
            prefix="mkt-",
            suffix=".log",
            encoding="utf-8",
            errors="backslashreplace",
            delete=False,
        ) as file:
            file.write(f"{text}\n\n{traceback.format_exc()}")
    except OSError:
        return "this line, for no log could be written,"
    return file.name
