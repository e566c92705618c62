"""The command line: help without a single package, and mistakes answered in a sentence."""

import subprocess
import sys

import pytest

from mkt import cli, figures
from mkt.figures.words import parameters

COMMANDS = ("book", "test", "lab", "figure", "claims", "track", "bench", "data", "labs", "doctor", "strip")
FIGURE = "teuliere2009.fig2"


def bare(*words):
    """Run the program on a Python that sees no installed package."""
    return subprocess.run([sys.executable, "-S", "-m", "mkt", *words], cwd=cli.ROOT, capture_output=True, text=True, timeout=60)


def test_help_needs_no_package():
    result = bare("--help")
    assert result.returncode == 0
    assert all(f"    {command} " in result.stdout for command in COMMANDS)


def test_a_reader_who_has_read_enough_is_no_error():
    program = subprocess.Popen([sys.executable, "-m", "mkt", "data"], cwd=cli.ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    program.stdout.close()  # as `| head -0` does, before a word was printed
    assert program.stderr.read() == "" and program.wait(60) == 1


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself_with_examples(command, capsys):
    with pytest.raises(SystemExit) as stopped:
        cli.parse([command, "--help"])
    assert stopped.value.code == 0
    assert f"examples:\n  python3 -m mkt {command}" in capsys.readouterr().out


@pytest.mark.parametrize("words, said", [
    ((), "usage:"), (("nope",), "invalid choice"), (("book", "--fast"), "unrecognized arguments: --fast"), (("figure",), "needs an ID and -o FILE"),
    (("bench", "--seeds", "3"), "go with `bench tracking`"),
])
def test_a_mistyped_command_is_refused_before_anything_is_installed(words, said):
    result = bare(*words)
    assert result.returncode == 2
    assert said in result.stdout + result.stderr


def test_arguments_after_test_and_lab_are_handed_on_in_order():
    assert cli.parse(["test", "-k", "widgets", "tests/test_cli.py", "-x"]).rest == ["-k", "widgets", "tests/test_cli.py", "-x"]
    assert cli.parse(["lab", "--no-browser"]).rest == ["--no-browser"]


@pytest.mark.parametrize("ending, magic", [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml"), ("csv", b"# Title: teuliere2009.fig2")])
def test_figure_writes_the_format_of_the_ending(tmp_path, ending, magic):
    path = tmp_path / f"figure.{ending}"
    assert not cli.run(cli.parse(["figure", FIGURE, "-o", str(path), "--set", "span=0.8", "layout=2x2"]))
    assert path.read_bytes().startswith(magic)


@pytest.mark.parametrize("words, said", [
    (["ghosts", "-o", "x.png"], f"no figure 'ghosts'; there are {', '.join(figures.registry())}"),
    (["fig6", "-o", "x.png"], "no figure 'fig6', perhaps teuliere2009.fig6 or nummiaro2003.fig6 or cordoba2014.fig6?; there are"),
    ([FIGURE, "-o", "x.png", "--set", "spam=1"], "has no parameter 'spam'; it takes layout, span"),
    ([FIGURE, "-o", "x.png", "--set", "span"], "'span' is not NAME=VALUE"),
    ([FIGURE, "-o", "x.png", "--set", "span=wide"], "not a number of type float"),
    ([FIGURE, "-o", "x.png", "--set", "layout=5x5"], "choose from one, 2x2, 3x3"),
    ([FIGURE, "-o", "x.nonsense"], "x.nonsense: the ending says what to write; take one of .png, .pdf, .svg, .csv"),
    ([FIGURE, "-o", "no/such/folder/x.png"], "no folder no/such/folder for x.png; make it first"),
    (["--all", "-o", f"{__file__}/x"], "x cannot be made a folder: Not a directory"),
    (["teuliere2009.fig8", "-o", "x.png", "--set", "frame=999", "features=exact"], "has no parameter 'features'"),
    (["own.run", "-o", "x.png", "--set", "spam=1"], "it takes frame, tracker, particles, scene, seed, n for particles"),
    (["own.resampling", "-o", "x.png", "--set", "n=0"], "own.resampling cannot be drawn with n=0: "),
])
def test_a_wrong_figure_is_answered_in_a_sentence(words, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stopped:
        cli.run(cli.parse(["figure", *words]))
    assert said in stopped.value.code
    assert not list(tmp_path.iterdir())


def test_figure_takes_set_once_or_often_and_numbers_between_the_positions():
    words = ["--set", "particles=100", "threshold=0.5"], ["--set", "n=100", "--set", "threshold=0.5"]
    for each in words:
        args = cli.parse(["figure", "teuliere2009.fig6", "-o", "x.pdf", *each])
        assert parameters(figures.get(args.id), args.set) == {"particles": 100, "threshold": 0.5}
    assert parameters(figures.get("teuliere2009.fig10"), ["fps=7.5", "compensation=off"]) == {"fps": 7.5, "compensation": "off"}
    assert parameters(figures.get("nummiaro2003.fig8"), ["turns=False"]) == {"turns": False}


@pytest.mark.parametrize("words, said", [
    (["--all"], "--all and -o FOLDER"), ([FIGURE, "--all", "-o", "x"], "--all and -o FOLDER"), ([FIGURE], "an ID and -o FILE"),
    (["--all", "-o", "x", "--set", "a=1"], "--set goes with one figure"), ([FIGURE, "-o", "x.png", "--format", "pdf"], "--format with --all"),
])
def test_figure_is_asked_for_one_or_for_all(words, said, capsys):
    with pytest.raises(SystemExit):
        cli.parse(["figure", *words])
    assert said in capsys.readouterr().err


def test_figure_all_writes_every_figure(tmp_path, monkeypatch):
    known = figures.registry()
    monkeypatch.setattr(figures, "registry", lambda: {id: known[id] for id in ("own.root_locus", FIGURE)})
    cli.run(cli.parse(["figure", "--all", "-o", str(tmp_path / "new" / "folder"), "--format", "pdf"]))
    assert {path.name for path in (tmp_path / "new" / "folder").iterdir()} == {"own.root_locus.pdf", f"{FIGURE}.pdf"}


def test_figure_list_names_every_figure_and_every_parameter(capsys):
    cli.run(cli.parse(["figure", "--list"]))
    listed = capsys.readouterr().out
    assert all(id in listed for id in figures.registry())
    cli.run(cli.parse(["figure", FIGURE, "--list"]))
    listed = capsys.readouterr().out
    assert "span=1.0    one of 0.4, 0.5" in listed and "Numbers need not be" in listed and "n means" not in listed
    cli.run(cli.parse(["figure", "own.run", "--list"]))
    assert "n means particles" in capsys.readouterr().out
