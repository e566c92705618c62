"""A close-up shows the part of a frame that regions cover, on a scale that fits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mkt.colors import ColorBins
from mkt.histograms import counts
from mkt.kernels import Kernels
from mkt.regions import area
from mkt.trackers.close_up import close_up, cut_out, fitting_pitch
from tests.trackers.scenes import STANDING

BINS = ColorBins()
FRAME = STANDING.sequence().frames[0]


@given(
    st.tuples(st.floats(-300, 600), st.floats(-300, 600)),
    st.floats(2, 300),
    st.integers(1, 9),
)
def test_a_close_up_shows_what_the_whole_frame_does(place, size, pitch):
    """At its scale, but for samples on the border of two pixels, which may round.

    At any other, wherever it lies, without an error.
    """
    region = np.array([[*place, 0.2, size, size]])
    image = close_up(BINS, FRAME, np.ones(3), region, pitch)
    kernels = Kernels("tiles", "uniform", aspect=1.0)
    assert np.isfinite(counts(image, kernels, region)).all()
    if pitch == 1:
        whole = counts(BINS(FRAME), kernels, region)
        differing = np.abs(counts(image, kernels, region) - whole).sum()
        assert differing < 0.02 * len(kernels.points)


@given(st.floats(1, 600), st.floats(1, 600), st.integers(100, 5000))
def test_of_a_fitting_pitch_samples_meet_pixels_of_their_own(hx, hy, samples):
    """No fewer pixels than samples, and as few as this allows."""
    region = np.array([300.0, 200.0, 0.2, hx, hy])
    pitch = fitting_pitch(Kernels(samples=samples), region)
    pixels = area(region) / np.array([pitch, pitch + 1]) ** 2
    assert pitch == 1 or pixels[0] >= samples * (1 - 1e-9)
    assert pixels[1] < samples * (1 + 1e-9)


def halves(border, axis):
    """A frame that is red before a border along an axis, and blue from there on."""
    frame = np.zeros((240, 320, 3), np.uint8)
    places = np.indices(frame.shape[:2])[axis]
    frame[..., 0], frame[..., 2] = 255 * (places < border), 255 * (places >= border)
    return frame


def test_a_pixel_of_a_small_close_up_is_the_mean_of_its_block():
    """Not one of them: noise goes down with the size."""
    frame = np.zeros((240, 320, 3), np.uint8)
    frame[::2, ::2] = frame[1::2, 1::2] = 200  # a fine chequerboard
    part, origin = cut_out(frame, np.array([101.3, 80.0]), np.array([180.0, 150.9]), 2)
    assert (part == 100).all() and part.shape == (35, 39, 3)
    assert origin == (101.5, 80.5)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("pitch", [1, 2, 3, 5])
def test_a_close_up_knows_where_it_lies(axis, pitch):
    """A border of colours is found where it is in the frame, to a pixel of its own."""
    frame = halves(117, axis)
    region = np.array([[150.0, 115.0, 0.3, 24.0, 18.0]])
    image = close_up(BINS, frame, np.ones(3), region, pitch)
    labels = image.labels if axis else image.labels.T
    red, *_, blue = BINS(frame).labels.ravel()
    first = int(np.argmax(labels[0] == blue))
    assert labels[0, 0] == red and first > 0
    middle = image.origin[1 - axis] + pitch * first  # of the first pixel that is blue
    assert image.pitch == pitch and abs(middle - 117) <= pitch
    assert image.origin[axis] % 1 == (pitch - 1) / 2 % 1


@given(
    st.floats(30, 290), st.floats(30, 210), st.floats(4, 40), st.sampled_from([1, 3])
)
def test_a_close_up_has_room_for_an_optimiser_and_no_more(x, y, half, pitch):
    """Once the largest size all round, and a little; cut at the frame."""
    region = np.array([[x, y, 0.0, half, half / 2]])
    image = close_up(BINS, FRAME, np.ones(3), region, pitch)
    reach = np.hypot(half, half / 2) + np.sqrt(half * half / 2)
    for k, (centre, side) in enumerate(((x, 320), (y, 240))):
        first = image.origin[k] - (pitch - 1) / 2
        last = first + pitch * image.shape[1 - k]
        assert 0 <= first and last <= side
        assert first <= max(centre - reach, 0)
        assert last >= min(centre + reach, side) - pitch
        assert first >= centre - reach - 2 * pitch - 1 or first == 0
        assert last <= centre + reach + 2 * pitch + 1


def test_several_regions_and_none_that_is_finite():
    two = np.array([[100.0, 100, 0, 10, 10], [200.0, 150, 0, 20, 20], [np.nan] * 5])
    image = close_up(BINS, FRAME, np.ones(3), two, 1)
    first, last = image.origin, np.array(image.origin) + image.shape[::-1]
    assert first[0] < 100 - 14 - 20 and last[0] > 200 + 28 + 20
    assert first[1] < 100 - 14 - 20 and last[1] > 150 + 28 + 20
    assert close_up(BINS, FRAME, np.ones(3), two[2:], 1).shape == (240, 320)


@pytest.mark.parametrize("place", [(-500.0, 120.0), (900.0, 120.0), (160.0, -400.0)])
@pytest.mark.parametrize("pitch", [1, 4])
def test_of_a_region_far_outside_some_pixels_of_the_border_are_left(place, pitch):
    region = np.array([[*place, 0.0, 20.0, 20.0]])
    image = close_up(BINS, FRAME, np.ones(3), region, pitch)
    assert min(image.shape) >= 1 and min(image.origin) >= 0
    assert image.origin[0] + pitch * image.shape[1] <= 320 + pitch
