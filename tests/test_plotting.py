"""What the drawings take, and where they put it."""

from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from mkt.colors import ColorBins
from mkt.plotting import (
    bin_colors,
    draw_ellipse,
    draw_histogram,
    draw_map,
    draw_region,
    shade_frames,
)

# From its middle (50, 40) its right side is 20 px away, to the right and downwards.
TURNED = np.array([50, 40, np.deg2rad(30), 20, 8])
RIGHT = [20 * np.sqrt(0.75), 10]


@pytest.fixture
def ax():
    fig, ax = plt.subplots()
    yield ax
    plt.close(fig)


def test_a_histogram_may_be_a_list():
    """As a student's may be, who has written it without numpy."""
    bins = ColorBins()
    q = np.zeros(bins.m)
    q[[3, 40]] = 0.25, 0.75
    heights = []
    for given in (q, q.tolist()):
        fig, ax = plt.subplots()
        draw_histogram(ax, given, bins)
        (bars,) = ax.collections
        heights.append([path.get_extents().height for path in bars.get_paths()])
        plt.close(fig)
    assert heights[0] == heights[1] == [0.25, 0.75]


def test_a_flat_surface_has_a_map_without_contours(ax):
    mesh = draw_map(ax, np.arange(3.0), np.arange(2.0), np.full((2, 3), 0.5))
    assert list(ax.collections) == [mesh]


def test_the_cross_of_a_map_stands_at_its_lowest_point(ax):
    z = np.array([[3.0, 2.0, 9.0], [4.0, 5.0, 1.0]])
    draw_map(ax, np.array([10.0, 20.0, 30.0]), np.array([-1.0, 1.0]), z)
    (cross,) = ax.lines
    assert cross.get_xydata().tolist() == [[30, 1]]


def test_the_tick_of_a_region_points_to_its_right_side(ax):
    draw_region(ax, TURNED)
    _, tick = ax.lines
    start, end = tick.get_xydata()
    assert start == pytest.approx([50, 40]) and end - start == pytest.approx(RIGHT)


def test_an_ellipse_ends_where_its_region_does(ax):
    draw_ellipse(ax, TURNED)
    (ellipse,) = ax.patches
    right, lower = ellipse.get_patch_transform().transform([[1, 0], [0, 1]]) - [50, 40]
    assert right == pytest.approx(RIGHT)
    assert lower == pytest.approx([-4, 8 * np.sqrt(0.75)])


def test_a_bin_of_one_colour_has_it_and_one_of_none_is_white():
    class Three:
        m = 3

        def __call__(self, frame):
            return SimpleNamespace(labels=(frame == (252, 0, 126)).all(-1) * 1)

    colors = np.array([to_rgb("#fc007e"), to_rgb("white")])
    assert bin_colors(Three())[1:] == pytest.approx(colors)


def test_shaded_frames_are_shaded_from_half_before_to_half_after_them(ax):
    shade_frames(ax, np.arange(2, 9), np.isin(np.arange(2, 9), (2, 4, 5, 8)))
    (shade,) = ax.collections
    spans = [path.get_extents().intervalx.tolist() for path in shade.get_paths()]
    assert spans == [[1.5, 2.5], [3.5, 5.5], [7.5, 8.5]]


def test_where_there_is_nothing_to_shade_nothing_is_shaded(ax):
    shade_frames(ax, np.arange(3), np.zeros(3, bool))
    assert not any(len(shade.get_paths()) for shade in ax.collections)
