"""The commands of ``python3 -m mkt``.  Nothing heavy is imported before a command runs, so that --help needs no installed package."""

import argparse
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
NOTEBOOKS, LAB_SETTINGS = ROOT / "notebooks", ROOT / "mkt" / "jupyterlab"
HANDING_ON = ("test", "lab")  # commands whose unknown arguments go to pytest and to JupyterLab
NOTE = "The first command sets up .venv from environment.txt (a minute or two; with uv installed, seconds)."


def parser():
    """The `argparse.ArgumentParser` of all commands."""
    top = argparse.ArgumentParser(prog="python3 -m mkt", epilog=NOTE,
                                  description="Multiple kernel tracking: the library, its book and its tests.")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True)
    _command(commands, "book", run_book, "execute the notebooks and build the book",
             "Executes every notebook of book.toml that changed and builds the site into _build/html; open _build/html/index.html.")
    test = _command(commands, "test", run_tests, "run the tests", "Runs pytest.  Everything after `test` is handed to it.",
                    "test", "test -k widgets", "test tests/test_regions.py -x -n 0")
    test.usage = "python3 -m mkt test [-h] [PYTEST ARGUMENT ...]"
    lab = _command(commands, "lab", run_lab, "open the notebooks in JupyterLab",
                   "Opens JupyterLab on the folder notebooks/ in your browser; Ctrl-C ends it.  Everything after `lab` is handed to it.",
                   "lab", "lab --no-browser --port 9000")
    lab.usage = "python3 -m mkt lab [-h] [JUPYTERLAB ARGUMENT ...]"
    _figure_arguments(_command(commands, "figure", run_figure, "draw one figure into a file, or all",
                               "Draws a registered figure with its defaults, or your values; or writes its curves as a table.  Parameters, versions and data\n"
                               "are in the file: a PDF's properties, a PNG's text, an SVG's metadata, the first lines of a CSV.",
                               "figure --list", "figure teuliere2009.fig6 --list", "figure teuliere2009.fig3 -o fig3.pdf",
                               "figure teuliere2009.fig6 -o fig6.csv --set particles=100 --set seed=1", "figure --all -o figures --format pdf"))
    _claims_arguments(_command(commands, "claims", run_claims, "put the papers' claims to the test",
                               "Runs the trackers over many seeds, on all cores, and judges each claim: some ten minutes for all of them on two cores.\n"
                               "Runs that are known are not done again.",
                               "claims --list", "claims", "claims T09-c T09-d --seeds 48", "claims -o claims.csv"))
    _track_arguments(_command(commands, "track", run_track, "track an object in a video of your own",
                              "Follows what is inside a box of the first frame, and writes the video with what was found drawn into it (green; dashed red\n"
                              "where the tracker says that it lost it), a table beside it (.csv), and the settings that give the same track again (.json).\n"
                              "Without --box it shows the first frame under a grid, to read the box off.  Ctrl-C ends it and keeps what was done so far.",
                              "track ball.mp4", "track ball.mp4 --box 120,80,60,40",
                              "track holiday/ --box 120,80,60,40,-30 --tracker combined --particles 200 -o found.avi", "track --settings found.json"))
    _bench_arguments(_command(commands, "bench", run_bench, "time the core, or rank the trackers",
                              "Without a word, prints CPU milliseconds of the hot loop and its rivals (median, one thread) side by side, with ratios.\n"
                              "With `tracking`, runs all trackers on all benchmark sequences that are found (see `python3 -m mkt data`), on our synthetic ones\n"
                              "if there are none, and prints who follows best.  Runs that are known are not done again; Ctrl-C loses only those under way.",
                              "bench", "bench tracking", "bench tracking guided pf-75 --seeds 10 -o runs.csv", "bench tracking -o table.md"))
    data = _command(commands, "data", run_data, "list the benchmarks, or check those that are there",
                    "Lists the benchmarks that can be used, where each is expected, what is there, its licence, and how to get it.\n"
                    "With `check`, opens every sequence that is there and says what is wrong with it.", "data", "data check")
    data.add_argument("check", nargs="?", choices=["check"], help="open every sequence that is there")
    _command(commands, "doctor", run_doctor, "say what is wrong with this machine",
             "Looks at Python, the environment, its packages, video formats, JupyterLab's widgets and data sets, and says how to mend what is wrong.")
    _labs_arguments(_command(commands, "labs", run_labs, "hand out the labs, check one, or grade them",
                             "`release` writes the students' version of every lab of notebooks/labs into a folder: without solutions and hidden checks.\n"
                             "A file that is there already stays as it is: there may be work in it.\n"
                             "`check` runs your notebook and says in words what its checks found; start it whenever you like.\n"
                             "`grade` runs what the students handed in, with the hidden checks, and writes a new table with a row for each file.\n"
                             "It notes checks that can no longer fail, but is not proof against intent.\n"
                             "It executes the students' code on this machine, as you: do it where you would run a stranger's program.",
                             "labs release", "labs check notebooks/handout/lab_1_histograms_and_kernels.ipynb", "labs grade submitted -o grades.csv"))
    _command(commands, "strip", run_strip, "remove outputs from the notebooks",
             "Removes outputs and execution counts from the notebooks of book.toml and from the labs, as they are to be committed.")
    return top


