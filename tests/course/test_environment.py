"""The set-up: what it is made from, what stops it, and how it is begun again.

The real thing runs in CI, before these tests.
"""

import importlib.util
import os
import re
import subprocess
import sys
import time
import tomllib

import pytest

from mkt import __main__ as door
from mkt.course import environment
from mkt.files import ROOT

SAY = "import sys; print({!r}); sys.exit({})"
# NAME==VERSION, perhaps a condition, and at least one hash, to the end of the entry.
PINNED = (
    r"[\w.-]+(?:\[[\w-]+\])?==\S+(?: ; [^\\\n]+)?"
    r"(?: \\\n    --hash=sha256:[0-9a-f]{64})+\n"
)


@pytest.fixture
def place(tmp_path, monkeypatch):
    """The environment's folder in an empty clone; one step, which writes a file."""
    (tmp_path / "environment.txt").write_text("numpy==2\n")
    (tmp_path / "pyproject.toml").write_text("")
    for name, path in {
        "ROOT": "",
        "VENV": ".venv",
        "LOCK": ".venv.lock",
        "REQUIREMENTS": "environment.txt",
        "PYTHON": ".venv/made",
    }.items():
        monkeypatch.setattr(environment, name, tmp_path / path)
    only_step(monkeypatch, "open('.venv/made', 'a').write('x')")
    return tmp_path / ".venv"


def only_step(monkeypatch, code):
    """Let the set-up be one step, which runs some code."""
    command = [sys.executable, "-c", code]
    monkeypatch.setattr(environment, "steps", lambda uv: [("working", command)])


def test_set_up_once_and_not_again(place):
    environment.ensure()
    assert environment.stamp_of(place) == environment.wanted_stamp()
    environment.ensure()
    assert (place / "made").read_text() == "x"


@pytest.mark.parametrize("name", ["environment.txt", "pyproject.toml"])
def test_changed_packages_renew_the_environment(place, name):
    environment.ensure()
    (place / "leftover").mkdir()
    (place.parent / name).write_text("# changed\n")
    environment.ensure()
    assert environment.stamp_of(place) == environment.wanted_stamp()
    assert not (place / "leftover").exists()


@pytest.mark.skipif(os.name == "nt", reason="links are for administrators there")
def test_a_renewal_removes_a_link_and_leaves_what_it_leads_to(place, tmp_path):
    """Python itself makes one, lib64."""
    environment.ensure()
    (tmp_path / "outside").mkdir()
    (place / "lib64").symlink_to(tmp_path / "outside")
    (place.parent / "environment.txt").write_text("# changed\n")
    environment.ensure()
    assert environment.is_made() and (tmp_path / "outside").is_dir()
    assert not (place / "lib64").is_symlink()


def test_an_empty_folder_is_nobodys_environment_and_is_set_up(place):
    place.mkdir()
    environment.ensure()
    assert environment.is_made()


def test_an_environment_that_came_with_a_copied_clone_is_not_as_wanted(
    place, tmp_path, monkeypatch
):
    """Its programs begin with the path of the old one."""
    environment.ensure()
    (tmp_path / "copy").mkdir()
    (tmp_path / "copy" / "pyproject.toml").write_text("")
    monkeypatch.setattr(environment, "ROOT", tmp_path / "copy")
    assert not environment.is_made()


def test_a_stopped_set_up_is_begun_again(place, monkeypatch, capsys):
    def interrupted(command):
        raise KeyboardInterrupt

    with monkeypatch.context() as context:
        context.setattr(environment, "execute", interrupted)
        with pytest.raises(KeyboardInterrupt):
            environment.ensure()
    assert environment.stamp_of(place) == environment.UNFINISHED
    (place / "half").write_text("made")
    environment.ensure()
    assert environment.stamp_of(place) == environment.wanted_stamp()
    assert not (place / "half").exists()
    said = capsys.readouterr().err
    assert said.count("First use: ") == 2 and "has changed" not in said


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b"nonsense"])
def test_a_damaged_stamp_begins_the_set_up_again(place, content):
    environment.ensure()
    (place / environment.STAMP_NAME).write_bytes(content)
    environment.ensure()
    assert environment.stamp_of(place) == environment.wanted_stamp()


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such signals")
def test_a_terminated_set_up_stops_its_installer(place, monkeypatch):
    code = "import os; os.kill(os.getppid(), 2); import time; time.sleep(60)"
    only_step(monkeypatch, code)
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        environment.ensure()
    assert time.monotonic() - start < 30


