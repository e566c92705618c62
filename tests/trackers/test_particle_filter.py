"""All trackers obey one protocol, follow an easy scene, and say when they are lost.

They repeat themselves for a seed, and the numbers of an info mean the same for all.
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
import pytest

from mkt.colors import ColorBins
from mkt.evaluation import overlap
from mkt.histograms import learn
from mkt.kernels import Kernels
from mkt.particles import covariance
from mkt.scenes import SCENES
from mkt.scenes.layers import Layer
from mkt.scenes.questions import base, look_alike, occlusion
from mkt.scenes.rendering import Scene
from mkt.trackers import by_name
from mkt.trackers.combined import Combined
from mkt.trackers.guided import Guided
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD
from mkt.tracking import follow, track

TRACKERS = {
    "one kernel": ParticleFilter(n=200, kernels=Kernels("one")),
    "ssd": SSD(),
    "filter": ParticleFilter(n=300),
    "combined": Combined(),
    "guided": Guided(),
}
DECLARED = {"region", "distance", "score", "lost", "evaluations"}
OF_PARTICLES = {"particles", "weights", "covariance", "n_eff"}
FILTERS = {"pf-1", "pf-500", "pf-75", "combined", "guided", "adaptive", "sir", "pfhr"}
AFTER_LIMIT = ("pf-500", "ssd", "combined", "guided", "wm", "camshift", "meanshift")


def short(scene, length=30):
    return replace(scene, length=length).sequence()


def mean_overlap(tracker, clip, seed):
    return overlap(track(tracker, clip, seed).regions, clip.truth).mean()


def behind_gravel(length=16):
    """A wall of gravel passes over the whole image.

    From frame 12 to 15 nothing else can be seen.
    """
    start = (0.0, -1840.0, 120.0, 0.0, 1.0)
    end = (20.0, 1160.0, 120.0, 0.0, 1.0)
    car = Layer("car", 80.0, ((0.0, 160.0, 120.0, 0.0, 1.0),))
    wall = Layer("gravel", 900.0, (start, end))
    return Scene(car, length=length, front=(wall,), shutter=0.0).sequence()


def light(name):
    """The tracker of a name, with few particles where it has any."""
    if name in FILTERS:
        return by_name.with_particles(name, 50)
    return by_name.get(name)


@lru_cache
def infos(name):
    """The infos of a tracker from a target that is seen until it is hidden totally."""
    clip = behind_gravel(5) if name in by_name.SLOW else behind_gravel()
    return list(follow(light(name), clip, seed=1))[1:]


@pytest.mark.parametrize("name", TRACKERS)
def test_the_protocol_and_repeatability(name):
    clip = short(base(0))
    first, again = (track(TRACKERS[name], clip, seed=3) for _ in range(2))
    assert first.regions.shape == (30, 5)
    assert first.score.shape == first.lost.shape == (30,)
    assert (first.regions == again.regions).all() and (first.score == again.score).all()
    assert ((0 <= first.score) & (first.score <= 1)).all()
    assert (first.info["evaluations"][1:] > 0).all()


@pytest.mark.parametrize("name", by_name.TRACKERS)
def test_every_info_has_the_declared_keys(name):
    expected = DECLARED | OF_PARTICLES if name in FILTERS else DECLARED
    for info in infos(name):
        assert expected <= set(info)
        if name not in FILTERS:
            assert not OF_PARTICLES & set(info)


@pytest.mark.parametrize("name", by_name.TRACKERS)
def test_an_info_has_the_same_keys_and_shapes_in_every_frame(name):
    """So a track can hold each as one array, whatever happened in a frame."""
    first, *others = [
        {key: np.shape(value) for key, value in info.items()} for info in infos(name)
    ]
    assert all(shapes == first for shapes in others)
    assert first["region"] == (5,)
    for key in ("distance", "score", "lost", "evaluations"):
        assert first[key] == ()


@pytest.mark.parametrize("name", sorted(FILTERS))
def test_covariance_and_effective_size_are_those_of_the_particles(name):
    """About the estimate that is reported."""
    for info in infos(name):
        particles, weights = info["particles"], info["weights"]
        about = info["region"]
        assert particles.shape == (50, 5) and weights.shape == (50,)
        assert weights.sum() == pytest.approx(1)
        assert info["n_eff"] == pytest.approx(1 / np.sum(weights**2))
        off = particles - about
        off[:, 2] = np.angle(np.exp(1j * off[:, 2]))
        expected = np.einsum("n,ni,nj->ij", weights, off, off)
        np.testing.assert_allclose(info["covariance"], expected, atol=1e-9)


@pytest.mark.parametrize("name", by_name.TRACKERS)
def test_the_score_follows_from_the_distance_by_one_formula(name):
    """As [T09] prints it, whatever lam or sigma the tracker weighs its particles by."""
    for info in infos(name):
        d = info["distance"]
        score = np.exp(-20 * d**2)
        assert info["score"] == pytest.approx(score, rel=1e-6, nan_ok=True)
        assert (0 <= d <= 1) or name == "mil"


def test_the_score_does_not_depend_on_how_a_filter_weighs():
    clip = short(base(0), 5)
    for lam in (1.0, 40.0):
        run = track(ParticleFilter(n=50, lam=lam), clip)
        expected = np.exp(-20 * run.info["distance"][1:] ** 2)
        np.testing.assert_allclose(run.score[1:], expected)


@pytest.mark.parametrize("name", AFTER_LIMIT)
def test_lost_is_said_beyond_a_limit_on_the_distance(name):
    """No limit can be passed at 2, and any distance passes one of -1."""
    clip = behind_gravel(14)
    for limit, lost in ((2.0, False), (-1.0, True)):
        tracker = with_limit(light(name), limit)
        assert (track(tracker, clip, seed=1).lost[1:] == lost).all()


@pytest.mark.parametrize("name", AFTER_LIMIT)
def test_lost_follows_from_the_distance_that_is_reported(name):
    limit = limit_of(by_name.get(name))
    lost = [info["lost"] for info in infos(name)]
    assert lost == [info["distance"] > limit for info in infos(name)]
    assert any(lost) and not all(lost)


def with_limit(tracker, limit):
    """The tracker with another `lost_above`, in both of its parts if it has two."""
    if isinstance(tracker, Combined):
        parts = tracker.filter, tracker.ssd
        inner, ssd = (replace(part, lost_above=limit) for part in parts)
        return replace(tracker, filter=inner, ssd=ssd)
    return replace(tracker, lost_above=limit)


def limit_of(tracker):
    """The `lost_above` of a tracker; that of a combination's two parts is the same."""
    if isinstance(tracker, Combined):
        assert tracker.filter.lost_above == tracker.ssd.lost_above
        return tracker.ssd.lost_above
    return tracker.lost_above


