"""The engine of the pages says what Python says."""

import base64

import cv2
import numpy as np
import pytest
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st
from scipy.signal import dlsim
from scipy.stats import kstest

from mkt.colors import SPACES, ColorBins
from mkt.evaluation import errors, overlap, success
from mkt.histograms import coefficient, histograms, learn
from mkt.kernels import Kernels
from mkt.papers.lessons import beats
from mkt.particles import SCHEMES
from mkt.regions import as_regions, displaced, warp_matrices
from mkt.scenes.rendering import regions as regions_of
from mkt.scenes.teuliere2009 import hidden
from mkt.servoing.poles import closed_loop, one_feature
from mkt.servoing.self_motion import Kalman
from mkt.trackers.combined import Combined
from mkt.trackers.newton import differentiate, moved, newton_path, newton_step
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD
from mkt.tracking import track
from tests.live.conftest import ENGINE, Recorded, assert_found, picture
from tests.strategies import frames, regions

CLOSE = 1e-5
LAYOUTS = ("one", "2x2", "3x3", "4x4", "cut", "tiles")
TIE = 3e-5  # [px] nearer than this to the middle of two pixels either may be taken

# A fault is not shrunk: each smaller case would be a call more, and none is clearer.
# The same cases each time, so that a planted fault is found each time.
few = settings(
    max_examples=60, deadline=None, phases=[Phase.generate], derandomize=True
)


@st.composite
def kernels(draw, profiles=("epanechnikov", "uniform"), layouts=LAYOUTS):
    """Kernels, and the same in the engine's words."""
    spec = {
        "layout": draw(st.sampled_from(layouts)),
        "profile": draw(st.sampled_from(profiles)),
        "span": draw(st.floats(0.7, 1.4)),
        "elliptic": draw(st.booleans()),
        "samples": draw(st.integers(200, 800)),
    }
    return Kernels(**spec), spec


def inside():
    """Regions whose kernels all see something of a frame of 64 x 48 pixels."""
    numbers = (10, 54), (10, 38), (-7, 7), (6, 20), (6, 20)
    return st.tuples(*(st.floats(*each) for each in numbers)).map(np.array)


def decided(kernels, *places):
    """Whether no sample of some regions lies between two pixels."""
    matrices = warp_matrices(as_regions(places)).reshape(-1, 3)
    points = matrices @ np.vstack([kernels.points.T, np.ones(len(kernels.points))])
    return bool((np.abs(points - np.floor(points) - 0.5) > TIE).all())


@few
@given(frames(), st.sampled_from(list(SPACES)), st.floats(0, 1), st.floats(0, 1))
def agrees_on_bins(engine, frame, space, s_min, v_min):
    bins = ColorBins(space, s_min=s_min, v_min=v_min)
    found = engine(
        "const { labels, m } = live.colorBins(data.options)(picture(data.frame));"
        "return { labels, m };",
        frame=picture(frame),
        options={"space": space, "sMin": s_min, "vMin": v_min},
    )
    assert found["m"] == bins.m
    assert found["labels"] == bins(frame).labels.ravel().tolist()


def test_bins_of_every_hue_and_saturation(engine):
    colours = np.stack(np.meshgrid(*[np.arange(0, 256, 3)] * 3), -1)
    frame = colours.reshape(86, -1, 3).astype(np.uint8)
    for space in SPACES:
        agrees = engine(
            "const { labels } = live.colorBins(data.options)(picture(data.frame));"
            "return labels;",
            frame=picture(frame),
            options={"space": space},
        )
        assert agrees == ColorBins(space)(frame).labels.ravel().tolist()


LOOK = """
const image = live.colorBins()(picture(data.frame));
const kernels = live.fitted(data.spec, data.learnt);
return data.regions.map((region) => live.histograms(image, kernels, region));
"""


@few
@given(frames(), kernels(), inside(), st.lists(regions(), min_size=1, max_size=3))
def agrees_on_histograms(engine, frame, both, learnt, places):
    spec, words = both
    fitted = spec.fitted(learnt)
    try:
        assert len(fitted.weights)
    except ValueError:
        assume(False)
    assume(decided(fitted, *places))
    wanted = histograms(ColorBins()(frame), fitted, places)
    found = engine(
        LOOK,
        frame=picture(frame),
        spec=words,
        learnt=learnt.tolist(),
        regions=[place.tolist() for place in places],
    )
    assert np.abs(np.array(found) - wanted).max() < CLOSE


