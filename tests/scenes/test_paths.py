"""Paths that layers and cameras go."""

import re

import numpy as np
import pytest

from mkt.files import PACKAGE
from mkt.scenes.paths import BEAT, roaming, shaking, spline, way


def test_no_two_stories_draw_the_same_lots():
    texts = [path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")]
    calls = [call for text in texts for call in re.findall(r"\blots\((\w+), ", text)]
    stories = sorted(int(story) for story in calls if story != "story")
    assert len(stories) > 10, "calls are no longer found"
    twice = {story for story in stories if stories.count(story) > 1}
    assert not twice, (
        f"each call of lots needs a number of its own; {stories} are taken"
    )


@pytest.mark.parametrize("seed", range(10))
def test_a_walk_starts_upright_and_in_its_own_size(seed):
    start = spline(roaming(np.random.default_rng(seed)))(0)
    assert start[2:] == pytest.approx([0, 1])


@pytest.mark.parametrize("seed", range(10))
def test_a_walk_starts_from_rest(seed):
    x, y = spline(roaming(np.random.default_rng(seed)))([-0.25, 0, 0.25])[:, :2].T
    assert max(np.ptp(x), np.ptp(y)) < 0.3


def test_a_path_ends_a_frame_after_its_last_point_at_most():
    path = way([0, 10, 20], [60, 200, 100], [100, 60, 180])
    there, later, much_later, inside = spline(path)([19.5, 21, 99, 10])
    assert (later == much_later).all() and tuple(inside[:2]) == (200, 60)
    assert np.abs(later - path[-1][1:])[:2].max() < 30 and (there != later).any()
    assert (spline(path)(-1) == spline(path)(-50)).all()


@pytest.mark.parametrize("seed", range(4))
def test_a_camera_shakes_along_both_axes_turns_and_zooms(seed):
    camera = shaking(np.random.default_rng(seed), 40 * int(BEAT), 10.0, 0.12)
    x, y, turn, scale = np.array(camera)[:, 1:].T
    assert (x[0], y[0], scale[0]) == (0, 0, 1)
    assert (np.std([x, y], axis=1) > 7).all() and 0.005 < turn.std() < 0.02
    zoom = np.log(scale)
    assert zoom.min() < -0.08 and 0.08 < zoom.max() and np.abs(zoom).max() < 0.125