def looks(tracker):
    """The kernels of a tracker; of a combination the filter's, then SSD's."""
    if isinstance(tracker, Combined):
        return [tracker.filter.kernels, tracker.ssd.kernels]
    return [tracker.kernels]


@pytest.mark.parametrize("name", ["pf-500", "pf-1", "sir", "ssd", "combined"])
def test_the_distance_that_is_reported_is_that_of_the_region_that_is_reported(name):
    """Of a combination it is the filter's, or SSD's where it has optimised."""
    clip, tracker = behind_gravel(), light(name)
    bins = tracker.filter.bins if name == "combined" else tracker.bins
    first = bins(clip.frames[0])
    targets = [learn(first, clip.truth[0], kernels) for kernels in looks(tracker)]
    for frame, info in zip(clip.frames[1:], infos(name), strict=True):
        optimised = name == "combined" and info["steps"] > 0
        target = targets[-1] if optimised else targets[0]
        d = target.distances(bins(frame), info["region"])
        assert info["distance"] == pytest.approx(float(d), abs=1e-4)


@pytest.mark.parametrize(
    "name, least",
    [
        ("one kernel", 0.4),
        ("ssd", 0.85),
        ("filter", 0.7),
        ("combined", 0.85),
        ("guided", 0.85),
    ],
)
def test_an_easy_scene_is_followed(name, least):
    overlaps = [
        mean_overlap(TRACKERS[name], short(base(seed), 60), seed) for seed in range(3)
    ]
    assert np.mean(overlaps) > least


