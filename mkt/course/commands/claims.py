"""``claims`` puts the papers' claims to the test."""

from pathlib import Path

from mkt.course.commands import Commands, command


def add(commands: Commands) -> None:
    """Describe the command."""
    parser = command(
        commands,
        "claims",
        run,
        "put the papers' claims to the test",
        "Runs the trackers over many seeds, on all cores, and judges each claim: some\n"
        "ten minutes for all of them on two cores.  Runs that are known are not done\n"
        "again.",
        "claims --list",
        "claims",
        "claims T09-c T09-d --seeds 48",
        "claims -o claims.csv",
    )
    add_argument = parser.add_argument
    add_argument(
        "ids", nargs="*", metavar="ID", help="claims such as T09-c; all by default"
    )
    add_argument("--list", action="store_true", help="list the claims, and stop")
    add_argument(
        "--seeds",
        type=int,
        metavar="N",
        help="how many sequences of each kind; 16 by default, at least 6",
    )
    add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="also write the numbers into this CSV file",
    )


def run(args) -> None:
    """Judge claims, print them, and write them into a file if asked to."""
    import pandas as pd

    from mkt.experiments import claims, claims_as_text
    from mkt.experiments.sweep import write_table

    if args.list:
        for claim in claims.CLAIMS.values():
            print(f"{claim.name}  {claim.sentence}")
        return
    if args.output and not args.output.parent.is_dir():
        # Said before the long work, not after it.
        raise FileNotFoundError(
            f"no folder {args.output.parent} for {args.output.name}; make it first"
        )
    seeds = claims.SEEDS if args.seeds is None else args.seeds
    results = claims.judge(args.ids, seeds)
    print(claims_as_text.as_text(results))
    if args.output:
        write_table(pd.DataFrame(claims.as_records(results)), args.output)
