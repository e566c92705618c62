"""The last word: pixels bring a region back to its picture, or say that they cannot."""

import cv2
import numpy as np
import pytest

from mkt.evaluation import overlap
from mkt.regions import displaced, size
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene
from mkt.trackers.last_word import (
    BLUR,
    PIXELS,
    _close_up,
    _CloseUp,
    _over,
    aligned,
    picture_of,
)

CLIP = Scene(Layer("car", 80.0, ((0.0, 159.5, 119.5, 0.2, 1.0),)), length=2).sequence()
FRAME, REGION = CLIP.frames[0], CLIP.truth[0]
FLAT = np.full_like(FRAME, 90)


def test_a_picture_has_the_aspect_of_its_region_and_pixels_enough():
    h, w = picture_of(FRAME, REGION, 1).shape
    assert w / h == pytest.approx(REGION[3] / REGION[4], rel=0.05)
    assert h * w == pytest.approx(PIXELS, rel=0.05)
    sliver = np.array([150.0, 110.0, 0.0, 60.0, 1.0])
    assert picture_of(FRAME, sliver, 1).shape[0] == 8


def test_a_picture_shows_the_same_at_every_pitch():
    near, far = (picture_of(FRAME, REGION, pitch).ravel() for pitch in (1, 2))
    assert np.corrcoef(near, far)[0, 1] > 0.95


def test_pictures_are_smoothed_so_that_noise_of_single_pixels_counts_little():
    noise = np.random.default_rng(0).normal(0, 60, (2, *FRAME.shape))
    noisy = (np.clip(FRAME + each, 0, 255).astype(np.uint8) for each in noise)
    first, second = (picture_of(frame, REGION, 1).ravel() for frame in noisy)
    assert np.corrcoef(first, second)[0, 1] > 0.9


@pytest.mark.parametrize("pitch", [1, 2])
@pytest.mark.parametrize(
    "off",
    [
        {"dx": 1.5, "dy": -1.0},
        {"scale": 1.04},
        {"dtheta": 0.08},
        {"dx": -1.0, "dtheta": -0.06, "scale": 0.97},
    ],
)
def test_place_turn_and_size_come_back(off, pitch):
    start = displaced(REGION, **off)
    picture = picture_of(FRAME, REGION, pitch)
    region, correlation = aligned(FRAME, picture, start, pitch)
    assert overlap(region, REGION) > 0.985 > overlap(start, REGION)
    assert correlation > 0.9 and abs(region[2] - REGION[2]) < 0.01


@pytest.mark.parametrize("pitch", [1, 2])
@pytest.mark.parametrize("dtheta", [0.0, 0.9, -2.4])
def test_the_close_up_has_room_for_the_steps(pitch, dtheta):
    """For as far as they bring anything back: a fifth of the size."""
    picture = picture_of(FRAME, REGION, pitch)
    start = displaced(REGION, dtheta=dtheta)
    close_up = _close_up(FRAME, start, pitch)
    fifth = 0.2 * size(REGION)
    for dx, dy in ((fifth, 0), (-fifth, 0), (0, fifth), (0, -fifth)):
        assert np.isfinite(_over(close_up, displaced(start, dx, dy), picture)).all()


@pytest.mark.parametrize("half", [4, 8, 20])
def test_a_close_up_is_smoothed_as_the_whole_frame_is_as_far_as_the_steps_go(half):
    """Its own border comes into no pixel of the object."""
    region, picture = np.array([*REGION[:2], 0.2, half, half]), np.zeros((30, 30))
    grey = cv2.cvtColor(FRAME, cv2.COLOR_RGB2GRAY).astype(np.float32)
    whole = _CloseUp(cv2.GaussianBlur(grey, BLUR, 0), np.zeros(2), 1)
    part = _close_up(FRAME, region, 1)
    room = 0.25 * half
    for dx, dy in ((0, 0), (room, 0), (-room, 0), (0, room), (0, -room)):
        there = displaced(region, dx, dy)
        seen = _over(part, there, picture)
        np.testing.assert_allclose(seen, _over(whole, there, picture), atol=0.01)


def test_another_light_makes_no_difference():
    dim = (FRAME * 0.6 + 20).astype(np.uint8)
    picture = picture_of(FRAME, REGION, 1)
    region, correlation = aligned(dim, picture, displaced(REGION, 1.0, 1.0), 1)
    assert overlap(region, REGION) > 0.985 and correlation > 0.9


def test_what_looks_otherwise_does_not_correlate():
    picture = picture_of(FRAME, REGION, 1)
    beside = displaced(REGION, 70, 40)
    assert aligned(FRAME, picture, beside, 1)[1] < 0.5


def test_outside_the_frame_nothing_is_said():
    picture = picture_of(FRAME, REGION, 1)
    away = displaced(REGION, 900, 0)
    region, correlation = aligned(FRAME, picture, away, 1)
    np.testing.assert_array_equal(region, away)
    assert correlation == 0


@pytest.mark.parametrize("frame", [FRAME, FLAT])
def test_a_picture_without_texture_says_nothing(frame):
    region, correlation = aligned(frame, picture_of(FLAT, REGION, 1), REGION, 1)
    assert np.isfinite(region).all() and correlation == 0


def test_what_was_outside_the_frame_is_no_part_of_a_picture():
    border = np.array([0.0, 119.5, 0.0, 40.0, 30.0])
    picture = picture_of(FRAME, border, 1)
    assert np.isnan(picture[:, : picture.shape[1] // 2 - 1]).all()
    assert np.isfinite(picture[:, picture.shape[1] // 2 + 1 :]).all()


def test_nothing_is_said_where_a_picture_and_a_look_share_too_little():
    """Three fifths of the one lie beyond the left border, of the other the right."""
    left = np.array([-8.0, 119.5, 0.0, 40.0, 30.0])
    right = np.array([327.0, 119.5, 0.0, 40.0, 30.0])
    region, correlation = aligned(FRAME, picture_of(FRAME, left, 1), right, 1)
    assert (region == right).all() and correlation == 0
