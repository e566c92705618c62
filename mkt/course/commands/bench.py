"""``bench`` times the core, or ranks the trackers."""

import os
import sys
from collections.abc import Callable
from pathlib import Path

from mkt.course.commands import Commands, command


def add(commands: Commands) -> None:
    """Describe the command."""
    parser = command(
        commands,
        "bench",
        run,
        "time the core, or rank the trackers",
        "Without a word, prints CPU milliseconds of the hot loop and its rivals\n"
        "(median, one thread) side by side, with ratios.\n"
        "With `tracking`, runs all trackers on all benchmark sequences that are found\n"
        "(see `python3 -m mkt data`), on our synthetic ones if there are none, and\n"
        "prints who follows best.  Runs that are known are not done again; Ctrl-C\n"
        "loses only those under way.",
        "bench",
        "bench tracking",
        "bench tracking guided pf-75 --seeds 10 -o runs.csv",
        "bench tracking -o table.md",
    )
    parser.set_defaults(check=check)
    _add_words(parser.add_argument)


def _add_words(add_argument: Callable) -> None:
    """Say which words the command takes."""
    add_argument(
        "what",
        nargs="?",
        choices=["core", "tracking"],
        default="core",
        help="what to measure; core by default",
    )
    add_argument(
        "names",
        nargs="*",
        metavar="TRACKER",
        help="trackers such as guided; all by default",
    )
    add_argument(
        "--seeds",
        type=int,
        metavar="N",
        help="runs of each tracker that draws random numbers on each sequence; "
        "5 by default",
    )
    add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="also write a row for each run (.csv), or the tables (.md)",
    )


def check(args) -> str | None:
    """What is wrong with the words after `bench`, None if nothing is."""
    if args.what == "core" and (args.seeds is not None or args.output):
        return "--seeds and -o go with `bench tracking`"
    return None


def run(args) -> None:
    """Print the benchmark of the core, or that of the trackers."""
    if args.what == "core":
        _time()
    else:
        _rank(args)


def _time() -> None:
    """Time the core on one thread, which numpy is told before it is loaded."""
    for library in ("OPENBLAS", "MKL", "OMP"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    from mkt.course import speed

    speed.main()


def _rank(args) -> None:
    """Rank the trackers, print the tables, and write them or the runs if asked to."""
    from mkt.experiments import leaderboard

    output = args.output
    if output and not (output.parent.is_dir() and output.suffix in (".csv", ".md")):
        raise ValueError(
            f"-o {output}: give a name that ends in .csv or .md, in a folder that "
            "exists"
        )
    seeds = leaderboard.SEEDS if args.seeds is None else args.seeds
    boards, troubles = leaderboard.recorded(args.names, seeds)
    board = boards[0] if boards else leaderboard.synthetic(args.names, seeds)
    text = leaderboard.as_markdown(board)
    print(text)
    if output:
        _write(board.rows, text, output)
    for trouble in troubles:
        print(f"left out: {trouble}", file=sys.stderr)


def _write(rows, text: str, output: Path) -> None:
    from mkt.experiments.sweep import write_table
    from mkt.files import whole

    if output.suffix == ".csv":
        write_table(rows, output)
        return
    with whole(output) as half:
        half.write_text(text + "\n", encoding="utf-8")
