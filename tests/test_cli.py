"""The command line: help without a single package, and mistakes answered in a sentence."""

import subprocess
import sys

import pytest

from mkt import cli, figures

COMMANDS = ("book", "test", "lab", "figure", "claims", "bench", "data", "labs", "strip")
FIGURE = "teuliere2009.fig2"


def bare(*words):
    """Run the program on a Python that sees no installed package."""
    return subprocess.run([sys.executable, "-S", "-m", "mkt", *words], cwd=cli.ROOT, capture_output=True, text=True, timeout=60)


def test_help_needs_no_package():
    result = bare("--help")
    assert result.returncode == 0
    assert all(f"    {command} " in result.stdout for command in COMMANDS)


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


@pytest.mark.parametrize("ending, magic", [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_figure_writes_the_format_of_the_ending(tmp_path, ending, magic):
    path = tmp_path / f"figure.{ending}"
    assert not cli.run(cli.parse(["figure", FIGURE, "-o", str(path), "--set", "span=0.8", "layout=2x2"]))
    assert path.read_bytes().startswith(magic)


@pytest.mark.parametrize("words, said", [
    (["teuliere2009.fig99", "-o", "x.png"], f"no figure 'teuliere2009.fig99'; there are {', '.join(figures.registry())}"),
    ([FIGURE, "-o", "x.png", "--set", "spam=1"], "has no parameter 'spam'; it takes layout, span"),
    ([FIGURE, "-o", "x.png", "--set", "span"], "'span' is not NAME=VALUE"),
    ([FIGURE, "-o", "x.png", "--set", "span=wide"], "not a number of type float"),
    ([FIGURE, "-o", "x.png", "--set", "layout=5x5"], "choose from one, 2x2, 3x3"),
    ([FIGURE, "-o", "x.nonsense"], "not supported"),
    ([FIGURE, "-o", "no/such/folder/x.png"], "No such file or directory"),
])
def test_a_wrong_figure_is_answered_in_a_sentence(words, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stopped:
        cli.run(cli.parse(["figure", *words]))
    assert said in stopped.value.code
    assert not list(tmp_path.iterdir())


def test_figure_list_names_every_figure_and_every_parameter(capsys):
    cli.run(cli.parse(["figure", "--list"]))
    listed = capsys.readouterr().out
    assert all(id in listed for id in figures.registry())
    cli.run(cli.parse(["figure", FIGURE, "--list"]))
    assert "span=1.0    one of 0.4, 0.5" in capsys.readouterr().out
