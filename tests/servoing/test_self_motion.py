"""The target's own motion: its measurement, its filter, and the loop that uses both."""

import numpy as np
import pytest

from mkt.servoing.features import Camera, interaction_matrix
from mkt.servoing.poles import closed_loop
from mkt.servoing.self_motion import (
    OFF,
    RAW,
    Kalman,
    measured_self_motion,
)

UNIT = Camera(1.0, (1, 1))  # its pixels are normalised coordinates
REGION = np.array([0.15 / 0.8, 0.1 / 0.8, -0.7, 0.1 / 0.8, 0.06 / 0.8])
L = interaction_matrix(REGION, UNIT, 0.024)


@pytest.mark.parametrize(
    "problem, call",
    [
        (
            "dt",
            lambda: measured_self_motion(
                np.zeros(4), np.zeros(4), np.eye(4, 6), np.zeros(6), 0.0
            ),
        ),
        ("dt", lambda: closed_loop(1.0, -0.2)),
        ("mismatch", lambda: closed_loop(1.0, 0.2, mismatch=0.0)),
        ("gain", lambda: closed_loop(float("nan"), 0.2)),
        ("delay", lambda: closed_loop(1.0, 0.2, delay=-1)),
        ("delay is 1.5; it must be a whole", lambda: closed_loop(1.0, 0.2, delay=1.5)),
        ("ratio", lambda: Kalman(-1.0)),
        ("take 0, infinity, or", lambda: Kalman(1e300)),
        ("take 0, infinity, or", lambda: Kalman(1e-300)),
        ("rho", lambda: Kalman(1.0, 1.0)),
        ("ratio is 'a'", lambda: Kalman("a")),
    ],
)
def test_bad_input_is_named(problem, call):
    with pytest.raises(ValueError, match=problem):
        call()


def test_the_targets_own_motion_is_what_the_camera_does_not_explain():
    rng = np.random.default_rng(0)
    v = rng.standard_normal(6)
    own, before = rng.standard_normal((2, 4))
    after = before + 0.2 * (L @ v + own)
    measured = measured_self_motion(after, before, L, v, 0.2)
    np.testing.assert_allclose(measured, own, atol=1e-12)


@pytest.mark.parametrize("ratio", [2e-4, 0.02, 0.2, 1.0, 50.0])
def test_the_steady_gain_is_where_the_recursion_ends(ratio):
    kalman = Kalman(ratio)
    F, P = kalman.transition, np.diag([1.0, ratio])
    for _ in range(2000):
        P = F @ P @ F.T + np.diag([0, ratio])
        K = P[:, 0] / (P[0, 0] + 1)
        P = P - np.outer(K, P[0])
    np.testing.assert_allclose(kalman.gain, K, rtol=1e-6)


def steps(kalman, z):
    """Estimates (T, n) from measurements (T, n)."""
    state, estimates = np.zeros((2, z.shape[1])), []
    for row in z:
        state = kalman.step(state, row)
        estimates.append(state[0])
    return np.array(estimates)


@pytest.mark.parametrize(
    "ratio, frames", [(2e-4, 50), (0.02, 5), (0.2, 2), (np.inf, 1)]
)
def test_frames_until_a_step_is_believed(ratio, frames):
    """63 % of a sudden velocity; what suits 60 Hz needs ten seconds at 5 Hz."""
    response = steps(Kalman(ratio), np.ones((200, 1)))[:, 0]
    believed = 1 + np.argmax(response > 1 - np.exp(-1))
    assert abs(believed - frames) <= 0.1 * frames + 0.5


@pytest.mark.parametrize("ratio", [0.05, 1.0])
def test_no_other_ratio_filters_better_than_the_true_one(ratio):
    rng = np.random.default_rng(1)
    truth, own = np.zeros((4000, 20)), np.zeros(20)
    for k in range(1, len(truth)):
        truth[k] = truth[k - 1] + own
        own = 0.3 * own + np.sqrt(ratio) * rng.standard_normal(20)
    z = truth + rng.standard_normal(truth.shape)
    filters = Kalman(ratio), Kalman(ratio / 5), Kalman(5 * ratio), RAW
    best, *others = [np.var(steps(kalman, z) - truth) for kalman in filters]
    assert best < 0.99 * min(others)


def test_ends_of_the_ratio():
    z = np.random.default_rng(0).standard_normal((9, 4))
    assert (steps(OFF, z) == 0).all()
    np.testing.assert_allclose(steps(RAW, z), z, atol=1e-12)
    np.testing.assert_allclose(RAW.gain, Kalman(1e9).gain, rtol=1e-6)
