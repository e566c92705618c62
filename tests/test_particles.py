"""Resampling is unbiased for every particle, motion is in units of the target, weights never become NaN."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mkt.particles import SCHEMES, Motion, Particles, effective_sample_size, mean_region, normalised

weights = st.lists(st.floats(0, 1), min_size=1, max_size=40).filter(lambda w: sum(w) > 1e-3).map(lambda w: np.array(w) / sum(w))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_every_particle_is_drawn_as_often_as_it_weighs(scheme):
    """Including the first one, which the printed systematic listing never draws."""
    w = np.array([0.168, 0.3, 0.002, 0.0, 0.25, 0.1, 0.18])
    rng = np.random.default_rng(0)
    draws = np.concatenate([SCHEMES[scheme](w, rng) for _ in range(4000)])
    frequency = np.bincount(draws, minlength=7) / len(draws)
    assert np.allclose(frequency, w, atol=4 * np.sqrt(0.25 / len(draws)))
    assert frequency[3] == 0


@given(weights, st.integers(0, 2**32 - 1))
def test_schemes_return_as_many_ancestors_as_particles(w, seed):
    for scheme in SCHEMES.values():
        ancestors = scheme(w, np.random.default_rng(seed))
        assert len(ancestors) == len(w) and (w[ancestors] > 0).all()


@given(weights, st.integers(0, 2**32 - 1))
def test_low_variance_schemes_are_within_one_of_the_expectation(w, seed):
    counts = np.bincount(SCHEMES["systematic"](w, np.random.default_rng(seed)), minlength=len(w))
    assert (np.abs(counts - len(w) * w) < 1 + 1e-6).all()
    counts = np.bincount(SCHEMES["residual"](w, np.random.default_rng(seed)), minlength=len(w))
    assert (counts >= np.floor(len(w) * w - 1e-6)).all()


@given(weights)
def test_effective_sample_size_is_between_one_and_n(w):
    assert 1 - 1e-9 <= effective_sample_size(w) <= len(w) + 1e-9
    assert effective_sample_size(np.full(8, 1 / 8)) == pytest.approx(8)


@given(st.lists(st.floats(-1e5, 0) | st.just(-np.inf), min_size=1, max_size=20))
def test_weights_are_a_distribution_whatever_the_likelihoods(log_weights):
    w = normalised(log_weights)
    assert np.isfinite(w).all() and w.sum() == pytest.approx(1)


def test_the_mean_angle_is_circular():
    regions = np.array([[0, 0, np.pi - 0.1, 1, 1], [0, 0, -np.pi + 0.1, 1, 4]])
    assert np.allclose(mean_region(regions, np.array([0.5, 0.5])), [0, 0, np.pi, 1, 2])


def test_motion_scales_with_the_target():
    small, large = np.array([50, 50, 0, 10, 5.0]), np.array([50, 50, 0, 40, 20.0])
    a, b = (Motion().scatter(r, 2000, np.random.default_rng(1)) for r in (small, large))
    assert np.allclose(4 * (a.regions[:, :2] - 50), b.regions[:, :2] - 50)
    assert np.allclose(a.regions[:, 2], b.regions[:, 2])


def test_constant_velocity_moves_and_a_random_walk_does_not():
    particles = Particles(np.tile([0.0, 0, 0, 10, 10], (4000, 1)), np.tile([5.0, 0], (4000, 1)))
    moving = Motion(damping=1.0).predict(particles, np.random.default_rng(0))
    walking = Motion(damping=0.0, velocity=0.0).predict(particles, np.random.default_rng(0))
    assert moving.regions[:, 0].mean() == pytest.approx(5, abs=0.1)
    assert walking.regions[:, 0].mean() == pytest.approx(0, abs=0.1)
