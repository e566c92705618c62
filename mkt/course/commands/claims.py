"""``claims`` puts the papers' claims to the test."""

from argparse import ArgumentParser
from pathlib import Path

from mkt.course.commands import Commands, command, seeds


def add(commands: Commands) -> None:
    """Describe the command."""
    parser = command(
        commands,
        "claims",
        run,
        "put the papers' claims to the test",
        "Runs the trackers over many scenes, on all cores, and judges each claim:\n"
        "half an hour for all of them on two cores.  Runs that are known are not done\n"
        "again.  With --shipped, judges what was run for the release, at once; with\n"
        "--again, on scenes that nobody had seen when the claims were put.",
        "claims --list",
        "claims",
        "claims --shipped",
        "claims --shipped --again",
        "claims T09-c T09-d --seeds 100:132",
        "claims -o claims.csv",
    )
    parser.set_defaults(check=check)
    add_argument = parser.add_argument
    add_argument(
        "names", nargs="*", metavar="ID", help="claims such as T09-c; all by default"
    )
    add_argument("--list", action="store_true", help="list the claims, and stop")
    _add_scenes(parser)
    add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="also write the verdicts into this CSV file, a row for each line; a file "
        "that is there is replaced",
    )


def _add_scenes(parser: ArgumentParser) -> None:
    """Describe on which scenes claims are judged, and whose numbers are taken."""
    parser.add_argument(
        "--seeds",
        type=seeds,
        metavar="A:B",
        help="scenes of each kind, from seed A to B - 1; 1000:1032 by default, six or "
        "more (shares of runs may need more to be supported)",
    )
    parser.add_argument(
        "--again",
        action="store_true",
        help="the scenes 3000:3032, on which the claims were tested once more",
    )
    source = parser.add_mutually_exclusive_group()
    source.add_argument(
        "--shipped", action="store_true", help="judge the numbers of the release"
    )
    source.add_argument(
        "--release",
        action="store_true",
        help="write the numbers into data/, for a release of the library",
    )


def check(args) -> str | None:
    """What is wrong with the words after `claims`, None if nothing is."""
    for name in ("shipped", "again"):
        if args.seeds and getattr(args, name):
            return f"--{name} has seeds of its own; leave out --seeds"
    return None


def run(args) -> None:
    """Judge claims, print them, and write them into a file if asked to."""
    import pandas as pd

    from mkt.experiments import claims, claims_as_text, shipped
    from mkt.experiments.sweep import write_table
    from mkt.files import new_file
    from mkt.scenes.drawn import FRESH

    if args.list:
        for claim in [claims.CLAIMS[name] for name in args.names or claims.CLAIMS]:
            print(f"{claim.name}  {claim.sentence}")
        return
    table, seeds = (
        (shipped.AGAIN, FRESH) if args.again else (shipped.CLAIMED, claims.SEEDS)
    )
    # Refused before the long work, not after it.
    if args.release:
        fresh = (claims.CLAIMS[name].name for name in args.names or claims.CLAIMS)
        shipped.check_kept(fresh, table)
    if args.output and new_file(args.output).suffix != ".csv":
        raise ValueError(f"-o {args.output}: give a name that ends in .csv")
    if args.shipped:
        measured = shipped.claimed(args.names, table)
    else:
        measured = claims.measure(args.names, args.seeds or seeds)
    results = [claims.judge(one) for one in measured]
    # Before they are printed: who reads on may have gone, as with `| head`.
    if args.output:
        write_table(pd.DataFrame(claims.as_records(results)), args.output)
    if args.release:
        shipped.write_claims(measured, table)
    print(claims_as_text.as_text(results))
