"""What the guided tracker decides in a frame, and what it reports of it."""

from dataclasses import replace

import numpy as np
import pytest

from mkt.evaluation import overlap
from mkt.particles import covariance, effective_sample_size
from mkt.regions import THETA, displaced
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene
from mkt.trackers.gains import relit
from mkt.trackers.guided import FULL_GRID, Guided, _surprise
from mkt.trackers.newton import minimise
from mkt.trackers.search import Optimum, Search
from tests.trackers.scenes import STANDING

FRAME = STANDING.sequence().frames[0]


def steps(tracker, scene, seed=0):
    """The state before each step, the frame, the state after it and the info."""
    clip, rng = scene.sequence(), np.random.default_rng(seed)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    for frame in clip.frames[1:]:
        before = state
        state, info = tracker.step(state, frame, rng)
        yield before, frame, state, info


def behind_gravel():
    wall = ((0.0, -1840.0, 120.0, 0.0, 1.0), (20.0, 1160.0, 120.0, 0.0, 1.0))
    front = (Layer("gravel", 900.0, wall),)
    return replace(STANDING, length=14, front=front, shutter=0.0)


def test_the_distance_is_that_of_the_region_under_the_last_fine_kernels():
    """In the frame as the tracker saw it: relit by the gains of the frame before."""
    said = set()
    for before, frame, _, info in steps(Guided(n=50), behind_gravel()):
        image = Guided().bins(relit(frame, before.light.gains))
        expected = float(before.fine.distances(image, info["region"]))
        assert info["distance"] == pytest.approx(expected, abs=1e-3)
        said.add(info["lost"])
    assert said == {True, False}


def test_particles_that_are_reported_are_those_that_were_weighed():
    """Those that begin anew at the estimate do so after the report."""
    tracker = Guided(n=50, renewed=1.0)
    for _, _, after, info in steps(tracker, replace(STANDING, length=3)):
        assert (after.particles.regions == after.region).all()
        assert np.ptp(info["particles"][:, 0]) > 1


def test_the_cost_is_in_regions_looked_at_with_the_full_grid():
    tracker = Guided(n=50)
    for _, _, after, info in steps(tracker, replace(STANDING, length=4)):
        coarse, closest = after.coarse.kernels, after.fine.kernels
        samples = 50 * len(coarse.points) + info["steps"] * len(closest.points)
        assert info["evaluations"] == pytest.approx(samples / FULL_GRID)


@pytest.mark.parametrize("hidden_above, hidden", [(2.0, False), (-1.0, True)])
def test_while_it_is_hidden_no_particle_comes_back(hidden_above, hidden):
    tracker = Guided(n=50, renewed=1.0, hidden_above=hidden_above)
    for _, _, after, _ in steps(tracker, replace(STANDING, length=4)):
        anew = (after.particles.regions == after.region).all()
        assert anew == (not hidden)


@pytest.mark.parametrize("lost_above, lost", [(2.0, False), (-1.0, True)])
def test_the_flag_is_a_threshold_that_changes_nothing_else(lost_above, lost):
    scene = replace(STANDING, length=4)
    flagged = steps(Guided(n=50, lost_above=lost_above), scene)
    for (*_, info), (*_, usual) in zip(
        flagged, steps(Guided(n=50), scene), strict=True
    ):
        assert info["lost"] == lost
        np.testing.assert_array_equal(info["region"], usual["region"])


MOVING = Scene(
    Layer("car", 80.0, ((0.0, 130.0, 120.0, 0.0, 1.0), (9.0, 166.0, 120.0, 0.0, 1.0))),
    length=10,
)


@pytest.mark.parametrize("doubtful, learnt", [(0.45, True), (-1.0, False)])
def test_the_velocity_is_learnt_from_sure_looks_alone(doubtful, learnt):
    """Of 4 px a frame; where every look is in doubt it stays what it was."""
    *_, (_, _, after, info) = steps(Guided(n=50, doubtful=doubtful), MOVING)
    assert overlap(info["region"], MOVING.sequence().truth[-1]) > 0.9
    expected = (4.0, 0.0) if learnt else (0.0, 0.0)
    np.testing.assert_allclose(after.velocity, expected, atol=0.7 if learnt else 0)


def test_of_each_look_half_of_the_movement_becomes_velocity():
    for before, _, after, _ in steps(Guided(n=50), MOVING):
        seen = after.region[:2] - before.region[:2]
        np.testing.assert_allclose(after.velocity, (before.velocity + seen) / 2)


