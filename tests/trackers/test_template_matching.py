"""Window matching: exact on what does not change, and blind to everything else."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from mkt.evaluation import overlap
from mkt.regions import from_box
from mkt.trackers.template_matching import TemplateMatching
from mkt.tracking import Sequence, track

SIZE = 30, 20


def sliding(places, size=SIZE, seed=0):
    """A patch of noise before grey noise of less contrast.

    Its top left corner is at the places (T, 2).
    """
    rng = np.random.default_rng(seed)
    patch = rng.integers(0, 256, (size[1], size[0], 3))
    ground = rng.integers(110, 140, (120, 160, 3))
    frames = []
    for x, y in places:
        frame = ground.astype(np.uint8)
        frame[y : y + size[1], x : x + size[0]] = patch
        frames.append(frame)
    truth = from_box([(x, y, *size) for x, y in places])
    return Sequence("patch", frames, truth, np.ones(len(truth)), upright=True)


@pytest.mark.parametrize("search", ["local", "global"])
@pytest.mark.parametrize(
    "place, step",
    [
        ((-12, 50), (3, 5)),
        ((60, -7), (3, 5)),
        ((142, 50), (-3, 5)),
        ((-12.4, 110.3), (3, -5)),
    ],
)
def test_of_a_box_that_sticks_out_the_part_inside_is_looked_for(search, place, step):
    """What lies outside had been the border again and again, which is nowhere else."""
    clip = sliding([(0, 0)] * 3, size=(160, 120))
    first = clip.frames[0]
    clip = replace(clip, frames=[first, first, np.roll(first, step, (1, 0))])
    box = from_box((*place, *SIZE))
    found = track(TemplateMatching(search), clip, start=box)
    np.testing.assert_allclose(found.regions[1], box, atol=0.5)
    np.testing.assert_allclose(found.regions[2], box + (*step, 0, 0, 0), atol=0.5)
    assert not found.lost.any()


@pytest.mark.parametrize("search", ["local", "global"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_rigid_target_is_found_exactly(search, seed):
    steps = np.random.default_rng(seed).integers(-8, 9, (12, 2))
    places = np.clip(np.cumsum(steps, 0) + [60, 50], 0, [130, 100])
    clip = sliding(places, seed=seed)
    found = track(TemplateMatching(search), clip)
    np.testing.assert_allclose(found.regions, clip.truth, atol=1e-9)
    assert found.score.min() > 0.99 and not found.lost.any()


def test_only_the_global_search_follows_a_jump():
    clip = sliding([(10, 10), (120, 90)])
    everywhere = track(TemplateMatching("global"), clip)
    assert overlap(everywhere.regions[1], clip.truth[1]) == pytest.approx(1)
    found = track(TemplateMatching("local"), clip)
    assert overlap(found.regions[1], clip.truth[1]) == 0 and found.lost[1]


def test_what_is_unlike_is_at_the_largest_distance_and_no_further():
    clip = sliding([(0, 0)] * 2, size=(160, 120))
    negative = 255 - clip.frames[0]
    found = track(
        TemplateMatching("global"), replace(clip, frames=[clip.frames[0], negative])
    )
    assert found.info["distance"][1] == 1 and found.lost[1]


def test_the_size_never_changes():
    clip = sliding([(40, 40)] * 3)
    regions = track(TemplateMatching(), clip).regions
    np.testing.assert_allclose(regions[:, 3:], np.tile(np.array(SIZE) / 2, (3, 1)))


@pytest.mark.parametrize("size", [(29.5, 20.5), (30.4, 19.6), (0.3, 12.0)])
def test_a_box_of_fractions_of_pixels_keeps_its_middle(size):
    """Its sides become whole, half of what is lacking on either side."""
    clip = sliding([(40, 40)])
    region = from_box((40.25, 40.5, *size))
    state = TemplateMatching().init(clip.frames[0], region, None)
    np.testing.assert_allclose(state.region[:2], region[:2])
    assert abs(2 * state.region[3:] - size).max() <= 0.7


@pytest.mark.parametrize("place", [(0, 0), (130, 100)])
def test_a_target_at_the_border_is_searched_for_inside_the_image(place):
    clip = sliding([place, place])
    tracker = TemplateMatching()
    state = tracker.init(clip.frames[0], clip.truth[0], None)
    rows, columns = tracker.window(state, clip.frames[0].shape)
    assert 0 <= columns.start <= place[0] and 0 <= rows.start <= place[1]
    assert place[0] + SIZE[0] <= columns.stop <= 160
    assert place[1] + SIZE[1] <= rows.stop <= 120
    found = track(tracker, clip).regions[1]
    assert overlap(found, clip.truth[1]) == pytest.approx(1)


def test_reach_says_how_far_it_looks():
    clip = sliding([(60, 50)] * 2)
    costs = [
        track(TemplateMatching(reach=reach), clip).info["evaluations"][1]
        for reach in (0.5, 1.0)
    ]
    assert costs == [31 * 21, 61 * 41]


@pytest.mark.parametrize("reach, looked_at", [(1e308, 131 * 101), (1e-18, 1)])
def test_the_template_fits_into_what_is_searched_at_any_reach(reach, looked_at):
    """Both ends of 25.5 to 50.5 would be rounded to the even one, a pixel too few."""
    clip = sliding([(60, 50)] * 2)
    tracker = TemplateMatching(reach=reach)
    state = tracker.init(clip.frames[0], clip.truth[0], np.random.default_rng(0))
    assert tracker.step(state, clip.frames[1], None)[1]["evaluations"] == looked_at
    odd = state._replace(template=state.template[:19, :25])
    odd = odd._replace(region=from_box((25.5, 25.5, 25, 19)))
    rows, columns = tracker.window(odd, clip.frames[1].shape)
    assert rows.stop - rows.start >= 19 and columns.stop - columns.start >= 25


def test_the_distance_is_that_of_the_highest_correlation():
    """A jump that the local search cannot follow: little is like the template there."""
    clip = sliding([(10, 10), (120, 90)])
    patch = clip.frames[0][10:30, 10:40]
    part = clip.frames[1][0:40, 0:55]
    c = cv2.matchTemplate(part, patch, cv2.TM_CCOEFF_NORMED).max()
    d = track(TemplateMatching(), clip).info["distance"][1]
    assert 0 < c < 0.5 and d == pytest.approx(np.sqrt(1 - c))


@pytest.mark.parametrize("lost_above, lost", [(0.99, False), (0.5**0.5, True)])
def test_it_is_lost_beyond_a_distance(lost_above, lost):
    clip = sliding([(10, 10), (120, 90)])
    assert track(TemplateMatching(lost_above=lost_above), clip).lost[1] == lost


def test_a_box_larger_than_the_frame_is_refused():
    clip = sliding([(40, 40)])
    said = "200x20 px is larger than the frame of 160x120"
    box = from_box((0.0, 40.0, 200.0, 20.0))
    with pytest.raises(ValueError, match=said):
        TemplateMatching().init(clip.frames[0], box, None)


def test_a_box_of_one_colour_is_refused_for_it_is_found_everywhere():
    clip = sliding([(40, 40)])
    frame = clip.frames[0].copy()
    frame[40:60, 40:70] = (200, 30, 30)
    with pytest.raises(ValueError, match="of one colour"):
        TemplateMatching().init(frame, clip.truth[0], None)
    frame[50, 50] = 0
    TemplateMatching().init(frame, clip.truth[0], None)


@pytest.mark.parametrize(
    "field, value", [("search", "everywhere"), ("reach", 0.0), ("reach", np.inf)]
)
def test_wrong_parameters_are_named(field, value):
    with pytest.raises(ValueError, match=field):
        TemplateMatching(**{field: value})