@pytest.mark.parametrize("name", TRACKERS)
def test_a_vanished_target_is_said_to_be_lost(name):
    lost = track(TRACKERS[name], behind_gravel(), seed=1).lost
    assert not lost[:9].any() and lost[-3:].all()


def test_the_switch_as_printed_makes_the_combination_a_plain_filter():
    """While the target is seen, "optimise where d_m >= threshold" never optimises.

    With "<=" it always does.
    """
    clip = short(base(1))
    plain, printed, corrected = (
        track(tracker, clip, seed=5)
        for tracker in (Combined().filter, Combined(as_printed=True), Combined())
    )
    assert (printed.regions == plain.regions).all()
    assert (printed.info["steps"][1:] == 0).all()
    assert (corrected.info["steps"][1:] > 0).all()
    iou = [overlap(run.regions, clip.truth).mean() for run in (corrected, plain)]
    assert iou[0] > iou[1]


def test_the_spread_of_a_combination_is_about_the_region_that_it_reports():
    clip, rng = short(base(1), 3), np.random.default_rng(0)
    tracker = Combined()
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    for frame in clip.frames[1:]:
        state, info = tracker.step(state, frame, rng)
        about = covariance(info["particles"], info["weights"], info["region"])
        assert info["steps"] > 0 and (info["covariance"] == about).all()
        looks = tracker.filter.n + 1  # the particles, and their mean
        assert info["evaluations"] == looks + info["steps"]


@pytest.mark.parametrize("as_printed", [False, True])
def test_at_the_threshold_itself_only_the_corrected_switch_optimises(as_printed):
    tracker = Combined(threshold=0.5, as_printed=as_printed)
    assert tracker.optimises(0.5) != as_printed
    assert tracker.optimises(0.49) != as_printed == tracker.optimises(0.51)


@dataclass(frozen=True)
class Counting:
    """Bins that count how often they were asked."""

    bins: ColorBins = ColorBins()
    calls: list = field(default_factory=list, compare=False)

    @property
    def m(self):
        return self.bins.m

    def __call__(self, frame):
        self.calls.append(frame)
        return self.bins(frame)


def test_the_combination_bins_a_frame_once():
    bins = Counting()
    combined = Combined(ParticleFilter(n=75, bins=bins), SSD(bins=bins))
    clip = short(base(1), 6)
    rng = np.random.default_rng(0)
    state = combined.init(clip.frames[0], clip.truth[0], rng)
    for frame in clip.frames[1:]:
        bins.calls.clear()
        state, info = combined.step(state, frame, rng)
        assert info["steps"] > 0 and len(bins.calls) == 1


def test_a_combination_of_other_bins_looks_with_each():
    inner, ssd = Counting(), Counting(ColorBins("rgb"))
    combined = Combined(ParticleFilter(n=75, bins=inner), SSD(bins=ssd))
    clip = short(base(1), 2)
    rng = np.random.default_rng(0)
    state = combined.init(clip.frames[0], clip.truth[0], rng)
    _, info = combined.step(state, clip.frames[1], rng)
    assert info["steps"] > 0 and len(inner.calls) == len(ssd.calls) == 2
    target = learn(ColorBins("rgb")(clip.frames[0]), clip.truth[0], SSD().kernels)
    d = target.distances(ColorBins("rgb")(clip.frames[1]), info["region"])
    assert info["distance"] == pytest.approx(float(d), abs=1e-4)


def scaled(scene, k):
    """The same scene at k times the resolution."""
    path = tuple(
        (t, k * x + (k - 1) / 2, k * y + (k - 1) / 2, angle, size)
        for t, x, y, angle, size in scene.target.path
    )
    target = replace(scene.target, width=k * scene.target.width, path=path)
    size = 320 * k, 240 * k
    return replace(scene, target=target, size=size, zoom=k * scene.zoom)


@pytest.mark.slow
def test_noise_in_units_of_the_target_makes_the_resolution_irrelevant():
    """The same scene at twice the resolution scores within 2 points, over seeds."""

    def mean(k):
        clips = [short(scaled(base(seed), k), 40) for seed in range(4)]
        tracker = ParticleFilter(n=300)
        return np.mean([mean_overlap(tracker, clip, s) for s, clip in enumerate(clips)])

    assert abs(mean(1) - mean(2)) < 0.02


