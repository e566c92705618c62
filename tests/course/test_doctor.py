"""The doctor calls fine things fine, finds each planted trouble, and has a remedy."""

import json
import os
import re
import subprocess
import sys
import sysconfig
import venv
from types import SimpleNamespace

import pytest

from mkt.course import doctor, environment
from mkt.files import ROOT
from mkt.sequences import writing

# Runs the command in a copy of the clone, whose folder it is told.
ELSEWHERE = """
import pathlib, sys
folder = sys.argv[1]
sys.path.insert(0, folder)
sys.argv = ["mkt", "doctor"]
from mkt import __main__ as program
from mkt.course import environment
environment.VENV = pathlib.Path(folder) / ".venv"
sys.exit(program.main())
"""


def findings(check):
    return {finding.name: finding for finding in check()}


def test_what_the_environment_needs_is_there():
    for check in (
        doctor.machine,
        doctor.packages,
        doctor.one_opencv,
        doctor.codecs,
        doctor.widgets,
        doctor.kernel,
    ):
        assert not [str(f) for f in check() if f.state == doctor.WRONG]


@pytest.mark.parametrize("version", ["", "1.0"])
def test_a_missing_or_other_package_is_named(monkeypatch, version):
    known = doctor._version
    monkeypatch.setattr(
        doctor, "_version", lambda name: version if name == "numpy" else known(name)
    )
    found = findings(doctor.packages)["packages"]
    assert (
        found.state == doctor.WRONG
        and "numpy is " + (version or "missing") in found.found
        and found.remedy
    )


@pytest.mark.parametrize("n, more", [(3, False), (4, True)])
def test_of_many_wrong_packages_the_first_three_are_named(monkeypatch, n, more):
    text = environment.REQUIREMENTS.read_text("utf-8")
    names = re.findall(r"^([\w.-]+)==", text, re.MULTILINE)
    wrong = [name for name in names if doctor._version(name)][:n]
    known = doctor._version
    monkeypatch.setattr(
        doctor, "_version", lambda name: "0.0.1" if name in wrong else known(name)
    )
    found = findings(doctor.packages)["packages"].found
    assert found.count(" is 0.0.1, not ") == 3 and found.endswith("...") == more


@pytest.mark.parametrize("made, state", [(True, doctor.FINE), (False, doctor.WRONG)])
def test_a_full_disk_is_trouble_before_the_set_up_alone(
    monkeypatch, tmp_path, made, state
):
    if made:
        (tmp_path / ".venv").mkdir()
    monkeypatch.setattr(environment, "VENV", tmp_path / ".venv")
    monkeypatch.setattr(
        doctor.shutil, "disk_usage", lambda _: SimpleNamespace(free=1e9)
    )
    found = findings(lambda: doctor._folder(tmp_path))["disk"]
    assert (found.state, found.found) == (state, "1.0 GB free")


def test_two_wheels_of_opencv_are_one_too_many(monkeypatch):
    monkeypatch.setattr(
        doctor,
        "_version",
        lambda name: (
            "5.0" if name in ("opencv-python", "opencv-python-headless") else ""
        ),
    )
    assert findings(doctor.one_opencv)["OpenCV"].state == doctor.WRONG


def test_without_a_wheel_of_opencv_nothing_is_said_of_two(monkeypatch):
    monkeypatch.setattr(doctor, "_version", lambda name: "")
    found = findings(doctor.one_opencv)["OpenCV"]
    assert (found.state, found.found) == (doctor.WRONG, "none")
    assert "two share" not in found.remedy


@pytest.mark.parametrize("by_hand", [True, False])
def test_a_package_that_is_broken_stops_no_other_check(monkeypatch, by_hand):
    def broken_one():
        raise ImportError("libGL.so.1: cannot open shared object file")
        yield

    for name in ("machine", "_folder", "virtual_environment", "widgets", "browser"):
        monkeypatch.setattr(doctor, name, lambda *_: iter(()))
    for name in ("codecs", "kernel"):
        monkeypatch.setattr(doctor, name, broken_one)
    monkeypatch.setattr(doctor, "box", lambda: doctor.Finding(doctor.FINE, "box", ""))
    monkeypatch.setattr(environment, "is_by_hand", lambda: by_hand)
    monkeypatch.setattr(environment, "is_current", lambda: True)
    found = findings(doctor.diagnose)
    assert found["broken one"].state == doctor.WRONG
    assert "libGL" in found["broken one"].found and found["broken one"].remedy
    assert "data sets" in found and ("packages" in found) != by_hand


def test_a_format_that_cannot_be_written_is_found(monkeypatch):
    monkeypatch.setitem(writing.CODECS, ".webm", "NONE")
    found = findings(doctor.codecs)
    assert (
        found["video .webm"].state == doctor.WRONG
        and found["video .avi"].state == doctor.FINE
    )


def test_a_video_from_which_more_comes_back_than_was_written_is_trouble(monkeypatch):
    monkeypatch.setattr("mkt.sequences.video.VideoFile", lambda path: range(6))
    found = findings(doctor.codecs)["video .avi"]
    assert (found.state, found.found) == (doctor.WRONG, "6 of 5 frames came back")


def test_data_that_may_not_be_read_do_not_end_the_list(monkeypatch):
    def refused():
        raise PermissionError(13, "Permission denied", "MOT15")

    monkeypatch.setattr("mkt.sequences.benchmarks.usable", refused)
    found = findings(doctor.data_sets)["data sets"]
    assert (found.state, found.found) == (
        doctor.WRONG,
        "[Errno 13] Permission denied: 'MOT15'",
    )


