"""The judge's end of the conversation with a student's code.

A `Student` stands for the process of `mkt.course.labs.accused`.  It starts this process
when it is needed, and again when the code has ended it; the cell that ended it is then
left out.  The functions of the student are called by value: copies of the arguments go
there, plain values come back.  The judge's own functions among the arguments stay here
and are called back, so that a check can look on.
"""

import io
import pickle
import queue
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np

from mkt.course.labs import sandbox
from mkt.course.labs.values import TooLarge, receive, send, unpack

WHERE = "__lab__"  # the module that the checks are in
UNWRITTEN = "not written yet"
DIED = "the program died, perhaps for want of memory, or something ended it"
# The end of what numpy says of an array that `mkt.course.labs.values.lock` has locked.
LOCKED = "is read-only"
CHANGED = (
    "your function changes an array that it was given, which is read-only: compute a "
    "new one in place of +=, *= or [...] ="
)
# Where a check, or a function that it puts in the place of another, is called by name.
RENAMED = "are the names in the `def` lines still those that you were given?"
ENDS = "calls exit(), which ends the program: take it out"
OVER = "the notebook takes too long as a whole, and was stopped before this"
# [s] for what was interrupted to end, but not above the limit; then its process is
# given up.
PATIENCE = 10.0
CELLS = 20  # times the limit is what a whole notebook may take


class Cell(NamedTuple):
    """A cell of code.

    Attributes
    ----------
    name, source : str
    """

    name: str
    source: str


class TheirError(Exception):
    """What went wrong in the student's code, in words."""


class Trouble(RuntimeError):
    """We failed ourselves, which says nothing about the student."""


class Kept:
    """Stands for an object that stays with the student; its attributes can be read.

    Parameters
    ----------
    student : Student
    number : int
    kind : str
        The name of its type.
    """

    def __init__(self, student: "Student", number: int, kind: str):
        self.student, self.number = student, number
        self.words = f"an object of the type {kind[:40]}"

    def __repr__(self) -> str:
        return self.words

    def __format__(self, _: str) -> str:
        return self.words

    def __getattr__(self, name: str) -> Any:
        # Numpy asks for a shape of its own accord: none is no error of theirs.
        if name.startswith("__") or name in ("ndim", "shape"):
            raise AttributeError(name)
        request = {"do": "get", "kept": self.number, "name": name}
        return self.student.ask(request)["value"]

    def _refused(self, *_: Any) -> Any:
        raise TheirError(
            f"your code gives {self.words}, which a check cannot look into: return "
            "numbers, a tuple, a list or an array"
        )

    __iter__ = __len__ = __getitem__ = __contains__ = __float__ = __int__ = _refused
    __lt__ = __le__ = __gt__ = __ge__ = __abs__ = __neg__ = __round__ = _refused
    __add__ = __sub__ = __mul__ = __matmul__ = __truediv__ = __pow__ = _refused
    __radd__ = __rsub__ = __rmul__ = __rmatmul__ = __rtruediv__ = __rpow__ = _refused


class KeptTuple(tuple):
    """Stands for a named tuple: a tuple for a check, too, as it is in a notebook."""

    number: int
    fields: list[str]

    def __new__(cls, number: int, fields: list[str], inside: list) -> "KeptTuple":
        """What is inside, by the number of the object that stays with the student."""
        if len(fields) != len(inside):
            raise ValueError(f"{len(inside)} values for {len(fields)} fields")
        one = super().__new__(cls, inside)
        one.number, one.fields = number, fields
        return one

    def __getattr__(self, name: str) -> Any:
        # Numpy asks for a shape: to it this is no field, and no error of theirs.
        if name not in self.fields:
            raise AttributeError(name)
        return self[self.fields.index(name)]


def kept(
    student: "Student", number: int, kind: str, fields: list[str], inside: list
) -> Kept | KeptTuple:
    """What stands for an object of a student's."""
    if fields:
        return KeptTuple(number, fields, inside)
    return Kept(student, number, kind)


class Function:
    """Stands for a function that the student has written.

    Parameters
    ----------
    student : Student
    name : str
    patches : callable
        What is in the place of the student's names now, {name: value}.
    """

    def __init__(self, student: "Student", name: str, patches: Callable[[], dict]):
        self.student, self.name, self.patches = student, name, patches

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Call it, in the student's process."""
        request = {"name": self.name, "args": args, "kwargs": kwargs}
        place = self.student.place
        more = {"do": "call", "patches": self.patches(), "place": place}
        return self.student.ask(request | more)["value"]


