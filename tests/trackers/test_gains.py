"""How far, how fast and from what the gains of the light are taken."""

import numpy as np
import pytest

from mkt.colors import ColorBins
from mkt.histograms import learn
from mkt.kernels import Kernels
from mkt.trackers.gains import BOUNDS, first_light, followed, relit

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


def test_gains_stay_within_two_stops():
    light = first(patches())
    dark = replace_gains(light, 0.26)
    now = followed(dark, under(patches(), 0.05, 0.05, 0.05), REGION, 1.0)
    assert now.gains.min() >= BOUNDS[0]
    bright = replace_gains(light, 3.9)
    now = followed(bright, np.full_like(patches(), 255), REGION, 1.0)
    assert now.gains.max() <= BOUNDS[1]


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
