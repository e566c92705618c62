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
    of_an_array = twist(e, L, lambda e: np.where(e.any(), gain(e), 0))
    np.testing.assert_array_equal(of_an_array, twist(e, L, gain(e)))
    # Of several components the largest counts.
    assert gain(np.array([0.1, -0.3, 0.3, 0.2])) == gain(np.array([0.3, 0, 0, 0]))


FLAT = np.diag([1.0, 1, 1, 0]) @ np.eye(4, 6)


@pytest.mark.parametrize(
    "problem, call",
    [
        ("singular", lambda: twist(np.ones(4), np.ones((4, 6)), 1.0)),
        ("singular", lambda: twist(np.ones(4), FLAT, 1.0)),
        ("not finite", lambda: twist(np.full(4, np.nan), L, 1.0)),
        ("the error .* not finite", lambda: twist(np.full(4, np.nan), L, np.mean)),
        ("interaction matrix .* finite", lambda: twist(np.ones(4), np.nan * L, 1.0)),
        ("gain is None", lambda: twist(np.ones(4), L, lambda e: None)),
        ("gain is .*1", lambda: twist(np.ones(4), L, lambda e: np.ones(4))),
        ("gain is nan", lambda: twist(np.ones(4), L, lambda e: np.nan)),
        ("gain is inf", lambda: twist(np.ones(4), L, np.inf)),
        ("dof", lambda: twist(np.ones(4), np.eye(4, 6), 1.0, dof=5)),
        (r"dof is array", lambda: twist(np.ones(4), L, 1.0, dof=np.array([6, 4]))),
        (r"dof is \[6\]", lambda: twist(np.ones(4), L, 1.0, dof=[6])),
        ("near > far", lambda: AdaptiveGain(0.5, 1.0)),
        (r"e has the shape \(4, 1\); give", lambda: twist(np.ones((4, 1)), L, 1.0)),
        (r"de_dt .* \(3,\); give \(4,\)", lambda: twist([1] * 4, L, 1.0, [0] * 3)),
        (r"de_dt .* \(4, 1\)", lambda: twist([1] * 4, L, 1.0, np.ones((4, 1)))),
    ],
)
def test_bad_input_is_named(problem, call):
    with pytest.raises(ValueError, match=problem):
        call()


@pytest.mark.parametrize(
    "n, columns, dof, said",
    [
        (
            8,
            6,
            6,
            "L has 8 rows, .* more than the 6 axes; leave features out",
        ),
        (
            5,
            6,
            4,
            "L has 5 rows, .* more than the 4 axes; leave features out",
        ),
        (4, 4, 6, r"L has the shape \(4, 4\); .* 4 features it is \(4, 6\)"),
        (4, 4, 4, r"L has the shape \(4, 4\); .* 4 features it is \(4, 6\)"),
    ],
)
def test_an_interaction_matrix_that_does_not_fit_is_told_how(n, columns, dof, said):
    e, L = np.ones(n), np.random.default_rng(0).standard_normal((n, columns))
    with pytest.raises(ValueError, match=said):
        twist(e, L, 1.0, dof=dof)


@pytest.mark.parametrize("n, dof", [(2, 6), (2, 4), (6, 6), (1, 4)])
def test_fewer_features_or_as_many_as_axes_are_controlled_too(n, dof):
    e, J = np.ones(n), np.random.default_rng(0).standard_normal((n, 6))
    np.testing.assert_allclose(J @ twist(e, J, 2.0, dof=dof), -2 * e)


@pytest.mark.parametrize(
    "near, far, slope, said",
    [
        (1.0, 1.0, 4.0, "near > far"),
        (0.5, 1.0, 4.0, "near > far"),
        (np.inf, 1.0, 4.0, "near is inf"),
        (2.0, 0.0, 4.0, "far is 0"),
        (2.0, 0.5, 0.0, "slope is 0"),
        (2.0, 0.5, "4", "slope is '4'; it must be"),
    ],
)
def test_a_gain_that_does_not_fall_is_refused(near, far, slope, said):
    with pytest.raises(ValueError, match=said):
        AdaptiveGain(near, far, slope)


def test_a_gain_may_fall_slowly():
    gain, e = AdaptiveGain(2.0, 0.5, 0.25), np.array([0, 1e-6, 0, 0])
    assert (gain(0 * e) - gain(e)) / 1e-6 == pytest.approx(0.25, rel=1e-3)


def test_lists_are_numbers_too():
    e, de_dt = [0.1, -0.2, 0.05, 0.3], [0.1, 0, 0, 0]
    arrays = (np.array(e), L, 2.0, np.array(de_dt))
    np.testing.assert_array_equal(twist(e, L.tolist(), 2.0, de_dt), twist(*arrays))


def test_a_target_stands_still_where_nothing_is_said_of_it():
    e = np.array([0.1, -0.2, 0.05, 0.3])
    np.testing.assert_array_equal(twist(e, L, 2.0), twist(e, L, 2.0, np.zeros(4)))


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("share", [1e-3, 0.9])
def test_a_small_part_that_cannot_be_controlled_is_refused_at_any_scale(size, share):
    """Two features with the same row of L that are to change differently."""
    alike = np.eye(4, 6)
    alike[3] = alike[2]
    e = size * np.array([1.0, 0, 0.5, 0.5 + share])
    with pytest.raises(ValueError, match="singular"):
        twist(e, alike, 1.0)
    assert np.isfinite(twist(e, np.eye(4, 6), 1.0)).all()


def test_rows_so_alike_that_rounding_spoils_the_twist_are_refused():
    """They differ by a millionth, and L v is off by a twentieth of a thousandth."""
    alike = np.eye(4, 6)
    alike[3, 2:4] = 1, 1e-6
    with pytest.raises(ValueError, match="singular"):
        twist(np.array([1.0, 0, 0.5, 1.4]), alike, 1.0)
