"""Who may import whom: a wing imports only wings on the floors below its own.

Each heavy package has few doors.
"""

import ast
import re
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from mkt.experiments.dependencies import names_in

PACKAGE = Path(__file__).parent.parent / "mkt"

# From the ground up.  The method is the modules beside `mkt/__init__.py`; wings on one
# floor do not know one another.
FLOORS = (
    {"method"},
    {"trackers", "scenes", "sequences"},
    {"servoing"},
    {"experiments"},
    {"figures"},
    {"papers", "own_video"},
    {"course"},
)
# Within the method, file by file: what is written above may not import what is below.
METHOD = (
    "types",
    "files",
    "registry",
    "regions",
    "homographies",
    "checks",
    "colors",
    "edges",
    "kernels",
    "histograms",
    "neighbours",
    "silhouettes",
    "particles",
    "autoregression",
    "tracking",
    "evaluation",
    "plotting",
)
ENTRANCES = {"__init__", "__main__"}  # the names for outside, and the command
DOORS = {
    "matplotlib": {"plotting", "figures", "papers", "own_video", "course"},
    "ipywidgets": {"figures", "own_video"},
    "anywidget": {"figures", "own_video"},
    "sphinx": {"course"},
    "nbclient": {"course"},
    "control": {"servoing"},
}
FILES = sorted(PACKAGE.rglob("*.py"))


def parts(path):
    """A file as the parts of its dotted name below ``mkt``."""
    return path.relative_to(PACKAGE).with_suffix("").parts


def wing(parts):
    """The wing of a dotted name: a folder, or the method for what lies beside those."""
    return parts[0] if (PACKAGE / parts[0]).is_dir() else "method"


def floor(wing):
    return next(k for k, wings in enumerate(FLOORS) if wing in wings)


def imports(path):
    """Dotted names that a file imports, or takes from ``mkt``, anywhere in it."""
    tree = ast.parse(path.read_text())
    # As `from mkt import workbench` or `mkt.workbench`: each with its real place.
    yield from (name for name in names_in(tree) if name.startswith("mkt."))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative imports hide the direction"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_point_one_way(path):
    here = parts(path)
    if here[0] in ENTRANCES:
        return
    for name in imports(path):
        package, *there = name.split(".")
        if package == "mkt" and there and there[0] != "__version__":
            assert allowed(here, there), f"{'/'.join(here)}.py must not import {name}"
        elif package in DOORS:
            assert here[0] in DOORS[package], (
                f"{package} has no door in {'/'.join(here)}.py"
            )


def test_every_package_that_is_imported_is_named_among_the_dependencies():
    """What comes by way of another may go with it."""
    project = tomllib.loads((PACKAGE.parent / "pyproject.toml").read_text())["project"]
    lists = [project["dependencies"], *project["optional-dependencies"].values()]
    named = {canonicalize_name(Requirement(one).name) for each in lists for one in each}
    distributions = packages_distributions()
    used = {name.partition(".")[0] for path in FILES for name in imports(path)}
    foreign = used & distributions.keys() - {"mkt"}
    missing = [
        package
        for package in sorted(foreign)
        if named.isdisjoint(map(canonicalize_name, distributions[package]))
    ]
    assert missing == []


def allowed(here, there):
    """Whether a module may import another, both as the parts of their dotted names."""
    mine, theirs = wing(here), wing(there)
    if mine == theirs == "method":
        return METHOD.index(there[0]) < METHOD.index(here[0])
    return mine == theirs or floor(theirs) < floor(mine)


def test_every_wing_has_its_floor():
    assert {
        wing(parts(path)) for path in FILES if parts(path)[0] not in ENTRANCES
    } == set.union(*FLOORS)
    assert {parts(path)[0] for path in PACKAGE.glob("*.py")} == {*METHOD, *ENTRANCES}


def test_the_map_names_every_module():
    """In the text of the package, or of the wing or room that it lies in."""
    inner = [path for path in FILES if parts(path)[0] not in ENTRANCES]
    absent = [path for path in inner if not _is_on_the_map(path)]
    assert absent == [], "name these in the text of the __init__.py above them"


def _is_on_the_map(path):
    name = ".".join(("mkt", *parts(path))).removesuffix(".__init__")
    inits = [folder / "__init__.py" for folder in path.parents]
    maps = [init for init in inits if init in FILES and init != path]
    texts = [ast.get_docstring(ast.parse(init.read_text())) for init in maps]
    return any(f"`{prefix}{name}`" in text for text in texts for prefix in ("", "~"))


LIGHT = (
    "__init__",
    "__main__",
    "files",
    "course/__init__",
    "course/environment",
    "course/labs/__init__",
)


def test_the_method_is_seven_files():
    text = ast.get_docstring(ast.parse((PACKAGE / "__init__.py").read_text("utf-8")))
    points = re.findall(r"^\d\. (.+?);$", text, re.MULTILINE | re.DOTALL)
    assert "*the method*, seven files" in text and len(points) == 7
    assert all(point.count("`mkt.") == 1 for point in points)


def test_the_map_is_light():
    """``import mkt`` and ``python3 -m mkt --help`` need nothing that is installed."""
    commands = [path.relative_to(PACKAGE) for path in PACKAGE.glob("course/commands/*")]
    files = {*LIGHT, "course/cli", *(str(path.with_suffix("")) for path in commands)}
    known = {"mkt"} | {
        f"mkt.{name.removesuffix('/__init__').replace('/', '.')}" for name in files
    }
    for name in files - {"course/commands/__pycache__"}:
        for module in _imported_on_top(PACKAGE / f"{name}.py"):
            standard = module.split(".")[0] in sys.stdlib_module_names
            assert standard or module in known, f"{name} imports {module}"


def _imported_on_top(path):
    """The modules that a file imports before anything in it is called."""
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module
