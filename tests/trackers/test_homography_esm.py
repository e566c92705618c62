"""The rival on planes: pixels, with OpenCV's alignment as an oracle."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mkt.evaluation import errors
from mkt.homographies import corner_error, moved, of_regions, through
from mkt.regions import from_box
from mkt.scenes.cards import card
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene, homographies
from mkt.trackers import homography_esm
from mkt.trackers.homography_esm import PlaneESM, esm_step
from mkt.tracking import track
from tests.trackers.scenes import STANDING


def facing_and_later(seed, k=45):
    """Two frames of a card, its region in the first, its homography in the second."""
    scene = replace(card("base", seed), noise=0.0, shutter=0.0)
    clip = scene.sequence()
    truth = homographies(scene, scene.target, float(k))
    return clip.frames[0], clip.frames[k], clip.truth[0].copy(), truth


def by_ecc(frame, later, region, start):
    """OpenCV's alignment, both frames smoothed first; the homography (3, 3)."""
    grey = [
        cv2.cvtColor(f, cv2.COLOR_RGB2GRAY).astype(np.float32) for f in (frame, later)
    ]
    before, after = (cv2.GaussianBlur(g, (5, 5), 0) for g in grey)
    size = np.round(2 * region[3:]).astype(int)
    from_square = of_regions(from_box([0, 0, *size]))
    to_image = of_regions(region) @ np.linalg.inv(from_square)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    picture = cv2.warpPerspective(before, to_image, size, flags=flags)
    way = (start @ np.linalg.inv(from_square)).astype(np.float32)
    ends = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-7)
    motion, everywhere = cv2.MOTION_HOMOGRAPHY, np.full(after.shape, 255, np.uint8)
    way = way / way[2, 2]
    found = cv2.findTransformECC(picture, after, way, motion, ends, everywhere, 1)[1]
    return found @ from_square


@pytest.mark.parametrize("seed", [0, 1, 2, 5])
def test_esm_ends_where_opencvs_alignment_ends(seed):
    """Inside the border, where blur brings no background, both end at the truth."""
    frame, later, region, truth = facing_and_later(seed)
    region[3:], truth[:, :2] = 0.9 * region[3:], 0.9 * truth[:, :2]
    tracker = PlaneESM(blurs=(5,))
    state = tracker.init(frame, region, np.random.default_rng(0))
    found, correlation, _ = tracker.refine(state, later, truth)
    oracle = by_ecc(frame, later, region, truth)
    assert corner_error(found, oracle) < 0.05 and correlation > 0.98
    assert corner_error(found, truth) < 0.15


@settings(max_examples=25)
@given(
    x=st.tuples(*[st.floats(-0.03, 0.03)] * 6, *[st.floats(-0.02, 0.02)] * 2),
)
def test_a_step_of_esm_leaves_a_small_part_of_a_small_displacement(x):
    """It is exact to second order: of a pixel or two, less than a sixth is left."""
    picture, sides = waves(np.eye(3)), np.array([1.25, 0.8])
    seen = waves(moved(np.eye(3), -np.array(x), sides))
    left = esm_step(picture, seen)[0] - np.array(x)
    assert np.abs(left).max() < 0.15 * np.abs(x).max() + 1e-3


def waves(homography):
    """A smooth picture (80, 125) of the canonical square under a homography."""
    x, y = np.meshgrid(np.arange(125), np.arange(80))
    grid = np.column_stack([(x.ravel() - 62) / 62.5, (y.ravel() - 39.5) / 40])
    u, v = through(homography, grid).T
    waves = np.sin(5 * u) + np.cos(4 * v + 1) + np.sin(3 * u * v + u + 2 * v)
    return (100 + 40 * waves).reshape(80, 125).astype(np.float32)


def test_esm_does_not_mind_the_light():
    frame, later, region, truth = facing_and_later(3)
    tracker = PlaneESM()
    state = tracker.init(frame, region, np.random.default_rng(0))
    found, _, _ = tracker.refine(state, later, truth)
    darker = np.round(20 + 0.6 * later).astype(np.uint8)
    assert corner_error(tracker.refine(state, darker, truth)[0], found) < 0.05


def test_esm_begins_again_where_it_runs_away():
    frame, later, region, truth = facing_and_later(3)
    tracker = PlaneESM()
    state = tracker.init(frame, region, np.random.default_rng(0))
    far = of_regions([300.0, 20.0, 0, 20.0, 16.0])
    noise = np.random.default_rng(1).integers(0, 256, later.shape, dtype=np.uint8)
    found, correlation, _ = tracker.refine(state, noise, far)
    np.testing.assert_array_equal(found, far)
    assert correlation == 0


