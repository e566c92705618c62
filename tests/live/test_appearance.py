"""The samples that wait on the page are placed and judged as Python's are."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from mkt.trackers.adaptive import Adaptive
from mkt.trackers.appearance import background, place, threshold
from tests.live.conftest import ENGINE, Recorded, assert_found, fixture_of, picture
from tests.strategies import frames

RUN = """
const { coefficient, colorBins, disc, place, replay, summary } = live;
const { zones, size, halfAxes, n, drawn, model, samples, around } = data;
const regions = place(zones, size, halfAxes, n, replay(drawn));
const image = colorBins({ space: "rgb" })(picture(data.frame));
const points = disc(samples);
const rho = data.wanted.map((region) => coefficient(image, points, region, model));
return { regions, rho, about: summary(around) };
"""
few = settings(
    max_examples=40, deadline=None, phases=[Phase.generate], derandomize=True
)
doors = st.tuples(*(st.floats(*ends) for ends in ((0, 63), (0, 47), (1, 9), (1, 9))))
zones = st.lists(
    st.one_of(st.sampled_from(["borders", "anywhere"]), doors), min_size=1, max_size=4
)
half_axes = st.tuples(st.floats(3, 15), st.floats(3, 15)).map(np.array)


class Drawn(Recorded):
    """With the numbers that zones draw."""

    def uniform(self, low, high, shape):
        return low + (np.asarray(high) - low) * self.random(shape)

    def normal(self, mean, spread, shape):
        return np.asarray(mean) + np.asarray(spread) * self.standard_normal(shape)


appearance = fixture_of(ENGINE)


def agrees(engine, frame, zones, axes, n):
    tracker = Adaptive(n=n, zones=tuple(zones))
    image = tracker.bins(frame)
    here = np.array([32.3, 24.4, 0.0, *axes])
    model = tracker.learn(frame, here)
    rng = Drawn(0)
    particles = tracker.place(model, frame.shape, rng)
    wanted = np.column_stack([particles[:, :2], np.zeros(n), particles[:, 4:6]])
    around = background(tracker.disc, image, axes) @ np.sqrt(model.q)
    found = engine(
        RUN,
        frame=picture(frame),
        zones=zones,
        size=frame.shape[1::-1],
        halfAxes=axes.tolist(),
        n=n,
        drawn=rng.drawn,
        model=[[int(u), float(model.q[u])] for u in np.flatnonzero(model.q)],
        samples=tracker.disc.samples,
        around=around.tolist(),
        wanted=wanted.tolist(),
    )
    np.testing.assert_allclose(found["regions"], wanted, atol=1e-9)
    rho = tracker.observe(image, particles, model)
    np.testing.assert_allclose(found["rho"], rho, atol=1e-4)
    about = found["about"]
    limit = about["mean"] + 2 * about["spread"]
    assert limit == pytest.approx(
        threshold(background(tracker.disc, image, axes), model.q), abs=1e-5
    )
    counts = np.histogram(around.clip(0, 1), 50, (0, 1))[0]
    assert sum(about["counts"]) == len(around)
    assert np.abs(np.subtract(about["counts"], counts)).sum() <= 2  # on a border


def everywhere(engine):
    numbers = frames(), zones, half_axes, st.integers(1, 30)
    few(given(*numbers)(lambda a, b, c, d: agrees(engine, a, b, c, d)))()


def test_samples_wait_and_appear_as_in_python(appearance):
    everywhere(appearance)


def test_a_coefficient_of_one_is_counted(appearance):
    counts = appearance("return live.summary([0, 1, 1]).counts;")
    assert counts == np.histogram([0, 1, 1], 50, (0, 1))[0].tolist()


def test_as_many_wait_for_each_pixel_of_border(appearance):
    size, axes, n = (4, 2), np.array([0.2, 0.1]), 60
    rng = Drawn(0)
    wanted = place(("borders",), size[::-1], axes, n, rng)
    rng.standard_normal(n)
    found = appearance(
        "const { zones, size, halfAxes, n, drawn } = data;"
        "return live.place(zones, size, halfAxes, n, live.replay(drawn));",
        zones=["borders"],
        size=size,
        halfAxes=axes.tolist(),
        n=n,
        drawn=rng.drawn,
    )
    np.testing.assert_allclose(np.array(found)[:, :2], wanted)


FAULTS = {
    "the elliptic radius": (
        "f * (1 - x * x) + (1 - f) * (1 - y * y)",
        "1 - x * x - y * y",
    ),
    "both half axes of one": (
        "halfAxes.map((half) => growth * half)",
        "halfAxes.map(() => growth * halfAxes[0])",
    ),
    "round doors": ("y + spread[1] * v", "y + spread[0] * v"),
    "a band of the other axis": (
        "halfAxes[axis] * depths",
        "halfAxes[1 - axis] * depths",
    ),
    "what lies outside is counted": (
        "slice(0, image.m)",
        "map((value, u) => value + counts[image.m] * (u === 0))",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_found(appearance, fault):
    assert_found(appearance, ENGINE, *FAULTS[fault], everywhere)
