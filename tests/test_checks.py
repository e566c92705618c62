"""Every refusal names the field, its value and the remedy."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

import mkt
from mkt import checks
from mkt.checks import LONGEST, checked_frame, checked_region, finite


def spec(value):
    return SimpleNamespace(field=value)


def kinds(specification, field):
    checks.one_of(specification, **{field: {"one": 1, "two": 2}})


@pytest.mark.parametrize(
    "check, good, bad, says",
    [
        (
            kinds,
            ["one", "two"],
            ["three", None, ["one"], 1],
            "it must be one of one, two",
        ),
        (
            checks.positive,
            [1, 0.5, np.float64(3), np.float32(3)],
            [0, -1, np.inf, np.float32("inf"), np.nan, 10**400],
            "it must be positive",
        ),
        (
            checks.not_negative,
            [0, 0.5, np.float32(3)],
            [-1, np.inf, np.float32("inf"), np.nan, 10**400],
            "it must be at least 0",
        ),
        (
            checks.grey_levels,
            [0, 7.5, 255],
            [-0.1, 255.1, np.nan],
            "between 0 and 255 grey levels",
        ),
        (checks.shares, [0, 1, 0.5], [-0.1, 1.1, np.nan], "between 0 and 1"),
        (
            checks.flags,
            [True, False, np.bool_(True)],
            ["no", None, 1, 0.0, [True], np.nan],
            "it must be True or False",
        ),
        (
            checks.counts,
            [1, np.int64(5), 100_000],
            [0, -1, 1.0, "3", np.nan, 100_001, 10**400],
            "it must be a whole number, at least 1 and at most 100000",
        ),
    ],
)
def test_fields(check, good, bad, says):
    for value in good:
        check(spec(value), "field")
    for value in bad:
        with pytest.raises(ValueError, match=f"field is .*; .*{says}") as caught:
            check(spec(value), "field")
        assert str(value) in str(caught.value)


@pytest.mark.parametrize(
    "numbers, fit",
    [
        ((1, 2.0), True),
        ((np.float32(1), 2**70), True),
        (np.arange(3, dtype=np.uint8), True),
        (np.arange(3, dtype=np.float32), True),
        (("1", "2"), False),
        ((True, 3), False),
        (np.array([True, False]), False),
        ((10**400, 1), False),
        ((-(10**400), 1), False),
        ((np.float32("inf"), 1), False),
        ((1, -np.inf), False),
        ((1, np.nan), False),
        ((1j, 1), False),
        (((1, 2), (3,)), False),
        ([np.zeros((2, 2)), np.zeros((2, 3))], False),
        ((), False),
        (None, False),
    ],
)
def test_finite_numbers_are_neither_text_nor_true(numbers, fit):
    assert checks.are_finite(numbers, None) is fit


def test_text_true_and_what_is_no_float_are_refused_by_name():
    for made, says in (
        (lambda: mkt.Servo(gain=10**400), "gain is"),
        (lambda: mkt.Experiment(jitter=10**400), "jitter is"),
        (lambda: mkt.Experiment(start=("0",) * 6), "start is"),
        (lambda: mkt.SSD(sizes=("0.3", "3")), "sizes is"),
        (lambda: mkt.SSD(sizes=(True, 3)), "sizes is"),
        (lambda: mkt.Servo(desired=("1",) * 5), "desired is"),
        (lambda: mkt.ColorBins(shift=("1", "2", "3")), "shift is"),
        (lambda: mkt.Adaptive(zones=(("1", "2", "3", "4"),)), "zone .* is unknown"),
        (lambda: mkt.Adaptive(zones=((10**400, 2, 3, 4),)), "zone .* is unknown"),
    ):
        with pytest.raises(ValueError, match=says):
            made()


def test_opencv_takes_the_longest_side_and_no_longer_one():
    place = np.zeros((1, 1), np.float32)
    for frame in np.zeros((1, LONGEST), np.uint8), np.zeros((LONGEST, 1), np.uint8):
        assert cv2.remap(frame, place, place, cv2.INTER_NEAREST) == 0
    with pytest.raises(cv2.error):
        too_long = np.zeros((1, LONGEST + 1), np.uint8)
        cv2.remap(too_long, place, place, cv2.INTER_NEAREST)


def test_a_frame_comes_back_as_an_array():
    frame = np.zeros((2, 3, 3), np.uint8)
    assert checked_frame(frame) is frame
    longest = np.zeros((1, LONGEST, 3), np.uint8)
    assert checked_frame(longest) is longest
    assert checked_frame([[np.array([1, 2, 3], np.uint8)]]).shape == (1, 1, 3)


@pytest.mark.parametrize(
    "frame, says",
    [
        (np.zeros((4, 4), np.uint8), r"not \(4, 4\) uint8; convert it first"),
        (np.zeros((4, 4, 3)), "not .* float64; convert it first"),
        (np.zeros((0, 4, 3), np.uint8), "at least one pixel"),
        (
            np.zeros((1, LONGEST + 1, 3), np.uint8),
            "too large; scale it down to at most",
        ),
    ],
)
def test_what_is_no_frame_is_refused(frame, says):
    with pytest.raises(ValueError, match=says):
        checked_frame(frame)


def test_a_region_comes_back_as_float64():
    region = checked_region([50, 40, 0, 20, 10])
    assert region.dtype == np.float64 and region.tolist() == [50, 40, 0, 20, 10]


@pytest.mark.parametrize(
    "region, says",
    [
        ([1, 2, 3, 4], "regions must have the shape"),
        (np.ones((2, 5)), "one region .* is needed"),
        ([1, 2, np.nan, 4, 5], "is not finite; give five numbers"),
        ([1, 2, 0, 0, 5], "has no area; its half axes hx and hy must be positive"),
        ([1, 2, 0, -4, -5], "has no area"),
        ([1, 2, 0, 1e-200, 1e-200], "has no area"),
    ],
)
def test_what_is_no_region_is_refused(region, says):
    with pytest.raises(ValueError, match=says):
        checked_region(region)


def test_an_estimate_that_is_not_finite_is_refused():
    region = np.array([50.0, 40, 0, 20, 10])
    assert finite(region) is region
    with pytest.raises(ValueError, match="the estimate .* is not finite; check the"):
        finite(region * [1, 1, np.nan, 1, 1])


def test_a_region_in_a_message_is_short_and_on_one_line():
    region = np.array([2.14748365e9, 9.00719925e15, 1 / 3, 5.0, np.inf])
    with pytest.raises(ValueError) as caught:
        checked_region(region)
    said = "the region (2.1475e+09, 9.0072e+15, 0.33333, 5, inf) is not finite; "
    assert str(caught.value).startswith(said)
