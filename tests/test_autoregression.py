"""A learnt motion model: it finds again what made the tracks."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mkt.autoregression import AutoRegression, changes, learnt
from mkt.particles import Motion, Particles

START = [160.0, 120.0, 0.2, 30.0, 20.0]


def simulated(model, length, seed):
    """A track (length, 5) that the model itself made."""
    rng = np.random.default_rng(seed)
    cloud, rows = model.scatter(START, 1, rng), []
    for _ in range(length):
        rows.append(cloud.regions[0])
        cloud = model.predict(cloud, rng)
    return np.array(rows)


@pytest.mark.slow
@given(st.floats(0.2, 0.95), st.floats(0.005, 0.05), st.integers(0, 100))
def test_what_made_the_tracks_is_learnt(phi, sigma, seed):
    made = AutoRegression((phi,) * 3, (sigma,) * 3, (sigma,) * 3)
    found = learnt(simulated(made, 400, seed + k) for k in range(3))
    assert np.allclose(found.phi, phi, atol=0.15)
    assert np.allclose(found.sigma, sigma, rtol=0.15)


def test_changes_are_in_units_of_the_target():
    """A track in another image, twice as large, has the same changes."""
    track = simulated(AutoRegression((0.9,) * 3, (0.02,) * 3, (0.02,) * 3), 50, 0)
    larger = track * [2, 2, 1, 2, 2]
    assert np.allclose(changes(track), changes(larger))


def test_a_step_is_counted_in_the_size_before_it():
    """As `predict` takes it: of a target that doubles its size, not in the new one."""
    track = np.array([[0, 0, 0, 20, 5], [10, -5, 0.3, 40, 10.0]])
    np.testing.assert_allclose(changes(track), [[1, -0.5, 0.3, np.log(2)]])


def test_a_prediction_adds_the_change_that_it_keeps():
    model = AutoRegression((0.5, 1.0, 0.5), (0, 0, 0), (0, 0, 0))
    before = Particles(np.array([START]), np.array([[0.2, -0.4, 0.3, 0.1]]))
    region = model.predict(before, np.random.default_rng(0)).regions[0]
    unit = np.sqrt(600)
    sides = np.exp(0.05) * np.array([30, 20])
    assert np.allclose(region, [160 + 0.1 * unit, 120 - 0.2 * unit, 0.5, *sides])


def test_place_turn_and_size_are_learnt_each_from_its_own_changes():
    made = AutoRegression((0.9, 0.2, 0.6), (0.01, 0.04, 0.02), (0.02,) * 3)
    found = learnt(simulated(made, 1500, k) for k in range(4))
    assert np.allclose(found.phi, made.phi, atol=0.05)
    assert np.allclose(found.sigma, made.sigma, rtol=0.05)
    expected = np.array(made.sigma) / np.sqrt(1 - np.array(made.phi) ** 2)
    assert np.allclose(found.spread, expected, rtol=0.1)


@pytest.mark.parametrize("field", ["phi", "sigma", "spread"])
def test_a_model_has_three_numbers_in_each_field_and_no_negative_deviation(field):
    model = AutoRegression((-1, 1, 1), (1, 1, 1), (1, 1, 1))
    wrong = [(1, 1), 1.0, (1, 1, np.nan)] + [(1, -1, 1)] * (field != "phi")
    for value in wrong:
        with pytest.raises(ValueError, match=rf"^{field} is .* three finite numbers"):
            replace(model, **{field: value})


def test_changes_never_grow_without_end():
    x = 1.1 ** np.arange(40.0)
    track = np.column_stack([x, x, 0 * x, 0 * x + 10, 0 * x + 10])
    model = learnt([track])
    assert model.phi[0] == 1 and max(model.phi) <= 1
    swung = np.cumsum((-2.0) ** np.arange(10))
    back = np.column_stack([swung, swung, 0 * swung, 0 * swung + 10, 0 * swung + 10])
    assert learnt([back]).phi[0] == -1


@pytest.mark.parametrize("tracks", [[], [np.ones((2, 5))]])
def test_too_little_to_learn_from_is_said(tracks):
    with pytest.raises(ValueError, match="at least one track, each of at least three"):
        learnt(tracks)


def test_one_track_alone_is_put_into_a_list():
    with pytest.raises(ValueError, match=r"the shape \(5,\); give a list of tracks"):
        learnt(np.ones((9, 5)))


@pytest.mark.parametrize("loosen", [-1.0, np.nan, np.inf])
def test_noise_is_not_loosened_by_what_is_no_factor(loosen):
    with pytest.raises(ValueError, match="loosen is"):
        learnt([np.ones((9, 5))], loosen)


@pytest.mark.parametrize("hx", [np.nan, np.inf, 0.0, -3.0])
def test_a_track_with_a_region_that_cannot_be_is_refused(hx):
    track = np.column_stack([*[np.arange(9.0)] * 3, np.full((9, 2), 10.0)])
    assert learnt([track.tolist()]) == learnt([track])
    track[4, 3] = hx
    with pytest.raises(ValueError, match="leave them out"):
        learnt([track])


def test_loosening_is_a_factor_on_the_noise_alone():
    track = simulated(AutoRegression((0.9,) * 3, (0.02,) * 3, (0.02,) * 3), 80, 0)
    once, twice = learnt([track]), learnt([track], loosen=2)
    assert once.phi == twice.phi and once.spread == twice.spread
    assert np.allclose(2 * np.array(once.sigma), twice.sigma, rtol=1e-3)


@pytest.mark.parametrize(
    "region, said",
    [
        ([0, 0, 0, -1, 1], "has no area"),
        ([0, 0, 0, 1, np.nan], "is not finite"),
        ([START], "one region .* is needed"),
        ([1, 2, 3, 4], r"not \(4,\)"),
    ],
)
def test_nothing_is_scattered_round_what_is_no_region(region, said):
    model = AutoRegression((0.9,) * 3, (0.02,) * 3, (0.03,) * 3)
    with pytest.raises(ValueError, match=said):
        model.scatter(region, 3, np.random.default_rng(0))


@pytest.mark.parametrize(
    "model", [Motion(), AutoRegression((0.9,) * 3, (0.02,) * 3, (0.03,) * 3)]
)
def test_scatter_is_centred_and_the_same_for_a_seed(model):
    clouds = [model.scatter(START, 4000, np.random.default_rng(3)) for _ in range(2)]
    assert np.array_equal(clouds[0].regions, clouds[1].regions)
    assert np.allclose(clouds[0].regions[:, :2].mean(0), START[:2], atol=0.5)
