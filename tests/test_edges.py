"""Bins of edges, and several kinds of bins joined, against their parts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mkt.colors import ColorBins, Joined
from mkt.edges import EdgeBins
from mkt.histograms import (
    coefficient,
    histograms,
    learn,
    mixed_histograms,
    sample,
    turned,
    turned_once,
)
from mkt.kernels import Kernels
from mkt.neighbours import SoftBins
from mkt.particles import Motion
from mkt.regions import displaced
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene
from mkt.trackers.combined import Combined
from mkt.trackers.newton import count, differentiate, newton_step, template
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD
from mkt.tracking import track

CAR = Layer("car", 80.0, ((0.0, 160.0, 120.0, 0.3, 1.0),))
CLIP = Scene(CAR, length=2).sequence()
FRAME, REGION = CLIP.frames[0], CLIP.truth[0]
PARTS = ColorBins(), EdgeBins()
SHARES = 3.0, 1.0
BOTH = Joined(PARTS, SHARES)
KERNELS = (Kernels("3x3"), Kernels("tiles", "uniform"))
AROUND = displaced(REGION, [0, 4, 150, 900], [0, -3, 60, 0], [0, 0.2, 0, 0])


def ramp(angle, size=21, slope=8.0):
    """A frame whose brightness rises along an angle [rad]."""
    y, x = np.mgrid[:size, :size] - size // 2
    grey = np.rint(128 + slope * (x * np.cos(angle) + y * np.sin(angle)))
    return np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[..., None], 3, -1)


@given(st.integers(1, 12), st.floats(0, 2 * np.pi))
def test_the_sector_is_that_of_the_direction_in_which_it_grows_brighter(n, angle):
    share = angle / (2 * np.pi) * n
    if abs(share % 1 - 0.5) > 0.15:  # not between two sectors
        assert EdgeBins(n)(ramp(angle)).labels[10, 10] == round(share) % n


@given(st.integers(1, 3), st.integers(4, 12))
def test_a_gentle_rise_is_flat(gentle, steep):
    middle = [EdgeBins()(ramp(0.0, slope=s)).labels[10, 10] for s in (gentle, steep)]
    assert middle == [8, 0]


@pytest.mark.parametrize("gain", [0.5, 0.8])
def test_a_weaker_light_turns_no_edge(gain):
    """Where both are steep enough to have a direction, on nearly all pixels."""
    bins = EdgeBins()
    bright, dim = (bins(f).labels for f in (FRAME, (FRAME * gain).astype(np.uint8)))
    seen = (bright < 8) & (dim < 8)
    assert seen.any() and np.mean(bright[seen] == dim[seen]) > 0.9


@pytest.mark.parametrize("kernels", KERNELS, ids=lambda kernels: kernels.layout)
def test_joined_histograms_are_those_of_the_parts_in_their_shares(kernels):
    fitted = kernels.fitted(REGION)
    q = histograms(BOTH(FRAME), fitted, AROUND)
    parts = [histograms(part(FRAME), fitted, AROUND) for part in PARTS]
    shares = np.array(SHARES) / sum(SHARES)
    together = [share * part for share, part in zip(shares, parts, strict=True)]
    np.testing.assert_allclose(q, np.concatenate(together, -1), atol=1e-6)
    rho = coefficient(q, q[0])
    alone = [coefficient(part, part[0]) for part in parts]
    np.testing.assert_allclose(rho, np.tensordot(shares, alone, 1), atol=1e-6)


def test_joined_mixtures_are_those_of_the_parts_too():
    kernels, mixture = Kernels("axes").fitted(REGION), np.ones((len(AROUND), 2))
    q = mixed_histograms(BOTH(FRAME), kernels, AROUND, mixture)
    parts = [mixed_histograms(p(FRAME), kernels, AROUND, mixture) for p in PARTS]
    together = np.concatenate([0.75 * parts[0], 0.25 * parts[1]], -1)
    np.testing.assert_allclose(q, together, atol=1e-6)


def test_joined_derivatives_equal_those_of_the_parts_and_so_does_the_step():
    """The normal equations of both are the sum of the normal equations of each."""
    image, near = BOTH(FRAME), displaced(REGION, 3, -2, 0.1, 1.06)
    target = learn(image, REGION, KERNELS[0])
    q, dq = differentiate(target, image, near)
    normal, right = np.zeros((4, 4)), np.zeros(4)
    first = 0
    for part, share in zip(PARTS, (0.75, 0.25), strict=True):
        alone = learn(part(FRAME), REGION, KERNELS[0])
        q_b, dq_b = differentiate(alone, part(FRAME), near)
        columns = slice(first, first := first + part.m)
        np.testing.assert_allclose(q[:, columns], share * q_b, atol=1e-7)
        np.testing.assert_allclose(dq[:, columns], share * dq_b, atol=1e-6)
        seen = q_b > 1e-6
        J = dq_b[seen] / np.sqrt(q_b[seen])[:, None]
        e = np.sqrt(q_b[seen]) - np.sqrt(alone.q[seen])
        normal += share * J.T @ J
        right += share * J.T @ e
    expected = -2 * np.linalg.solve(normal, right)
    np.testing.assert_allclose(newton_step(q, dq, target.q), expected, rtol=1e-3)


def test_joined_derivatives_equal_central_differences():
    """dq of colours and edges together, through weights that move over fixed labels."""
    image, kernels = BOTH(FRAME), KERNELS[0].fitted(REGION)
    target = learn(image, REGION, kernels)
    labels = sample(image, kernels, REGION)
    assert labels.shape == (2, len(kernels.points))
    _, dq = differentiate(target, image, REGION)
    pairs, columns = template(kernels), []
    plane = kernels.points * kernels.half_sides
    for h in 1e-6 * np.eye(4):
        counted = []
        for step in (h, -h):
            angle = np.array([REGION[2] + step[2]])
            c, s = np.cos(step[2]), np.sin(step[2])
            back = (plane - step[:2]) @ [[c, -s], [s, c]] / np.exp(step[3])
            raw = kernels.weigh(back)
            weights = raw / raw.sum(1, keepdims=True)
            column = weights[pairs.kernel, pairs.sample][:, None]
            now = count(target, labels, column)[..., 0] * image.shares
            turned(now[None], angle, image.compasses[0])
            counted.append(now)
        columns.append((counted[0] - counted[1]) / 2e-6)
    off = np.abs(np.stack(columns, -1) - dq)[target.q > 1e-4]
    assert off.max() < 5e-3 * np.abs(dq).max()


def test_the_bins_of_a_frame_stay_when_others_follow():
    frames = np.random.default_rng(0).integers(0, 256, (3, 20, 30, 3), np.uint8)
    first = EdgeBins()(frames[0])
    kept = first.labels.copy()
    for frame in (frames[1], frames[2, :9, :7]):
        EdgeBins()(frame)
    assert (first.labels == kept).all()


@given(st.floats(-7, 7))
def test_directions_turn_with_the_region(angle):
    """A ramp seen by a region that turns with it: always the first sector.

    Up to the mixture of two neighbours, which the pixels' whole sectors make.
    """
    image, kernels = (
        EdgeBins()(ramp(angle, 61, 3.0 + 2)),
        Kernels("one").fitted([1] * 5),
    )
    q = histograms(image, kernels, [[30, 30, angle, 9, 9]])[0, 0]
    assert q[[7, 0, 1]].sum() > 0.95 and q[0] > 0.45


@given(st.floats(-7, 7))
def test_a_whole_sector_moves_the_counts_by_one_bin(angle):
    counts = np.random.default_rng(0).random((2, 3, 11))
    turns = angle + np.array([0, np.pi / 4])
    moved = counts.copy()
    moved[1] = moved[0]
    turned(moved, turns, (2, 8))
    np.testing.assert_allclose(moved[0, :, 2:10], np.roll(moved[1, :, 2:10], 1, -1))
    np.testing.assert_array_equal(moved[0][:, [0, 1, 10]], counts[0][:, [0, 1, 10]])


@given(st.floats(-7, 7))
def test_one_region_is_turned_as_many_are(angle):
    counts = np.random.default_rng(0).random((3, 11, 5))
    several = np.moveaxis(counts.copy(), -1, 0)[None]
    turned(several, np.array([angle]), (2, 8))
    turned_once(counts, angle, (2, 8))
    np.testing.assert_array_equal(counts, np.moveaxis(several[0], 0, -1))


@pytest.mark.parametrize(
    "tracker",
    [
        SSD(bins=BOTH),
        ParticleFilter(n=60, motion=Motion(), bins=BOTH),
        Combined(ParticleFilter(n=40, bins=BOTH), SSD(bins=BOTH)),
    ],
    ids=lambda tracker: type(tracker).__name__,
)
def test_every_tracker_takes_several_bin_images(tracker):
    clip = Scene(CAR, length=6).sequence()
    found = track(tracker, clip, 0).regions[-1]
    assert np.hypot(*(found - clip.truth[-1])[:2]) < 6


@pytest.mark.parametrize(
    "wrong, said",
    [
        (lambda: EdgeBins(0), "directions"),
        (lambda: EdgeBins(255), "254"),
        (lambda: EdgeBins(flat=0), "flat"),
        (lambda: Joined((), ()), "at least one part"),
        (lambda: Joined(PARTS, (1.0,)), "shares has 1"),
        (lambda: Joined(PARTS, (0.0, 0.0)), "not all 0"),
        (lambda: Joined(PARTS, (1.0, -1.0)), "not negative"),
        (lambda: Joined((ColorBins("rgb", (40, 40, 40)),) * 2, (1, 1)), "at most"),
    ],
)
def test_what_makes_no_sense_is_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        wrong()


@pytest.mark.parametrize("part", [SoftBins(), Joined((EdgeBins(),), (1.0,))])
def test_what_has_several_bins_for_a_pixel_cannot_be_joined(part):
    """Their further bins would be lost without a word."""
    with pytest.raises(ValueError, match=f"{type(part).__name__}.*cannot be joined"):
        Joined((part, EdgeBins()), (1.0, 1.0))(FRAME)


class Numbers(EdgeBins):
    """Bins of one's own that forget to say how many there are."""

    def __call__(self, frame):
        """The numbers alone."""
        return super().__call__(frame).labels


