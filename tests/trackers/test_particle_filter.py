"""The particle filter of [T09]: how it weighs, and what it refuses."""

import numpy as np
import pytest

from mkt.colors import ColorBins
from mkt.kernels import Kernels
from mkt.particles import SCHEMES
from mkt.scenes.questions import base
from mkt.trackers import by_name
from mkt.trackers.combined import Combined
from mkt.trackers.particle_filter import ParticleFilter
from mkt.tracking import track
from tests.trackers.scenes import short


def test_the_score_does_not_depend_on_how_a_filter_weighs():
    clip = short(base(0), 5)
    for lam in (1.0, 40.0):
        run = track(ParticleFilter(n=50, lam=lam), clip)
        expected = np.exp(-20 * run.info["distance"][1:] ** 2)
        np.testing.assert_allclose(run.score[1:], expected)


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


def test_a_filter_draws_as_its_own_method_says():
    class Worst(ParticleFilter):
        def resample(self, weights, rng):
            return np.full(self.n, np.argmin(weights))

    clip, rng = short(base(0), 3), np.random.default_rng(0)
    tracker = Worst(n=20)
    state, info = tracker.step(
        tracker.init(clip.frames[0], clip.truth[0], rng), clip.frames[1], rng
    )
    worst = info["particles"][np.argmin(info["weights"])]
    np.testing.assert_array_equal(state.particles.regions, np.tile(worst, (20, 1)))


def test_nobody_enters_a_scheme_that_kept_runs_would_not_know():
    with pytest.raises(TypeError):
        SCHEMES["mine"] = SCHEMES["residual"]


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
    plain, sir = ParticleFilter(), by_name.TRACKERS["sir"]
    assert (plain.n, plain.lam, plain.scheme) == (500, 20.0, "multinomial")
    assert plain.kernels == Kernels("tiles", "uniform")
    assert Combined().filter == ParticleFilter(n=75)
    assert [by_name.TRACKERS[f"pf-{k}"].n for k in (1, 500, 75)] == [500, 500, 75]
    assert (sir.n, sir.scheme, sir.bins) == (200, "systematic", ColorBins("hs"))
