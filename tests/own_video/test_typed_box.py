"""Boxes that are typed."""

import numpy as np
import pytest

from mkt.own_video.typed_box import parse_box, region_of


@pytest.mark.parametrize(
    "text, region",
    [
        ("10,20,30,40", [24.5, 39.5, 0, 15, 20]),
        ("10.5,20,30,40,-90", [25, 39.5, -np.pi / 2, 15, 20]),
        ("-10, 0,30,40", [4.5, 19.5, 0, 15, 20]),
    ],
)
def test_boxes_are_read_as_annotations_are(text, region):
    frame = np.zeros((120, 160, 3), np.uint8)
    assert np.allclose(region_of(parse_box(text), frame), region)
