"""Features, interaction matrices, the control law and the filter of the target's own motion, against independent numbers."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from mkt.kalman import OFF, RAW, Kalman, closed_loop, drift
from mkt.servo import AdaptiveGain, Camera, control, error, features, interaction_matrix, interaction_matrix_tilted, moments

CASES = json.loads((Path(__file__).parent / "interaction_matrices.json").read_text())["cases"]
UNIT = Camera(1.0, (1, 1))  # its pixels are normalised coordinates
GOLDEN = np.array([.15 / .8, .1 / .8, -.7, .1 / .8, .06 / .8])


def region_of(case):
    x, y, z = case["centre"]
    return np.array([x / z, y / z, np.radians(case["turn_deg"]), case["length"] / z / 2, case["width"] / z / 2])


@pytest.mark.parametrize("case", CASES, ids=lambda c: str(c["id"]))
def test_matrices_equal_those_of_visp(case):
    corners, L = np.reshape(case["corners"], (4, 2)), np.reshape(case["matrix"], (4, 6))
    np.testing.assert_allclose(moments(corners), case["features"], rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(interaction_matrix_tilted(corners, case["plane"]), L, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("case", [c for c in CASES if c["parallel"]], ids=lambda c: str(c["id"]))
def test_the_short_formula_holds_where_the_plane_is_parallel(case):
    L = interaction_matrix(region_of(case), UNIT, case["length"] * case["width"], "alpha")
    np.testing.assert_allclose(L, np.reshape(case["matrix"], (4, 6)), rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(features(region_of(case), UNIT, "alpha"), case["features"], rtol=1e-7, atol=1e-9)


def test_the_golden_matrix():
    s, L = features(GOLDEN, UNIT), interaction_matrix(GOLDEN, UNIT, .2 * .12, "alpha")
    np.testing.assert_allclose(s, [.9682, .6455, 5.1640, -.7], atol=5e-5)
    np.testing.assert_allclose(L, [[-6.455, 0, 0, -.0944, -5.1522, .6455], [0, -6.455, 0, 5.1909, .0944, -.9682],
                                   [0, 0, -6.455, -.9682, 1.4524, 0], [0, 0, 0, -.1908, -.2814, -1]], atol=5e-5)


def rectangle(rng, tilt):
    """Corners (4, 3) [m] of a rectangle before the camera, and its plane (A, B, C)."""
    length, width = rng.uniform(0.1, 0.3), rng.uniform(0.04, 0.09)
    flat = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * [length / 2, width / 2, 0]
    turn = expm(np.cross(np.eye(3), [0, 0, rng.uniform(-1.2, 1.2)]))
    tilted = expm(np.cross(np.eye(3), tilt * np.append(rng.standard_normal(2), 0)))
    corners = flat @ turn.T @ tilted.T + rng.uniform([-0.2, -0.2, 0.6], [0.2, 0.2, 1.2])
    return corners, np.linalg.solve(corners[:3], np.ones(3)) if tilt else (0, 0, 1 / corners[0, 2])


def seen(corners, twist, t):
    """The image (4, 2) of corners (4, 3) after the camera moved with a twist (6,) for a time t."""
    generator = np.zeros((4, 4))
    generator[:3, :3], generator[:3, 3] = np.cross(np.eye(3), twist[3:]), twist[:3]
    x = (np.linalg.inv(expm(generator * t)) @ np.column_stack([corners, np.ones(4)]).T)[:3]
    return (x[:2] / x[2]).T


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_matrices_are_the_derivatives_of_projected_rectangles(seed, tilt):
    corners, plane = rectangle(np.random.default_rng(seed), tilt)
    step = 1e-5
    difference = [(moments(seen(corners, v, step)) - moments(seen(corners, v, -step))) / (2 * step) for v in np.eye(6)]
    np.testing.assert_allclose(interaction_matrix_tilted(seen(corners, np.zeros(6), 0), plane), np.transpose(difference), rtol=1e-6, atol=1e-6)


def test_errors_are_wrapped():
    close = error([[1, 2, 3, np.pi - 0.1]], [1, 2, 3, -np.pi + 0.1])
    np.testing.assert_allclose(close, [[0, 0, 0, -0.2]], atol=1e-12)
    np.testing.assert_allclose(error([0, 0, 0, np.pi / 2 - 0.1], [0, 0, 0, -np.pi / 2 + 0.1], "alpha"), [0, 0, 0, -0.2], atol=1e-12)


def test_alpha_is_the_longer_axis():
    camera, region = Camera(), np.array([100.0, 80.0, 0.3, 20.0, 40.0])
    same = np.array([100.0, 80.0, 0.3 - np.pi / 2, 40.0, 20.0])
    np.testing.assert_allclose(features(region, camera, "alpha"), features(same, camera, "alpha"))
    np.testing.assert_allclose(interaction_matrix(region, camera, 0.01, "alpha"), interaction_matrix(same, camera, 0.01, "alpha"), atol=1e-12)
    assert features(region, camera, "alpha")[3] == pytest.approx(0.3 - np.pi / 2)
    assert features(np.array([region, same]), camera).shape == (2, 4)


@pytest.mark.parametrize("dof", [6, 4])
@pytest.mark.parametrize("seed", range(3))
def test_the_law_asks_for_an_exponential_decay_by_the_least_motion(dof, seed):
    rng = np.random.default_rng(seed)
    e, de, L = rng.standard_normal(4), rng.standard_normal(4), interaction_matrix(GOLDEN, UNIT, 0.024)
    v = control(e, L, 1.5, de, dof)
    np.testing.assert_allclose(L @ v + de, -1.5 * e, atol=1e-12)
    if dof == 6:
        np.testing.assert_allclose(v, -np.linalg.pinv(L) @ (1.5 * e + de), atol=1e-12)
    else:
        assert (v[[3, 4]] == 0).all()


def test_the_adaptive_gain_falls_from_near_to_far():
    gain, e = AdaptiveGain(2.0, 0.5, 4.0), np.array([0, -1e-6, 0, 0])
    assert gain(0 * e) == 2.0 and gain(1e7 * e) == pytest.approx(0.5)
    assert (gain(0 * e) - gain(e)) / 1e-6 == pytest.approx(4.0, rel=1e-4)
    L = interaction_matrix(GOLDEN, UNIT, 0.024)
    np.testing.assert_array_equal(control(e, L, gain), control(e, L, gain(e)))


@pytest.mark.parametrize("problem, call", [
    ("no area", lambda: features([0, 0, 0, 1, 0], UNIT)),
    ("no area", lambda: interaction_matrix([0, 0, 0, 1, 0], UNIT, 0.01)),
    ("no area", lambda: moments(np.zeros((4, 2)))),
    ("no area", lambda: interaction_matrix_tilted(np.zeros((4, 2)), (0, 0, 1))),
    ("surface", lambda: interaction_matrix(GOLDEN, UNIT, 0.0)),
    ("square", lambda: interaction_matrix([0, 0, 0, 1, 1], UNIT, 0.01, "alpha")),
    ("focal", lambda: Camera(0.0)),
    ("singular", lambda: control(np.ones(4), np.ones((4, 6)), 1.0)),
    ("singular", lambda: control(np.ones(4), np.diag([1.0, 1, 1, 0]) @ np.eye(4, 6), 1.0)),
    ("dof", lambda: control(np.ones(4), np.eye(4, 6), 1.0, dof=5)),
    ("near > far", lambda: AdaptiveGain(0.5, 1.0)),
    ("dt", lambda: drift(np.zeros(4), np.zeros(4), np.eye(4, 6), np.zeros(6), 0.0)),
    ("dt", lambda: closed_loop(1.0, -0.2)),
    ("ratio", lambda: Kalman(-1.0)),
    ("rho", lambda: Kalman(1.0, 1.0)),
])
def test_bad_input_is_named(problem, call):
    with pytest.raises(ValueError, match=problem):
        call()


def test_the_targets_own_motion_is_what_the_camera_does_not_explain():
    rng = np.random.default_rng(0)
    L, v, own, before = interaction_matrix(GOLDEN, UNIT, 0.024), rng.standard_normal(6), rng.standard_normal(4), rng.standard_normal(4)
    np.testing.assert_allclose(drift(before + 0.2 * (L @ v + own), before, L, v, 0.2), own, atol=1e-12)


@pytest.mark.parametrize("ratio", [2e-4, 0.02, 0.2, 1.0, 50.0])
def test_the_steady_gain_is_where_the_recursion_ends(ratio):
    filter = Kalman(ratio)
    F, P = filter.transition, np.diag([1.0, ratio])
    for _ in range(2000):
        P = F @ P @ F.T + np.diag([0, ratio])
        K = P[:, 0] / (P[0, 0] + 1)
        P = P - np.outer(K, P[0])
    np.testing.assert_allclose(filter.gain, K, rtol=1e-6)


def steps(filter, z):
    """Estimates (T, n) from measurements (T, n)."""
    state, estimates = np.zeros((2, z.shape[1])), []
    for row in z:
        state = filter.step(state, row)
        estimates.append(state[0])
    return np.array(estimates)


@pytest.mark.parametrize("ratio, frames", [(2e-4, 50), (0.02, 5), (0.2, 2), (np.inf, 1)])
def test_frames_until_a_step_is_believed(ratio, frames):
    """63 % of a sudden velocity; what suits 60 Hz needs ten seconds at 5 frames a second."""
    response = steps(Kalman(ratio), np.ones((200, 1)))[:, 0]
    assert abs(1 + np.argmax(response > 1 - np.exp(-1)) - frames) <= 0.1 * frames + 0.5


@pytest.mark.parametrize("ratio", [0.05, 1.0])
def test_no_other_ratio_filters_better_than_the_true_one(ratio):
    rng = np.random.default_rng(1)
    truth, own = np.zeros((4000, 20)), np.zeros(20)
    for k in range(1, len(truth)):
        truth[k] = truth[k - 1] + own
        own = 0.3 * own + np.sqrt(ratio) * rng.standard_normal(20)
    z = truth + rng.standard_normal(truth.shape)
    best, *others = [np.var(steps(f, z) - truth) for f in (Kalman(ratio), Kalman(ratio / 5), Kalman(5 * ratio), RAW)]
    assert best < 0.99 * min(others)


def test_ends_of_the_ratio():
    z = np.random.default_rng(0).standard_normal((9, 4))
    assert (steps(OFF, z) == 0).all()
    np.testing.assert_allclose(steps(RAW, z), z, atol=1e-12)


def test_the_steady_error_is_c_over_gain_without_compensation_and_zero_with_it():
    assert closed_loop(1.5, 0.2).dcgain() == pytest.approx(1 / 1.5)
    for filter in (RAW, Kalman(), Kalman(0.02)):
        assert closed_loop(1.5, 0.2, filter).dcgain() == pytest.approx(0, abs=1e-9)


def radius(*args, **kwargs):
    return np.abs(closed_loop(*args, **kwargs).poles()).max()


def test_poles_against_gain_delay_and_a_matrix_thought_too_small():
    assert radius(1.0, 0.2) == pytest.approx(0.8) and radius(9.0, 0.2) == pytest.approx(0.8) and radius(11.0, 0.2) > 1
    assert radius(1.0, 0.2, RAW) == pytest.approx(0.8)
    assert radius(4.9, 0.2, delay=1) < 1 < radius(5.1, 0.2, delay=1)  # z^2 - z + gain dt
    assert radius(1.0, 0.2, RAW, mismatch=0.4) > 1 > radius(1.0, 0.2, Kalman(), mismatch=0.4)