def test_a_kernel_of_another_python_is_found_with_its_folder(monkeypatch, tmp_path):
    argv = [str(tmp_path / "python"), "-m", "ipykernel_launcher"]
    spec = {"argv": argv, "language": "python", "display_name": "other"}
    folder = tmp_path / "kernels" / "python3"
    folder.mkdir(parents=True)
    (folder / "kernel.json").write_text(json.dumps(spec))
    monkeypatch.setenv("JUPYTER_PATH", str(tmp_path))
    found = findings(doctor.kernel)["kernel"]
    assert found.state == doctor.WRONG and str(folder) in found.remedy


def test_a_missing_part_of_jupyterlab_is_found(monkeypatch, tmp_path):
    monkeypatch.setattr(doctor.sys, "prefix", str(tmp_path))
    found = findings(doctor.widgets)
    assert {*found} == {*doctor.EXTENSIONS}
    for finding in found.values():
        assert finding.state == doctor.WRONG and "is missing" in finding.found


def test_a_folder_of_data_that_is_not_there(monkeypatch, tmp_path):
    monkeypatch.setenv("MKT_DATA", str(tmp_path / "nowhere"))
    assert findings(doctor.data_sets)["data sets"].state == doctor.WRONG
    monkeypatch.delenv("MKT_DATA")
    assert findings(doctor.data_sets)["data sets"].state == doctor.FINE


@pytest.mark.parametrize(
    "stamp, state",
    [
        (None, doctor.NOTE),
        ("unfinished", doctor.NOTE),
        ("old", doctor.NOTE),
        ("foreign", doctor.WRONG),
    ],
)
def test_the_state_of_the_environment(monkeypatch, tmp_path, stamp, state):
    monkeypatch.setattr(environment, "VENV", tmp_path / ".venv")
    monkeypatch.setattr(doctor.sys, "prefix", str(tmp_path))
    if stamp:
        (tmp_path / ".venv").mkdir()
        (
            tmp_path
            / ".venv"
            / ("something" if stamp == "foreign" else environment.STAMP_NAME)
        ).write_text(stamp)
    found = findings(doctor.virtual_environment)["environment"]
    assert found.state == state and found.remedy


def test_an_environment_whose_python_is_gone_is_not_set_up(monkeypatch, tmp_path):
    """Every command sets it up anew, see `mkt.course.environment.ensure`."""
    monkeypatch.setattr(environment, "VENV", tmp_path)
    monkeypatch.setattr(environment, "PYTHON", tmp_path / "python")
    monkeypatch.setattr(doctor.sys, "prefix", str(tmp_path / "elsewhere"))
    (tmp_path / environment.STAMP_NAME).write_text(environment.wanted_stamp())
    found = findings(doctor.virtual_environment)["environment"]
    assert found.state == doctor.NOTE and "its Python is not there" in found.found
    (tmp_path / "python").touch()
    assert findings(doctor.virtual_environment)["environment"].state == doctor.FINE


@pytest.mark.skipif(os.name == "nt", reason="links are for administrators there")
def test_an_environment_of_others_is_found(monkeypatch, tmp_path):
    """Every command refuses it, see `mkt.course.environment.make`."""
    (tmp_path / "theirs").mkdir()
    (tmp_path / ".venv").symlink_to(tmp_path / "theirs")
    monkeypatch.setattr(environment, "VENV", tmp_path / ".venv")
    monkeypatch.setattr(doctor.sys, "prefix", str(tmp_path))
    found = findings(doctor.virtual_environment)["environment"]
    assert found.state == doctor.WRONG and found.remedy == "delete the link"


@pytest.mark.skipif(os.name == "nt", reason="servers are none of those")
def test_a_server_whose_environment_is_marked_needs_no_other(monkeypatch, tmp_path):
    """One that has the packages and nothing of ours, before the script has run."""
    theirs = tmp_path / "theirs"
    venv.create(theirs)
    python, packages = theirs / "bin" / "python", sysconfig.get_path("purelib")
    site = next(theirs.glob("lib/*/site-packages"))
    (site / "packages.pth").write_text(packages)

    def ran(*words):
        bare = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
        return subprocess.run([python, *words], cwd=tmp_path, env=bare).returncode

    assert ran("-c", "import mkt")
    assert ran(ROOT / ".binder" / "postBuild") == 0
    assert ran("-c", "import mkt; mkt.SSD()") == 0
    monkeypatch.setattr(environment, "VENV", tmp_path / ".venv")
    monkeypatch.setattr(doctor.sys, "prefix", str(theirs))
    assert findings(doctor.virtual_environment)["environment"].state == doctor.FINE


def test_the_server_installs_what_the_readme_does():
    line = (ROOT / ".binder" / "requirements.txt").read_text().split()
    assert (
        line[0] == "-r"
        and (ROOT / ".binder" / line[1]).resolve() == ROOT / "environment.txt"
    )


def test_every_trouble_has_a_remedy_and_a_code(monkeypatch, capsys):
    monkeypatch.setenv("MKT_DATA", "/nowhere")
    monkeypatch.setattr(doctor, "_version", lambda name: "")
    monkeypatch.setattr(
        environment, "stamp_of", lambda folder: environment.wanted_stamp()
    )
    assert all(
        finding.remedy for finding in doctor.diagnose() if finding.state != doctor.FINE
    )
    assert doctor.main() == 1 and "things to mend" in capsys.readouterr().out


def test_it_runs_where_nothing_is_installed(tmp_path):
    """A copy of the checkout without environment, and a Python without packages."""
    for name in ("environment.txt", "pyproject.toml"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    (tmp_path / "mkt").symlink_to(ROOT / "mkt", target_is_directory=True)
    # Not that of the environment: from 3.14 on it knows its packages even with -S.
    python = sys._base_executable
    done = subprocess.run(
        [python, "-S", "-I", "-c", ELSEWHERE, str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0 and "not set up yet" in done.stdout, (
        done.stdout + done.stderr
    )
