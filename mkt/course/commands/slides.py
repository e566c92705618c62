"""``slides`` makes slides for a meeting of the chapters and their figures."""

from mkt.course.commands import Commands, command, named_path


def add(commands: Commands) -> None:
    """Describe the command."""
    parser = command(
        commands,
        "slides",
        run,
        "make slides of chapters, for a meeting",
        "Writes an HTML file for each chapter: its question, goals, equations,\n"
        "predictions with their figures, and takeaways, as they stand in the chapter.\n"
        "Arrow keys turn the slides, and the browser's Print makes a PDF of them.\n"
        "Without numbers it takes the first chapter of each part.",
        "slides -o slides",
        "slides 5 6 -o slides",
        clone=True,
    )
    parser.set_defaults(check=check)
    parser.add_argument("names", nargs="*", metavar="N", help="the number of a chapter")
    parser.add_argument(
        "-o",
        "--output",
        type=named_path,
        required=True,
        metavar="FOLDER",
        help="where to; no file in it is overwritten",
    )


def check(args) -> str | None:
    """What is wrong with the numbers, None if nothing."""
    for word in args.names:
        if not word.isdecimal():
            return f"{word!r} is no number of a chapter; give one such as 5"
    return None


def run(args) -> None:
    """Write the slides and say where they are."""
    from mkt.course import slides
    from mkt.course.book import contents

    book = contents.read()
    chapters = slides.chosen(book, [int(word) for word in args.names])
    for path in slides.write(book, chapters, args.output):
        print(path)
