"""A clone that its reader may not write, as on a machine for all.

The file system is read-only and the user another one, under bubblewrap.
"""

import shutil
import subprocess
import sys

import pytest

from mkt.course import doctor, environment
from mkt.files import ROOT
from tests.own_video import films

SANDBOX = ("bwrap", "--ro-bind", "/", "/", "--dev", "/dev", "--proc", "/proc")
STRANGER = ("--unshare-user", "--uid", "12345", "--gid", "12345")


@pytest.fixture
def run(tmp_path):
    """A way to run a command as a stranger, who may write into one folder alone."""
    place = ("--bind", tmp_path, tmp_path, "--chdir", tmp_path)
    own = ("--setenv", "MKT_CACHE", tmp_path / "kept")
    other = ("--setenv", "MKT_BUILD", tmp_path / "built")
    inside = [*SANDBOX, *place, *STRANGER, *own, *other]
    if not shutil.which("bwrap") or subprocess.call([*inside, "true"]):
        pytest.skip("bubblewrap cannot be used")

    def run(*words, options=(), python=sys.executable):
        command = [python, "-m", "mkt", *words]
        variables = ["--setenv", "PYTHONPATH", ROOT, *options]
        return subprocess.run(
            [*inside, *variables, *command], capture_output=True, text=True, timeout=120
        )

    return run


@pytest.mark.slow
def test_commands_work_in_a_folder_of_their_own(run, tmp_path):
    films.write(tmp_path / "car.mkv", films.driving(3).frames)
    track = ("track", "car.mkv", "--box", "55,48,50,24", "--tracker", "ssd")
    for words in (
        track,
        ("figure", "teuliere2009.fig2", "-o", "x.pdf"),
        ("figure", "own.run", "-o", "x.csv"),
        ("claims", "--list"),
        ("doctor",),
    ):
        done = run(*words)
        assert done.returncode == 0, done.stdout + done.stderr
    assert f"folder        {ROOT} cannot be written" in done.stdout
    assert list((tmp_path / "kept").rglob("*.*"))


def test_without_an_environment_it_is_said_what_to_do(run):
    # A Python that sees no packages, nor the stamp of their environment.
    hidden = ("--tmpfs", environment.VENV)
    done = run("data", options=hidden, python=sys._base_executable)
    assert done.returncode == 1
    [line] = done.stderr.splitlines()
    assert line == environment.READ_ONLY.format(ROOT)


@pytest.mark.parametrize("made", [True, False])
def test_the_doctor_knows_a_clone_for_all(made, monkeypatch, tmp_path):
    monkeypatch.setattr(doctor.os, "access", lambda *_: False)
    monkeypatch.setattr(environment, "is_current", lambda: made)
    *_, found = doctor._folder(tmp_path)
    remedy = "MKT_CACHE and MKT_BUILD" if made else "clone into a folder of your own"
    assert found.state == (doctor.NOTE if made else doctor.WRONG)
    assert remedy in found.remedy
