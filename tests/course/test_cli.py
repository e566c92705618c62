"""The command line: help without a package, mistakes answered in a sentence."""

import os
import shutil
import subprocess
import sys
import tempfile
from types import SimpleNamespace

import nbformat
import pytest

import mkt
from mkt import files
from mkt.course import cli
from mkt.course.commands import lab
from mkt.course.figure_arguments import parameters
from mkt.figures.registry import FIGURES
from mkt.files import ROOT

COMMANDS = (
    "book",
    "test",
    "lab",
    "figure",
    "claims",
    "track",
    "bench",
    "data",
    "labs",
    "doctor",
    "strip",
)
FIGURE = "teuliere2009.fig2"


def bare(*words):
    """Run the program on a Python that sees no installed package."""
    return subprocess.run(
        [sys.executable, "-S", "-m", "mkt", *words],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
    )


THREADS = """
import os, sys
from types import SimpleNamespace
from mkt.course import cli

def show(args):
    import cv2, numpy
    from threadpoolctl import threadpool_info
    pools = [pool["num_threads"] for pool in threadpool_info()]
    print(*{cv2.getNumThreads(), *pools}, *{*cli.ONE_THREAD} & {*os.environ})

cli.run(SimpleNamespace(command=sys.argv[1], clone=False, run=show))
"""


