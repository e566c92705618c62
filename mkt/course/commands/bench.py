"""``bench`` times the core, or ranks the trackers."""

import sys
from collections.abc import Callable
from math import isnan
from pathlib import Path

from mkt.course.commands import Commands, command, named_path, seeds

FEW = 4  # drawn scenes of each kind, unless more are asked for
MEANING = {  # of the numbers of `mkt.evaluation.evaluate`
    "overlap": "mean, over the frames in which the target is seen",
    "hits": "the share of these whose overlap is above .2",
    "hits_of_all": "the same out of all frames but the first",
    "area": "under the success curve",
    "position": "mean error [px]",
    "orientation": "mean error [deg], where the truth has one",
    "scale": "mean error of the size [log]",
    "shrunk": "the share of frames with less than half of the true area",
    "lost": "1 where none of the last ten frames is a hit",
    "failed": "1 where none of them is a hit that is turned the right way",
    "silent": "the share of the misses in which it did not say that it is lost",
    "false_alarms": "the share of the hits in which it did",
}


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
        "loses only those under way.  A tracker of your own is MODULE:CLASS.\n"
        "With `score`, judges boxes that were found elsewhere: FILE has them in the\n"
        "form of the truth of SEQUENCE (BoBoT, OTB, VOT, MOT), or is a table (.csv)\n"
        "of `track` or of --tracks.  A .txt of theirs has MOT's rows, which leave out\n"
        "the frames that are said to be lost: they count as missed.",
        "bench",
        "bench tracking",
        "bench tracking guided pf-75 --seeds 0:10 -o runs.csv",
        "bench tracking -o table.md",
        "bench tracking guided pf-500 --starts 6",
        "bench tracking mosse:MOSSE guided --on PETS09-S2L1:9 --tracks found",
        "bench score boxes.txt PETS09-S2L1:9",
    )
    parser.set_defaults(check=check)
    _add_words(parser.add_argument)
    _add_runs(parser.add_argument)
    _add_files(parser.add_argument)


def _add_words(add_argument: Callable) -> None:
    """Say which words the command takes."""
    add_argument(
        "what",
        nargs="?",
        choices=["core", "tracking", "score"],
        default="core",
        help="what to measure; core by default",
    )
    add_argument(
        "names",
        nargs="*",
        metavar="NAME",
        help="trackers such as guided, all by default; after `score` FILE SEQUENCE",
    )
    add_argument(
        "--tracker",
        action="append",
        default=[],
        metavar="MODULE:CLASS",
        help="one of your own, beside those that are named, or all",
    )


def _add_runs(add_argument: Callable) -> None:
    """Say which words choose the runs."""
    add_argument(
        "--on",
        action="append",
        default=[],
        metavar="SEQUENCE",
        help="only this one, such as BoBoT/Vid_A_ball, or PETS09-S2L1:9 for the target "
        "9 of a sequence of MOT; may be given several times",
    )
    add_argument(
        "--seeds",
        type=seeds,
        metavar="A:B",
        help="from A to B - 1, of random numbers and of drawn scenes; by default 0:5 "
        "and 1000:1004, with --starts 0:1",
    )
    add_argument(
        "--starts",
        type=int,
        metavar="N",
        help="start each sequence in N frames spread over it instead of in its first, "
        "and play it from N backwards: how much hangs on the first frame",
    )
    add_argument(
        "--release",
        action="store_true",
        help="run the drawn scenes 1000:1032 and BoBoT with the trackers whose code "
        "has changed, and write the numbers into data/, for a release of the library; "
        "takes minutes for a tracker, hours for all",
    )


def _add_files(add_argument: Callable) -> None:
    """Say which words name what is written."""
    add_argument(
        "--tracks",
        type=named_path,
        metavar="FOLDER",
        help="also write what each run found, frame by frame: a table (.csv), and "
        "MOT's rows (.txt); files that are there are replaced",
    )
    add_argument(
        "-o",
        "--output",
        type=named_path,
        metavar="FILE",
        help="also write a row for each run (.csv), or the tables (.md); a file that "
        "is there is replaced",
    )


