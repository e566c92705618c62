"""The shape of a target, found in a frame whose truth is known, as weights."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from mkt import silhouettes
from mkt.kernels import Kernels
from mkt.regions import warp
from mkt.scenes.textures import texture
from mkt.scenes.varied import Varied
from mkt.silhouettes import (
    SHAPES,
    SIDE,
    Silhouette,
    as_bytes,
    by_colour,
    grabbed,
    masked,
    patch,
)
from mkt.trackers.ssd import SSD

BOX = {"layout": "one", "profile": "uniform", "span": 1.5, "elliptic": True}


def first(item, ground="grass", seed=3):
    scene = Varied("calm", seed).scene()
    target = replace(scene.target, texture=item)
    clip = replace(scene, target=target, background=ground).sequence()
    return clip.frames[0], clip.truth[0]


def true_mask(item):
    opacity = texture(item)[..., 3] / 255
    return cv2.resize(opacity, (SIDE, SIDE), interpolation=cv2.INTER_AREA)


def likeness(mask, item):
    """Of a mask with the true one: what is in both, over what is in either."""
    both = mask, true_mask(item)
    return np.minimum(*both).sum() / np.maximum(*both).sum()


@pytest.mark.parametrize("seed", range(3))
def test_grab_cut_finds_limbs(seed):
    assert likeness(grabbed(*first("starfish", seed=seed)), "starfish") > 0.6


@pytest.mark.parametrize("seed", range(3))
def test_colours_tell_limbs_and_a_hole(seed):
    """Their share is larger on the target than in its box beside it."""
    for item in ("starfish", "ring"):
        share, mask = by_colour(*first(item, seed=seed)), true_mask(item) > 0.5
        assert share[mask].mean() > share[~mask].mean() + 0.2


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_are_the_same_each_time_and_never_empty(name):
    frame, region = first("car", "workshop")
    mask = SHAPES[name](frame, region)
    assert mask.shape == (SIDE, SIDE) and mask.mean() > 0.05
    assert 0 <= mask.min() and mask.max() <= 1 + 1e-9
    assert np.array_equal(mask, SHAPES[name](frame, region))


def test_a_mask_lies_over_the_region_and_not_beside_it():
    """The shape of a box that is its own mirror image is that, too."""
    frame = np.full((200, 200, 3), 90, np.uint8)
    frame[60:140, 60:140] = (200, 30, 40)
    mask = by_colour(frame, [99.5, 99.5, 0, 56, 56])
    assert np.allclose(mask, mask[:, ::-1], atol=0.1)
    assert np.allclose(mask, mask[::-1], atol=0.1)


def test_grab_cut_finds_the_same_whatever_was_drawn_before():
    """It starts from random clusters; here other ones end on another mask."""
    clip, masks = Varied("cut-out", 1).sequence(), []
    for seed in (1, 2, 3):
        cv2.setRNGSeed(seed)
        masks.append(grabbed(clip.frames[0], clip.truth[0]))
    assert np.array_equal(masks[0], masks[1]) and np.array_equal(*masks[1:])


@pytest.mark.parametrize("half, found", [(4, False), (12, True)])
def test_a_speck_of_the_region_is_not_taken_for_the_target(half, found):
    """Of 60 x 60 px it is 8 x 8 or 24 x 24 in another colour."""
    noise = np.random.default_rng(0).normal(90, 6, (120, 120, 3))
    frame = np.clip(noise, 0, 255).astype(np.uint8)
    frame[60 - half : 60 + half, 60 - half : 60 + half] = (230, 30, 40)
    mask = grabbed(frame, [59.5, 59.5, 0, 30, 30])
    assert 0.1 < mask.mean() < 0.2 if found else mask.all()


def test_shares_of_colours_are_means_of_three_pixels():
    """At the border of two colours two steps of a third lie between their shares."""
    frame = np.full((200, 200, 3), 90, np.uint8)
    frame[76:124, 100:124] = (200, 30, 40)
    ground, *between, target = by_colour(frame, [99.5, 99.5, 0, 24, 24])[20, 22:26]
    assert ground < 0.5 and target == pytest.approx(1)
    steps = ground + (target - ground) * np.array([1, 2]) / 3
    np.testing.assert_allclose(between, steps)


def test_what_is_not_found_is_all_of_the_box():
    frame = np.full((80, 80, 3), 90, np.uint8)
    assert grabbed(frame, [40, 40, 0, 12, 9]).all()


@pytest.mark.parametrize("around", [1.0, 1.6])
def test_a_patch_is_upright_whatever_the_region(around):
    """Each of its pixels has the colour of its place, and colours say places here."""
    y, x = np.mgrid[:110, :130].astype(np.uint8)
    region = [65, 55, 0.7, 30, 18]
    seen = patch(np.dstack([x, y, y]), region, around).astype(float)
    n = len(seen)
    assert n % 2 == 0 and abs(n - SIDE * around) <= 1
    cells = (2 * np.arange(n) + 1 - n) / SIDE
    places = warp(region, np.stack(np.meshgrid(cells, cells), -1).reshape(-1, 2))
    assert np.abs(seen[..., :2].reshape(-1, 2) - places).max() < 1


def test_weights_are_those_of_the_kernel_times_the_mask_of_their_cell():
    mask = np.random.default_rng(0).random((SIDE, SIDE))
    shown = Silhouette(**BOX, mask=as_bytes(mask)).fitted([0, 0, 0.3, 40, 15])
    plain = Kernels(**BOX).fitted([0, 0, 0.3, 40, 15])
    assert np.array_equal(shown.half_sides, plain.half_sides)
    x, y = shown.points.T
    cell = mask[((y + 1) / 2 * SIDE).astype(int), ((x + 1) / 2 * SIDE).astype(int)]
    expected = plain.weigh(shown.points * shown.half_sides)[0] * cell
    assert np.allclose(shown.weights[0], expected / expected.sum(), atol=2e-5)
    corners = np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]]) * shown.half_sides
    at_corners = shown.weigh(0.999 * corners) / plain.weigh(0.999 * corners)
    assert np.allclose(at_corners, mask[[0, 0, -1, -1], [0, -1, 0, -1]], atol=3e-3)


def test_a_silhouette_counts_only_what_the_mask_shows():
    mask = np.zeros((SIDE, SIDE))
    mask[:, : SIDE // 2] = 1
    left = Silhouette(**BOX, mask=as_bytes(mask)).fitted([0, 0, 0, 20, 10])
    on_the_left = left.points[:, 0] < 0
    assert left.weights[0, on_the_left].sum() > 0.99
    whole = Silhouette(**BOX).fitted([0, 0, 0, 20, 10])
    plain = Kernels(**BOX).fitted([0, 0, 0, 20, 10])
    assert np.allclose(whole.weights, plain.weights)


def test_kernels_beside_the_mask_still_see_something():
    """A part that nothing is seen of would be refused."""
    middle = np.zeros((SIDE, SIDE))
    middle[20:28, 20:28] = 1
    shown = masked(Kernels("tiles", "uniform"), middle).fitted([0, 0, 0, 20, 10])
    assert np.allclose(shown.weights.sum(1), 1)


def test_a_second_mask_leaves_what_the_first_one_shows_too():
    left, upper = np.zeros((2, SIDE, SIDE))
    left[:, : SIDE // 2] = upper[: SIDE // 2] = 1
    both = masked(masked(Kernels(**BOX), left), upper)
    assert both == masked(Kernels(**BOX), left * upper)
    assert both == masked(Silhouette(**BOX, mask=as_bytes(left)), upper)


def test_a_silhouette_has_no_slope():
    shown = Silhouette("3x3").fitted([0, 0, 0, 20, 10])
    with pytest.raises(ValueError, match="silhouette have no slope"):
        _ = shown.slopes
    with pytest.raises(ValueError, match="silhouette have no slope"):
        SSD(Silhouette("3x3"))


@pytest.mark.parametrize("find", [grabbed, by_colour])
@pytest.mark.parametrize(
    "region, said",
    [
        ((np.nan, 20, 0, 9, 9), "finite"),
        ((20, 20, 0, 0, 9), "area|positive"),
        ((-60, 20, 0, 9, 9), "lies outside the image; choose a box inside it"),
    ],
)
def test_a_shape_is_sought_only_where_there_is_something(find, region, said):
    with pytest.raises(ValueError, match=said):
        find(np.zeros((40, 60, 3), np.uint8), region)


@pytest.mark.parametrize("around", [0, 0.9, np.nan, "2"])
def test_what_lies_round_a_region_is_no_smaller_than_the_region(around):
    with pytest.raises(ValueError, match="around is .*; it must be finite, and at le"):
        patch(np.zeros((90, 90, 3), np.uint8), [45, 45, 0, 20, 10], around)


def test_a_mask_of_another_size_is_refused():
    with pytest.raises(ValueError, match="mask has 3 bytes"):
        Silhouette(mask=b"abc")
    square = SIDE, SIDE
    for wrong in (np.ones((3, 3)), np.full(square, 255), np.full(square, np.nan)):
        with pytest.raises(ValueError, match="give 48 x 48 numbers from 0 to 1"):
            masked(Kernels("3x3"), wrong)


def test_a_mask_of_a_masked_kernel_is_multiplied():
    half = np.full((SIDE, SIDE), 0.5)
    twice = masked(masked(Kernels("one"), half), half)
    assert twice.image == pytest.approx(0.25, abs=1 / 255)


@pytest.mark.parametrize("share, is_whole", [(0.04, True), (0.06, False)])
def test_less_than_a_twentieth_was_not_found(monkeypatch, share, is_whole):
    def cut(seen, labels, *more):
        edge = (len(labels) - SIDE) // 2
        labels[edge : edge + round(share * SIDE), edge : edge + SIDE] = 1

    monkeypatch.setattr(silhouettes.cv2, "grabCut", cut)
    frame = np.zeros((90, 90, 3), np.uint8)
    assert grabbed(frame, [45, 45, 0, 20, 20]).all() == is_whole


@pytest.mark.parametrize("mask", [None, "x" * SIDE**2, [1] * SIDE**2])
def test_a_mask_of_another_kind_is_refused(mask):
    with pytest.raises(ValueError, match="^mask is of the type .*; make it with as_by"):
        Silhouette(mask=mask)
