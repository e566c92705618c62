"""Histograms against a straightforward implementation, one pixel at a time.

And the properties of the coefficient.
"""

from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mkt.colors import BinImage, ColorBins
from mkt.histograms import (
    coefficient,
    counts,
    distance,
    histograms,
    learn,
    log_likelihood,
    mixed_histograms,
    normalised,
    sample,
)
from mkt.kernels import LAYOUTS, PROFILES, Kernels
from mkt.regions import warp
from tests.strategies import frames, regions
from tests.test_colors import BINS


def reference_histograms(image, kernels, region):
    """One region, one kernel, one sample at a time."""
    height, width = image.shape
    places = np.round(warp(region, kernels.points)).astype(int)
    q = np.zeros((len(kernels.weights), image.m))
    for j, weights in enumerate(kernels.weights):
        for (column, row), weight in zip(places, weights, strict=True):
            if 0 <= column < width and 0 <= row < height:
                q[j, image.labels[row, column]] += weight
        if q[j].sum() > 0:
            q[j] /= q[j].sum()
    return q


def nearly_on_a_pixel_border(kernels, region):
    """The share of samples whose pixel depends on the last digit.

    Single and double precision may differ there.
    """
    return np.mean(np.abs(np.abs(warp(region, kernels.points) % 1 - 0.5)) < 1e-3)


@settings(max_examples=60)
@given(
    frames(),
    regions(),
    st.sampled_from(LAYOUTS),
    st.sampled_from(PROFILES),
    st.booleans(),
    st.sampled_from(BINS),
)
def test_histograms_equal_the_reference(frame, region, layout, profile, elliptic, bins):
    kernels = Kernels(layout, profile, elliptic=elliptic, samples=300)
    kernels = kernels.fitted([0, 0, 0, 4, 3])
    image = bins(frame)
    expected = reference_histograms(image, kernels, region)
    computed = histograms(image, kernels, region)[0]
    # A kernel of which hardly the rim is in the image has a sum that is rounding alone.
    seen = counts(image, kernels, region)[0].sum(-1)
    computed, expected = (q[(seen == 0) | (seen > 1e-4)] for q in (computed, expected))
    assume(len(expected))
    # One sample of 300 moves a bin of one kernel by at most a few hundredths; away from
    # borders they agree to rounding.
    borderline = nearly_on_a_pixel_border(kernels, region)
    assert np.abs(computed - expected).sum(-1).max() <= 1e-5 + 60 * borderline


def test_a_kernel_of_which_only_the_border_is_seen_sees_nothing():
    """Its points there weigh 6e-18, a rounding error."""
    kernels = Kernels("5x5", samples=400, aspect=1.0)
    image = ColorBins()(np.full((48, 64, 3), 200, np.uint8))
    q = histograms(image, kernels, [0, 61.5, 4.125, 2, 39])
    assert set(q.sum(-1).round(6).ravel()) == {0, 1} and (q[0, 16] == 0).all()


@settings(max_examples=60)
@given(
    frames(),
    regions(),
    st.sampled_from(LAYOUTS),
    st.sampled_from(PROFILES),
    st.sampled_from(BINS),
)
def test_each_sums_to_one_or_sees_nothing(frame, region, layout, profile, bins):
    kernels = Kernels(layout, profile, samples=400, aspect=1.0)
    q = histograms(bins(frame), kernels, region)
    total = q.sum(-1)
    assert np.all(np.isclose(total, 1, atol=1e-5) | (total == 0))
    rho = coefficient(q, q)
    assert np.allclose(rho, total, atol=1e-5)
    d = distance(rho, axis=-1)
    assert np.isfinite(d).all() and (0 <= d).all() and (d <= 1).all()


@given(frames(), st.integers(-9, 9), st.integers(-9, 9), st.floats(-3, 3))
def test_moving_image_and_region_together_changes_nothing(frame, dx, dy, theta):
    kernels, bins = Kernels(samples=400, aspect=1.0), ColorBins()
    moved = np.roll(frame, (dy, dx), (0, 1))
    region = np.array([32.13, 24.29, theta, 9.0, 9.0])
    before = histograms(bins(frame), kernels, region)
    after = histograms(bins(moved), kernels, region + [dx, dy, 0, 0, 0])
    borderline = nearly_on_a_pixel_border(kernels, region)
    assert np.abs(before - after).sum() <= 1e-5 + 4000 * borderline