def test_what_lies_outside_the_frame_does_not_pull():
    """A card that leaves the image is aligned by what is left of it."""
    way = ((0.0, 160.0, 120.0, 0.0, 1.0), (10.0, 300.0, 120.0, 0.2, 1.0))
    scene = Scene(Layer("cat", 100.0, way), "tissue", 11)
    clip, truth = scene.sequence(), homographies(scene, scene.target, 10.0)
    tracker = PlaneESM(blurs=(5,))
    state = tracker.init(clip.frames[0], clip.truth[0], np.random.default_rng(0))
    start = moved(truth, np.array([0.02, -0.02, 0.02, 0.02]), np.ones(2))
    found, _, _ = tracker.refine(state, clip.frames[10], start)
    assert corner_error(found, truth) < 0.5


@pytest.mark.parametrize("allowed, taken", [(3, 3), (9, 5)])
def test_esm_bounds_and_counts_its_steps_in_object_units(allowed, taken, monkeypatch):
    """Of each pass; one is over after a step that is short, here the fifth."""
    calls = []

    def given(picture, seen):
        calls.append(picture.shape)
        size = 1e-4 if len(calls) % 5 == 0 else 1.0
        return size * np.array([0.6, -0.7, 0.1, 0.02, 0, 0, 0, 0]), 0.25

    monkeypatch.setattr(homography_esm, "esm_step", given)
    clip = card("base", 3).sequence()
    tracker = PlaneESM(iterations=allowed, blurs=(5,))
    region = np.array([90.0, 80.0, 0.0, 20.0, 12.0])
    state = tracker.init(clip.frames[0], region, np.random.default_rng(0))
    found, correlation, steps = tracker.refine(state, clip.frames[0], state.first)
    sides, place = np.sqrt([20 / 12, 12 / 20]), state.first
    for k in range(taken):
        small = 1e-4 if k == 4 else 1.0
        step = np.clip(small * np.array([0.6, -0.7, 0.1, 0.02]), -0.5, 0.5)
        place = moved(place, step, sides)
    np.testing.assert_allclose(found, place)
    assert calls == [(24, 40)] * taken and correlation == 0.25 and steps == taken


