"""Resampling is unbiased, motion is in units of the target, weights are never NaN."""

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mkt.particles import (
    SCHEMES,
    EllipseMotion,
    Motion,
    Particles,
    covariance,
    effective_sample_size,
    independent_positions,
    mean_region,
    normalised,
    resample_if_degenerate,
    residual,
    search,
    stratified_positions,
    systematic_positions,
    whole_and_rest,
)

seeds = st.integers(0, 2**32 - 1)
weights = (
    st.lists(st.floats(0, 1), min_size=1, max_size=40)
    .filter(lambda w: sum(w) > 1e-3)
    .map(lambda w: np.array(w) / sum(w))
)
# Regions (N, 5) whose angles are less than half a turn apart.
particles = st.integers(2, 30).flatmap(
    lambda n: arrays(float, (n, 5), elements=st.floats(-1.5, 1.5))
)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_every_particle_is_drawn_as_often_as_it_weighs(scheme):
    """Including the first one, which the printed systematic listing never draws."""
    w = np.array([0.168, 0.3, 0.002, 0.0, 0.25, 0.1, 0.18])
    rng = np.random.default_rng(0)
    draws = np.concatenate([SCHEMES[scheme](w, rng) for _ in range(4000)])
    frequency = np.bincount(draws, minlength=7) / len(draws)
    assert np.allclose(frequency, w, atol=4 * np.sqrt(0.25 / len(draws)))
    assert frequency[3] == 0


@given(weights, seeds)
def test_schemes_return_as_many_ancestors_as_particles(w, seed):
    for scheme in SCHEMES.values():
        ancestors = scheme(w, np.random.default_rng(seed))
        assert len(ancestors) == len(w) and (w[ancestors] > 0).all()


def children(scheme, w, seed):
    """How often each particle is drawn."""
    ancestors = SCHEMES[scheme](w, np.random.default_rng(seed))
    return np.bincount(ancestors, minlength=len(w))


@given(weights, seeds)
def test_low_variance_schemes_are_within_one_of_the_expectation(w, seed):
    expected = len(w) * w
    assert (np.abs(children("systematic", w, seed) - expected) < 1 + 1e-6).all()
    assert (children("residual", w, seed) >= np.floor(expected - 1e-6)).all()


@given(st.integers(1, 50), seeds)
def test_positions_lie_where_their_scheme_says(n, seed):
    free, stratified, systematic = (
        np.sort(positions(n, np.random.default_rng(seed)))
        for positions in (
            independent_positions,
            stratified_positions,
            systematic_positions,
        )
    )
    for positions in (free, stratified, systematic):
        assert positions.shape == (n,)
        assert (positions >= 0).all() and (positions <= 1).all()
    assert (np.abs(n * stratified - np.arange(n) - 0.5) <= 0.5 + 1e-9).all()
    assert 0 <= systematic[0] <= 1 / n
    assert np.allclose(np.diff(systematic), 1 / n)


def test_positions_differ_in_how_much_is_left_to_chance():
    """One random number for each position, or one for all of them."""
    rng = np.random.default_rng(0)
    inside = 20 * stratified_positions(20, rng) % 1
    assert np.ptp(inside) > 0.5
    assert np.ptp(20 * systematic_positions(20, rng) % 1) < 1e-9
    taken = np.floor(20 * independent_positions(20, rng))
    assert len(set(taken)) < 20  # some strata get two, others none


def test_a_position_belongs_to_the_particle_whose_share_it_falls_into():
    found = search([0.5, 0.0, 0.25, 0.25], [0.0, 0.49, 0.5, 0.74, 0.75, 1.0])
    assert found.tolist() == [0, 0, 2, 2, 3, 3]


def test_weights_are_one_row():
    table = np.full((2, 2), 0.25)
    for scheme in SCHEMES.values():
        with pytest.raises(ValueError, match="weights must not be negative.*normalise"):
            scheme(table, np.random.default_rng(0))
    with pytest.raises(ValueError, match="weights must not be"):
        effective_sample_size(table)
    with pytest.raises(ValueError, match="weights must not be"):
        mean_region(np.ones((1, 5)), [[1.0]])


def test_nothing_is_scattered_round_what_has_no_area():
    with pytest.raises(ValueError, match="has no area"):
        Motion().scatter([0, 0, 0, -1, 1], 3, np.random.default_rng(0))


