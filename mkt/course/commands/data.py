"""``data`` lists the benchmarks, or checks those that are there."""

from mkt.course.commands import Commands, command


def add(commands: Commands) -> None:
    """Describe the command."""
    parser = command(
        commands,
        "data",
        run,
        "list the benchmarks, or check those that are there",
        "Lists the benchmarks that can be used, where each is expected, what is\n"
        "there, its licence, and how to get it.\n"
        "With `check`, decodes every frame of all sequences that are there, and says\n"
        "what is wrong with them.",
        "data",
        "data check",
    )
    parser.add_argument(
        "check_all",
        nargs="?",
        choices=["check"],
        metavar="check",
        help="decode every frame that is there",
    )


def run(args) -> int | None:
    """List the benchmarks, or check what is there: exit code 1 where one is wrong."""
    from mkt.sequences import benchmarks

    if not args.check_all:
        print(benchmarks.listing())
        return None
    good, troubles = benchmarks.usable(look=benchmarks.check_frames)
    for found, words in good.items():
        print(f"{found.name}: {words}")
    for trouble in troubles:
        print(f"wrong: {trouble}")
    if good or troubles:
        print(f"{len(good)} sequences can be used, {len(troubles)} cannot")
    else:
        print("nothing is there; `python3 -m mkt data` says what could be")
    return 1 if troubles else 0