class Student:
    """What a student wrote, in a process of its own.

    Parameters
    ----------
    cells : list of Cell
    limit : float [s]
        What a cell or a check may take.
    boxed : bool
        Whether it runs in bubblewrap's box.

    Attributes
    ----------
    failures : dict
        Name of each cell that failed -> what went wrong, in words.
    place : str
        The cell behind which the student's names are looked up: what stands further
        down may give them to something else.
    deadline : float [s]
        Until when it may answer, of `time.monotonic`; each cell and each check has one.
    """

    def __init__(self, cells: list[Cell], limit: float, boxed: bool):
        self.cells, self.limit, self.boxed = cells, limit, boxed
        self.failures: dict[str, str] = {}
        self.deadly: set[Cell] = set()  # those that end the process
        self.place = ""
        self.end = time.monotonic() + CELLS * limit
        self.deadline = self.end
        self.process: subprocess.Popen | None = None
        self.generators: list[np.random.Generator] = []
        self.folder = tempfile.TemporaryDirectory(
            prefix="mkt-lab-", ignore_cleanup_errors=True
        )

    def __enter__(self) -> "Student":
        try:
            self.start()
        except BaseException:  # also Ctrl-C, while a cell runs
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
        self.folder.cleanup()

    def start(self) -> None:
        """Run all cells in a fresh process, without those that end it."""
        while self.process is None:
            self.launch()
            for cell in self.cells:
                if cell not in self.deadly and self.process:
                    self.run(cell)

    def launch(self) -> None:
        """A process that waits for requests.

        One thread collects its answers, another looks at how much memory it takes.

        Raises
        ------
        Trouble
            Where there cannot be one.
        """
        command = [sys.executable, "-m", "mkt.course.labs.accused"]
        try:
            self.process = subprocess.Popen(
                sandbox.boxed([*command, "boxed"]) if self.boxed else command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                cwd=None if self.boxed else self.folder.name,
                env=None if self.boxed else sandbox.environment_outside(),
            )
        except OSError as error:  # such as too many processes
            raise Trouble(f"a student's program cannot be started: {error}") from None
        self.pipe: Any = self.process.stdin
        self.answers: queue.Queue[bytes | None] = queue.Queue(1)
        self.functions: list[Callable] = []
        collector = self.process.stdout, self.answers
        threading.Thread(target=_collect, args=collector, daemon=True).start()
        threading.Thread(
            target=sandbox.watch, args=(self.process,), daemon=True
        ).start()
        if self.answers.get() is None:  # it greets, before it runs anything of theirs
            self.process = None
            raise Trouble("the students' programs cannot be started here")

    def stop(self) -> None:
        """End the process, and with a box all that it has started."""
        if self.process:
            self.process.kill()
            self.process.wait()
        self.process = None

    def run(self, cell: Cell) -> None:
        """Run a cell, and keep in `failures` what went wrong.

        Of two cells of one name it is what ended the process, or else what came last.
        """
        self.allow()
        if cell.name not in {deadly.name for deadly in self.deadly}:
            self.failures.pop(cell.name, None)
        try:
            self.ask({"do": "run", "source": cell.source, "name": cell.name})
        except TheirError as error:
            self.failures[cell.name] = str(error)
            if self.process is None:
                self.deadly.add(cell)

    def allow(self) -> None:
        """Start the time of one cell or check."""
        self.deadline = min(time.monotonic() + self.limit, self.end)

    def ask(self, request: dict[str, Any]) -> dict[str, Any]:
        """The answer to a request.

        Raises
        ------
        TheirError
            Where there is none.
        """
        if self.process is None:
            self.start()
            self.allow()  # whatever its cells took
        left = self.deadline - time.monotonic()
        if left <= 0:
            raise TheirError(self.late())
        self.generators = []  # of this request; the states of earlier ones are known
        called_back = False
        assert self.process is not None
        # It may not even listen.
        with sandbox.within(left + self.patience, self.process.kill):
            self.say(request | {"limit": left})
            while "back" in (answer := self.hear()):
                called_back = True
                self.say(self.called_back(answer))
        if "error" in answer:
            if called_back and answer["error"] == "KeyboardInterrupt":
                self.stop()  # it would take our last answer for the next request
            raise _as_said(str(answer["error"]), str(answer["words"]), self.late())
        return answer

    @property
    def patience(self) -> float:
        """What an interrupted process may take to end [s]."""
        return min(PATIENCE, self.limit)

    def late(self) -> str:
        """The message about what took too long."""
        if time.monotonic() >= self.end:
            return OVER
        return f"not finished after {self.limit:g} s: is there a loop that never ends?"

    def say(self, message: dict[str, Any]) -> None:
        """Send a message."""
        buffer = io.BytesIO()
        _Pickler(buffer, self).dump(message)
        with suppress(OSError):  # it has died, and `hear` says so
            send(self.pipe, buffer.getvalue())

    def hear(self) -> dict[str, Any]:
        """The next message.

        Raises
        ------
        TheirError
            Where none comes, or nonsense does.
        """
        words = DIED
        try:
            left = self.deadline + self.patience - time.monotonic()
            if left <= 0:  # however many messages there are
                raise queue.Empty
            message = self.answers.get(timeout=left)
            answer = unpack(message or b"", partial(kept, self))
            for k, state in answer["states"].items():
                self.generators[k].bit_generator.state = state
            return answer
        except queue.Empty:
            words = f"not finished after {self.limit:g} s, and could not be interrupted"
        except Exception:  # whatever a hostile message leads to
            pass
        self.stop()
        raise TheirError(words)

    def called_back(self, answer: dict[str, Any]) -> dict[str, Any]:
        """What a function of the judge's answers to the student."""
        try:
            function = self.functions[answer["back"]]
            said = {"value": function(*answer["args"], **answer["kwargs"])}
        except Exception as error:
            said = {"error": f"{type(error).__name__}: {error}"}
        states = {k: rng.bit_generator.state for k, rng in enumerate(self.generators)}
        return said | {"states": states}


