"""``figure`` draws one figure into a file, or all of them."""

from collections.abc import Callable

from mkt.course.commands import Commands, command, named_path

FORMATS = ("png", "pdf", "svg", "csv")
WANTED = (
    "figure needs an ID and -o FILE, or --all and -o FOLDER; "
    "`python3 -m mkt figure --list` lists the figures"
)
SWALLOWED = "{} is not NAME=VALUE; an ID stands before --set"
TWICE = "--tracker says which tracker is shown; leave it out of --set"
APART = (
    "--set goes with one figure, --format with --all; one figure's format is the "
    "ending of its file"
)


def add(commands: Commands) -> None:
    """Describe the command."""
    parser = command(
        commands,
        "figure",
        run,
        "draw one figure into a file, or all",
        "Draws a registered figure with its defaults, or your values; or writes what\n"
        "it shows as a table.  Parameters, versions and data are in the file: a PDF's\n"
        "properties, a PNG's text, an SVG's metadata, a GIF's comment, a CSV's first\n"
        "lines.",
        "figure --list",
        "figure teuliere2009.fig6 --list",
        "figure teuliere2009.fig3 -o fig3.pdf",
        "figure teuliere2009.fig6 -o fig6.csv --set particles=100 --set seed=1",
        "figure --all -o figures --format pdf",
    )
    parser.set_defaults(check=check)
    _add_words(parser.add_argument)


def _add_words(add_argument: Callable) -> None:
    """Say which words the command takes."""
    add_argument(
        "id",
        nargs="?",
        metavar="ID",
        help="paper and figure, such as teuliere2009.fig3",
    )
    add_argument(
        "-o",
        "--output",
        type=named_path,
        metavar="FILE",
        help="file to write: .png, .pdf, .svg, .csv for a table of what it shows, or "
        ".gif where it has a slider frame; with --all a folder; a file that is there "
        "is replaced",
    )
    add_argument(
        "--set",
        nargs="+",
        action="extend",
        default=[],
        metavar="NAME=VALUE",
        help="parameters that differ from the defaults",
    )
    add_argument(
        "--tracker",
        metavar="MODULE:CLASS",
        help="a tracker of your own, in a figure that shows one of choice (own.run) or "
        "all (own.success)",
    )
    add_argument(
        "--list",
        action="store_true",
        help="list the figures, or with ID its parameters, and stop",
    )
    add_argument(
        "--all",
        action="store_true",
        help="draw every figure with its defaults, into the folder FILE "
        "(two or three minutes)",
    )
    add_argument(
        "--format", choices=FORMATS, help="what to write with --all; png by default"
    )


def check(args) -> str | None:
    """What is wrong with the words after `figure`, None if nothing is."""
    if args.list:
        return None
    if not args.id and (other := [word for word in args.set if "=" not in word]):
        return SWALLOWED.format(other[0])
    if not args.output or bool(args.id) == args.all:
        return WANTED
    if (args.all and (args.set or args.tracker)) or (args.format and not args.all):
        return APART
    if args.tracker and any(word.startswith("tracker=") for word in args.set):
        return TWICE
    return None


def run(args) -> None:
    """Draw one figure or all of them into files, or list what there is."""
    from mkt.course import figure_arguments
    from mkt.figures import export
    from mkt.figures.registry import FIGURES

    if args.list:
        print(figure_arguments.listing(args.id))
        return
    if args.all:
        export.write_all(FIGURES.values(), args.output, args.format or "png")
    else:
        entry = FIGURES[args.id]
        parameters = figure_arguments.parameters(entry, args.set)
        if args.tracker:
            entry, own = figure_arguments.own_tracker(entry, args.tracker)
            parameters |= own
        export.write(entry, args.output, parameters)
    print(args.output)
