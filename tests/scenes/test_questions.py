"""The named tests for trackers: each asks the question that it is named for."""

from dataclasses import replace

import numpy as np
import pytest

from mkt.scenes import SCENES, questions, varied
from mkt.scenes.paths import LENGTH
from mkt.scenes.questions import occlusion
from mkt.scenes.rendering import regions, render
from tests.trackers.scenes import short

SEEDS = range(4)


def test_a_panel_hides_the_item_totally_for_about_ten_frames():
    for seed in range(8):
        clip = questions.occlusion(seed).sequence()
        behind = np.flatnonzero(clip.visibility < 0.02)
        assert len(clip) == LENGTH and 10 <= len(behind) <= 18
        assert clip.visibility[46:56].mean() < 0.1 and behind.min() >= 40
        assert np.ptp(clip.truth[:, 3]) == pytest.approx(0)


def test_look_alikes_are_one_of_the_colours_and_one_of_the_shape():
    scene = questions.look_alike(0, "cup")
    shuffled, recoloured = scene.behind
    assert {layer.texture for layer in scene.behind} == {"cup"}
    assert shuffled.shuffle > 1 and not shuffled.hue
    assert recoloured.shuffle == 1 and recoloured.hue


def test_the_light_begins_neutral_and_then_changes():
    for seed in SEEDS:
        gains = gains_of(questions.illumination(seed), (0, 40, 80))
        assert gains[0] == pytest.approx(1)
        assert gains.min() < 0.8  # it dims
        assert np.ptp(gains[1:], axis=1).max() > 0.1  # and changes its colour


def gains_of(scene, frames):
    """What the light makes of each channel in frames, (n, 3)."""
    lit = replace(scene, noise=0.0, shutter=0.0)
    neutral = replace(lit, light=((0.0, 1.0, 1.0, 1.0),))
    means = [[render(each, k).mean((0, 1)) for k in frames] for each in (lit, neutral)]
    return np.divide(*means)


def speeds(scene):
    """Speed of the centre [px/frame], once it has left its rest."""
    centres = regions(scene, scene.target, np.arange(4.0, LENGTH))[:, :2]
    return np.linalg.norm(np.diff(centres, axis=0), axis=1)


def smeared(scene):
    """How far the frame of the fastest motion is from a frozen one [grey levels]."""
    k = 4 + int(np.argmax(speeds(scene)))
    sharp = replace(scene, noise=0.0, shutter=0.0)
    frames = [render(each, k) for each in (replace(scene, noise=0.0), sharp)]
    return np.abs(np.diff(np.array(frames, float), axis=0)).mean()


@pytest.mark.parametrize("seed", SEEDS)
def test_fast_bursts_are_blurred_and_others_hardly(seed):
    """Those under a fast shutter are as fast, and sharp."""
    blurred, base = questions.blur(seed), questions.base(seed)
    swift = varied.swift(seed)
    slow = speeds(base).mean()
    assert min(speeds(blurred).mean(), speeds(swift).mean()) > 1.5 * slow
    assert smeared(blurred) > 2 * smeared(base) and smeared(swift) == 0


@pytest.mark.parametrize("name", SCENES)
def test_scenarios_follow_from_their_arguments(name):
    assert SCENES[name](3) == SCENES[name](3) != SCENES[name](4)
    assert short(SCENES[name](0), 2).visibility[0] > 0.7


@pytest.mark.parametrize("seed", range(4))
def test_the_occlusion_is_total(seed):
    visibility = occlusion(seed).sequence().visibility
    assert (visibility[46:53] < 0.02).all()
    assert visibility[20] > 0.7
    assert visibility[-5:].min() > 0.5
