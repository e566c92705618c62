"""Textures by their names."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from mkt.scenes.textures import NAMES, resized, texture

LOOKS = json.loads(Path(__file__).with_name("looks_of_textures.json").read_text())


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


def test_what_is_enlarged_is_smooth():
    car = texture("car")
    size = tuple(2 * side for side in car.shape[1::-1])
    expected = cv2.resize(car, size, interpolation=cv2.INTER_CUBIC)
    np.testing.assert_array_equal(resized("car", 2.0), expected)


@pytest.mark.parametrize("name", NAMES)
def test_a_texture_looks_as_in_the_release(name):
    """Mean and spread of its red, green, blue and opacity: scenes are made of it."""
    pixels = texture(name).reshape(-1, 4)
    found = [pixels.mean(0), pixels.std(0)]
    np.testing.assert_allclose(found, LOOKS[name], atol=0.5)
