"""Layers: what one may be, and how a twin looks."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from mkt.scenes.layers import Layer, looks
from mkt.scenes.paths import standing
from mkt.scenes.rendering import Scene, render

MIDDLE = standing(160, 120)


def test_look_alikes():
    """A shuffled twin has its colours at other places; a recoloured one has others."""

    def middle(**changes):
        layer = Layer("car", 90.0, MIDDLE, **changes)
        frame = render(Scene(layer, length=1, noise=0.0), 0)
        return frame[95:145, 125:195].astype(float)

    plain, shuffled, recoloured = middle(), middle(shuffle=3), middle(hue=120.0)
    assert np.abs(plain - shuffled).mean() > 20
    assert np.abs(plain.mean((0, 1)) - shuffled.mean((0, 1))).max() < 12
    assert np.abs(plain.mean((0, 1)) - recoloured.mean((0, 1))).max() > 20


def test_a_texture_is_cut_into_no_more_tiles_than_it_has_pixels():
    car = Layer("car", 80.0, MIDDLE, shuffle=51)
    with pytest.raises(ValueError, match="shuffle is 51, but the texture has 50 px"):
        Scene(car, length=1).sequence().frames[0]


def test_points_that_cannot_be_are_refused_with_their_field():
    car = Layer("car", 60.0, MIDDLE)
    for field, points in (
        ("path", ()),
        ("path", ((0.0, 160.0, 120.0, 0.0),)),
        ("path", [(0.0, 160.0, 120.0, 0.0, 1.0)]),
        ("path", ([0.0, 160.0, 120.0, 0.0, 1.0],)),
        ("turn", ((0.0, 1.5),)),
        ("turn", ((0.0,),)),
        ("tilt", ()),
        ("path", ((0.0, np.nan, 120.0, 0.0, 1.0),)),
        ("turn", ((9.0, 0.0), (0.0, 1.0))),
        ("path", ((0.0, 1.0, 1.0, 0.0, 1.0), (0.0, 2.0, 2.0, 0.0, 1.0))),
        ("path", (("a", 0.0, 0.0, 0.0, 1.0),)),
        ("path", ((0.0, (160.0, 0.0), 120.0, 0.0, 1.0),)),
        ("turn", ((0.0, "x"),)),
    ):
        with pytest.raises(ValueError, match=rf"^{field} is .*(give|lies)"):
            replace(car, **{field: points})
    falling = ((20.0, 0.5, 0.5, 0.5), (0.0, 1.0, 1.0, 1.0))
    for field, points in (
        ("light", ()),
        ("camera", ()),
        ("light", ((0.0, 1.0),)),
        ("light", falling),
    ):
        with pytest.raises(ValueError, match=rf"^{field} is .*give"):
            Scene(car, **{field: points})


def test_a_layer_without_width_or_tiles_is_refused():
    with pytest.raises(ValueError, match="^shuffle is 0"):
        Layer("cup", 60.0, MIDDLE, shuffle=0)
    with pytest.raises(ValueError, match="^width is 0"):
        Layer("car", 0.0, MIDDLE)


@pytest.mark.parametrize(
    "field, value",
    [("hue", 10**400), ("hue", -np.inf), ("box", "no"), ("box", None)],
    ids=["hue-huge", "hue-infinite", "box-no", "box-None"],
)
def test_no_hue_and_neither_yes_nor_no_are_refused(field, value):
    with pytest.raises(ValueError, match=f"^{field} is .*; it must be"):
        Layer("car", 60.0, MIDDLE, **{field: value})


def test_an_unknown_texture_and_another_look_that_is_no_layer_are_refused():
    with pytest.raises(ValueError, match="^texture is 'nope'; it must be one of car"):
        Layer("nope", 60.0, MIDDLE)
    with pytest.raises(ValueError, match="^view is of the type str; give a Layer"):
        Layer("car", 60.0, MIDDLE, view="cup")


def test_a_hue_is_turned_by_as_many_degrees_as_it_says():
    layer = Layer("car", 90.0, MIDDLE)
    plain, turned, round_and_on, far = (
        render(Scene(replace(layer, hue=hue), length=1, noise=0.0), 0)
        for hue in (0.0, 90.0, -270.0, 1e20)
    )
    assert (round_and_on == turned).all() and far.shape == plain.shape

    def hues(frame):
        hsv = cv2.cvtColor(frame[95:145, 125:195], cv2.COLOR_RGB2HSV).astype(float)
        return 2 * hsv[..., 0], (hsv[..., 1] > 120) & (hsv[..., 2] > 120)

    (before, strong), (after, _) = hues(plain), hues(turned)
    off = (after - before)[strong] % 360
    assert np.median(off) == pytest.approx(90, abs=4)


def test_nobody_changes_a_look_that_is_kept():
    (look,) = looks(Layer("car", 80.0, standing(160, 120)), np.zeros(1))
    with pytest.raises(ValueError, match="read-only"):
        look[:] = 0
