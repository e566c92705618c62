"""PFHR: its update, its readings of the acceptance test, its occlusion mode."""

from dataclasses import replace

import numpy as np
import pytest

from mkt.evaluation import overlap
from mkt.kernels import Kernels
from mkt.scenes import SCENES
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene
from mkt.trackers.by_name import TRACKERS
from mkt.trackers.hybrid_resampling import ACCEPT, NOTHING_LEARNT, HybridResampling
from mkt.tracking import track
from tests.trackers.scenes import STANDING

PFHR = TRACKERS["pfhr"]
SEEDS = range(5)
EQUAL = np.full(PFHR.n, 1 / PFHR.n)


def behind_a_wall(length=80):
    """A cup that goes to the right at 3 px a frame, past a brick wall on its way.

    It is totally hidden for about ten frames.
    """
    start = (0.0, 50.0, 120.0, 0.0, 1.0)
    end = (float(length), 50.0 + 3 * length, 120.0, 0.0, 1.0)
    wall = Layer("bricks", 90.0, ((0.0, 180.0, 120.0, 0.0, 1.0),))
    cup = Layer("cup", 60.0, (start, end))
    return Scene(cup, "gravel", length, front=(wall,), shutter=0.0)


def kept(scene):
    """The sequence of a scene, its frames rendered once."""
    clip = scene.sequence()
    return replace(clip, frames=list(clip.frames))


@pytest.fixture(scope="module")
def wall():
    return kept(behind_a_wall())


@pytest.fixture(scope="module")
def runs(wall):
    return [track(PFHR, wall, seed, keep=("particles",)) for seed in SEEDS]


def test_a_visible_target_is_followed(wall, runs):
    before = np.argmax(wall.visibility < 0.9)
    for run in runs:
        iou = overlap(run.regions[:before], wall.truth[:before])
        assert iou.min() > 0.4


def test_it_says_that_the_target_is_hidden_and_finds_it_again(wall, runs):
    gone, before = wall.visibility < 0.02, np.argmax(wall.visibility < 0.9)
    for run in runs:
        assert run.lost[gone].mean() > 0.8
        assert not run.lost[:before].any() and not run.lost[-5:].any()
        assert overlap(run.regions[-1], wall.truth[-1]) > 0.4


def test_few_effective_particles_are_no_sign_of_an_occlusion(wall, runs):
    """Where all looks equally bad, all weights are equal.

    The printed test takes the visible target for the hidden one, and the wall for the
    target.
    """
    gone, there = wall.visibility < 0.02, wall.visibility > 0.9
    for seed in SEEDS:
        lost = track(replace(PFHR, occlusion="n_eff"), wall, seed).lost
        assert lost[there].mean() > 0.3 and not lost[gone].all()
        assert runs[seed].lost[gone].all()


def test_while_hidden_the_particles_spread_wider_every_frame_and_nothing_is_learnt(
    runs,
):
    for run in runs:
        hidden = np.flatnonzero(run.lost)
        first, last = hidden[0] + 1, hidden[-1]
        widths = [np.ptp(run.info["particles"][k][::2, 1]) for k in (first, last)]
        assert widths[1] > widths[0] + 10
        assert (run.info["shares"][hidden] == NOTHING_LEARNT).all()


def test_coefficients_of_the_update_stay_in_bounds_and_sum_to_one(runs):
    shares = np.concatenate([run.info["shares"][1:] for run in runs])
    assert (shares >= 0).all() and (shares <= 1).all()
    np.testing.assert_allclose(shares.sum(1), 1)
    learnt = shares[shares[:, 3] > 0]
    assert len(learnt) > 50
    np.testing.assert_allclose(learnt[:, 3], PFHR.gamma)


@pytest.mark.parametrize(
    "likelihoods", [(1e-9, 1e-9), (1.0, 1e-9), (1e-9, 1.0), (1.0, 1.0)]
)
def test_coefficients_at_extreme_likelihoods(likelihoods):
    for eta, gamma in ((0.0, 0.0), (0.2, 0.1), (0.5, 0.5), (0.0, 1.0)):
        shares = replace(PFHR, eta=eta, gamma=gamma).shares(*likelihoods)
        assert (shares >= 0).all() and shares.sum() == pytest.approx(1)


