"""Bins that know their neighbours, against another way to compute them."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from mkt.colors import ColorBins
from mkt.neighbours import (
    MEASURES,
    SoftBins,
    circular_emd,
    hsv_counts,
    quadratic,
    shared,
    smoothing,
)

BINS = ColorBins(counts=(6, 4, 3))


@pytest.mark.parametrize("name", MEASURES)
def test_nothing_seen_is_as_unlike_as_can_be(name):
    """Or particles of a filter would win by leaving the image."""
    grey = np.eye(BINS.m)[-1]
    both = MEASURES[name](np.stack([np.zeros(BINS.m), grey]), grey, BINS)
    assert both == pytest.approx([1, 0], abs=1e-6)


def hues(frame, bins):
    """The histogram of the hues of a frame of bright colours."""
    image = bins(frame)
    count = sum(np.bincount(a.ravel(), minlength=image.m) for a in image.layers)
    colours = count[:100].reshape(10, 10).sum(1)
    return colours / colours.sum()


def of_hue(hue):
    """A saturated frame of one hue [2 deg]."""
    return cv2.cvtColor(
        np.full((2, 2, 3), (hue, 200, 200), np.uint8), cv2.COLOR_HSV2RGB
    )


@pytest.mark.parametrize("hue", range(0, 180, 7))
def test_soft_votes_are_shared_by_how_near_the_border_is(hue):
    """The share of the own bin falls linearly from its middle to its border."""
    inside = (hue % 18 + 0.5) / 18
    expected = 1 - abs(inside - 0.5)
    assert hues(of_hue(hue), SoftBins())[hue // 18] == pytest.approx(expected, abs=0.15)
    assert hues(of_hue(hue), ColorBins())[hue // 18] == 1


def test_soft_votes_go_round_the_circle_of_hues():
    assert np.flatnonzero(hues(of_hue(0), SoftBins())).tolist() == [0, 9]
    assert np.flatnonzero(hues(of_hue(179), SoftBins())).tolist() == [0, 9]


def test_votes_have_all_shifts_in_each_channel():
    shifts = np.array([bins.shift for bins in SoftBins()._moved])
    assert np.allclose(np.sort(shifts, 0), np.linspace(-0.4, 0.4, 5)[:, None])
    assert len({tuple(pair) for pair in shifts[:, :2].tolist()}) == 5


def test_smoothing_is_a_quadratic_form_that_keeps_the_sum():
    S = smoothing(BINS).toarray()
    assert np.allclose(S, S.T) and np.allclose(S.sum(1), 1)
    assert np.linalg.eigvalsh(S).min() > -1e-6
    first = S[0, :24].reshape(6, 4)  # hue 0, saturation 0: half of a half stays
    assert first[0, 0] == pytest.approx(0.375) and first[5, 0] == first[1, 0]
    assert not S[:24, 24:].any()


def test_shared_is_the_product_for_any_shape():
    q = np.random.default_rng(0).random((2, 3, BINS.m))
    assert np.allclose(shared(q, BINS), q @ smoothing(BINS).toarray(), atol=1e-6)


def test_neighbours_are_known_for_hsv_alone():
    assert hsv_counts(ColorBins()) == (10, 10, 10)
    with pytest.raises(ValueError, match="space is rgb"):
        smoothing(ColorBins("rgb"))


@given(st.lists(st.tuples(*[st.integers(0, 6)] * 2), min_size=1, max_size=12))
def test_circular_emd_is_the_cheapest_assignment(pairs):
    """Each of n units is carried to one of n places, the shorter way round."""
    start, end = np.array(pairs).T
    gap = np.abs(start[:, None] - end)
    cost = np.minimum(gap, 7 - gap)
    cheapest = cost[linear_sum_assignment(cost)].sum() / len(pairs) / 3.5
    p, q = (np.bincount(each, minlength=7) / len(pairs) for each in (start, end))
    assert circular_emd(p, q) == pytest.approx(cheapest, abs=1e-9)


@pytest.mark.parametrize("name", MEASURES)
def test_measures_are_squared_distances(name):
    rng = np.random.default_rng(1)
    q = rng.dirichlet(np.full(BINS.m, 0.1), (20, 2)).astype(np.float32)
    d2 = MEASURES[name](q[:, 0], q[:, 1], BINS)
    assert d2.min() >= -1e-6 and d2.max() <= 1 + 1e-6
    assert np.allclose(MEASURES[name](q, q, BINS), 0, atol=1e-6)
    assert np.allclose(d2, MEASURES[name](q[:, 1], q[:, 0], BINS), atol=1e-6)


@pytest.mark.parametrize("name", ["smoothed", "quadratic", "earth mover"])
def test_a_neighbouring_hue_is_nearer_than_a_far_one(name):
    one = np.eye(BINS.m, dtype=np.float32)
    near, across, far = (MEASURES[name](one[u], one[1], BINS) for u in (5, 21, 13))
    assert near < far and across < far
    assert MEASURES["bhattacharyya"](one[[5, 13]], one[1], BINS).tolist() == [1, 1]


def test_quadratic_is_half_the_form_and_one_for_bins_apart():
    p, q = np.eye(BINS.m)[[0, 14]]
    off, S = p - q, smoothing(BINS).toarray()
    assert MEASURES["quadratic"](p, q, BINS) == pytest.approx(off @ S @ off / 2)


def test_the_earth_mover_carries_what_both_have_of_colour_and_pays_for_the_rest():
    """Half of p is of hue 0, and a quarter of q of hue 3 of 6, which is opposite."""
    p, q = np.zeros((2, BINS.m))
    p[[0, -1]] = 0.5
    q[[3 * 4, -1]] = 0.25, 0.75
    expected = 0.25 * 1 + abs(0.5 - 0.25)
    assert MEASURES["earth mover"](p, q, BINS) == pytest.approx(expected)
    assert MEASURES["earth mover"](q, p, BINS) == pytest.approx(expected)


@given(st.integers(3, 12), st.integers(0, 2**32 - 1))
def test_the_circle_is_cut_where_that_is_cheapest(n, seed):
    p, q = np.random.default_rng(seed).dirichlet(np.ones(n), 2)
    gap = np.cumsum(p - q)
    cheapest = min(np.abs(gap - cut).sum() for cut in gap) / (n / 2)
    assert circular_emd(p, q) == pytest.approx(cheapest)


@pytest.mark.parametrize("p, q", [([], []), (1.0, 1.0), ([1.0], [0.5, 0.5])])
def test_histograms_of_other_bins_or_of_none_have_no_distance(p, q):
    with pytest.raises(ValueError, match="p and q have the shapes .* the same bins"):
        circular_emd(p, q)


@pytest.mark.parametrize("name", ["smoothed", "quadratic", "earth mover"])
@pytest.mark.parametrize("m", [1, 26, 28, 54])
def test_histograms_of_other_bins_have_no_neighbours(name, m):
    q = np.full((9, m), 1 / m)
    with pytest.raises(ValueError, match="makes 27 bins; give"):
        MEASURES[name](q, q, BINS)


@pytest.mark.parametrize("name", ["smoothed", "earth mover"])
def test_nor_has_a_reference_of_other_bins(name):
    q, reference = np.full(27, 1 / 27), np.full(28, 1 / 28)
    with pytest.raises(ValueError, match=r"shape \(28,\), but .* makes 27 bins"):
        MEASURES[name](q, reference, BINS)


def test_soft_bins_begin_with_the_borders_of_their_bins():
    """Half a bin of hue on, the votes of a colour are those of one half a bin ahead."""
    half = SoftBins(ColorBins(shift=(0.5, 0, 0)))
    for hue in (0, 7, 40):
        votes = hues(of_hue(hue), half)
        assert (votes == hues(of_hue(hue + 9), SoftBins())).all()
        assert (votes != hues(of_hue(hue), SoftBins())).any()


@pytest.mark.parametrize("measure", MEASURES.values(), ids=MEASURES)
def test_no_rounding_makes_a_squared_distance_negative(measure):
    """Of equal histograms in single precision; its root would be NaN."""
    q = np.random.default_rng(0).dirichlet(np.ones(110), 200).astype(np.float32)
    assert np.min(measure(q, q, ColorBins())) >= 0


def test_soft_bins_move_the_borders_of_two_channels_by_different_pairs():
    shifts = np.array([bins.shift for bins in SoftBins(ColorBins("rgb"))._moved])
    for a, b in ((0, 1), (0, 2), (1, 2)):
        assert (shifts[:, a] != shifts[:, b]).sum() == 4
        assert sorted(shifts[:, a]) == pytest.approx([-0.4, -0.2, 0, 0.2, 0.4])


def test_the_quadratic_distance_is_never_negative():
    """For a difference that S does not see, rounding may leave it a little below."""
    bins = ColorBins()
    unseen = np.linalg.eigh(shared(np.eye(bins.m), bins))[1][:, :10]
    off = np.random.default_rng(0).normal(size=(99, 10)) @ unseen.T
    off /= np.abs(off).sum(1, keepdims=True)
    reference = np.full(bins.m, 1 / bins.m)
    assert (quadratic(reference + off, reference, bins) >= 0).all()