class _Pickler(pickle.Pickler):
    """Writes messages to the student."""

    def __init__(self, file, student: Student):
        super().__init__(file, protocol=5)
        self.student = student

    def persistent_id(self, obj: Any) -> tuple | None:
        """A name for what is not sent: functions of the lab, and what is the student's.

        Random numbers come from a copy, whose state comes back with every answer.
        """
        if isinstance(obj, Function):
            return "own", obj.name, self.student.place
        if isinstance(obj, Kept | KeptTuple):
            return "kept", obj.number
        if isinstance(obj, FunctionType) and obj.__module__ == WHERE:
            return "function", _place(self.student.functions, obj)
        if isinstance(obj, np.random.Generator):
            number = _place(self.student.generators, obj)
            return "generator", number, obj.bit_generator.state
        if isinstance(obj, np.ndarray) and not obj.flags.writeable:
            return "locked", np.array(obj)  # pickled it could be written to
        return None


def _place(known: list, obj: Any) -> int:
    """The number of an object in a list, at whose end it is put if it is new."""
    for k, one in enumerate(known):
        if one is obj:
            return k
    known.append(obj)
    return len(known) - 1


def _collect(pipe, answers: "queue.Queue[bytes | None]") -> None:
    """Hand over all messages of a pipe, and None at its end."""
    with suppress(EOFError, OSError, ValueError):
        while True:
            answers.put(receive(pipe))
    answers.put(None)


def _as_said(name: str, words: str, late: str) -> TheirError:
    """An error of the student's code, as the student is told."""
    if name == TooLarge.__name__:
        return TheirError(words)
    if name == "AssertionError":
        return TheirError(words or "the assertion is false")
    if name == "NotImplementedError":
        return TheirError(UNWRITTEN)
    if name == "KeyboardInterrupt":
        return TheirError(late)
    if name == "SystemExit":
        return TheirError(ENDS)
    if name == "ValueError" and words.endswith(LOCKED):
        return TheirError(CHANGED)
    more = f": {RENAMED}" if "unexpected keyword argument" in words else ""
    # Python says "(<where>, line 3)" of what it cannot read.
    return TheirError(
        f"stops with {name}: {re.sub(r'[(][^()]*, line', '(line', words)}{more}"
    )