DISTANCES = """
const image = live.colorBins()(picture(data.frame));
const target = live.learn(image, data.learnt, data.spec);
return data.regions.map((region) => live.coefficients(target, image, region));
"""


@few
@given(frames(), kernels(), inside(), st.lists(inside(), min_size=1, max_size=3))
def agrees_on_coefficients(engine, frame, both, learnt, places):
    spec, words = both
    image = ColorBins()(frame)
    try:
        target = learn(image, learnt, spec)
    except ValueError:
        assume(False)
    assume(decided(target.kernels, learnt, *places))
    wanted = coefficient(histograms(image, target.kernels, places), target.q)
    found = engine(
        DISTANCES,
        frame=picture(frame),
        spec=words,
        learnt=learnt.tolist(),
        regions=[place.tolist() for place in places],
    )
    assert np.abs(np.array(found) - wanted).max() < CLOSE


STEP = """
const image = live.colorBins()(picture(data.frame));
const target = live.learn(image, data.learnt, data.spec);
const at = live.differentiate(target, image, data.region, data.derivative);
return { ...at, step: live.newtonStep(at, target) };
"""


@few
@given(
    frames(),
    kernels(["epanechnikov"], ["one", "2x2", "3x3", "4x4", "cut"]),
    inside(),
    st.tuples(*[st.floats(-1, 1)] * 4),
    st.booleans(),
)
def agrees_on_newton_steps(engine, frame, both, learnt, moved, derivative):
    spec, words = both
    image = ColorBins()(frame)
    try:
        target = learn(image, learnt, spec)
    except ValueError:
        assume(False)
    dx, dy, turn, growth = moved
    region = displaced(learnt, 5 * dx, 5 * dy, 0.5 * turn, np.exp(0.3 * growth))
    assume(decided(target.kernels, learnt, region))
    q, dq = differentiate(target, image, region, derivative)
    found = engine(
        STEP,
        frame=picture(frame),
        spec=words,
        learnt=learnt.tolist(),
        region=region.tolist(),
        derivative=derivative,
    )
    assert np.abs(np.array(found["q"]) - q.ravel()).max() < CLOSE
    assert np.abs(np.array(found["dq"]) - dq.ravel()).max() < CLOSE
    seen = q.ravel() > 1e-6
    jacobian = dq.reshape(-1, 4)[seen] / np.sqrt(q.ravel()[seen])[:, None]
    curvature = np.linalg.eigvalsh(jacobian.T @ jacobian)
    # Where a direction is as flat as the limit, rounding may keep it or leave it.
    assume((np.abs(curvature / (1e-3 * curvature[-1]) - 1) > 1e-3).all())
    wanted = newton_step(q, dq, target.q)
    assert np.abs(found["step"] - wanted).max() < CLOSE * max(1, np.abs(wanted).max())


@few
@given(
    st.sampled_from(list(SCHEMES)),
    st.lists(st.floats(0, 1), min_size=4, max_size=60),
    st.integers(0, 2**32),
)
def agrees_on_who_lives(engine, scheme, weights, seed):
    assume(sum(weights) > 1e-3)
    weights = np.array(weights) / sum(weights)
    rng = Recorded(seed)
    wanted = SCHEMES[scheme](weights, rng)
    found = engine(
        "return live.SCHEMES[data.scheme](data.weights, live.replay(data.drawn));",
        scheme=scheme,
        weights=weights.tolist(),
        drawn=rng.drawn,
    )
    assert found == wanted.tolist()


@few
@given(inside(), inside(), st.integers(-3, 3))
def agrees_on_errors(engine, one, other, turns):
    one = one + [0, 0, turns * np.pi, 0, 0]
    wanted = errors(one, other)
    found = engine(
        "return live.errors(data.one, data.other);",
        one=one.tolist(),
        other=other.tolist(),
    )
    assert abs(found[0] - wanted.position) < CLOSE
    assert abs(found[1] - wanted.orientation) < CLOSE


@few
@given(inside(), inside())
def agrees_on_overlap(engine, one, other):
    # Sides on one line are where shapely's own arithmetic can fail.
    assume(abs(np.sin(2 * (one[2] - other[2]))) > 1e-6)
    found = engine(
        "return live.overlap(data.one, data.other);",
        one=one.tolist(),
        other=other.tolist(),
    )
    assert abs(found - overlap(one, other)) < CLOSE


