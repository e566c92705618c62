"""Settings in a file: written, read again, refused, and the video that they are of."""

import json

import numpy as np
import pytest

from mkt.files import DataError
from mkt.own_video.settings import (
    Settings,
    changed_versions,
    chosen_frames,
    fingerprint,
    load,
    settled,
    with_numbers,
)
from tests.own_video import films


def test_numbers_are_changed_by_name_also_in_a_filter_inside():
    assert with_numbers("combined", {"n": 30, "threshold": 0.5}).filter.n == 30
    assert with_numbers("guided", {"n": 30, "found": 1}).found == 1.0
    with pytest.raises(ValueError, match="no number 'm'; it has n, lam, lost_above"):
        with_numbers("pf-75", {"m": 3})
    with pytest.raises(ValueError, match="n is 30.5; it must be a whole number"):
        with_numbers("pf-75", {"n": 30.5})


def test_settings_come_back_as_they_were_written(car, place):
    numbers = {"n": 30, "threshold": 0.1 + 0.2}
    box = (0.1, 1 / 3, 50, 40, -7.25)
    written = settled(car, box, "combined", numbers, seed=7)
    written.save(place / "x.json")
    assert load(place / "x.json") == written
    assert written.numbers == numbers


def test_a_fingerprint_is_that_of_sha256sum_and_a_folder_has_one_too(place):
    (place / "a.png").write_bytes(b"abc")
    assert fingerprint(place / "a.png") == (
        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    )
    before = fingerprint(place)
    (place / "note.txt").write_text("not an image")
    assert fingerprint(place) == before
    (place / "b.png").write_bytes(b"abc")
    assert fingerprint(place) != before


def test_the_same_images_in_another_order_are_another_film(place):
    films = []
    for order in ("abc", "acb"):
        folder = place / order
        (folder / "4.png").mkdir(parents=True)
        for name, content in zip(("1", "2", "10"), order, strict=True):
            (folder / f"{name}.png").write_text(content)
        films.append(fingerprint(folder))
    assert films[0] != films[1]
    (place / "acb" / "10.png").rename(place / "acb" / "1b.png")
    assert fingerprint(place / "acb") == films[0]


def test_another_video_under_the_same_name_is_noticed_and_a_moved_one_is_found(
    car, place
):
    gone = (
        "the video is gone; if it has moved, say where it is now: "
        "python3 -m mkt track VIDEO --settings"
    )
    another = (
        "not the video of x.json: its sha256 is .*; take the very file that was tracked"
    )
    settled(car, films.BOX).save(place / "x.json")
    moved = car.rename(place / "moved.mkv")
    with pytest.raises(DataError, match=gone):
        load(place / "x.json")
    assert load(place / "x.json", moved).video == str(moved)
    car.write_bytes(moved.read_bytes() + b"x")
    with pytest.raises(DataError, match=another):
        load(place / "x.json")


def test_a_path_in_the_settings_may_be_relative_to_them(car, place, monkeypatch):
    settled(car, films.BOX).save(place / "x.json")
    text = (place / "x.json").read_text()
    (place / "x.json").write_text(text.replace(json.dumps(str(car)), '"car.mkv"'))
    assert str(place) not in (place / "x.json").read_text()
    monkeypatch.chdir("/")
    assert load(place / "x.json").video == str(car)


@pytest.mark.parametrize(
    "change, said",
    [
        (
            {"box": [1, 2, 3, 4]},
            r"x.json: box is \[1, 2, 3, 4\]; it must be a list of five finite numbers",
        ),
        ({"box": [1, 2, 3, 4, "x"]}, "box is"),
        ({"seed": 1.5}, "seed is 1.5"),
        ({"seed": -1}, "seed is -1"),
        ({"numbers": {"n": -3}}, "x.json: particles is -3"),
        ({"numbers": {"zorg": 3}}, "x.json: the tracker .* has no number 'zorg'"),
        ({"numbers": {"n": None}}, "n in numbers is None"),
        ({"numbers": {"n": 10**400}}, "n in numbers is"),
        ({"box": [0, 0, 10**400, 1, 0]}, "box is"),
        ({"video": 3}, "video is 3"),
        ({"video": ""}, "x.json: video is ''; it must be a text that is not empty"),
        ({"video": "caf\udce9.mkv"}, r"caf\\udce9.mkv: the name is not UTF-8"),
        ({"sha256": None}, "sha256 is None"),
        ({"tracker": []}, r"tracker is \[\]"),
        ({"tracker": {}}, "tracker is {}"),
        ({"versions": 5}, "versions is 5"),
        ({"versions": None}, "versions is None"),
        ({"versions": {"numpy": 2}}, "numpy in versions is 2"),
        ({"a\nb": 1}, "missing or unknown: a b"),
        ({"more": 1}, "missing or unknown: more"),
    ],
)
def test_wrong_settings_are_named(change, said, car, place):
    settled(car, films.BOX).save(place / "x.json")
    values = json.loads((place / "x.json").read_text()) | change
    (place / "x.json").write_text(json.dumps(values))
    with pytest.raises(DataError, match=said):
        load(place / "x.json")


