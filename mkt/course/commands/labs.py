"""``labs`` hands out the labs of the course, checks one, or grades many."""

import os
import sys
import time
from argparse import ArgumentTypeError
from pathlib import Path

from mkt.course.commands import Commands, command, named_path
from mkt.course.labs import LIMIT

EXECUTES = "It executes the students' code"

DESCRIPTION = (
    "`release` writes the students' version of every lab of notebooks/labs into a\n"
    "folder: without solutions and hidden checks.  A file that is there already\n"
    "stays as it is: there may be work in it.\n"
    "`handout` writes a folder and a zip for students who have nothing yet: the\n"
    "library, the chapters and the labs, without solutions and hidden checks.\n"
    "`nbgrader` writes a course for those who grade with nbgrader.\n"
    "`check` runs your notebook and says in words what its checks found; start it\n"
    "whenever you like.\n"
    "`grade` runs what the students handed in, with the hidden checks, and writes\n"
    "a table with a row for each file, and for each student without any, and a\n"
    "page for each student beside it.  Started again it goes on where it was\n"
    "stopped.  Type the points of what a person reads into the table;\n"
    "`grade --merge` sums up.\n"
    f"{EXECUTES} in bubblewrap's box, without network and\n"
    "without your files, and nowhere else unless you say so."
)


def add(commands: Commands) -> None:
    """Describe the command and its actions."""
    parser = command(
        commands,
        "labs",
        run,
        "hand out the labs, check one, or grade them",
        DESCRIPTION,
        "labs release",
        "labs handout -o ../course",
        "labs nbgrader -o mkt-course",
        "labs check notebooks/handout/lab_1_histograms_and_kernels.ipynb",
        "labs grade submitted -o grades.csv",
        "labs grade --merge -o grades.csv",
        clone=True,
    )
    parser.set_defaults(check=check_words)
    actions = parser.add_subparsers(dest="what", metavar="ACTION", required=True)
    _add_release(actions)
    _add_handout(actions)
    check = actions.add_parser(
        "check", help="run one notebook and explain what its checks found"
    )
    check.add_argument(
        "path",
        type=Path,
        metavar="FILE",
        help="your notebook, saved; of one in notebooks/handout its name will do",
    )
    grade = _add_grade(actions)
    for action in (check, grade):
        action.add_argument(
            "--limit",
            type=_seconds,
            default=LIMIT,
            metavar="S",
            help="seconds that a cell or a check may take, %(default)s by default; an "
            "endless loop costs as many for each check that calls it",
        )


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0
    if not 0 < value < float("inf"):
        raise ArgumentTypeError(f"{text!r} is not a number of seconds above 0")
    return value


def _table(text: str) -> Path:
    """The path of a table; a spreadsheet would take other names for its own files."""
    path = named_path(text)
    if path.suffix.lower() != ".csv":
        raise ArgumentTypeError(f"{text}: give a name that ends in .csv")
    return path


def check_words(args) -> str | None:
    """What is wrong with words that make no sense together, or None."""
    if args.what != "grade":
        return None
    if not args.merge:
        missing = "name the FOLDER with what was handed in, or say --merge"
        return None if args.path else missing
    running = {
        "FOLDER": args.path,
        "--limit": args.limit != LIMIT,
        "--separator": args.separator,
        "--trust-the-students": args.trust_the_students,
    }
    words = ", ".join(word for word, said in running.items() if said)
    return f"--merge runs nothing and takes no {words}" if words else None


def _add_release(actions: Commands) -> None:
    release = actions.add_parser(
        "release", help="write the students' version of every lab"
    )
    release.add_argument(
        "-o",
        "--output",
        type=named_path,
        metavar="FOLDER",
        help="where to; notebooks/handout by default, where JupyterLab shows them",
    )


def _add_handout(actions: Commands) -> None:
    handout = actions.add_parser(
        "handout", help="write a folder and a zip that students can start from"
    )
    nbgrader = actions.add_parser(
        "nbgrader", help="write a course for nbgrader: its configuration, and sources"
    )
    for action, more in ((handout, ", and FOLDER.zip neither"), (nbgrader, "")):
        action.add_argument(
            "-o",
            "--output",
            type=named_path,
            required=True,
            metavar="FOLDER",
            help=f"where to; it must not be there yet{more}",
        )


def _add_grade(actions: Commands):
    grade = actions.add_parser(
        "grade",
        help="grade a folder of notebooks, executing them",
        description=f"{EXECUTES} in bubblewrap's box.",
    )
    grade.add_argument(
        "path",
        type=Path,
        metavar="FOLDER",
        nargs="?",
        help="nbgrader's submitted/, with STUDENT/LAB/LAB.ipynb in it; or "
        "STUDENT/LAB.ipynb, or STUDENT_LAB.ipynb, or LAB_STUDENT.ipynb",
    )
    grade.add_argument(
        "-o",
        "--output",
        type=_table,
        default=Path("grades.csv"),
        metavar="FILE.csv",
        help="table to write, or to go on with; ./grades.csv by default",
    )
    grade.add_argument(
        "--merge",
        action="store_true",
        help="run nothing: sum up the table with the points that you have typed",
    )
    grade.add_argument(
        "--separator",
        choices=(",", ";", "tab"),
        help="between the cells of the table: as in one that is there, or a comma; "
        "a German spreadsheet wants ';'",
    )
    grade.add_argument(
        "--trust-the-students",
        action="store_true",
        help="run their code as you, with your files and the network",
    )
    return grade


def run(args) -> int | None:
    """Do what was asked: exit code 1 where a check found something."""
    actions = {
        "release": _release,
        "handout": _handout,
        "nbgrader": _nbgrader,
        "check": _check,
        "grade": _grade,
    }
    return actions[args.what](args)


def _release(args) -> None:
    from mkt.course.labs import notebooks

    folder = args.output or notebooks.HANDOUT
    for path, written in notebooks.release(folder).items():
        stays = (
            f"{path} is there already and stays as it is, perhaps with work in it; "
            "for a fresh one rename it first"
        )
        print(path if written else stays)


def _handout(args) -> None:
    from mkt.course.labs import handout

    for path in handout.write(args.output):
        print(path)


def _nbgrader(args) -> None:
    from mkt.course.labs import notebooks

    for path in notebooks.for_nbgrader(args.output):
        print(path)


def _check(args) -> int:
    from mkt.course.labs import checking

    saved = time.localtime(checking.found(args.path).stat().st_mtime)
    print(
        f"as it was saved at {time.strftime('%H:%M:%S', saved)}; what does not end is "
        f"stopped after {args.limit:g} s (--limit), once for each check that calls it",
        file=sys.stderr,
    )
    lines, passed = checking.check(args.path, args.limit)
    for line in lines:
        print(line)
    return 0 if passed else 1


def _grade(args) -> int:
    from mkt.course.labs import grading, pages

    troubles = []
    if not args.merge and os.name == "posix" and os.geteuid() == 0:
        print("grading as root, which SECURITY.md advises against", file=sys.stderr)
    if args.merge:
        grading.merge(args.output)
    else:
        troubles = grading.grade(
            args.path,
            args.output,
            args.limit,
            trusted=args.trust_the_students,
            comma="\t" if args.separator == "tab" else args.separator,
        )
    print(args.output)
    print(pages.folder_of(args.output))
    for trouble in troubles:
        print(trouble)
    return 1 if troubles else 0
