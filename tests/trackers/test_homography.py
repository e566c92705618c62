"""SSD on homographies: derivatives, the similarity as an oracle, cards in space."""

import numpy as np
import pytest

from mkt.colors import ColorBins, Joined
from mkt.edges import EdgeBins
from mkt.histograms import distance, learn, sample, turned
from mkt.homographies import (
    PARAMETERS,
    angles,
    corner_error,
    moved,
    of_regions,
    through,
)
from mkt.kernels import Kernels
from mkt.regions import displaced
from mkt.scenes.cards import card
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene, homographies
from mkt.trackers import homography, newton
from mkt.trackers.homography import (
    NEARLY,
    SHORT,
    PlaneSSD,
    columns,
    columns_at,
    felt,
    jacobian,
    minimise,
    plausible,
    step_from,
)
from mkt.trackers.homography_combined import PlaneCombined
from mkt.trackers.homography_esm import PlaneESM
from mkt.tracking import track

HALF_SIDES = np.array([1.25, 0.8])
SEEN = of_regions([160.0, 120.0, 0.3, 50.0, 32.0])
TILTED = moved(SEEN, np.array([0, 0, 0, 0, 0.05, -0.1, 0.3, -0.2]), HALF_SIDES)
RGB = ColorBins("rgb", (5, 5, 5))


def disc(centre, radius, rings=24, spokes=64):
    """Points (n, 2) and weights that integrate over a disc; Gauss times trapezium."""
    node, weight = np.polynomial.legendre.leggauss(rings)
    r, w = radius * (node + 1) / 2, radius * weight / 2
    phi = 2 * np.pi * np.arange(spokes) / spokes
    rays = np.stack([np.cos(phi), np.sin(phi)], -1)
    points = centre + (r[:, None, None] * rays).reshape(-1, 2)
    return points, np.repeat(r * w, spokes) * 2 * np.pi / spokes


def memberships(points):
    """How much points (n, 2) of the image belong to each of three soft bins."""
    x, y = points.T
    waves = np.stack([np.sin(0.05 * x + 0.02 * y), np.cos(0.07 * y), 0 * x])
    exponentials = np.exp(waves)
    return exponentials / exponentials.sum(0)


@pytest.mark.parametrize("k", range(8))
@pytest.mark.parametrize("homography", [SEEN, TILTED], ids=["facing", "tilted"])
def test_columns_are_the_derivative_of_a_histogram_of_soft_bins(homography, k):
    """Where bins are smooth and integrals exact, differences agree to 1e-7."""
    centre, radius, h = np.array([0.45, -0.2]), 0.5, 1e-4
    points, area = disc(centre, radius)
    off = points - centre
    weights = 1 - (off**2).sum(-1) / radius**2
    slopes = np.moveaxis(-2 * off / radius**2, -1, 0)[:, None]
    by = columns_at(weights[None], slopes, points, 8)[1 + k, 0]
    derivative = memberships(through(homography, points / HALF_SIDES)) @ (by * area)

    def histogram(x):
        there = moved(homography, x * np.eye(8)[k], HALF_SIDES)
        return memberships(through(there, points / HALF_SIDES)) @ (weights * area)

    differences = (histogram(h) - histogram(-h)) / (2 * h)
    assert np.abs(derivative).max() > 1e-3
    assert np.abs(differences - derivative).max() < 1e-7 * max(1, np.abs(by).max())


@pytest.fixture(scope="module")
def car():
    """The bins of a frame, and the target learnt in it."""
    scene = Scene(Layer("car", 96.0, ((0.0, 160.0, 120.0, 0.3, 1.0),)), length=2)
    clip = scene.sequence()
    both = Joined((ColorBins(), EdgeBins()), (2, 1))
    images = [bins(clip.frames[1]) for bins in (ColorBins(), both)]
    kernels = Kernels("3x3", samples=2400)
    return clip.truth[0], [(i, learn(i, clip.truth[0], kernels)) for i in images]


@pytest.mark.parametrize("bins", [0, 1], ids=["colours", "and edges"])
def test_four_parameters_make_the_similaritys_step(car, bins):
    """Its own template, and its own formula for C: the same step to the last digits."""
    region, targets = car
    image, target = targets[bins]
    start = displaced(region, 5, -3, 0.1, 1.1)
    by = columns(target.kernels, "similarity")
    q, dq = newton.differentiate(target, image, of_regions(start), columns=by)
    wanted_q, wanted = newton.differentiate(target, image, start)
    assert np.allclose(q, wanted_q, atol=1e-12)
    assert np.allclose(dq, wanted, atol=1e-11)
    step = newton.newton_step(q, dq, target.q)
    there = moved(of_regions(start), 0.1 * step, target.kernels.half_sides)
    # One turns while it shifts, the other afterwards: the same to first order.
    other = of_regions(newton.moved(start, 0.1 * step))
    assert corner_error(there, other) < 0.01 * corner_error(there, of_regions(start))


