"""The linear loop, as the control package has it: its poles, and what it predicts."""

import control
import numpy as np
import pytest

from mkt.servoing.poles import closed_loop, one_feature
from mkt.servoing.self_motion import OFF, RAW, Kalman


def test_the_steady_error_is_c_over_gain_without_compensation_and_zero_with_it():
    assert closed_loop(1.5, 0.2).dcgain() == pytest.approx(1 / 1.5)
    for kalman in (RAW, Kalman(), Kalman(0.02)):
        assert closed_loop(1.5, 0.2, kalman).dcgain() == pytest.approx(0, abs=1e-9)


def radius(*args, **kwargs):
    """Of the circle that holds all poles of a closed loop."""
    return np.abs(closed_loop(*args, **kwargs).poles()).max()


def test_poles_against_gain_delay_and_a_matrix_thought_too_small():
    assert radius(1.0, 0.2) == pytest.approx(0.8)
    assert radius(9.0, 0.2) == pytest.approx(0.8)
    assert radius(11.0, 0.2) > 1
    assert radius(1.0, 0.2, RAW) == pytest.approx(0.8)
    # z^2 - z + gain dt
    assert radius(4.9, 0.2, delay=1) < 1 < radius(5.1, 0.2, delay=1)
    assert radius(1.0, 0.2, RAW, mismatch=0.4) > 1
    assert radius(1.0, 0.2, Kalman(), mismatch=0.4) < 1


@pytest.mark.parametrize("delay", [0, 1, 2])
@pytest.mark.parametrize(
    "kalman", [OFF, RAW, Kalman(0.2)], ids=["off", "raw", "kalman"]
)
def test_one_feature_is_what_the_closed_loop_predicts(kalman, delay):
    """Cases side by side, each with its own gain."""
    gains, velocity = np.array([0.5, 1.5]), 5.0 * np.repeat([0, 1, -1, 0], 12)
    found = one_feature(gains, 0.2, kalman, velocity, np.zeros((48, 2)), delay)
    for gain, errors in zip(gains, found.T, strict=True):
        loop = closed_loop(gain, 0.2, kalman, delay)
        predicted = control.forced_response(loop, inputs=velocity).outputs
        np.testing.assert_allclose(errors, predicted, atol=1e-9)


def test_the_noise_of_one_feature_moves_the_error_but_is_no_part_of_it():
    noise = np.random.default_rng(0).standard_normal((300, 1))
    still = one_feature(np.array([1.0]), 0.2, OFF, np.zeros(300), noise)[:, 0]
    # e_(k+1) = e_k - gain dt (e_k + noise_k)
    np.testing.assert_allclose(
        still[1:], 0.8 * still[:-1] - 0.2 * noise[:-1, 0], atol=1e-12
    )
    assert still[0] == 0


@pytest.mark.parametrize(
    "field, value",
    [
        ("dt", 0),
        ("dt", float("inf")),
        ("dt", "x"),
        ("delay", -1),
        ("delay", 1.5),
        ("gain", float("nan")),
        ("gain", float("inf")),
    ],
)
def test_both_forms_of_the_loop_refuse_the_same_in_words(field, value):
    given = {"gain": 1.0, "dt": 0.2, "kalman": OFF, "delay": 0} | {field: value}
    with pytest.raises(ValueError, match=f"^{field} is {value!r}; .* must be"):
        closed_loop(**given)
    given["gain"] = np.array([1.0, given["gain"]])  # one of several is enough
    with pytest.raises(ValueError, match=f"^{field} is .*; .* must be"):
        one_feature(**given, velocity=np.zeros(3), noise=np.zeros((3, 2)))


@pytest.mark.parametrize("mismatch", [0, -0.4, float("nan"), float("inf"), "x"])
def test_a_matrix_cannot_be_thought_of_another_sign(mismatch):
    with pytest.raises(
        ValueError, match=f"^mismatch is {mismatch!r}; it must be posit"
    ):
        closed_loop(1.0, 0.2, mismatch=mismatch)