@pytest.mark.parametrize("bad", [[], [0.0, 0.0], [1.0, -0.1], [np.nan, 1.0], [np.inf]])
def test_nothing_is_drawn_from_what_is_no_distribution(bad):
    for scheme in SCHEMES.values():
        with pytest.raises(ValueError, match="weights must not be negative.*normalise"):
            scheme(bad, np.random.default_rng(0))


@pytest.mark.parametrize("bad", [[], [0.0, 0.0], [1.0, -0.1], [np.nan, 1.0], [np.inf]])
def test_nothing_is_estimated_from_what_is_no_distribution(bad):
    with pytest.raises(ValueError, match="weights must not be .* none at all; make"):
        mean_region(np.ones((len(bad), 5)), bad)


@pytest.mark.parametrize("bad", [[], [0.0, 0.0], [np.nan, 1.0], [np.inf], [2.0, -1.0]])
def test_weights_that_count_nothing_have_no_effective_sample_size(bad):
    with pytest.raises(ValueError, match="weights must not be .* none at all; make"):
        effective_sample_size(bad)


@pytest.mark.parametrize("total", [0.5, 0.999, 1.001, 2])
def test_an_estimate_needs_weights_of_sum_one(total):
    weights = np.full(2, total / 2)
    with pytest.raises(ValueError, match="make them of sum 1"):
        mean_region(np.ones((2, 5)), weights)
    with pytest.raises(ValueError, match="make them of sum 1"):
        effective_sample_size(weights)
    assert effective_sample_size(np.full(50_000, 1 / 50_000, np.float32)) > 49_000


@pytest.mark.parametrize("hx", [0.0, -3.0])
@pytest.mark.parametrize("weight", [0.0, 0.5, 1.0])
def test_particles_without_area_have_no_mean(hx, weight):
    regions = [[1, 2, 0, 3, 4], [1, 2, 0, hx, 4]]
    said = r"^region 1 is \(1, 2, 0, .*, 4\), without area; give half axes"
    with pytest.raises(ValueError, match=said):
        mean_region(regions, [1 - weight, weight])


def test_the_mean_of_what_is_not_known_is_not_known():
    regions = [[1, 2, 0, 3, 4], [np.nan] * 5]
    assert np.isnan(mean_region(regions, [0.5, 0.5])).all()


def test_no_weights_follow_from_no_logarithms():
    with pytest.raises(ValueError, match="log_weights is empty; give one for each"):
        normalised([])


def test_the_mean_takes_lists():
    regions, w = [[1, 2, 0.5, 3, 4], [3, 2, 0.5, 3, 4]], [0.5, 0.5]
    assert mean_region(regions, w) == pytest.approx([2, 2, 0.5, 3, 4])
    with pytest.raises(ValueError, match=r"regions must have the shape \(\.\.\., 5\)"):
        mean_region([[1, 2, 0.5]], [1])
    for regions, w in (([1, 2, 3, 4, 5], [1]), (np.ones((3, 5)), [0.5, 0.5])):
        with pytest.raises(
            ValueError, match="regions have the shape .* a weight for e"
        ):
            mean_region(regions, w)


@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("w", [[1, 1, 1], [2, 0.5, 0.5], [0.1, 0.2, 0.1]])
def test_the_sum_of_the_weights_does_not_matter(name, w):
    """Up to where rounding tells: no position falls on a border."""
    draws = [
        SCHEMES[name](weights, np.random.default_rng(3))
        for weights in (w, np.divide(w, np.sum(w)))
    ]
    assert draws[0].tolist() == draws[1].tolist() and len(draws[0]) == len(w)


@given(weights, st.floats(0, 1.5), st.sampled_from(sorted(SCHEMES)), seeds)
def test_resampling_happens_where_too_few_particles_count(w, share, name, seed):
    n = len(w)
    scheme, rng = SCHEMES[name], np.random.default_rng(seed)
    ancestors, after = resample_if_degenerate(w, share, scheme, rng)
    if effective_sample_size(w) < share * n:
        drawn = scheme(w, np.random.default_rng(seed))
        assert ancestors.tolist() == drawn.tolist()
        assert (after == 1 / n).all()
    else:
        assert ancestors.tolist() == list(range(n)) and (after == w).all()
        assert rng.random() == np.random.default_rng(seed).random()  # nothing was drawn


