"""What is kept: whole, healed where it is damaged, and known by all it depends on."""

import json
import os
import subprocess
import sys
import textwrap
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from mkt import evaluation, plotting
from mkt.autoregression import AutoRegression
from mkt.colors import Joined
from mkt.edges import EdgeBins
from mkt.experiments import cache
from mkt.experiments.cache import Shelf
from mkt.files import PACKAGE, ROOT
from mkt.neighbours import SoftBins
from mkt.scenes import SCENES
from mkt.scenes.drawn import Drawn
from mkt.sequences.carphone import Carphone
from mkt.trackers.by_name import TRACKERS
from mkt.trackers.combined import Combined
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.scaled import Scaled
from mkt.trackers.ssd import SSD

TEXT = Shelf("text", ".json", cache.as_json, json.loads)
ARRAYS = Shelf("arrays", ".npz", cache.arrays_as_bytes, cache.arrays_of)


def test_what_is_put_can_be_got(kept):
    assert TEXT.get("a") is None
    TEXT.put("a", {"x": [1, "two"]})
    ARRAYS.put("a", {"x": np.arange(3.0), "words": np.array(["", "tracking"])})
    assert TEXT.get("a") == {"x": [1, "two"]}
    assert ARRAYS.get("a")["x"].tolist() == [0, 1, 2]
    assert ARRAYS.get("a")["words"].tolist() == ["", "tracking"]
    assert {path.parent.parent for path in kept.rglob("a.*")} == {kept}


@pytest.mark.parametrize("shelf", [TEXT, ARRAYS], ids=["text", "arrays"])
@pytest.mark.parametrize("content", [b"", b'{"x"', b"PK\x03\x04", b"\xff\xfe\x00"])
def test_a_damaged_entry_counts_as_missing_and_is_made_again(shelf, content):
    shelf.put("a", {"x": np.arange(2)} if shelf is ARRAYS else 1)
    shelf.place("a").write_bytes(content)
    assert shelf.get("a") is None
    fresh = {"x": np.ones(1)} if shelf is ARRAYS else {"x": 1}
    assert shelf.kept("a", lambda: fresh) == fresh == shelf.get("a")


def test_a_truncated_archive_is_missing():
    ARRAYS.put("a", {"x": np.arange(1000.0)})
    place = ARRAYS.place("a")
    place.write_bytes(place.read_bytes()[:-100])
    assert ARRAYS.get("a") is None


def test_objects_are_not_kept_for_to_read_them_is_to_run_them():
    with pytest.raises(ValueError, match="x is an array of objects"):
        ARRAYS.put("a", {"x": np.array([{}], object)})


def test_what_is_damaged_or_another_one_s_is_missing(kept):
    TEXT.put("a", "mine")
    whole = TEXT.place("a").read_bytes()
    assert TEXT.get("a") == "mine"
    for content in (b"", b"[[[[", whole[:-1], whole[:-2] + b"x]", whole[::-1]):
        TEXT.place("a").write_bytes(content)
        assert TEXT.get("a") is None
    TEXT.place("b").write_bytes(whole)  # that of another key
    assert TEXT.get("b") is None and TEXT.kept("b", lambda: "new") == "new"


def test_what_has_not_been_used_for_longest_goes_first(kept, monkeypatch):
    for name, age in (("old", 3), ("older", 9), ("new", 0)):
        TEXT.put(name, name * 100)
        at = 1e9 - 1e6 * age
        os.utime(TEXT.place(name), (at, at))
    monkeypatch.setattr(cache, "MOST", 1.5 * TEXT.place("old").stat().st_size)
    fresh = Shelf("text", ".json", cache.as_json, json.loads)
    fresh.put("newest", "")
    assert {path.stem for path in (kept / "text").iterdir()} == {"new", "newest"}
    monkeypatch.setattr(cache, "MOST", 0)
    Shelf("text", ".json", cache.as_json, json.loads).put("last", "")
    assert {path.stem for path in (kept / "text").iterdir()} == {"newest", "last"}


def test_what_another_program_takes_away_meanwhile_is_no_trouble(kept):
    TEXT.put("mine", "mine")
    gone = kept / "text" / "theirs.0123.json"  # seen in the folder, but not there
    gone.symlink_to(kept / "nowhere")
    Shelf("text", ".json", cache.as_json, json.loads).put("other", "other")
    assert TEXT.get("mine") == "mine" and TEXT.get("other") == "other"


