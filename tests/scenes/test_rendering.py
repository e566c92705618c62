"""Synthetic scenes: the truth is exact, the blur is that of an exposure.

And everything follows from the specification.
"""

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest

from mkt.regions import displaced, warp
from mkt.scenes import rendering
from mkt.scenes.layers import Layer
from mkt.scenes.paths import STILL, standing
from mkt.scenes.rendering import Scene, regions, render
from mkt.scenes.textures import resized

MOVING = (
    (0.0, 110.0, 100.0, 0.0, 1.0),
    (10.0, 170.0, 130.0, 0.6, 1.2),
    (20.0, 220.0, 110.0, -0.4, 0.9),
)
MIDDLE = standing(160, 120)
CAMERA = ((0.0, 0.0, 0.0, 0.0, 1.0), (20.0, 30.0, -20.0, 0.2, 1.1))


def look_up(frame, region, n=40):
    """The pixels under n x n points of a region, (n, n, 3)."""
    along = (2 * np.arange(n) + 1) / n - 1
    points = np.stack(np.meshgrid(along, along), -1).reshape(-1, 2)
    x, y = np.rint(warp(region, points)).astype(int).T
    return frame[y, x].reshape(n, n, 3).astype(float)


@pytest.mark.parametrize(
    "camera", [STILL, CAMERA], ids=["still camera", "moving camera"]
)
@pytest.mark.parametrize("name", ["astronaut", "badge", "motorcycle"])
def test_the_truth_is_where_the_object_is(name, camera):
    """The object pulled back from the true region looks like in frame 0.

    From a region displaced by 2 px it does so less.
    """
    layer = Layer(name, 80.0, MOVING)
    clip = Scene(layer, length=21, camera=camera, shutter=0.0, noise=0.0).sequence()
    first = look_up(clip.frames[0], clip.truth[0])
    dx, dy = [0, 2, -2, 0, 0, 0, 0], [0, 0, 0, 2, -2, 0, 0]
    turn = [0, 0, 0, 0, 0, 0.08, -0.08]
    for k in (7, 14, 20):
        differences = [
            np.abs(look_up(clip.frames[k], region) - first).mean()
            for region in displaced(clip.truth[k], dx, dy, turn)
        ]
        assert np.argmin(differences) == 0


def test_same_specification_same_frames_in_any_order():
    scene = Scene(Layer("car", 80.0, MOVING), length=8, seed=3)
    fresh = rendering._rendered  # without the cache
    forward = [fresh(scene, k) for k in range(8)]
    backward = [fresh(scene, k) for k in reversed(range(8))][::-1]
    assert np.array_equal(forward, backward)
    assert not (render(replace(scene, seed=4), 0) == forward[0]).all()


def test_of_large_frames_fewer_are_kept(monkeypatch):
    monkeypatch.setattr(rendering, "FRAMES", 5 * 640 * 480)
    scene = Scene(Layer("cat", 60.0, MIDDLE), length=9, size=(640, 480), seed=77)
    alive = [weakref.ref(frame) for frame in scene.sequence().frames]
    gc.collect()
    assert sum(ref() is not None for ref in alive) <= 6
    assert render(scene, 8) is render(scene, 8)


def test_frames_are_a_series_like_any_other():
    frames = Scene(Layer("cat", 60.0, MIDDLE), length=4).sequence().frames
    assert len(frames[1:]) == 3 and np.array_equal(frames[1:], list(frames)[1:])
    assert np.array_equal(frames[-1], frames[3]) and frames[4:] == []
    with pytest.raises(IndexError, match="frame 4 of 4"):
        frames[4]


def test_blur_is_the_mean_over_the_exposure():
    """A long exposure equals the mean of instants much denser than the renderer's."""
    path = ((0.0, 60.0, 120.0, 0.0, 1.0), (10.0, 260.0, 120.0, 1.0, 1.0))
    fast = Layer("car", 80.0, path)
    scene = Scene(fast, length=11, shutter=0.9, noise=0.0)
    blurred = render(scene, 5).astype(float)
    instants = []
    for offset in (np.arange(100) + 0.5) / 100 - 0.5:
        target = _stopped(fast, 5 + 0.9 * offset)
        instants.append(render(replace(scene, length=1, shutter=0, target=target), 0))
    frozen = render(replace(scene, shutter=0.0), 5).astype(float)
    to_mean = np.abs(blurred - np.mean(instants, 0)).mean()
    to_frozen = np.abs(blurred - frozen).mean()
    assert to_frozen > 1 and to_mean < to_frozen / 8


@pytest.mark.parametrize("n", [1, 4, 27])
def test_an_exposure_is_half_before_and_half_after_the_instant_of_the_truth(n):
    times = rendering._exposure(n)
    assert times.mean() == pytest.approx(0, abs=1e-12)
    assert len(times) == n and times[-1] == pytest.approx(0.5 - 0.5 / n)


