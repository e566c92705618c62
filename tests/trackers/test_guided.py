"""Gains that follow the light and nothing else; and what the guided tracker reports."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mkt.colors import ColorBins
from mkt.evaluation import overlap
from mkt.histograms import counts, learn
from mkt.kernels import Kernels
from mkt.regions import displaced
from mkt.scenes.rendering import Layer, Scene
from mkt.trackers.close_up import close_up
from mkt.trackers.gains import BOUNDS, first_light, followed, relit
from mkt.trackers.guided import FULL_GRID, Guided

BINS = ColorBins()
CAR = Layer("car", 80.0, ((0.0, 159.5, 119.5, 0.2, 1.0),))
SPECIFICATION = Scene(CAR, length=30)
FRAME = SPECIFICATION.sequence().frames[0]


def begin(scene=SPECIFICATION):
    clip = scene.sequence()
    frame, region = clip.frames[0], clip.truth[0]
    target = learn(BINS(frame), region, Kernels("3x3"))
    return clip, first_light(target, BINS, frame, region)


def follow_on_the_truth(clip, light):
    for frame, region in zip(clip.frames, clip.truth, strict=True):
        light = followed(light, frame, region)
    return light


@given(st.integers(0, 255), st.floats(0.3, 3))
def test_a_gain_is_divided_out(value, gain):
    pixels = np.full((1, 1, 3), value, np.uint8)
    assert (relit(pixels, np.ones(3)) == value).all()
    relit_value = int(relit(pixels, np.full(3, gain))[0, 0, 0])
    assert abs(relit_value - min(value / gain, 255)) <= 1


@pytest.mark.parametrize("gains", [(0.6, 0.6, 0.6), (0.75, 0.9, 1.1)])
def test_finds_the_gains_of_a_new_light(gains):
    """Within 7 % after 29 frames under another light, at the true place."""
    change = ((0.0, 1.0, 1.0, 1.0), (1.0, *gains))
    light = follow_on_the_truth(*begin(replace(SPECIFICATION, light=change)))
    assert np.abs(np.log(light.gains / gains)).max() < 0.07


def test_stays_when_the_light_stays():
    light = follow_on_the_truth(*begin())
    assert np.abs(np.log(light.gains)).max() < 0.05


def test_does_not_take_the_background_for_the_object():
    """Beside the object no gains make the background look like it.

    The reference stays, and the likeness there stays low.
    """
    clip, light = begin()
    beside = displaced(clip.truth[0], 100, 60)
    for frame in clip.frames:
        light = followed(light, frame, beside)
    image = BINS(relit(clip.frames[0], light.gains))
    there, here = light.target.distances(image, np.stack([beside, clip.truth[0]]))
    assert (light.gains >= BOUNDS[0]).all() and (light.gains <= BOUNDS[1]).all()
    assert here < there


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
    return replace(SPECIFICATION, length=14, front=front, shutter=0.0)


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
    for _, _, after, info in steps(tracker, replace(SPECIFICATION, length=3)):
        assert (after.particles.regions == info["region"]).all()
        assert np.ptp(info["particles"][:, 0]) > 1


def test_the_cost_is_in_regions_looked_at_with_the_full_grid():
    tracker = Guided(n=50)
    for _, _, after, info in steps(tracker, replace(SPECIFICATION, length=4)):
        coarse, closest = after.coarse.kernels, after.fine.kernels
        samples = 50 * len(coarse.points) + info["steps"] * len(closest.points)
        assert info["evaluations"] == pytest.approx(samples / FULL_GRID)


@pytest.mark.parametrize("hidden_above, hidden", [(2.0, False), (-1.0, True)])
def test_while_it_is_hidden_no_particle_comes_back(hidden_above, hidden):
    tracker = Guided(n=50, renewed=1.0, hidden_above=hidden_above)
    for _, _, after, info in steps(tracker, replace(SPECIFICATION, length=4)):
        anew = (after.particles.regions == info["region"]).all()
        assert anew == (not hidden)


@pytest.mark.parametrize("lost_above, lost", [(2.0, False), (-1.0, True)])
def test_the_flag_is_a_threshold_that_changes_nothing_else(lost_above, lost):
    scene = replace(SPECIFICATION, length=4)
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
    tracker, clip = Guided(n=50, sure=sure), SPECIFICATION.sequence()
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


@given(
    st.tuples(st.floats(-300, 600), st.floats(-300, 600)),
    st.floats(2, 300),
    st.integers(1, 9),
)
def test_a_close_up_shows_what_the_whole_frame_does(place, size, pitch):
    """At the scale of the frame exactly; else wherever it lies, without an error."""
    region = np.array([[*place, 0.2, size, size]])
    image = close_up(BINS, FRAME, np.ones(3), region, pitch)
    kernels = Kernels("tiles", "uniform", aspect=1.0)
    assert np.isfinite(counts(image, kernels, region)).all()
    if pitch == 1:
        whole = counts(BINS(FRAME), kernels, region)
        np.testing.assert_array_equal(counts(image, kernels, region), whole)
