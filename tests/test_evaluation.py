"""Overlap against an independent count of points, and errors."""

import numpy as np
import pytest
from hypothesis import given, settings

from mkt.evaluation import errors, overlap
from mkt.regions import corners, from_box, unwarp
from tests.strategies import regions


@settings(max_examples=100)
@given(regions(), regions())
def test_overlap_equals_counting_points(a, b):
    low = np.min([corners(a).min(0), corners(b).min(0)], 0)
    high = np.max([corners(a).max(0), corners(b).max(0)], 0)
    grid = low + (high - low) * (np.indices((300, 300)).reshape(2, -1).T + 0.5) / 300
    in_a, in_b = ((np.abs(unwarp(r, grid)) <= 1).all(-1) for r in (a, b))
    if in_a.sum() > 500 and in_b.sum() > 500:  # else the grid is too coarse to tell
        assert overlap(a, b) == pytest.approx((in_a & in_b).sum() / (in_a | in_b).sum(), abs=0.05)


@given(regions())
def test_overlap_with_itself_is_one(a):
    assert overlap(a, a)== pytest.approx(1, abs=1e-4)


def test_disjoint_neighbours_do_not_overlap():
    assert overlap(from_box([0, 0, 0.1, 0.1]), from_box([0.15, 0, 0.1, 0.1]))== 0


def test_hidden_truth_gives_nan():
    truth = np.full((2, 5), np.nan)
    assert np.isnan(overlap(np.ones((2, 5)), truth)).all()


def test_upright_ignores_the_angle():
    turned = [10, 10, np.pi / 2, 4, 8]
    assert overlap(turned, [10, 10, 0, 8, 4], upright=True)== pytest.approx(1)
    assert overlap(turned, [10, 10, 0, 4, 8]) < 0.5


def test_errors_wrap_and_have_signs():
    e = errors([3, 4, 3.1, 20, 20], [0, 0, -3.1, 10, 10])
    assert e.position == pytest.approx(5)
    assert e.orientation == pytest.approx(2 * np.pi - 6.2)
    assert e.scale == pytest.approx(np.log(2))