SET_UP = """
import sys
from pathlib import Path
from mkt.course import environment
place = Path(sys.argv[1])
for name in ("VENV", "LOCK", "REQUIREMENTS", "ROOT"):
    setattr(environment, name, place / getattr(environment, name).name)
environment.ROOT, environment.PYTHON = place, place / ".venv" / "made"
code = "import time; open('.venv/made', 'a').write('x'); time.sleep(1)"
environment.steps = lambda uv: [("working", [sys.executable, "-c", code])]
environment.ensure()
"""


def test_two_set_ups_at_once_make_one_environment(place):
    words = [sys.executable, "-c", SET_UP, place.parent]
    both = [
        subprocess.Popen(words, cwd=ROOT, stderr=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    said = [program.communicate(timeout=60)[1] for program in both]
    assert [program.returncode for program in both] == [0, 0], said
    assert (place / "made").read_text() == "x"
    assert sum("First use" in words for words in said) == 1


def test_somebody_elses_environment_is_left_alone(place):
    place.mkdir()
    (place / "pyvenv.cfg").write_text("mine")
    with pytest.raises(SystemExit, match="was not made by mkt"):
        environment.ensure()
    assert (place / "pyvenv.cfg").read_text() == "mine"


def test_an_environment_behind_a_link_is_left_alone(place, tmp_path):
    """Its stamp is that of another clone, which would take it for an old one."""
    others = tmp_path / "others"
    others.mkdir()
    (others / environment.STAMP_NAME).write_text("of another clone")
    environment.VENV.symlink_to(others)
    with pytest.raises(SystemExit, match="is a link"):
        environment.ensure()
    assert [path.name for path in others.iterdir()] == [environment.STAMP_NAME]


def test_an_environment_is_not_renewed_from_within(place, monkeypatch):
    environment.ensure()
    (place.parent / "environment.txt").write_text("numpy==3\n")
    monkeypatch.setattr(sys, "prefix", str(place))
    with pytest.raises(SystemExit, match="deactivate"):
        environment.ensure()


@pytest.mark.parametrize(
    "said",
    [
        "Failed to establish a new connection: Name or service not known",
        "ERROR: No matching distribution found for numpy==2.4",
    ],
)
def test_no_network_is_said_plainly(place, monkeypatch, capsys, said):
    only_step(monkeypatch, SAY.format(said, 1))
    with pytest.raises(SystemExit, match="needs a network connection"):
        environment.ensure()
    assert said in capsys.readouterr().err
    assert environment.stamp_of(place) == environment.UNFINISHED


def test_a_full_disk_is_no_missing_network_where_a_package_is_called_networkx():
    said = "Installing collected packages: networkx, numpy\n[Errno 28] No space left"
    with pytest.raises(SystemExit, match="The set-up failed"):
        environment.fail(said)


def test_other_failures_show_the_installers_last_words(place, monkeypatch, capsys):
    only_step(monkeypatch, SAY.format("disk is full", 1))
    with pytest.raises(SystemExit, match="set-up failed"):
        environment.ensure()
    assert "disk is full" in capsys.readouterr().err


def test_how_far_pip_has_come_is_counted_by_the_packages_it_has_begun(capsys):
    lines = []
    for line in (
        "Collecting numpy==2.0\n",
        "  Downloading numpy-2.0.whl (16 MB)\n",
        "Collecting scipy==1.14\n",
    ):
        lines.append(line)
        environment.count(lines)
    first, second = capsys.readouterr().err.split("\r")[1:]
    assert first.split()[:2] == ["1", "of"] and "numpy==2.0" in first
    assert second.split()[:2] == ["2", "of"] and "scipy==1.14" in second


def test_missing_venv_module_says_what_to_install(place, monkeypatch):
    monkeypatch.setattr(environment.shutil, "which", lambda name: None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(SystemExit, match="apt install python3-venv"):
        environment.ensure()
    assert not place.exists()


def test_an_old_python_is_told(monkeypatch):
    monkeypatch.setattr(door, "OLDEST", (99, 0))
    with pytest.raises(SystemExit, match="needs Python 3.11 or later"):
        door.main()


def test_inside_the_environment_nothing_is_set_up(monkeypatch, capsys):
    monkeypatch.setattr(environment, "stamp_of", lambda _: environment.wanted_stamp())
    monkeypatch.setattr(environment, "ensure", lambda: pytest.fail("set up again"))
    monkeypatch.setattr(sys, "argv", ["mkt", "figure", "--list"])
    assert not door.main()
    assert "teuliere2009.fig3" in capsys.readouterr().out


@pytest.mark.parametrize("uv", ["uv", None])
def test_a_set_up_takes_only_what_is_listed_and_then_the_clone(uv):
    (_, make), (_, listed), *_, (_, clone) = environment.steps(uv)
    assert make[-1] == str(environment.VENV)
    assert "--require-hashes" in listed
    assert listed[-2:] == ["-r", str(environment.REQUIREMENTS)]
    assert {"--no-deps", "--no-build-isolation"} <= set(clone)
    assert clone[-2:] == ["-e", str(ROOT)]


def test_what_pip_does_not_compile_is_compiled_but_for_files_of_another_python(
    tmp_path,
):
    (tmp_path / "good.py").write_text("x = 1")
    (tmp_path / "old.py").write_text("print 1")
    here = f"import sysconfig; sysconfig.get_path = lambda _: {str(tmp_path)!r}; "
    (_, pip), (_, (_, flag, code)) = environment.steps(None)[1:3]
    assert "--no-compile" in pip
    done = subprocess.run(
        [sys.executable, flag, here + code], capture_output=True, text=True
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    (compiled,) = (tmp_path / "__pycache__").iterdir()
    assert compiled.name.startswith("good.")


def test_environment_pins_every_direct_dependency_for_pip_and_names_no_host():
    text = (ROOT / "environment.txt").read_text()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    direct = sum(project["optional-dependencies"].values(), project["dependencies"])
    head, *packages = re.split(r"^(?=[^#\s])", text, flags=re.M)
    assert all(re.fullmatch(PINNED, package) for package in packages)
    pinned = {re.match(r"[\w.-]+", package)[0] for package in packages}
    named = {re.match(r"[\w-]+", name)[0].lower() for name in direct}
    assert named - {"mkt"} <= pinned  # an extra may take in another
    assert all(line.startswith("#") for line in head.splitlines())
    assert "pip install --require-hashes -r environment.txt" in head
    assert "uv pip compile" in head and "--generate-hashes" in head
    assert "rfc3987-syntax" not in text  # 1.6 s to import, in every program of Jupyter
    assert not re.search(r"https?:|--index|--find-links", text)
    assert "-e ." not in text.splitlines()


@pytest.mark.skipif(os.name == "nt", reason="a bash script")
def test_ci_runs_the_readers_command():
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    assert script.read_text().rstrip().endswith("exec python3 -m mkt test")


@pytest.mark.skipif(os.name == "nt", reason="Windows starts a second program")
def test_a_command_takes_the_place_of_the_program_that_starts_it():
    """So a signal to the one reaches the other."""
    number = "import os; print(os.getpid(), flush=True)"
    code = f"{number}; from mkt.course.environment import become; import sys; "
    code += f"become([sys.executable, '-c', {number!r}])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, cwd=ROOT)
    before, after = done.stdout.split()
    assert before == after


def test_the_library_is_found_from_beside_a_folder_of_its_name(tmp_path):
    """As in the parent folder of a clone called mkt."""
    (tmp_path / "mkt").mkdir()
    code = "import mkt; print(mkt.__version__)"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