def check(args) -> str | None:
    """What is wrong with the words after `bench`, None if nothing is."""
    words = (args.tracker, args.on, args.tracks, args.seeds, args.output)
    said = any(words) or args.starts is not None
    if args.what != "tracking" and (said or args.release):
        return "options go with `bench tracking`"
    if args.what == "core" and args.names:
        return "bench core takes no names; `bench tracking` ranks trackers"
    if args.what == "score" and len(args.names) != 2:
        return "bench score needs a FILE and a SEQUENCE"
    if args.starts is not None and args.starts < 1:
        return f"--starts is {args.starts}; give 1 or more"
    if args.starts and args.tracks:
        return "--tracks writes whole sequences; leave out --starts"
    if args.release and (args.names or said):
        return "--release chooses the trackers, and takes no other word"
    return None


def run(args) -> None:
    """Print the benchmark of the core, or that of the trackers."""
    if args.what == "core":
        _time()
    elif args.what == "score":
        _score(Path(args.names[0]), args.names[1])
    elif args.release:
        _release()
    else:
        _rank(args)


def _time() -> None:
    """Time the core."""
    from mkt.course import speed

    speed.main()


def _rank(args) -> None:
    """Rank the trackers, print the tables, and write them or the runs if asked to."""
    from mkt.course import own_tracker
    from mkt.experiments import leaderboard
    from mkt.experiments.leaderboard_as_text import as_markdown
    from mkt.files import named, new_file

    output = args.output
    if output and new_file(output).suffix not in (".csv", ".md"):
        raise ValueError(f"-o {output}: give a name that ends in .csv or .md")
    if args.tracks:
        with named(args.tracks):
            args.tracks.mkdir(parents=True, exist_ok=True)
    own = [own_tracker.enter_for_ranking(name) for name in args.tracker]
    chosen = [own_tracker.enter_for_ranking(name) for name in args.names]
    names = [*chosen, *own] if chosen else []  # those of your own are among all
    usual = leaderboard.SEEDS[:1] if args.starts else leaderboard.SEEDS
    boards, troubles = leaderboard.recorded(
        names, args.seeds or usual, on=args.on, starts=args.starts or 0
    )
    if args.starts and not boards:
        raise ValueError("--starts needs sequences; see `python3 -m mkt data`")
    few = leaderboard.HELD_BACK[:FEW]
    board = boards[0] if boards else leaderboard.synthetic(names, args.seeds or few)
    text = as_markdown(board)
    # Before they are printed: who reads on may have gone, as with `| head`.
    if output:
        _write(board.rows, text, output)
    if args.tracks:
        leaderboard.write_tracks(board, args.tracks)
    print(text)
    for trouble in troubles:
        print(f"left out: {trouble}", file=sys.stderr)


def _score(path: Path, name: str) -> None:
    """Print what a track in a file is worth, and - for what is not known."""
    from mkt.evaluation import evaluate
    from mkt.sequences import benchmarks, tracks

    track, clip = tracks.read(path, benchmarks.named(name))
    for what, value in evaluate(track, clip).items():
        number = "-" if isnan(value) else f"{value:.3f}"
        print(f"{what:12}  {number:>7}  {MEANING[what]}")


def _release() -> None:
    """Run what the book shows, and keep the numbers.

    Only trackers whose code has changed run; of the others the numbers stay.
    """
    from mkt.experiments import leaderboard, shipped

    for table, every in (
        (shipped.TRACKED, leaderboard.HELD_BACK),
        (shipped.BOBOT, leaderboard.SEEDS),
    ):
        _, made = shipped.read_runs(table)
        names = shipped.changed(table, made)
        print(f"{table.name}: {', '.join(names) or 'nothing'} to run", file=sys.stderr)
        board = leaderboard.for_release(table, names) if names else None
        if board:
            shipped.write_runs(shipped.renewed(table, board.rows), every, table)
        elif names:
            print("BoBoT is not below MKT_DATA; its table stays", file=sys.stderr)


def _write(rows, text: str, output: Path) -> None:
    from mkt.experiments.sweep import write_table
    from mkt.files import whole

    if output.suffix == ".csv":
        write_table(rows, output)
        return
    with whole(output) as half:
        half.write_text(text + "\n", encoding="utf-8")
