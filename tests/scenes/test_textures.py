"""Textures by their names."""

import numpy as np
import pytest

from mkt.scenes.textures import NAMES, resized, texture


@pytest.mark.parametrize("name", NAMES)
def test_every_texture_is_there(name):
    rgba = texture(name)
    assert rgba.ndim == 3 and rgba.shape[2] == 4
    assert rgba.dtype == np.uint8 and rgba[..., :3].std() > 10


def test_a_texture_from_far_away_keeps_two_pixels_a_side():
    assert resized("car", 1e-3).shape == (2, 2, 4)


def test_a_ring_has_a_hole_in_its_middle():
    alpha = texture("ring")[..., 3]
    height, width = alpha.shape
    across = alpha[height // 2, [width // 20, width // 2, -width // 20]]
    assert across.tolist() == [255, 0, 255]


def test_unknown_textures_are_named():
    with pytest.raises(ValueError, match="no texture 'lorry'.*car"):
        texture("lorry")
