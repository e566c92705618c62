"""The doctor: fine things are called fine, each planted trouble is found, and every trouble comes with a remedy."""

import subprocess
import sys

import pytest

from mkt import __main__ as bootstrap
from mkt import doctor, recording
from mkt.cli import ROOT


def findings(check):
    return {finding.name: finding for finding in check()}


def test_what_the_environment_needs_is_there():
    for check in (doctor.machine, doctor.packages, doctor.one_opencv, doctor.codecs, doctor.widgets, doctor.kernel):
        assert not [str(f) for f in check() if f.state == doctor.WRONG]


@pytest.mark.parametrize("version", ["", "1.0"])
def test_a_missing_or_other_package_is_named(monkeypatch, version):
    known = doctor._version
    monkeypatch.setattr(doctor, "_version", lambda name: version if name == "numpy" else known(name))
    found = findings(doctor.packages)["packages"]
    assert found.state == doctor.WRONG and "numpy is " + (version or "missing") in found.found and found.remedy


def test_two_wheels_of_opencv_are_one_too_many(monkeypatch):
    monkeypatch.setattr(doctor, "_version", lambda name: "5.0" if name in ("opencv-python", "opencv-python-headless") else "")
    assert findings(doctor.one_opencv)["OpenCV"].state == doctor.WRONG


def test_a_format_that_cannot_be_written_is_found(monkeypatch):
    monkeypatch.setitem(recording.CODECS, ".webm", "NONE")
    found = findings(doctor.codecs)
    assert found["video .webm"].state == doctor.WRONG and found["video .avi"].state == doctor.FINE


def test_a_folder_of_data_that_is_not_there(monkeypatch, tmp_path):
    monkeypatch.setenv("MKT_DATA", str(tmp_path / "nowhere"))
    assert findings(doctor.data_sets)["data sets"].state == doctor.WRONG
    monkeypatch.delenv("MKT_DATA")
    assert findings(doctor.data_sets)["data sets"].state == doctor.FINE


@pytest.mark.parametrize("stamp, state", [(None, doctor.NOTE), ("unfinished", doctor.NOTE), ("old", doctor.NOTE), ("foreign", doctor.WRONG)])
def test_the_state_of_the_environment(monkeypatch, tmp_path, stamp, state):
    monkeypatch.setattr(bootstrap, "VENV", tmp_path / ".venv")
    monkeypatch.setattr(doctor.sys, "prefix", str(tmp_path))
    if stamp:
        (tmp_path / ".venv").mkdir()
        (tmp_path / ".venv" / ("something" if stamp == "foreign" else bootstrap.STAMP_NAME)).write_text(stamp)
    found = findings(doctor.environment)["environment"]
    assert found.state == state and found.remedy


def test_a_server_whose_environment_is_marked_needs_no_other(monkeypatch, tmp_path):
    monkeypatch.setattr(bootstrap, "VENV", tmp_path / ".venv")
    monkeypatch.setattr(doctor.sys, "prefix", str(tmp_path))
    exec(compile((ROOT / ".binder" / "postBuild").read_text(), "postBuild", "exec"), {})
    assert findings(doctor.environment)["environment"].state == doctor.FINE


def test_the_server_installs_what_the_readme_does():
    line = (ROOT / ".binder" / "requirements.txt").read_text().split()
    assert line[0] == "-r" and (ROOT / ".binder" / line[1]).resolve() == ROOT / "environment.txt"


def test_every_trouble_has_a_remedy_and_a_code(monkeypatch, capsys):
    monkeypatch.setenv("MKT_DATA", "/nowhere")
    monkeypatch.setattr(doctor, "_version", lambda name: "")
    monkeypatch.setattr(bootstrap, "stamp_of", lambda folder: bootstrap.wanted_stamp())
    assert all(finding.remedy for finding in doctor.diagnose() if finding.state != doctor.FINE)
    assert doctor.main() == 1 and "things to mend" in capsys.readouterr().out


def test_it_runs_where_nothing_is_installed(tmp_path):
    """A copy of the checkout without environment, and a Python without packages."""
    for name in ("environment.txt", "pyproject.toml"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    (tmp_path / "mkt").symlink_to(ROOT / "mkt", target_is_directory=True)
    code = (f"import sys; sys.path.insert(0, {str(tmp_path)!r}); sys.argv = ['mkt', 'doctor']; import pathlib; from mkt import __main__ as b; "
            f"b.VENV = pathlib.Path({str(tmp_path)!r}) / '.venv'; sys.exit(b.main())")
    done = subprocess.run([sys.executable, "-S", "-I", "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and "not set up yet" in done.stdout, done.stdout + done.stderr
