"""The six twins: each has the difficulty that it is named for, over several seeds."""

import numpy as np
import pytest

from mkt.regions import HX
from mkt.scenes import regions, sequence
from mkt.twins import LENGTH, TWINS

SEEDS = range(6)
TIMES = np.arange(LENGTH, dtype=float)


def truth(kind, seed):
    scene = TWINS[kind](seed)
    return regions(scene, scene.target, TIMES)


@pytest.mark.parametrize("kind", TWINS)
def test_long_enough_upright_and_inside_the_image(kind):
    assert LENGTH >= 150
    for seed in SEEDS:
        scene = TWINS[kind](seed)
        assert scene.length == LENGTH and scene.seed == seed
        path = truth(kind, seed)
        assert np.abs(np.rad2deg(path[:, 2])).max() < 5
        inside = (path[:, :2] > 0).all(1) & (path[:, :2] < [320, 240]).all(1)
        assert inside.mean() > 0.95 and inside[0]


@pytest.mark.parametrize("kind", TWINS)
def test_everything_follows_from_the_arguments(kind):
    assert TWINS[kind](3) == TWINS[kind](3)
    assert TWINS[kind](3) != TWINS[kind](4)
    other = TWINS[kind](3, "hopper", "gravel")
    assert other.target.texture == "hopper" and other.background == "gravel" and other.target.path == TWINS[kind](3).target.path


@pytest.mark.parametrize("kind", ["passers", "pillars"])
@pytest.mark.parametrize("seed", [0, 1])
def test_three_total_occlusions(kind, seed):
    hidden = sequence(TWINS[kind](seed)).visibility < 0.02
    assert not hidden[:15].any()
    assert np.sum(~hidden[:-1] & hidden[1:]) >= 3
    assert 10 <= hidden.sum() <= LENGTH / 2


def test_look_alikes_are_the_object_in_other_colors():
    for seed in SEEDS:
        scene = TWINS["passers"](seed)
        assert {layer.texture for layer in scene.front} == {scene.target.texture} and all(layer.hue for layer in scene.front)


def test_the_camera_goes_along_behind_the_pillars():
    """The object walks far, and yet stays in the middle of the screen."""
    for seed in SEEDS:
        way = np.ptp(np.array(TWINS["pillars"](seed).target.path)[:, 1])
        assert np.ptp(truth("pillars", seed)[:, 0]) < way / 3


def test_size_changes_by_more_than_half_only_where_it_is_the_question():
    ratio = {kind: [np.ptp(np.log(truth(kind, seed)[:, HX])) for seed in SEEDS] for kind in TWINS}
    assert min(ratio["scale"]) > 0.6
    assert max(max(values) for kind, values in ratio.items() if kind != "scale") < 0.7


def test_steps_are_large_only_where_they_are_the_question():
    step = {kind: [np.linalg.norm(np.diff(truth(kind, seed)[:, :2], axis=0), axis=1).max() for seed in SEEDS] for kind in TWINS}
    assert min(step["trajectory"]) > 18
    assert max(max(values) for kind, values in step.items() if kind != "trajectory") < 18


def test_the_ground_changes_under_the_pan():
    """The strip above the object has another mean colour in each fifth of the sequence."""
    frames = sequence(TWINS["background"](0)).frames
    means = np.array([frames[k][:40].mean((0, 1)) for k in (0, 40, 80, 120)])
    assert min(np.linalg.norm(means[i] - means[j]) for i in range(4) for j in range(i)) > 5
