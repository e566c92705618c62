"""The engine of the pages says what Python says."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st

from mkt.colors import SPACES, ColorBins
from mkt.evaluation import overlap, success
from mkt.histograms import coefficient, histograms, learn
from mkt.kernels import Kernels
from mkt.particles import SCHEMES
from mkt.regions import as_regions, displaced, warp_matrices
from mkt.scenes.teuliere2009 import hidden
from mkt.servoing.poles import closed_loop, one_feature
from mkt.servoing.self_motion import Kalman
from mkt.trackers.combined import Combined
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD, differentiate, newton_path, newton_step
from mkt.tracking import track
from tests.live.conftest import ENGINE, Recorded, picture
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


CHECKS = (
    agrees_on_bins,
    agrees_on_histograms,
    agrees_on_coefficients,
    agrees_on_newton_steps,
    agrees_on_who_lives,
    agrees_on_overlap,
)


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_the_engine(engine, check):
    check(engine)


RUN = """
const bins = live.colorBins();
const images = data.frames.map((frame) => bins(picture(frame)));
const rng = live.replay(data.drawn);
const [init, step, options] = {
  filter: [live.filterInit, live.filterStep, live.FILTER],
  combined: [live.combinedInit, live.combinedStep, live.COMBINED],
}[data.tracker];
let [state, info] = [init(options, images[0], data.start, rng), null];
return images.slice(1).map((image) => {
  [state, info] = step(options, state, image, rng);
  const { region, distance, nEff, lost, steps = 0 } = info;
  return [...region, distance, nEff, Number(lost), steps];
});
"""


@pytest.fixture(scope="module")
def behind_the_wall():
    """The scene of figure 6, from shortly before the wall until the car is out."""
    clip = hidden(0, first=12, frames=5).sequence()
    kept = slice(0, 24)
    return replace(
        clip,
        frames=[clip.frames[k] for k in range(24)],
        truth=clip.truth[kept],
        visibility=clip.visibility[kept],
    )


@pytest.mark.parametrize("name", ["filter", "combined"])
def test_a_whole_run_frame_by_frame(engine, behind_the_wall, name):
    clip = behind_the_wall
    tracker = {"filter": ParticleFilter(n=75), "combined": Combined()}[name]
    rng = Recorded(3)
    state, wanted = tracker.init(clip.frames[0], clip.truth[0], rng), []
    for frame in clip.frames[1:]:
        state, info = tracker.step(state, frame, rng)
        rest = [info["distance"], info["n_eff"], info["lost"], info.get("steps", 0)]
        wanted.append([*info["region"], *rest])
    found = engine(
        RUN,
        frames=[picture(frame) for frame in clip.frames],
        start=clip.truth[0].tolist(),
        tracker=name,
        drawn=rng.drawn,
    )
    np.testing.assert_allclose(found, wanted, atol=2e-3, rtol=1e-4)
    distances = np.array(wanted)[:, 5]
    assert distances.min() < 0.6 < distances.max()  # both sides of the switch


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
        "const { ratio, ...rest } = data.loop;"
        "const loop = { ...rest, ratio: ratio ?? Infinity };"
        "return live.oneFeature(loop, data.velocity, data.noise);",
        loop={
            "gain": gain,
            "dt": 0.1,
            "delay": delay,
            "ratio": None if np.isinf(ratio) else ratio,
        },
        velocity=velocity.tolist(),
        noise=noise.tolist(),
    )
    np.testing.assert_allclose(found, wanted, rtol=CLOSE, atol=CLOSE)


def test_the_loop(engine):
    agrees_on_the_loop(engine)


@pytest.mark.parametrize("delay", [0, 1, 2, 3])
@pytest.mark.parametrize("gain", [0.4, 3.0, 9.0])
def test_the_poles(engine, gain, delay):
    found = engine(
        "return live.poles(data.loop);", loop={"gain": gain, "dt": 0.2, "delay": delay}
    )
    mine = np.array([complex(*pole) for pole in found])
    theirs = closed_loop(gain, 0.2, delay=delay).poles()
    for pole in mine:  # theirs has others, values that are stored for one frame
        assert np.abs(theirs - pole).min() < 1e-4


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
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_found(engine, fault):
    right, wrong, check = FAULTS[fault]
    text = ENGINE.read_text("utf-8")
    assert right in text
    engine.load(text.replace(right, wrong))
    try:
        with pytest.raises(AssertionError):
            check(engine)
    finally:
        engine.load(text)
