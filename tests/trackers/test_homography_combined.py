"""A filter before the optimiser, on planes in space: its particles and its looks."""

import numpy as np
import pytest

from mkt.homographies import moved
from mkt.scenes.cards import card
from mkt.trackers.homography import PlaneSSD
from mkt.trackers.homography_combined import PlaneCombined


def test_a_combination_on_planes_reports_its_particles_and_all_looks():
    clip = card("base", 2).sequence()
    tracker, rng = PlaneCombined(n=30), np.random.default_rng(0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    _, info = tracker.step(state, clip.frames[1], rng)
    assert 1 <= info["n_eff"] <= 30 and info["steps"] >= 2
    assert info["particles"].shape == (30, 5)
    assert info["weights"].sum() == pytest.approx(1)
    off = np.abs(info["weights"] @ info["particles"][:, :2] - info["region"][:2])
    assert off.max() < 3 * np.sqrt(np.diag(info["covariance"])[:2].max())
    assert not info["lost"] and np.asarray(info["lost"]).dtype == bool
    assert info["evaluations"] == 30 + 1 + info["steps"]
    hidden = np.full_like(clip.frames[1], 128)
    _, info = tracker.step(state, hidden, rng)
    assert info["lost"] and info["steps"] == 0 and info["evaluations"] == 31


def test_particles_of_a_plane_lie_round_the_new_estimate():
    clip, rng = card("base", 2).sequence(), np.random.default_rng(0)
    tracker = PlaneCombined(n=300, spread=(0.4, 0.01))
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    beside = moved(
        state.ssd.homography, np.array([0.3, 0]), state.target.kernels.half_sides
    )
    state = state._replace(ssd=state.ssd._replace(homography=beside))
    after, _ = tracker.step(state, clip.frames[0], rng)
    assert abs(after.offsets[:, 0].mean()) < 0.1


@pytest.mark.parametrize("length", [1, 8])
def test_a_combination_on_planes_scatters_over_one_to_eight_parameters(length):
    tracker = PlaneCombined(n=5, spread=(0.1,) * length)
    clip = card("base", 2).sequence()
    state = tracker.init(clip.frames[0], clip.truth[0], np.random.default_rng(0))
    assert state.offsets.shape == (5, length)
    with pytest.raises(ValueError, match="spread"):
        PlaneCombined(spread=(0.1,) * 9)
    with pytest.raises(ValueError, match="n"):
        PlaneCombined(n=0)


@pytest.mark.parametrize("lost_above, lost", [(0.01, True), (0.6, False)])
def test_what_the_optimiser_ends_on_is_judged_by_its_own_limit(lost_above, lost):
    """Whatever the filter before it thought of the place."""
    clip, rng = card("base", 2).sequence(), np.random.default_rng(0)
    ssd = PlaneSSD(iterations=3, lost_above=lost_above)
    tracker = PlaneCombined(n=30, ssd=ssd, threshold=1.0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    _, info = tracker.step(state, clip.frames[3], rng)
    assert info["steps"] >= 2 and info["lost"] == lost


def test_particles_of_a_plane_weigh_by_the_printed_likelihood():
    """Exp of -20 times the sum over the kernels of d^2, (13) of [T09]."""
    clip, tracker = card("base", 2).sequence(), PlaneCombined(n=30)
    state = tracker.init(clip.frames[0], clip.truth[0], np.random.default_rng(0))
    _, info = tracker.step(state, clip.frames[1], np.random.default_rng(1))
    noise = np.random.default_rng(1).standard_normal((30, 4))
    half_sides = state.target.kernels.half_sides
    places = moved(state.ssd.homography, tracker.spread * noise, half_sides)
    rho = state.target.coefficients(tracker.ssd.bins(clip.frames[1]), places)
    expected = np.exp(-20 * np.sum(1 - rho, axis=-1))
    np.testing.assert_allclose(info["weights"], expected / expected.sum(), rtol=1e-4)


def test_while_a_plane_is_hidden_the_mean_of_the_particles_is_said():
    clip, rng = card("base", 2).sequence(), np.random.default_rng(0)
    tracker = PlaneCombined(n=300, spread=(0.4, 0.01), threshold=-1.0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    sides = state.target.kernels.half_sides
    beside = moved(state.ssd.homography, np.array([0.3, 0]), sides)
    state = state._replace(ssd=state.ssd._replace(homography=beside))
    _, info = tracker.step(state, clip.frames[0], rng)
    mean = info["weights"] @ info["particles"][:, :2]
    np.testing.assert_allclose(info["region"][:2], mean, atol=0.2)
    assert np.abs(mean - beside[:2, 2]).max() > 1
