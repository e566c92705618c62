"""The code that a result depends on: all that it reaches, and nothing else."""

import functools
import importlib
import os
import subprocess
import sys
import textwrap
import time
from dataclasses import dataclass
from fractions import Fraction
from importlib.metadata import packages_distributions
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

from mkt import evaluation, plotting
from mkt.autoregression import AutoRegression
from mkt.colors import Joined
from mkt.edges import EdgeBins
from mkt.experiments import dependencies
from mkt.files import PACKAGE, ROOT
from mkt.neighbours import SoftBins
from mkt.scenes import SCENES
from mkt.scenes.drawn import Drawn
from mkt.sequences.carphone import Carphone
from mkt.servoing import loop
from mkt.servoing.controller import Servo
from mkt.trackers.by_name import TRACKERS
from mkt.trackers.combined import Combined
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.scaled import Scaled
from mkt.trackers.ssd import SSD
from tests.test_structure import imports


def names(*things):
    modules = [sys.modules[type(thing).__module__] for thing in things]
    reached = dependencies.reachable([Path(module.__file__) for module in modules])
    return {path.relative_to(PACKAGE).as_posix() for path in reached}


def test_a_run_depends_on_its_tracker_and_source_and_on_no_figure():
    reached = names(Combined(), Drawn("base"))
    assert {
        "trackers/ssd.py",
        "trackers/particle_filter.py",
        "histograms.py",
        "scenes/cordoba2014.py",
        "scenes/layers.py",
        "scenes/rendering.py",
        "checks.py",
    } <= reached
    outside = {"plotting.py", "trackers/guided.py", "sequences/video.py"}
    assert not reached & outside
    assert not any(p.startswith(("figures", "papers", "course")) for p in reached)


@pytest.mark.parametrize(
    "code, reached",
    [
        ("import mkt\nmkt.Kernels('one')", PACKAGE / "kernels.py"),
        ("import mkt as m\nm.Kernels('one')", PACKAGE / "kernels.py"),
        ("from mkt import Kernels", PACKAGE / "kernels.py"),
        ("import helper", "helper.py"),
        ("from helper import ONE", "helper.py"),
        ("from .helper import ONE", "helper.py"),
        ("from . import helper", "helper.py"),
        ("from mine.helper import ONE", "helper.py"),
    ],
)
def test_a_tracker_of_ones_own_depends_on_what_it_uses(code, reached, tmp_path):
    folder = tmp_path / "mine"
    folder.mkdir()
    for name in ("__init__", "helper", "other"):
        (folder / f"{name}.py").write_text("ONE = 1\n")
    (folder / "tracker.py").write_text(code)
    found = dependencies.reachable([folder / "tracker.py"])
    assert folder / reached in found
    assert folder / "other.py" not in found and PACKAGE / "plotting.py" not in found


@pytest.mark.parametrize(
    "code, reached",
    [
        ("import helper", "helper.py"),
        ("from helper import ONE", "helper.py"),
        ("def later():\n    import helper", "helper.py"),
        ("import kit.tools", "kit/tools.py"),
        ("import kit.tools", "kit/__init__.py"),
        ("from kit import tools", "kit/tools.py"),
        ("from spread_out import part", "spread_out/part.py"),
        ("import kit", "helper.py"),
    ],
)
def test_a_tracker_of_ones_own_depends_on_other_folders_too(
    code, reached, tmp_path, monkeypatch
):
    mine, theirs = tmp_path / "mine", tmp_path / "theirs"
    for folder in (mine, theirs / "kit", theirs / "spread_out"):
        folder.mkdir(parents=True)
    (theirs / "kit" / "__init__.py").write_text("import helper")
    for name in ("helper", "other", "kit/tools", "spread_out/part"):
        (theirs / f"{name}.py").write_text("ONE = 1")
    (mine / "tracker.py").write_text(f"{code}\n")
    monkeypatch.syspath_prepend(theirs)
    found = dependencies.reachable([mine / "tracker.py"])
    assert theirs / reached in found and theirs / "other.py" not in found


def test_python_s_own_modules_and_installed_ones_count_by_their_versions(tmp_path):
    path = tmp_path / "tracker.py"
    path.write_text("import json, os, cv2, numpy.linalg, __main__, helper_of_nobody")
    assert dependencies.reachable([path]) == [path]


def test_a_file_of_ones_own_may_be_written_in_any_encoding_that_python_reads(tmp_path):
    path = tmp_path / "tracker.py"
    path.write_text("# coding: latin-1\nname = 'Düne'\n", encoding="latin-1")
    assert dependencies.reachable([path]) == [path]
    assert "Düne" in dependencies.stripped(path)


REWRITTEN = """
import importlib, os, sys, time
import numpy, mkt
sys.path.insert(0, "."); sys.dont_write_bytecode = True
import mine
from mkt.experiments import dependencies
print(dependencies.code_of(mine.Mine()) is None)
time.sleep(0.05)  # the time of a file is exact to some milliseconds
open("helper.py", "w").write("ONE = 2")
print(dependencies.code_of(mine.Mine()) is None)
"""