def test_parts_outside_the_image_have_coefficient_zero():
    # An odd number of columns, so that some samples have x = 0.
    kernels = Kernels("tiles", "uniform", aspect=1.0, samples=33**2)
    image = BinImage(np.zeros((48, 64), np.uint8), ColorBins().m)
    half_outside = histograms(image, kernels, [0.0, 24.0, 0.0, 30.0, 30.0])
    rho = coefficient(half_outside, histograms(image, kernels, [32, 24, 0, 9, 9]))
    assert np.allclose(rho.reshape(3, 3), [[0, 1, 1]] * 3)


@pytest.mark.parametrize("samples", [20**2, 33**2])
@pytest.mark.parametrize("layout", ["tiles", "3x3", "ellipse"])
@pytest.mark.parametrize(
    "lost",
    [
        [1e9, 0, 0, 9, 9],
        [1e10, 0, 0, 9, 9],
        [np.nan] * 5,
        [np.inf, 0, 0, 9, 9],
        [30, 20, 0, np.nan, 9],
        [30, 20, 0.3, 9, np.inf],
        np.full((3, 3), np.nan),
        np.diag([1e12, 1, 1]),
        [[9, 0, np.inf], [0, 9, 20], [0, 0, 1]],
    ],
)
def test_nothing_is_counted_in_what_is_not_finite_or_too_far(samples, layout, lost):
    kernels = Kernels(layout, "uniform", aspect=1.0, samples=samples)
    image = BinImage(np.zeros((48, 64), np.uint8), ColorBins().m)
    assert (histograms(image, kernels, [lost]) == 0).all()


def noise_and_regions(n=70):
    """An image of bins, and regions (n, 5) in it."""
    rng = np.random.default_rng(1)
    image = ColorBins()(rng.integers(0, 256, (60, 80, 3), dtype=np.uint8))
    places = rng.uniform(0, [80, 60], (n, 2))
    return image, np.column_stack(
        [places, rng.uniform(-3, 3, n), rng.uniform(3, 20, (n, 2))]
    )


@pytest.mark.parametrize(
    "layout, profile",
    [("3x3", "epanechnikov"), ("tiles", "uniform"), ("ellipse", "uniform")],
)
def test_many_regions_equal_one_at_a_time(layout, profile):
    image, many = noise_and_regions()
    kernels = Kernels(layout, profile, aspect=1.0)
    together = histograms(image, kernels, many)
    apart = np.concatenate([histograms(image, kernels, region) for region in many])
    assert np.allclose(together, apart, atol=1e-6)


def test_a_frame_is_no_image_of_bins_for_mixed_histograms_either():
    with pytest.raises(ValueError, match="image is of the type ndarray; give bins"):
        mixed_histograms(np.zeros((4, 4, 3), np.uint8), Kernels("axes"), [], [])


def test_another_way_to_combine_is_refused():
    with pytest.raises(ValueError, match="combine is 'max'; it must be sum or mean"):
        log_likelihood([0.5, 0.6], combine="max")


def test_mixed_histograms_are_those_of_the_mixed_weights():
    image, many = noise_and_regions()
    kernels = Kernels("axes", aspect=1.0)
    shares = np.random.default_rng(2).uniform(0.1, 1, (len(many), 2))
    mixed = mixed_histograms(image, kernels, many, shares)
    apart = counts(image, kernels, many)
    expected = normalised(np.einsum("nj,njm->nm", shares.astype(np.float32), apart))
    assert np.allclose(mixed, expected, atol=1e-6)


# What belongs together: an image and its bins, kernels and their object


def test_a_second_look_leaves_the_first_one_alone():
    """The arrays to work in, which are shared, never come out."""
    image, (first, second, *_) = noise_and_regions()
    kernels = Kernels(aspect=1.0)
    looks = [sample(image, kernels, region) for region in (first, second)]
    kept = looks[0].copy()
    assert not np.shares_memory(*looks) and (looks[0] != looks[1]).any()
    histograms(image, kernels, second)
    assert (looks[0] == kept).all() and looks[0].shape == (len(kernels.points),)


def test_a_point_outside_has_the_number_beyond_the_last_bin():
    image, _ = noise_and_regions()
    far = np.array([1e9, 0, 0, 5, 5])
    assert (sample(image, Kernels(aspect=1.0), far) == image.m).all()


def test_an_image_of_other_bins_than_those_learnt_is_refused():
    frame = np.random.default_rng(0).integers(0, 256, (48, 64, 3), np.uint8)
    region = [32, 24, 0, 9, 9]
    target = learn(ColorBins()(frame), region, Kernels())
    other = ColorBins("rgb")(frame)
    says = "image has 512 bins, but the reference 110; make both with the same bins"
    for compare in (target.coefficients, target.distances):
        with pytest.raises(ValueError, match=says):
            compare(other, [region])
    assert target.distances(ColorBins()(frame), region) == pytest.approx(0, abs=1e-3)


