"""The pictures of a film, drawn on a figure that has a background of its own."""

import numpy as np

from mkt.figures.film import drawn, stage


def first_picture(before: str) -> np.ndarray:
    """A picture with a title of its own, on a figure that had another before."""
    fig, left, _right = stage(2.0, 5)
    left.set_title(before)
    return next(drawn(fig, lambda _: left.set_title("frame 1"), [0]))


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