RUN = """
const bins = live.colorBins();
const images = data.frames.map((frame) => bins(picture(frame)));
const tracker = {
  filter: [live.filterInit, live.filterStep, live.FILTER],
  combined: [live.combinedInit, live.combinedStep, live.COMBINED],
  ssd: [live.ssdInit, live.ssdStep, live.SSD],
}[data.tracker];
const run = (tracker) =>
  live.track(tracker, images, data.start, live.replay(data.drawn));
const row = ({ region, distance, nEff = 0, lost, steps = 0 }) =>
  [...region, distance, nEff, Number(lost), steps];
"""


@pytest.fixture(scope="module")
def behind_the_wall():
    """The scene of figure 6, from shortly before the wall until the car is out."""
    return hidden(0, first=12, frames=5).sequence().part(slice(24))


FILM = """
const bins = live.colorBins();
const rng = live.replay(data.drawn);
const { n, lam, noise, scheme } = data;
const motion = live.restless(live.MOTION, noise);
const options = { ...live.FILTER, n, lambda: lam, motion, scheme };
const [first, ...others] = data.frames.map((frame) => bins(picture(frame)));
let [state, info] = [live.filterInit(options, first, data.start, rng), null];
let before;
for (const image of others) {
  before = state.particles.regions;
  [state, info] = live.filterStep(options, state, image, rng);
}
return { ...info, before };
"""


@pytest.mark.parametrize(
    "n, lam, noise, scheme",
    [
        (75, 20, 1.0, "multinomial"),
        (30, 60, 0.5, "systematic"),
        (40, 5, 2.0, "residual"),
        (50, 0, 1.5, "stratified"),
    ],
)
def test_the_four_beats_of_a_round(engine, n, lam, noise, scheme):
    clip, learnt = beats.film(240.0).sequence(), beats.film().sequence()
    motion = beats.restless(noise)
    tracker = ParticleFilter(n=n, lam=lam, motion=motion, scheme=scheme)
    rng = Recorded(3)
    made = beats.last_round(tracker, clip, learnt, 8, rng)
    found = engine(
        FILM,
        frames=[picture(learnt.frames[0]), *map(picture, clip.frames[1:9])],
        start=learnt.truth[0].tolist(),
        drawn=rng.drawn,
        n=n,
        lam=lam,
        noise=noise,
        scheme=scheme,
    )
    close = {"atol": 2e-3, "rtol": 1e-4}
    np.testing.assert_allclose(found["before"], made.before, **close)
    np.testing.assert_allclose(found["particles"], made.predicted, **close)
    np.testing.assert_allclose(found["weights"], made.weights, atol=1e-4)
    np.testing.assert_allclose(found["region"], made.estimate, **close)
    assert abs(found["distance"] - made.distance) < 1e-4
    assert found["ancestors"] == made.ancestors.tolist()


def infos(tracker, clip, rng):
    """What a tracker tells of every frame after the first one."""
    state, told = tracker.init(clip.frames[0], clip.truth[0], rng), []
    for frame in clip.frames[1:]:
        state, info = tracker.step(state, frame, rng)
        told.append(info)
    return told


def test_random_numbers_are_uniform_and_normal_and_follow_from_their_seed(engine):
    draw = "const r = live.random(data.seed); return [[...r.uniforms(4000)], "
    draw += "[...r.normals(4000)]];"
    uniforms, normals = engine(draw, seed=7)
    assert kstest(uniforms, "uniform").pvalue > 0.01 < kstest(normals, "norm").pvalue
    assert engine(draw, seed=7) == [uniforms, normals] != engine(draw, seed=8)


def test_each_component_of_a_step_is_bounded(engine):
    region, step = [60.0, 40.0, 0.3, 20.0, 12.0], [0.9, -0.7, 0.6, -3.0]
    found = engine(
        "return live.moved(data.region, data.step);", region=region, step=step
    )
    assert found == pytest.approx(moved(np.array(region), np.array(step)))


def test_weights_of_which_none_can_be_told_are_equal(engine):
    found = engine("return live.normalised([-Infinity, -Infinity, -Infinity]);")
    assert found == pytest.approx([1 / 3] * 3)


WHOLE = {"filter": ParticleFilter(n=75), "combined": Combined(), "ssd": SSD()}
# SSD begins where it ended, so that one pixel taken for its neighbour is never made up.
TOGETHER = {"ssd": 7}


