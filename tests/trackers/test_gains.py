"""Gains follow the light and nothing else: how far, how fast and from what."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mkt.colors import ColorBins
from mkt.histograms import learn
from mkt.kernels import Kernels
from mkt.regions import displaced
from mkt.trackers.gains import BOUNDS, first_light, followed, relit
from tests.trackers.scenes import STANDING

BINS = ColorBins()
REGION = np.array([60.0, 40.0, 0.0, 30.0, 20.0])


def patches(seed=0):
    """A frame of coloured patches, bright enough that no gain here clips them."""
    rng = np.random.default_rng(seed)
    cells = rng.integers(60, 120, (8, 12, 3), dtype=np.uint8)
    return cells.repeat(10, 0).repeat(10, 1)


def under(frame, *gains):
    return np.clip(frame * np.array(gains) + 0.5, 0, 255).astype(np.uint8)


def first(frame):
    target = learn(BINS(frame), REGION, Kernels("3x3"))
    return first_light(target, BINS, frame, REGION)


@pytest.mark.parametrize("rate", [0.3, 0.6, 1.0])
def test_gains_come_nearer_by_the_share_of_the_rate(rate):
    """A geometric mean of what was and of what the colours say."""
    light = first(patches())
    now = followed(light, under(patches(), 1.6, 1.4, 1.2), REGION, rate)
    expected = np.array([1.6, 1.4, 1.2]) ** rate
    assert np.allclose(now.gains, expected, rtol=0.01)


def test_a_second_look_goes_on_from_the_first():
    light = first(patches())
    lit = under(patches(), 1.6, 1.4, 1.2)
    light = followed(light, lit, REGION, 0.5)
    light = followed(light, lit, REGION, 0.5)
    assert np.allclose(light.gains, np.array([1.6, 1.4, 1.2]) ** 0.75, rtol=0.02)


def test_beyond_the_image_the_light_is_that_at_its_border():
    """Black there would be taken for less light."""
    frame = np.full((80, 120, 3), (90, 110, 70), np.uint8)
    half_out = np.array([0.0, 40.0, 0.0, 30.0, 20.0])
    target = learn(BINS(frame), REGION, Kernels("3x3"))
    light = first_light(target, BINS, frame, half_out)
    assert np.allclose(light.colors, (90, 110, 70))


def test_gains_stay_within_two_stops():
    light = first(patches())
    dark = replace_gains(light, 0.26)
    now = followed(dark, under(patches(), 0.05, 0.05, 0.05), REGION, 1.0)
    assert now.gains.min() >= BOUNDS[0]
    bright = replace_gains(light, 3.9)
    now = followed(bright, np.full_like(patches(), 255), REGION, 1.0)
    assert now.gains.max() <= BOUNDS[1]


@pytest.mark.filterwarnings("error")
def test_of_what_is_black_no_light_is_told():
    black = np.zeros_like(patches())
    light = followed(first(black), black, REGION, 1.0)
    assert (light.gains == 1).all()


def replace_gains(light, gain):
    return light._replace(gains=np.full(3, gain))


def test_one_covered_kernel_does_not_move_the_gains():
    """The median over the kernels leaves out what has come before one of them."""
    light = first(patches())
    covered = under(patches(), 1.6, 1.4, 1.2)
    covered[20:34, 30:50] = [255, 0, 0]  # the corner under the first of nine
    now = followed(light, covered, REGION, 1.0)
    assert np.allclose(now.gains, [1.6, 1.4, 1.2], rtol=0.03)


def test_gains_go_back_where_that_looks_more_like_the_object():
    light = replace_gains(first(patches()), 1.3)
    # What is seen is black: no ratio of colours tells anything, and nothing is like it.
    now = followed(light, patches(), REGION, rate=0.0)
    assert np.allclose(now.gains, 1.3**0.9)


def test_beyond_the_border_the_colours_are_those_of_the_border():
    frame = np.full((80, 120, 3), 100, np.uint8)
    light = first(frame)
    outside = light._replace(gains=np.ones(3))
    now = followed(outside, frame, REGION + [50, 30, 0, 0, 0], 1.0)
    assert np.allclose(now.gains, 1.0, atol=0.01)


def test_relit_refuses_what_is_no_frame():
    with pytest.raises(ValueError):
        relit(np.zeros((4, 4)), np.ones(3))


def test_a_target_keeps_its_reference():
    light = first(patches(3))
    now = followed(light, under(patches(3), 1.3, 1.3, 1.3), REGION)
    assert now.target is light.target and (now.colors == light.colors).all()


def begin(scene=STANDING):
    clip = scene.sequence()
    frame, region = clip.frames[0], clip.truth[0]
    target = learn(BINS(frame), region, Kernels("3x3"))
    return clip, first_light(target, BINS, frame, region)


def follow_on_the_truth(clip, light):
    for frame, region in zip(clip.frames, clip.truth, strict=True):
        light = followed(light, frame, region)
    return light


@given(st.integers(0, 255), st.floats(0.3, 3))
def test_a_gain_is_divided_out(value, gain):
    pixels = np.full((1, 1, 3), value, np.uint8)
    assert (relit(pixels, np.ones(3)) == value).all()
    relit_value = int(relit(pixels, np.full(3, gain))[0, 0, 0])
    assert abs(relit_value - min(value / gain, 255)) <= 1


@pytest.mark.parametrize("gains", [(0.6, 0.6, 0.6), (0.75, 0.9, 1.1)])
def test_finds_the_gains_of_a_new_light(gains):
    """Within 7 % after 29 frames under another light, at the true place."""
    change = ((0.0, 1.0, 1.0, 1.0), (1.0, *gains))
    light = follow_on_the_truth(*begin(replace(STANDING, light=change)))
    assert np.abs(np.log(light.gains / gains)).max() < 0.07


def test_stays_when_the_light_stays():
    light = follow_on_the_truth(*begin())
    assert np.abs(np.log(light.gains)).max() < 0.05


def test_does_not_take_the_background_for_the_object():
    """Beside the object no gains make the background look like it.

    The reference stays, and the likeness there stays low.
    """
    clip, light = begin()
    beside = displaced(clip.truth[0], 100, 60)
    for frame in clip.frames:
        light = followed(light, frame, beside)
    image = BINS(relit(clip.frames[0], light.gains))
    there, here = light.target.distances(image, np.stack([beside, clip.truth[0]]))
    assert (light.gains >= BOUNDS[0]).all() and (light.gains <= BOUNDS[1]).all()
    assert here < there


def test_kernels_that_learnt_nothing_say_nothing_of_the_light():
    clip = replace(STANDING, length=2).sequence()
    frame, (x, *rest) = clip.frames[0], clip.truth[0]
    border = int(x + 16)
    cut = np.ascontiguousarray(frame[:, border:])
    there = np.array([x - border, *rest])
    target = learn(BINS(cut), there, Kernels("3x3", samples=2400), partly=True)
    assert len(target.learnt) < 7
    light = first_light(target, BINS, cut, there)
    for _ in range(20):
        light = followed(light, (0.7 * frame).astype(np.uint8), clip.truth[0])
    assert np.abs(light.gains - 0.7).max() < 0.1
