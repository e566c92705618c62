"""Whatever a tracker is shown, it answers with finite numbers or refuses in a sentence.

Nothing of OpenCV's or numpy's insides comes up.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mkt.checks import LONGEST
from mkt.colors import BinImage, ColorBins, Joined, JointHSV
from mkt.histograms import coefficient, histograms
from mkt.kernels import LAYOUTS, PROFILES, Kernels
from mkt.particles import SCHEMES, EllipseMotion, Motion
from mkt.trackers import by_name
from mkt.trackers.adaptive import Adaptive
from mkt.trackers.combined import Combined
from mkt.trackers.guided import Guided
from mkt.trackers.homography import PlaneSSD
from mkt.trackers.homography_combined import PlaneCombined
from mkt.trackers.homography_esm import PlaneESM
from mkt.trackers.hybrid_resampling import HybridResampling
from mkt.trackers.opencv import CamShift, MeanShift
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD
from mkt.trackers.template_matching import TemplateMatching
from mkt.trackers.two_cameras import TwoCameras

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
BLOCKS = np.random.default_rng(0).integers(0, 256, (6, 8, 3), np.uint8)
BLOCKS = BLOCKS.repeat(8, 0).repeat(8, 1)
FEW = settings(max_examples=20, suppress_health_check=[HealthCheck.too_slow])
MOVING = (  # what of a state a step changes
    "region",
    "estimate",
    "regions",
    "velocity",
    "velocities",
    "weights",
    "particles",
)
UNTOLD = {  # NaN says that there is no such number
    "mil": {"score", "distance", "evaluations"},
    "camshift": {"evaluations"},
    "adaptive": {"rho"},
}
# What a refusal is about, and what it says that is to be done.
SUBJECTS = "region frame box aspect kernel estimate weights shape".split()
REMEDIES = "choose give must raise make bring convert check needed".split()


WIDTHS, HEIGHTS = st.integers(1, 70), st.integers(1, 50)


def frames(width=WIDTHS, height=HEIGHTS):
    """Frames of any content, size and layout in memory, read-only."""

    def draw(width, height, content, layout, seed):
        rng = np.random.default_rng(seed)
        frame = rng.integers(0, 256, (height, width, 3), np.uint8)
        if content in COLORS:
            frame[:] = COLORS[content]
        frame = LAYOUTS_IN_MEMORY[layout](frame)
        frame.flags.writeable = False
        return frame

    return st.builds(
        draw,
        width,
        height,
        st.sampled_from([*COLORS, "noise", "noise"]),
        st.sampled_from(list(LAYOUTS_IN_MEMORY)),
        st.integers(0, 99),
    )


def inside(frame):
    """Regions that a tracker could well be started on."""
    height, width = frame.shape[:2]
    return st.tuples(
        st.floats(0, width - 1),
        st.floats(0, height - 1),
        st.floats(-7, 7),
        st.floats(1, width),
        st.floats(1, height),
    ).map(np.array)


ANYWHERE = st.lists(
    st.floats(width=64) | st.floats(-100, 100) | st.sampled_from([0.0, 1e-9, 1e9]),
    min_size=5,
    max_size=5,
).map(np.array)


def told(call):
    """What a call returns, None where it refuses in a sentence.

    The sentence must name what is wrong and what to do.
    """
    try:
        return call()
    except ValueError as error:
        assert type(error) is ValueError
        says = str(error)
        assert any(word in says for word in SUBJECTS), says
        assert any(word in says for word in REMEDIES), says


def finite(name, info):
    """Check that an info holds a region with an area, and only finite numbers.

    Those that are documented to be NaN excepted.
    """
    region = info["region"]
    assert np.shape(region) == (5,) and min(region[3:]) > 0, region
    for key, value in info.items():
        if not isinstance(value, str) and key not in UNTOLD.get(name, ()):
            assert np.isfinite(np.asarray(value, float)).all(), (key, value)
    if "weights" in info:
        assert info["weights"].sum() == pytest.approx(1)
        assert (info["weights"] >= 0).all()


def walked(name, frame, region, later):
    """Start a tracker, take a step for each later frame, and check what it answers."""
    tracker, rng = by_name.TRACKERS[name], np.random.default_rng(0)
    state = told(partial(tracker.init, frame, region, rng))
    if state is None:
        return
    for shown in later:
        answer = told(partial(tracker.step, state, shown, rng))
        if answer is None:
            return
        state, info = answer
        finite(name, info)


QUICK = by_name.quick()


@pytest.mark.parametrize("name", QUICK)
@FEW
@given(st.data())
def test_frames_of_any_content_and_layout(name, data):
    frame = data.draw(frames())
    same_size = frames(st.just(frame.shape[1]), st.just(frame.shape[0]))
    region = data.draw(inside(frame))
    later = data.draw(st.lists(same_size, min_size=1, max_size=3))
    walked(name, frame, region, later)


@pytest.mark.parametrize("name", QUICK)
@FEW
@given(st.data())
def test_frames_that_change_their_size(name, data):
    walked(name, BLOCKS, GOOD, data.draw(st.lists(frames(), min_size=1, max_size=3)))


@pytest.mark.parametrize("name", by_name.TRACKERS)
@settings(max_examples=40)
@given(region=ANYWHERE)
@pytest.mark.filterwarnings("ignore:overflow")
def test_regions_of_any_numbers(name, region):
    walked(name, BLOCKS, region, () if name in by_name.SLOW else [BLOCKS])


@pytest.mark.parametrize("name", by_name.TRACKERS)
@pytest.mark.parametrize(
    "region, said",
    [
        ([500, 500, 0, 12, 9], "outside"),
        ([31, 23, 0, 0, 9], "has no area"),
        ([31, 23, 0, -12, -9], "has no area"),
        ([31, 23, 0, 12, 2e154], "larger than any image"),
        ([31, -2e154, 0, 12, 9], "outside"),
        ([np.nan] * 5, "is not finite"),
        ([31, 23, np.nan, 12, 9], "is not finite"),
        ([31, 23, 12, 9], r"the shape \(..., 5\)"),
        ([GOOD], "one region"),
        (None, r"\(cx, cy, theta, hx, hy\)"),
    ],
)
def test_a_wrong_region_is_refused_in_a_sentence(name, region, said):
    with pytest.raises(ValueError, match=said):
        by_name.TRACKERS[name].init(BLOCKS, region, np.random.default_rng(0))


WRONG_FRAMES = {
    "no rows": BLOCKS[:0],
    "no columns": BLOCKS[:, :0],
    "grey": BLOCKS[..., 0],
    "four channels": np.dstack([BLOCKS, BLOCKS[..., 0]]),
    "float": BLOCKS / 255,
    "16 bits": BLOCKS.astype(np.uint16),
    "int": BLOCKS.astype(int),
    "bool": BLOCKS > 9,
    "None": None,
    "name of a file": "a.png",
}


@pytest.mark.parametrize("name", by_name.TRACKERS)
@pytest.mark.parametrize("wrong", WRONG_FRAMES.values(), ids=WRONG_FRAMES)
def test_a_wrong_frame_is_refused_at_the_start_and_later(name, wrong):
    tracker, rng = by_name.TRACKERS[name], np.random.default_rng(0)
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
            for part in broken(value, change):
                yield state._replace(**{field: part})


def all_nan(values):
    return np.full_like(values, np.nan)


def first_nan(values):
    values = values.copy()
    values.flat[0] = np.nan
    return values


@pytest.mark.parametrize("name", QUICK)
@pytest.mark.parametrize("change", [all_nan, first_nan], ids=["all NaN", "one NaN"])
def test_a_state_with_nan_never_makes_an_estimate_of_nan(name, change):
    tracker = by_name.TRACKERS[name]
    states = list(broken(tracker.init(BLOCKS, GOOD, np.random.default_rng(0)), change))
    assert states
    for state in states:
        rng = np.random.default_rng(0)
        answer = told(partial(tracker.step, state, BLOCKS, rng))
        assert answer is None or np.isfinite(answer[1]["region"]).all()


def far_away(values):
    """Places outside the image; velocities and weights as they are."""
    return values + 1e5 * (values.shape[-1] in (5, 7))


@pytest.mark.parametrize("name", QUICK)
def test_particles_that_all_left_the_image_are_a_lost_target(name):
    tracker, rng = by_name.TRACKERS[name], np.random.default_rng(0)
    away = list(broken(tracker.init(BLOCKS, GOOD, rng), far_away))
    for state in away:
        _, info = tracker.step(state, BLOCKS, rng)
        finite(name, info)
    assert away


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize(
    "weights", [np.zeros(4), [0.5, np.nan, 0.5], [1.5, -0.5], [], [np.inf, 1]]
)
def test_nothing_is_drawn_from_what_is_no_distribution(scheme, weights):
    said = "weights must not be negative, NaN, all zero, or none at all"
    with pytest.raises(ValueError, match=said):
        SCHEMES[scheme](weights, np.random.default_rng(0))


class Highest:
    """A generator whose numbers are as near to 1 as they can be."""

    def random(self, n=None):
        return np.full(n, np.nextafter(1, 0)) if n else np.nextafter(1, 0)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_draw_next_to_one_finds_a_particle(scheme):
    assert SCHEMES[scheme](np.full(1000, 1e-3), Highest()).max() < 1000


LABELS = ColorBins()(BLOCKS).labels


@settings(max_examples=60)
@given(
    st.lists(ANYWHERE, max_size=4),
    st.sampled_from(LAYOUTS),
    st.sampled_from(PROFILES),
    frames(),
)
@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value")
def test_histograms_of_any_regions_sum_to_one_or_nothing(
    regions, layout, profile, frame
):
    kernels = Kernels(layout, profile, aspect=1.0, samples=300)
    q = histograms(ColorBins()(frame), kernels, np.reshape(regions, (-1, 5)))
    total = coefficient(q, q)
    assert q.shape[0] == len(regions)
    assert (np.isclose(total, 1, atol=1e-4) | (total == 0)).all()


@pytest.mark.parametrize(
    "labels, m, said",
    [
        (LABELS[:0], 110, "labels must be"),
        (BLOCKS, 110, "labels must be"),
        (LABELS.astype(int), 110, "labels must be"),
        (LABELS / 2, 110, "labels must be"),
        (LABELS.tolist(), 110, "labels must be"),
        (np.zeros((2, LONGEST + 1), np.uint8), 110, "labels must be"),
        (LABELS, 5, "m is 5, but"),
        (LABELS, 0, "m is 0, but"),
        (LABELS, 256, "m is 256, and uint8"),
    ],
)
def test_histograms_of_what_is_no_bin_image_are_refused(labels, m, said):
    with pytest.raises(ValueError, match=said):
        BinImage(labels, m)


@pytest.mark.parametrize(
    "kernels, region, said",
    [
        (Kernels(), GOOD, "not fitted to an object yet"),
        (Kernels(aspect=1.0, samples=60_000), GOOD, "samples is 60000"),
        (Kernels(aspect=1.0), GOOD[:4], "regions must have the shape"),
    ],
)
def test_histograms_of_impossible_kernels_or_regions_are_refused(kernels, region, said):
    with pytest.raises(ValueError, match=said):
        histograms(ColorBins()(BLOCKS), kernels, region)


@pytest.mark.parametrize(
    "space, counts",
    [
        ("rgb", (40, 40, 40)),
        ("rgb", (1, 1, 1)),
        ("hs", (64, 64)),
        ("hsv", (64, 64, 64)),
    ],
)
def test_bins_at_the_limits_are_numbered_within_them(space, counts):
    bins = ColorBins(space, counts)
    labels = bins(BLOCKS).labels
    assert labels.max() < bins.m <= np.iinfo(labels.dtype).max


@pytest.mark.parametrize(
    "make, field",
    [
        (lambda: ColorBins("rgb", (64, 64, 64)), "counts"),
        (lambda: ColorBins(s_min=np.nan), "s_min"),
        (lambda: ColorBins(v_min=-1), "v_min"),
        (lambda: ParticleFilter(n=0), "n"),
        (lambda: ParticleFilter(n=2.5), "n"),
        (lambda: ParticleFilter(scheme="best"), "scheme"),
        (lambda: ParticleFilter(combine="product"), "combine"),
        (lambda: ParticleFilter(lam=np.nan), "lam"),
        (lambda: ParticleFilter(lost_above="far"), "lost_above"),
        (lambda: ParticleFilter(bins="hsv"), "bins"),
        (lambda: SSD(bins=ColorBins), "bins"),
        (lambda: SSD(lost_above=np.nan), "lost_above"),
        (lambda: Combined(threshold=None), "threshold"),
        (lambda: TemplateMatching(lost_above=np.nan), "lost_above"),
        (lambda: PlaneSSD(lost_above=np.nan), "lost_above"),
        (lambda: PlaneSSD(bins=8), "bins"),
        (lambda: PlaneESM(lost_below=np.nan), "lost_below"),
        (lambda: PlaneCombined(threshold=np.nan), "threshold"),
        (lambda: Motion(position=np.nan), "position"),
        (lambda: Motion(damping=1.1), "damping"),
        (lambda: EllipseMotion(axes=-1), "axes"),
        (lambda: EllipseMotion(smallest=0), "smallest"),
        (lambda: SSD(iterations=0), "iterations"),
        (lambda: ColorBins(counts=(10.5, 10, 10)), "counts"),
        (lambda: ColorBins(counts=[10, 10, 10]), "counts"),
        (lambda: JointHSV((64, 64, 64)), "counts"),
        (lambda: JointHSV(8), "counts"),
        (lambda: SSD(spans=()), "spans"),
        (lambda: SSD(spans=(0,)), "spans"),
        (lambda: SSD(spans=1.0), "spans"),
        (lambda: SSD(sizes=(0, 1)), "sizes"),
        (lambda: SSD(sizes=[0.3, 3]), "sizes"),
        (lambda: ColorBins(shift=[0.0, 0.0, 0.0]), "shift"),
        (lambda: PlaneCombined(spread=[0.1]), "spread"),
        (lambda: PlaneCombined(ssd=SSD()), "ssd"),
        (lambda: PlaneCombined(kernels="tiles"), "kernels"),
        (lambda: Adaptive(disc="round"), "disc"),
        (lambda: ParticleFilter(n=True), "n"),
        (lambda: SSD(lost_above=True), "lost_above"),
        (lambda: BinImage(np.zeros((2, 2), np.uint8), "all"), "m"),
        (lambda: Joined(("hsv", "rgb"), (1, 1)), "bins"),
        (lambda: Joined((ColorBins(),), 1), "parts"),
        (lambda: SSD(derivative_of_c="no"), "derivative_of_c"),
        (lambda: Combined(as_printed=None), "as_printed"),
        (lambda: TwoCameras((np.eye(3), np.eye(3)), talking="no"), "talking"),
        (lambda: TwoCameras((np.eye(3), np.eye(3)), "pf-500"), "filter"),
        (lambda: TwoCameras(np.eye(3)), "homographies"),
        (lambda: Guided(n=-3), "n"),
        (lambda: Guided(steps=0), "steps"),
        (lambda: Guided(starts=-1), "starts"),
        (lambda: Guided(renewed=1.5), "renewed"),
        (lambda: Guided(place=-1.0), "place"),
        (lambda: Guided(size=np.inf), "size"),
        (lambda: Guided(widening=np.nan), "widening"),
        (lambda: Guided(hidden_above=np.nan), "hidden_above"),
        (lambda: Guided(alike="much"), "alike"),
        (lambda: Guided(bins="hsv"), "bins"),
        (lambda: Guided(motion=Motion(position=0.0)), "position"),
        (lambda: Adaptive(n=0), "n"),
        (lambda: Adaptive(bins="rgb"), "bins"),
        (lambda: Adaptive(sigma=0), "sigma"),
        (lambda: Adaptive(patience=0), "patience"),
        (lambda: HybridResampling(n=0), "n"),
        (lambda: HybridResampling(spread=-1.0), "spread"),
        (lambda: HybridResampling(level=np.nan), "level"),
        (lambda: HybridResampling(damping=2), "damping"),
        (lambda: HybridResampling(bins=8), "bins"),
        (lambda: HybridResampling(growth=np.inf), "growth"),
        (lambda: MeanShift(bins=0), "bins"),
        (lambda: MeanShift(s_min=np.nan), "s_min"),
        (lambda: CamShift(bins=0.5), "bins"),
    ],
)
def test_a_parameter_that_cannot_be_is_named(make, field):
    with pytest.raises(ValueError, match=rf"^{field} is "):
        make()


def test_a_word_is_told_from_a_number():
    with pytest.raises(ValueError, match="position is '0.06'; it must be a number"):
        Motion(position="0.06")


class Nowhere(Motion):
    """A motion of one's own that goes wrong after the start."""

    def predict(self, particles, rng):
        """All particles are nowhere."""
        return particles._replace(regions=np.nan * particles.regions)

    scatter = Motion().scatter


def test_a_motion_of_nan_is_said_at_the_first_step():
    tracker = replace(ParticleFilter(n=9), motion=Nowhere())
    rng = np.random.default_rng(0)
    state = tracker.init(BLOCKS, GOOD, rng)
    said = "is not finite; check the state and the tracker's motion"
    with pytest.raises(ValueError, match=said):
        tracker.step(state, BLOCKS, rng)
