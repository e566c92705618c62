"""The figures of the four wishes show what the chapter says, and its table is whole."""

import numpy as np
import pytest

from mkt.experiments.shipped import WISHED, read_table, seeds_of
from mkt.papers.lessons import wishes
from mkt.scenes.drawn import HELD_BACK
from mkt.scenes.varied import KINDS, Varied
from tests.papers.drawing import numbers


def test_many_hard_bins_lose_their_pit_in_another_light():
    fine, coarse = (numbers("own.neighbours", count=n, cast=0.2) for n in (30, 5))
    hard, soft = (fine[name].min() for name in ("bhattacharyya", "smoothed"))
    assert soft < hard and coarse["bhattacharyya"].min() < hard


@pytest.mark.parametrize("seed", range(3))
def test_a_starfish_is_less_than_its_box(seed):
    shown = numbers("own.silhouettes", item="starfish", ground="grass", seed=seed)
    assert 0.1 < shown["area_grab-cut"] < 0.5


def test_learnt_noise_spreads_with_the_frames_ahead():
    near, far = (numbers("own.learnt_motion", ahead=n) for n in (1, 8))
    assert np.all(far["median [px]"] > near["median [px]"])


def test_only_those_who_talk_send_bytes():
    shown = [numbers("own.two_cameras", talking=talking) for talking in (True, False)]
    assert 20 <= shown[0]["bytes"] <= 40 and shown[1]["bytes"] == 0
    assert shown[0]["told [px]"][-1] < 20 < shown[0]["alone [px]"][-1]


def test_the_table_has_every_run():
    rows, made = read_table(WISHED, *wishes.COLUMNS)
    assert seeds_of(made) == HELD_BACK
    for kind in KINDS:
        for label in wishes.contenders(kind):
            cell = rows[(rows["source"] == kind) & (rows["tracker"] == label)]
            assert sorted(cell["seed"]) == list(HELD_BACK), (kind, label)


@pytest.mark.parametrize("name", wishes.WISHES)
def test_every_wish_has_a_verdict(name):
    table = wishes.verdicts(name)
    assert len(table) >= 2 and not table["verdict"].str.startswith("(").all()


@pytest.mark.parametrize("kind", KINDS)
def test_scenes_are_short_and_the_same_for_a_seed(kind):
    one, two = (Varied(kind, 7).sequence() for _ in range(2))
    assert len(one) == 60 and np.array_equal(one.frames[30], two.frames[30])
    assert np.array_equal(one.truth, two.truth)
