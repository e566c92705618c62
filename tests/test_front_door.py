"""The package's own names: `import mkt` loads nothing, and each name what it needs."""

import datetime
import importlib
import re
import subprocess
import sys
from types import ModuleType

import nbformat
import pytest

import mkt
from mkt.files import PACKAGE, ROOT
from mkt.scenes.textures import resized, texture

WINGS = (
    "trackers",
    "scenes",
    "sequences",
    "servoing",
    "experiments",
    "figures",
    "papers",
    "own_video",
    "course",
)
LOADED = """
import sys
before = set(sys.modules)
import mkt
print(*sorted(set(sys.modules) - before))
"""


def printed(code):
    """What a program prints in a Python of its own."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_importing_the_package_loads_nothing_else():
    loaded = set(printed(LOADED).split())
    assert "mkt" in loaded
    assert {name for name in loaded if name.startswith("mkt")} == {"mkt"}
    packages = {name.partition(".")[0] for name in loaded - {"mkt"}}
    assert packages <= sys.stdlib_module_names


def test_what_few_need_of_scipy_waits_until_it_is_needed():
    """Each of these takes longer to import than all of the library."""
    modules = "mkt.papers.runs, mkt.course.own_tracker"
    loaded = printed(LOADED.replace("import mkt\n", f"import {modules}\n")).split()
    assert "mkt.papers.runs" in loaded
    assert not {"scipy.interpolate", "scipy.ndimage", "scipy.spatial"} & {*loaded}


@pytest.mark.parametrize("name", mkt.NAMES)
def test_every_name_is_that_of_its_module(name):
    home = importlib.import_module(mkt.NAMES[name])
    assert getattr(mkt, name) is getattr(home, name)
    assert name in dir(mkt)


# What says old names may say them: the list of changes.
TEXTS = sorted(
    {*ROOT.glob("*.md"), *ROOT.glob("notebooks/**/*.ipynb"), *PACKAGE.rglob("*.md")}
    - {ROOT / "CHANGELOG.md"}
)


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.name)
def test_texts_and_notebooks_name_what_is_there(path):
    """Most cells of labs, and of what the book leaves out, run in slow tests alone."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".ipynb":
        text = "\n".join(cell.source for cell in nbformat.reads(text, 4).cells)
    named = {*re.findall(r"\bmkt\.([A-Za-z]\w*)", text)}
    gone = [name for name in named if not hasattr(mkt, name)]
    assert not gone, f"{path.name} has mkt.{', mkt.'.join(gone)}; see mkt.NAMES"


def test_names_are_completed_before_they_are_loaded():
    assert printed("import mkt; print({*mkt.NAMES} <= {*dir(mkt)})") == "True\n"


@pytest.mark.parametrize("name", ["Nonsense", "no_such_module", "__wrapped__"])
def test_an_unknown_name_is_an_attribute_error_in_a_sentence(name):
    said = f"module 'mkt' has no attribute '{name}'"
    with pytest.raises(AttributeError, match=said):
        getattr(mkt, name)
    with pytest.raises(ImportError, match=f"cannot import name '{name}' from 'mkt'"):
        exec(f"from mkt import {name}")
    assert not hasattr(mkt, name)


def test_a_package_that_is_missing_is_not_taken_for_a_wrong_name():
    code = (
        "import sys; sys.modules['numpy'] = None\n"
        "import mkt\n"
        "try:\n"
        "    mkt.SSD\n"
        "except ModuleNotFoundError as error:\n"
        "    print(error.name)\n"
    )
    assert printed(code) == "numpy\n"


def test_names_can_be_imported_from_the_package():
    from mkt import SSD, track
    from mkt.trackers import ssd
    from mkt.tracking import track as its_own

    assert SSD is ssd.SSD and track is its_own


def test_a_name_is_there_without_its_module_having_been_imported():
    code = "from mkt import SSD, track; print(SSD().iterations, track.__module__)"
    assert printed(code) == "10 mkt.tracking\n"


@pytest.mark.parametrize("name", [*WINGS, "tracking", "regions"])
def test_wings_and_modules_resolve(name):
    module = getattr(mkt, name)
    assert isinstance(module, ModuleType) and module.__name__ == f"mkt.{name}"
    assert printed(f"import mkt; print(mkt.{name}.__name__)") == f"mkt.{name}\n"


@pytest.mark.parametrize(
    "array",
    [
        mkt.bin_colors(mkt.ColorBins()),
        mkt.smoothing(mkt.ColorBins()).data,
        resized("car", 0.5),
        texture("car"),
    ],
    ids=["colours", "smoothing", "resized", "texture"],
)
def test_nobody_can_write_to_what_is_computed_once(array):
    with pytest.raises(ValueError, match="read-only"):
        array[...] = 0


def test_every_file_that_is_cited_names_one_version_and_its_day():
    """What is not released yet stands above it, and is of no version."""
    text = {
        name: (ROOT / name).read_text(encoding="utf-8")
        for name in ("CHANGELOG.md", "CITATION.cff", "README.md", "paper.bib")
    }
    headings = re.findall(r"^## (.*)$", text["CHANGELOG.md"], re.MULTILINE)
    released = [each for each in headings if each != "Not yet released"]
    version, day = released[0].split(", ")
    assert version == mkt.__version__
    date = datetime.datetime.strptime(day, "%d %B %Y").date()
    assert f'version: {version}\ndate-released: "{date}"\n' in text["CITATION.cff"]
    assert f"This is version {version} of {day};" in text["README.md"]
    cited = f"version = {{{version}}},\n  year    = {{{date.year}}}"
    assert cited in text["README.md"] and cited in text["paper.bib"]
