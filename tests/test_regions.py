"""The currency: warping, corners, boxes."""

import numpy as np
from hypothesis import given

from mkt.regions import area, corners, from_box, to_box, unwarp, warp, wrap_angle
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
