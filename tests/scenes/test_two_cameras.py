"""A path of the target behind a wall, seen by two cameras."""

import cv2
import numpy as np

from mkt.scenes.textures import texture
from mkt.scenes.two_cameras import SIZE, TwoViews


def test_the_path_begins_upright_and_the_wall_is_where_it_is_said_to_be():
    views = TwoViews(3)
    assert views.truth[0, 2] == 0
    bricks = cv2.resize(texture("bricks"), SIZE)[..., :3]
    same = (views.frames(0)[0] == bricks).all((0, 2))
    assert np.flatnonzero(same)[[0, -1]].tolist() == [130, 189]