@pytest.mark.slow
@pytest.mark.parametrize("name", WHOLE)
def test_a_whole_run_frame_by_frame(engine, behind_the_wall, name):
    clip, tracker = behind_the_wall, WHOLE[name]
    rng = Recorded(3)
    wanted = [
        [
            *info["region"],
            info["distance"],
            info.get("n_eff", 0),
            info["lost"],
            info.get("steps", 0),
        ]
        for info in infos(tracker, clip, rng)
    ]
    found = engine(
        f"{RUN} return run(tracker).map(row);",
        frames=[picture(frame) for frame in clip.frames],
        start=clip.truth[0].tolist(),
        tracker=name,
        drawn=rng.drawn,
    )
    same = slice(TOGETHER.get(name))
    np.testing.assert_allclose(found[same], wanted[same], atol=2e-3, rtol=1e-4)
    for distances in np.array(found)[:, 5], np.array(wanted)[:, 5]:
        assert distances.min() < 0.6 < distances.max()  # both sides of the switch


TWICE = """
const options = { ...live.COMBINED, threshold: data.threshold };
const whole = run([live.combinedInit, live.combinedStep, options]);
const found = run([live.filterInit, live.filterStep, live.FILTER]);
const again = live.refinedTrack(options, images, data.start, found);
return [whole, again].map((infos) => infos.map(row));
"""


@pytest.mark.slow
@pytest.mark.parametrize("threshold", [0.45, 0.6])
def test_another_threshold_needs_no_other_filter(engine, behind_the_wall, threshold):
    clip, rng = behind_the_wall, Recorded(3)
    infos(ParticleFilter(n=75), clip, rng)
    whole, again = engine(
        f"{RUN} {TWICE}",
        frames=[picture(frame) for frame in clip.frames],
        start=clip.truth[0].tolist(),
        tracker="combined",
        drawn=rng.drawn,
        threshold=threshold,
    )
    assert whole == again
    assert {row[-1] > 0 for row in whole} == {True, False}


SCREEN = """
const regionAt = (t) => data.regions[Math.round((t + 1) / 0.25)];
const { width, middle } = live.screen(regionAt, data.scene);
const frames = [...Array(data.length).keys()];
const seen = frames.map((k) => live.beside(regionAt(k), middle(k), width));
return { width, middles: frames.map(middle), seen };
"""


@pytest.mark.parametrize("seed, frames", [(0, 5), (1, 10), (2, 1)])
def test_the_screen_hides_the_same_frames(engine, seed, frames):
    scene = hidden(seed, first=46, frames=frames)
    places = regions_of(scene, scene.target, np.arange(-1, scene.length, 0.25))
    found = engine(
        SCREEN,
        regions=places.tolist(),
        length=scene.length,
        scene={"shutter": scene.shutter, "first": 46, "frames": frames},
    )
    (wall,) = scene.front
    assert found["width"] == wall.width
    times = np.arange(scene.length)
    middles = regions_of(scene, wall, times)[:, :2]
    np.testing.assert_allclose(found["middles"], middles, atol=0.01)
    clip = scene.sequence()
    # The car's corners are round, and its box has them.
    assert np.abs(clip.visibility - found["seen"]).max() < 0.1
    hides = np.array(found["seen"]) == 0
    assert hides.tolist() == [46 <= k < 46 + frames for k in times]


def test_a_whole_newton_path(engine, behind_the_wall):
    clip = behind_the_wall
    image = ColorBins()(clip.frames[0])
    start = displaced(clip.truth[0], 9, -4, 0.2, 0.9)
    target = learn(image, clip.truth[0], SSD().kernels)
    wanted = newton_path(target, image, start, 8)
    found = engine(
        "const image = live.colorBins()(picture(data.frame));"
        "const target = live.learn(image, data.truth, live.SSD.kernels);"
        "return live.newtonPath(target, image, data.start, 8, true);",
        frame=picture(clip.frames[0]),
        truth=clip.truth[0].tolist(),
        start=start.tolist(),
    )
    np.testing.assert_allclose(found, wanted, atol=1e-3)


