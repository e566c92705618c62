"""Cards in space: the truth is where the card is, through a pinhole camera."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mkt.homographies import of_regions, through
from mkt.scenes.cards import KINDS, card
from mkt.scenes.drawn import HELD_BACK
from mkt.scenes.layers import Layer
from mkt.scenes.paths import STILL, spline
from mkt.scenes.rendering import Scene, homographies, regions
from mkt.scenes.textures import texture

TIMES = np.arange(120)


def test_the_truth_is_a_pinholes():
    """Corner by corner: turned in space, moved there, divided by the depth."""
    layer = Layer("cat", 100.0, ((0.0, 190.0, 90.0, 0.4, 1.2),), tilt=((0, 0.5, -0.3),))
    scene = Scene(layer, focal=300.0)
    found = homographies(scene, layer, np.float64(0))
    hx, hy = regions(scene, layer, np.float64(0))[3:]
    square = np.array([[-1, -1], [1, -1], [0.5, 1], [0, 0]])
    turn = Rotation.from_rotvec([0, 0, 0.4]) * Rotation.from_rotvec([0, -0.3, 0])
    turn = turn * Rotation.from_rotvec([0.5, 0, 0])
    there = turn.apply(np.column_stack([square * [hx, hy], np.zeros(4)]))
    there += [190 - 159.5, 90 - 119.5, 300]
    wanted = 300 * there[:, :2] / there[:, 2:] + [159.5, 119.5]
    assert np.allclose(through(found, square), wanted)


def test_a_layer_without_tilt_is_its_region():
    scene = card("base", 5)
    flat = replace(scene.target, tilt=Layer("cat", 1.0, STILL).tilt)
    seen = homographies(scene, flat, TIMES)
    assert (seen == of_regions(regions(scene, flat, TIMES))).all()
    assert np.allclose(homographies(scene, scene.target, 0), seen[0])


@pytest.mark.parametrize("k", [0, 30])
def test_the_card_is_rendered_where_the_truth_has_it(k):
    """The frame, pulled back through the truth, is the card's texture."""
    scene = replace(card("base", 501), shutter=0.0, noise=0.0)
    frame = scene.sequence().frames[k].astype(float)
    h = homographies(scene, scene.target, float(k))
    ij = np.stack(
        np.meshgrid(np.linspace(-0.9, 0.9, 40), np.linspace(-0.9, 0.9, 30)), -1
    )
    x, y = np.rint(through(h, ij.reshape(-1, 2))).astype(int).T
    rgba = texture(scene.target.texture).astype(float)
    height, width = rgba.shape[:2]
    u, v = ((ij.reshape(-1, 2) + 1) / 2 * [width, height]).astype(int).T
    grey, wanted = frame[y, x].mean(-1), rgba[v, u, :3].mean(-1)
    shifted = frame[y, x + 12].mean(-1)
    assert np.corrcoef(grey, wanted)[0, 1] > 0.85
    assert np.corrcoef(shifted, wanted)[0, 1] < np.corrcoef(grey, wanted)[0, 1] - 0.2


@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_is_what_it_says(kind):
    clip = card(kind, 7).sequence()
    assert len(clip) == 120 and np.isfinite(clip.truth).all()
    assert (clip.visibility.min() < 0.9) == (kind == "occlusion")
    assert clip.visibility.max() == pytest.approx(1, abs=0.02)
    assert clip.visibility.min() > 0.4


def test_a_slab_hides_less_than_a_third_of_the_cards_that_are_held_back():
    seen = [card("occlusion", seed).sequence().visibility.min() for seed in HELD_BACK]
    assert 1 - min(seen) == pytest.approx(0.29, abs=0.005)


def test_cards_turn_about_both_axes_and_now_and_then_far():
    tilts = [spline(card("base", seed).target.tilt)(TIMES) for seed in HELD_BACK]
    degrees = np.abs(np.rad2deg(tilts))
    assert (degrees[:, 0] == 0).all()
    assert (degrees.max((0, 1)) > 60).all() and degrees.max() < 80
    assert degrees.max((1, 2)).min() > 25  # in every scene
