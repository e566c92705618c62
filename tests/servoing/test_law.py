"""The control law and its adaptive gain."""

import numpy as np
import pytest

from mkt.servoing.features import Camera, interaction_matrix
from mkt.servoing.law import AdaptiveGain, twist

UNIT = Camera(1.0, (1, 1))  # its pixels are normalised coordinates
REGION = np.array([0.15 / 0.8, 0.1 / 0.8, -0.7, 0.1 / 0.8, 0.06 / 0.8])
L = interaction_matrix(REGION, UNIT, 0.024)


@pytest.mark.parametrize("dof", [6, 4])
@pytest.mark.parametrize("seed", range(3))
def test_the_law_asks_for_an_exponential_decay_by_the_least_motion(dof, seed):
    e, de_dt = np.random.default_rng(seed).standard_normal((2, 4))
    v = twist(e, L, 1.5, de_dt, dof)
    np.testing.assert_allclose(L @ v + de_dt, -1.5 * e, atol=1e-12)
    if dof == 6:
        least = -np.linalg.pinv(L) @ (1.5 * e + de_dt)
        np.testing.assert_allclose(v, least, atol=1e-12)
    else:
        assert (v[[3, 4]] == 0).all()


def test_the_adaptive_gain_falls_from_near_to_far():
    gain, e = AdaptiveGain(2.0, 0.5, 4.0), np.array([0, -1e-6, 0, 0])
    assert gain(0 * e) == 2.0
    assert gain(1e7 * e) == pytest.approx(0.5)
    assert (gain(0 * e) - gain(e)) / 1e-6 == pytest.approx(4.0, rel=1e-4)
    np.testing.assert_array_equal(twist(e, L, gain), twist(e, L, gain(e)))


FLAT = np.diag([1.0, 1, 1, 0]) @ np.eye(4, 6)


@pytest.mark.parametrize(
    "problem, call",
    [
        ("singular", lambda: twist(np.ones(4), np.ones((4, 6)), 1.0)),
        ("singular", lambda: twist(np.ones(4), FLAT, 1.0)),
        ("dof", lambda: twist(np.ones(4), np.eye(4, 6), 1.0, dof=5)),
        ("near > far", lambda: AdaptiveGain(0.5, 1.0)),
    ],
)
def test_bad_input_is_named(problem, call):
    with pytest.raises(ValueError, match=problem):
        call()