def test_groups_are_nested(car):
    target = car[1][0][1]
    full = columns(target.kernels, "homography")
    for group in ("similarity", "affine"):
        part = columns(target.kernels, group)
        assert (part == full[:, : part.shape[1]]).all()


def test_nine_kernels_feel_all_eight_and_one_no_turn(car):
    region, ((image, _), _) = car
    seen, strengths = of_regions(region), {}
    for layout in ("one", "3x3"):
        target = learn(image, region, Kernels(layout, samples=4800))
        strengths[layout] = felt(target, image, seen, "homography")
        values = np.linalg.svd(
            jacobian(target, image, seen, "homography"), compute_uv=False
        )
        assert (values[-1] < 1e-9) == (layout == "one")
        # No column can be shorter than the shortest image of a unit step.
        assert (strengths[layout] >= values[-1] - 1e-9).all()
    assert strengths["one"][2] < 1e-9 < 0.1 < strengths["3x3"].min()


@pytest.mark.parametrize("function", [felt, jacobian, step_from])
def test_an_unknown_group_is_refused(function, car):
    region, ((image, _), _) = car
    target = learn(image, region, Kernels("3x3"))
    with pytest.raises(ValueError, match="group is 'nope'; it must be one of simil"):
        function(target, image, of_regions(region), "nope")


def test_only_the_homography_finds_a_tilt():
    scene = card("base", 1)
    clip, truth = scene.sequence(), homographies(scene, scene.target, np.arange(120))
    found = {}
    for group in ("similarity", "affine", "homography"):
        tracker = PlaneSSD(group=group)
        run = track(tracker, clip.part(slice(50)))
        found[group] = np.median(corner_error(run.info["homography"][1:], truth[1:50]))
    assert found["homography"] < 1.5 < found["affine"] < found["similarity"]


@pytest.mark.parametrize("tracker", [PlaneSSD(), PlaneCombined(), PlaneESM()], ids=type)
def test_trackers_of_planes_follow_a_card(tracker):
    scene = card("base", 2)
    clip, truth = scene.sequence(), homographies(scene, scene.target, np.arange(120))
    first = clip.part(slice(40))
    runs = [track(tracker, first, seed=3) for _ in range(2)]
    error = corner_error(runs[0].info["homography"][1:], truth[1:40])
    assert np.median(error) < 1.5 and error.max() < 5
    assert not runs[0].lost.any()
    assert (runs[0].regions == runs[1].regions).all()


@pytest.mark.parametrize("tracker", [PlaneSSD(), PlaneCombined(), PlaneESM()], ids=type)
def test_a_card_that_is_gone_is_said_to_be_lost(tracker):
    scene = card("base", 2)
    frames, rng = scene.sequence().frames, np.random.default_rng(0)
    state = tracker.init(frames[0], scene.sequence().truth[0], rng)
    noise = rng.integers(0, 256, frames[0].shape, dtype=np.uint8)
    _, info = tracker.step(state, noise, rng)
    assert info["lost"] and np.isfinite(info["homography"]).all()


def test_a_result_that_no_camera_could_see_is_left():
    assert plausible(TILTED, SEEN)
    steep = moved(SEEN, np.array([0, 0, 0, 0, 0, 0, 0.9, 0]), HALF_SIDES)
    large = moved(SEEN, np.array([0, 0, 0, 2.0]), HALF_SIDES)
    assert not plausible(steep, SEEN) and not plausible(large, SEEN)


def test_minimise_stops_at_the_truth():
    clip = card("base", 3).sequence()
    image = RGB(clip.frames[0])
    target = learn(image, clip.truth[0], Kernels("5x5", samples=4800))
    start = of_regions(clip.truth[0])
    step = step_from(target, image, start, "homography")
    found, steps = minimise(target, image, start, 10, "homography")
    assert np.abs(step).max() < 1e-6 and steps == 1
    assert corner_error(found, start) < 1e-3