def _command(commands, name, action, summary, text, *examples):
    lines = "\n".join(f"  python3 -m mkt {example}" for example in examples or (name,))
    sub = commands.add_parser(name, help=summary, description=text, epilog=f"examples:\n{lines}",
                              formatter_class=argparse.RawDescriptionHelpFormatter)
    sub.set_defaults(action=action)
    return sub


def _figure_arguments(sub):
    sub.add_argument("id", nargs="?", metavar="ID", help="paper and figure, such as teuliere2009.fig3")
    sub.add_argument("-o", "--output", type=Path, metavar="FILE", help="file to write: .png, .pdf, .svg, or .csv for a table of its curves; with --all a folder")
    sub.add_argument("--set", nargs="+", action="extend", default=[], metavar="NAME=VALUE", help="parameters that differ from the defaults")
    sub.add_argument("--list", action="store_true", help="list the figures, or with ID its parameters, and stop")
    sub.add_argument("--all", action="store_true", help="draw every figure with its defaults, into the folder FILE (two or three minutes)")
    sub.add_argument("--format", choices=["png", "pdf", "svg", "csv"], help="what to write with --all; png by default")


def _claims_arguments(sub):
    sub.add_argument("ids", nargs="*", metavar="ID", help="claims such as T09-c; all by default")
    sub.add_argument("--list", action="store_true", help="list the claims, and stop")
    sub.add_argument("--seeds", type=int, metavar="N", help="how many sequences of each scenario; 16 by default, at least 6")
    sub.add_argument("-o", "--output", type=Path, metavar="FILE", help="also write the numbers into this CSV file")


def _bench_arguments(sub):
    sub.add_argument("what", nargs="?", choices=["core", "tracking"], default="core", help="what to measure; core by default")
    sub.add_argument("names", nargs="*", metavar="TRACKER", help="trackers such as guided; all by default")
    sub.add_argument("--seeds", type=int, metavar="N", help="runs of each tracker that draws random numbers on each sequence; 5 by default")
    sub.add_argument("-o", "--output", type=Path, metavar="FILE", help="also write a row for each run (.csv), or the tables (.md)")


def _track_arguments(sub):
    sub.add_argument("video", nargs="?", metavar="VIDEO", help="a video file, or a folder of images")
    sub.add_argument("--box", metavar="X,Y,W,H[,ANGLE]", help="where the target is in the first frame: upper left corner, width and height [px], "
                     "and, if you like, a clockwise rotation about its centre [degrees]")
    sub.add_argument("--tracker", default="guided", metavar="NAME", help="guided (the default), combined, ssd, mil, ...; a wrong name lists all")
    sub.add_argument("--particles", type=int, metavar="N", help="number of particles; the tracker's own by default")
    sub.add_argument("--seed", type=int, default=0, metavar="S", help="of the tracker's chance (0); the same seed gives the same track")
    sub.add_argument("--settings", type=Path, metavar="FILE", help="track again as this .json file says, which an earlier run wrote; with VIDEO if that has moved")
    sub.add_argument("-o", "--output", type=Path, metavar="FILE", help="video to write: .webm, .mkv (lossless) or .avi; VIDEO-NAME.webm by default")


def _labs_arguments(sub):
    actions = sub.add_subparsers(dest="what", metavar="ACTION", required=True)
    release = actions.add_parser("release", help="write the students' version of every lab")
    release.add_argument("-o", "--output", type=Path, metavar="FOLDER", help="where to; notebooks/handout by default, where JupyterLab shows them")
    check = actions.add_parser("check", help="run one notebook and explain what its checks found")
    check.add_argument("path", type=Path, metavar="FILE", help="your notebook, saved; of one in notebooks/handout its name will do")
    grade = actions.add_parser("grade", help="grade a folder of notebooks, executing them", description="It executes the students' code on this machine, as you.")
    grade.add_argument("path", type=Path, metavar="FOLDER", help="nbgrader's submitted/, with STUDENT/LAB/LAB.ipynb in it; or STUDENT/LAB.ipynb, or STUDENT_LAB.ipynb")
    grade.add_argument("-o", "--output", type=Path, default=Path("grades.csv"), metavar="FILE", help="table to write, which must not be there yet; ./grades.csv by default")
    for action in (check, grade):
        action.add_argument("--limit", type=float, default=60, metavar="S", help="seconds that a cell may take, 60 by default; an endless loop costs as many for each cell that calls it")


