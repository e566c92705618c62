"""What is kept: whole, healed where it is damaged, and known by all it depends on."""

import errno
import json
import os
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from mkt.experiments import cache
from mkt.experiments.cache import Shelf
from mkt.servoing.controller import Servo
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


def test_what_has_been_read_counts_as_used(kept, monkeypatch):
    for name, age in (("old", 3), ("older", 9)):
        TEXT.put(name, name * 100)
        at = 1e9 - 1e6 * age
        os.utime(TEXT.place(name), (at, at))
    assert TEXT.get("older") == "older" * 100
    monkeypatch.setattr(cache, "MOST", 1.5 * TEXT.place("older").stat().st_size)
    Shelf("text", ".json", cache.as_json, json.loads).put("newest", "")
    assert {path.stem for path in (kept / "text").iterdir()} == {"older", "newest"}


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


@dataclass(frozen=True)
class Quiet:
    """What it prints does not tell one from the other."""

    reach: float = field(repr=False)


class Plain:
    """As one writes a class that is no dataclass; it prints its address."""

    def __init__(self, reach):
        self.reach = reach


class Secret(Plain):
    def __repr__(self):
        return "Secret()"


class Grown(SSD):
    """A subclass of a dataclass that is none itself."""

    def __init__(self, reach):
        super().__init__()
        object.__setattr__(self, "reach", reach)


class Pair(tuple):
    """A container that keeps more than it contains."""

    def __new__(cls, reach):
        made = super().__new__(cls, (1, 2))
        made.reach = reach
        return made


@pytest.mark.parametrize("kind", [Quiet, Plain, Secret, Grown, Pair])
@pytest.mark.parametrize("within", [lambda x: x, lambda x: [x], lambda x: {"a": x}])
def test_keys_go_by_what_a_thing_is_not_by_what_it_prints(kind, within):
    one, same, other = (within(kind(reach)) for reach in (0.5, 0.5, 4.0))
    assert cache.identity(one) == cache.identity(same) != cache.identity(other)
    assert cache.key(one) == cache.key(same) != cache.key(other)


def test_a_key_outlives_what_a_thing_has_computed_for_itself():
    before = cache.key(Servo())
    assert Servo().goal.shape == (4,)
    servo = Servo()
    assert servo.goal.shape == (4,) and cache.key(servo) == before


def test_what_hides_something_has_no_key():
    loop = Plain(0)
    loop.reach = loop
    hidden = np.random.default_rng(0), len, Plain(iter([1])), np.array([{}]), loop
    assert [cache.key(SSD(), each) for each in hidden] == [None] * len(hidden)
    assert [cache.identity(each) for each in hidden] == [None] * len(hidden)


@pytest.mark.parametrize("kind", [set, frozenset])
def test_the_key_of_a_set_does_not_go_by_its_order(kind):
    """Which is that of coming for 0 and 64, and differs from day to day for words."""
    first, second = kind([0, 64]), kind([64, 0])
    assert list(first) != list(second)
    assert cache.key(first) == cache.key(second) != cache.key(kind([0]))


def test_keys_differ_where_numbers_do_in_their_last_digit():
    number = np.array([0.1])
    assert cache.key(number) != cache.key(np.nextafter(number, 1))


def test_what_cannot_be_touched_can_be_read(monkeypatch):
    def refuse(*_):
        raise PermissionError

    TEXT.put("a", 1)
    monkeypatch.setattr(os, "utime", refuse)
    assert TEXT.get("a") == 1


def test_what_cannot_be_kept_is_made_all_the_same_and_said_once(kept, capsys):
    kept.write_text("no folder")
    assert TEXT.kept("a", lambda: "new") == "new" and TEXT.get("a") is None
    ARRAYS.put("a", {"x": np.arange(3)})
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"{kept} cannot be written (")
    assert "let MKT_CACHE name another folder" in line and "room" not in line


def test_why_it_cannot_be_kept_is_said_in_the_words_of_the_system(
    kept, monkeypatch, capsys
):
    def refuse(*_, **__):
        raise PermissionError(errno.EACCES, "Permission denied", "a.json")

    kept.mkdir()
    monkeypatch.setattr(Path, "write_bytes", refuse)
    TEXT.put("a", 1)
    assert f"{kept} cannot be written (Permission denied), " in capsys.readouterr().err
    assert TEXT.get("a") is None