@few
@given(
    st.floats(0.1, 4),
    st.integers(0, 3),
    st.sampled_from([0.0, 0.1, 1.0, 10.0, np.inf]),
    st.integers(0, 99),
)
def agrees_on_the_loop(engine, gain, delay, ratio, seed):
    rng = np.random.default_rng(seed)
    velocity, noise = rng.normal(size=(2, 30))
    kalman = Kalman(ratio)
    wanted = one_feature(
        np.array([gain]), 0.1, kalman, velocity, noise[:, None], delay
    )[:, 0]
    found = engine(
        ANSWER,
        loop=in_words(gain=gain, dt=0.1, delay=delay, ratio=ratio),
        velocity=velocity.tolist(),
        noise=noise.tolist(),
    )
    np.testing.assert_allclose(found, wanted, rtol=CLOSE, atol=CLOSE)


# JSON knows no infinity.
WORDS = "const loop = { ...data.loop, ratio: data.loop.ratio ?? Infinity };"
ANSWER = f"{WORDS} return live.oneFeature(loop, data.velocity, data.noise);"


def in_words(ratio, **loop):
    """A loop as the engine takes it."""
    return loop | {"ratio": None if np.isinf(ratio) else ratio}


loops = st.fixed_dictionaries(
    {
        "gain": st.floats(0.1, 9),
        "dt": st.floats(0.05, 0.4),
        "delay": st.integers(0, 4),
        "ratio": st.sampled_from([0.0, 0.3, 1.0, np.inf]),
        "mismatch": st.floats(0.25, 3),
    }
)


def linear(gain, dt, delay, ratio, mismatch):
    """The same loop as Python's linear system."""
    return closed_loop(gain, dt, Kalman(ratio), delay, mismatch)


@few
@given(loops, st.integers(0, 99))
def agrees_on_the_answer_to_a_wrong_matrix(engine, loop, seed):
    system = linear(**loop)
    velocity = np.random.default_rng(seed).normal(size=20)
    matrices = system.A, system.B, system.C, system.D, loop["dt"]
    wanted = dlsim(matrices, velocity)[1][:, 0]
    found = engine(
        ANSWER, loop=in_words(**loop), velocity=velocity.tolist(), noise=[0] * 20
    )
    np.testing.assert_allclose(found, wanted, rtol=CLOSE, atol=CLOSE)


@few
@given(loops)
def agrees_on_poles(engine, loop):
    theirs = linear(**loop).poles()
    found = engine(f"{WORDS} return live.poles(loop);", loop=in_words(**loop))
    mine = np.array([complex(*pole) for pole in found])
    # Python has others at 0, values that are stored for one frame.  Poles that fall
    # together are found to the root of the precision.
    for pole in mine:
        assert np.abs(theirs - pole).min() < 1e-3
    for pole in theirs[np.abs(theirs) > 0.1]:
        assert np.abs(mine - pole).min() < 1e-3
    away = np.abs(theirs).max()
    assert away < 0.1 or abs(np.abs(mine).max() - away) < 1e-3


# The poles of the second loop are real at the near gain, and a pair at its own.
@pytest.mark.parametrize("gain, near, delay", [(2.0, 2.1, 3), (1.4, 1.1, 1)])
def test_poles_from_those_of_a_near_gain(engine, gain, near, delay):
    loop = {"gain": gain, "dt": 0.2, "delay": delay, "mismatch": 1.0}
    anew, near = engine(
        f"const near = live.poles({{ ...data.loop, gain: {near} }});"
        "return [live.poles(data.loop), live.poles(data.loop, near)];",
        loop=loop,
    )
    anew, near = (np.array(z) @ [1, 1j] for z in (anew, near))
    assert np.abs(anew[:, None] - near).min(axis=1).max() < 1e-6


def test_where_the_degree_falls_the_poles_of_a_near_gain_are_no_start(engine):
    loop = {"gain": 5.0, "dt": 0.2, "delay": 0, "ratio": 0, "mismatch": 1.0}
    anew, near = engine(
        "const near = live.poles({ ...data.loop, gain: 4.9 });"
        "return [live.poles(data.loop), live.poles(data.loop, near)];",
        loop=loop,
    )
    assert anew == near == []


BLURRED = """
const [ground, sprite] = [data.ground, data.sprite].map(picture);
const { data: pixels } = live.blurred(ground, sprite, data.region, data.motion);
return pixels;
"""


@st.composite
def crossings(draw):
    """Region, exposure and speed of an object of 24 x 15 pixels."""
    place = draw(st.integers(24, 40)) - 0.5, draw(st.integers(18, 30)), 0.0, 12.0, 7.5
    motion = {"exposure": draw(st.floats(0, 1)), "speed": draw(st.integers(0, 20))}
    return np.array(place), motion


