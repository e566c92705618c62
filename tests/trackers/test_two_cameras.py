"""Two filters that tell each other what they see: what is said, heard and sent."""

import cv2
import numpy as np
import pytest

from mkt.histograms import log_likelihood
from mkt.homographies import through
from mkt.particles import mean_region, normalised
from mkt.scenes.two_cameras import (
    FRAMES,
    SIZE,
    VIEWS,
    TwoViews,
    homographies,
    seen,
)
from mkt.trackers.neighbours import CrossBin
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.two_cameras import (
    BYTES,
    FLOOR,
    HIDDEN,
    Message,
    TwoCameras,
    heard,
    on_ground,
)


def followed(seed, talking, wrong=0.0):
    """Errors (T, 2) [px] of both cameras."""
    views, (first, second) = TwoViews(seed), homographies()
    truths = np.array([[seen(H, r) for H in (first, second)] for r in views.truth])
    believed = first, second @ np.array([[1, 0, wrong], [0, 1, 0], [0, 0, 1.0]])
    pair, rng = TwoCameras(believed, talking=talking), np.random.default_rng(seed)
    states, regions = pair.init(views.frames(0), tuple(truths[0]), rng), [truths[0]]
    for k in range(1, FRAMES):
        states, found = pair.step(states, views.frames(k), rng)
        regions.append(found.regions)
    return np.linalg.norm(np.array(regions)[..., :2] - truths[..., :2], axis=-1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_the_other_camera_bridges_a_wall(seed):
    assert followed(seed, talking=False)[-1, 0] > 40
    assert followed(seed, talking=True)[-1, 0] < 20


def test_a_wrong_calibration_pulls_the_estimate_behind_the_wall():
    right, wrong = followed(0, True), followed(0, True, 30.0)
    assert wrong[25:35, 0].mean() > right[25:35, 0].mean() + 10


def test_what_is_heard_is_a_gaussian_with_a_floor():
    message = Message(np.array([10.0, 20.0]), np.zeros((2, 2)))
    there, near, far = heard(message, np.array([[10, 20], [13, 20], [500, 20.0]]))
    assert there == pytest.approx(0, abs=0.01)
    assert near == pytest.approx(-0.5, abs=0.01)  # three pixels are one deviation
    assert far == pytest.approx(np.log(FLOOR))


def test_the_last_pixel_of_the_ground_is_seen_in_its_corner():
    for H, view in zip(homographies(), VIEWS, strict=True):
        corner = np.array([SIZE]) - 1.0
        np.testing.assert_allclose(through(H, corner), [view[2]], atol=1e-3)


def test_both_see_the_same_point_of_the_ground():
    """A region's middle on the ground, seen and taken back, is where it was."""
    region = np.array([150.0, 110.0, 0.4, 30.0, 20.0])
    for H in homographies():
        x, y, w = np.linalg.inv(H) @ [*seen(H, region)[:2], 1]
        assert np.allclose([x / w, y / w], region[:2])
    assert TwoViews(1) == TwoViews(1) and TwoViews(1).truth.shape == (FRAMES, 5)


def two(talking=True, **filters):
    """A pair on its first frames, its states, and the frames."""
    views, (first, second) = TwoViews(3), homographies()
    starts = tuple(seen(H, views.truth[0]) for H in (first, second))
    pair = TwoCameras((first, second), ParticleFilter(n=100, **filters), talking)
    return pair, pair.init(views.frames(0), starts, np.random.default_rng(0)), views


@pytest.mark.parametrize("combine", ["sum", "mean"])
def test_a_camera_says_the_mean_and_the_spread_of_what_it_sees(combine):
    pair, states, views = two(combine=combine)
    look = pair._look(1, states[1], views.frames(1)[1], np.random.default_rng(1))
    image = pair.filter.bins(views.frames(1)[1])
    rho = states[1].target.coefficients(image, look.cloud.regions)
    logs = log_likelihood(rho, pair.filter.lam, combine)
    weights = normalised(logs)
    assert look.said is not None
    np.testing.assert_allclose(look.said.mean, weights @ look.ground, rtol=1e-6)
    expected = np.cov(look.ground.T, aweights=weights, bias=True)
    np.testing.assert_allclose(look.said.covariance, expected, rtol=1e-6)
    np.testing.assert_allclose(look.logs, np.logaddexp(logs, -HIDDEN), rtol=1e-6)


def test_a_camera_that_is_lost_says_nothing():
    pair, states, views = two()
    grey = np.full_like(views.frames(1)[0], 128)
    assert pair._look(0, states[0], grey, np.random.default_rng(1)).said is None


@pytest.mark.parametrize("talking, bytes", [(True, 2 * BYTES), (False, 0)])
def test_what_is_sent_is_counted_and_each_place_is_through_its_own_map(talking, bytes):
    pair, states, views = two(talking)
    _, found = pair.step(states, views.frames(1), np.random.default_rng(1))
    assert found.bytes == bytes and found.places.shape == (2, 2)
    for H, region, place in zip(
        pair.homographies, found.regions, found.places, strict=True
    ):
        np.testing.assert_allclose(on_ground(H, region[None, :2])[0], place)


def test_of_two_cameras_one_that_is_lost_costs_nothing():
    pair, states, views = two()
    first, second = views.frames(1)
    grey = np.full_like(first, 128)
    _, found = pair.step(states, (grey, second), np.random.default_rng(1))
    assert found.bytes == BYTES


def test_who_is_told_weighs_by_it_and_places_a_tenth_there():
    pair, states, views = two()
    look = pair._look(0, states[0], views.frames(1)[0], np.random.default_rng(1))
    there = look.ground.max(0)
    told = Message(there, 4 * np.eye(2))
    region, cloud = pair._end(0, look, told, np.random.default_rng(2))
    weights = normalised(look.logs + heard(told, look.ground))
    np.testing.assert_allclose(region, mean_region(look.cloud.regions, weights))
    (image,) = cv2.perspectiveTransform(there[None, None], pair.homographies[0])[0]
    moved = np.all(np.isclose(cloud.regions[:, :2], image), axis=1)
    assert moved[:10].all() and not moved[10:].any() and len(moved) == 100
    alone, free = pair._end(0, look, None, np.random.default_rng(2))
    expected = mean_region(look.cloud.regions, normalised(look.logs))
    np.testing.assert_allclose(alone, expected)
    assert not np.all(np.isclose(free.regions[:, :2], image), axis=1).any()


def test_two_cameras_need_two_frames_and_two_regions():
    pair, states, views = two()
    with pytest.raises(ValueError):
        pair.init(views.frames(0), (views.truth[0],), np.random.default_rng(0))


def test_a_filter_that_weighs_in_its_own_way_is_refused():
    with pytest.raises(ValueError, match="filter is a CrossBin, which weighs in its"):
        TwoCameras(homographies(), CrossBin())