def test_kernels_that_are_not_fitted_to_an_object_are_refused():
    image, (region, *many) = noise_and_regions()
    remedy = r"not fitted to an object yet; take kernels\.fitted\(region\)"
    for kernels in (Kernels(), Kernels("tiles", "uniform")):
        with pytest.raises(ValueError, match=remedy):
            histograms(image, kernels, many)
        with pytest.raises(ValueError, match=remedy):
            sample(image, kernels, region)


def test_learning_fits_the_kernels():
    image, _ = noise_and_regions()
    target = learn(image, [40, 30, 0, 12, 8], Kernels())
    assert target.kernels.aspect == 1.5 and target.m == image.m
    with pytest.raises(ValueError, match="part of the region .* outside the image"):
        learn(image, [-10, 30, 0, 20, 20], Kernels())


# The coefficient and the distance


@given(st.integers(2, 40), st.integers(0, 2**32 - 1))
def test_distance_equals_opencv(m, seed):
    p, q = np.random.default_rng(seed).dirichlet(np.ones(m), 2).astype(np.float32)
    theirs = cv2.compareHist(p, q, cv2.HISTCMP_BHATTACHARYYA)
    assert distance(coefficient(p, q)) == pytest.approx(theirs, abs=2e-3)


def test_squared_distance_is_half_the_squared_difference_of_roots():
    p, q = np.random.default_rng(0).dirichlet(np.ones(9), 2)
    half = 0.5 * np.sum((np.sqrt(p) - np.sqrt(q)) ** 2)
    assert distance(coefficient(p, q)) ** 2 == pytest.approx(half)


@pytest.mark.parametrize("m", [1, 3])
def test_histograms_of_other_bins_are_not_compared(m):
    said = rf"q has the shape \(1, 2\) and reference \({m},\); make both with the same"
    with pytest.raises(ValueError, match=said):
        coefficient([[0.5, 0.5]], np.full(m, 1 / m))


def test_few_samples_are_looked_up_for_many_regions():
    """More rows at once than OpenCV counts to."""
    image = ColorBins()(np.zeros((20, 20, 3), np.uint8))
    one = Kernels("one", "uniform", aspect=1.0, samples=3)
    region = np.array([10.0, 10, 0, 4, 4])
    q = histograms(image, one, np.tile(region, (40_000, 1)))
    assert np.allclose(q, histograms(image, one, region[None]))


def test_more_samples_than_opencv_counts_to_are_refused_for_one_region_too():
    image = ColorBins()(np.zeros((20, 20, 3), np.uint8))
    many = Kernels(aspect=1.0, samples=40_000)
    with pytest.raises(ValueError, match="samples is 40000, too many"):
        sample(image, many, np.array([10.0, 10, 0, 4, 4]))


def test_two_threads_do_not_share_their_room():
    rng = np.random.default_rng(0)
    images = [BinImage(rng.integers(0, 9, (60, 80), np.uint8), 9) for _ in range(2)]
    kernels = Kernels("3x3").fitted([40, 30, 0, 20, 10])
    regions = np.array([40, 30, 0, 20, 10]) + rng.normal(0, 3, (400, 5)) * [
        1,
        1,
        0,
        0,
        0,
    ]
    alone = [histograms(image, kernels, regions) for image in images]
    with ThreadPoolExecutor(2) as pool:
        for _ in range(20):
            together = pool.map(lambda i: histograms(i, kernels, regions), images)
            for one, other in zip(alone, together, strict=True):
                assert np.array_equal(one, other)


def test_the_likelihood_takes_the_sum_or_the_mean_of_squared_distances():
    rho = np.array([[0.9, 0.7], [1.0, 0.0]])
    assert np.allclose(log_likelihood(rho, 20.0), [-8, -20])
    assert np.allclose(log_likelihood(rho, 20.0, "mean"), [-4, -10])
    # Rounding may put a coefficient above 1; nothing is likelier than equality.
    assert (log_likelihood([[1 + 1e-6]]) == 0).all()
    assert distance(1 + 1e-6) == 0


def test_overlapping_constant_kernels_are_counted_in_each():
    kernels = Kernels("4x4", "uniform", span=1.0, aspect=1.0)
    assert kernels.parts is None and (kernels.weights > 0).sum(0).max() > 1


class Columns(Kernels):
    """Constant kernels side by side, as many as the sides of their grid allow."""

    def _squared_radii(self, plane):
        j = self.samples
        own = np.floor((plane[:, 0] / self.half_sides[0] + 1) / 2 * j)
        return np.where(own == np.arange(j)[:, None], 0.0, 2.0)


