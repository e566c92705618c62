"""The two sequences of [T09] are what its sentences say: fast, blurred by exposure; fast, of a fixed size, totally hidden from frame 46 on."""

from dataclasses import replace

import numpy as np
import pytest

from mkt.evaluation import errors
from mkt.scenarios import WIDTH, fast, hidden
from mkt.scenes import sequence

SEEDS = range(4)


def speeds(truth):
    """Speed of the centre [px a frame], once it has left its rest."""
    return np.linalg.norm(np.diff(truth[4:, :2], axis=0), axis=1)


@pytest.mark.parametrize("frames", [5, 10])
@pytest.mark.parametrize("object, background", [("car", "workshop"), ("astronaut", "bricks"), ("hopper", "fur")])
def test_the_target_is_hidden_in_just_these_frames(object, background, frames):
    for seed in SEEDS:
        visible = sequence(hidden(seed, object, background, frames=frames)).visibility
        behind = np.flatnonzero(visible < 0.001)
        assert set(range(46, 46 + frames)) <= set(behind) <= set(range(45, 46 + frames + 1))
        assert visible[38] > 0.7 and visible[46 + frames + 8] > 0.7


def test_no_exposure_sees_the_hidden_target():
    """The frames behind the screen are the same whatever the target is."""
    scene = replace(hidden(1), noise=0.0)
    other = replace(scene, target=replace(scene.target, hue=120.0))
    for k in range(46, 51):
        assert (sequence(scene).frames[k] == sequence(other).frames[k]).all()
    assert (sequence(scene).frames[40] != sequence(other).frames[40]).any()


@pytest.mark.parametrize("scenario, least", [(fast, 0.1), (hidden, 0.06)])
def test_motion_is_fast_and_the_target_stays_in_view(scenario, least):
    truths = [sequence(scenario(seed)).truth for seed in SEEDS]
    assert np.mean([speeds(truth).mean() for truth in truths]) > least * WIDTH
    assert all(np.ptp(np.unwrap(truth[:, 2])) > np.deg2rad(30) for truth in truths)
    centres = np.concatenate(truths)[:, :2]
    assert (centres > 20).all() and (centres < [300, 220]).all()


def test_size_changes_in_the_one_and_not_in_the_other():
    for seed in SEEDS:
        assert np.ptp(np.log(sequence(fast(seed)).truth[:, 3])) > 0.1
        assert np.ptp(sequence(hidden(seed)).truth[:, 3:], axis=0) == pytest.approx(0)


def test_blur_is_the_exposure():
    """The longer the shutter is open, the further the frame is from the frozen one; truth and first frame hardly change."""
    frozen, half, open_ = (sequence(replace(fast(2, exposure=e), noise=0.0)) for e in (0.0, 0.5, 0.9))
    k = 1 + int(np.argmax(np.linalg.norm(np.diff(frozen.truth[:, :2], axis=0), axis=1)))
    away = [np.abs(other.frames[k].astype(float) - frozen.frames[k]).mean() for other in (half, open_)]
    assert 0 < away[0] < away[1]
    assert (frozen.truth == open_.truth).all() and np.abs(open_.frames[0].astype(float) - frozen.frames[0]).mean() < away[0] / 3


@pytest.mark.parametrize("scenario", [fast, hidden])
def test_the_seed_is_the_path_and_the_noise_another_thing(scenario):
    first, again, other, noisy = (sequence(s) for s in (scenario(3), scenario(3), scenario(4), replace(scenario(3), seed=9)))
    assert (first.frames[20] == again.frames[20]).all()
    assert errors(first.truth, other.truth).position.max() > WIDTH / 2
    assert (first.truth == noisy.truth).all() and (first.frames[20] != noisy.frames[20]).any()
