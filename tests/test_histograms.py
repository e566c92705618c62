"""Bins and histograms against a straightforward implementation, one pixel at a time, and the properties of the coefficient."""

import colorsys

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mkt.histograms import ColorBins, coefficient, distance, histograms
from mkt.kernels import LAYOUTS, PROFILES, Kernels
from mkt.regions import warp
from tests.strategies import frames, regions

BINS = [ColorBins(), ColorBins("hsv", (8, 8, 8)), ColorBins("rgb"), ColorBins("rgb", (4, 5, 6)), ColorBins("hs")]


def reference_histograms(image, m, kernels, region):
    """One region, one kernel, one sample at a time."""
    height, width = image.shape
    q = np.zeros((len(kernels.weights), m))
    for j, weights in enumerate(kernels.weights):
        for (x, y), weight in zip(warp(region, kernels.points), weights):
            column, row = round(x), round(y)
            if 0 <= column < width and 0 <= row < height:
                q[j, image[row, column]] += weight
        if q[j].sum() > 0:
            q[j] /= q[j].sum()
    return q


def nearly_on_a_pixel_border(kernels, region):
    """Samples whose pixel depends on the last digit: single and double precision may differ there."""
    return np.mean(np.abs(np.abs(warp(region, kernels.points) % 1 - 0.5)) < 1e-3)


@settings(max_examples=60, deadline=None)
@given(frames(), regions(), st.sampled_from(LAYOUTS), st.sampled_from(PROFILES), st.booleans(), st.sampled_from(BINS))
def test_histograms_equal_the_reference(frame, region, layout, profile, elliptic, bins):
    kernels = Kernels(layout, profile, elliptic=elliptic, samples=300).fitted([0, 0, 0, 4, 3])
    image = bins(frame)
    expected = reference_histograms(image, bins.m, kernels, region)
    computed = histograms(image, bins.m, kernels, region)[0]
    # One sample of 300 moves a bin of one kernel by at most a few hundredths; away from borders they agree to rounding.
    borderline = nearly_on_a_pixel_border(kernels, region)
    assert np.abs(computed - expected).sum(-1).max() <= 1e-5 + 60 * borderline


@settings(max_examples=60, deadline=None)
@given(frames(), regions(), st.sampled_from(LAYOUTS), st.sampled_from(PROFILES), st.sampled_from(BINS))
def test_each_sums_to_one_or_sees_nothing(frame, region, layout, profile, bins):
    kernels = Kernels(layout, profile, samples=400)
    q = histograms(bins(frame), bins.m, kernels, region)
    total = q.sum(-1)
    assert np.all(np.isclose(total, 1, atol=1e-5) | (total == 0))
    rho = coefficient(q, q)
    assert np.allclose(rho, total, atol=1e-5)
    d = distance(rho, axis=-1)
    assert np.isfinite(d).all() and (0 <= d).all() and (d <= 1).all()


@settings(deadline=None)
@given(frames(), st.integers(-9, 9), st.integers(-9, 9), st.floats(-3, 3))
def test_moving_image_and_region_together_changes_nothing(frame, dx, dy, theta):
    kernels, bins = Kernels(samples=400), ColorBins()
    moved = np.roll(frame, (dy, dx), (0, 1))
    region = np.array([32.13, 24.29, theta, 9.0, 9.0])
    a, b = (histograms(bins(f), bins.m, kernels, r) for f, r in ((frame, region), (moved, region + [dx, dy, 0, 0, 0])))
    assert np.abs(a - b).sum() <= 1e-5 + 4000 * nearly_on_a_pixel_border(kernels, region)


def test_parts_outside_the_image_have_coefficient_zero():
    bins, kernels = ColorBins(), Kernels("tiles", "uniform")
    image = np.zeros((48, 64), np.uint8)
    half_outside = [0.0, 24.0, 0.0, 30.0, 30.0]
    rho = coefficient(histograms(image, bins.m, kernels, half_outside), histograms(image, bins.m, kernels, [32, 24, 0, 9, 9]))
    assert np.allclose(rho.reshape(3, 3), [[0, 1, 1]] * 3)
    for lost in ([1e9, 0, 0, 9, 9], [np.nan] * 5, [np.inf, 0, 0, 9, 9]):
        assert (histograms(image, bins.m, kernels, lost) == 0).all()