def parse(arguments):
    """Parse a list of command-line words.  Exits with a message when they make no sense, or after --help."""
    top = parser()
    if not arguments:
        top.print_help()
        sys.exit(2)
    args, rest = top.parse_known_args(arguments)
    if rest and args.command not in HANDING_ON:
        top.error(f"unrecognized arguments: {' '.join(rest)}")
    if args.command == "figure" and not args.list:
        _one_or_all(top, args)
    if args.command == "bench" and args.what == "core" and (args.seeds is not None or args.output):
        top.error("--seeds and -o go with `bench tracking`")
    if args.command == "track":
        _agree(top, args)
    args.rest = rest
    return args


def _agree(top, args):
    """A video, or settings that name one and leave nothing to say."""
    if args.settings is None and args.video is None:
        top.error("track needs a VIDEO, or --settings FILE")
    if args.settings and (args.box, args.tracker, args.particles, args.seed) != (None, "guided", None, 0):
        top.error("--settings says box, tracker, particles and seed; leave these out, or change them in a copy of the file")


def _one_or_all(top, args):
    """Ends the program where the words after `figure` ask for neither one figure nor all, or for both."""
    if not args.output or bool(args.id) == args.all:
        top.error("figure needs an ID and -o FILE, or --all and -o FOLDER; `python3 -m mkt figure --list` lists the figures")
    if args.all and args.set or args.format and not args.all:
        top.error("--set goes with one figure, --format with --all; one figure's format is the ending of its file")


def run(args):
    """Run a parsed command; returns the exit code."""
    return args.action(args)


def run_book(args):
    """Build the book and say where it is."""
    from mkt import book

    try:
        print(f"The book is ready: open {book.build().as_uri()}")
    except (book.BookError, OSError) as error:
        sys.exit(str(error))


def run_tests(args):
    """Run pytest on the checkout."""
    import pytest

    os.chdir(ROOT)
    return pytest.main(args.rest)


def run_lab(args):
    """Open JupyterLab on the notebooks, with our settings: it asks nobody about news."""
    from jupyterlab.labapp import main

    return main([f"--ServerApp.root_dir={NOTEBOOKS}", f"--LabApp.app_settings_dir={LAB_SETTINGS}", *args.rest])


def run_figure(args):
    """Draw one figure or all of them into files, or list what there is."""
    from mkt import export, figures
    from mkt.figures import words

    try:
        if args.list:
            return print(words.listing(args.id))
        if args.all:
            export.write_all(figures.registry().values(), args.output, args.format or "png")
        else:
            entry = figures.get(args.id)
            export.write(entry, args.output, words.parameters(entry, args.set))
    except (KeyError, ValueError, OSError) as error:
        sys.exit(f"mkt figure: {error.args[0] if isinstance(error, KeyError) else error}")
    print(args.output)


def run_claims(args):
    """Judge claims, print them, and write them into a file if asked to."""
    from mkt import claims, sweeps
    from mkt.claims import listing

    if args.list:
        return print(*(f"{claim.id}  {claim.sentence}" for claim in claims.registry().values()), sep="\n")
    try:
        if args.output and not args.output.parent.is_dir():  # said before the long work, not after it
            raise FileNotFoundError(f"no folder {args.output.parent} for {args.output.name}; make it first")
        results = claims.judge(args.ids, claims.SEEDS if args.seeds is None else args.seeds)
        print(listing.as_text(results))
        if args.output:
            sweeps.table(listing.as_rows(results), args.output)
    except (KeyError, ValueError, OSError) as error:
        sys.exit(f"mkt claims: {error.args[0] if isinstance(error, KeyError) else error}")