@pytest.fixture
def own_tracker(tmp_path, monkeypatch):
    """A tracker of the user's own, and the file that its module uses; both are old."""
    monkeypatch.syspath_prepend(tmp_path)
    for name, text in (("aid", "A = 1\n"), ("own", "import aid\nclass Own: pass\n")):
        path = tmp_path / f"{name}.py"
        path.write_text(text)
        os.utime(path, (1e9, 1e9))
    yield importlib.import_module("own").Own(), tmp_path / "aid.py"
    for name in ("aid", "own"):
        del sys.modules[name]


def test_results_of_code_that_was_removed_meanwhile_are_not_kept(own_tracker):
    tracker, used = own_tracker
    assert dependencies.code_of(tracker) is not None
    used.unlink()
    assert dependencies.code_of(tracker) is None


def test_a_file_from_a_clock_that_is_ahead_was_not_rewritten(own_tracker):
    """As on a drive of another machine: its time says nothing, and results are kept."""
    tracker, used = own_tracker
    ahead = time.time() + 3600
    os.utime(used, (ahead, ahead))
    assert dependencies.code_of(tracker) is not None


def test_results_of_code_that_was_rewritten_meanwhile_are_not_kept(tmp_path):
    (tmp_path / "helper.py").write_text("ONE = 1")
    (tmp_path / "mine.py").write_text("import helper\n\nclass Mine:\n    pass\n")
    arguments = [sys.executable, "-c", REWRITTEN]
    done = subprocess.run(arguments, cwd=tmp_path, stdout=subprocess.PIPE, check=True)
    assert done.stdout.split() == [b"False", b"True"]


