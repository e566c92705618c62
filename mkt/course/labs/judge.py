"""What a student's notebook is worth: the checks, in a process that is not its own.

The student's cells run in one process (`mkt.course.labs.accused`), and the given cells
and checks of the lab here, where the student's names stand for calls into the other
one.  A check sees what a function returns, and nothing that was done to Python, numpy
or the notebook around it.  It has the student's functions as they are where it stands.
``python -m mkt.course.labs.judge`` judges one notebook.
"""

import ast
import builtins
import contextlib
import io
import json
import os
import signal
import subprocess
import sys
import types
from collections.abc import Iterable
from typing import Any

from mkt.course.labs import LIMIT
from mkt.course.labs.source import parsed
from mkt.course.labs.student import (
    CELLS,
    WHERE,
    Cell,
    Function,
    Student,
    TheirError,
    Trouble,
)

# [s] that a judge may take for itself beside the student's time.
OWN_TIME = 300
SAID = 1000  # [letters] of what is said of a cell; a student's list may be endless

_running: set[subprocess.Popen] = set()  # judges, which other threads wait for


class Judge:
    """The given cells of a lab, executed, and its checks, ready to be executed.

    Parameters
    ----------
    given, checks : list of Cell
        Of the lab.
    student : Student
    """

    def __init__(self, given: list[Cell], checks: list[Cell], student: Student):
        self.checks, self.student = checks, student
        module = types.ModuleType(WHERE)
        sys.modules[WHERE] = module  # data classes look their module up
        self.space = vars(module)
        self.functions = {
            name: Function(student, name, self.patches)
            for name in names_of_others([*given, *checks])
        }
        self.space |= self.functions
        for cell in given:
            self.verdict(cell)

    def patches(self) -> dict[str, Any]:
        """What a check has put in the place of the student's functions."""
        return {
            name: self.space[name]
            for name, function in self.functions.items()
            if self.space[name] is not function
        }

    def verdicts(self) -> dict[str, str]:
        """Name of each check that fails -> why, in words."""
        said = {cell.name: self.verdict(cell) for cell in self.checks}
        return {name: words for name, words in said.items() if words}

    def verdict(self, cell: Cell) -> str:
        """Execute a cell of the lab, and say what went wrong, "" if nothing did."""
        self.student.allow()
        self.student.place = cell.name
        with contextlib.redirect_stdout(io.StringIO()):
            try:
                exec(compile(cell.source, cell.name, "exec"), self.space)
            except TheirError as error:
                return str(error)
            except AssertionError as error:
                return str(error) or "the assertion is false"
            except Trouble:
                raise
            except Exception as error:
                return f"stops with {type(error).__name__}: {error}"
        return ""


def names_of_others(cells: Iterable[Cell]) -> set[str]:
    """Names that some cells use and do not define."""
    used, defined = set(), set(dir(builtins))
    for cell in cells:
        for node in ast.walk(parsed(cell.source)):
            if isinstance(node, ast.Name):
                (used if isinstance(node.ctx, ast.Load) else defined).add(node.id)
            elif isinstance(node, ast.arg):
                defined.add(node.arg)
            elif isinstance(node, ast.FunctionDef | ast.ClassDef | ast.ExceptHandler):
                defined.add(str(node.name))
            elif isinstance(node, ast.alias):
                defined.add(node.asname or node.name.partition(".")[0])
    return used - defined


def judged(
    given: list[Cell],
    checks: list[Cell],
    theirs: list[Cell],
    limit: float = LIMIT,
    *,
    boxed: bool,
) -> dict[str, str]:
    """What fails in a notebook, {name of the cell: why}, by a judge's own process.

    Parameters
    ----------
    given, checks : list of Cell
        Of the lab.
    theirs : list of Cell
        All cells of the student, empty ones in the places of the checks.
    limit : float [s]
        What a cell or a check may take.
    boxed : bool
        Whether the student's cells run in bubblewrap's box.

    Raises
    ------
    Trouble
        Where the judge did not come to an end.
    """
    case = {"given": given, "checks": checks, "theirs": theirs}
    case |= {"limit": limit, "boxed": boxed}
    out, errors, code = _run(json.dumps(case), CELLS * limit + OWN_TIME)
    try:
        said = json.loads(out)
    except ValueError:
        last = errors.strip().splitlines()[-1:] or [f"exit code {code}"]
        raise Trouble(f"the judge failed: {last[0]}") from None
    # In one line each, which nobody can take for a note of ours.
    return {name: " ".join(words.split())[:SAID] for name, words in said.items()}


def _run(case: str, time: float) -> tuple[str, str, int]:
    """What a judge writes about a case, and to its log, and its exit code."""
    with subprocess.Popen(
        [sys.executable, "-m", "mkt.course.labs.judge"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        env=os.environ | {"MPLBACKEND": "agg", "MKT_STATIC": "0"},
    ) as process:
        _running.add(process)
        try:
            return *process.communicate(case, time), process.returncode
        except subprocess.TimeoutExpired:
            raise Trouble("the judge did not come to an end") from None
        finally:
            _running.discard(process)
            process.kill()


def end_all() -> None:
    """End the judges that this process has started, and with each its student.

    Each is told once: a second time would disturb it while it does so.
    """
    while _running:
        _running.pop().terminate()


def main() -> None:
    """Judge the case on the standard input."""
    # As Ctrl-C does, what `timeout` or a batch system sends leaves no folder behind.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    case = json.load(sys.stdin)
    given, checks, theirs = (
        [Cell(*cell) for cell in case[part]] for part in ("given", "checks", "theirs")
    )
    with Student(theirs, case["limit"], case["boxed"]) as student:
        said = Judge(given, checks, student).verdicts()
        for check in checks:  # of which only the verdict counts
            student.failures.pop(check.name, None)
        print(json.dumps(student.failures | said))


if __name__ == "__main__":
    main()
