"""Bins of one's own may lie in the frame as they like: every tracker finds its way."""

from dataclasses import dataclass, replace

import cv2
import numpy as np
import pytest

from mkt.colors import BinImage, ColorBins, Joined, binned
from mkt.evaluation import overlap
from mkt.scenes import SCENES
from mkt.trackers.appearance import background
from mkt.trackers.by_name import TRACKERS
from mkt.trackers.close_up import close_up
from mkt.trackers.ellipses import Disc
from mkt.trackers.ssd import SSD
from mkt.tracking import track


@dataclass(frozen=True)
class Half:
    """Colours of a frame on half the scale, without its first columns."""

    m: int = ColorBins().m
    left: int = 4  # [px] of the small frame

    def __call__(self, frame):
        """The bins."""
        sides = frame.shape[1] // 2, frame.shape[0] // 2
        small = cv2.resize(frame, sides, interpolation=cv2.INTER_AREA)
        labels = ColorBins()(np.ascontiguousarray(small[:, self.left :])).labels
        return BinImage(labels, self.m, origin=(0.5 + 2 * self.left, 0.5), pitch=2)


@pytest.fixture(scope="module")
def clip():
    """Forty frames of the car."""
    return replace(SCENES["base"](0), length=40).sequence()


@pytest.mark.parametrize(
    "tracker",
    [
        SSD(bins=Half()),
        SSD(bins=Joined((Half(), Half()), (2.0, 1.0))),
        replace(TRACKERS["guided"], bins=Half()),
        replace(TRACKERS["pf-500"], bins=Half()),
    ],
    ids=["ssd", "joined", "guided", "pf-500"],
)
def test_on_half_the_scale_the_target_is_kept(tracker, clip):
    found = overlap(track(tracker, clip).regions, clip.truth)
    assert found.mean() > 0.75


def test_hybrid_particles_go_as_far_as_the_frame_does(clip):
    tracker = replace(TRACKERS["pfhr"], bins=Half())
    rng = np.random.default_rng(0)
    start = clip.truth[0].copy()
    start[:2] = 270, 190  # beyond the small frame
    state = tracker.init(clip.frames[0], start, rng)
    _, info = tracker.step(state, clip.frames[1], rng)
    assert np.median(info["particles"][:, 0]) > 240


def test_the_background_lies_where_the_image_does(clip):
    axes = np.full(2, 20.0)
    whole = background(Disc(), ColorBins()(clip.frames[0]), axes)
    half = background(Disc(), Half(left=0)(clip.frames[0]), axes)
    assert whole.shape == half.shape
    assert np.sum(whole * half, 1).mean() > 0.9
    moved = replace(Half(left=0)(clip.frames[0]), origin=(60.0, 40.0))
    np.testing.assert_array_equal(background(Disc(), moved, axes), half)


@dataclass(frozen=True)
class Red:
    """The red of every second pixel of every second row, from the second one on."""

    m: int = 256

    def __call__(self, frame):
        """The bins."""
        labels = frame[1::2, 1::2, 0].astype(np.uint16)
        return BinImage(labels, self.m, origin=(1.0, 1.0), pitch=2)


@pytest.mark.parametrize("pitch", [1, 3])
def test_a_close_up_knows_where_the_pixels_of_such_an_image_lie(pitch):
    """Red is the place along x: it says itself where each pixel is."""
    frame = np.zeros((100, 250, 3), np.uint8)
    frame[..., 0] = np.arange(250)
    region = np.array([[124.0, 50, 0, 20, 10]])
    image = close_up(Red(), frame, np.ones(3), region, pitch)
    assert image.pitch == 2 * pitch
    places = image.origin[0] + image.pitch * np.arange(image.shape[1])
    np.testing.assert_allclose(image.labels[0], places, atol=1)


def test_parts_that_lie_otherwise_are_not_joined(clip):
    with pytest.raises(ValueError, match="all must lie alike in the frame"):
        Joined((ColorBins(), Half()), (1.0, 1.0))(clip.frames[0])


def test_a_part_that_makes_more_bins_than_it_says_is_refused(clip):
    @dataclass(frozen=True)
    class Few(Half):
        m: int = 8

        def __call__(self, frame):
            return replace(ColorBins()(frame), m=255)

    with pytest.raises(ValueError, match=r"Few.* says that m is 8, but makes 255 bins"):
        Joined((Few(), ColorBins()), (1.0, 1.0))(clip.frames[0])


def test_what_makes_no_bin_image_is_named_in_a_close_up_too(clip):
    @dataclass(frozen=True)
    class Numbers(Half):
        def __call__(self, frame):
            return super().__call__(frame).labels

    tracker = replace(TRACKERS["guided"], bins=Numbers())
    with pytest.raises(ValueError, match="ndarray; return a BinImage"):
        tracker.init(clip.frames[0], clip.truth[0], np.random.default_rng(0))


@dataclass(frozen=True)
class Grey:
    """Sixteen greys of every k-th pixel, as they may be laid wrongly into a frame."""

    step: int = 1
    pitch: int = 1
    turned: bool = False
    m: int = 16

    def __call__(self, frame):
        """The bins."""
        labels = frame[:: self.step, :: self.step, 1] // 16
        return BinImage(labels.T if self.turned else labels, self.m, pitch=self.pitch)


@pytest.mark.parametrize("name", ["ssd", "guided", "pf-500", "adaptive", "pfhr"])
@pytest.mark.parametrize("bins", [Grey(2), Grey(3), Grey(1, 2), Grey(turned=True)])
def test_an_image_on_another_scale_than_it_says_is_refused(bins, name, clip):
    tracker = replace(TRACKERS[name], bins=bins)
    with pytest.raises(ValueError, match=r"makes an image .* of a frame .*the pitch"):
        tracker.init(clip.frames[0], clip.truth[0], np.random.default_rng(0))


def test_an_image_may_be_on_another_scale_or_of_a_part():
    frame = np.zeros((61, 80, 3), np.uint8)
    for bins in (Grey(), Grey(2, 2), Grey(3, 3)):
        assert binned(bins, frame).pitch == bins.pitch
    assert binned(lambda frame: ColorBins()(frame[:50]), frame).shape == (50, 80)
