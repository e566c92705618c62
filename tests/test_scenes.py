"""Synthetic scenes: the truth is exact, the blur is that of an exposure, and everything follows from the specification."""

from dataclasses import replace

import numpy as np
import pytest

from mkt.regions import displaced, warp
from mkt.scenes import Layer, Scene, frame, regions, sequence
from mkt.textures import BACKGROUNDS, OBJECTS, texture

MOVING = ((0.0, 110.0, 100.0, 0.0, 1.0), (10.0, 170.0, 130.0, 0.6, 1.2), (20.0, 220.0, 110.0, -0.4, 0.9))
CAMERA = ((0.0, 0.0, 0.0, 0.0, 1.0), (20.0, 30.0, -20.0, 0.2, 1.1))


def look_up(image, region, n=40):
    """The pixels under n x n points of a region, (n, n, 3)."""
    along = (2 * np.arange(n) + 1) / n - 1
    points = np.stack(np.meshgrid(along, along), -1).reshape(-1, 2)
    x, y = np.rint(warp(region, points)).astype(int).T
    return image[y, x].reshape(n, n, 3).astype(float)


@pytest.mark.parametrize("camera", [((0.0, 0.0, 0.0, 0.0, 1.0),), CAMERA], ids=["still camera", "moving camera"])
@pytest.mark.parametrize("name", ["astronaut", "badge", "motorcycle"])
def test_the_truth_is_where_the_object_is(name, camera):
    """The object pulled back from the true region looks like in frame 0; from a region displaced by 2 px it does so less."""
    scene = sequence(Scene(Layer(name, 80.0, MOVING), length=21, camera=camera, shutter=0.0, noise=0.0))
    first = look_up(scene.frames[0], scene.truth[0])
    for k in (7, 14, 20):
        truth = scene.truth[k]
        moved = displaced(truth, [0, 2, -2, 0, 0, 0, 0], [0, 0, 0, 2, -2, 0, 0], [0, 0, 0, 0, 0, 0.08, -0.08])
        differences = [np.abs(look_up(scene.frames[k], r) - first).mean() for r in moved]
        assert np.argmin(differences) == 0


def test_same_specification_same_frames_in_any_order():
    scene = Scene(Layer("car", 80.0, MOVING), length=8, seed=3)
    forward = [frame.__wrapped__(scene, k) for k in range(8)]
    backward = [frame.__wrapped__(scene, k) for k in reversed(range(8))][::-1]
    assert all((a == b).all() for a, b in zip(forward, backward))
    assert not (frame(replace(scene, seed=4), 0) == forward[0]).all()


def test_frames_are_a_series_like_any_other():
    frames = sequence(Scene(Layer("cat", 60.0, ((0.0, 160.0, 120.0, 0.0, 1.0),)), length=4)).frames
    assert [np.array_equal(a, b) for a, b in zip(frames[1:], list(frames)[1:])] == [True] * 3
    assert np.array_equal(frames[-1], frames[3]) and frames[4:] == []
    with pytest.raises(IndexError, match="frame 4 of 4"):
        frames[4]


def test_blur_is_the_mean_over_the_exposure():
    """A long exposure equals the mean of frozen instants taken much more densely than the renderer does."""
    fast = Layer("car", 80.0, ((0.0, 60.0, 120.0, 0.0, 1.0), (10.0, 260.0, 120.0, 1.0, 1.0)))
    scene = Scene(fast, length=11, shutter=0.9, noise=0.0)
    blurred = sequence(scene).frames[5].astype(float)
    instants = [sequence(replace(scene, length=1, shutter=0.0, target=_shifted(fast, 5 + 0.9 * o))).frames[0].astype(float) for o in (np.arange(100) + 0.5) / 100 - 0.5]
    frozen = sequence(replace(scene, shutter=0.0)).frames[5].astype(float)
    to_mean, to_frozen = (np.abs(blurred - other).mean() for other in (np.mean(instants, 0), frozen))
    assert to_frozen > 1 and to_mean < to_frozen / 8


def _shifted(layer, time):
    """The layer standing still where it is at a time."""
    x, y, theta, hx, _ = regions(Scene(layer, length=1), layer, np.array([time]))[0]
    return replace(layer, path=((0.0, x, y, theta, 2 * hx / layer.width),))


def test_visibility_falls_to_zero_behind_an_occluder():
    occluder = Layer("bricks", 120.0, ((0.0, 160.0, 120.0, 0.0, 1.0),))
    scene = Scene(Layer("astronaut", 50.0, ((0.0, 40.0, 120.0, 0.0, 1.0), (20.0, 280.0, 120.0, 0.0, 1.0))), length=21, front=(occluder,))
    visibility = sequence(scene).visibility
    assert visibility[0] == pytest.approx(1, abs=0.02) and visibility[-1] == pytest.approx(1, abs=0.02)
    assert visibility[10] == 0
    assert 0.2 < visibility[np.argmax(visibility < 0.99)] <= 0.99


def test_visibility_counts_what_leaves_the_image():
    scene = sequence(Scene(Layer("astronaut", 60.0, ((0.0, -0.5, 120.0, 0.0, 1.0),)), length=1))
    assert scene.visibility[0] == pytest.approx(0.5, abs=0.02)


def test_noise_and_light():
    base = Scene(Layer("car", 60.0, ((0.0, 160.0, 120.0, 0.0, 1.0),)), background="table", length=1, noise=0.0)
    clean = sequence(base).frames[0].astype(float)
    noisy = sequence(replace(base, noise=4.0)).frames[0].astype(float)
    unclipped = (clean > 20) & (clean < 235)
    assert np.std((noisy - clean)[unclipped]) == pytest.approx(4.0, rel=0.05)
    dim = sequence(replace(base, light=((0.0, 0.5, 0.7, 1.0),))).frames[0]
    assert dim[..., 0].sum() / clean[..., 0].sum() == pytest.approx(0.5, abs=0.01)
    assert dim[..., 2].sum() / clean[..., 2].sum() == pytest.approx(1.0, abs=0.01)


def test_look_alikes():
    """A shuffled twin has the same colours elsewhere; a recoloured one has other colours."""
    def alone(**changes):
        return sequence(Scene(Layer("car", 90.0, ((0.0, 160.0, 120.0, 0.0, 1.0),), **changes), length=1, noise=0.0)).frames[0]

    plain, shuffled, recoloured = alone()[95:145, 125:195], alone(shuffle=3)[95:145, 125:195], alone(hue=120.0)[95:145, 125:195]
    assert np.abs(plain.astype(float) - shuffled).mean() > 20
    assert np.abs(plain.mean((0, 1)) - shuffled.mean((0, 1))).max() < 12
    assert np.abs(plain.mean((0, 1)) - recoloured.mean((0, 1))).max() > 20


@pytest.mark.parametrize("name", [*OBJECTS, *BACKGROUNDS])
def test_every_texture_is_there(name):
    rgba = texture(name)
    assert rgba.ndim == 3 and rgba.shape[2] == 4 and rgba.dtype == np.uint8 and rgba[..., :3].std() > 10


@pytest.mark.parametrize("field, value", [("shutter", 1.5), ("noise", -1.0), ("length", 0), ("zoom", 0.0)])
def test_impossible_cameras_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        Scene(Layer("car", 60.0, MOVING), **{field: value})


def test_unknown_textures_are_named():
    with pytest.raises(ValueError, match="no texture 'lorry'.*car"):
        sequence(Scene(Layer("lorry", 60.0, MOVING)))
