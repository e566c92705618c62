"""PFHR's equations (10), (12), (17) and (18), each term by itself."""

from dataclasses import replace

import numpy as np
import pytest

from mkt.histograms import coefficient, histograms
from mkt.particles import covariance, mean_region
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene
from mkt.trackers.hybrid_resampling import HybridResampling

CUP = Layer("cup", 60.0, ((0.0, 160.0, 120.0, 0.0, 1.0), (20.0, 190.0, 110.0, 0.0, 1)))
CLIP = Scene(CUP, "gravel", 8, shutter=0.0).sequence()
STILL = HybridResampling(
    n=40, motion=replace(HybridResampling().motion, position=0.0, scale=0.0)
)
SIZE = 30.0  # sqrt(hx hy) of the cup's square


class Edge:
    """Randomness whose uniform numbers all lie at the upper end, with no noise."""

    def uniform(self, low, high, shape):
        assert low == -high
        return np.full(shape, high)

    def standard_normal(self, shape):
        return np.zeros(shape)


def began(tracker=STILL):
    return tracker.init(CLIP.frames[0], CLIP.truth[0], np.random.default_rng(0))


@pytest.mark.parametrize("hidden", [1, 2, 5])
def test_the_search_grows_by_one_share_a_frame_from_the_first_on(hidden):
    """(18): +-(spread + growth (k - 1)) sqrt(hx hy) round the last estimate."""
    tracker = replace(STILL, inertial=0.0, spread=0.5, growth=0.1)
    state = began(tracker)._replace(hidden=hidden)
    reach = tracker.predict(state, (240, 320), Edge())[:, :2] - state.estimate[:2]
    wide = (0.5 + 0.1 * (hidden - 1)) * np.sqrt(np.prod(state.estimate[3:]))
    assert np.allclose(reach, wide)


def test_the_search_starts_at_the_estimate_whatever_the_particles_are():
    state = began()
    state = state._replace(hidden=1, regions=state.regions + 50)
    predicted = STILL.predict(state, (240, 320), Edge())
    assert np.allclose(predicted[:, 2:], state.estimate[2:])


@pytest.mark.parametrize("hidden, frames", [(0, 1), (1, 1.9), (2, 2.71)])
def test_inertia_carries_on_and_dies_away(hidden, frames):
    """v (1 + d + d^2 + ...): what is still to go after so many hidden frames."""
    state = began()._replace(velocity=np.array([4.0, -2.0]), hidden=hidden)
    assert np.allclose(
        replace(STILL, damping=0.9).drift(state), [4 * frames, -2 * frames]
    )


def test_particles_stay_inside_the_image_along_each_axis():
    state = began()._replace(velocity=np.array([900.0, 800.0]))
    onward = STILL.predict(state, (240, 320), Edge())[1::2, :2]
    assert (onward == [319, 239]).all()
    state = state._replace(velocity=np.array([-900.0, -800.0]))
    assert (STILL.predict(state, (240, 320), Edge())[1::2, :2] == 0).all()


def seen(tracker, state, rng=None):
    """A frame with the target: the state after it and the info."""
    return tracker.step(state, CLIP.frames[4], rng or np.random.default_rng(1))


def test_the_mean_velocity_takes_its_share_of_the_displacement():
    """(12), with smoothing .5 of a displacement that was made in one frame."""
    state = began()._replace(velocity=np.array([1.0, 2.0]))
    after, info = seen(replace(STILL, occlusion="never"), state)
    shift = (info["region"] - state.estimate)[:2]
    assert np.allclose(after.velocity, 0.5 * np.array([1.0, 2.0]) + 0.5 * shift)


def test_after_a_wait_the_displacement_is_shared_among_its_frames():
    state = began()._replace(hidden=3)
    after, info = seen(replace(STILL, occlusion="never"), state)
    shift = (info["region"] - state.estimate)[:2]
    assert np.allclose(after.velocity, 0.5 * shift / 4)
    assert after.hidden == 0