def test_what_is_binned_holds_the_place_to_which_the_velocity_leads(monkeypatch):
    """Also where no particle is: a target that was seen to move by 90 px a frame."""
    tracker, clip, rng = Guided(n=50), STANDING.sequence(), np.random.default_rng(0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    there = displaced(clip.truth[0], dx=90.0)
    frame = np.roll(clip.frames[0], 90, 1)
    state = state._replace(velocity=np.array([90.0, 0.0]))
    _, info = tracker.step(state, frame, rng)
    assert overlap(info["region"], there) > 0.9


def test_the_first_sure_look_after_others_says_nothing_of_the_velocity():
    tracker, clip, rng = Guided(n=50), MOVING.sequence(), np.random.default_rng(0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)._replace(missed=3)
    after, _ = tracker.step(state, clip.frames[1], rng)
    assert after.missed == 0 and (after.velocity == state.velocity).all()


@pytest.mark.parametrize("found, learnt", [(0.3, True), (-1.0, False)])
def test_surprise_is_learnt_from_sure_looks_alone(found, learnt):
    """At rest before, it is 4 px off where it was expected; a tenth of that counts."""
    tracker, clip = Guided(n=50, found=found), MOVING.sequence()
    rng = np.random.default_rng(0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    state, _ = tracker.step(state, clip.frames[1], rng)
    once = 0.1 * 4**2 / np.prod(clip.truth[0, 3:])
    assert state.surprise == pytest.approx(once if learnt else 0, rel=0.3)
    state, _ = tracker.step(state._replace(surprise=1.0), clip.frames[2], rng)
    assert state.surprise == pytest.approx(0.9 if learnt else 1.0, abs=0.01)
    state = state._replace(surprise=1.0, missed=1)
    assert tracker.step(state, clip.frames[3], rng)[0].surprise == 1.0


def test_a_velocity_fades_while_the_target_is_hidden():
    tracker, clip = Guided(n=50, hidden_above=-1.0), MOVING.sequence()
    rng = np.random.default_rng(0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    state = state._replace(velocity=np.array([10.0, 0.0]))
    for frame in clip.frames[1:4]:
        state, _ = tracker.step(state, frame, rng)
    np.testing.assert_allclose(state.velocity, (7.29, 0.0))


@pytest.mark.parametrize("sure, back", [(0.25, True), (0.0, False)])
def test_a_target_seen_beyond_doubt_is_taken_wherever_it_is(sure, back):
    """The estimate stands far off, and the prior of the place would keep it there.

    Half of the crowd is with it, half at the target.
    """
    tracker, clip = Guided(n=50, sure=sure), STANDING.sequence()
    rng = np.random.default_rng(0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    beside = displaced(clip.truth[0], 90, 50)
    regions = np.where(np.arange(50)[:, None] % 2, beside, clip.truth[0])
    crowd = state.particles._replace(regions=regions)
    state = state._replace(region=beside, particles=crowd)
    _, info = tracker.step(state, clip.frames[1], rng)
    there = overlap(info["region"], clip.truth[1])
    assert there > 0.9 if back else there < 0.1


def test_a_box_that_touches_the_border_starts_with_the_part_that_is_seen():
    """Its particles are compared in the kernels that saw something; it comes in."""
    path = ((0.0, -18.0, 120.0, 0.0, 1.0), (20.0, 70.0, 120.0, 0.0, 1.0))
    scene = Scene(Layer("car", 80.0, path), length=20)
    *_, (_, _, after, info) = steps(Guided(n=50), scene)
    assert after.fine.learnt is not None and len(after.fine.learnt) < 9
    full = Guided()._search(after, None).full
    assert full == 2 * len(after.fine.learnt)  # the others' d says nothing
    assert overlap(info["region"], scene.sequence().truth[-1]) > 0.6


def test_a_turning_car_is_followed_in_its_turn():
    path = ((0.0, 160.0, 120.0, 0.0, 1.0), (24.0, 160.0, 120.0, 1.2, 1.0))
    scene = Scene(Layer("car", 80.0, path), length=25)
    *_, (_, _, after, info) = steps(Guided(n=50), scene)
    assert after.turned and abs(info["region"][2] - 1.2) < 0.1


@pytest.mark.parametrize("turn, turned", [(0.0, False), (np.inf, True)])
def test_the_share_decides_whether_a_turn_is_believed(turn, turned):
    path = ((0.0, 160.0, 120.0, 0.0, 1.0), (9.0, 160.0, 120.0, 0.5, 1.0))
    scene = Scene(Layer("car", 80.0, path), length=10)
    *_, (_, _, after, info) = steps(Guided(n=50, turn=turn), scene)
    assert after.turned == turned
    assert (abs(info["region"][2] - after.first[2]) > 1e-9) == turned


def test_what_is_far_off_is_looked_at_on_a_scale_that_fits():
    """A frame four times as large: the same pixels are binned, the same place found."""
    scene = Scene(Layer("car", 80.0, ((0.0, 159.5, 119.5, 0.1, 1.0),)), length=3)
    large = replace(
        scene,
        target=Layer("car", 320.0, ((0.0, 639.5, 479.5, 0.1, 1.0),)),
        size=(1280, 960),
        zoom=2.0,
    )
    for each, pitch in (scene, 1), (large, 5):
        *_, (_, _, after, info) = steps(Guided(n=50), each)
        assert after.pitch == pitch
        assert overlap(info["region"], each.sequence().truth[-1]) > 0.93


# The decisions of a frame, with ends of the optimiser that are given.
def far(share):
    """A region that is off the car by a share of its size."""
    region = STANDING.sequence().truth[0]
    return displaced(region, share * np.sqrt(region[3] * region[4]), 0)


def ended(region, distance, steps, free=False):
    return Optimum(region, distance, steps, free)


class Given(Search):
    """A search whose optimiser ends where it is told, and says where it began."""

    def told(self, *ends):
        object.__setattr__(self, "ends", list(ends))
        object.__setattr__(self, "asked", [])
        return self

    def closest(self, prior, start, free):
        self.asked.append((start, free, prior))
        return self.ends.pop(0)


def told(*ends):
    """A tracker, its state on the car's first frame, its prior, a search there."""
    tracker = Guided(n=50)
    state = tracker.init(FRAME, far(0), np.random.default_rng(0))
    search = Given(**vars(tracker._search(state, None))).told(*ends)
    return tracker, state, tracker._prior(state), search


@pytest.mark.parametrize(
    "away, distance, other, taken",
    [
        (1.0, 0.4, 0.46, 1),  # .16 + 1 / 18 against .2116
        (0.63**0.5, 0.4, 0.45, 0),  # .16 + .63 / 18 against .2025
        (0.0, 0.4, 0.4, 0),
    ],
)
def test_among_optima_the_sum_of_both_terms_decides(away, distance, other, taken):
    """O(x) of nine kernels is 18 d^2, and the prior comes to it."""
    ends = ended(far(away), distance, 3), ended(far(0), other, 4)
    *_, prior, search = told(*ends)
    found = search.over(prior, [far(0), far(0)], False)
    assert found.distance == ends[taken].distance and found.steps == 7
    np.testing.assert_array_equal(found.region, ends[taken].region)


def test_after_a_sure_optimum_no_further_start_is_tried():
    ends = [ended(far(0), d, 2) for d in (0.31, 0.29, 0.1)]
    *_, prior, search = told(*ends)
    found = search.over(prior, [far(0)] * 3, False)
    assert found.distance == 0.29 and found.steps == 4 and len(search.ends) == 1


def test_at_the_limit_itself_the_target_is_not_yet_found():
    *_, prior, search = told(*[ended(far(0), 0.3, 2)] * 2)
    assert search.over(prior, [far(0)] * 2, False).steps == 4


@pytest.mark.parametrize(
    "free, held, turned", [(0.5, 0.6, True), (0.51, 0.6, False), (0.5, 0.5, False)]
)
@pytest.mark.parametrize("before", [True, False])
def test_a_turn_must_bring_its_share_of_the_squared_distance(
    free, held, turned, before
):
    """.25 is below .7 * .36, and .2601 is not."""
    known, other = (free, held) if before else (held, free)
    *_, prior, search = told(ended(far(0.1), other, 3, not before))
    best = search.turned(prior, ended(far(0), known, 4, before))
    assert best.free == turned and best.steps == 7
    assert best.distance == (free if turned else held)
    assert search.asked[0][1] == (not before)


@pytest.mark.parametrize("distance, taken", [(0.24, True), (0.25, False)])
def test_a_start_anywhere_knows_no_place_and_has_a_size_and_a_turn_of_its_own(
    distance, taken
):
    end, known = ended(far(3), distance, 3, True), ended(far(0), 0.5, 4)
    *_, prior, search = told(end)
    start = far(3) * (1, 1, 1, 1.3, 1.3)
    under, found = search.anywhere(prior, known, start)
    assert found.steps == 7 and found.distance == (distance if taken else 0.5)
    [(begun, free, asked)] = search.asked
    assert begun is start and asked.region is start and free and found.free == taken
    assert (asked.weights == (0, 0, 0, 5)).all()
    assert under is (asked if taken else prior)
    assert (prior.weights == (1, 1, 0, 5)).all()


def test_the_prior_is_where_the_target_goes_and_widens_in_doubt():
    tracker, state, *_ = told()
    state = state._replace(velocity=np.array([6.0, -2.0]))
    for missed, place in (0, 1.0), (4, 0.5):
        prior = tracker._prior(state._replace(missed=missed))
        np.testing.assert_allclose(prior.region - state.region, (6, -2, 0, 0, 0))
        np.testing.assert_allclose(prior.weights, (place, place, 0, 5))


def test_the_prior_of_the_place_is_as_sure_as_the_velocity_was():
    """A miss as long as the particles' own step halves its weight."""
    tracker, state, *_ = told()
    for surprise, place in (0.0, 1.0), (0.01, 0.5), (0.03, 0.1):
        prior = tracker._prior(state._replace(surprise=surprise))
        np.testing.assert_allclose(prior.weights, (place, place, 0, 5))


def test_pixels_have_the_last_word_in_what_is_said_and_in_nothing_else():
    scene = replace(MOVING, length=5)
    kernels = steps(Guided(n=50, alike=2.0), scene)
    pixels = steps(Guided(n=50, alike=-1.0), scene)
    regions = []
    for (*_, one, told), (*_, other, said) in zip(kernels, pixels, strict=True):
        np.testing.assert_array_equal(one.region, told["region"])
        np.testing.assert_array_equal(one.region, other.region)
        np.testing.assert_array_equal(one.particles.regions, other.particles.regions)
        assert not np.array_equal(other.region, said["region"])
        regions.append([told["region"], said["region"]])
    truth = scene.sequence().truth[1:, None]
    told, said = overlap(np.array(regions), truth).mean(0)
    assert said > told


@pytest.mark.parametrize("turn, believed", [(np.inf, True), (0.0, False)])
def test_pixels_say_a_turn_where_the_kernels_believe_one(turn, believed):
    path = ((0.0, 150.0, 120.0, 0.0, 1.0), (9.0, 160.0, 120.0, 0.3, 1.0))
    scene = Scene(Layer("car", 80.0, path), length=6)
    truth = scene.sequence().truth[1:]
    runs = steps(Guided(n=50, turn=turn, alike=-1.0), scene)
    for (*_, after, info), true in zip(runs, truth, strict=True):
        kernels, pixels = after.region[THETA], info["region"][THETA]
        assert after.turned == believed
        if believed:
            assert abs(pixels - true[THETA]) < 0.015 and pixels != kernels
        else:
            assert pixels == kernels == pytest.approx(0.0)


@pytest.mark.parametrize("turned", [False, True])
def test_it_starts_where_particles_are_alike_and_near(turned, monkeypatch):
    """Ranked by likeness minus the prior's cost; anywhere, by the likeness alone."""
    tracker, kept = Guided(n=60, starts=3, found=-1.0, place=9.0), []
    over, anywhere = Search.over, Search.anywhere

    def watched(search, prior, starts, free):
        assert free == turned  # as in the frame before
        kept.append((search.image, prior, list(starts)))
        return over(search, prior, starts, free)

    def watched_anywhere(search, prior, known, start):
        kept.append(start)
        return anywhere(search, prior, known, start)

    monkeypatch.setattr(Search, "over", watched)
    monkeypatch.setattr(Search, "anywhere", watched_anywhere)
    state = tracker.init(FRAME, far(0), np.random.default_rng(0))
    state = state._replace(velocity=np.array([15.0, 0.0]), turned=turned)
    regions = tracker.motion.predict(state.particles, np.random.default_rng(7)).regions
    tracker.step(state, FRAME, np.random.default_rng(7))
    (image, prior, starts), start = kept
    likeness = state.coarse.coefficients(image, regions).mean(-1)
    ranked = np.argsort(-(likeness - prior.cost(regions) / 18))[:3]
    np.testing.assert_array_equal(starts, [prior.region, *regions[ranked]])
    np.testing.assert_array_equal(start, regions[np.argmax(likeness)])
    assert ranked[0] != np.argmax(likeness)  # or the prior would not be seen


def test_what_is_reported_of_the_particles_follows_from_their_likeness():
    for before, frame, _, info in steps(Guided(n=50), replace(STANDING, length=3)):
        image = Guided().bins(relit(frame, before.light.gains))
        rho = before.coarse.coefficients(image, info["particles"]).mean(-1)
        np.testing.assert_allclose(info["weights"], rho / rho.sum(), rtol=1e-4)
        size = effective_sample_size(info["weights"])
        assert info["n_eff"] == pytest.approx(size) and 1 < size <= 50
        spread = covariance(info["particles"], info["weights"], info["region"])
        np.testing.assert_allclose(info["covariance"], spread)


def test_a_hidden_target_goes_on_by_nine_tenths_of_its_velocity():
    tracker = Guided(n=50, hidden_above=-1.0)
    state = tracker.init(FRAME, far(0), np.random.default_rng(0))
    state = state._replace(velocity=np.array([10.0, -5.0]))
    _, info = tracker.step(state, FRAME, np.random.default_rng(1))
    np.testing.assert_allclose(info["region"] - state.region, (9, -4.5, 0, 0, 0))


def test_while_it_is_hidden_pixels_say_nothing():
    tracker = Guided(n=50, hidden_above=-1.0, alike=-1.0)
    for _, _, after, info in steps(tracker, replace(MOVING, length=4)):
        np.testing.assert_array_equal(info["region"], after.region)


@pytest.mark.parametrize("renewed", [0.0, 1.0])
def test_particles_that_begin_anew_move_as_the_estimate_does(renewed):
    *_, (_, _, after, _) = steps(Guided(n=50, renewed=renewed), MOVING)
    alike = (after.particles.velocities == after.velocity).all(1)
    assert alike.all() if renewed else not alike.any()


def test_surprise_is_in_half_sides_of_the_target():
    """3 and 4 px off: a tenth of 25 px^2 / (hx hy)."""
    _, state, *_ = told()
    surprise = _surprise(state, displaced(far(0), 3, 4), True)
    assert surprise == pytest.approx(0.1 * 25 / (state.first[3] * state.first[4]))


def test_frames_in_doubt_are_counted_and_light_is_followed_in_others():
    change = ((0.0, 1.0, 1.0, 1.0), (1.0, 0.8, 0.8, 0.8))
    scene = replace(STANDING, light=change, length=4)
    *_, (_, _, doubting, _) = steps(Guided(n=50, doubtful=-1.0, found=-1.0), scene)
    *_, (_, _, sure, _) = steps(Guided(n=50, doubtful=2.0, found=2.0), scene)
    assert (doubting.missed, sure.missed) == (3, 0)
    assert (doubting.light.gains == 1).all() and (sure.light.gains < 0.95).all()


def test_the_optimiser_trusts_kernels_by_their_likeness_and_holds_what_is_known():
    """A post hides a third of the car: what it hides does not pull."""
    tracker, state, prior, _ = told()
    hidden = FRAME.copy()
    hidden[:, 175:230] = 128
    image = tracker.bins(hidden)
    search = tracker._search(state, image)
    here, free = search.closest(prior, far(0.1), True).region, [0, 0]
    for robust in (False, True):
        free[robust] = minimise(
            state.fine, image, far(0.1), 5, robust=robust, prior=prior
        )[0]
    np.testing.assert_array_equal(here, free[True])
    assert not np.allclose(free[True], free[False])
    held = search.closest(prior, displaced(far(0.1), dtheta=0.3), False)
    assert held.region[2] == state.first[2]
    fixed = prior._replace(weights=np.array([1, 1, np.inf, 5]))
    expected, _ = minimise(state.fine, image, far(0.1), 5, robust=True, prior=fixed)
    np.testing.assert_allclose(held.region, expected)


@pytest.mark.parametrize("field", ["coarse", "fine"])
def test_the_name_of_a_layout_is_refused(field):
    with pytest.raises(ValueError, match=f"{field} is of the type str; give Kernels"):
        Guided(**{field: "3x3"})


@pytest.mark.parametrize("field", ["n", "steps"])
def test_without_particles_or_steps_it_is_refused(field):
    with pytest.raises(ValueError, match=field):
        Guided(**{field: 0})
