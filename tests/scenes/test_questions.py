"""The named tests for trackers: each asks the question that it is named for."""

import numpy as np
import pytest

from mkt.scenes import SCENES, questions
from mkt.scenes.paths import LENGTH
from mkt.scenes.questions import occlusion
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
        gains = np.array(questions.illumination(seed).light)[:, 1:]
        assert (gains[0] == 1).all() and np.abs(np.log(gains[1:])).max() > 0.2


def test_fast_bursts_are_blurred_and_others_hardly():
    assert questions.blur(0).shutter > questions.base(0).shutter


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
