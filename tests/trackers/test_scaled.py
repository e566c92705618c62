"""A tracker on smaller frames finds the same thing in the pixels of the whole ones."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mkt import SCENES, SSD, ParticleFilter, evaluate, track
from mkt.homographies import as_region
from mkt.regions import CX, CY
from mkt.scenes.cards import card
from mkt.trackers.homography import PlaneSSD
from mkt.trackers.scaled import Scaled, rescaled
from tests import strategies


@given(region=strategies.regions(), scale=st.floats(0.05, 1))
def test_a_region_comes_back(region, scale):
    back = rescaled(rescaled(region, scale), 1 / scale)
    assert np.allclose(back, region, rtol=1e-12, atol=1e-9)


def test_what_is_in_a_region_is_in_the_region_of_the_shrunk_frame():
    """A white square, drawn twice as small by OpenCV itself."""
    frame = np.zeros((40, 60), np.uint8)
    frame[10:18, 20:32] = 255
    region = np.array([25.5, 13.5, 0, 6, 4])
    small = cv2.resize(frame, (30, 20), interpolation=cv2.INTER_AREA)
    y, x = np.nonzero(small)
    middle = rescaled(region, 0.5)[[CX, CY]]
    assert np.allclose(middle, [x.mean(), y.mean()])


def test_at_scale_one_nothing_changes():
    clip = SCENES["base"](0).sequence()
    plain = track(ParticleFilter(n=50), clip, seed=1)
    scaled = track(Scaled(ParticleFilter(n=50), 1.0), clip, seed=1)
    assert np.allclose(scaled.regions, plain.regions, atol=1e-9)


def test_the_whole_answer_is_in_pixels_of_the_frame():
    clip = SCENES["base"](0).sequence()
    tracker = Scaled(ParticleFilter(n=200), 0.5)
    found = track(tracker, clip, seed=1, keep=["particles", "weights"])
    assert evaluate(found, clip)["overlap"] > 0.7
    for k in (1, -1):
        particles, weights = found.info["particles"][k], found.info["weights"][k]
        off = (particles - found.regions[k])[:, :2]
        spread = found.info["covariance"][k][:2, :2]
        assert np.allclose((weights * off.T) @ off, spread, rtol=1e-6)


def test_a_homography_is_in_pixels_of_the_frame_too():
    clip = card("base", 500).sequence()
    tracker, rng = Scaled(PlaneSSD(), 0.5), np.random.default_rng(0)
    _, info = tracker.step(
        tracker.init(clip.frames[0], clip.truth[0], rng), clip.frames[1], rng
    )
    aspect = clip.truth[0, 3] / clip.truth[0, 4]
    assert np.allclose(as_region(info["homography"], aspect), info["region"])
    assert np.abs(info["region"][:2] - clip.truth[1, :2]).max() < 5


def test_a_scale_that_leaves_nothing_of_a_frame_is_told():
    frame, rng = np.zeros((60, 80, 3), np.uint8), np.random.default_rng(0)
    with pytest.raises(ValueError, match="leaves nothing of a frame of 80x60 px"):
        Scaled(SSD(), 0.008).init(frame, np.array([40.0, 30, 0, 20, 20]), rng)
    with pytest.raises(ValueError, match="less than a pixel of the target"):
        Scaled(SSD(), 0.04).init(frame, np.array([40.0, 30, 0, 20, 10]), rng)


@pytest.mark.parametrize("scale", [0, -1, 1.01, np.nan, "half"])
def test_another_scale_is_refused(scale):
    with pytest.raises(ValueError, match="scale is"):
        Scaled(SSD(), scale)


def test_what_is_no_tracker_is_refused():
    with pytest.raises(ValueError, match="'ssd' is no tracker"):
        Scaled("ssd", 0.5)


def test_a_refusal_says_at_which_scale_its_numbers_are():
    frame, region = np.zeros((60, 80, 3), np.uint8), np.array([0.0, 0, 0.3, 20, 16])
    with pytest.raises(ValueError, match=r"at the scale 0.5: .*\(-0.25, -0.25"):
        Scaled(SSD(), 0.5).init(frame, region, np.random.default_rng(0))


def test_half_a_pixel_of_a_frame_is_nothing():
    with pytest.raises(ValueError, match="leaves nothing"):
        Scaled(SSD(), 0.5).step(None, np.zeros((1, 9, 3), np.uint8), None)