def test_keys_differ_where_their_parts_do():
    keys = {cache.key(*parts) for parts in ((1,), ("1",), (1, 2), (SSD(),), ())}
    assert len(keys) == 5 and cache.key(SSD()) == cache.key(SSD())
    assert cache.key(SSD()) != cache.key(SSD(iterations=3))
    many, other = np.zeros(2000), np.zeros(2000)
    other[1000] = 1e-12
    assert cache.key(many) != cache.key(other)
    assert cache.identity(many) != cache.identity(other)


def names(*things):
    modules = [sys.modules[type(thing).__module__] for thing in things]
    reached = cache.reachable([Path(module.__file__) for module in modules])
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
    found = cache.reachable([folder / "tracker.py"])
    assert folder / reached in found
    assert folder / "other.py" not in found and PACKAGE / "plotting.py" not in found


REWRITTEN = """
import importlib, os, sys, time
import numpy, mkt
sys.path.insert(0, "."); sys.dont_write_bytecode = True
import mine
from mkt.experiments import cache
print(cache.code_of(mine.Mine()) is None)
time.sleep(0.05)  # the time of a file is exact to some milliseconds
open("helper.py", "w").write("ONE = 2")
print(cache.code_of(mine.Mine()) is None)
"""


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
    assert loaded <= set(map(str, cache.reachable(roots)))


def test_the_hash_feels_code_but_no_comment_docstring_or_layout(tmp_path):
    def hashed(text):
        path = tmp_path / "module.py"
        path.write_text(textwrap.dedent(text))
        cache._hash.cache_clear()
        cache.stripped.cache_clear()
        cache.imported.cache_clear()
        return cache._hash((path,))

    plain = hashed('"""One."""\nx = 1\n')
    assert hashed('"""Two."""\n\nx  =  1  # one\n') == plain
    assert hashed('"""One."""\nx = 2\n') != plain


@pytest.mark.parametrize("newer", ["python 3.99.0", "numpy 99.0"])
def test_another_python_or_numpy_makes_another_key(newer, monkeypatch):
    now, before = cache.versions(), cache.code_of(SSD())
    assert before == cache.code_of(SSD())
    name = newer.split()[0]
    assert sum(line.startswith(f"{name} ") for line in now) == 1
    later = [newer if line.startswith(f"{name} ") else line for line in now]
    monkeypatch.setattr(cache, "versions", lambda: later)
    cache._hash.cache_clear()
    assert cache.code_of(SSD()) != before
    cache._hash.cache_clear()


def test_what_was_written_in_a_notebook_is_not_kept():
    space = {"__name__": "nowhere", "dataclass": dataclass}
    exec("@dataclass(frozen=True)\nclass Mine:\n    n: int = 1", space)
    assert cache.code_of(space["Mine"]()) is None
    assert cache.code_of(SSD(), Carphone(), evaluation) is not None
    assert cache.code_of(SSD()) != cache.code_of(Combined(), plotting)


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
    assert PACKAGE / part in cache.reachable(cache.homes(whole))


def test_a_tracker_with_a_part_from_a_notebook_is_not_kept():
    space = {"__name__": "nowhere", "dataclass": dataclass}
    exec("@dataclass(frozen=True)\nclass Mine:\n    m: int = 1", space)
    assert cache.code_of(ParticleFilter(bins=space["Mine"]())) is None
    assert cache.code_of(Scaled(ParticleFilter(bins=space["Mine"]()), 0.5)) is None


@pytest.mark.parametrize("name", TRACKERS)
def test_runs_of_every_tracker_are_kept(name):
    assert cache.code_of(TRACKERS[name]) is not None


@pytest.mark.parametrize("name", SCENES)
def test_runs_on_every_scene_are_kept(name):
    assert cache.code_of(SCENES[name](500)) is not None


def test_what_cannot_be_touched_can_be_read(monkeypatch):
    def refuse(*_):
        raise PermissionError

    TEXT.put("a", 1)
    monkeypatch.setattr(os, "utime", refuse)
    assert TEXT.get("a") == 1