@pytest.mark.slow
def test_all_that_is_imported_when_a_tracker_runs_is_reached():
    code = (
        "import sys, mkt.trackers.adaptive, mkt.scenes.drawn; "
        "from mkt.scenes import SCENES; SCENES['base']; "
        "print(*(m.__file__ for n, m in sys.modules.items() "
        "if n.startswith('mkt.')))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    loaded = set(done.stdout.split())
    roots = [PACKAGE / "trackers" / "adaptive.py", PACKAGE / "scenes" / "drawn.py"]
    assert loaded <= set(map(str, dependencies.reachable(roots)))


def test_the_hash_feels_code_but_no_comment_docstring_or_layout(tmp_path):
    def hashed(text):
        path = tmp_path / "module.py"
        path.write_text(textwrap.dedent(text))
        dependencies._hash.cache_clear()
        dependencies.stripped.cache_clear()
        dependencies.imported.cache_clear()
        return dependencies._hash((path,))

    plain = hashed('"""One."""\nx = 1\n')
    assert hashed('"""Two."""\n\nx  =  1  # one\n') == plain
    assert hashed('"""One."""\nx = 2\n') != plain


@pytest.mark.parametrize("newer", ["python 3.99.0", "numpy 99.0"])
def test_another_python_or_numpy_makes_another_key(newer, monkeypatch):
    now, before = dependencies.versions(), dependencies.code_of(SSD())
    assert before == dependencies.code_of(SSD())
    name = newer.split()[0]
    assert sum(line.startswith(f"{name} ") for line in now) == 1
    later = [newer if line.startswith(f"{name} ") else line for line in now]
    monkeypatch.setattr(dependencies, "versions", lambda: later)
    dependencies._hash.cache_clear()
    assert dependencies.code_of(SSD()) != before
    dependencies._hash.cache_clear()


def test_every_package_that_numbers_depend_on_is_part_of_the_key():
    """What trackers, scenes and the servoing import, and that of the photographs."""
    scenes = [scene(0) for scene in SCENES.values()]
    roots = dependencies.homes(*TRACKERS.values(), *scenes, loop, evaluation)
    used = chain.from_iterable(map(imports, dependencies.reachable(roots)))
    known = packages_distributions()
    packages = {p for name in used for p in known.get(name.partition(".")[0], ())}
    versions = {line.split()[0] for line in dependencies.versions()}
    assert {"python", "scikit-image", *packages} - {"mkt"} <= versions


OWN_SCENE = """
from functools import partial, wraps
from mkt.scenes import SCENES

def same(function):
    return wraps(function)(lambda *words: function(*words))

@SCENES.register("mine")
def mine(seed, item, ground):
    return SCENES["base"](seed, item, ground)

SCENES.add("wrapped", same(mine))
SCENES.add("partly", partial(mine, ground="grass"))
"""


@pytest.fixture
def own_scene(tmp_path, monkeypatch):
    """The file of a scene of the user's own, which has been imported."""
    monkeypatch.setattr(SCENES, "_entries", dict(SCENES))
    monkeypatch.syspath_prepend(tmp_path)
    path = tmp_path / "scene_of_mine.py"
    path.write_text(OWN_SCENE)
    importlib.import_module("scene_of_mine")
    yield path
    del sys.modules["scene_of_mine"]


def test_a_scene_of_ones_own_counts_with_its_code_and_others_do_not(own_scene):
    drawn = PACKAGE / "scenes" / "drawn.py"
    assert set(dependencies.homes(Drawn("mine", 1))) == {own_scene, drawn}
    assert own_scene in dependencies.homes(Drawn("wrapped", 1))
    assert dependencies.homes(Drawn("base", 1)) == (drawn,)


def test_a_scene_whose_code_cannot_be_found_is_not_kept(own_scene):
    for name, space in (("noted", {"__name__": "nowhere"}), ("nameless", {})):
        exec("def scene(seed, item, ground): pass", space)
        SCENES.add(name, space["scene"])
        assert dependencies.code_of(Drawn(name)) is None
    assert dependencies.code_of(Drawn("partly")) is None


def test_what_was_written_in_a_notebook_is_not_kept():
    space = {"__name__": "nowhere", "dataclass": dataclass}
    exec("@dataclass(frozen=True)\nclass Mine:\n    n: int = 1", space)
    assert dependencies.code_of(space["Mine"]()) is None
    assert dependencies.code_of(SSD(), Carphone(), evaluation) is not None
    assert dependencies.code_of(SSD()) != dependencies.code_of(Combined(), plotting)


@pytest.mark.parametrize(
    "whole, part",
    [
        (ParticleFilter(bins=SoftBins()), "neighbours.py"),
        (
            ParticleFilter(motion=AutoRegression(*[(0.1, 0.1, 0.1)] * 3)),
            "autoregression.py",
        ),
        (Scaled(SSD(), 0.5), "trackers/ssd.py"),
        (Scaled(ParticleFilter(bins=Joined((EdgeBins(),), (1.0,))), 0.5), "edges.py"),
    ],
)
def test_a_run_depends_on_the_parts_that_its_tracker_is_made_of(whole, part):
    assert PACKAGE / part in dependencies.reachable(dependencies.homes(whole))


class Holding:
    """A tracker or a source as one writes it who knows no dataclasses."""

    def __init__(self, part):
        self.part = part


@dataclass(frozen=True)
class Made:
    part: object


class Speaking(Made):
    """It says itself what identifies it, which is not the code of its parts."""

    def identity(self):
        return "mine"


@pytest.mark.parametrize("whole", [Holding, Made, Speaking])
@pytest.mark.parametrize(
    "within",
    [
        lambda part: part,
        lambda part: [{"a": part}],
        lambda part: {part: "a"},
        lambda part: (frozenset({part}), {part}),
    ],
)
def test_a_part_of_a_plain_class_counts_too(whole, within, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    path = tmp_path / "part_of_mine.py"
    path.write_text("class Part:\n    pass\n")
    part = importlib.import_module("part_of_mine").Part()
    assert path in dependencies.homes(whole(within(part)))
    del sys.modules["part_of_mine"]
    assert dependencies.homes(whole(within(part))) is None


def test_what_holds_itself_is_looked_at_once():
    ring = Holding(1)
    ring.part = [ring, SSD()]
    assert PACKAGE / "trackers" / "ssd.py" in dependencies.homes(ring)


def test_parts_of_python_and_of_installed_packages_are_no_code_of_a_tracker():
    parts = Holding([np.zeros(2), np.float64(1), Path("x"), Fraction(1, 2), None, "x"])
    assert dependencies.homes(parts) == (Path(__file__),)


def test_a_tracker_with_a_part_from_a_notebook_is_not_kept():
    space = {"__name__": "nowhere", "dataclass": dataclass}
    exec("@dataclass(frozen=True)\nclass Mine:\n    __call__ = len", space)
    mine = ParticleFilter(bins=space["Mine"]())
    assert dependencies.code_of(mine) is None
    assert dependencies.code_of(Scaled(mine, 0.5)) is None


def test_what_holds_a_function_in_a_partial_is_not_kept():
    held = Servo(gain=functools.partial(max, 1.0))
    assert dependencies.code_of(Servo()) and dependencies.code_of(held) is None


def test_functions_within_what_says_itself_what_it_is_are_its_own_affair():
    for part in (max, functools.partial(max, 1.0), np.float32, SSD, np.poly1d([1, 2])):
        for held in (part, [part], Made(part), Speaking(part)):
            assert dependencies.homes(Speaking(held)) == (Path(__file__),)
        assert dependencies.homes(Made(Speaking(part))) == (Path(__file__),)


def test_a_part_counts_once_it_is_reached_in_one_way():
    held = Made(max)
    for both in (Speaking(held), held), (held, Speaking(held)):
        assert dependencies.homes(Made(both)) is None


@pytest.mark.parametrize("name", TRACKERS)
def test_runs_of_every_tracker_are_kept(name):
    assert dependencies.code_of(TRACKERS[name]) is not None


@pytest.mark.parametrize("name", SCENES)
def test_runs_on_every_scene_are_kept(name):
    assert dependencies.code_of(SCENES[name](500)) is not None


def test_what_is_imported_from_three_packages_up_counts(tmp_path):
    folder = tmp_path / "a" / "b" / "c"
    folder.mkdir(parents=True)
    for place in (folder, folder.parent, folder.parent.parent):
        (place / "__init__.py").touch()
    (tmp_path / "a" / "top.py").touch()
    (folder / "mine.py").write_text("from ...top import x\n")
    assert tmp_path / "a" / "top.py" in dependencies.reachable([folder / "mine.py"])
