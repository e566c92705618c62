"""What moves between frames is found, and noise is not."""

from dataclasses import replace

import numpy as np
import pytest

from mkt.regions import to_box
from mkt.scenes.layers import Layer
from mkt.scenes.paths import standing
from mkt.trackers.detector import moving
from tests.trackers.scenes import GROWING


def test_nothing_moves_in_a_still_scene():
    target = Layer("car", 80.0, standing(150, 120))
    still = replace(GROWING, target=target, length=10).sequence()
    assert moving(list(still.frames)).shape == (0, 5)
    with pytest.raises(ValueError, match="at least two"):
        moving(list(still.frames)[:1])


def blots(*boxes, frames=12):
    """Still frames of grey with noise; in the last one squares stand somewhere."""
    rng = np.random.default_rng(0)
    shown = [rng.normal(120, 2, (90, 120, 3)) for _ in range(frames)]
    for x, y, w, h in boxes:
        shown[-1][y : y + h, x : x + w] = 250
    return [np.clip(frame, 0, 255).astype(np.uint8) for frame in shown]


def test_what_moves_is_listed_the_largest_first():
    found = moving(blots((10, 10, 14, 14), (60, 40, 30, 24)))
    assert found.shape == (2, 5)
    np.testing.assert_allclose(found[0], (74.5, 51.5, 0, 15, 12), atol=1)
    np.testing.assert_allclose(found[1], (16.5, 16.5, 0, 7, 7), atol=1)


@pytest.mark.parametrize(
    "frames, said",
    [
        ([np.zeros((9, 9, 3))] * 2, "a frame must be .* uint8 RGB"),
        (["a.png", "b.png"], "a frame must be"),
        (iter([]), "frames is of the type list_iterator; give a list"),
        (
            [np.zeros((9, 9, 3), np.uint8), np.zeros((8, 9, 3), np.uint8)],
            r"shapes \(9, 9, 3\) and \(8, 9, 3\); give frames of one camera",
        ),
    ],
)
def test_what_is_no_film_of_one_camera_is_refused(frames, said):
    with pytest.raises(ValueError, match=said):
        moving(frames)


def test_two_frames_suffice_and_small_parts_are_noise():
    frames = blots((60, 40, 30, 24), frames=2)
    assert len(moving(frames)) == 1
    (found,) = moving(frames)
    area = round(4 * found[3] * found[4])
    assert len(moving(frames, smallest=area - 60)) == 1
    assert len(moving(frames, smallest=area + 1)) == 0


def test_specks_are_removed_and_parts_of_one_object_are_joined():
    frames = blots((20, 20, 1, 60), (60, 40, 12, 24), (75, 40, 12, 24))
    assert len(moving(frames, smallest=20)) == 1


def test_what_has_just_the_smallest_area_is_no_noise():
    frames = blots((20, 20, 30, 24))  # 720 px^2, of which four corners are closed away
    assert [len(moving(frames, area)) for area in (716, 717)] == [1, 0]


def moved(step, frames):
    """A square of 20 px that goes to the right, and its box in the last frame."""
    places = [10 + step * k for k in range(frames)]
    shown = [blots(frames=1)[0] for _ in places]
    shown = [np.tile(frame, (1, 3, 1)) for frame in shown]
    for frame, x in zip(shown, places, strict=True):
        frame[40:60, x : x + 20] = 250
    return shown, [places[-1], 40, 20, 20]


@pytest.mark.parametrize("step, frames", [(25, n) for n in range(3, 13)] + [(4, 30)])
def test_where_it_stood_first_nothing_is_found(step, frames):
    shown, box = moved(step, frames)
    np.testing.assert_allclose(to_box(moving(shown)), [box], atol=1)


def test_what_is_slower_than_the_text_says_is_background_in_part_or_whole():
    shown, (x, *_) = moved(2, 30)
    (half,) = to_box(moving(shown))
    np.testing.assert_allclose(half, (x + 10, 40, 10, 20), atol=1)
    np.testing.assert_allclose(to_box(moving(shown[::2])), [[66, 40, 20, 20]], atol=1)
    assert not len(moving(moved(1, 30)[0]))
