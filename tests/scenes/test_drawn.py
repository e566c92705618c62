"""The registry of all scenes, and the rule by which they are drawn."""

import pickle
from functools import partial

import pytest

from mkt.scenes import SCENES
from mkt.scenes.cards import card
from mkt.scenes.cordoba2014 import KINDS
from mkt.scenes.drawn import GROUNDS, ITEMS, Drawn, drawn
from mkt.scenes.nummiaro2003 import parking, students, traffic
from mkt.scenes.two_cameras import TwoViews
from mkt.scenes.varied import Varied
from mkt.servoing.robot import to_and_fro


def test_all_scenes_are_found_by_name():
    tests = {"base", "look-alike", "occlusion", "blur", "illumination"}
    assert set(SCENES) == tests | {"fast", "hidden"} | set(KINDS)


@pytest.mark.parametrize("kind", SCENES)
def test_every_scene_takes_seed_item_and_ground(kind):
    scene = SCENES[kind](1, item="hopper", ground="tissue")
    assert (scene.target.texture, scene.background) == ("hopper", "tissue")
    assert scene.seed == 1 and SCENES[kind](1).target.texture == "car"
    assert len({scene, SCENES[kind](1, "hopper", "tissue")}) == 1  # hashable, and equal


def test_sixteen_seeds_are_all_pairs():
    pairs = {(drawn("base", k).item, drawn("base", k).ground) for k in range(16)}
    assert pairs == {(item, ground) for item in ITEMS for ground in GROUNDS}


def test_a_drawn_scene_is_a_source():
    """Its specification says all, and can be sent to a worker process."""
    source = drawn("fast", 6)
    assert source == pickle.loads(pickle.dumps(source)) != drawn("fast", 7)
    assert source.scene() == SCENES["fast"](6, "motorcycle", "tissue")
    assert source.sequence().name == source.name == "fast"


SEEDED = {name: SCENES[name] for name in SCENES} | {
    "Drawn": partial(Drawn, "base"),
    "drawn": partial(drawn, "base"),
    "students": students,
    "parking": parking,
    "traffic": traffic,
    "card": partial(card, "base"),
    "Varied": partial(Varied, "swift"),
    "TwoViews": TwoViews,
    "to_and_fro": to_and_fro,
}


@pytest.mark.parametrize("make", SEEDED.values(), ids=SEEDED)
@pytest.mark.parametrize("seed", [-1, 1.5, "a"])
def test_what_is_no_seed_is_refused(make, seed):
    with pytest.raises(ValueError, match=f"^seed is {seed!r}; it must be a whole"):
        make(seed)


def test_an_unknown_kind_is_told_with_the_known_ones():
    with pytest.raises(ValueError, match="no scene 'fastt', perhaps fast.*there are"):
        Drawn("fastt").sequence()
