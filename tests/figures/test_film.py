"""The pictures of a film, drawn on a figure that has a background of its own."""

import numpy as np
import pytest

from mkt.figures.film import drawn, play, stage


def first_picture(before: str) -> np.ndarray:
    """A picture with a title of its own, on a figure that had another before."""
    fig, left, _right = stage(2.0, 5)
    left.set_title(before)
    return next(drawn(fig, lambda _: left.set_title("frame 1"), [0]))


@pytest.mark.parametrize("fps", [0, -5, np.nan, np.inf, "5"])
def test_a_film_needs_a_pace(fps):
    with pytest.raises(ValueError, match="^fps is .*above 0"):
        play([np.zeros((20, 20, 3), np.uint8)], fps, "black")


def test_a_film_is_of_pictures():
    with pytest.raises(ValueError, match="uint8 RGB"):
        play([np.zeros((20, 20, 3))], 5, "black")


def test_a_title_takes_the_place_of_the_one_that_the_figure_had():
    assert np.array_equal(first_picture("the start, in words"), first_picture(""))


def test_a_title_that_stays_is_in_each_picture():
    fig, left, _right = stage(2.0, 5)
    without, again = drawn(fig, lambda _: None, [0, 1])
    left.set_title("here")
    first, second = drawn(fig, lambda _: None, [0, 1])
    assert np.array_equal(first, second) and np.array_equal(without, again)
    assert not np.array_equal(first, without)


def test_a_title_is_drawn_again_once_the_film_is_over():
    fig, left, _right = stage(2.0, 5)
    list(drawn(fig, lambda _: None, range(2)))
    assert not left.title.get_animated()


def test_a_picture_keeps_nothing_of_the_one_before():
    fig, left, _right = stage(2.0, 5)

    def draw(k):
        left.plot([0, 1], [k, 1 - k], "black")

    left.set(xlim=(0, 1), ylim=(0, 1))
    (alone,) = drawn(fig, draw, [1])
    _, second = drawn(fig, draw, [0, 1])
    assert np.array_equal(second, alone)


@pytest.mark.parametrize("black_above", [False, True])
def test_what_stands_above_in_the_figure_stands_above_in_the_picture(black_above):
    fig, left, _right = stage(2.0, 5)
    left.set(xlim=(0, 1), ylim=(0, 1))

    def draw(_):
        left.plot([0, 1], [0.5, 0.5], "black", lw=9, zorder=3 if black_above else 1)
        left.plot([0, 1], [0.5, 0.5], "white", lw=9, zorder=2)

    (picture,) = drawn(fig, draw, [0])
    height, width = picture.shape[:2]
    middle = picture[height // 3 : -height // 3, width // 5 : width // 3]
    assert (middle.min() < 50) == black_above
