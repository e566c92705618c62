"""Gains that follow the light and nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mkt.histograms import ColorBins, learn
from mkt.kernels import Kernels
from mkt.regions import displaced
from mkt.scenes import Layer, Scene, sequence
from mkt.trackers.light import BOUNDS, first_light, followed, relit

SPECIFICATION = Scene(Layer("car", 80.0, ((0.0, 159.5, 119.5, 0.2, 1.0),)), length=30)


def begin(scene=SPECIFICATION):
    clip, bins = sequence(scene), ColorBins()
    target = learn(bins(clip.frames[0]), clip.truth[0], bins, Kernels("3x3"))
    return clip, first_light(target, clip.frames[0], clip.truth[0])


@given(st.integers(0, 255), st.floats(0.3, 3))
def test_a_gain_is_divided_out(value, gain):
    pixels = np.full((1, 1, 3), value, np.uint8)
    assert (relit(pixels, np.ones(3)) == value).all()
    assert abs(int(relit(pixels, np.full(3, gain))[0, 0, 0]) - min(value / gain, 255)) <= 1


@pytest.mark.parametrize("gains", [(0.6, 0.6, 0.6), (0.75, 0.9, 1.1)])
def test_finds_the_gains_of_a_new_light(gains):
    """Within 7 % after 29 frames under another light, at the true place."""
    clip, light = begin(replace(SPECIFICATION, light=((0.0, 1.0, 1.0, 1.0), (1.0, *gains))))
    for frame, region in zip(clip.frames, clip.truth):
        light = followed(light, frame, region)
    assert np.abs(np.log(light.gains / gains)).max() < 0.07


def test_stays_when_the_light_stays():
    clip, light = begin()
    for frame, region in zip(clip.frames, clip.truth):
        light = followed(light, frame, region)
    assert np.abs(np.log(light.gains)).max() < 0.05


def test_does_not_take_the_background_for_the_object():
    """Beside the object no gains make the background look like it: the reference stays, and the likeness there stays low."""
    clip, light = begin()
    beside = displaced(clip.truth[0], 100, 60)
    for frame in clip.frames:
        light = followed(light, frame, beside)
    target = light.target
    there, here = (target.distances(target.bins(relit(clip.frames[0], light.gains)), region) for region in (beside, clip.truth[0]))
    assert (light.gains >= BOUNDS[0]).all() and (light.gains <= BOUNDS[1]).all()
    assert here < there