def threads(command):
    """The numbers of threads in a command, and which variables it has set for them."""
    done = subprocess.run(
        [sys.executable, "-c", THREADS, command],
        cwd=ROOT,
        env={k: v for k, v in os.environ.items() if k not in cli.ONE_THREAD},
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    return {*done.stdout.split()}


def test_commands_of_many_processes_compute_on_one_thread():
    assert threads("book") == {"1", *cli.ONE_THREAD}
    assert not threads("track") & {*cli.ONE_THREAD}


def run(*words):
    """Run a command; returns its exit code, 0 for None."""
    return cli.run(cli.parse([*map(str, words)])) or 0


def test_help_needs_no_package():
    result = bare("--help")
    assert result.returncode == 0
    assert all(f"    {command} " in result.stdout for command in COMMANDS)


def test_a_reader_who_has_read_enough_is_no_error():
    program = subprocess.Popen(
        [sys.executable, "-m", "mkt", "data"],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    program.stdout.close()  # as `| head -0` does, before a word was printed
    assert program.stderr.read() == "" and program.wait(60) == 1


@pytest.mark.slow
def test_what_is_to_be_written_is_written_though_nobody_reads_on(tmp_path):
    program = subprocess.Popen(
        [sys.executable, "-u", "-m", "mkt", "claims", "--shipped", "-o", "c.csv"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    program.stdout.close()
    assert program.stderr.read() == "" and program.wait(60) == 1
    assert (tmp_path / "c.csv").read_text().startswith("claim,")


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself_with_examples(command, capsys):
    with pytest.raises(SystemExit) as stopped:
        cli.parse([command, "--help"])
    assert stopped.value.code == 0
    assert f"examples:\n  python3 -m mkt {command}" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["figure", "bench", "claims"])
def test_a_command_that_replaces_a_file_says_so(command, capsys):
    with pytest.raises(SystemExit):
        cli.parse([command, "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert "a file that is there is replaced" in said


@pytest.mark.parametrize(
    "words, said",
    [
        ((), "usage:"),
        (("nope",), "invalid choice"),
        (("book", "--fast"), "unrecognized arguments: --fast"),
        (("figure",), "needs an ID and -o FILE"),
        (("bench", "--seeds", "0:3"), "go with `bench tracking`"),
        (("bench", "core", "guided"), "bench core takes no names"),
        (("labs", "release", "-o", ""), "the name is empty"),
        (("slides", "1", "-o", ""), "the name is empty"),
        (("figure", "--all", "-o", ""), "the name is empty"),
        (("bench", "tracking", "--tracks", ""), "the name is empty"),
    ],
)
def test_a_mistyped_command_is_refused_before_anything_is_installed(words, said):
    result = bare(*words)
    assert result.returncode == 2
    assert said in result.stdout + result.stderr


def test_arguments_after_test_and_lab_are_handed_on_in_order():
    words = ["-k", "widgets", "tests/test_cli.py", "-x"]
    assert cli.parse(["test", *words]).rest == words
    assert cli.parse(["lab", "--no-browser"]).rest == ["--no-browser"]


@pytest.fixture
def jupyterlab(monkeypatch):
    """The words that JupyterLab is opened with; git hears nothing."""
    given = []
    made_up = SimpleNamespace(main=given.extend)
    monkeypatch.setitem(sys.modules, "jupyterlab.labapp", made_up)
    monkeypatch.setattr(lab, "_tell_git", lambda: None)
    monkeypatch.setattr(lab.os, "geteuid", lambda: 1000, raising=False)
    return given


def test_jupyterlab_is_opened_on_the_chapters_with_our_settings(jupyterlab):
    assert run("lab", "--no-browser") == 0
    assert jupyterlab[0] == f"--ServerApp.root_dir={ROOT / 'notebooks'}"
    assert jupyterlab[1].startswith("--LabApp.app_settings_dir=")
    assert jupyterlab[2:] == [
        "--LabApp.default_url=/lab/tree/01_color_histograms.ipynb",
        "--no-browser",
    ]
    assert list(lab.SETTINGS.glob("*.json"))


def test_root_is_told_what_to_do(jupyterlab, monkeypatch):
    monkeypatch.setattr(lab.os, "geteuid", lambda: 0, raising=False)
    with pytest.raises(SystemExit, match="in a container of your own add --allow-root"):
        run("lab")
    assert run("lab", "--allow-root") == 0 and jupyterlab[-1] == "--allow-root"


def test_where_nothing_can_be_written_work_is_done_on_copies(
    jupyterlab, monkeypatch, tmp_path
):
    monkeypatch.setattr(lab.os, "access", lambda *_: False)
    monkeypatch.setattr(lab.Path, "home", lambda: tmp_path)
    own = tmp_path / "mkt-notebooks"
    for _ in range(2):  # the second time there is work in one
        run("lab")
        assert f"--ServerApp.root_dir={own}" in jupyterlab
        texts = (*lab.NOTEBOOKS.glob("*.ipynb"), *lab.NOTEBOOKS.glob("*.md"))
        assert {path.name for path in own.iterdir()} == {path.name for path in texts}
        (own / lab.FIRST).write_text("work")
    run("lab")
    assert (own / lab.FIRST).read_text() == "work"


def test_half_a_copy_of_a_notebook_does_not_stay(monkeypatch, tmp_path):
    def torn(source, target):
        target.write_bytes(source.read_bytes()[:1000])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(lab.os, "access", lambda *_: False)
    monkeypatch.setattr(lab.Path, "home", lambda: tmp_path)
    monkeypatch.setattr(lab.shutil, "copyfile", torn)
    with pytest.raises(OSError, match="No space left"):
        lab.writable()
    assert not list((tmp_path / "mkt-notebooks").glob("*.ipynb"))


def test_a_broken_opencv_is_told_by_the_one_door_out(tmp_path):
    (tmp_path / "cv2").mkdir()
    broken = 'raise ImportError("libGL.so.1: cannot open shared object file")'
    (tmp_path / "cv2" / "__init__.py").write_text(broken)
    result = subprocess.run(
        [sys.executable, "-m", "mkt", "data"],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert result.returncode and "Traceback" not in result.stderr
    assert "mkt data: a fault of mkt itself (ImportError)" in result.stderr


def test_a_chapter_that_was_run_is_no_change_for_git(tmp_path, monkeypatch):
    name = "notebooks/02_cost_surfaces.ipynb"
    for path in (name, ".gitattributes"):
        (tmp_path / path).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / path, tmp_path / path)

    def git(*words):
        known = ["git", "-c", "user.name=a", "-c", "user.email=a@b", "-C", tmp_path]
        of_nobody = {"GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_NOSYSTEM": "1"}
        variables = os.environ | {"PYTHONPATH": str(ROOT)} | of_nobody
        done = subprocess.run(
            [*known, *words], env=variables, capture_output=True, text=True, check=True
        )
        return done.stdout

    git("init", "-q")
    monkeypatch.setattr(lab, "ROOT", tmp_path)
    lab._tell_git()
    git("add", ".")
    git("commit", "-qm", "first")
    notebook = nbformat.read(tmp_path / name, 4)
    code = next(cell for cell in notebook.cells if cell.cell_type == "code")
    code.execution_count = 7
    code.outputs = [nbformat.v4.new_output("stream", text="words")]
    notebook.metadata.language_info.version = "3.99"
    nbformat.write(notebook, tmp_path / name)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    lab._tell_git()  # as at the end of a session
    assert git("diff") == git("diff", "--cached") == git("status", "--short") == ""
    code.source += "\n# a thought"
    nbformat.write(notebook, tmp_path / name)
    lab._tell_git()
    assert "a thought" in git("diff") and git("diff", "--cached") == ""


def test_notebooks_are_stored_as_they_are_written():
    """Or opening and saving one would be a change."""
    for path in sorted((ROOT / "notebooks").rglob("[0-9l]*.ipynb")):
        if "handout" not in path.parts and ".ipynb_checkpoints" not in path.parts:
            text = path.read_text(encoding="utf-8")
            assert nbformat.writes(nbformat.reads(text, 4)) == text.rstrip("\n"), path


@pytest.mark.parametrize(
    "ending, magic",
    [
        ("png", b"\x89PNG"),
        ("pdf", b"%PDF"),
        ("svg", b"<?xml"),
        ("csv", b"# Title: teuliere2009.fig2"),
    ],
)
def test_figure_writes_the_format_of_the_ending(tmp_path, ending, magic):
    path = tmp_path / f"figure.{ending}"
    changes = ["--set", "span=0.8", "layout=2x2"]
    assert run("figure", FIGURE, "-o", path, *changes) == 0
    assert path.read_bytes().startswith(magic)


PICTURE = (FIGURE, "-o", "x.png")
CROWD = ("nummiaro2003.fig5", "-o", "x.csv")
MISTAKES = [
    (
        ("ghosts", "-o", "x.png"),
        "no figure 'ghosts'; `python3 -m mkt figure --list` lists all",
    ),
    (
        ("fig6", "-o", "x.png"),
        "no figure 'fig6', perhaps teuliere2009.fig6 or nummiaro2003.fig6 "
        "or cordoba2014.fig6; `python3 -m mkt figure --list` lists all",
    ),
    (
        (*PICTURE, "--set", "spam=1"),
        "has no parameter 'spam'; it takes layout, span",
    ),
    ((*PICTURE, "--set", "span"), "'span' is not NAME=VALUE"),
    ((*PICTURE, "--set", "span=wide"), "not a number of type float"),
    ((*CROWD, "--set", "particles=9007199254740993"), "beyond 2^53; choose a smaller"),
    ((*CROWD, "--set", f"particles=-{10**400}"), "beyond 2^53; choose a smaller"),
    ((*PICTURE, "--set", "span=nan"), "span=nan: not a finite number"),
    (
        ("own.chance", "-o", "x.png", "--set", "epsilon=-1"),
        "epsilon is -1.0, a share in %; give 0 to 100",
    ),
    ((*PICTURE, "--set", "layout=5x5"), "choose from one, 2x2, 3x3"),
    (
        (FIGURE, "-o", "x.nonsense"),
        "x.nonsense: the ending says what to write; take one of .png, .pdf, .svg, .csv",
    ),
    (
        (FIGURE, "-o", "no/such/folder/x.png"),
        "no folder no/such/folder for x.png; make it first",
    ),
    (
        ("--all", "-o", "x.PNG"),
        "x.PNG: all figures go into a folder; give its name without .PNG, and say",
    ),
    (
        ("--all", "-o", f"{__file__}/x"),
        "x cannot be made a folder: Not a directory; give the name of another",
    ),
    (
        ("teuliere2009.fig8", "-o", "x.png", "--set", "frame=999", "features=exact"),
        "has no parameter 'features'",
    ),
    (
        ("own.run", "-o", "x.png", "--set", "spam=1"),
        "it takes frame, tracker, particles, scene, seed, n for particles",
    ),
    (
        ("own.resampling", "-o", "x.png", "--set", "n=0"),
        "own.resampling cannot be drawn with n=0: ",
    ),
]


@pytest.mark.parametrize("words, said", MISTAKES)
def test_a_wrong_figure_is_answered_in_a_sentence(words, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stopped:
        run("figure", *words)
    assert stopped.value.code.startswith("mkt figure: ")
    assert said in stopped.value.code
    assert not list(tmp_path.iterdir())


def test_names_may_stand_before_and_behind_options():
    words = "bench", "tracking", "ssd", "--seeds", "3:4", "wm", "mil"
    assert cli.parse(words).names == ["ssd", "wm", "mil"]
    words = "claims", "T09-c", "--list", "T09-d"
    assert cli.parse(words).names == ["T09-c", "T09-d"]
    assert cli.parse(["slides", "5", "-o", "x", "6"]).names == ["5", "6"]
    with pytest.raises(SystemExit):
        cli.parse(["bench", "tracking", "--sedes", "3:4", "wm"])
    with pytest.raises(SystemExit):
        cli.parse(["slides", "5", "-o", "x", "six"])


@pytest.mark.parametrize(
    "words, said",
    [
        (("claims", "T09-z"), "mkt claims: no claim 'T09-z'"),
        (("claims", "--list", "T09-z"), "mkt claims: no claim 'T09-z'"),
        (("bench", "tracking", "best"), "mkt bench: no tracker 'best'; there are "),
        (("bench", "tracking", "-o", "x.png"), "mkt bench: -o x.png: give a name "),
        (("claims", "-o", "no/x.csv"), "mkt claims: no folder no for x.csv; make it"),
        (("labs", "check", "none.ipynb"), "mkt labs: none.ipynb: there is no such"),
    ],
)
def test_every_other_command_names_itself_when_its_input_is_wrong(
    words, said, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stopped:
        run(*words)
    assert stopped.value.code.startswith(said)


def test_figure_takes_set_once_or_often_and_numbers_between_the_positions():
    once = ["--set", "particles=100", "threshold=0.5"]
    often = ["--set", "n=100", "--set", "threshold=0.5"]
    for words in once, often:
        args = cli.parse(["figure", "teuliere2009.fig6", "-o", "x.pdf", *words])
        chosen = parameters(FIGURES[args.id], args.set)
        assert chosen == {"particles": 100, "threshold": 0.5}
    # A length whose slider stands at whole pixels.
    chosen = parameters(FIGURES["teuliere2009.fig3"], ["extent=12.5"])
    assert chosen == {"extent": 12.5}
    words = ["fps=7.5", "compensation=off"]
    chosen = parameters(FIGURES["teuliere2009.fig10"], words)
    assert chosen == {"fps": 7.5, "compensation": "off"}
    for yes in ("True", "yes"):  # as Python writes it, and a page
        chosen = parameters(FIGURES["nummiaro2003.fig8"], [f"elliptic={yes}"])
        assert chosen == {"elliptic": True}


@pytest.mark.parametrize(
    "words, said",
    [
        (["--all"], "--all and -o FOLDER"),
        ([FIGURE, "--all", "-o", "x"], "--all and -o FOLDER"),
        ([FIGURE], "an ID and -o FILE"),
        (["--set", "a=1", FIGURE, "-o", "x.png"], "an ID stands before --set"),
        (["--all", "-o", "x", "--set", "a=1"], "--set goes with one figure"),
        ([FIGURE, "-o", "x.png", "--format", "pdf"], "--format with --all"),
        (
            ["own.run", "-o", "x.csv", "--tracker", "my:Own", "--set", "tracker=ssd"],
            "leave it out of --set",
        ),
    ],
)
def test_figure_is_asked_for_one_or_for_all(words, said, capsys):
    with pytest.raises(SystemExit):
        cli.parse(["figure", *words])
    assert said in capsys.readouterr().err


def test_figure_all_writes_every_figure(tmp_path, monkeypatch):
    two = {name: FIGURES[name] for name in ("own.root_locus", FIGURE)}
    monkeypatch.setattr(FIGURES, "_entries", two)
    folder = tmp_path / "new" / "folder"
    assert run("figure", "--all", "-o", folder, "--format", "pdf") == 0
    written = {path.name for path in folder.iterdir()}
    assert written == {"own.root_locus.pdf", f"{FIGURE}.pdf"}


def test_figure_list_names_every_figure_and_every_parameter(capsys):
    run("figure", "--list")
    listed = capsys.readouterr().out
    assert all(name in listed for name in FIGURES)
    run("figure", FIGURE, "--list")
    listed = capsys.readouterr().out
    assert "span=1.0    one of 0.4, 0.5" in listed
    assert "Numbers need not be" in listed and "n means" not in listed
    run("figure", "own.run", "--list")
    assert "n means particles" in capsys.readouterr().out


@pytest.mark.parametrize(
    "name, work", [("book", "mkt.course.book.build"), ("test", "pytest.main")]
)
def test_book_and_tests_are_made_by_one_program_at_a_time(
    name, work, tmp_path, monkeypatch
):
    taken = []

    def look(*_):
        with (tmp_path / f"{name}.lock").open("ab") as again:
            taken.append(not files._locked(again))
        return tmp_path

    monkeypatch.setattr(f"mkt.course.commands.{name}.BUILD", tmp_path)
    monkeypatch.setattr(work, look)
    monkeypatch.chdir(tmp_path)  # `test` goes to the clone
    run(name)
    assert taken == [True]


# The door


def broken(error):
    """A command that ends in an error, as parsed words."""

    def run(args):
        raise error

    return SimpleNamespace(command="figure", run=run, clone=False)


def test_a_fault_of_ours_is_a_sentence_and_a_log(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(sys, "argv", ["mkt", "figure", "caf\udce9"])
    with pytest.raises(SystemExit) as stopped:
        cli.run(broken(ZeroDivisionError("by nought")))
    [log] = tmp_path.iterdir()
    assert stopped.value.code == (
        f"mkt figure: a fault of mkt itself (ZeroDivisionError).  Please send {log} to "
        "those who look after it; SECURITY.md says where"
    )
    text = log.read_text()
    assert "ZeroDivisionError: by nought" in text and r"caf\udce9" in text
    assert sys.version in text


def test_a_fault_is_said_where_no_log_can_be_written(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "none"))
    with pytest.raises(SystemExit, match="send this line, for no log could be written"):
        cli.run(broken(ZeroDivisionError()))


def test_numbers_beyond_the_memory_are_a_sentence():
    with pytest.raises(SystemExit, match="not enough memory for this; choose smaller"):
        cli.run(broken(MemoryError()))


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="names there are always Unicode")
def test_a_name_that_is_not_utf_8_can_be_written_and_printed(tmp_path):
    name = os.fsencode(tmp_path) + b"/caf\xe9.csv"
    words = ["-m", "mkt", "figure", FIGURE, "-o", name]
    done = subprocess.run([sys.executable, *words], cwd=ROOT, capture_output=True)
    assert done.returncode == 0 and done.stdout.endswith(rb"caf\udce9.csv" + b"\n")


@pytest.mark.parametrize("camera", ["0", "rtsp://camera/stream"])
def test_track_says_what_follows_a_camera(camera, capsys):
    with pytest.raises(SystemExit):
        cli.parse(["track", camera])
    assert "not cameras; `live` in RESEARCH.md" in capsys.readouterr().err


def test_track_takes_a_folder_whose_name_is_a_number(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "0").mkdir()
    assert str(cli.parse(["track", "0"]).video) == "0"


def test_a_minus_behind_an_option_is_of_its_number_and_after_two_alone_it_is_not():
    for box in "-5,30,40,40", "-.5,30,40,40":
        args = cli.parse(["track", "x.mkv", "--box", box, "-o", "x.csv"])
        assert args.box == [box] and args.output.name == "x.csv"
    assert cli.parse(["test", "--", "-5"]).rest[-1] == "-5"


def test_what_the_system_says_of_a_file_gets_its_name_and_a_remedy():
    with pytest.raises(SystemExit, match="^mkt labs: /no/f: Gone; look whether"):
        with cli.door("labs"):
            raise FileNotFoundError(2, "Gone", "/no/f")


def test_the_version_is_that_of_the_library(capsys):
    with pytest.raises(SystemExit) as ended:
        cli.parse(["--version"])
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"mkt {mkt.__version__}\n"


def test_no_starts_are_refused(capsys):
    with pytest.raises(SystemExit):
        run("bench", "tracking", "--starts", "0")
    assert "give 1 or more" in capsys.readouterr().err
