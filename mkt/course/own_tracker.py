"""A tracker of the user's own by the name ``module:Class``, without a change here.

Once it is entered, every command knows it by that name: `mkt.trackers.by_name` has it.
Only words of the command line are taken for such a name, never those of a file, because
to import a module is to run it.
"""

import importlib
import inspect
import re
import traceback
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mkt.files import PACKAGE, DataError
from mkt.registry import UnknownName
from mkt.scenes.drawn import Drawn
from mkt.trackers import by_name
from mkt.tracking import Tracker, checked_step

WANTED = (
    "a tracker is a frozen dataclass with the methods init and step, whose fields all "
    "have a default; CONTRIBUTING.md describes it"
)
CALLED = {"init": ("frame", "region", "rng"), "step": ("state", "frame", "rng")}

Place = tuple[str, int | None]  # a file and a line of it


def enter(name: str) -> str:
    """Make ``module:Class`` known as a tracker; known names stay what they are.

    Parameters
    ----------
    name : str
        The class, or an object of it, in a module that Python can import from here.

    Returns
    -------
    str
        The name.

    Raises
    ------
    ValueError
        When there is no such thing, or it is no tracker; DataError with the line in
        which its module fails.
    """
    if name in by_name.TRACKERS:
        return name
    if ":" not in name:
        unknown = UnknownName("tracker", name, list(by_name.TRACKERS))
        raise ValueError(f"{unknown}; one of your own is MODULE:CLASS")
    by_name.add(name, _made(name), name)
    return name


def enter_for_ranking(name: str) -> str:
    """`enter`, for runs whose cost is counted: one step shows what its info lacks.

    Raises
    ------
    ValueError
        As `enter` does, for a step that is none, and for an info without the
        evaluations.
    """
    if ":" in enter(name):
        clip = Drawn("base", 0).sequence()
        rng = np.random.default_rng(0)
        tracker = by_name.TRACKERS[name]
        state = tracker.init(clip.frames[0], clip.truth[0], rng)
        stepped = tracker.step(state, clip.frames[1], rng)
        if "evaluations" not in checked_step(tracker, stepped)[1]:
            raise ValueError(
                f"{name}: its info has no evaluations, the regions that it looked at; "
                "make it with mkt.report"
            )
    return name


def _made(name: str) -> Tracker:
    """The tracker that ``module:Class`` names."""
    thing = _named(name)
    try:
        tracker = thing() if isinstance(thing, type) else thing
    except TypeError as error:
        raise ValueError(f"{name}: {error}; {WANTED}") from None
    except (Exception, SystemExit) as error:
        raise _mistake(error) or error from None
    frozen = is_dataclass(tracker) and tracker.__dataclass_params__.frozen
    methods = (getattr(tracker, method, None) for method in CALLED)
    if not (frozen and all(map(callable, methods))):
        raise ValueError(f"{name} is not a tracker: {WANTED}")
    for method in CALLED:
        _refuse_signature(tracker, method, name)
    try:
        hash(tracker)
    except TypeError as error:
        raise ValueError(
            f"{name}: {error}; take a tuple for a list in its fields"
        ) from None
    return tracker


def _refuse_signature(tracker: Tracker, method: str, name: str) -> None:
    """Refuse a method that does not take what it will be called with.

    Called with it, it would fail before the first line of its own.
    """
    takes = inspect.signature(getattr(tracker, method))
    given = CALLED[method]
    try:
        takes.bind(*given)
    except TypeError:
        raise ValueError(
            f"{name}: {method} takes {takes}; "
            f"write it with (self, {', '.join(given)}), as it is called"
        ) from None


def _named(name: str) -> Any:
    """What a module calls by a name."""
    module, _, attribute = name.partition(":")
    try:
        return getattr(importlib.import_module(module), attribute)
    except (Exception, SystemExit) as error:  # which would end the command unsaid
        raise _mistake(error) or ValueError(
            f"{name}: {error}; give the tracker as module:Class, from the folder in "
            "which module.py lies"
        ) from None


def failed(error: Exception) -> DataError | None:
    """What is wrong in a tracker that was entered and failed while it ran.

    None where no line of one was on the way to the error.
    """
    own = [made for name, made in by_name.TRACKERS.items() if ":" in name]
    files = {inspect.getfile(type(tracker)) for tracker in own}
    # One that is an object of the library's own class has no line of the user's.
    files = {file for file in files if not Path(file).is_relative_to(PACKAGE)}
    theirs = [at for at in way_to(error) if at[0] in files]
    return _told(error, theirs[-1]) if theirs else None


def way_to(error: BaseException) -> list[Place]:
    """Files and lines on the way to an error, the innermost last.

    Of an error in a process that joblib has started they are those there, which come
    back as text.
    """
    if type(error.__cause__).__name__ == "_RemoteTraceback":
        places = re.findall(r'File "(.+)", line (\d+)', str(error.__cause__))
        return [(file, int(line)) for file, line in places]
    return [(f.filename, f.lineno) for f in traceback.extract_tb(error.__traceback__)]


def _mistake(error: BaseException) -> DataError | None:
    """What is wrong in a module of the user's; None where none of it has run."""
    place = _place(error)
    return _told(error, place) if place else None


def _told(error: BaseException, place: Place) -> DataError:
    # Notes stand below, each line of one by itself.
    below = sum(len(n.split("\n")) for n in getattr(error, "__notes__", ()))
    what = traceback.format_exception_only(error)[-1 - below].strip()
    return DataError(place[0], what, "correct it there, and run this again", place[1])


def _place(error: BaseException) -> Place | None:
    """File and line of the user's in which something failed."""
    if isinstance(error, SyntaxError) and error.filename:
        return error.filename, error.lineno
    theirs = [at for at in way_to(error) if not _on_the_way(at[0])]
    # Below the first one's folder are packages that it calls: not what is to be mended.
    near = [at for at in theirs if Path(at[0]).parent == Path(theirs[0][0]).parent]
    return near[-1] if near else None


def _on_the_way(file: str) -> bool:
    """Whether code stands between the command and the user's: ours, or Python's."""
    return file in (__file__, importlib.__file__) or file.startswith("<")
