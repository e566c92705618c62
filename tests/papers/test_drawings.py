"""Drawings of mechanisms: drawn, in words too, readable, and true to the library."""

import base64
import re

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from mpl_toolkits.mplot3d.art3d import Text3D
from mpl_toolkits.mplot3d.proj3d import proj_transform

from mkt.figures.registry import FIGURES
from mkt.histograms import coefficient
from mkt.papers.lessons import (
    drawings,
    drawings_of_cameras,
    drawings_of_looks,
    pencil,
    wished,
)
from mkt.papers.nummiaro2003.sequences import WITH
from mkt.papers.nummiaro2003.steps import MISSED
from mkt.servoing.robot import Workspace, move

each = pytest.mark.parametrize("name", pencil.DRAWINGS)


@each
def test_a_drawing_is_a_picture_of_lines_with_words_for_those_who_hear_it(name):
    page = pencil.DRAWINGS[name]().data
    svg = base64.b64decode(re.search(r'base64,([^"]+)"', page)[1]).decode()
    assert svg.count("<path") > 20 and "<image" not in svg
    assert len(re.search(r'alt="([^"]+)"', page)[1]) > 100
    assert pencil.DRAWINGS[name]().data == page  # the same every time


@each
def test_its_letters_are_large_enough_and_inside(name):
    fig = pencil.DRAWINGS[name].figure()
    fig.canvas.draw()
    frame = fig.bbox
    texts = [text for text in fig.findobj(match=_is_text) if text.get_text()]
    assert texts
    for text in texts:
        assert text.get_fontsize() * pencil.PIXELS / 72 >= 10
        box = _projected(text).get_window_extent()
        if text.get_visible() and box.width:
            assert box.x0 >= frame.x0 - 1 and box.x1 <= frame.x1 + 1, text.get_text()
            assert box.y0 >= frame.y0 - 1 and box.y1 <= frame.y1 + 1, text.get_text()


def _projected(text):
    """A text; one in space where its axes put it on the Figure."""
    if isinstance(text, Text3D):
        x, y, _ = proj_transform(*text.get_position_3d(), text.axes.get_proj())
        text.set_position((x, y))
    return text


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


def test_a_drawing_has_the_colours_of_its_chapters_figure():
    *_, prior = drawings_of_looks.two_kinds_of_bins.figure().axes
    middle = FIGURES["own.priors"].draw()[0].axes[1]
    named = [
        {line.get_label(): line.get_color() for line in ax.lines}
        for ax in (prior, middle)
    ]
    for first, second in (("$O$", "O"), ("prior", "prior"), ("sum", "sum")):
        assert named[0][first] == named[1][second]
    motion = drawings_of_looks.four_wishes.figure().axes[2]
    rings = [line.get_mec() for line in motion.lines[1:]]
    assert rings == [wished.MODELS["by hand"], wished.MODELS["learnt on swift"]]
    two = [patch.get_ec() for patch in drawings.two_modes.figure().axes[0].patches]
    assert {to_rgba(WITH), to_rgba(MISSED)} <= set(two)


def test_every_chapter_has_a_drawing():
    numbers = {name.split()[0] for name in pencil.DRAWINGS}
    assert numbers == {f"{k:02}" for k in range(1, 18)}


def test_the_kernel_that_slides_off_the_roof_sees_other_colours():
    before = drawings_of_looks.toy_histogram(*drawings_of_looks.BEFORE)
    after = drawings_of_looks.toy_histogram(*drawings_of_looks.AFTER)
    assert before.sum() == pytest.approx(1) and after.sum() == pytest.approx(1)
    ground, _, roof, stripe = after - before
    assert roof < 0 < stripe and ground >= 0
    assert 0.3 < coefficient(before, after) < 0.95


def test_the_ball_stays_turned_in_the_valley_and_finds_the_bottom_of_the_pit():
    ends = {}
    for layout in ("one", "3x3"):
        x, degrees, z = drawings_of_looks.landscape(layout)
        way = drawings_of_looks.rolled(z, (14, 14))
        assert (x[way[0][1]], degrees[way[0][0]]) == (15, 45)
        assert all(z[b] < z[a] for a, b in zip(way, way[1:], strict=False))
        ends[layout] = x[way[-1][1]], degrees[way[-1][0]]
    assert ends["3x3"] == (0, 0)
    assert abs(ends["one"][0]) <= 2.5 and ends["one"][1] >= 24


def test_while_the_shutter_is_open_no_pixel_keeps_its_colour():
    (ax,) = drawings_of_looks.open_shutter.figure().axes
    pixels = np.array([patch.get_facecolor()[:3] for patch in ax.patches])
    *moved, frame = pixels.reshape(5, -1, 3)
    assert frame == pytest.approx(np.mean(moved, axis=0))
    colours = np.unique(moved[0], axis=0)
    ground = np.all(frame == frame[0], axis=1)
    assert len(colours) == 4 and ground.sum() == 11
    assert all(np.abs(colours - pixel).max(1).min() > 0.05 for pixel in frame[~ground])


def test_the_motion_that_is_not_noticed_leaves_the_car_where_it_is():
    workspace = Workspace()
    car = drawings_of_cameras.CAR
    pose = workspace.facing(drawings_of_cameras.MIDDLE_OF_IMAGE, car)
    twist = drawings_of_cameras.circling(workspace, pose)
    there = move(pose, twist, 0.35)
    off = workspace.truth(there, car) - drawings_of_cameras.MIDDLE_OF_IMAGE
    corner = np.array([[0.4, 0.3, 0.0]])
    seen = [
        drawings_of_cameras.projected(workspace.camera, each, corner)
        for each in (pose, there)
    ]
    assert np.abs(off[:2]).max() < 3 < 30 < np.abs(seen[1] - seen[0]).max()
    assert np.linalg.norm(there[:3, 3] - pose[:3, 3]) > 0.3


@pytest.mark.parametrize("delay", [0, 1, 2, 3])
def test_the_error_after_a_push_shrinks_as_its_largest_pole_says(delay):
    gain = drawings_of_cameras.SAME_GAIN
    polynomial = np.zeros(delay + 2)
    polynomial[:2] += 1, -1
    polynomial[-1] += gain
    pole = np.abs(np.roots(polynomial)).max()
    errors = drawings_of_cameras.delayed(gain, delay, 400)
    late = [np.abs(errors[k : k + 40]).max() for k in (200, 240)]
    if pole > 1 or delay > 0:
        assert (late[1] / late[0]) ** (1 / 40) == pytest.approx(pole, abs=0.01)
    assert (late[1] > late[0]) == (pole > 1) == (delay == 3)


def test_two_neighbouring_hues_become_alike_once_they_share():
    before, after = drawings_of_looks.next_hues()
    assert coefficient(*before) == 0 and coefficient(*after) > 0.4
    assert after.sum(axis=1) == pytest.approx(1)


def test_the_card_that_turns_away_is_no_rectangle_in_the_image():
    workspace = Workspace(width=0.3)
    pose = drawings_of_cameras.turned_card(np.deg2rad(55), 0.5)
    corners = workspace.outline(pose, (0, 0, 0))
    left, right = (np.ptp(corners[ends, 1]) for ends in ([0, 3], [1, 2]))
    assert max(left, right) > 1.3 * min(left, right)
    centre = drawings_of_cameras.projected(workspace.camera, pose, np.zeros((1, 3)))
    assert centre[0] == pytest.approx([159.5, 119.5])
