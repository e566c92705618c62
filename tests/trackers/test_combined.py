"""The switch of the combination, its particles, and how often it bins a frame."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from mkt.colors import ColorBins
from mkt.evaluation import overlap
from mkt.histograms import learn
from mkt.particles import covariance
from mkt.scenes.questions import base
from mkt.trackers.combined import Combined
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD
from mkt.tracking import track
from tests.trackers.scenes import short


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
