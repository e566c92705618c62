"""The library without a clone: a wheel holds all that it needs, and says what it lacks.

The wheel is built from a copy of the clone, without a network, and run in a folder of
its own.
"""

import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from mkt.course import cli, environment
from mkt.files import DATA, PACKAGE, ROOT
from tests.own_video import films

BUILT_FROM = ("pyproject.toml", "setup.py", "README.md", "LICENSE")
BUILD = ("pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A folder of packages with the unpacked wheel in it."""
    place = tmp_path_factory.mktemp("wheel")
    clone = place / "clone"
    for folder in (PACKAGE, DATA):
        shutil.copytree(folder, clone / folder.name)
    for name in BUILT_FROM:
        shutil.copy(ROOT / name, clone)
    words = [sys.executable, "-m", *BUILD, "--wheel-dir", place, clone]
    done = subprocess.run(words, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    [wheel] = place.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(place / "site")
    return place / "site"


@pytest.fixture
def run(site, tmp_path):
    """A way to run Python with that library, in a folder and a home of its own."""

    def run(*words):
        variables = {"PYTHONPATH": str(site), "HOME": str(tmp_path)}
        known = {
            k: v for k, v in os.environ.items() if not k.startswith(("MKT", "XDG"))
        }
        return subprocess.run(
            [sys.executable, *map(str, words)],
            cwd=tmp_path,
            env=known | variables,
            capture_output=True,
            text=True,
            timeout=300,
        )

    return run


def files(folder):
    found = (path for path in folder.rglob("*") if path.is_file())
    names = {path.relative_to(folder).as_posix() for path in found}
    return {name for name in names if "__pycache__" not in name}


@pytest.mark.slow
def test_a_wheel_holds_the_package_and_the_tables_and_nothing_else(site):
    inside = {name for name in files(site) if ".dist-info" not in name}
    package = {f"mkt/{name}" for name in files(PACKAGE)}
    tables = {name for name in files(DATA) if name.endswith((".csv", ".json"))}
    assert inside == package | {f"mkt/data/{name}" for name in tables}


LIBRARY = """
import mkt
from mkt.experiments import cache
assert "site" in mkt.__file__, mkt.__file__
assert len(mkt.verdicts()) and len(mkt.carphone()) == 120
jobs = mkt.jobs({"ssd": mkt.SSD()}, [mkt.drawn("base", 0)])
print(cache.folder(), len(mkt.sweep(jobs, 1)))
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="other systems have other folders")
def test_the_library_finds_its_tables_and_keeps_runs_with_the_user(run, tmp_path):
    done = run("-c", LIBRARY)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [str(tmp_path / ".cache" / "mkt"), "1"]
    assert list((tmp_path / ".cache" / "mkt" / "rows").iterdir())


WITHOUT = """
import sys

class Without:
    def find_spec(self, name, path, target=None):
        if name in {}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Without())
"""


@pytest.fixture
def no_extras(site):
    """Of what pip installs with an extra, nothing can be imported."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        extras = tomllib.load(file)["project"]["optional-dependencies"]
    wanted = {re.split(r"[\[<>=]", one)[0] for each in extras.values() for one in each}
    names = {*(wanted - {"mkt", "myst-nb"}), "IPython", "markdown_it"}
    place = site / "sitecustomize.py"
    place.write_text(WITHOUT.format(sorted(names)), encoding="utf-8")
    yield
    place.unlink()


@pytest.mark.slow
def test_commands_run_from_the_installed_library(run, no_extras, tmp_path):
    films.write(tmp_path / "car.mkv", films.driving(3).frames)
    for words in (
        ("figure", "--list"),
        ("figure", "teuliere2009.fig2", "-o", "x.csv"),
        ("figure", "own.learnt_motion", "-o", "x.pdf"),
        ("track", "car.mkv", "--box", "55,48,50,24", "--tracker", "ssd"),
        ("claims", "--shipped", "T09-c"),
        ("doctor",),
    ):
        done = run("-m", "mkt", *words)
        assert done.returncode == 0, done.stdout + done.stderr
    assert not (tmp_path / ".venv").exists()


@pytest.mark.slow
@pytest.mark.parametrize("command", ["book", "lab", "test", "strip"])
def test_what_needs_the_clone_says_so(run, command):
    done = run("-m", "mkt", command)
    assert done.returncode == 1
    assert done.stderr == f"mkt {command}: {cli.NO_CLONE.format(command)}\n"


@pytest.mark.parametrize("origin", [ROOT, Path("/somewhere/else")])
def test_an_environment_made_by_hand_is_known_by_what_was_installed(
    tmp_path, monkeypatch, origin
):
    listed = tmp_path / "mkt-0.1.0.dist-info"
    listed.mkdir()
    (listed / "METADATA").write_text("Metadata-Version: 2.1\nName: mkt\nVersion: 0\n")
    (listed / "direct_url.json").write_text(f'{{"url": "{origin.as_uri()}"}}')
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    assert environment.is_by_hand() == (origin == ROOT)


def test_a_light_install_names_the_package_that_it_lacks(monkeypatch):
    monkeypatch.setattr(environment, "is_by_hand", lambda: True)
    with pytest.raises(SystemExit, match="the package jupyterlab is missing"):
        with cli.door("lab"):
            raise ModuleNotFoundError("No module", name="jupyterlab")
