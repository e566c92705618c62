"""SSD as a tracker: its spans, its bounds on the size, and what it refuses."""

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from mkt.colors import ColorBins
from mkt.edges import EdgeBins
from mkt.files import PACKAGE
from mkt.kernels import Kernels
from mkt.regions import displaced
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene
from mkt.trackers.guided import Guided
from mkt.trackers.homography import PlaneSSD
from mkt.trackers.newton import distance_at, minimise
from mkt.trackers.ssd import SSD

LAYER = Layer("car", 80.0, ((0.0, 160.0, 120.0, 0.3, 1.0),))
CLIP = Scene(LAYER, length=2).sequence()


def test_spans_are_factors_on_the_span_of_the_kernels():
    rng = np.random.default_rng(0)
    tracker = SSD(Kernels("3x3", span=0.5), spans=(1.4, 1.0))
    state = tracker.init(CLIP.frames[0], CLIP.truth[0], rng)
    assert [target.kernels.span for target in state.targets] == [0.7, 0.5]


def test_a_tracker_takes_its_steps_span_after_span():
    rng = np.random.default_rng(0)
    tracker = SSD(spans=(1.4, 1.0), iterations=2)
    state = tracker.init(CLIP.frames[0], CLIP.truth[0], rng)
    assert [target.kernels.span for target in state.targets] == [1.4, 1.0]
    assert state.size == pytest.approx(np.sqrt(np.prod(CLIP.truth[0, 3:])))
    image = tracker.bins(CLIP.frames[1])
    region = start = displaced(CLIP.truth[0], 6, 0, np.deg2rad(9), 1.1)
    taken = []
    for target in state.targets:
        region, steps = minimise(target, image, region, 2)
        taken.append(steps)
    after, info = tracker.step(state._replace(region=start), CLIP.frames[1], rng)
    np.testing.assert_allclose(after.region, region)
    assert info["steps"] == info["evaluations"] == sum(taken) > max(taken)
    assert info["distance"] == distance_at(state.targets[-1], image, region)


@pytest.mark.parametrize(
    "field, value",
    [
        ("iterations", 0),
        ("iterations", 2.5),
        ("spans", ()),
        ("sizes", (0.0, 1.0)),
        ("sizes", (2.0, 1.0)),
        ("sizes", (-1.0, 1.0)),
        ("sizes", (0.5, np.inf)),
        ("sizes", 0.5),
        ("spans", ("wide",)),
        ("kernels", "3x3"),
    ],
)
def test_a_field_that_makes_no_sense_is_refused(field, value):
    with pytest.raises(ValueError, match=f"^{field} is "):
        SSD(**{field: value})


@pytest.mark.parametrize("scale", [0.7, 1.4])
def test_the_size_is_bounded_and_the_aspect_kept(scale):
    tracker = SSD(sizes=(0.9, 1.1), iterations=1)
    truth = CLIP.truth[0]
    state = tracker.init(CLIP.frames[0], truth, np.random.default_rng(0))
    start = displaced(truth, 25, 25, 1.0, scale)
    region, _, _ = tracker.refine(state, tracker.bins(CLIP.frames[0]), start)
    factor = 0.9 if scale < 1 else 1.1
    np.testing.assert_allclose(region[3:], factor * truth[3:])


@pytest.mark.parametrize("kernels", [Kernels("tiles", "uniform"), Kernels("ellipse")])
@pytest.mark.parametrize(
    "made", [SSD, lambda k: Guided(fine=k), lambda k: PlaneSSD(passes=(k,))]
)
def test_kernels_without_a_slope_are_refused_before_a_run(made, kernels):
    with pytest.raises(ValueError, match="kernels have no slope"):
        made(kernels)


def test_the_slopes_of_other_weights_are_not_those_of_epanechnikov():
    class Gaussian(Kernels):
        def weigh(self, points):
            return np.exp(-super().weigh(points))

    with pytest.raises(ValueError, match="Gaussian has a `weigh` of its own"):
        SSD(Gaussian())


@pytest.mark.parametrize("bins", [ColorBins(), EdgeBins()], ids=["colours", "edges"])
def test_a_run_in_another_thread_may_come_between_any_two_lines(bins):
    """What is kept to work in, matrices and rooms for look-ups, is each thread's own.

    To switch between threads often would meet the line where it matters by chance only.
    """
    tracker = SSD(bins=bins, iterations=2)
    state = tracker.init(CLIP.frames[0], CLIP.truth[0], None)

    def found(k):
        begun = state._replace(region=displaced(CLIP.truth[0], 4 * k - 2))
        return tracker.step(begun, CLIP.frames[k], None)[0].region

    def interrupted(frame, event, arg):
        if event == "line":
            others.append(pool.submit(found, 1).result())
        ours = frame.f_code.co_filename.startswith(str(PACKAGE))
        return interrupted if ours else None

    alone, other, others = found(0), found(1), []
    before = sys.gettrace()
    with ThreadPoolExecutor(1) as pool:
        sys.settrace(interrupted)
        try:
            together = found(0)
        finally:
            sys.settrace(before)
    np.testing.assert_array_equal(together, alone)
    assert len(others) > 50 and (np.array(others) == other).all()