def test_limits_of_resampling():
    w, rng = np.array([0.7, 0.1, 0.1, 0.1]), np.random.default_rng(0)
    equal = np.full(4, 0.25)
    for share, expected in ((0.0, w), (0.4, w), (0.5, equal), (1.0, equal)):
        _, after = resample_if_degenerate(w, share, SCHEMES["systematic"], rng)
        assert after.tolist() == expected.tolist()  # N_eff is 1.92 of 4


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


@given(particles, seeds)
def test_covariance_is_that_of_numpy(regions, seed):
    w = np.random.default_rng(seed).dirichlet(np.ones(len(regions)))
    assume(w.max() < 1 - 1e-6)
    ours = covariance(regions, w, w @ regions)
    theirs = np.cov(regions.T, aweights=w, ddof=0)
    assert np.allclose(ours, theirs, atol=1e-12)
    assert np.linalg.eigvalsh(ours).min() > -1e-12


@given(particles, seeds)
def test_whole_turns_do_not_count_in_the_covariance(regions, seed):
    rng = np.random.default_rng(seed)
    w = rng.dirichlet(np.ones(len(regions)))
    turned = regions.copy()
    turned[:, 2] += 2 * np.pi * rng.integers(-3, 4, len(regions))
    before = covariance(regions, w, w @ regions)
    assert np.allclose(covariance(turned, w, w @ regions), before, atol=1e-9)


def test_motion_scales_with_the_target():
    small, large = np.array([50, 50, 0, 10, 5.0]), np.array([50, 50, 0, 40, 20.0])
    a, b = (
        Motion().scatter(region, 2000, np.random.default_rng(1))
        for region in (small, large)
    )
    assert np.allclose(4 * (a.regions[:, :2] - 50), b.regions[:, :2] - 50)
    assert np.allclose(a.regions[:, 2], b.regions[:, 2])


@pytest.mark.parametrize(
    "motion, mean",
    [(Motion(damping=1.0), 5), (Motion(damping=0.0, velocity=0.0), 0)],
    ids=["constant velocity", "a random walk"],
)
def test_constant_velocity_moves_and_a_random_walk_does_not(motion, mean):
    regions = np.tile([0.0, 0, 0, 10, 10], (4000, 1))
    swarm = Particles(regions, np.tile([5.0, 0], (4000, 1)))
    moved = motion.predict(swarm, np.random.default_rng(0))
    assert moved.regions[:, 0].mean() == pytest.approx(mean, abs=0.1)


def test_particles_are_taken_with_their_velocities():
    swarm = Particles(np.arange(15.0).reshape(3, 5), np.arange(6.0).reshape(3, 2))
    taken = swarm.take(np.array([2, 2, 0]))
    assert taken.regions[:, 0].tolist() == [10, 10, 0]
    assert taken.velocities[:, 0].tolist() == [4, 4, 0]


class Given:
    """A source of randomness that answers what it was given, in order."""

    def __init__(self, *answers):
        self.answers = [np.asarray(answer, float) for answer in answers]

    def standard_normal(self, shape):
        answer = self.answers.pop(0)
        assert answer.shape == (shape if isinstance(shape, tuple) else (shape,))
        return answer


def test_every_term_of_the_motion_is_the_one_that_is_written():
    # v' = d v + s_v u k, c' = c + v' + s_p u w, theta' = theta + s_a a,
    # h' = h exp(s_s g)
    motion = Motion(position=0.5, velocity=0.25, angle=0.1, scale=0.2, damping=0.6)
    regions = np.array([[10, 20, 0.3, 4, 9], [30, 40, -0.2, 8, 2.0]])
    velocities = np.array([[5.0, -10], [1, 2]])
    kicks, walk = [[1.0, 2], [-1, 3]], [[-2.0, 1], [4, 0.5]]
    turns, growth = [2.0, -1], [1.0, -2]
    rng = Given(kicks, walk, turns, growth)
    moved = motion.predict(Particles(regions, velocities), rng)
    units = [6.0, 4.0]  # sqrt(hx hy)
    for i, u in enumerate(units):
        v = 0.6 * velocities[i] + 0.25 * u * np.array(kicks[i])
        assert np.allclose(moved.velocities[i], v)
        centre = regions[i, :2] + v + 0.5 * u * np.array(walk[i])
        assert np.allclose(moved.regions[i, :2], centre)
        assert np.isclose(moved.regions[i, 2], regions[i, 2] + 0.1 * turns[i])
        axes = regions[i, 3:] * np.exp(0.2 * growth[i])
        assert np.allclose(moved.regions[i, 3:], axes)


