"""The two sequences of [T09] are what its sentences say of them.

Both are fast.  The one is blurred by its exposure; the other is of a fixed size, and
totally hidden from frame 46 on.
"""

from dataclasses import replace

import numpy as np
import pytest

from mkt.evaluation import errors
from mkt.scenes.paths import WIDTH
from mkt.scenes.teuliere2009 import fast, hidden

SEEDS = range(4)


def speeds(truth):
    """Speed of the centre [px/frame], once it has left its rest."""
    return np.linalg.norm(np.diff(truth[4:, :2], axis=0), axis=1)


@pytest.mark.parametrize("frames", [5, 10])
@pytest.mark.parametrize(
    "item, ground",
    [("car", "workshop"), ("astronaut", "bricks"), ("hopper", "fur")],
)
def test_the_target_is_hidden_in_just_these_frames(item, ground, frames):
    for seed in SEEDS:
        visible = hidden(seed, item, ground, frames=frames).sequence().visibility
        behind = set(np.flatnonzero(visible < 0.001))
        assert set(range(46, 46 + frames)) <= behind
        assert behind <= set(range(45, 46 + frames + 1))
        assert visible[38] > 0.7 and visible[46 + frames + 8] > 0.7


@pytest.mark.parametrize("frames", [0, -3, -30, 2.5])
def test_a_target_is_hidden_for_a_frame_at_least(frames):
    with pytest.raises(ValueError, match="^frames is .*at least 1"):
        hidden(0, frames=frames)


def test_no_exposure_sees_the_hidden_target():
    """The frames behind the screen are the same whatever the target is."""
    scene = replace(hidden(1), noise=0.0)
    other = replace(scene, target=replace(scene.target, hue=120.0))
    frames, others = scene.sequence().frames, other.sequence().frames
    for k in range(46, 51):
        assert (frames[k] == others[k]).all()
    assert (frames[40] != others[40]).any()


@pytest.mark.parametrize("scene, least", [(fast, 0.1), (hidden, 0.06)])
def test_motion_is_fast_and_the_target_stays_in_view(scene, least):
    truths = [scene(seed).sequence().truth for seed in SEEDS]
    assert np.mean([speeds(truth).mean() for truth in truths]) > least * WIDTH
    assert all(np.ptp(np.unwrap(truth[:, 2])) > np.deg2rad(30) for truth in truths)
    centres = np.concatenate(truths)[:, :2]
    assert (centres > 20).all() and (centres < [300, 220]).all()


def test_size_changes_in_the_one_and_not_in_the_other():
    for seed in SEEDS:
        assert np.ptp(np.log(fast(seed).sequence().truth[:, 3])) > 0.1
        sides = hidden(seed).sequence().truth[:, 3:]
        assert np.ptp(sides, axis=0) == pytest.approx(0)


def difference(a, b):
    """The mean difference of two frames [grey levels]."""
    return np.abs(a.astype(float) - b).mean()


def test_blur_is_the_exposure():
    """The longer the shutter is open, the further the frame is from the frozen one.

    The truth stays, and the first frame hardly changes.
    """
    frozen, half, most = (
        replace(fast(2, exposure=exposure), noise=0.0).sequence()
        for exposure in (0.0, 0.5, 0.9)
    )
    k = 1 + int(np.argmax(np.linalg.norm(np.diff(frozen.truth[:, :2], axis=0), axis=1)))
    away = [difference(clip.frames[k], frozen.frames[k]) for clip in (half, most)]
    assert 0 < away[0] < away[1]
    assert (frozen.truth == most.truth).all()
    assert difference(most.frames[0], frozen.frames[0]) < away[0] / 3


@pytest.mark.parametrize("scene", [fast, hidden])
def test_the_seed_is_the_path_and_the_noise_another_thing(scene):
    first, again, other, noisy = (
        each.sequence()
        for each in (scene(3), scene(3), scene(4), replace(scene(3), seed=9))
    )
    assert (first.frames[20] == again.frames[20]).all()
    assert errors(first.truth, other.truth).position.max() > WIDTH / 2
    assert (first.truth == noisy.truth).all()
    assert (first.frames[20] != noisy.frames[20]).any()
