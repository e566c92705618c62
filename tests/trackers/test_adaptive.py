"""The adaptive colour particle filter: its histograms, equations, modes, learning."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mkt.colors import BinImage, ColorBins, JointHSV
from mkt.evaluation import overlap
from mkt.histograms import coefficient
from mkt.papers.nummiaro2003.claims import student, traffic
from mkt.particles import EllipseMotion, covariance
from mkt.regions import warp
from mkt.scenes.layers import Layer
from mkt.scenes.paths import standing
from mkt.scenes.rendering import Scene, render
from mkt.trackers import appearance
from mkt.trackers.adaptive import (
    INITIALISING,
    TRACKING,
    Adaptive,
    as_regions,
    equivalent_rho,
    upright,
)
from mkt.trackers.detector import moving
from mkt.trackers.ellipses import Disc
from mkt.tracking import track
from tests.strategies import frames

START, END = (0.0, 110.0, 110.0, 0.0, 1.0), (40.0, 190.0, 130.0, 0.0, 1.2)
SCENE = Scene(Layer("car", 80.0, (START, END)), "grass", 40)
ELLIPSES = np.array(
    [
        [120.0, 100.0, 0.0, 40.0, 50.0],
        [160.3, 120.8, 0.0, 45.0, 15.0],
        [80.5, 140.2, 0.0, 12.0, 48.0],
        [5.0, 6.0, 0.0, 30.0, 40.0],
    ]
)


def every_pixel(image, region, elliptic):
    """(3) and (4) as printed: a sum over all pixels inside the ellipse."""
    cx, cy, _, hx, hy = region
    y, x = np.indices(image.shape)
    r2 = ((x - cx) / hx) ** 2 + ((y - cy) / hy) ** 2
    inside = r2 <= 1
    printed = ((x - cx) ** 2 + (y - cy) ** 2) / (hx**2 + hy**2)
    k = 1 - (r2 if elliptic else printed)
    p = np.bincount(image.labels[inside], k[inside], image.m)
    return p / p.sum()


@pytest.mark.parametrize("elliptic", [False, True])
@pytest.mark.parametrize("bins", [ColorBins("rgb"), JointHSV()], ids=["rgb", "hsv"])
def test_the_fixed_grid_stands_for_all_pixels(bins, elliptic):
    """The default grid is close, a dense one as good as exact.

    And it is much closer to its own kernel than to the other one.
    """
    image = bins(render(replace(SCENE, background="workshop"), 5))
    fast, dense = (
        Disc(elliptic, samples).histograms(image, ELLIPSES)
        for samples in (1200, 30_000)
    )
    assert fast.shape == (4, bins.m)
    assert fast.sum(1) == pytest.approx(1, abs=1e-5)
    for p, better, region in zip(fast, dense, ELLIPSES, strict=True):
        exact = every_pixel(image, region, elliptic)
        other = every_pixel(image, region, not elliptic)
        assert 1 - coefficient(p, exact) < 0.06
        assert 1 - coefficient(better, exact) < 2e-3
        assert np.abs(better - exact).sum() < np.abs(better - other).sum() / 2


def one_by_one(image, points, region):
    """(3) with the printed radius, (4), one sample at a time."""
    cx, cy, _, hx, hy = region
    height, width = image.shape
    p = np.zeros(image.m)
    for x, y in points * region[3:]:
        column, row = round(cx + x), round(cy + y)
        if 0 <= column < width and 0 <= row < height:
            p[image.labels[row, column]] += 1 - (x**2 + y**2) / (hx**2 + hy**2)
    return p / p.sum() if p.any() else p


def ellipses_of(seed, n=3):
    """Upright ellipses (n, 5) in and around an image of 64 x 48 pixels."""
    rng = np.random.default_rng(seed)
    places = rng.uniform([-30, -30], [94, 78], (n, 2))
    return np.column_stack([places, np.zeros(n), rng.uniform(0.5, 40, (n, 2))])


@settings(max_examples=60)
@given(frames(), st.integers(0, 2**32 - 1), st.sampled_from([100, 400, 1200]))
def test_mixed_histograms_have_the_printed_radius(frame, seed, samples):
    disc, image, regions = Disc(samples=samples), ColorBins()(frame), ellipses_of(seed)
    points = disc.kernels.points
    off_border = np.abs(warp(regions, points) % 1 - 0.5)
    assume(off_border.min() > 5e-5)  # there single and double precision may differ
    expected = [one_by_one(image, points, region) for region in regions]
    assert disc.histograms(image, regions) == pytest.approx(
        np.array(expected), abs=1e-5
    )


@pytest.mark.parametrize(
    "halves, ends", [((30.0, 30.0), (0.5, 0.5)), ((10.0, 20.0), (0.8, 0.2))]
)
def test_the_printed_radius_leaves_weight_on_the_border(halves, ends):
    """At the ends of both half axes and in the middle."""
    points = np.array([[1.0, 0], [0, 1], [0, 0]])
    shares = np.square(halves) / np.sum(np.square(halves))
    assert shares @ Disc().kernels.weigh(points) == pytest.approx([*ends, 1])
    elliptic = Disc(elliptic=True).kernels.weigh(points)
    assert elliptic == pytest.approx(np.array([[0, 0, 1]]))


def test_outside_the_image_nothing_is_counted():
    image = ColorBins("rgb")(render(SCENE, 0))
    ellipses = np.array([[-200.0, 50, 0, 20, 20], [0.0, 120, 0, 20, 20]])
    outside, half_inside = Disc().histograms(image, ellipses)
    assert not outside.any()
    assert half_inside.sum() == pytest.approx(1, abs=1e-5)


def test_the_motion_is_linear_and_keeps_the_aspect():
    """Without noise: constant velocity, and half axes that keep their first ratio."""
    still, rng = EllipseMotion(0, 0, 0, 0), np.random.default_rng(0)
    particle = np.array([[10.0, 20.0, 1.5, -2.0, 30.0, 40.0, 5.0]])
    moved = still.predict(particle, np.array([30.0, 40.0]), rng)
    assert moved[0] == pytest.approx([11.5, 18, 1.5, -2, 33, 44, 5])
    shrinking = np.array([[0, 0, 0, 0, 5.0, 5.0, -90.0]])
    smallest = still.predict(shrinking, np.ones(2), rng)
    assert smallest[0, 4:6] == pytest.approx([4, 4])


@pytest.mark.parametrize(
    "sigma, density, printed, relative",
    [
        (0.1, 0.970, 0.993, 0.998),
        (0.158, 0.949, 0.9946, 0.9947),
        (0.2, 0.936, np.nan, 0.992),
        (0.5, np.nan, np.nan, 0.947),
    ],
)
def test_what_the_printed_gate_asks_for(sigma, density, printed, relative):
    rho = equivalent_rho(0.9, sigma)
    names = ("density", "printed", "relative", "coefficient")
    expected = [density, printed, relative, 0.9]
    found = [rho[name] for name in names]
    assert found == pytest.approx(expected, abs=6e-4, nan_ok=True)


def test_the_update_is_gated_and_keeps_the_sum():
    tracker, image = Adaptive(alpha=0.3), ColorBins("rgb")(render(SCENE, 0))
    truth = SCENE.sequence().truth[0]
    model = tracker.learn(render(SCENE, 0), truth)
    near, far = truth + [4, 3, 0, 0, 0], truth + [60, 60, 0, 0, 0]
    other, rho = tracker.updated(model, image, near)
    p = tracker.disc.histograms(image, near[None])[0]
    assert rho > tracker.rho_min
    assert other.q == pytest.approx(0.7 * model.q + 0.3 * p, abs=1e-6)
    assert other.q.sum() == pytest.approx(1, abs=1e-5)
    assert tracker.updated(model, image, far)[0] is model
    assert replace(tracker, alpha=0.0).updated(model, image, near)[0] is model


def test_the_background_leaves_out_the_target():
    """On a plain image with one blot, no background ellipse sees the blot."""
    labels = np.zeros((120, 160), np.uint16)
    labels[42:58, 72:88] = 7
    image = BinImage(labels, 512)
    region = np.array([79.5, 49.5, 0.0, 12.0, 12.0])
    without, with_it = (
        appearance.background(Disc(), image, region[3:], where)
        for where in (region, None)
    )
    assert not without[:, 7].any() and with_it[:, 7].any()
    everything = np.array([80.0, 60.0, 0, 160, 120])
    with pytest.raises(ValueError, match="no background"):
        appearance.background(Disc(), image, everything[3:], everything)


def test_the_threshold_is_mean_plus_two_spreads():
    roots = np.sqrt(np.array([[1.0, 0], [0.64, 0.36], [0.36, 0.64]]))
    limit = appearance.threshold(roots, np.array([1.0, 0.0]))
    assert limit == pytest.approx(0.8 + 2 * np.std([1, 0.8, 0.6]))


def test_samples_are_placed_in_their_zones():
    rng, halves = np.random.default_rng(0), np.array([20.0, 30.0])
    zones = "borders", (100.0, 90.0, 5.0, 8.0), "anywhere"
    centres = appearance.place(zones, (240, 320), halves, 3000, rng)
    (x, y), at_door, everywhere = centres[0::3].T, centres[1::3], centres[2::3]
    near = np.array([x <= 20, x >= 299, y <= 30, y >= 209])
    assert near.any(0).all() and (near.mean(1) > 0.1).all()
    assert at_door.mean(0) == pytest.approx([100, 90], abs=1)
    assert at_door.std(0) == pytest.approx([5, 8], rel=0.1)
    assert everywhere.min(0) == pytest.approx([0, 0], abs=5)
    assert everywhere.max(0) == pytest.approx([319, 239], abs=5)


@pytest.mark.parametrize(
    "zones, said",
    [
        ((), "zones is empty"),
        (("doors",), "'doors' is unknown"),
        (((1.0, 2.0),), "unknown"),
    ],
)
def test_unknown_zones_are_named(zones, said):
    with pytest.raises(ValueError, match=said):
        appearance.place(zones, (240, 320), np.ones(2), 10, np.random.default_rng(0))
    with pytest.raises(ValueError, match=said):
        Adaptive(zones=zones)


# The three ways to start, the modes, and what the update is good for; over seeds

ENTRY = (
    (0.0, -45.0, 120.0, 0.0, 1.0),
    (10.0, -38.0, 120.0, 0.0, 1.0),
    (50.0, 60.0, 123.0, 0.0, 1.0),
    (60.0, 80.0, 124.0, 0.0, 1.0),
)
ENTERING = Scene(Layer("car", 70.0, ENTRY), "grass", 60)


def upright_overlap(regions, truth):
    return overlap(regions, truth, upright=True)


@pytest.mark.parametrize("seed", range(3))
def test_by_hand_it_follows_and_repeats_itself(seed):
    clip = replace(SCENE, seed=seed).sequence()
    first, again = (track(Adaptive(), clip, seed) for _ in range(2))
    assert (first.regions == again.regions).all() and not first.lost.any()
    assert upright_overlap(first.regions, clip.truth).mean() > 0.6
    assert (first.info["evaluations"][1:] == 101).all()
    assert ((first.score >= 0) & (first.score <= 1)).all()


@pytest.mark.parametrize("seed", range(3))
def test_from_a_known_histogram_it_waits_at_the_borders(seed):
    clip = replace(ENTERING, seed=seed).sequence()
    rng, tracker = np.random.default_rng(seed), Adaptive(zones=("borders",))
    model = tracker.learn(clip.frames[59], clip.truth[59])
    state = tracker.expect(clip.frames[0], model, rng)
    modes = []
    for frame in clip.frames[1:]:
        state, info = tracker.step(state, frame, rng)
        modes.append(info["mode"])
    started = modes.index(TRACKING)
    assert clip.visibility[started + 1] > 0 and set(modes[started:]) == {TRACKING}
    assert upright_overlap(state.region, clip.truth[59]) > 0.4


@pytest.mark.parametrize("seed", range(3))
def test_from_a_detector_it_starts_on_what_moves(seed):
    clip = replace(SCENE, seed=seed).sequence()
    shown, truth = list(clip.frames), clip.truth
    found = moving(shown[:16])
    assert len(found) == 1 and upright_overlap(found[0], truth[15]) > 0.6
    visible = clip.visibility[15:]
    rest = replace(clip, frames=shown[15:], truth=truth[15:], visibility=visible)
    result = track(Adaptive(), rest, seed, start=found[0])
    assert upright_overlap(result.regions, rest.truth).mean() > 0.5


def test_nothing_moves_in_a_still_scene():
    target = Layer("car", 80.0, standing(150, 120))
    still = replace(SCENE, target=target, length=10).sequence()
    assert moving(list(still.frames)).shape == (0, 5)
    with pytest.raises(ValueError, match="at least two"):
        moving(list(still.frames)[:1])


def test_the_modes_follow_the_couple_of_frames_rule():
    tracker = Adaptive(n=100, b=0.1, patience=3)
    truth = SCENE.sequence().truth[0]
    state = tracker.init(render(SCENE, 0), truth, np.random.default_rng(0))
    modes = []
    for positives in (10, 9, 9, 10, 9, 9, 9, 10, 11):
        state = tracker.switched(state, positives)
        modes.append(state.mode)
    assert modes == [TRACKING] * 6 + [INITIALISING] * 2 + [TRACKING]


@pytest.mark.parametrize("frame", [0, 30])
def test_the_particles_above_the_limit_are_counted(frame):
    """While the car is out of view, and when it has come."""
    tracker, rng = Adaptive(zones=("borders",), alpha=0.0), np.random.default_rng(0)
    clip = ENTERING.sequence()
    model = tracker.learn(clip.frames[59], clip.truth[59])
    before = tracker.expect(clip.frames[0], model, rng)
    after, info = tracker.step(before, clip.frames[frame], rng)
    image = tracker.bins(clip.frames[frame])
    rho = tracker.observe(image, after.particles, model)
    assert info["positives"] == np.sum(rho > before.limit)
    assert info["threshold"] == before.limit
    assert (info["positives"] >= 10) == (frame == 30)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_the_student_is_found_again_and_the_passes_are_bridged(seed):
    run = student(seed)
    assert run["lost"] and run["found"] and run["bridged"] and run["late"] <= 5


@pytest.mark.slow
def test_the_update_helps_where_the_view_changes_and_hurts_where_only_the_scale_does():
    """Over seeds: 20 points more true positives on the van of other colours.

    And a larger error of H_x on the one that only grows.
    """

    def mean(number, alpha, look):
        return np.mean([traffic(seed, alpha, look)[number] for seed in range(2)])

    alpha = Adaptive().alpha
    assert mean("hits", alpha, "fades") > mean("hits", 0.0, "fades") + 0.2
    assert mean("scale", alpha, "same") > mean("scale", 0.0, "same")


# One frame, quantity by quantity.
QUIET = EllipseMotion(position=0.0, velocity=0.0, axes=0.0, growth=0.0)
TURNED = np.array([110.0, 110.0, 0.5, 40.0, 20.0])


@pytest.mark.parametrize("field", ["n", "sigma"])
def test_without_samples_or_spread_it_is_refused(field):
    with pytest.raises(ValueError, match=field):
        Adaptive(**{field: 0})


@pytest.mark.parametrize("field", ["alpha", "rho_min", "b"])
@pytest.mark.parametrize("value", [1.5, -0.1, np.nan])
def test_a_share_beyond_one_is_refused(field, value):
    with pytest.raises(ValueError, match=f"^{field} is "):
        Adaptive(**{field: value})


@given(st.floats(-3, 3), st.floats(5, 60), st.floats(5, 60))
def test_the_upright_ellipse_touches_the_box_of_the_turned_one(theta, hx, hy):
    angle = np.linspace(0, 2 * np.pi, 721)
    outline = warp(
        [[100, 90, theta, hx, hy]], np.stack([np.cos(angle), np.sin(angle)], 1)
    )
    region = upright(np.array([100, 90, theta, hx, hy]))
    assert region[:3].tolist() == [100, 90, 0]
    assert region[3:] == pytest.approx(np.abs(outline[0] - [100, 90]).max(0), rel=1e-3)


def test_a_start_by_hand_has_equal_particles_at_rest_and_no_target_behind():
    tracker, frame = Adaptive(n=20, motion=QUIET), render(SCENE, 0)
    state = tracker.init(frame, TURNED, np.random.default_rng(0))
    box = upright(TURNED)
    for particle in state.particles:
        assert particle == pytest.approx([110, 110, 0, 0, *box[3:], 0])
    assert (state.weights == 1 / 20).all() and (state.region == box).all()
    assert state.mode == TRACKING and state.missing == 0
    image, axes = tracker.bins(frame), box[3:]
    apart, all_of_it = (
        appearance.background(tracker.disc, image, axes, where) for where in (box, None)
    )
    np.testing.assert_array_equal(state.background, apart)
    assert len(apart) < len(all_of_it)
    assert state.limit == appearance.threshold(apart, state.model.q)


def test_who_waits_has_particles_of_one_shape_at_rest():
    tracker, frame = Adaptive(n=50), render(SCENE, 0)
    model = tracker.learn(frame, TURNED)
    state = tracker.expect(frame, model, np.random.default_rng(0))
    x, y, vx, vy, hx, hy, va = state.particles.T
    assert not vx.any() and not vy.any() and not va.any() and np.ptp(hx) > 1
    assert hx / hy == pytest.approx(model.half_axes[0] / model.half_axes[1])
    sides = [hx.mean(), hy.mean()]
    assert state.region == pytest.approx([x.mean(), y.mean(), 0, *sides])
    assert state.mode == INITIALISING and state.missing == 0


@given(st.floats(0.05, 1), st.floats(0, 1), st.floats(0, 1))
def test_two_weights_have_the_printed_ratio(sigma, first, second):
    """(10): exp(-d^2 / (2 sigma^2)) with d^2 = 1 - rho."""
    assume(abs(first - second) < 100 * sigma**2)
    a, b = Adaptive(sigma=sigma).weigh(np.array([first, second]))
    expected = (first - second) / (2 * sigma**2)
    assert np.log(a / b) == pytest.approx(expected, abs=1e-6, rel=1e-6)


def test_while_waiting_only_what_appears_has_weight():
    tracker = Adaptive(n=60, zones=("anywhere",), b=0.0)
    model = tracker.learn(render(SCENE, 20), SCENE.sequence().truth[20])
    before = tracker.expect(render(SCENE, 20), model, np.random.default_rng(0))
    after, info = tracker.step(before, render(SCENE, 20), np.random.default_rng(1))
    image = tracker.bins(render(SCENE, 20))
    rho = tracker.observe(image, after.particles, model)
    np.testing.assert_array_equal(after.weights > 0, rho > before.limit)
    assert 0 < info["positives"] < 60 and info["mode"] == TRACKING
    assert after.missing == 0


def one_step(tracker):
    """The state before and after a frame of tracking, and the info."""
    truth, rng = SCENE.sequence().truth[0], np.random.default_rng(0)
    before = tracker.init(render(SCENE, 0), truth, rng)
    after, info = tracker.step(before, render(SCENE, 1), rng)
    return before, after, info


def test_what_is_learnt_moves_the_limit_of_the_next_frame():
    before, after, info = one_step(Adaptive(n=40, alpha=0.5, rho_min=0.0))
    assert info["updated"] and info["threshold"] == before.limit
    assert not np.array_equal(after.model.q, before.model.q)
    np.testing.assert_array_equal(info["model"], after.model.q)
    assert after.limit == appearance.threshold(after.background, after.model.q)
    assert after.limit != before.limit


def test_what_is_not_learnt_leaves_model_and_limit():
    before, after, info = one_step(Adaptive(n=40, alpha=0.0))
    assert not info["updated"] and after.limit == before.limit
    assert after.model is before.model


def test_the_report_of_a_frame_is_that_of_its_mean_state():
    tracker = Adaptive(n=40, alpha=0.0)
    _, after, info = one_step(tracker)
    image = tracker.bins(render(SCENE, 1))
    p = tracker.disc.histograms(image, info["region"][None])[0]
    rho = float(coefficient(p, after.model.q))
    assert info["rho"] == pytest.approx(rho, abs=1e-6) and 0.5 < rho < 1
    assert info["distance"] == pytest.approx(np.sqrt(1 - rho), abs=1e-6)
    assert not info["lost"] and info["mode"] == TRACKING
    regions, weights = as_regions(after.particles), after.weights
    np.testing.assert_array_equal(info["particles"], regions)
    np.testing.assert_array_equal(info["weights"], weights)
    assert info["n_eff"] == pytest.approx(1 / np.sum(weights**2))
    spread = covariance(regions, weights, info["region"])
    np.testing.assert_allclose(info["covariance"], spread)


def test_who_waits_reports_that_nothing_is_seen():
    tracker = Adaptive(n=40, zones=("borders",), b=1.0)
    model = tracker.learn(render(SCENE, 0), SCENE.sequence().truth[0])
    state = tracker.expect(render(SCENE, 0), model, np.random.default_rng(0))
    after, info = tracker.step(state, render(SCENE, 1), np.random.default_rng(1))
    assert info["lost"] and info["distance"] == 1 and np.isnan(info["rho"])
    assert info["updated"] is False and info["mode"] == INITIALISING
    assert after.missing == 0 and after.limit == state.limit


@pytest.mark.parametrize("half_axes", [(20.0, 10.0), (0.5, 30.0)])
def test_the_background_is_looked_at_on_a_grid_of_its_own_size(half_axes):
    """From the first pixel on, every so many half axes, and not closer than a pixel."""
    image = BinImage(np.zeros((60, 80), np.uint8), 3)
    looked = []

    class Watching(Disc):
        def histograms(self, image, regions):
            looked.append(regions)
            return super().histograms(image, regions)

    appearance.background(Watching(), image, np.array(half_axes))
    columns, rows = (np.unique(looked[0][:, k]) for k in (0, 1))
    for places, side, half in zip((columns, rows), (80, 60), half_axes, strict=True):
        between = max(appearance.EVERY * half, 1)
        np.testing.assert_allclose(places, np.arange(0, side, between))
    assert len(looked[0]) == len(columns) * len(rows)
    assert (looked[0][:, 2:] == (0, *half_axes)).all()


def test_the_background_begins_where_two_ellipses_touch():
    """Half axes 20 and 10 round a target of 30 and 20: 50 along x and 30 along y."""
    image = BinImage(np.zeros((240, 320), np.uint8), 3)
    target, halves = np.array([160.0, 120.0, 0, 30.0, 20.0]), np.array([20.0, 10.0])
    looked = []

    class Watching(Disc):
        def histograms(self, image, regions):
            looked.append(regions)
            return super().histograms(image, regions)

    appearance.background(Watching(), image, halves, target)
    off = (looked[0][:, :2] - target[:2]) / (50, 30)
    r = np.hypot(*off.T)
    assert 1 < r.min() < 1.2


def test_samples_along_the_borders_lie_in_a_band_of_the_target_s_own_width():
    rng, halves = np.random.default_rng(1), np.array([20.0, 5.0])
    x, y = appearance.place(("borders",), (240, 320, 3), halves, 4000, rng).T
    assert x.min() >= 0 and y.min() >= 0 and x.max() <= 319 and y.max() <= 239
    wide, high = appearance.BAND * halves
    upright_band = (x <= wide) | (x >= 319 - wide)
    level_band = (y <= high) | (y >= 239 - high)
    assert (upright_band | level_band).all()
    beside = upright_band & ~level_band  # of 240 px of border on either side
    assert beside.mean() == pytest.approx(240 / 560, abs=0.04)
    deep = np.minimum(x, 319 - x)[beside]
    assert deep.max() > 0.95 * wide and deep.min() < 0.05 * wide


def test_samples_anywhere_are_on_the_image():
    rng = np.random.default_rng(2)
    places = appearance.place(("anywhere",), (2, 3), np.ones(2), 4000, rng)
    assert places.min() >= 0 and (places.max(0) <= (2, 1)).all()
    assert places.max(0) == pytest.approx([2, 1], abs=0.01)
    assert places.min(0) == pytest.approx([0, 0], abs=0.01)


# What moves.
def blots(*boxes, frames=12):
    """Still frames of grey with noise; in the last one squares stand somewhere."""
    rng = np.random.default_rng(0)
    shown = [rng.normal(120, 2, (90, 120, 3)) for _ in range(frames)]
    for x, y, w, h in boxes:
        shown[-1][y : y + h, x : x + w] = 250
    return [np.clip(frame, 0, 255).astype(np.uint8) for frame in shown]


def test_what_moves_is_listed_the_largest_first():
    found = moving(blots((10, 10, 14, 14), (60, 40, 30, 24)))
    assert found.shape == (2, 5)
    np.testing.assert_allclose(found[0], (74.5, 51.5, 0, 15, 12), atol=1)
    np.testing.assert_allclose(found[1], (16.5, 16.5, 0, 7, 7), atol=1)


def test_two_frames_suffice_and_small_parts_are_noise():
    frames = blots((60, 40, 30, 24), frames=2)
    assert len(moving(frames)) == 1
    (found,) = moving(frames)
    area = round(4 * found[3] * found[4])
    assert len(moving(frames, smallest=area - 60)) == 1
    assert len(moving(frames, smallest=area + 1)) == 0


def test_specks_are_removed_and_parts_of_one_object_are_joined():
    frames = blots((20, 20, 1, 60), (60, 40, 12, 24), (75, 40, 12, 24))
    assert len(moving(frames, smallest=20)) == 1
