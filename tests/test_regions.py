"""The currency: warping, corners, boxes."""

import numpy as np
import pytest
from hypothesis import given

from mkt.regions import (
    area,
    as_regions,
    corners,
    displaced,
    from_box,
    outside,
    rotation,
    size,
    to_box,
    unwarp,
    warp,
    wrap_angle,
)
from tests.strategies import points, regions


@given(regions(), points())
def test_unwarp_undoes_warp(region, p):
    assert np.allclose(unwarp(region, warp(region, p)), p, atol=1e-9)


@given(regions())
def test_area_is_that_of_the_polygon(region):
    x, y = corners(region).T
    shoelace = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
    # Positive: clockwise on a screen whose y points down.
    assert np.isclose(shoelace, area(region))


def test_theta_turns_x_towards_y():
    assert np.allclose(warp([0, 0, np.pi / 2, 3, 1], [[1, 0]]), [[0, 3]])


def test_boxes_and_pixel_centres():
    # One pixel, whose centre is the origin.
    assert np.allclose(from_box([0, 0, 1, 1]), [0, 0, 0, 0.5, 0.5])
    assert np.allclose(to_box(from_box([10, 20, 30, 40])), [10, 20, 30, 40])
    assert np.allclose(to_box(from_box([10, 20, 30, 40], np.pi / 2)), [5, 25, 40, 30])


def test_many_at_once():
    many = np.random.default_rng(0).uniform(1, 9, (4, 3, 5))
    assert corners(many).shape == (4, 3, 4, 2)
    assert np.allclose(corners(many)[2, 1], corners(many[2, 1]))


def test_angles_wrap_to_half_open_interval():
    wrapped = wrap_angle([0, np.pi, -np.pi, 3 * np.pi / 2, 7])
    assert np.allclose(wrapped, [0, -np.pi, -np.pi, -np.pi / 2, 7 - 2 * np.pi])


def test_the_ends_of_the_half_open_interval():
    assert wrap_angle(np.pi) == -np.pi
    assert wrap_angle(-np.pi) == -np.pi
    assert wrap_angle(3.14) == pytest.approx(3.14)
    below = np.nextafter(-np.pi, -4)  # a whole turn later is rounded to +pi
    assert wrap_angle(below) == -np.pi and np.isnan(wrap_angle(np.nan))


def test_rotations_of_many_angles_are_those_of_one():
    angles = np.array([[0.1, 1.2, 2.5], [-0.4, 3.0, 0.7]])
    many = rotation(angles)
    assert many.shape == (2, 3, 2, 2)
    c, s = np.cos(1.2), np.sin(1.2)
    assert np.allclose(many[0, 1], [[c, -s], [s, c]])


def test_what_is_no_region_is_refused_with_its_shape():
    with pytest.raises(ValueError, match=r"^regions must .* not \(2, 4\)$"):
        as_regions(np.zeros((2, 4)))
    with pytest.raises(ValueError, match=r"not \(\)$"):
        as_regions(3)


def test_many_boxes_share_one_angle_or_have_their_own():
    boxes = np.array([[0, 0, 4, 2], [10, 20, 6, 8.0]])
    assert from_box(boxes, 0.5)[:, 2].tolist() == [0.5, 0.5]
    assert from_box(boxes, [0.5, 0.7])[:, 2].tolist() == [0.5, 0.7]
    assert from_box(boxes)[1].tolist() == [12.5, 23.5, 0, 3, 4]


@given(regions())
def test_size_is_the_half_side_of_the_square_of_the_same_area(region):
    assert np.isclose((2 * size(region)) ** 2, area(region))


@pytest.mark.parametrize("region", [[1, 2, 3], np.ones((5, 5)), 3.0])
def test_displaced_takes_one_region(region):
    with pytest.raises(ValueError, match="^region has the shape .*give one"):
        displaced(region, dx=1)


def test_displaced_moves_along_the_image_axes_and_turns_and_scales():
    region = [50, 40, 0.3, 20, 10]
    assert displaced(region).tolist() == region
    assert displaced(region, dx=3).tolist() == [53, 40, 0.3, 20, 10]
    assert displaced(region, dy=3).tolist() == [50, 43, 0.3, 20, 10]
    assert displaced(region, dtheta=0.5).tolist() == [50, 40, 0.8, 20, 10]
    assert displaced(region, scale=2).tolist() == [50, 40, 0.3, 40, 20]


def test_displacements_broadcast_to_a_grid():
    grid = displaced([50, 40, 0, 20, 10], np.arange(3), np.arange(2)[:, None])
    assert grid.shape == (2, 3, 5)
    assert grid[1, 2].tolist() == [52, 41, 0, 20, 10]


@pytest.mark.parametrize("box", [[1, 2, 3], 7, [[1, 2, 3, 4, 5]]])
def test_a_box_has_four_numbers(box):
    with pytest.raises(ValueError, match="four numbers, not an array of the shape"):
        from_box(box)


@pytest.mark.parametrize(
    "x, y",
    [(-10, 20), (80, 20), (30, -5), (30, 60)],
    ids=["left", "right", "up", "down"],
)
def test_a_box_that_just_touches_an_image_lies_outside(x, y):
    """Of 80 x 60 px; half a pixel further in it does not."""
    step = 0.5 * np.sign([40 - x, 30 - y]) * [y == 20, x == 30]
    touching, within = from_box([[x, y, 10, 5], [*(step + [x, y]), 10, 5]])
    assert outside([touching, within], (60, 80, 3)).tolist() == [True, False]
