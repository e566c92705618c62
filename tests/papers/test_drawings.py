"""Drawings of mechanisms: drawn, in words too, readable, and true to the library."""

import base64
import re

import numpy as np
import pytest

from mkt.papers.lessons import drawings

each = pytest.mark.parametrize("name", drawings.DRAWINGS)


@each
def test_a_drawing_is_a_picture_of_lines_with_words_for_those_who_hear_it(name):
    page = drawings.DRAWINGS[name]().data
    svg = base64.b64decode(re.search(r'base64,([^"]+)"', page)[1]).decode()
    assert svg.count("<path") > 20 and "<image" not in svg
    assert len(re.search(r'alt="([^"]+)"', page)[1]) > 100
    assert drawings.DRAWINGS[name]().data == page  # the same every time


@each
def test_its_letters_are_large_enough_and_inside(name):
    fig = drawings.DRAWINGS[name].figure()
    fig.canvas.draw()
    frame = fig.bbox
    texts = [text for text in fig.findobj(match=_is_text) if text.get_text()]
    assert texts
    for text in texts:
        assert text.get_fontsize() * drawings.PIXELS / 72 >= 10
        box = text.get_window_extent()
        if text.get_visible() and box.width:
            assert box.x0 >= frame.x0 - 1 and box.x1 <= frame.x1 + 1, text.get_text()
            assert box.y0 >= frame.y0 - 1 and box.y1 <= frame.y1 + 1, text.get_text()


def _is_text(artist):
    return hasattr(artist, "get_fontsize") and hasattr(artist, "get_window_extent")


def test_the_eight_particles_keep_the_rules_of_the_filter():
    made = drawings.eight()
    assert made["weights"].sum() == pytest.approx(1)
    offspring = np.bincount(made["ancestors"], minlength=8)
    assert np.abs(offspring - 8 * made["weights"]).max() < 1
    stayed = abs(made["before"].mean() - made["truth"])
    assert abs(made["estimate"] - made["truth"]) < stayed / 3


def test_the_product_of_two_bells_is_one_step_of_a_kalman_filter():
    mean, variance = drawings.bells((0.0, 4.0), (3.0, 2.0))
    x = np.linspace(-20, 20, 40001)
    density = np.exp(-(x**2) / 8 - (x - 3) ** 2 / 4)
    density /= density.sum()
    assert density @ x == pytest.approx(mean)
    assert density @ (x - mean) ** 2 == pytest.approx(variance)


def test_while_the_ellipse_creeps_off_the_gate_lets_every_step_pass():
    score, car = drawings.creep(0.6, np.linspace(1, 0, 6))
    assert (score > 0.8).all() and car[-1] < 0.8
    leap, _ = drawings.creep(0.6, np.array([1.0, 0.0]))
    assert leap[1] < 0.8
