"""Who may import whom: no arrow points back, and each heavy package has few doors."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "mkt"

# Each module may import those named here and nothing else of the package.
CORE = {"regions", "kernels", "histograms", "particles", "tracking"}
MATERIAL = CORE | {"files", "trackers", "textures", "scenes", "scenarios", "stories", "twins", "archives", "video", "datasets", "evaluation", "plotting", "servo", "kalman", "robot", "loop"}
ALLOWED = {
    "__init__": set(),
    "__main__": {"cli"},
    "files": set(),
    "regions": set(),
    "kernels": {"regions"},
    "histograms": {"regions", "kernels"},
    "tracking": {"regions"},
    "particles": {"regions"},
    "trackers": CORE | {"trackers"},
    "video": set(),
    "datasets": {"regions", "tracking", "video"},
    "textures": {"datasets", "video"},
    "scenes": {"regions", "tracking", "textures"},
    "scenarios": {"scenes"},
    "stories": {"datasets", "scenes", "tracking"},
    "twins": {"scenes"},
    "archives": {"datasets", "evaluation", "video"},
    "sweeps": CORE | {"archives", "evaluation", "files", "scenarios", "scenes", "twins"},
    "evaluation": {"regions", "tracking"},
    "servo": {"regions"},
    "kalman": {"servo"},
    "robot": {"regions", "servo", "textures"},
    "loop": {"regions", "tracking", "servo", "kalman", "robot"},
    "plotting": {"regions", "kernels", "histograms", "tracking"},
    "recording": {"files", "regions", "tracking", "plotting", "video"},
    "settings": {"files", "regions", "trackers", "datasets", "video"},
    "webcam": {"recording", "video"},
    "workbench": MATERIAL | {"recording", "animation", "settings", "webcam", "workbench"},
    "animation": {"recording"},
    "figures": MATERIAL | {"figures"},
    "export": MATERIAL,
    "page": MATERIAL | {"figures"},
    "widgets": MATERIAL | {"figures", "page"},
    "bench": MATERIAL | {"figures"},
    "claims": MATERIAL | {"figures", "sweeps", "claims"},
    "leaderboard": MATERIAL | {"archives", "sweeps", "claims"},
    "book": MATERIAL | {"figures", "export", "page", "widgets", "book", "claims", "leaderboard"},
    "doctor": {"__main__", "archives", "recording", "video"},
    "labs": {"book", "files", "labs"},
    "cli": MATERIAL | {"labs", "doctor", "archives", "leaderboard", "figures", "export", "widgets", "book", "bench", "recording", "settings", "claims", "sweeps"},
}
DOORS = {
    "matplotlib": {"plotting", "figures", "export", "widgets", "bench", "cli"},
    "ipywidgets": {"widgets", "workbench"},
    "anywidget": {"workbench"},
    "sphinx": {"book"},
    "nbclient": {"book", "labs"},
    "control": {"kalman"},
}
FILES = sorted(PACKAGE.rglob("*.py"))


def room(path):
    """The module or sub-package of a file, as ALLOWED names it."""
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


def imports(path):
    """Dotted names that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative imports hide the direction"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_point_one_way(path):
    assert room(path) in ALLOWED, f"{path.name} is not on the plan: say in tests/test_structure.py what it may import"
    for name in imports(path):
        package, _, rest = name.partition(".")
        if package == "mkt" and rest.split(".")[0] in ALLOWED:
            assert rest.split(".")[0] in ALLOWED[room(path)], f"{path.name} must not import {name}"
        elif package in DOORS:
            assert room(path) in DOORS[package], f"{package} has no door in {path.name}"


def test_the_map_is_light():
    """``import mkt`` works before anything is installed."""
    for name in ("__init__", "__main__", "cli"):
        top = ast.parse((PACKAGE / f"{name}.py").read_text()).body
        packages = [alias.name for node in top if isinstance(node, ast.Import) for alias in node.names]
        packages += [node.module for node in top if isinstance(node, ast.ImportFrom)]
        assert all(p.split(".")[0] in __import__("sys").stdlib_module_names for p in packages), f"{name}: {packages}"
