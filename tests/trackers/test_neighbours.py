"""The particle filter whose colours have neighbours, and which it is without them."""

import numpy as np
import pytest

from mkt.colors import ColorBins, JointHSV
from mkt.histograms import histograms, learn
from mkt.neighbours import MEASURES, SoftBins, quadratic
from mkt.particles import Particles
from mkt.scenes.varied import Varied
from mkt.trackers.neighbours import CrossBin
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.shaped import Shaped
from mkt.tracking import track

CLIP = Varied("calm", 3).sequence()
SHORT = CLIP.part(slice(12))


def test_without_neighbours_it_is_the_particle_filter():
    plain = track(ParticleFilter(n=40), SHORT, 1)
    cross = track(CrossBin(n=40, measure="bhattacharyya"), SHORT, 1)
    assert np.allclose(plain.regions, cross.regions, atol=1e-3)


def test_without_neighbours_kernels_are_combined_as_in_the_particle_filter():
    image, particles = first_look()
    target = learn(image, CLIP.truth[0], ParticleFilter().kernels)
    for combine in ("sum", "mean"):
        plain, cross = (
            each.weigh(target, image, particles)
            for each in (
                ParticleFilter(combine=combine),
                CrossBin(combine=combine, measure="bhattacharyya"),
            )
        )
        assert np.allclose(plain, cross)


def first_look():
    """The first frame, and particles of which the last is beside the image."""
    regions = CLIP.truth[0] + np.array([[0.0] * 5, [9, 0, 0, 0, 0], [900, 0, 0, 0, 0]])
    return ColorBins()(CLIP.frames[0]), Particles(regions, np.zeros((3, 2)))


@pytest.mark.parametrize("measure", MEASURES)
def test_nothing_looks_less_alike_than_what_lies_outside_the_image(measure):
    image, particles = first_look()
    tracker = CrossBin(lam=1.0, measure=measure)
    target = learn(image, CLIP.truth[0], tracker.kernels)
    weights = tracker.weigh(target, image, particles)
    assert weights[2] / weights[0] == pytest.approx(np.exp(-9))
    flat = target._replace(q=np.roll(target.q, target.m // 2, -1))  # nothing is alike
    weights = tracker.weigh(flat, image, particles)
    assert weights.argmin() == 2


@pytest.mark.parametrize("bins", [JointHSV(), SoftBins(), ColorBins("rgb")])
def test_bins_without_known_neighbours_are_refused(bins):
    with pytest.raises(ValueError, match="neighbours are known for hsv"):
        CrossBin(bins=bins)


@pytest.mark.parametrize("measure", ["smoothed", "quadratic", "earth mover"])
def test_each_measure_follows(measure):
    found = track(CrossBin(n=60, measure=measure, lam=80), SHORT, 1)
    off = np.linalg.norm(found.regions[5, :2] - CLIP.truth[5, :2])
    assert off < 20 and not np.allclose(found.regions[1], CLIP.truth[1])


def test_an_unknown_measure_or_shape_is_refused():
    with pytest.raises(ValueError, match="measure"):
        CrossBin(measure="nearest")
    with pytest.raises(ValueError, match="shape"):
        Shaped(shape="outline")


def test_one_part_outside_is_as_unlike_as_can_be():
    frame = np.random.default_rng(0).integers(0, 255, (60, 80, 3), np.uint8)
    tracker = CrossBin(n=2, measure="quadratic", combine="mean", lam=1.0)
    image = tracker.bins(frame)
    target = learn(image, [40, 30, 0, 15, 12], tracker.kernels)
    regions = np.array([[40.0, 30, 0, 15, 12], [-9, 30, 0, 15, 12]])
    q = histograms(image, target.kernels, regions)
    outside = ~q[1].any(-1)
    assert 0 < outside.sum() < 9
    d2 = quadratic(q, target.q, tracker.bins)
    d2[1, outside] = 1
    expected = np.exp(-d2.mean(-1))
    found = tracker.weigh(target, image, Particles(regions, np.zeros((2, 2))))
    np.testing.assert_allclose(found, expected / expected.sum(), rtol=1e-5)
