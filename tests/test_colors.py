"""Bins: each colour has one, as the standard library would say, and bad ones refuse."""

import colorsys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mkt.checks import LONGEST
from mkt.colors import BinImage, ColorBins, JointHSV, label_type

BINS = [
    ColorBins(),
    ColorBins("hsv", (8, 8, 8)),
    ColorBins("rgb"),
    ColorBins("rgb", (4, 5, 6)),
    ColorBins("hs"),
]


def label(bins, color):
    """The bin of one colour (r, g, b)."""
    return bins(np.array([[color]], np.uint8)).labels[0, 0]


@pytest.mark.parametrize("bins", BINS, ids=str)
def test_bins_cover_their_range_and_nothing_else(bins):
    steps = np.arange(0, 256, 5, dtype=np.uint8)
    colours = np.stack(np.meshgrid(steps, steps, steps), -1).reshape(52, -1, 3)
    labels = bins(colours).labels
    # Ten steps of saturation, of which the first is all grey.
    lowest = 1 if bins == ColorBins() else 0
    assert labels.min() == lowest and labels.max() == bins.m - 1
    assert labels.dtype == label_type(bins.m)


def test_grey_and_dark_pixels_go_to_value_bins():
    bins = ColorBins()
    grey = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 3, 1)[None]
    assert (bins(grey).labels == 100 + np.arange(256) * 10 // 256).all()
    assert label(bins, [40, 0, 0]) >= 100  # V = .16: too dark for its hue to mean much
    assert label(bins, [200, 20, 30]) < 100


@given(st.tuples(*[st.integers(0, 255)] * 3))
def test_hsv_bins_follow_the_standard_library(rgb):
    h, s, v = colorsys.rgb_to_hsv(*(c / 255 for c in rgb))
    steps = np.array([10 * h, 10 * s, 10 * v])
    on_a_border = np.abs(steps - np.round(steps)).min() <= 0.1
    if on_a_border or abs(s - 0.1) <= 0.02 or abs(v - 0.2) <= 0.02:
        return
    hue, saturation, value = steps.astype(int)
    colourful = s > 0.1 and v > 0.2
    expected = 10 * hue + saturation if colourful else 100 + value
    assert label(ColorBins(), rgb) == expected


def test_rgb_bins_are_joint():
    assert label(ColorBins("rgb"), [255, 0, 32]) == 7 * 64 + 0 * 8 + 1


@given(st.tuples(*[st.integers(0, 255)] * 3))
def test_joint_bins_count_hue_saturation_and_value_together(rgb):
    h, s, v = colorsys.rgb_to_hsv(*(c / 255 for c in rgb))
    steps = np.array([8 * h, 8 * s, 4 * v])
    if np.abs(steps - np.round(steps)).min() > 0.1:
        hue, saturation, value = steps.astype(int)
        assert label(JointHSV(), rgb) == (8 * hue + saturation) * 4 + value


@pytest.mark.parametrize("bins", [*BINS, JointHSV()], ids=str)
def test_an_image_knows_its_number_of_bins(bins):
    image = bins(np.zeros((4, 6, 3), np.uint8))
    assert image.m == bins.m and image.shape == image.labels.shape == (4, 6)


def test_numbers_beyond_the_bins_are_refused():
    """They would be counted in foreign memory."""
    labels = np.array([[0, 9]], np.uint8)
    assert BinImage(labels, 10).m == 10
    for m in (9, 1, 0, -1):
        with pytest.raises(ValueError, match=f"m is {m}, .* up to 9.*; give the m of"):
            BinImage(labels, m)
    with pytest.raises(ValueError, match="m is 256, and uint8 has no number left"):
        BinImage(labels, 256)  # no number is left for what lies outside


@pytest.mark.parametrize(
    "more, said",
    [
        ({"others": (np.zeros((3, 4), np.uint16),)}, "others .* uint16, .* alike"),
        ({"others": (np.zeros((3, 3), np.uint8),)}, r"others .*\(3, 3\).* alike"),
        ({"shares": np.ones(3, np.float32)}, "shares .* each of the 5 bins"),
        ({"shares": np.full(5, np.nan)}, "shares must be finite, not negative"),
        ({"shares": np.array([-1.0, 1, 1, 1, 1])}, "shares must be finite, not neg"),
        ({"shares": np.zeros(5)}, "shares must be .* not all 0"),
        ({"compasses": ((3, 10),)}, r"compasses has \(3, 10\), .* 0 to 4"),
        ({"compasses": ((4, 2),)}, r"compasses has \(4, 2\)"),
        ({"compasses": ((-1, 2),)}, r"compasses has \(-1, 2\)"),
        ({"compasses": ((0.0, 3.0),)}, r"compasses has \(0.0, 3.0\)"),
        ({"compasses": (0, 3)}, "compasses has 0, but bins"),
        ({"compasses": 3}, "compasses is of the type int; give a tuple"),
        ({"compasses": None}, "compasses is of the type NoneType; give a tuple"),
        ({"others": None}, "others is of the type NoneType; give a tuple of arrays"),
        ({"others": np.array(2)}, "others is of the type ndarray; give a tuple"),
        ({"shares": ("1",) * 5}, "shares must be finite"),
        ({"shares": (None,) * 5}, "shares must be finite"),
        ({"origin": (np.nan, 0)}, "origin is .*; give two finite numbers"),
        ({"origin": 3}, "origin is 3; give two"),
        ({"origin": (1, 2, 3)}, "origin is .*; give two"),
        ({"pitch": 0}, "pitch is 0"),
        ({"pitch": 1.5}, "pitch is 1.5"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_layers_that_differ_and_what_does_not_fit_the_bins_is_refused(more, said):
    """Half of what cv2.remap would count in them lies in foreign memory."""
    with pytest.raises(ValueError, match=said):
        BinImage(np.zeros((3, 4), np.uint8), 5, **more)


def test_the_number_of_bins_is_whole():
    with pytest.raises(ValueError, match="m is 5.0; it must be a whole number"):
        BinImage(np.zeros((3, 4), np.uint8), 5.0)


@pytest.mark.parametrize(
    "labels",
    [
        np.zeros((4, 4, 3), np.uint8),
        np.zeros((4, 4), int),
        np.zeros((4, 4)),
        np.zeros((0, 4), np.uint8),
        [[0, 1]],
    ],
    ids=["a frame", "long numbers", "fractions", "nothing", "a list"],
)
def test_what_is_no_image_of_bins_is_refused(labels):
    with pytest.raises(ValueError, match="labels must be .* with ColorBins"):
        BinImage(labels, 2)


@pytest.mark.parametrize(
    "frame",
    [
        np.zeros((4, 4), np.uint8),
        np.zeros((4, 4, 4), np.uint8),
        np.zeros((4, 4, 3), np.uint16),
    ],
)
def test_wrong_frames_are_refused(frame):
    with pytest.raises(ValueError, match="uint8 RGB"):
        ColorBins()(frame)


@pytest.mark.parametrize(
    "arguments",
    [
        {"space": "lab"},
        {"counts": (3, 3)},
        {"counts": 0},
        {"counts": (0, 1, 1)},
        {"space": "rgb", "counts": (64, 64, 64)},
        {"s_min": 1.5},
        {"v_min": -0.1},
        {"v_min": "dark"},
        {"shift": (0, 0)},
        {"shift": (np.nan, 0, 0)},
        {"shift": 0.5},
    ],
)
def test_bad_bins_are_named(arguments):
    with pytest.raises(ValueError, match=list(arguments)[-1]):
        ColorBins(**arguments)


@pytest.mark.parametrize("counts", [(8, 8), (8, 8, 0)])
def test_bad_joint_bins_are_named(counts):
    with pytest.raises(ValueError, match="counts is .* hue, saturation and value"):
        JointHSV(counts)


def test_the_limits_of_colour_themselves_count_as_grey_and_dark():
    """V = 51 is .2 of 255: [T09] calls a pixel colourful only above the limits."""
    assert label(ColorBins(), [51, 0, 0]) == 100 + 51 * 10 // 256
    assert label(ColorBins(), [52, 0, 0]) < 100
    fifth = ColorBins(s_min=0.2)  # S = 51 of 255
    assert label(fifth, [255, 204, 204]) == 109
    assert label(fifth, [255, 203, 203]) < 100


def test_the_bins_of_each_space_by_default_are_the_printed_ones():
    sizes = {space: ColorBins(space).m for space in ("hsv", "rgb", "hs")}
    assert sizes == {"hsv": 110, "rgb": 512, "hs": 100} and JointHSV().m == 256


def test_the_largest_number_of_a_bin_is_one_less_than_m():
    labels = np.array([[0, 3]], np.uint8)
    assert BinImage(labels, 4).m == 4
    with pytest.raises(ValueError, match="m is 3"):
        BinImage(labels, 3)
    assert BinImage(np.zeros((1, 1), np.uint8), 255).m == 255
    with pytest.raises(ValueError, match="m is 256"):
        BinImage(np.zeros((1, 1), np.uint8), 256)  # 256 would stand for outside


def test_the_longest_side_is_taken_and_one_more_is_not():
    assert BinImage(np.zeros((1, LONGEST), np.uint8), 1).shape == (1, LONGEST)
    with pytest.raises(ValueError, match=str(LONGEST)):
        BinImage(np.zeros((1, LONGEST + 1), np.uint8), 1)


def test_a_shift_of_half_a_bin_begins_the_next_bin_half_a_bin_earlier():
    bins = ColorBins("rgb", shift=(0.5, 0.0, 0.0))
    reds = np.array([[[15, 0, 0], [16, 0, 0], [255, 0, 0]]], np.uint8)
    assert bins(reds).labels[0].tolist() == [0, 64, 7 * 64]


@pytest.mark.parametrize("space", ["hsv", "hs"])
def test_hues_are_shifted_round_the_circle(space):
    """Half a bin, so that reds on both sides of 0 degrees come into one."""
    red, below, above = [255, 0, 0], [255, 0, 50], [255, 50, 0]
    plain = {int(label(ColorBins(space), one)) for one in (red, below, above)}
    shifted = ColorBins(space, shift=(0.5, 0.0, 0.0))
    found = {int(label(shifted, one)) for one in (red, below, above)}
    assert len(plain) == 2 and len(found) == 1


def test_a_shift_up_leaves_the_darkest_in_the_first_bin():
    bins = ColorBins("rgb", shift=(-0.5, 0.0, 0.0))
    reds = np.array([[[0, 0, 0], [47, 0, 0], [48, 0, 0], [255, 0, 0]]], np.uint8)
    assert bins(reds).labels[0].tolist() == [0, 0, 64, 7 * 64]
