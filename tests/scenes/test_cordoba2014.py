"""The six twins: each has the difficulty that it is named for, over several seeds."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from mkt.regions import HX, HY
from mkt.scenes import SCENES
from mkt.scenes.cordoba2014 import KINDS, LENGTH, TALLEST, scale
from mkt.scenes.rendering import regions, render

SEEDS = range(6)
TIMES = np.arange(LENGTH, dtype=float)


def truth(kind, seed):
    scene = SCENES[kind](seed)
    return regions(scene, scene.target, TIMES)


@pytest.mark.parametrize("kind", KINDS)
def test_long_enough_upright_and_inside_the_image(kind):
    assert LENGTH >= 150
    for seed in SEEDS:
        scene = SCENES[kind](seed)
        assert scene.length == LENGTH and scene.seed == seed
        path = truth(kind, seed)
        assert np.abs(np.rad2deg(path[:, 2])).max() < 5
        inside = (path[:, :2] > 0).all(1) & (path[:, :2] < [320, 240]).all(1)
        assert inside.mean() > 0.95 and inside[0]


@pytest.mark.parametrize("kind", KINDS)
def test_everything_follows_from_the_arguments(kind):
    twin = SCENES[kind]
    assert twin(3) == twin(3)
    assert twin(3) != twin(4)
    other = twin(3, "hopper", "gravel")
    assert other.target.texture == "hopper" and other.background == "gravel"
    assert other.target.path == twin(3).target.path


@pytest.mark.parametrize("kind", ["passers", "pillars"])
@pytest.mark.parametrize("seed", [0, 1])
def test_three_total_occlusions(kind, seed):
    hidden = SCENES[kind](seed).sequence().visibility < 0.02
    assert not hidden[:15].any()
    assert np.sum(~hidden[:-1] & hidden[1:]) >= 3
    assert 10 <= hidden.sum() <= LENGTH / 2


def test_look_alikes_are_the_object_in_other_colors():
    for seed in SEEDS:
        scene = SCENES["passers"](seed)
        own = tuple(replace(layer, hue=0.0) for layer in scene.front)
        assert {layer.texture for layer in scene.front} == {scene.target.texture}
        for k in (40, 80, 120):  # of a passing
            assert change(scene, replace(scene, front=own), scene.target, k) > 4


def change(scene, other, layer, k):
    """How differently two scenes show the middle of a layer in a frame [grey levels].

    Without blur and noise.
    """
    x, y, _, hx, hy = regions(scene, layer, float(k))
    rows = slice(max(int(y - hy / 2), 0), int(y + hy / 2))
    columns = slice(max(int(x - hx / 2), 0), int(x + hx / 2))
    one, two = (
        render(replace(each, noise=0.0, shutter=0.0), k)[rows, columns].astype(float)
        for each in (scene, other)
    )
    return np.abs(one - two).mean()


def test_four_copies_of_the_item_are_seen_round_it():
    """The first has its colours, too."""
    for seed in SEEDS:
        scene = SCENES["clutter"](seed)
        bare = replace(scene, behind=())
        assert len(scene.behind) == 4 and scene.behind[0].hue == 0
        assert {layer.texture for layer in scene.behind} == {scene.target.texture}
        assert min(change(scene, bare, layer, 0) for layer in scene.behind) > 30
        assert change(scene, bare, scene.target, 0) == 0


def test_look_alikes_come_from_either_side():
    """Each crosses the whole image."""
    ways = np.array([[p.path for p in SCENES["passers"](seed).front] for seed in SEEDS])
    steps = np.diff(ways[..., 1], axis=-1)
    assert (np.abs(steps) > 320).all() and set(np.sign(steps).flat) == {-1, 1}


def test_the_camera_goes_along_behind_the_pillars():
    """The object walks far, and yet stays in the middle of the screen."""
    for seed in SEEDS:
        way = np.ptp(np.array(SCENES["pillars"](seed).target.path)[:, 1])
        assert np.ptp(truth("pillars", seed)[:, 0]) < way / 3


def over_seeds(measure):
    """What a measure of the true path (T, 5) gives for each kind, over the seeds."""
    return {kind: [measure(truth(kind, seed)) for seed in SEEDS] for kind in KINDS}


def ratio(path):
    """Logarithm of the largest size over the smallest."""
    return np.ptp(np.log(path[:, HX]))


def step(path):
    """The longest way of the centre from one frame to the next [px]."""
    return np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1).max()


def test_size_changes_by_more_than_half_only_where_it_is_the_question():
    ratios = over_seeds(ratio)
    assert min(ratios.pop("scale")) > 0.6
    assert max(map(max, ratios.values())) < 0.7


def test_steps_are_large_only_where_they_are_the_question():
    steps = over_seeds(step)
    assert min(steps.pop("trajectory")) > 18
    assert max(map(max, steps.values())) < 18


def test_the_ground_changes_under_the_pan():
    """The strip above the object has another mean colour in each fifth."""
    frames = SCENES["background"](0).sequence().frames
    means = [frames[k][:40].mean((0, 1)) for k in (0, 40, 80, 120)]
    assert min(np.linalg.norm(a - b) for a, b in combinations(means, 2)) > 5


def test_a_tall_item_is_as_high_as_the_scene_has_room_for():
    scene = scale(0, "student")
    region = regions(scene, scene.target, 0.0)
    assert 2 * region[HY] == pytest.approx(TALLEST)
