"""Histograms in ellipses are those of all pixels; what is turned touches its box."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mkt.colors import ColorBins, JointHSV
from mkt.histograms import coefficient
from mkt.regions import warp
from mkt.scenes.rendering import render
from mkt.trackers.adaptive import (
    upright,
)
from mkt.trackers.ellipses import Disc
from tests.strategies import frames
from tests.trackers.scenes import GROWING

ELLIPSES = np.array(
    [
        [120.0, 100.0, 0.0, 40.0, 50.0],
        [160.3, 120.8, 0.0, 45.0, 15.0],
        [80.5, 140.2, 0.0, 12.0, 48.0],
        [5.0, 6.0, 0.0, 30.0, 40.0],
    ]
)


def every_pixel(image, region, elliptic):
    """(3) and (4) as printed: a sum over all pixels inside the ellipse."""
    cx, cy, _, hx, hy = region
    y, x = np.indices(image.shape)
    r2 = ((x - cx) / hx) ** 2 + ((y - cy) / hy) ** 2
    inside = r2 <= 1
    printed = ((x - cx) ** 2 + (y - cy) ** 2) / (hx**2 + hy**2)
    k = 1 - (r2 if elliptic else printed)
    p = np.bincount(image.labels[inside], k[inside], image.m)
    return p / p.sum()


@pytest.mark.parametrize("elliptic", [False, True])
@pytest.mark.parametrize("bins", [ColorBins("rgb"), JointHSV()], ids=["rgb", "hsv"])
def test_the_fixed_grid_stands_for_all_pixels(bins, elliptic):
    """The default grid is close, a dense one as good as exact.

    And it is much closer to its own kernel than to the other one.
    """
    image = bins(render(replace(GROWING, background="workshop"), 5))
    fast, dense = (
        Disc(elliptic, samples).histograms(image, ELLIPSES)
        for samples in (1200, 30_000)
    )
    assert fast.shape == (4, bins.m)
    assert fast.sum(1) == pytest.approx(1, abs=1e-5)
    for p, better, region in zip(fast, dense, ELLIPSES, strict=True):
        exact = every_pixel(image, region, elliptic)
        other = every_pixel(image, region, not elliptic)
        assert 1 - coefficient(p, exact) < 0.06
        assert 1 - coefficient(better, exact) < 2e-3
        assert np.abs(better - exact).sum() < np.abs(better - other).sum() / 2


def one_by_one(image, points, region):
    """(3) with the printed radius, (4), one sample at a time."""
    cx, cy, _, hx, hy = region
    height, width = image.shape
    p = np.zeros(image.m)
    for x, y in points * region[3:]:
        column, row = round(cx + x), round(cy + y)
        if 0 <= column < width and 0 <= row < height:
            p[image.labels[row, column]] += 1 - (x**2 + y**2) / (hx**2 + hy**2)
    return p / p.sum() if p.any() else p


def ellipses_of(seed, n=3):
    """Upright ellipses (n, 5) in and around an image of 64 x 48 pixels."""
    rng = np.random.default_rng(seed)
    places = rng.uniform([-30, -30], [94, 78], (n, 2))
    return np.column_stack([places, np.zeros(n), rng.uniform(0.5, 40, (n, 2))])


@settings(max_examples=60)
@given(frames(), st.integers(0, 2**32 - 1), st.sampled_from([100, 400, 1200]))
def test_mixed_histograms_have_the_printed_radius(frame, seed, samples):
    disc, image, regions = Disc(samples=samples), ColorBins()(frame), ellipses_of(seed)
    points = disc.kernels.points
    off_border = np.abs(warp(regions, points) % 1 - 0.5)
    assume(off_border.min() > 5e-5)  # there single and double precision may differ
    expected = [one_by_one(image, points, region) for region in regions]
    assert disc.histograms(image, regions) == pytest.approx(
        np.array(expected), abs=1e-5
    )


@pytest.mark.parametrize(
    "halves, ends", [((30.0, 30.0), (0.5, 0.5)), ((10.0, 20.0), (0.8, 0.2))]
)
def test_the_printed_radius_leaves_weight_on_the_border(halves, ends):
    """At the ends of both half axes and in the middle."""
    points = np.array([[1.0, 0], [0, 1], [0, 0]])
    shares = np.square(halves) / np.sum(np.square(halves))
    assert shares @ Disc().kernels.weigh(points) == pytest.approx([*ends, 1])
    elliptic = Disc(elliptic=True).kernels.weigh(points)
    assert elliptic == pytest.approx(np.array([[0, 0, 1]]))


@pytest.mark.parametrize(
    "field, value",
    [("samples", "x"), ("samples", None), ("samples", 2.5), ("elliptic", "no")],
)
def test_a_disc_of_what_cannot_be_is_refused_when_it_is_made(field, value):
    with pytest.raises(ValueError, match=rf"^{field} is .*; it must be"):
        Disc(**{field: value})


def test_outside_the_image_nothing_is_counted():
    image = ColorBins("rgb")(render(GROWING, 0))
    ellipses = np.array([[-200.0, 50, 0, 20, 20], [0.0, 120, 0, 20, 20]])
    outside, half_inside = Disc().histograms(image, ellipses)
    assert not outside.any()
    assert half_inside.sum() == pytest.approx(1, abs=1e-5)


@given(st.floats(-3, 3), st.floats(5, 60), st.floats(5, 60))
def test_the_upright_ellipse_touches_the_box_of_the_turned_one(theta, hx, hy):
    angle = np.linspace(0, 2 * np.pi, 721)
    outline = warp(
        [[100, 90, theta, hx, hy]], np.stack([np.cos(angle), np.sin(angle)], 1)
    )
    region = upright(np.array([100, 90, theta, hx, hy]))
    assert region[:3].tolist() == [100, 90, 0]
    assert region[3:] == pytest.approx(np.abs(outline[0] - [100, 90]).max(0), rel=1e-3)
