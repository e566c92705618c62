"""Paths that layers and cameras go."""

import numpy as np
import pytest

from mkt.scenes.paths import roaming, spline


@pytest.mark.parametrize("seed", range(10))
def test_a_walk_starts_upright_and_in_its_own_size(seed):
    start = spline(roaming(np.random.default_rng(seed)))(0)
    assert start[2:] == pytest.approx([0, 1])


@pytest.mark.parametrize("seed", range(10))
def test_a_walk_starts_from_rest(seed):
    x, y = spline(roaming(np.random.default_rng(seed)))([-0.25, 0, 0.25])[:, :2].T
    assert max(np.ptp(x), np.ptp(y)) < 0.3