@few
@given(frames(), crossings())
def agrees_on_blur(engine, frame, crossing):
    (x, y, *rest), motion = crossing
    image = frame.astype(np.float32)
    sprite = np.zeros((15, 24, 4), np.uint8)
    sprite[..., :3] = frame[:15, :24]
    sprite[..., 3] = np.add.outer(np.arange(15), np.arange(24)) * 6 + 20
    way = motion["speed"] * motion["exposure"]
    n = int(np.clip(np.ceil(way), 1, 32))
    premultiplied = sprite.astype(np.float32)
    premultiplied[..., :3] *= premultiplied[..., 3:] / 255
    mean = np.zeros_like(image)
    for share in (np.arange(n) + 0.5) / n - 0.5:
        shift = np.array([[1, 0, x - 11.5 + way * share], [0, 1, y - 7]])
        size = image.shape[1::-1]
        part = cv2.warpAffine(premultiplied, shift, size, flags=cv2.INTER_LINEAR)
        mean += (image * (1 - part[..., 3:] / 255) + part[..., :3]) / n
    found = engine(
        BLURRED,
        ground=picture(frame),
        sprite={
            "rgba": base64.b64encode(sprite.tobytes()).decode(),
            "width": 24,
            "height": 15,
        },
        region=[x, y, *rest],
        motion=motion,
    )
    made = np.reshape(found, (*image.shape[:2], 4))[..., :3]
    # OpenCV takes places to 1/32 of a pixel, and both round.
    assert np.abs(made - mean).max() < 255 / 32 + 1


CHECKS = (
    agrees_on_bins,
    agrees_on_histograms,
    agrees_on_coefficients,
    agrees_on_newton_steps,
    agrees_on_who_lives,
    agrees_on_errors,
    agrees_on_overlap,
    agrees_on_the_loop,
    agrees_on_the_answer_to_a_wrong_matrix,
    agrees_on_poles,
    agrees_on_blur,
)


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_the_engine(engine, check):
    check(engine)


def test_the_success_curve(engine, behind_the_wall):
    clip = behind_the_wall
    run = track(Combined(), clip)
    iou = overlap(run.regions, clip.truth)[1:]
    found = engine(
        "const { found, truth } = data;"
        "const overlaps = found.map((each, i) => live.overlap(each, truth[i]));"
        "return live.success(overlaps, data.limits);",
        found=run.regions[1:].tolist(),
        truth=clip.truth[1:].tolist(),
        limits=np.linspace(0.025, 0.975, 20).tolist(),
    )
    wanted = success(np.append(np.nan, iou), np.linspace(0.025, 0.975, 20))
    np.testing.assert_allclose(found, wanted)


FAULTS = {
    "a hue below nothing": (
        "hue < 0 ? hue + 180 : hue",
        "Math.max(hue, 0)",
        agrees_on_bins,
    ),
    "halves rounded up": (
        "f(u + HALF_EVEN) - HALF_EVEN",
        "Math.floor(u)",
        agrees_on_histograms,
    ),
    "a wrong kernel": ("Math.max(1 - r2, 0)", "Math.exp(-r2)", agrees_on_coefficients),
    "no derivative of C": (
        "derivativeOfC ? q[u] * sums[k + 1] : 0",
        "0",
        agrees_on_newton_steps,
    ),
    "no random start": (
        "(i + offsets(i)) / weights.length",
        "i / weights.length",
        agrees_on_who_lives,
    ),
    "a matrix thought right": (
        "speed - sent.at(-1) / mismatch",
        "speed - sent.at(-1)",
        agrees_on_the_answer_to_a_wrong_matrix,
    ),
    "a filter's pole forgotten": (
        "a * d + a * coloured]",
        "a * d]",
        agrees_on_poles,
    ),
    "an angle off by turns": (
        "Math.abs(Math.atan2(Math.sin(off), Math.cos(off)))",
        "Math.abs(off)",
        agrees_on_errors,
    ),
    "a shutter that opens early": (
        "((k + 0.5) / n - 0.5)",
        "(k / n - 0.5)",
        agrees_on_blur,
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_found(engine, fault):
    right, wrong, check = FAULTS[fault]
    try:
        assert_found(engine, ENGINE, right, wrong, check)
    finally:
        engine.load(ENGINE)