@pytest.mark.slow
def test_nine_kernels_tell_look_alikes_apart():
    """Nine kernels stay with the target, one histogram does less well.

    They move among the same colours in another order and the same item in other
    colours.
    """
    hits = {}
    pairs = ("car", "table"), ("astronaut", "bricks"), ("badge", "gravel")
    for name in ("ssd", "pf-500", "combined", "guided", "camshift", "meanshift"):
        shares = []
        for seed, (item, ground) in enumerate(pairs):
            clip = short(look_alike(seed, item, ground), 90)
            found = track(by_name.get(name), clip, seed).regions
            shares.append(np.mean(overlap(found, clip.truth) > 0.2))
        hits[name] = np.mean(shares)
    assert min(hits[name] for name in ("ssd", "pf-500", "combined", "guided")) >= 0.95
    assert np.mean([hits["camshift"], hits["meanshift"]]) < 0.9


@pytest.mark.slow
@pytest.mark.parametrize("name", TRACKERS)
def test_rotation_and_scale_are_followed(name):
    """Mean overlap of the rotated regions over seeds, 80 % and more with nine."""
    clips = [base(seed, "astronaut", "bricks").sequence() for seed in range(3)]
    means = [mean_overlap(TRACKERS[name], clip, s) for s, clip in enumerate(clips)]
    assert (np.mean(means) >= 0.8) == (name != "one kernel")


@pytest.mark.parametrize("name", SCENES)
def test_scenarios_follow_from_their_arguments(name):
    assert SCENES[name](3) == SCENES[name](3) != SCENES[name](4)
    assert short(SCENES[name](0), 2).visibility[0] > 0.7


@pytest.mark.parametrize("seed", range(4))
def test_the_occlusion_is_total(seed):
    visibility = occlusion(seed).sequence().visibility
    assert (visibility[46:53] < 0.02).all()
    assert visibility[20] > 0.7
    assert visibility[-5:].min() > 0.5


@pytest.mark.parametrize(
    "field, value",
    [
        ("n", 0),
        ("scheme", "lottery"),
        ("combine", "product"),
        ("lam", -1.0),
        ("lam", np.inf),
        ("lam", np.nan),
    ],
)
def test_filters_that_cannot_be_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        ParticleFilter(**{field: value})


def test_a_filter_may_weigh_all_alike_or_by_the_mean():
    assert ParticleFilter(lam=0.0).lam == 0 and ParticleFilter(lam=0.5).lam == 0.5
    assert ParticleFilter(combine="mean").combine == "mean"


def test_the_mean_of_the_kernels_weighs_less_sharply_than_their_sum():
    """Nine kernels: the logarithms of the weights differ by a factor of nine."""
    clip = base(0).sequence()
    image, region = ParticleFilter().bins(clip.frames[0]), clip.truth[0]
    regions = region + np.arange(30)[:, None] * (0.5, 0, 0, 0, 0)
    shapes = {}
    for combine in ("sum", "mean"):
        tracker = ParticleFilter(n=30, combine=combine, lam=2.0)
        state = tracker.init(clip.frames[0], region, np.random.default_rng(0))
        cloud = state.particles._replace(regions=regions)
        weights = tracker.weigh(state.target, image, cloud)
        shapes[combine] = np.log(weights / weights[0])
    ratio = shapes["sum"][5:] / shapes["mean"][5:]
    np.testing.assert_allclose(ratio, 9, rtol=1e-3)


def test_the_defaults_that_are_printed():
    """In Sections IV-B and VI-A of [T09], and in Section 4 of [C14]."""
    plain, sir = ParticleFilter(), by_name.get("sir")
    assert (plain.n, plain.lam, plain.scheme) == (500, 20.0, "multinomial")
    assert plain.kernels == Kernels("tiles", "uniform")
    assert Combined().filter == ParticleFilter(n=75)
    assert [by_name.get(f"pf-{k}").n for k in (1, 500, 75)] == [500, 500, 75]
    assert (sir.n, sir.scheme, sir.bins) == (200, "systematic", ColorBins("hs"))
