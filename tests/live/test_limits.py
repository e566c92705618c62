"""Where a number meets its limit the page decides as Python does."""

import numpy as np
import pytest

from mkt.colors import ColorBins
from mkt.evaluation import success
from mkt.histograms import learn
from mkt.kernels import Kernels
from mkt.particles import SCHEMES
from mkt.scenes.teuliere2009 import hidden
from mkt.trackers.combined import Combined
from mkt.trackers.newton import newton_step
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD
from tests.live.conftest import Recorded, picture

STEP = """
const [first, second] = data.frames.map((frame) => live.colorBins()(picture(frame)));
"""
SSD_STEP = """
const options = { ...live.SSD, sizes: data.sizes };
const state = live.ssdInit(options, first, data.learnt);
return live.ssdStep(options, { ...state, region: data.start }, second)[1].region;
"""
LOST = """
const rng = live.replay(data.drawn);
const lostAbove = data.limit;
const ssd = { ...live.SSD, lostAbove };
const [init, step, options] = {
  filter: [live.filterInit, live.filterStep, { ...live.FILTER, lostAbove }],
  combined: [live.combinedInit, live.combinedStep, { ...live.COMBINED, ssd }],
  ssd: [live.ssdInit, live.ssdStep, ssd],
}[data.tracker];
return step(options, init(options, first, data.start, rng), second, rng)[1].lost;
"""


@pytest.fixture(scope="module")
def two():
    """The first two frames of the car, with nothing before it."""
    return hidden(0).sequence().part(slice(2))


def pictures(clip):
    return [picture(frame) for frame in clip.frames]


@pytest.mark.parametrize("factor, sizes", [(0.8, (1, 1)), (1, (0.3, 0.9)), (1, (2, 3))])
def test_the_size_is_bounded_by_that_of_the_first_frame(engine, two, factor, sizes):
    ssd, rng = SSD(sizes=sizes), np.random.default_rng(0)
    state = ssd.init(two.frames[0], two.truth[0], rng)
    start = two.truth[0] * [1, 1, 1, factor, factor]
    wanted = ssd.step(state._replace(region=start), two.frames[1], rng)[1]["region"]
    found = engine(
        STEP + SSD_STEP,
        frames=pictures(two),
        learnt=two.truth[0].tolist(),
        start=start.tolist(),
        sizes=sizes,
    )
    np.testing.assert_allclose(found, wanted, atol=2e-3)
    share = np.sqrt(found[3] * found[4]) / state.size
    assert np.isclose(share, sizes).any()  # the bound was met


def test_the_bounds_of_the_size_are_those_of_python(engine):
    assert tuple(engine("return live.SSD.sizes;")) == SSD().sizes


@pytest.mark.parametrize("name", ["filter", "combined", "ssd"])
def test_a_target_is_lost_beyond_its_limit(engine, two, name):
    def told(limit):
        ssd = SSD(lost_above=limit)
        made = {
            "filter": ParticleFilter(n=75, lost_above=limit),
            "combined": Combined(ssd=ssd),
            "ssd": ssd,
        }[name]
        rng = Recorded(3)
        state = made.init(two.frames[0], two.truth[0], rng)
        return made.step(state, two.frames[1], rng)[1], rng.drawn

    distance = told(1)[0]["distance"]
    for limit, lost in [(0.99 * distance, True), (1.01 * distance, False)]:
        info, drawn = told(limit)
        found = engine(
            STEP + LOST,
            frames=pictures(two),
            start=two.truth[0].tolist(),
            drawn=drawn,
            tracker=name,
            limit=limit,
        )
        assert found == info["lost"] == lost


def test_an_overlap_at_a_limit_is_no_success(engine):
    levels = [0, 0.5, 1]
    found = engine("return live.success(data.levels, data.levels);", levels=levels)
    assert found == pytest.approx(success([np.nan, *levels], levels))


class Zeros:
    """A generator whose uniforms are all 0."""

    def random(self, n=None):
        return 0.0 if n is None else np.zeros(n)


@pytest.mark.parametrize("n", [4, 49])  # 49 * (1 / 49) < 1
@pytest.mark.parametrize("scheme", SCHEMES)
def test_who_lives_where_a_draw_meets_the_end_of_a_share(engine, scheme, n):
    weights = np.full(n, 1 / n)
    found = engine(
        "const uniforms = Array(data.weights.length).fill(0);"
        "const drawn = live.replay({ uniforms, normals: [] });"
        "return live.SCHEMES[data.scheme](data.weights, drawn);",
        scheme=scheme,
        weights=weights.tolist(),
    )
    assert found == SCHEMES[scheme](weights, Zeros()).tolist()


# An error would end node.
REFUSED = """
const image = live.colorBins()(picture(data.frame));
try {
  live.learn(image, data.region, data.spec);
} catch ({ message }) {
  return message;
}
return "";
"""


@pytest.mark.parametrize(
    "spec, region, reason",
    [
        ({"layout": "4x4", "span": 0.01, "samples": 200}, (30, 20), "covers no sample"),
        ({"layout": "3x3"}, (300, 20), "lies outside"),
        ({"layout": "3x3"}, (-8, 20), "lies outside"),
    ],
)
def test_what_cannot_be_learnt_is_refused(engine, spec, region, reason):
    frame = np.zeros((48, 64, 3), np.uint8)
    place = [*region, 0.0, 16.0, 12.0]
    said = engine(REFUSED, frame=picture(frame), region=place, spec=spec)
    assert reason in said
    with pytest.raises(ValueError, match=reason):
        learn(ColorBins()(frame), place, Kernels(**spec))


def test_a_bin_that_is_all_but_empty_has_no_part_in_a_step(engine):
    rng = np.random.default_rng(0)
    reference, dq = np.full((1, 8), 1 / 8), rng.normal(size=(1, 8, 4))
    q = np.array([[*np.full(6, 1 / 6), 1e-8, 0]])
    found = engine(
        "const q = data.reference;"
        "return live.newtonStep({ q: data.q, dq: data.dq }, { q });",
        q=q.ravel().tolist(),
        dq=dq.ravel().tolist(),
        reference=reference.tolist(),
    )
    np.testing.assert_allclose(found, newton_step(q, dq, reference), rtol=1e-6)


def test_a_screen_up_to_the_middle_covers_half(engine):
    seen = "return live.beside([0, 0, 0, 10, 5], [10, 0], 20);"
    assert engine(seen) == 0.5


def test_what_stands_still_and_is_opaque_is_seen_as_it_is(engine):
    frame = np.random.default_rng(0).integers(0, 256, (24, 32, 3), np.uint8)
    sprite = np.ascontiguousarray(255 - frame[4:14, 6:18])
    found = engine(
        "const [ground, sprite] = [data.ground, data.sprite].map(picture);"
        "const still = { exposure: 1, speed: 0 };"
        "return live.blurred(ground, sprite, [13.5, 9.5], still).data;",
        ground=picture(frame),
        sprite=picture(sprite),
    )
    frame[5:15, 8:20] = sprite
    assert np.reshape(found, (24, 32, 4))[..., :3].tolist() == frame.tolist()