def test_many_regions_equal_one_at_a_time():
    rng = np.random.default_rng(1)
    bins = ColorBins()
    image = bins(rng.integers(0, 256, (60, 80, 3), dtype=np.uint8))
    many = np.column_stack([rng.uniform(0, 80, 70), rng.uniform(0, 60, 70), rng.uniform(-3, 3, 70), rng.uniform(3, 20, (70, 2))])
    for kernels in (Kernels(), Kernels("tiles", "uniform"), Kernels("ellipse", "uniform")):
        together = histograms(image, bins.m, kernels, many)
        apart = np.concatenate([histograms(image, bins.m, kernels, r) for r in many])
        assert np.allclose(together, apart, atol=1e-6)


@pytest.mark.parametrize("bins", BINS, ids=str)
def test_bins_cover_their_range_and_nothing_else(bins):
    colours = np.stack(np.meshgrid(*[np.arange(0, 256, 5, dtype=np.uint8)] * 3), -1).reshape(52, -1, 3)
    image = bins(colours)
    lowest = 1 if bins == ColorBins() else 0  # ten steps of saturation, of which the first is all grey
    assert image.min() == lowest and image.max() == bins.m - 1 and image.dtype == bins.dtype


def test_grey_and_dark_pixels_go_to_value_bins():
    bins = ColorBins()
    grey = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 3, 1)[None]
    assert (bins(grey) == 100 + np.arange(256) * 10 // 256).all()
    assert bins(np.array([[[40, 0, 0]]], np.uint8))[0, 0] >= 100  # V = .16: too dark for its hue to mean much
    assert bins(np.array([[[200, 20, 30]]], np.uint8))[0, 0] < 100


@given(st.tuples(*[st.integers(0, 255)] * 3))
def test_hsv_bins_follow_the_standard_library(rgb):
    h, s, v = colorsys.rgb_to_hsv(*(c / 255 for c in rgb))
    scaled = np.array([h * 10, s * 10, v * 10])
    if np.abs(scaled - np.round(scaled)).min() > 0.1 and abs(s - 0.1) > 0.02 and abs(v - 0.2) > 0.02:
        expected = int(scaled[0]) * 10 + int(scaled[1]) if s > 0.1 and v > 0.2 else 100 + int(scaled[2])
        assert ColorBins()(np.array([[rgb]], np.uint8))[0, 0] == expected


def test_rgb_bins_are_joint():
    assert ColorBins("rgb")(np.array([[[255, 0, 32]]], np.uint8))[0, 0] == 7 * 64 + 0 * 8 + 1


@given(st.integers(2, 40), st.integers(0, 2**32 - 1))
def test_distance_equals_opencv(m, seed):
    p, q = np.random.default_rng(seed).dirichlet(np.ones(m), 2).astype(np.float32)
    assert distance(coefficient(p, q)) == pytest.approx(cv2.compareHist(p, q, cv2.HISTCMP_BHATTACHARYYA), abs=2e-3)


def test_squared_distance_is_half_the_squared_difference_of_roots():
    p, q = np.random.default_rng(0).dirichlet(np.ones(9), 2)
    assert distance(coefficient(p, q)) ** 2 == pytest.approx(0.5 * np.sum((np.sqrt(p) - np.sqrt(q)) ** 2))


@pytest.mark.parametrize("frame", [np.zeros((4, 4), np.uint8), np.zeros((4, 4, 4), np.uint8), np.zeros((4, 4, 3), np.uint16)])
def test_wrong_frames_are_refused(frame):
    with pytest.raises(ValueError, match="uint8 RGB"):
        ColorBins()(frame)


@pytest.mark.parametrize("arguments", [{"space": "lab"}, {"counts": (3, 3)}, {"counts": (0, 1, 1)}])
def test_bad_bins_are_named(arguments):
    with pytest.raises(ValueError, match=next(iter(arguments))):
        ColorBins(**arguments)