@pytest.mark.parametrize(
    "pixels, needed", [(0, 1), (9, 5), (19, 10), (199, rendering.MAX_SUBFRAMES)]
)
def test_an_exposure_has_a_sub_frame_for_each_pixel_that_something_moves(
    pixels, needed
):
    """The shutter is open half of the time."""
    path = ((0.0, 30.0, 40.0, 0.0, 1.0), (1.0, 30.0 + pixels, 40.0, 0.0, 1.0))
    pan = ((0.0, 0.0, 0.0, 0.0, 1.0), (1.0, 0.0, float(pixels), 0.0, 1.0))
    still = Scene(Layer("cat", 20.0, standing(30, 40)), length=2, size=(80, 60))
    for scene in (
        replace(still, target=Layer("cat", 20.0, path)),
        replace(still, front=(Layer("car", 20.0, path),)),
        replace(still, camera=pan),
    ):
        assert rendering._subframes(scene) == [needed] * 2


def test_an_exposure_has_a_sub_frame_for_each_pixel_that_the_ground_moves():
    """A camera that comes closer moves the border of the image most, by 8.8 pixels."""
    closer = ((0.0, 0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0, 1.44))
    target = Layer("cat", 20.0, standing(39.5, 29.5))
    scene = Scene(target, length=2, size=(80, 60), camera=closer)
    assert rendering._subframes(scene) == [9, 9]


def _stopped(layer, time):
    """The layer standing still where it is at a time."""
    x, y, theta, hx, _ = regions(Scene(layer, length=1), layer, np.array([time]))[0]
    return replace(layer, path=((0.0, x, y, theta, 2 * hx / layer.width),))


def test_visibility_falls_to_zero_behind_an_occluder():
    occluder = Layer("bricks", 120.0, MIDDLE)
    path = ((0.0, 40.0, 120.0, 0.0, 1.0), (20.0, 280.0, 120.0, 0.0, 1.0))
    scene = Scene(Layer("astronaut", 50.0, path), length=21, front=(occluder,))
    visibility = scene.sequence().visibility
    assert visibility[[0, -1]] == pytest.approx(1, abs=0.02)
    assert visibility[10] == 0
    assert 0.2 < visibility[np.argmax(visibility < 0.99)] <= 0.99


def test_visibility_counts_what_leaves_the_image():
    clip = Scene(Layer("astronaut", 60.0, standing(-0.5, 120)), length=1).sequence()
    assert clip.visibility[0] == pytest.approx(0.5, abs=0.02)


def test_noise_and_light():
    layer = Layer("car", 60.0, MIDDLE)
    base = Scene(layer, background="table", length=1, noise=0.0)
    clean = render(base, 0).astype(float)
    noisy = render(replace(base, noise=4.0), 0).astype(float)
    unclipped = (clean > 20) & (clean < 235)
    assert np.std((noisy - clean)[unclipped]) == pytest.approx(4.0, rel=0.05)
    dim = render(replace(base, light=((0.0, 0.5, 0.7, 1.0),)), 0)
    assert dim[..., 0].sum() / clean[..., 0].sum() == pytest.approx(0.5, abs=0.01)
    assert dim[..., 2].sum() / clean[..., 2].sum() == pytest.approx(1.0, abs=0.01)
    bright = render(replace(base, light=((0.0, 1.2, 1.2, 1.2),)), 0)
    dark = clean < 200  # what 1.2 times as much does not clip
    np.testing.assert_allclose(bright[dark], 1.2 * clean[dark], atol=1.2)


def test_a_target_that_shrinks_to_nothing_between_two_points_is_refused():
    scales = 1.0, 0.05, 1.0, 0.05
    path = tuple((20.0 * k, 160.0, 120.0, 0.0, s) for k, s in enumerate(scales))
    with pytest.raises(ValueError, match="no area in frame .*more points"):
        Scene(Layer("car", 60.0, path), length=61).sequence()


@pytest.mark.parametrize(
    "field, value",
    [
        ("shutter", 1.5),
        ("noise", -1.0),
        ("noise", np.nan),
        ("noise", 1e39),
        ("length", 0),
        ("length", 2.5),
        ("zoom", 0.0),
        ("focal", -1.0),
        ("seed", -1),
        ("seed", 1.5),
        ("size", (0, 240)),
        ("size", (60.0, 40.0)),
        ("size", 60),
        ("light", ((0.0, 1.0, -0.1, 1.0),)),
        ("light", ((0.0, 1.0, 1.0, 1.0), (9.0, 1.0, 1.0, -1.0))),
    ],
)
def test_impossible_cameras_are_refused(field, value):
    with pytest.raises(ValueError, match=rf"^{field} is .*(must|lies)"):
        Scene(Layer("car", 60.0, MOVING), **{field: value})