def test_the_reference_stays_a_histogram_and_near_the_first_look(wall):
    rng = np.random.default_rng(0)
    state = PFHR.init(wall.frames[0], wall.truth[0], rng)
    for frame in wall.frames[1:20]:
        state, _ = PFHR.step(state, frame, rng)
    np.testing.assert_allclose(state.target.q.sum(-1), 1, atol=1e-4)
    assert 0 < np.abs(state.target.q - state.first).sum() < 0.5


def test_half_of_the_particles_go_on_with_the_mean_velocity(wall):
    still = replace(PFHR, motion=replace(PFHR.motion, position=0.0, scale=0.0))
    state = still.init(wall.frames[0], wall.truth[0], np.random.default_rng(0))
    state = state._replace(velocity=np.array([5.0, -2.0]))
    predicted = still.predict(state, wall.frames[0].shape, np.random.default_rng(1))
    moves = predicted[:, :2] - state.regions[:, :2]
    onward = np.abs(moves - [5, -2]).max(1) < 1e-9
    assert onward.sum() == PFHR.n / 2 and np.abs(moves[~onward]).max() < 1e-9
    # Copies of one ancestor, which are neighbours, are split evenly.
    assert (onward[:-1] != onward[1:]).all()


def acceptance(accept, weights, seed=0):
    """What the test does in a frame with the target, where old particles weigh so much.

    Returns the share of particles that it keeps, their weights and their likelihoods.
    """
    clip = replace(behind_a_wall(), length=2).sequence()
    tracker, rng = replace(PFHR, accept=accept), np.random.default_rng(seed)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)._replace(weights=weights)
    image = tracker.bins(clip.frames[1])
    predicted = tracker.predict(state, clip.frames[1].shape, rng)
    likelihoods = tracker.likelihoods(state.target, image, predicted)
    regions, kept, _ = tracker.accepted(state, image, predicted, likelihoods, rng)
    accepted = np.mean((regions == predicted).all(1))
    return accepted, kept, tracker.likelihoods(state.target, image, regions)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_readings_of_the_acceptance_test(seed):
    """Most proposals are worse: they are wider than the particles."""
    accepted = {accept: acceptance(accept, EQUAL, seed)[0] for accept in ACCEPT}
    assert accepted["always"] == 1
    assert accepted["fresh"] < accepted["metropolis"] < 1
    assert accepted["fresh"] < 0.5


def test_the_printed_test_accepts_up_to_a_distance_that_depends_on_the_number_of_particles():  # noqa: E501
    _, kept, likelihoods = acceptance("paper", EQUAL)
    new = kept > 1 / PFHR.n
    distances = np.sqrt(-np.log(likelihoods) / PFHR.lam)
    bound = np.sqrt(np.log(PFHR.n) / PFHR.lam)
    assert bound == pytest.approx(0.515, abs=5e-4)
    assert 0 < new.sum() < PFHR.n and distances[new].max() < bound
    np.testing.assert_allclose(kept[new], likelihoods[new])
    assert (kept[~new] == 1 / PFHR.n).all()  # what it rejects keeps the old weight


def test_old_likelihoods_in_place_of_weights_reject_everything():
    """The other literal reading: stored raw likelihoods of an older, better frame."""
    assert acceptance("paper", np.ones(PFHR.n))[0] == 0


def test_fresh_never_keeps_the_worse_place():
    _, kept, likelihoods = acceptance("fresh", EQUAL)
    np.testing.assert_allclose(kept, likelihoods)


def test_the_same_seed_gives_the_same_run(wall):
    clip = wall.part(slice(12))
    one, two, other = (track(PFHR, clip, seed).regions for seed in (3, 3, 4))
    np.testing.assert_array_equal(one, two)
    assert (one[-1] != other[-1]).any()


