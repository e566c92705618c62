"""What the drawings take, and where they put it."""

from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from mkt.colors import ColorBins
from mkt.kernels import Kernels
from mkt.plotting import (
    DESIRED,
    bin_colors,
    draw_ellipse,
    draw_histogram,
    draw_kernels,
    draw_map,
    draw_region,
    film_strip,
    new_figure,
    plot_track,
    shade_frames,
)
from mkt.regions import corners
from mkt.tracking import Sequence, Track

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


def test_the_cross_of_a_map_is_seen_at_the_border_too(ax):
    z = np.ones((3, 400))
    z[1, -1] = 0
    draw_map(ax, np.arange(400.0), np.arange(3.0), z)
    ax.set_axis_off()
    canvas = ax.figure.canvas
    canvas.draw()
    right = int(ax.bbox.x1)
    beyond = np.asarray(canvas.buffer_rgba())[:, right + 2 : right + 8, :3]
    assert beyond.min() < 50  # of white paper


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


@pytest.mark.parametrize("layout", ["3x3", "tiles"])
def test_kernels_are_drawn_round_the_samples_that_they_weigh(ax, layout):
    kernels = Kernels(layout, samples=2000, aspect=1.6)
    draw_kernels(ax, kernels)
    assert len(ax.patches) == len(kernels.weights)
    for patch, weights in zip(ax.patches, kernels.weights, strict=True):
        outline = patch.get_path().transformed(patch.get_patch_transform())
        inside = outline.contains_points(kernels.points * kernels.half_sides)
        assert np.mean(inside != (weights > 0)) < 0.01  # on the line
    (crosses,) = ax.lines
    assert np.allclose(crosses.get_xydata(), kernels.centres)


@pytest.fixture
def tracked():
    """Four frames of four greys, their true regions, and a track that is 5 px off."""
    truth = np.array([[20.0 + 10 * k, 30, 0.1 * k, 12, 8] for k in range(4)])
    frames = [np.full((60, 80, 3), 50 * k, np.uint8) for k in range(4)]
    found = truth + [5, 0, 0, 0, 0]
    lost = np.array([False, False, True, False])
    info = {"distance": np.array([0.0, 0.1, 0.7, 0.3])}
    clip = Sequence("toy", frames, truth, np.ones(4))
    return clip, Track(found, np.ones(4), lost, info)


def outlines(ax):
    """The boxes of the truth, twice, and of the estimate, as corners (4, 2)."""
    return [line.get_xydata()[:4] for line in ax.lines[:3]]


def assert_shows(ax, clip, regions, k):
    """The frame, the true region and the estimate of frame k."""
    (image,) = ax.images
    assert (image.get_array() == clip.frames[k]).all()
    expected = corners([clip.truth[k], clip.truth[k], regions[k]])
    np.testing.assert_allclose(outlines(ax), expected)


def test_a_track_is_plotted_with_its_distances_and_where_it_is_lost(tracked):
    clip, track = tracked
    fig = new_figure((4, 4))
    plot_track(fig, track, clip, 2)
    upper, lower = fig.axes
    assert_shows(upper, clip, track.regions, 2)
    assert upper.get_title() == "toy, frame 2, lost"
    curve, here = lower.lines
    assert curve.get_ydata().tolist() == track.info["distance"].tolist()
    assert set(here.get_xdata()) == {2}
    (shade,) = lower.collections
    (span,) = shade.get_paths()
    assert span.get_extents().intervalx.tolist() == [1.5, 2.5]
    assert to_rgb(shade.get_facecolor()[0]) == to_rgb(DESIRED)


def test_a_film_strip_shows_each_run_s_own_region_in_each_frame(tracked):
    clip, track = tracked
    other = track.regions + [0, 7, 0, 0, 0]
    fig = new_figure((6, 4))
    rows = {"one": (track.regions, "red"), "other": (other, "blue")}
    film_strip(fig, clip, (1, 3), rows)
    shown = [(regions, k) for regions, _ in rows.values() for k in (1, 3)]
    for ax, (regions, k) in zip(fig.axes, shown, strict=True):
        assert_shows(ax, clip, regions, k)


@pytest.mark.parametrize("k", [-1, 4, 999, 1.0, "1", None, True])
def test_a_frame_that_is_not_there_is_refused_before_anything_is_drawn(tracked, k):
    clip, track = tracked
    fig = new_figure((6, 4))
    said = "is .*; toy has 4 frames, so give a whole number from 0 to 3"
    with pytest.raises(ValueError, match=f"^frame {said}"):
        plot_track(fig, track, clip, k)
    with pytest.raises(ValueError, match=f"^one of frames {said}"):
        film_strip(fig, clip, [0, k], {"one": (track.regions, "red")})
    assert not fig.axes
    plot_track(fig, track, clip, np.int64(3))


def test_a_histogram_of_a_kernel_that_saw_nothing_is_empty(ax):
    draw_histogram(ax, np.zeros(ColorBins().m), ColorBins())  # a warning is an error
    for q in (np.ones(50), np.ones((9, 110))):
        with pytest.raises(ValueError, match="q has the shape .*, but there are 110"):
            draw_histogram(ax, q, ColorBins())
    assert ax.get_ylim() == (0, 1.05)