def test_scattered_particles_start_at_rest():
    # One draw of the place, of the angle, of the size; the velocity is noise alone.
    kicks, walk = np.zeros((3, 2)), np.zeros((3, 2))
    still = Motion().scatter([5, 6, 0.1, 3, 2], 3, Given(kicks, walk, [0] * 3, [0] * 3))
    assert np.allclose(still.regions, [5, 6, 0.1, 3, 2])
    assert np.all(still.velocities == 0)


def test_the_defaults_of_the_motion_are_those_of_the_chapters():
    assert Motion() == Motion(0.06, 0.05, 0.08, 0.03, 0.8)


def test_weights_that_are_all_impossible_become_equal():
    assert normalised([-np.inf, -np.inf]).tolist() == [0.5, 0.5]
    assert normalised([np.nan, 0.0]).tolist() == [0.5, 0.5]
    assert normalised([-np.inf, 0.0]).tolist() == [0.0, 1.0]


@given(arrays(float, (6,), elements=st.floats(0, 1)), st.integers(0, 2**32 - 1))
def test_residual_copies_the_whole_parts_and_draws_just_the_rest(w, seed):
    w = w + 1e-3
    w = w / w.sum()
    copies = np.bincount(residual(w, np.random.default_rng(seed)), minlength=6)
    certain, left = whole_and_rest(w)
    assert copies.sum() == 6
    assert np.all(copies >= certain)
    # Nobody without a rest is drawn on top of his whole part.
    assert np.all((copies == certain)[left == 0])


@given(st.integers(1, 300))
@example(93)  # 93 times a 93rd is a little less than 1
def test_residual_copies_each_of_equal_particles_once(n):
    certain, left = whole_and_rest(np.full(n, 1 / n))
    assert (certain == 1).all() and left == pytest.approx(np.zeros(n))


def test_only_whole_parts_are_certain():
    certain, left = whole_and_rest([0.475, 0.525])  # of two: 0.95 and 1.05
    assert certain.tolist() == [0, 1] and left == pytest.approx([0.95, 0.05])


def test_every_term_of_the_motion_of_an_ellipse_is_the_one_that_is_written():
    motion = EllipseMotion(position=0.5, velocity=0.25, axes=0.1, growth=0.2)
    noise = np.arange(1.0, 8)[None]
    states = np.array([[10.0, 20, 1.5, -2, 9, 16, 5]])
    moved = motion.predict(states, np.array([3.0, 4.0]), Given(noise))
    size = 12  # sqrt(9 * 16)
    kicks = size * noise[0] * [0.5, 0.5, 0.25, 0.25, 0.1, 0.1, 0.2]
    # va = 5 is shared by the axes as 3 : 4, which is that of the start.
    assert np.allclose(moved[0], np.array([11.5, 18, 1.5, -2, 12, 20, 5]) + kicks)


class Uniform:
    """A source of chance that gives certain numbers in [0, 1), in order."""

    def __init__(self, *numbers):
        self.left = list(numbers)

    def random(self, n=None):
        taken = [self.left.pop(0) for _ in range(1 if n is None else n)]
        return taken[0] if n is None else np.array(taken)


@pytest.mark.parametrize(
    "name, chance, expected",
    [
        ("multinomial", [0.9, 0.1, 0.6, 0.2], [3, 0, 2, 0]),
        ("stratified", [0.9, 0.1, 0.1, 0.2], [0, 0, 2, 2]),
        ("stratified", [0.9, 0.99, 0.1, 0.2], [0, 1, 2, 2]),
        ("systematic", [0.5], [0, 0, 2, 3]),
        ("residual", [0.95, 0.1], [0, 2, 3, 0]),
    ],
)
def test_where_each_scheme_leaves_what_to_chance(name, chance, expected):
    """Weights of 1.8, .2, 1.3 and .7 particles: residual copies two for certain."""
    drawn = SCHEMES[name]([0.45, 0.05, 0.325, 0.175], Uniform(*chance))
    assert drawn.tolist() == expected