def test_the_reference_is_the_mixture_of_four_histograms():
    """(10): the reference as it was, the estimate, the heaviest particle, the first."""
    tracker = replace(HybridResampling(n=40), occlusion="never", w_min=0.0)
    state = began(tracker)
    # A reference that has moved away from the first look, so that the two differ.
    moved = state.target.q[:, ::-1].copy()
    moved = 0.7 * state.target.q + 0.3 * moved
    state = state._replace(target=state.target._replace(q=moved))
    after, info = seen(tracker, state)
    heaviest = info["particles"][np.argmax(info["weights"])]
    image = tracker.bins(CLIP.frames[4])
    looks = np.stack([info["region"], heaviest])
    estimate, best = histograms(image, state.target.kernels, looks)
    shares = info["shares"]
    mixed = (
        shares[0] * moved
        + shares[1] * estimate
        + shares[2] * best
        + shares[3] * state.first
    )
    assert np.allclose(after.target.q, mixed, atol=1e-6)
    # The two likelihoods are those against the reference as it was.
    rho = coefficient(np.stack([estimate, best]), moved)[:, 0]
    weigh = np.exp(-tracker.lam * (1 - rho))
    assert shares[3] == tracker.gamma
    assert shares[1] == pytest.approx(tracker.eta * weigh[0] / weigh.sum(), rel=1e-4)
    assert shares[2] == pytest.approx(tracker.eta - shares[1])
    assert info["distance"] == pytest.approx(np.sqrt(1 - rho[0]), abs=1e-4)


def test_nothing_is_learnt_below_the_mean_likelihood():
    learning = replace(HybridResampling(n=40), occlusion="never", w_min=0.0)
    state = began(learning)
    assert seen(learning, state)[1]["shares"][3] > 0
    wary = replace(learning, w_min=1.0)
    after, info = seen(wary, state)
    assert info["shares"].tolist() == [1, 0, 0, 0]
    assert np.allclose(after.target.q, state.target.q)


def test_weights_multiply_from_frame_to_frame():
    """(4): w_k ~ w_(k-1) p(z | x), with no test of acceptance."""
    state = began()
    heavy = np.arange(1.0, 41) / np.arange(1.0, 41).sum()
    state = state._replace(weights=heavy)
    image = STILL.bins(CLIP.frames[1])
    regions, weights, _ = STILL.accepted(
        state, image, state.regions, np.full(40, 0.5), np.random.default_rng(0)
    )
    assert np.allclose(weights, heavy / 2) and regions is state.regions


def test_metropolis_keeps_worse_places_as_often_as_their_ratio():
    tracker = replace(STILL, n=4000, accept="metropolis")
    state = began(tracker)
    state = state._replace(regions=np.tile(CLIP.truth[0], (4000, 1)))
    image = tracker.bins(CLIP.frames[0])
    old = tracker.likelihoods(state.target, image, state.regions)
    moved = state.regions + [1, 0, 0, 0, 0]
    _, weights, _ = tracker.accepted(
        state, image, moved, 0.3 * old, np.random.default_rng(0)
    )
    assert np.mean(weights == 0.3 * old) == pytest.approx(0.3, abs=0.03)


@pytest.mark.parametrize("accept", ["fresh", "metropolis"])
def test_what_lives_on_says_whether_the_target_is_hidden(accept):
    """All proposals are far off, and all old places on the target."""
    far = replace(STILL.motion, position=9.0)
    tracker = replace(STILL, accept=accept, motion=far)
    state = began(tracker)
    state = state._replace(regions=np.tile(CLIP.truth[0], (40, 1)))
    after, info = tracker.step(state, CLIP.frames[0], np.random.default_rng(0))
    assert not info["lost"] and after.hidden == 0
    assert info["shares"][0] < 1  # sure enough to learn


def test_the_printed_test_says_how_likely_the_new_places_are():
    """It compares with old weights, and does not look at the old places."""
    tracker = replace(STILL, accept="paper")
    state = began(tracker)
    image, likelihoods = tracker.bins(CLIP.frames[0]), np.full(40, 1e-3)
    moved = state.regions + [9, 0, 0, 0, 0]
    regions, weights, said = tracker.accepted(
        state, image, moved, likelihoods, np.random.default_rng(0)
    )
    assert (regions == state.regions).all() and (weights == state.weights).all()
    assert (said == likelihoods).all()


def test_the_level_alone_decides_what_is_hidden():
    tracker = replace(STILL, level=0.1)
    equal = np.full(40, 1 / 40)
    assert tracker.is_hidden(equal, np.full(40, 0.099))
    assert not tracker.is_hidden(equal, np.r_[np.zeros(39), 0.1])
    printed = replace(tracker, occlusion="n_eff", n_lim=0.5)
    assert not printed.is_hidden(equal, np.zeros(40))
    alone = np.r_[1.0, np.zeros(39)]
    assert printed.is_hidden(alone, np.ones(40))