@pytest.mark.parametrize(
    "change, said",
    [
        ({"every": 0}, "every is 0; it must be a whole number, at least 1"),
        ({"last": 1.5}, "last is 1.5; it must be a whole number, at least 0, or noth"),
        ({"every": 1.5}, "every is 1.5"),
        ({"first": -1}, "first is -1"),
        ({"scale": 0}, "scale is 0; it must be above 0 and at most 1"),
        ({"box": (1, 2, 3)}, r"box is \(1, 2, 3\); give four or five numbers: x, y, w"),
        ({"box": 5}, "box is 5; give four"),
        ({"box": (1, 2, 3, 10**400)}, "box is"),
        ({"box": (1, 2, 3, 4, np.nan)}, "box is"),
        ({"numbers": {"n": np.inf}}, "n is inf; it must be a finite number"),
        ({"numbers": {"lost_above": None}}, "lost_above is None"),
    ],
)
def test_settings_that_cannot_be_are_named_where_they_are_made(change, said, car):
    with pytest.raises(ValueError, match=said):
        settled(**{"video": car, "box": films.BOX} | change)


@pytest.mark.parametrize(
    "first, last, every, frames",
    [
        (0, None, 1, [0, 1, 2, 3, 4, 5, 6, 7]),
        (2, 6, 2, [2, 4, 6]),
        (6, 7, 1, [6, 7]),
        (3, 3, 1, [3]),  # a picture
        (7, None, 5, [7]),
    ],
)
def test_the_last_frame_that_is_named_is_one_of_them(first, last, every, frames):
    part = chosen_frames(films.driving(8), first, last, every)
    assert list(range(8)[part]) == frames


@pytest.mark.parametrize(
    "first, last, every, said",
    [
        (-1, None, 1, "frames from -1 on: .* has 0 to 7"),
        (-3, 5, 1, "frames -3 to 5: .* has 0 to 7"),
        (6, 7, 2, "every 2-th frame: of 6 to 7 that is one alone"),
    ],
)
def test_frames_that_cannot_be_chosen_are_named(first, last, every, said):
    with pytest.raises(ValueError, match=said):
        chosen_frames(films.driving(8), first, last, every)


@pytest.mark.parametrize(
    "part", [{"first": 1}, {"last": 2}, {"every": 2}, {"scale": 0.5}]
)
def test_each_choice_of_what_is_looked_at_is_kept_apart(part, car):
    box = (10, 10, 50, 40)
    assert settled(car, box, **part).identity() != settled(car, box).identity()
    assert settled(car, box, seed=7).identity() == settled(car, box).identity()


def test_a_box_may_be_an_array(car):
    assert settled(car, np.array(films.BOX, float)) == settled(car, films.BOX)


def test_a_box_of_four_numbers_is_not_turned(car):
    assert settled(car, films.BOX[:4]).box == (*films.BOX[:4], 0)


def test_numbers_may_be_numpy_s(car, place):
    numbers = {"first": np.int64(1), "last": np.int32(3), "scale": np.float32(0.5)}
    written = settled(car, films.BOX, seed=np.uint8(7), **numbers)
    written.save(place / "x.json")
    assert load(place / "x.json") == written
    assert (written.first, written.last, written.seed) == (1, 3, 7)


def test_a_file_may_begin_with_the_mark_of_utf_8(car, place):
    settled(car, films.BOX).save(place / "x.json")
    text = (place / "x.json").read_text()
    (place / "x.json").write_text(text, encoding="utf-8-sig")
    assert load(place / "x.json") == settled(car, films.BOX)


@pytest.mark.parametrize(
    "text, said",
    [
        ("{\n", "x.json, line 2: not JSON"),
        ("[]", "missing or unknown: box, numbers, seed"),
        ("\xff", "not text in UTF-8"),
        ("9" * 5000, "a number or a list in it is too long; let"),
        ("[" * 100_000, "a number or a list in it is too long; let"),
    ],
)
def test_what_is_no_settings_file_is_said(text, said, place):
    (place / "x.json").write_text(text, encoding="latin-1")
    with pytest.raises(DataError, match=said):
        load(place / "x.json")


def test_other_versions_are_mentioned(car):
    assert changed_versions(settled(car, films.BOX)) == ""
    old = Settings("x", "y", films.BOX, versions={"numpy": "1.0", "gone": "2"})
    changed = changed_versions(old)
    assert changed.startswith("numpy 1.0 is ")
    assert changed.endswith("gone 2 is missing here")