def test_the_first_pass_ends_near_and_the_last_one_there():
    clip = card("base", 3).sequence()
    tracker, rng = PlaneSSD(iterations=30), np.random.default_rng(0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    image = tracker.bins(clip.frames[20])
    wide, small = state.targets
    near, few = minimise(wide, image, state.homography, 30, "homography", NEARLY)
    _, all_the_way = minimise(wide, image, state.homography, 30, "homography", SHORT)
    found, steps = minimise(small, image, near, 30, "homography", SHORT)
    assert few < all_the_way and steps > 1  # so which of the two ends where is seen
    refined, _, taken = tracker.refine(state, image, state.homography)
    assert taken == few + steps
    np.testing.assert_allclose(refined, found)


@pytest.mark.parametrize(
    "make, said",
    [
        (lambda: PlaneSSD(group="euclidean"), "group"),
        (lambda: PlaneSSD(passes=()), "passes"),
        (lambda: PlaneSSD(passes=("3x3",)), "passes is of the type str"),
        (lambda: PlaneSSD(passes=Kernels("3x3")), "passes"),
        (lambda: PlaneSSD(iterations=0), "iterations"),
        (lambda: PlaneCombined(spread=()), "spread"),
        (lambda: PlaneCombined(spread=(-1.0,)), "spread"),
        (lambda: PlaneCombined(spread=("a",) * 4), "spread"),
        (lambda: PlaneCombined(spread=0.5), "spread"),
        (lambda: PlaneESM(blurs=(4,)), "blurs"),
        (lambda: card("fog", 0), "kind"),
    ],
)
def test_what_cannot_be_is_refused(make, said):
    with pytest.raises(ValueError, match=said):
        make()


# What kernels feel, what a camera could see, and what is reported.
def test_the_jacobian_of_a_similarity_is_that_of_the_root_of_the_mean_distance():
    """By the optimiser of chapter 4: d sqrt(q) over the root of the kernels."""
    clip = card("base", 3).sequence()
    image, region = RGB(clip.frames[0]), clip.truth[0]
    target = learn(image, region, Kernels("3x3", samples=2400))
    q, dq = newton.differentiate(target, image, region)
    seen = q > newton.EMPTY
    expected = dq[seen] / (2 * np.sqrt(q[seen])[:, None]) / 3
    found = jacobian(target, image, of_regions(region), "similarity")
    np.testing.assert_allclose(found, expected, atol=1e-9)
    wider = jacobian(target, image, of_regions(region), "homography")
    assert wider.shape == (len(expected), 8)
    np.testing.assert_allclose(wider[:, :4], expected, atol=1e-9)


@pytest.mark.parametrize("k, name", [*enumerate(PARAMETERS)])
def test_directions_turn_with_whatever_turns_a_plane(k, name):
    """By central differences, through weights that move over fixed labels."""
    clip = card("base", 3).sequence()
    image, region = EdgeBins()(clip.frames[0]), clip.truth[0]
    target = learn(image, region, Kernels("3x3", samples=2400))
    sides, by = target.kernels.half_sides, columns(target.kernels, "homography")
    here = moved(of_regions(region), np.array([0, 0, 0.2, 0, 0.1, 0.2, 0.1, 0]), sides)
    counts = newton.count(target, sample(image, target.kernels, here), by)
    _, dq = newton.differentiate(target, image, here, columns=by)

    def seen(x):
        now = counts[..., 0] + x * counts[..., 1 + k]
        there = moved(here, x * np.eye(8)[k], sides)
        turned(now[None], angles(there[None]), image.compasses[0])
        return now / now.sum(-1, keepdims=True)

    wanted = (seen(1e-5) - seen(-1e-5)) / 2e-5
    np.testing.assert_allclose(dq[..., k], wanted, atol=1e-7, err_msg=name)


@pytest.mark.parametrize(
    "growth, seen", [(3.9, True), (4.1, False), (1 / 7.9, True), (1 / 8.1, False)]
)
def test_an_object_is_at_most_four_times_as_large_and_eight_times_as_small(
    growth, seen
):
    here = moved(SEEN, np.array([0, 0, 0, np.log(growth)]), HALF_SIDES)
    assert plausible(here, SEEN) == seen


@pytest.mark.parametrize("tilt, seen", [(0.65, True), (0.85, False)])
def test_no_corner_of_an_object_is_at_the_horizon(tilt, seen):
    """The depth of its nearest corner is 1 - tilt."""
    away = np.array([[1.0, 0, 0], [0, 1, 0], [tilt, 0, 1]])
    assert plausible(SEEN @ away, SEEN) == seen


@pytest.mark.parametrize("stretch, seen", [(1.35, True), (1.45, False)])
def test_an_object_is_not_drawn_out_to_a_needle(stretch, seen):
    """By e^x along one axis and e^-x along the other: four times is ln 4 = 1.39."""
    here = moved(SEEN, np.array([0, 0, 0, 0, stretch]), HALF_SIDES)
    assert plausible(here, SEEN) == seen


def test_a_plane_is_reported_with_its_own_aspect():
    clip = card("base", 2).sequence()
    for tracker in (PlaneSSD(), PlaneCombined(n=20)):
        rng = np.random.default_rng(0)
        state = tracker.init(clip.frames[0], clip.truth[0], rng)
        _, info = tracker.step(state, clip.frames[0], rng)
        np.testing.assert_allclose(info["region"], clip.truth[0], atol=1.5)
        assert {"steps", "homography"} <= set(info) and info["steps"] >= 2


def test_steps_of_all_passes_are_counted_and_the_last_pass_says_the_distance():
    clip = card("base", 3).sequence()
    tracker, rng = PlaneSSD(iterations=1), np.random.default_rng(0)
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    image = tracker.bins(clip.frames[10])
    found, d, steps = tracker.refine(state, image, state.homography)
    assert steps == 2
    coarse, fine = (t.coefficients(image, found[None])[0] for t in state.targets)
    assert d == pytest.approx(float(distance(fine, -1)), abs=1e-3)
    assert abs(d - float(distance(coarse, -1))) > 0.01


def test_an_optimiser_of_planes_takes_as_many_steps_as_it_may_and_bounds_them(
    monkeypatch,
):
    clip = card("base", 3).sequence()
    image, start = RGB(clip.frames[0]), of_regions(clip.truth[0])
    target = learn(image, clip.truth[0], Kernels("3x3", samples=1600))
    large = np.array([2.0, -2.0, 0.1, -0.1, 0, 0, 0, 0])
    monkeypatch.setattr(homography, "step_from", lambda *_: large)
    bounded, place = np.array([0.5, -0.5, 0.1, -0.1, 0, 0, 0, 0]), start
    for allowed in (1, 2, 3):
        found, taken = minimise(target, image, start, allowed, "homography")
        place = moved(place, bounded, target.kernels.half_sides)
        np.testing.assert_allclose(found, place)
        assert taken == allowed


def test_a_step_trusts_each_kernel_of_a_plane_by_its_likeness():
    """Grey over a part of the card: the kernels there have no word."""
    clip = card("base", 3).sequence()
    target = learn(RGB(clip.frames[0]), clip.truth[0], Kernels("3x3", samples=2400))
    hidden = clip.frames[0].copy()
    x, y = clip.truth[0][:2].astype(int)
    hidden[:, x + 10 :] = 128
    image, here = RGB(hidden), of_regions(clip.truth[0])
    q, dq = newton.differentiate(
        target, image, here, columns=columns(target.kernels, "affine")
    )
    rho = np.sum(np.sqrt(q * target.q), -1)
    expected = newton.newton_step(q, dq, target.q, rho**8)
    np.testing.assert_allclose(
        step_from(target, image, here, "affine"), expected, rtol=1e-4, atol=1e-7
    )
    assert not np.allclose(expected, newton.newton_step(q, dq, target.q), rtol=1e-2)


def test_an_optimiser_that_ends_where_no_camera_could_stand_has_not_moved(monkeypatch):
    clip = card("base", 3).sequence()
    tracker = PlaneSSD()
    state = tracker.init(clip.frames[0], clip.truth[0], np.random.default_rng(0))
    image, start = tracker.bins(clip.frames[0]), state.homography
    huge = moved(start, np.array([0, 0, 0, 2.0]), HALF_SIDES)
    monkeypatch.setattr(homography, "minimise", lambda *_: (huge, 3))
    found, d, steps = tracker.refine(state, image, start)
    np.testing.assert_array_equal(found, start)
    assert d < 0.1 and steps == 3 * len(state.targets)


def test_a_plane_is_not_sought_in_an_image_of_other_bins(car):
    region, ((fewer, _), (_, target)) = car
    with pytest.raises(ValueError, match="the image has 110 bins, but the reference"):
        minimise(target, fewer, of_regions(region), 3, "homography")


def test_what_no_camera_could_see_leaves_the_start_and_not_the_first_place(monkeypatch):
    clip = card("base", 2).sequence()
    tracker = PlaneSSD(iterations=1)
    state = tracker.init(clip.frames[0], clip.truth[0], np.random.default_rng(0))
    start = of_regions(displaced(clip.truth[0], 5, 3))
    monkeypatch.setattr(homography, "plausible", lambda *_: False)
    found, _, _ = tracker.refine(state, tracker.bins(clip.frames[0]), start)
    assert (found == start).all()