@pytest.mark.parametrize("j", [255, 256, 257, 300])
def test_more_constant_kernels_than_a_byte_has_numbers_are_counted_apart(j):
    # So flat that each kernel has one sample, all in one row.
    kernels = Columns("tiles", "uniform", aspect=1000.0, samples=j)
    labels = np.random.default_rng(0).integers(0, 9, (3, 320), np.uint8)
    q = histograms(BinImage(labels, 9), kernels, [[(j - 1) / 2, 1, 0, j / 2, 0.5]])[0]
    assert kernels.parts is not None and len(q) == j
    assert (q.argmax(-1) == labels[1, :j]).all() and (q.max(-1) == 1).all()


IMAGE = ColorBins()(
    np.random.default_rng(5).integers(0, 256, (60, 80, 3), dtype=np.uint8)
)


@given(st.integers(0, 2**32 - 1), st.integers(1, 9))
def test_distances_are_roots_of_what_the_coefficients_lack(seed, parts):
    """(5) of [T09]: over the parts, d is the root of the mean of the squares."""
    rho = np.random.default_rng(seed).random((4, parts))
    assert np.allclose(distance(rho) ** 2, 1 - rho)
    assert np.allclose(distance(rho, axis=-1) ** 2, 1 - rho.mean(-1))
    assert distance(1 + 1e-9) == 0


@given(st.integers(0, 2**32 - 1), st.integers(2, 9))
def test_the_likelihood_adds_parts_and_keeps_regions_apart(seed, parts):
    rho = np.random.default_rng(seed).random((3, 4, parts))
    by_sum, by_mean = (log_likelihood(rho, combine=how) for how in ("sum", "mean"))
    assert by_sum.shape == by_mean.shape == (3, 4)
    assert np.allclose(by_sum, -20 * np.sum(1 - rho, -1))
    assert np.allclose(by_sum, parts * by_mean)


def test_distances_have_the_shape_of_the_regions():
    region = np.array([40.0, 30, 0.2, 14, 9])
    target = learn(IMAGE, region, Kernels("2x2"))
    many = region + np.random.default_rng(0).normal(0, 2, (2, 3, 5)) * [1, 1, 0, 0, 0]
    d = target.distances(IMAGE, many)
    assert d.shape == (2, 3) and target.distances(IMAGE, region) < 1e-3
    for k in np.ndindex(2, 3):
        rho = coefficient(histograms(IMAGE, target.kernels, many[k])[0], target.q)
        assert d[k] == pytest.approx(np.sqrt(np.mean(1 - rho)), abs=1e-6)


def test_an_object_that_is_partly_outside_is_learnt_by_the_kernels_that_see_it():
    half, away = np.array([0.0, 30, 0, 15, 15]), np.array([-90.0, 30, 0, 15, 15])
    tiles = Kernels("tiles", "uniform")
    with pytest.raises(ValueError, match="outside the image"):
        learn(IMAGE, half, tiles)
    target = learn(IMAGE, half, tiles, partly=True)
    assert target.learnt is not None
    assert target.learnt.tolist() == [1, 2, 4, 5, 7, 8]  # not the left column
    rho = target.coefficients(IMAGE, half[None])
    assert rho.shape == (1, 6) and np.allclose(rho, 1) and target.counted == 6
    with pytest.raises(ValueError, match="outside the image"):
        learn(IMAGE, away, tiles, partly=True)
    assert learn(IMAGE, [40.0, 30, 0, 15, 15], tiles, partly=True).learnt is None


@pytest.mark.parametrize("shares", [np.ones((1, 9)), np.ones(9), np.ones((2, 8))])
def test_each_region_has_a_share_of_each_kernel(shares):
    kernels = Kernels("3x3").fitted([40.0, 30, 0, 20, 15])
    with pytest.raises(ValueError, match=r"shares has the shape .*, \(2, 9\)"):
        mixed_histograms(IMAGE, kernels, [[40.0, 30, 0, 20, 15]] * 2, shares)


def test_a_frame_is_no_image_of_bins_and_a_name_no_kernels():
    frame, region = np.zeros((60, 80, 3), np.uint8), [40.0, 30, 0, 20, 15]
    image, kernels = ColorBins()(frame), Kernels("3x3")
    with pytest.raises(ValueError, match="image is of .* ndarray; give bins.frame."):
        learn(frame, region, kernels)
    with pytest.raises(ValueError, match="give bins.frame., not the frame itself"):
        learn(image, region, kernels).distances(frame, region)
    with pytest.raises(ValueError, match="kernels is of the type str; give Kernels"):
        learn(image, region, "3x3")
