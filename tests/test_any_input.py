"""Whatever a tracker is shown, it answers with finite numbers or refuses in a sentence; nothing of OpenCV's or numpy's insides comes up."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mkt.histograms import LONGEST, ColorBins, coefficient, histograms
from mkt.kernels import LAYOUTS, PROFILES, Kernels
from mkt.particles import SCHEMES, Motion
from mkt.trackers import catalogue
from mkt.trackers.adaptive import Adaptive
from mkt.trackers.baselines import CamShift, MeanShift
from mkt.trackers.guided import Guided
from mkt.trackers.hybrid_resampling import HybridResampling
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD

COLORS = {"black": 0, "grey": 128, "white": 255, "red": (255, 0, 0)}
LAYOUTS_IN_MEMORY = {
    "plain": lambda frame: frame,
    "mirrored": lambda frame: frame[::-1, ::-1],
    "BGR seen as RGB": lambda frame: frame[..., ::-1],
    "every second pixel": lambda frame: frame.repeat(2, 0).repeat(2, 1)[::2, ::2],
    "by columns": np.asfortranarray,
    "of another array": lambda frame: np.dstack([frame, frame])[..., 2:5],
}
GOOD = np.array([31.5, 23.5, 0.1, 12.0, 9.0])
BLOCKS = np.random.default_rng(0).integers(0, 256, (6, 8, 3), np.uint8).repeat(8, 0).repeat(8, 1)
FEW = settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])
MOVING = ("region", "estimate", "regions", "samples", "velocity", "velocities", "weights", "particles")  # what of a state a step changes
UNTOLD = {"mil": {"score", "evaluations"}, "camshift": {"evaluations"}, "adaptive": {"rho"}}  # NaN says that there is no such number


def frames(width=st.integers(1, 70), height=st.integers(1, 50)):
    """Frames of any content, size and layout in memory, read-only."""
    def draw(width, height, content, layout, seed):
        noise = np.random.default_rng(seed).integers(0, 256, (height, width, 3), np.uint8)
        frame = LAYOUTS_IN_MEMORY[layout](np.full_like(noise, COLORS[content]) if content in COLORS else noise)
        frame.flags.writeable = False
        return frame

    return st.builds(draw, width, height, st.sampled_from([*COLORS, "noise", "noise"]), st.sampled_from(list(LAYOUTS_IN_MEMORY)), st.integers(0, 99))


def inside(frame):
    """Regions that a tracker could well be started on."""
    height, width = frame.shape[:2]
    return st.tuples(st.floats(0, width - 1), st.floats(0, height - 1), st.floats(-7, 7), st.floats(1, width), st.floats(1, height)).map(np.array)


ANYWHERE = st.lists(st.floats(width=64) | st.floats(-100, 100) | st.sampled_from([0.0, 1e-9, 1e9]), min_size=5, max_size=5).map(np.array)


def told(call):
    """What a call returns, None where it refuses in a sentence that names what is wrong and what to do."""
    try:
        return call()
    except ValueError as error:
        assert type(error) is ValueError
        says = str(error)
        assert any(word in says for word in ("region", "frame", "box", "aspect", "kernel", "estimate", "weights", "shape")), says
        assert any(word in says for word in ("choose", "give", "must", "raise", "make", "bring", "convert", "check", "needed")), says


def finite(name, info):
    """Check that an info holds a region with an area, and no number that is NaN or infinite unless it is documented to be."""
    assert np.shape(info["region"]) == (5,) and info["region"][3] > 0 and info["region"][4] > 0, info["region"]
    for key, value in info.items():
        if not isinstance(value, str) and key not in UNTOLD.get(name, ()):
            assert np.isfinite(np.asarray(value, float)).all(), (key, value)
    if "weights" in info:
        assert info["weights"].sum() == pytest.approx(1) and (info["weights"] >= 0).all()


def walked(name, frame, region, later):
    """Start a tracker and take a step for each later frame, checking what it answers."""
    tracker, rng = catalogue.get(name), np.random.default_rng(0)
    state = told(lambda: tracker.init(frame, region, rng))
    for shown in later if state is not None else ():
        answer = told(lambda: tracker.step(state, shown, rng))
        if answer is None:
            return
        state, info = answer
        finite(name, info)


QUICK = [name for name in catalogue.TRACKERS if name not in catalogue.SLOW]


@pytest.mark.parametrize("name", QUICK)
@FEW
@given(st.data())
def test_frames_of_any_content_and_layout(name, data):
    frame = data.draw(frames())
    same_size = frames(st.just(frame.shape[1]), st.just(frame.shape[0]))
    walked(name, frame, data.draw(inside(frame)), data.draw(st.lists(same_size, min_size=1, max_size=3)))


@pytest.mark.parametrize("name", QUICK)
@FEW
@given(st.data())
def test_frames_that_change_their_size(name, data):
    walked(name, BLOCKS, GOOD, data.draw(st.lists(frames(), min_size=1, max_size=3)))


@pytest.mark.parametrize("name", catalogue.TRACKERS)
@settings(max_examples=40, deadline=None)
@given(region=ANYWHERE)
@pytest.mark.filterwarnings("ignore:overflow")
def test_regions_of_any_numbers(name, region):
    walked(name, BLOCKS, region, () if name in catalogue.SLOW else [BLOCKS])


@pytest.mark.parametrize("name", catalogue.TRACKERS)
@pytest.mark.parametrize("region, said", [
    ([500, 500, 0, 12, 9], "outside"), ([31, 23, 0, 0, 9], "has no area"), ([31, 23, 0, -12, -9], "has no area"), ([np.nan] * 5, "is not finite"),
    ([31, 23, np.nan, 12, 9], "is not finite"), ([31, 23, 12, 9], r"the shape \(..., 5\)"), ([GOOD], "one region"), (None, r"\(cx, cy, theta, hx, hy\)"),
])
def test_a_wrong_region_is_refused_in_a_sentence(name, region, said):
    with pytest.raises(ValueError, match=said):
        catalogue.get(name).init(BLOCKS, region, np.random.default_rng(0))


@pytest.mark.parametrize("name", catalogue.TRACKERS)
@pytest.mark.parametrize("wrong", [
    BLOCKS[:0], BLOCKS[:, :0], BLOCKS[..., 0], np.dstack([BLOCKS, BLOCKS[..., 0]]), BLOCKS / 255, BLOCKS.astype(np.uint16), BLOCKS.astype(int), BLOCKS > 9, None, "a.png",
], ids=["no rows", "no columns", "grey", "four channels", "float", "16 bits", "int", "bool", "None", "name of a file"])
def test_a_wrong_frame_is_refused_at_the_start_and_later(name, wrong):
    tracker, rng = catalogue.get(name), np.random.default_rng(0)
    with pytest.raises(ValueError, match=r"a frame must be \(H, W, 3\) uint8 RGB"):
        tracker.init(wrong, GOOD, rng)
    state = tracker.init(BLOCKS, GOOD, rng)
    with pytest.raises(ValueError, match=r"a frame must be \(H, W, 3\) uint8 RGB"):
        tracker.step(state, wrong, rng)


def broken(state, change):
    """The state with one of its moving arrays changed, once for each."""
    for field in state._fields:
        value = getattr(state, field)
        if field in MOVING and isinstance(value, np.ndarray):
            yield state._replace(**{field: change(value)})
        elif hasattr(value, "_fields"):
            yield from (state._replace(**{field: part}) for part in broken(value, change))


def first_nan(values):
    values = values.copy()
    values.flat[0] = np.nan
    return values


@pytest.mark.parametrize("name", QUICK)
@pytest.mark.parametrize("change", [lambda values: np.full_like(values, np.nan), first_nan], ids=["all NaN", "one NaN"])
def test_a_state_with_nan_never_makes_an_estimate_of_nan(name, change):
    tracker = catalogue.get(name)
    states = list(broken(tracker.init(BLOCKS, GOOD, np.random.default_rng(0)), change))
    assert states
    for state in states:
        answer = told(lambda: tracker.step(state, BLOCKS, np.random.default_rng(0)))
        assert answer is None or np.isfinite(answer[1]["region"]).all()


@pytest.mark.parametrize("name", QUICK)
def test_particles_that_all_left_the_image_are_a_lost_target(name):
    tracker, rng = catalogue.get(name), np.random.default_rng(0)
    away = [state for state in broken(tracker.init(BLOCKS, GOOD, rng), lambda values: values + 1e5 * (values.shape[-1] in (5, 7)))]
    for state in away:
        _, info = tracker.step(state, BLOCKS, rng)
        finite(name, info)
    assert away


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("weights", [np.zeros(4), [0.5, np.nan, 0.5], [1.5, -0.5], [], [np.inf, 1]])
def test_nothing_is_drawn_from_what_is_no_distribution(scheme, weights):
    with pytest.raises(ValueError, match="weights must not be negative, nor all zero, nor NaN"):
        SCHEMES[scheme](weights, np.random.default_rng(0))


class Highest:
    """A generator whose numbers are as near to 1 as they can be."""

    def random(self, n=None):
        return np.full(n, np.nextafter(1, 0)) if n else np.nextafter(1, 0)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_draw_next_to_one_finds_a_particle(scheme):
    assert SCHEMES[scheme](np.full(1000, 1e-3), Highest()).max() < 1000


IMAGE = ColorBins()(BLOCKS)


@settings(max_examples=60, deadline=None)
@given(st.lists(ANYWHERE, max_size=4), st.sampled_from(LAYOUTS), st.sampled_from(PROFILES), frames())
@pytest.mark.filterwarnings("ignore:overflow")
def test_histograms_of_any_regions_sum_to_one_or_nothing(regions, layout, profile, frame):
    q = histograms(ColorBins()(frame), 110, Kernels(layout, profile, samples=300), np.reshape(regions, (-1, 5)))
    total = coefficient(q, q)
    assert q.shape[0] == len(regions) and (np.isclose(total, 1, atol=1e-4) | (total == 0)).all()


@pytest.mark.parametrize("image, m, kernels, region, said", [
    (IMAGE[:0], 110, Kernels(), GOOD, "image must be"), (BLOCKS, 110, Kernels(), GOOD, "image must be"), (IMAGE.astype(int), 110, Kernels(), GOOD, "image must be"),
    (IMAGE / 2, 110, Kernels(), GOOD, "image must be"), (np.zeros((2, LONGEST + 1), np.uint8), 110, Kernels(), GOOD, "image must be"),
    (IMAGE, 5, Kernels(), GOOD, "m is 5, but"), (IMAGE, 0, Kernels(), GOOD, "m is 0, but"), (IMAGE, 256, Kernels(), GOOD, "m is 256, but"),
    (IMAGE, 110, Kernels(samples=60_000), GOOD, "samples is 60000"), (IMAGE, 110, Kernels(), GOOD[:4], "regions must have the shape"),
])
def test_histograms_of_what_is_no_bin_image_are_refused(image, m, kernels, region, said):
    with pytest.raises(ValueError, match=said):
        histograms(image, m, kernels, region)


@pytest.mark.parametrize("space, counts", [("rgb", (40, 40, 40)), ("rgb", (1, 1, 1)), ("hs", (64, 64)), ("hsv", (64, 64, 64))])
def test_bins_at_the_limits_are_numbered_within_them(space, counts):
    bins = ColorBins(space, counts)
    assert bins(BLOCKS).max() < bins.m <= np.iinfo(bins.dtype).max


@pytest.mark.parametrize("make, field", [
    (lambda: ColorBins("rgb", (64, 64, 64)), "counts"), (lambda: ColorBins(s_min=np.nan), "s_min"), (lambda: ColorBins(v_min=-1), "v_min"),
    (lambda: ParticleFilter(n=0), "n"), (lambda: ParticleFilter(n=2.5), "n"), (lambda: ParticleFilter(scheme="best"), "scheme"),
    (lambda: ParticleFilter(combine="product"), "combine"), (lambda: ParticleFilter(lam=np.nan), "lam"), (lambda: SSD(iterations=0), "iterations"),
    (lambda: SSD(spans=()), "spans"), (lambda: SSD(sizes=(0, 1)), "sizes"), (lambda: Guided(n=-3), "n"), (lambda: Guided(fine=()), "fine"),
    (lambda: Guided(steps=0), "steps"), (lambda: Adaptive(n=0), "n"), (lambda: Adaptive(sigma=0), "sigma"), (lambda: HybridResampling(n=0), "n"),
    (lambda: MeanShift(bins=0), "bins"), (lambda: CamShift(bins=0.5), "bins"),
])
def test_a_parameter_that_cannot_be_is_named(make, field):
    with pytest.raises(ValueError, match=rf"^{field} is "):
        make()


def test_a_motion_of_nan_is_said_at_the_first_step():
    tracker = replace(ParticleFilter(n=9), motion=Motion(position=np.nan))
    with pytest.raises(ValueError, match="is not finite; check the state and the tracker's motion"):
        tracker.step(tracker.init(BLOCKS, GOOD, np.random.default_rng(0)), BLOCKS, np.random.default_rng(0))
