"""The set-up: what it is made from, what stops it, and that a stopped one is begun again.  The real thing runs in CI, before these tests."""

import importlib.util
import os
import re
import subprocess
import sys
import tomllib

import pytest

from mkt import __main__ as bootstrap
from mkt.cli import ROOT

SAY = "import sys; print({!r}); sys.exit({})"


@pytest.fixture
def place(tmp_path, monkeypatch):
    """An empty checkout whose set-up is one step that writes a file; returns the folder of its environment."""
    (tmp_path / "environment.txt").write_text("numpy==2\n")
    (tmp_path / "pyproject.toml").write_text("")
    for name, path in {"ROOT": "", "VENV": ".venv", "REQUIREMENTS": "environment.txt", "PYTHON": ".venv/made"}.items():
        monkeypatch.setattr(bootstrap, name, tmp_path / path)
    monkeypatch.setattr(bootstrap, "steps", lambda uv: [("making", [sys.executable, "-c", "open('.venv/made', 'a').write('x')"])])
    return tmp_path / ".venv"


def step(monkeypatch, code):
    monkeypatch.setattr(bootstrap, "steps", lambda uv: [("failing", [sys.executable, "-c", code])])


def test_set_up_once_and_not_again(place):
    bootstrap.ensure()
    assert bootstrap.stamp_of(place) == bootstrap.wanted_stamp()
    bootstrap.ensure()
    assert (place / "made").read_text() == "x"


@pytest.mark.parametrize("name", ["environment.txt", "pyproject.toml"])
def test_changed_packages_renew_the_environment(place, name):
    bootstrap.ensure()
    (place / "leftover").mkdir()
    (place.parent / name).write_text("# changed\n")
    bootstrap.ensure()
    assert bootstrap.stamp_of(place) == bootstrap.wanted_stamp()
    assert not (place / "leftover").exists()


def test_a_stopped_set_up_is_begun_again(place, monkeypatch):
    with monkeypatch.context() as context:
        context.setattr(bootstrap, "execute", lambda command: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            bootstrap.ensure()
    assert bootstrap.stamp_of(place) == bootstrap.UNFINISHED
    (place / "half").write_text("made")
    bootstrap.ensure()
    assert bootstrap.stamp_of(place) == bootstrap.wanted_stamp()
    assert not (place / "half").exists()


def test_somebody_elses_environment_is_left_alone(place):
    place.mkdir()
    (place / "pyvenv.cfg").write_text("mine")
    with pytest.raises(SystemExit, match="was not made by mkt"):
        bootstrap.ensure()
    assert (place / "pyvenv.cfg").read_text() == "mine"


def test_an_environment_is_not_renewed_from_within(place, monkeypatch):
    bootstrap.ensure()
    (place.parent / "environment.txt").write_text("numpy==3\n")
    monkeypatch.setattr(sys, "prefix", str(place))
    with pytest.raises(SystemExit, match="deactivate"):
        bootstrap.ensure()


def test_no_network_is_said_plainly(place, monkeypatch, capsys):
    step(monkeypatch, SAY.format("Failed to establish a new connection: Name or service not known", 1))
    with pytest.raises(SystemExit, match="needs a network connection"):
        bootstrap.ensure()
    assert "Name or service" in capsys.readouterr().err
    assert bootstrap.stamp_of(place) == bootstrap.UNFINISHED


def test_other_failures_show_the_installers_last_words(place, monkeypatch, capsys):
    step(monkeypatch, SAY.format("disk is full", 1))
    with pytest.raises(SystemExit, match="set-up failed"):
        bootstrap.ensure()
    assert "disk is full" in capsys.readouterr().err


def test_missing_venv_module_says_what_to_install(place, monkeypatch):
    monkeypatch.setattr(bootstrap.shutil, "which", lambda name: None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(SystemExit, match="apt install python3-venv"):
        bootstrap.ensure()
    assert not place.exists()


def test_an_old_python_is_told(monkeypatch):
    monkeypatch.setattr(bootstrap, "OLDEST", (99, 0))
    with pytest.raises(SystemExit, match="needs Python 3.11 or later"):
        bootstrap.main()


def test_inside_the_environment_nothing_is_set_up(monkeypatch, capsys):
    monkeypatch.setattr(bootstrap, "stamp_of", lambda environment: bootstrap.wanted_stamp())
    monkeypatch.setattr(bootstrap, "ensure", lambda: pytest.fail("set up again"))
    monkeypatch.setattr(sys, "argv", ["mkt", "figure", "--list"])
    assert not bootstrap.main()
    assert "teuliere2009.fig3" in capsys.readouterr().out


def test_environment_pins_every_direct_dependency_for_pip_and_names_no_host():
    text = (ROOT / "environment.txt").read_text()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    direct = sum(project["optional-dependencies"].values(), project["dependencies"])
    pinned = set(re.findall(r"^([\w-]+)==", text, re.M))
    assert {re.match(r"[\w-]+", name)[0].lower() for name in direct} <= pinned
    assert "pip" in text.splitlines()[0]
    assert text.splitlines()[-1] == "-e ."
    assert not re.search(r"https?:|--hash|--index|--find-links", text)


@pytest.mark.skipif(os.name == "nt", reason="a bash script")
def test_ci_runs_the_readers_command():
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    assert script.read_text().rstrip().endswith("exec python3 -m mkt test")


def test_the_library_is_found_from_beside_a_folder_of_its_name(tmp_path):
    """As in the parent folder of a clone called mkt."""
    (tmp_path / "mkt").mkdir()
    code = "import mkt; print(mkt.__version__)"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