def test_esm_says_how_alike_the_pictures_are():
    clip = card("base", 3).sequence()
    tracker, rng = PlaneESM(), np.random.default_rng(0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    _, correlation, steps = tracker.refine(state, clip.frames[4], state.first)
    after, info = tracker.step(state, clip.frames[4], rng)
    assert 0.9 < correlation < 1 and not info["lost"]
    assert info["evaluations"] == info["steps"] == steps > 1
    assert info["distance"] == pytest.approx(np.sqrt(1 - correlation))
    np.testing.assert_array_equal(after.homography, info["homography"])


def test_the_likeness_of_a_card_half_outside_is_that_of_the_other_half():
    picture = waves(np.eye(3))
    seen = picture.copy()
    seen[:, :60] = np.nan
    step, correlation = esm_step(picture, seen)
    assert correlation == pytest.approx(1, abs=1e-5) and np.abs(step).max() < 1e-5
    shifted = waves(moved(np.eye(3), np.array([-0.02]), np.array([1.25, 0.8])))
    shifted[:, :60] = np.nan
    assert esm_step(picture, shifted)[0][0] == pytest.approx(0.02, abs=0.005)


def test_what_lies_outside_has_no_say_in_the_light():
    """However bright the picture is there, and however dim the frame has become."""
    picture = waves(np.eye(3))
    seen = 0.4 * picture + 30
    picture[:, :60] += 3 * np.ptp(picture)
    seen[:, :60] = np.nan
    _, correlation = esm_step(picture, seen)
    assert correlation == pytest.approx(1, abs=1e-4)


def test_a_small_object_is_kept_at_no_less_than_eight_pixels():
    clip = card("base", 3).sequence()
    region = np.array([90.0, 80.0, 0.0, 3.0, 2.0])
    state = PlaneESM(blurs=(1,)).init(clip.frames[0], region, np.random.default_rng(0))
    assert [picture.shape for picture in state.pictures] == [(8, 8)]
    with pytest.raises(ValueError, match="iterations"):
        PlaneESM(iterations=0)


def test_esm_steps_in_the_plane_of_its_picture_whatever_the_region_is():
    """A sliver is kept as 8 px high: its plane is that of the picture, not its own."""
    clip = card("base", 3).sequence()
    x, y = clip.truth[0][:2]
    region = np.array([x, y, 0.0, 24.0, 3.0])
    tracker = PlaneESM(blurs=(1,), iterations=1)
    state = tracker.init(clip.frames[0], region, np.random.default_rng(0))
    (picture,) = state.pictures
    assert picture.shape == (8, 48)
    start = state.first + np.array([[0, 0, 0.4], [0, 0, 0.2], [0, 0, 0]])
    (grey,) = tracker._smoothed(clip.frames[0])
    step, _ = esm_step(picture, homography_esm.facing(grey, start, picture))
    found, _, _ = tracker.refine(state, clip.frames[0], start)
    by_hand = moved(start, np.clip(step, -0.5, 0.5), np.sqrt([48 / 8, 8 / 48]))
    np.testing.assert_allclose(found, by_hand)


@pytest.mark.parametrize("seed", range(500, 508))
def test_esm_says_no_distance_to_what_it_has_just_learnt(seed):
    clip = card("base", seed).sequence()
    tracker, rng = PlaneESM(), np.random.default_rng(0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    _, info = tracker.step(state, clip.frames[0], rng)
    assert 0 <= info["distance"] < 0.1


@pytest.mark.parametrize(
    "region",
    [(1000, 1000, 0, 20, 20), (50, 50, 0, 40_000, 40_000), (160, 120, 0, 1e9, 1e-3)],
)
def test_esm_refuses_what_it_hardly_sees(region):
    frame = card("base", 0).sequence().frames[0]
    with pytest.raises(ValueError, match="most of the region .* outside the image"):
        PlaneESM().init(frame, np.array(region, float), None)


@pytest.mark.parametrize("inside, seen", [(0.5, True), (0.1, False)])
def test_esm_says_nothing_of_an_object_of_which_hardly_anything_is_in_the_frame(
    inside, seen
):
    """At a tenth it is neither learnt nor followed; at a half it is."""
    clip, rng = card("base", 0).sequence(), np.random.default_rng(0)
    frame, region, tracker = clip.frames[0], clip.truth[0].copy(), PlaneESM(blurs=(5,))
    state = tracker.init(frame, region, rng)
    cut = round(region[0] + (1 - 2 * inside) * region[3])
    part, there = frame[:, cut:], region - [cut, 0, 0, 0, 0]
    _, correlation, steps = tracker.refine(state, part, of_regions(there))
    if seen:
        assert correlation > 0.95 and steps > 0
        tracker.init(part, there, rng)
    else:
        assert correlation == steps == 0
        with pytest.raises(ValueError, match="most of the region"):
            tracker.init(part, there, rng)


@pytest.mark.parametrize("k", range(8))
def test_esm_steps_in_what_a_picture_shows_but_faintly(k):
    """Of a pattern in the middle alone a tilt changes few pixels, by little."""
    sides, x = np.array([1.25, 0.8]), 0.02 * np.eye(8)[k]
    seen = spot(moved(np.eye(3), -x, sides))
    step, _ = esm_step(spot(np.eye(3)), seen)
    assert step[k] == pytest.approx(x[k], rel=0.1)


def spot(homography):
    """A smooth picture (80, 125) with a pattern in the middle of the square alone."""
    x, y = np.meshgrid(np.arange(125), np.arange(80))
    grid = np.column_stack([(x.ravel() - 62) / 62.5, (y.ravel() - 39.5) / 40])
    u, v = through(homography, grid).T
    pattern = np.sin(9 * u + 1) + np.cos(8 * v) + np.sin(12 * u * v + 2 * u)
    shown = 100 + 60 * np.exp(-(u**2 + v**2) / 0.08) * pattern
    return shown.reshape(80, 125).astype(np.float32)


def test_a_step_of_esm_takes_the_mean_of_both_slopes():
    """Those of one picture alone leave a fifth, or half, of such a displacement."""
    picture, sides = waves(np.eye(3)), np.array([1.25, 0.8])
    x = 0.02 * np.array([4, -3, 4, 3, 2, -2, 1, 2])
    left = esm_step(picture, waves(moved(np.eye(3), -x, sides)))[0] - x
    assert np.abs(left).max() < 0.08 * np.abs(x).max()


def entering(left, length=25):
    """A view from which a camera turns away; the object comes in from the border.

    That lies at `left`, in half widths of the object from its middle, at first.
    """
    clip = replace(STANDING, length=length).sequence()
    border = int(clip.truth[0, 0] + 40 * left)
    borders = [max(border - 3 * k, 60) for k in range(length)]
    frames = [
        np.ascontiguousarray(frame[:, x : x + 150])
        for frame, x in zip(clip.frames, borders, strict=True)
    ]
    truth = clip.truth - np.outer(borders, (1, 0, 0, 0, 0))
    return replace(clip, frames=frames, truth=truth)


@pytest.mark.parametrize("left", [-0.6, 0.0])
def test_what_was_outside_at_first_is_no_part_of_the_picture(left):
    clip = entering(left)
    found = track(PlaneESM(), clip).regions
    assert errors(found, clip.truth).position.max() < 0.5


def test_a_look_that_shares_too_little_with_the_picture_leads_nowhere():
    """Three fifths of the one lie beyond the left border, of the other the right."""
    frame = replace(STANDING, length=2).sequence().frames[0]
    left = np.array([-8.0, 119.5, 0.0, 40.0, 30.0])
    state = PlaneESM().init(frame, left, np.random.default_rng(0))
    start = of_regions(left + [335, 0, 0, 0, 0])
    found, correlation, steps = PlaneESM().refine(state, frame, start)
    assert (found == start).all() and (correlation, steps) == (0, 0)
