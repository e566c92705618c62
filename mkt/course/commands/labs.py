"""``labs`` hands out the labs of the course, checks one, or grades many."""

from pathlib import Path

from mkt.course.commands import Commands, command

EXECUTES = "It executes the students' code on this machine, as you"


def add(commands: Commands) -> None:
    """Describe the command and its three actions."""
    parser = command(
        commands,
        "labs",
        run,
        "hand out the labs, check one, or grade them",
        "`release` writes the students' version of every lab of notebooks/labs into a\n"
        "folder: without solutions and hidden checks.  A file that is there already\n"
        "stays as it is: there may be work in it.\n"
        "`check` runs your notebook and says in words what its checks found; start it\n"
        "whenever you like.\n"
        "`grade` runs what the students handed in, with the hidden checks, and writes\n"
        "a new table with a row for each file.  It notes checks that can no longer\n"
        "fail, but is not proof against intent.\n"
        f"{EXECUTES}: do it where you would run a\nstranger's program.",
        "labs release",
        "labs check notebooks/handout/lab_1_histograms_and_kernels.ipynb",
        "labs grade submitted -o grades.csv",
    )
    actions = parser.add_subparsers(dest="what", metavar="ACTION", required=True)
    _add_release(actions)
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
            type=float,
            default=60,
            metavar="S",
            help="seconds that a cell may take, 60 by default; an endless loop costs "
            "as many for each cell that calls it",
        )


def _add_release(actions: Commands) -> None:
    release = actions.add_parser(
        "release", help="write the students' version of every lab"
    )
    release.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FOLDER",
        help="where to; notebooks/handout by default, where JupyterLab shows them",
    )


def _add_grade(actions: Commands):
    grade = actions.add_parser(
        "grade",
        help="grade a folder of notebooks, executing them",
        description=f"{EXECUTES}.",
    )
    grade.add_argument(
        "path",
        type=Path,
        metavar="FOLDER",
        help="nbgrader's submitted/, with STUDENT/LAB/LAB.ipynb in it; or "
        "STUDENT/LAB.ipynb, or STUDENT_LAB.ipynb",
    )
    grade.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("grades.csv"),
        metavar="FILE",
        help="table to write, which must not be there yet; ./grades.csv by default",
    )
    return grade


def run(args) -> int | None:
    """Release, check or grade labs: exit code 1 where a check found something."""
    return {"release": _release, "check": _check, "grade": _grade}[args.what](args)


def _release(args) -> None:
    from mkt.course.labs import notebooks

    folder = args.output or notebooks.HANDOUT
    for path, written in notebooks.release(folder).items():
        stays = (
            f"{path} is there already and stays as it is, perhaps with work in it; "
            "for a fresh one rename it first"
        )
        print(path if written else stays)


def _check(args) -> int:
    from mkt.course.labs import grading

    lines, passed = grading.check(args.path, args.limit)
    for line in lines:
        print(line)
    return 0 if passed else 1


def _grade(args) -> None:
    from mkt.course.labs import grading

    grading.grade(args.path, args.output, args.limit)
    print(args.output)
