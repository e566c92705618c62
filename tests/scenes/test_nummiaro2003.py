"""The sequences of [N03]: each tells what the paper says of it, for every seed."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from mkt.scenes import nummiaro2003 as stories
from mkt.scenes.layers import Layer
from mkt.scenes.paths import standing
from mkt.scenes.rendering import Scene, regions, render

SEEDS = range(4)
MIDDLE = standing(160, 120)


def reduced(scene):
    """The same story without noise."""
    return replace(scene, noise=0.0).sequence()


@pytest.mark.parametrize("seed", SEEDS)
def test_the_student_goes_behind_the_tree_is_passed_twice_and_leaves(seed):
    visible = reduced(stories.students(seed)).visibility
    assert len(visible) == 222 and visible[0] > 0.9
    assert not visible[95:108].any() and visible[58] > 0.9 and visible[140] > 0.9
    for k in stories.PASSES:
        assert visible[k] < 0.2 and (visible[[k - 9, k + 9]] > 0.9).all()
        assert 1 <= np.sum(visible[k - 9 : k + 9] < 0.3) <= 4
    assert not visible[-8:].any()


def test_the_doors_are_where_the_student_comes_out():
    scene = stories.students(0)
    (left, y, *_), (right, *_), borders = stories.doors(scene)
    clip = reduced(scene)
    out = np.flatnonzero(clip.visibility[108:] > 0.9)[0] + 108
    cx, cy = clip.truth[out, :2]
    assert borders == "borders"
    assert np.hypot(right - cx, y - cy) < 12
    assert left < stories.TREE_X < right


@pytest.mark.parametrize("tree", [60, 100])
def test_the_doors_stand_at_the_sides_of_the_tree_however_wide_it_is(tree):
    scene = stories.students(1, tree)
    (left, _, spread, _), (right, *_), _ = stories.doors(scene)
    assert right - left == pytest.approx(tree + stories.PERSON)
    assert spread < stories.PERSON / 2
    hidden = reduced(scene).visibility[70:130] == 0
    assert hidden.sum() > 30 if tree == 100 else hidden.sum() < 20


def mean_color(frame, region):
    """The mean colour well inside a region (5,)."""
    x, y, _, hx, hy = region
    rows = slice(int(y - hy / 2), int(y + hy / 2))
    columns = slice(int(x - hx / 2), int(x + hx / 2))
    return frame[rows, columns].mean((0, 1))


@pytest.mark.parametrize("look", stories.LOOKS)
def test_the_van_in_traffic_grows_and_looks_otherwise(look):
    for seed in SEEDS:
        clip = reduced(stories.traffic(seed, look))
        assert clip.truth[-1, 3] / clip.truth[0, 3] == pytest.approx(1.8, rel=0.05)
        first, late = (mean_color(clip.frames[k], clip.truth[k]) for k in (0, 145))
        change = np.abs(late - first).max()
        assert change < 12 if look == "same" else change > 40
    with pytest.raises(ValueError, match="fades, turns, same"):
        stories.traffic(0, "flies")


def test_the_van_in_traffic_grows_by_the_same_factor_in_each_frame():
    """From frame 15 to 125: by the root of the whole in the middle of them."""
    for seed in SEEDS:
        scene = stories.traffic(seed, growth=4.0)
        size = regions(scene, scene.target, [15, 70, 125])[:, 3]
        assert size / size[0] == pytest.approx([1, 2, 4], rel=0.1)


def test_a_growth_of_one_keeps_the_size():
    truth = stories.traffic(1, growth=1.0).sequence().truth
    assert truth[:, 3] == pytest.approx(truth[0, 3])


@pytest.mark.parametrize("target, growth", [("car", 2), ("person", 1)])
def test_both_on_the_parking_place_can_be_followed(target, growth):
    for seed in SEEDS:
        clip = reduced(stories.parking(seed, target))
        assert len(clip) == 150 and clip.visibility.min() > 0.6
        assert clip.truth[-1, 3] / clip.truth[0, 3] == pytest.approx(growth, rel=0.1)
    for unknown in "lorry", ["car"]:
        with pytest.raises(
            ValueError, match="target is .*; it must be one of pers.*car"
        ):
            stories.parking(0, unknown)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_van_on_the_parking_place_turns_its_side(seed):
    """Its right half is another one late, its left half is still its rear."""
    clip = reduced(stories.parking(seed))

    def halves(k):
        x, y, _, hx, hy = clip.truth[k]
        middles = x - hx / 2, x + hx / 2
        return [mean_color(clip.frames[k], [m, y, 0, hx / 2, hy]) for m in middles]

    (left, right), (rear, side) = halves(40), halves(140)
    assert max(np.abs(rear - left).max(), np.abs(right - left).max()) < 30
    assert np.abs(side - rear).max() > 80


def test_stories_follow_from_their_seed():
    for story in (stories.students, stories.parking, stories.traffic):
        assert story(3) == story(3) != story(4)


# What the stories need of `mkt.scenes.rendering`


def car(degrees):
    """A car whose colours are turned, alone and sharp."""
    return render(
        Scene(Layer("car", 90.0, MIDDLE, hue=degrees), length=1, noise=0.0), 0
    )


@pytest.mark.parametrize(
    "hue, same",
    [(120.0, 480.0), (-60.0, 300.0), (-240.0, 120.0), (359.0, -1.0), (360.0, 0.0)],
)
def test_a_hue_goes_round_the_whole_circle(hue, same):
    assert (car(hue) == car(same)).all()


def test_a_box_shows_two_sides_each_in_its_share_of_the_width():
    side = Layer("gravel", 90.0, standing(0, 0))
    turn = ((2.0, 0.0), (10.0, 1.0))
    box = Layer("grass", 90.0, MIDDLE, view=side, turn=turn, box=True)
    scene = Scene(box, "planks", length=11, noise=0.0, shutter=0.0)

    def alone(name, width):
        """A texture squeezed to a width, as the scene would show it."""
        whole = render(replace(scene, target=Layer(name, 90.0, MIDDLE)), 0)[75:165]
        squeezed = cv2.resize(
            whole[:, 115:205], (width, 90), None, 0, 0, cv2.INTER_AREA
        )
        return squeezed.astype(float)

    for k, seam in ((0, 90), (4, 68), (6, 45), (10, 0)):
        seen = render(scene, k)[75:165, 115:205].astype(float)
        wanted = [alone("grass", seam)] if seam else []
        wanted += [alone("gravel", 90 - seam)] if seam < 90 else []
        assert np.abs(seen - np.hstack(wanted))[2:-2, 2:-2].mean() < 12
        assert np.abs(scene.sequence().truth[k] - scene.sequence().truth[0]).max() == 0


def test_a_turn_is_a_mixture_of_two_views():
    def shown(k, **changes):
        layer = Layer("car", 90.0, MIDDLE, **changes)
        frozen = Scene(layer, length=11, noise=0.0, shutter=0.0)
        return render(frozen, k).astype(float)

    view = Layer("car", 40.0, standing(0, 0), hue=120.0)
    turning = {"view": view, "turn": ((2.0, 0.0), (10.0, 1.0))}
    front, side = shown(0), shown(0, hue=120.0)
    assert (shown(0, **turning) == front).all() and (shown(2, **turning) == front).all()
    assert np.abs(shown(10, **turning) - side).max() <= 1
    assert np.abs(shown(4, **turning) - (0.75 * front + 0.25 * side)).max() <= 2