def run_track(args):
    """Track in a video of the user's own, or show its first frame to read a box off."""
    from mkt import recording, settings
    from mkt.datasets import video

    try:
        if args.settings is None and args.box is None:
            settings.with_numbers(args.tracker, _particles(args))  # a wrong name is said now, not after the box was read off
            print(recording.ask_for_box(video(args.video), _output(args, args.video)), file=sys.stderr)
            return 2
        chosen = settings.load(args.settings, args.video) if args.settings else _settled(args)
        output = _output(args, chosen.video)
        clip = chosen.sequence()
        done = recording.record(chosen.configured(), clip, output, chosen.seed, title=chosen.tracker)
        chosen.save(output.with_suffix(".json"))
    except (KeyError, ValueError, OSError) as error:
        sys.exit(f"mkt track: {error.args[0] if isinstance(error, KeyError) else error}")
    print(output, output.with_suffix(".csv"), output.with_suffix(".json"), sep="\n")
    if args.settings and settings.drift(chosen):
        print(f"the track may differ in its last digits: {settings.drift(chosen)}", file=sys.stderr)
    if done < len(clip):
        print(f"stopped: {done} of {len(clip)} frames are in both, up to frame {done - 1}", file=sys.stderr)
        return 130


def _settled(args):
    from mkt import settings

    return settings.settled(args.video, settings.parse_box(args.box), args.tracker, _particles(args), args.seed)


def _particles(args):
    return {} if args.particles is None else {"n": args.particles}


def _output(args, source):
    """Where the video goes: -o, or a name made from what is tracked, in the folder where the command runs."""
    from mkt.recording import checked_output

    name = f"{args.settings.stem}-again" if args.settings else f"{Path(source).resolve().stem}-{args.tracker}"
    return checked_output(args.output or f"{name}.webm", source)


def run_bench(args):
    """Print the benchmark of the core, or that of the trackers."""
    if args.what == "tracking":
        return run_bench_tracking(args)
    from mkt import bench

    return bench.main()


def run_bench_tracking(args):
    """Rank the trackers, print the tables, and write them or the runs into a file if asked to."""
    from mkt import leaderboard, sweeps
    from mkt.files import whole

    try:
        if args.output and not (args.output.parent.is_dir() and args.output.suffix in (".csv", ".md")):
            raise ValueError(f"-o {args.output}: give a name that ends in .csv or .md, in a folder that exists")
        seeds = leaderboard.SEEDS if args.seeds is None else args.seeds
        boards, troubles = leaderboard.recorded(args.names, seeds)
        board = boards[0] if boards else leaderboard.synthetic(args.names, seeds)
        text = leaderboard.as_markdown(board)
        print(text)
        if args.output and args.output.suffix == ".csv":
            sweeps.table(board.rows, args.output)
        elif args.output:
            with whole(args.output) as half:
                half.write_text(text + "\n", encoding="utf-8")
    except (KeyError, ValueError, OSError) as error:
        sys.exit(f"mkt bench: {error.args[0] if isinstance(error, KeyError) else error}")
    for trouble in troubles:
        print(f"left out: {trouble}", file=sys.stderr)


def run_data(args):
    """List the benchmarks, or check what is there: exit code 1 where something is wrong."""
    from mkt import archives

    try:
        if not args.check:
            return print(archives.listing())
        good, troubles = archives.usable()
    except ValueError as error:
        sys.exit(f"mkt data: {error}")
    print(*(f"{found.name}: {words}" for found, words in good.items()), *(f"wrong: {trouble}" for trouble in troubles), sep="\n")
    print(f"{len(good)} sequences can be used, {len(troubles)} cannot" if good or troubles else "nothing is there; `python3 -m mkt data` says what could be")
    return 1 if troubles else 0


def run_doctor(args):
    """Print what is wrong and how to mend it: exit code 1 where something is."""
    from mkt import doctor

    return doctor.main()


def run_labs(args):
    """Release, check or grade labs: exit code 1 where a check found something."""
    from mkt.labs import grading, notebooks

    try:
        if args.what == "release":
            for path, written in notebooks.release(args.output or notebooks.HANDOUT).items():
                print(path if written else f"{path} is there already and stays as it is, perhaps with work in it; for a fresh one rename it first")
            return None
        if args.what == "grade":
            grading.grade(args.path, args.output, args.limit)
            return print(args.output)
        lines, passed = grading.check(args.path, args.limit)
    except (ValueError, OSError) as error:
        sys.exit(f"mkt labs: {error}")
    print(*lines, sep="\n")
    return 0 if passed else 1


def run_strip(args):
    """Strip the notebooks and name those that changed."""
    from mkt import book

    try:
        for path in book.strip_all():
            print(f"stripped {os.path.relpath(path)}")
    except book.BookError as error:
        sys.exit(f"mkt strip: {error}")
