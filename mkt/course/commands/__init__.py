"""The commands of ``python3 -m mkt``, a module for each.

A command module has `add`, which describes its words to argparse, and `run`, which does
the work and returns the exit code or None.  For students and readers:
`mkt.course.commands.book`, `mkt.course.commands.lab`, `mkt.course.commands.labs`,
`mkt.course.commands.slides`, `mkt.course.commands.figure`, `mkt.course.commands.track`,
`mkt.course.commands.data` and `mkt.course.commands.doctor`; for those who check:
`mkt.course.commands.test`, `mkt.course.commands.claims`, `mkt.course.commands.bench`.

Nothing heavy is imported before a command runs, so that --help needs no installed
package.  A command reports what is wrong with its input as a ValueError or OSError;
`mkt.course.cli` prints this in one line.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

Commands = Any  # argparse's own type for sub-commands is private


def command(
    commands: Commands,
    name: str,
    run: Callable[[argparse.Namespace], int | None],
    summary: str,
    text: str,
    *examples: str,
    clone: bool = False,
) -> argparse.ArgumentParser:
    """A new command.

    Parameters
    ----------
    commands
        Of argparse.
    name : str
    run : callable
        The parsed words -> the exit code, None for 0.
    summary : str
        For the list of commands.
    text : str
        For its own help.
    *examples : str
        Lines without ``python3 -m mkt``; the bare command by default.
    clone : bool
        It needs what only a clone has: notebooks, tests.
    """
    lines = "\n".join(f"  python3 -m mkt {words}" for words in examples or (name,))
    parser = commands.add_parser(
        name,
        help=summary,
        description=text,
        epilog=f"examples:\n{lines}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(run=run, clone=clone, error=parser.error)
    return parser


def named_path(text: str) -> Path:
    """The path that was typed.

    Raises
    ------
    argparse.ArgumentTypeError
        For an empty one, which Path takes for this folder.
    """
    if not text:
        raise argparse.ArgumentTypeError("the name is empty")
    return Path(text)


def seeds(text: str) -> range:
    """The seeds that A:B names, from A to B - 1.

    Raises
    ------
    argparse.ArgumentTypeError
        With the remedy.
    """
    first, colon, after = text.partition(":")
    if not (colon and first.isdecimal() and after.isdecimal()):
        raise argparse.ArgumentTypeError(
            f"{text}: give the first seed and the one after the last, such as 100:132"
        )
    if int(after) <= int(first):
        raise argparse.ArgumentTypeError(f"{text}: there is no seed in it")
    return range(int(first), int(after))
