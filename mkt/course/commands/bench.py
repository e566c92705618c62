"""``bench`` times the core, or ranks the trackers."""

import os
import sys
from collections.abc import Callable
from pathlib import Path

from mkt.course.commands import Commands, command, seeds

FEW = 4  # drawn scenes of each kind, unless more are asked for


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
        "(see `python3 -m mkt data`), on drawn scenes if there are none, and prints\n"
        "who follows best.  Runs that are known are not done again; Ctrl-C\n"
        "loses only those under way.",
        "bench",
        "bench tracking",
        "bench tracking guided pf-75 --seeds 0:10 -o runs.csv",
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
        type=seeds,
        metavar="A:B",
        help="from A to B - 1, of random numbers and of drawn scenes; by default 0:5 "
        "and 1000:1004",
    )
    add_argument(
        "--release",
        action="store_true",
        help="run the drawn scenes 1000:1032 and BoBoT, and write the numbers into "
        "data/, for a release of the library; takes hours",
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
    if args.what == "core" and (args.seeds or args.output or args.release):
        return "--seeds, --release and -o go with `bench tracking`"
    if args.release and (args.names or args.seeds or args.output):
        return "--release runs all trackers, and takes no other word"
    return None


def run(args) -> None:
    """Print the benchmark of the core, or that of the trackers."""
    if args.what == "core":
        _time()
    elif args.release:
        _release()
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
    boards, troubles = leaderboard.recorded(args.names, args.seeds or leaderboard.SEEDS)
    few = leaderboard.HELD_BACK[:FEW]
    board = (
        boards[0] if boards else leaderboard.synthetic(args.names, args.seeds or few)
    )
    text = leaderboard.as_markdown(board)
    print(text)
    if output:
        _write(board.rows, text, output)
    for trouble in troubles:
        print(f"left out: {trouble}", file=sys.stderr)


def _release() -> None:
    """Run what the book shows, and keep the numbers."""
    from mkt.experiments import leaderboard, shipped

    scenes = leaderboard.synthetic()
    shipped.write_runs(scenes.rows, leaderboard.HELD_BACK, shipped.TRACKED)
    boards, _ = leaderboard.recorded(archive="BoBoT")
    if boards:
        shipped.write_runs(boards[0].rows, leaderboard.SEEDS, shipped.BOBOT)
    else:
        print("BoBoT is not below MKT_DATA; its table stays as it is", file=sys.stderr)


def _write(rows, text: str, output: Path) -> None:
    from mkt.experiments.sweep import write_table
    from mkt.files import whole

    if output.suffix == ".csv":
        write_table(rows, output)
        return
    with whole(output) as half:
        half.write_text(text + "\n", encoding="utf-8")