@pytest.mark.parametrize("name", ["sir", "pfhr"])
def test_boxes_stay_upright_and_keep_their_aspect(name, wall):
    regions = track(TRACKERS[name], wall.part(slice(15))).regions
    np.testing.assert_allclose(regions[:, 2], 0, atol=1e-12)
    aspect = regions[:, 3] / regions[:, 4]
    np.testing.assert_allclose(aspect, aspect[0])


@pytest.mark.parametrize(
    "field, value",
    [
        ("accept", "never"),
        ("occlusion", "weights"),
        ("inertial", 1.5),
        ("eta", -0.1),
        ("gamma", 0.96),
        ("lam", -5.0),
    ],
)
def test_wrong_parameters_are_named(field, value):
    with pytest.raises(ValueError, match=field):
        HybridResampling(**{field: value})


def turning():
    """An astronaut who shows another side within twenty frames, and keeps to that.

    Four fifths of it are another texture.
    """
    look = Layer("hopper", 64.0, ((0.0, 160.0, 120.0, 0.0, 1.0),))
    way = ((0.0, 140.0, 120.0, 0.0, 1.0), (100.0, 190.0, 110.0, 0.0, 1.0))
    turn = ((0.0, 0.0), (10.0, 0.0), (30.0, 0.8))
    target = Layer("astronaut", 64.0, way, view=look, turn=turn)
    return Scene(target, "bricks", 100, shutter=0.0)


@pytest.mark.slow
def test_an_object_that_shows_another_side_is_waited_for_where_it_was():
    """That is the price of a fixed level; without the occlusion mode nobody waits."""
    clip = kept(turning())
    waits = [track(PFHR, clip, seed).lost[-30:].mean() for seed in range(3)]
    assert min(waits) > 0.9
    assert not track(replace(PFHR, occlusion="never"), clip).lost.any()


@pytest.mark.parametrize("accept, times", [("always", 1), ("paper", 1), ("fresh", 2)])
def test_the_cost_counts_every_look_at_a_region(accept, times, wall):
    """Two more are the estimate and the heaviest particle."""
    run = track(replace(PFHR, accept=accept), wall.part(slice(5)))
    assert (run.info["evaluations"][1:] == times * PFHR.n + 2).all()


def test_with_several_kernels_all_of_them_say_how_far_off_the_target_is():
    clip = SCENES["base"](500).sequence()
    nine = Kernels("tiles", "uniform")
    tracker = HybridResampling(kernels=nine, lam=20 / 9, occlusion="never")
    rng = np.random.default_rng(0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    after, info = tracker.step(state, clip.frames[1], rng)
    seen = state.target.distances(tracker.bins(clip.frames[1]), info["region"])
    assert info["distance"] == pytest.approx(seen, abs=1e-6)


@pytest.mark.parametrize("occlusion", ["likelihood", "n_eff", "never"])
def test_likelihoods_too_small_to_be_written_down_are_all_alike(occlusion, wall):
    strict, rng = replace(PFHR, lam=1e5, occlusion=occlusion), np.random.default_rng(0)
    state = strict.init(wall.frames[0], wall.truth[0], rng)
    _, info = strict.step(state, np.zeros_like(wall.frames[0]), rng)
    assert np.allclose(info["weights"], 1 / PFHR.n)
    assert info["n_eff"] == pytest.approx(PFHR.n)
    assert np.allclose(strict.shares(0.0, 0.0), strict.shares(0.4, 0.4))


def test_the_share_that_goes_on_is_exact():
    tracker, clip = HybridResampling(n=200, inertial=0.58), STANDING.sequence()
    frame, rng = clip.frames[0], np.random.default_rng
    state = tracker.init(frame, clip.truth[0], rng(0))
    moving = state._replace(velocity=np.array([9.0, 0.0]))
    walk, with_it = (tracker.predict(s, frame.shape, rng(0)) for s in (state, moving))
    assert (walk != with_it).any(1).sum() == 116
