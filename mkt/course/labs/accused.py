"""The process in which a student's code runs: ``python -m mkt.course.labs.accused``.

It executes cells and calls the functions that they define, as the judge asks on its
standard input (see `mkt.course.labs.student`, the other end).  Nothing in here decides
about points: whatever the student's code does to this process, it can only send other
values.
"""

import _thread
import contextlib
import io
import os
import pickle
import sys
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from mkt.course.labs import sandbox
from mkt.course.labs.values import pack, receive, send

ENDLESS = 2**62  # [bytes]: the judge may send what it likes
Request = dict[str, Any]


def main() -> None:
    """Serve the judge until it closes the pipe."""
    requests, replies = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    with Path(os.devnull).open("r+b") as nowhere:
        for stream in range(3):  # nobody gets what the students print
            os.dup2(nowhere.fileno(), stream)
    os.environ |= {"MPLBACKEND": "agg", "MKT_STATIC": "0"}
    if "boxed" in sys.argv:
        sandbox.limit()
    Accused(requests, replies).serve()


class Accused:
    """A student's namespace, and the conversation about it.

    Parameters
    ----------
    requests, replies : binary file
    """

    def __init__(self, requests, replies):
        from IPython.core.interactiveshell import InteractiveShell
        from traitlets.config import Config

        class Shell(InteractiveShell):
            """One without windows: ``%matplotlib`` asks for some, and nobody looks."""

            def enable_gui(self, gui=None):
                """Do nothing."""

            def ask_exit(self):
                """What `exit()` asks for is an error here as in a function."""
                raise SystemExit

            def _tee(self, channel):
                """Keep nothing of what is printed: it may be more than memory holds."""
                return contextlib.nullcontext()

        self.requests, self.replies = requests, replies
        config = Config({"HistoryManager": {"enabled": False}})
        self.shell = Shell.instance(config=config)
        self.kept: list[Any] = []
        self.places: dict[str, dict[str, Any]] = {}  # by cell: the names behind it
        self.generators: dict[int, np.random.Generator] = {}

    def serve(self) -> None:
        """Answer one request after the other."""
        self.say({"value": "ready"})
        deeds = {"run": self.run, "call": self.call, "get": self.get}
        while True:
            self.generators.clear()
            try:
                request = self.hear()
            except EOFError:
                return
            try:
                # As Ctrl-C does.
                with sandbox.within(request["limit"], _thread.interrupt_main):
                    answer = deeds[request["do"]](request)
            except BaseException as error:  # also SystemExit, which is theirs
                answer = _told(error)
            self.say(answer)

    def hear(self) -> Any:
        """The judge's next message."""
        message = receive(self.requests, ENDLESS)
        return _Unpickler(io.BytesIO(message), self).load()

    def say(self, answer: Request) -> None:
        """Send an answer, or why it cannot be sent."""
        try:
            message = self.packed(answer)
        except BaseException as error:  # a list in itself, an object that raises
            message = self.packed(_told(error))
        send(self.replies, message)

    def packed(self, answer: Request) -> bytes:
        """A message that says, too, how far the judge's random numbers are used up."""
        states = {k: rng.bit_generator.state for k, rng in self.generators.items()}
        return pack(answer | {"states": states}, self.keep)

    def keep(self, value: Any) -> int:
        """The number of an object that the judge can ask about later."""
        self.kept.append(value)
        return len(self.kept) - 1

    def run(self, request: Request) -> Request:
        """Execute a cell."""
        done = self.shell.run_cell(request["source"])
        if "matplotlib.pyplot" in sys.modules:
            sys.modules["matplotlib.pyplot"].close("all")
        self.places[request["name"]] = dict(self.shell.user_ns)
        error = done.error_before_exec or done.error_in_exec
        return _told(error) if error else {"value": None}

    def call(self, request: Request) -> Request:
        """Call a function as it was at a place, with some of its names replaced."""
        names = self.places.get(request["place"], {}) | request["patches"]
        with patch.dict(self.shell.user_ns, names):
            function = self.named(request["name"], request["place"])
            args = map(_interned, request["args"])
            named = {key: _interned(a) for key, a in request["kwargs"].items()}
            return {"value": function(*args, **named)}

    def get(self, request: Request) -> Request:
        """An attribute of an object that was kept."""
        return {"value": getattr(self.kept[request["kept"]], request["name"])}

    def named(self, name: str, place: str) -> Any:
        """The object that a name stood for behind a cell, or else stands for now.

        Raises
        ------
        NameError
        """
        for names in (self.places.get(place, {}), self.shell.user_ns):
            if name in names:
                return names[name]
        raise NameError(f"name '{name}' is not defined")

    def back(self, number: int, args: tuple, kwargs: dict) -> Any:
        """Call a function of the judge's; what cannot be sent raises here."""
        message = self.packed({"back": number, "args": args, "kwargs": kwargs})
        send(self.replies, message)
        answer = self.hear()
        for k, state in answer["states"].items():
            self.generators[k].bit_generator.state = state
        if "error" in answer:
            raise RuntimeError(answer["error"])
        return answer["value"]


class _Unpickler(pickle.Unpickler):
    """Reads what the judge sends, which is trusted."""

    def __init__(self, file, accused: Accused):
        super().__init__(file)
        self.accused = accused

    def persistent_load(self, pid: tuple) -> Any:
        """What the judge does not send, but names."""
        kind, name, *more = pid
        if kind == "own":
            return self.accused.named(name, *more)
        if kind == "kept":
            return self.accused.kept[name]
        if kind == "function":
            return lambda *args, **kwargs: self.accused.back(name, args, kwargs)
        if kind == "locked":
            name.flags.writeable = False
            return name
        generators = self.accused.generators
        generators.setdefault(name, np.random.Generator(np.random.PCG64()))
        generators[name].bit_generator.state = more[0]
        return generators[name]


def _interned(value: Any) -> Any:
    """A word that came as bytes is then the one of the lab, for `is` as well."""
    return sys.intern(value) if type(value) is str else value


def _told(error: BaseException) -> Request:
    """An error in words."""
    return {"error": type(error).__name__, "words": str(error)}


if __name__ == "__main__":
    main()