@pytest.mark.parametrize(
    "field, value",
    [
        ("target", "car"),
        ("behind", [Layer("cup", 60.0, MIDDLE)]),
        ("front", Layer("cup", 60.0, MIDDLE)),
        ("front", ("cup",)),
        ("background", "nope"),
        ("background", ["workshop"]),
    ],
)
def test_what_is_no_layer_and_no_ground_is_refused_by_its_field(field, value):
    with pytest.raises(ValueError, match=rf"^{field} is .*(give|must)"):
        replace(Scene(Layer("car", 60.0, MOVING)), **{field: value})


def test_what_lies_behind_hides_nothing():
    wall = Layer("bricks", 300.0, MIDDLE)
    clip = Scene(Layer("car", 60.0, MIDDLE), length=1, behind=(wall,)).sequence()
    assert clip.visibility[0] == pytest.approx(1, abs=0.02)


def test_frames_cannot_be_drawn_into():
    frame = Scene(Layer("car", 60.0, MIDDLE), length=1).sequence().frames[0]
    with pytest.raises(ValueError, match="read-only"):
        frame[0, 0] = 0


def test_light_is_rounded_and_not_cut_off():
    scene = Scene(Layer("car", 60.0, MIDDLE), "table", length=1, noise=0.0)
    clean = render(scene, 0).astype(float)
    dim = render(replace(scene, light=((0.0, 0.5, 0.5, 0.5),)), 0)
    assert np.mean(dim - 0.5 * clean) == pytest.approx(0.0, abs=0.2)


def test_the_background_moves_with_the_camera():
    pan = ((0.0, 0.0, 0.0, 0.0, 1.0), (1.0, 12.0, -7.0, 0.0, 1.0))
    away = Layer("car", 20.0, standing(-300, -300))
    scene = Scene(away, length=2, camera=pan, shutter=0.0, noise=0.0)
    before, after = scene.sequence().frames
    assert np.array_equal(after[:-7, 12:], before[7:, :-12])


def test_a_still_camera_sees_the_middle_of_the_background():
    plane = resized("bricks", 0.5)[..., :3]
    height, width = 90 + plane.shape[0] % 2, 120 + plane.shape[1] % 2
    top, left = (plane.shape[0] - height) // 2, (plane.shape[1] - width) // 2
    away = Layer("car", 20.0, standing(-300, -300))
    scene = Scene(away, length=1, background="bricks", noise=0.0, size=(width, height))
    seen = plane[top : top + height, left : left + width]
    assert scene.zoom == 0.5 and np.array_equal(render(scene, 0), seen)


def test_all_turns_together_with_a_rolling_camera():
    """A quarter of a turn: the picture is the first one, turned clockwise."""
    roll = ((0.0, 0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, np.pi / 2, 1.0))
    layer = Layer("car", 40.0, standing(60, 35))
    scene = Scene(layer, length=2, camera=roll, shutter=0, noise=0, size=(120, 120))
    before, after = scene.sequence().frames
    off = np.abs(after.astype(float) - np.rot90(before, -1))
    assert before.std() > 20 and off.mean() < 0.5


def test_what_is_in_front_is_painted_over_the_target_and_what_is_behind_is_not():
    wall, target = Layer("bricks", 300.0, MIDDLE), Layer("badge", 60.0, MIDDLE)

    def shown(**layers):
        frame = render(Scene(target, length=1, noise=0.0, **layers), 0)
        return frame[110:130, 150:170].astype(int)

    alone, behind, front = shown(), shown(behind=(wall,)), shown(front=(wall,))
    assert np.abs(behind - alone).max() <= 1
    assert np.abs(front - alone).max() > 20


def test_the_light_changes_with_time_and_the_noise_is_another_in_each_frame():
    fading = ((0.0, 1.0, 1.0, 1.0), (2.0, 0.5, 0.5, 0.5))
    scene = Scene(Layer("car", 60.0, MIDDLE), "table", 3, light=fading, noise=0.0)
    sums = np.array([frame.sum(dtype=float) for frame in scene.sequence().frames])
    assert sums / sums[0] == pytest.approx([1, 0.75, 0.5], abs=0.01)
    still = replace(scene, light=((0.0, 1.0, 1.0, 1.0),), noise=4.0)
    one, two = (frame.astype(float) for frame in still.sequence().frames[:2])
    assert np.std(one - two) == pytest.approx(4 * 2**0.5, rel=0.1)


def test_the_noise_of_a_frame_is_not_that_of_another_seed_s_frame():
    still = Scene(Layer("car", 60.0, MIDDLE), length=2, size=(80, 60))
    frames = [render(replace(still, seed=seed), k) for seed, k in ((3, 1), (4, 0))]
    assert (frames[0] != frames[1]).mean() > 0.5


def test_every_frame_has_a_noise_of_its_own():
    scene = Scene(Layer("car", 80.0, standing(160, 120)), length=130, shutter=0.0)
    frames = scene.sequence().frames
    for k in (1, 2, 64, 128):
        assert (frames[0] != frames[k]).any()