def test_the_printed_sign_draws_learns_and_estimates_and_spreads_in_the_next_frame():
    tracker = HybridResampling(n=40, occlusion="n_eff", n_lim=1.0, w_min=-1.0)
    before = began(tracker)._replace(velocity=np.array([4.0, -2.0]))
    after, info = tracker.step(before, CLIP.frames[1], np.random.default_rng(0))
    assert info["lost"] and after.hidden == 1
    estimate = mean_region(info["particles"], info["weights"])
    np.testing.assert_array_equal(info["region"], estimate)
    drawn = (after.regions[:, None] == info["particles"]).all(-1).any(1)
    assert drawn.all() and len(np.unique(after.regions, axis=0)) < 40
    assert (after.weights == 1 / 40).all() and (info["shares"][1:] > 0).all()
    np.testing.assert_array_equal(after.estimate, before.estimate)
    np.testing.assert_array_equal(after.velocity, before.velocity)
    again, _ = tracker.step(after, CLIP.frames[2], np.random.default_rng(1))
    assert again.hidden == 2 and (again.estimate == before.estimate).all()


def test_the_defaults_that_are_printed():
    tracker = HybridResampling()
    printed = (tracker.n, tracker.lam, tracker.inertial, tracker.gamma)
    assert printed == (200, 20.0, 0.5, 0.1)


# What a frame reports, and what waiting leaves.
def hidden_frames(n, **fields):
    """States and infos of frames in which nothing is seen."""
    tracker = replace(STILL, level=2.0, **fields)
    state = began(tracker)._replace(velocity=np.array([4.0, -2.0]))
    for k in range(1, n + 1):
        before = state
        state, info = tracker.step(before, CLIP.frames[k], np.random.default_rng(k))
        yield tracker, before, state, info


def test_while_it_waits_the_target_is_where_inertia_has_carried_it():
    total = np.zeros(2)
    for k, (_, before, after, info) in enumerate(hidden_frames(3, damping=0.5)):
        total += np.array([4.0, -2.0]) * 0.5**k
        moved = info["region"] - before.estimate
        np.testing.assert_allclose(moved, [*total, 0, 0, 0], atol=1e-9)
        assert info["lost"] and after.hidden == k + 1
        np.testing.assert_array_equal(after.estimate, before.estimate)


def test_while_it_waits_particles_go_on_and_weigh_the_same():
    for _, before, after, info in hidden_frames(2):
        np.testing.assert_array_equal(after.regions, info["particles"])
        assert not np.array_equal(after.regions, before.regions)
        np.testing.assert_allclose(after.weights, 1 / STILL.n)
        np.testing.assert_array_equal(info["shares"], (1, 0, 0, 0))


def test_the_distance_of_a_hidden_target_is_that_of_where_it_should_be():
    for tracker, before, _, info in hidden_frames(2, damping=0.9):
        k = before.hidden + 1
        image = tracker.bins(CLIP.frames[k])
        expected = float(before.target.distances(image, info["region"]))
        assert info["distance"] == pytest.approx(expected)


@pytest.mark.parametrize("hidden", [False, True])
def test_spread_and_effective_size_are_those_of_the_particles_reported(hidden):
    tracker = replace(STILL, level=2.0 if hidden else 0.0)
    _, info = tracker.step(began(tracker), CLIP.frames[1], np.random.default_rng(1))
    assert info["n_eff"] == pytest.approx(1 / np.sum(info["weights"] ** 2))
    spread = covariance(info["particles"], info["weights"], info["region"])
    np.testing.assert_allclose(info["covariance"], spread)


@pytest.mark.parametrize("accept", ["always", "paper", "fresh", "metropolis"])
@pytest.mark.parametrize("waiting", [False, True])
@pytest.mark.parametrize("hidden", [False, True])
def test_each_look_at_a_region_is_counted(accept, waiting, hidden):
    """The old places are asked again by two tests, and not while the target is gone."""
    tracker = replace(STILL, accept=accept, level=2.0 if hidden else 0.0)
    state = began(tracker)._replace(hidden=int(waiting))
    _, info = tracker.step(state, CLIP.frames[1], np.random.default_rng(1))
    anew = accept in ("fresh", "metropolis") and not waiting
    assert info["evaluations"] == 40 * (1 + anew) + (1 if hidden else 2)


def test_likelihoods_have_the_sharpness_of_the_tracker():
    """exp(-lam d^2): twice lam is the square."""
    state, image = began(), STILL.bins(CLIP.frames[3])
    places = state.regions + np.arange(STILL.n)[:, None] * (1, 0, 0, 0, 0)
    once, twice = (
        replace(STILL, lam=lam).likelihoods(state.target, image, places)
        for lam in (10.0, 20.0)
    )
    np.testing.assert_allclose(twice, once**2, rtol=1e-5)


def test_shares_that_sum_to_more_than_one_are_refused_with_their_sum():
    with pytest.raises(ValueError, match=r"eta \+ gamma is 1\.2"):
        HybridResampling(eta=0.5, gamma=0.7)
    with pytest.raises(ValueError, match="gamma"):
        HybridResampling(eta=0.5, gamma=-0.1)
    with pytest.raises(ValueError, match="n is"):
        HybridResampling(n=0)