def test_a_part_that_makes_no_bin_image_is_named():
    said = r"what Numbers\(.* makes is of the type ndarray; return a BinImage"
    with pytest.raises(ValueError, match=said):
        Joined((ColorBins(), Numbers()), (1.0, 1.0))(FRAME)


def test_three_kinds_of_bins_lie_one_behind_the_other():
    """Each with the numbers, the votes and the turning directions of its own."""
    parts = EdgeBins(6), ColorBins("hs"), EdgeBins(9)
    image = Joined(parts, (1.0, 0.0, 3.0))(FRAME)
    firsts = np.cumsum([0, *(part.m for part in parts)])
    assert image.m == firsts[-1]
    for part, layer, first in zip(parts, image.layers, firsts[:-1], strict=True):
        assert np.array_equal(layer, part(FRAME).labels.astype(int) + first)
    turning = [
        (int(first) + start, n)
        for part, first in zip(parts, firsts[:-1], strict=True)
        for start, n in part(FRAME).compasses
    ]
    assert list(image.compasses) == turning and len(turning) == 2
    votes = np.repeat([0.25, 0, 0.75], [part.m for part in parts])
    assert np.allclose(image.shares, votes)


def test_the_brightness_is_that_of_the_eye_to_which_red_is_brighter_than_blue():
    frame = np.zeros((3, 9, 3), np.uint8)
    frame[:, :4, 2] = frame[:, 4:, 0] = 255
    assert EdgeBins()(frame).labels[1, 3:5].tolist() == [0, 0]


def test_of_directions_too_nothing_is_counted_in_a_region_that_is_not_finite():
    """And the finite regions beside it are counted as if they were alone."""
    frame = np.random.default_rng(0).integers(0, 256, (60, 80, 3), dtype=np.uint8)
    image, kernels = EdgeBins()(frame), Kernels("3x3", aspect=1.5)
    here = np.array([40.0, 30.0, 0.4, 15.0, 10.0])
    both = histograms(image, kernels, [np.full(5, np.nan), here])
    assert (both[0] == 0).all()
    np.testing.assert_array_equal(both[1], histograms(image, kernels, here)[0])
