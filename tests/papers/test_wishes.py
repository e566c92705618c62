"""The figures of the four wishes show what the chapter says, and its table is whole."""

import numpy as np
import pandas as pd
import pytest

from mkt.autoregression import learnt
from mkt.experiments.shipped import WISHED, read_table, seeds_of
from mkt.figures.registry import FIGURES
from mkt.homographies import through
from mkt.papers.lessons import wishes
from mkt.scenes.drawn import HELD_BACK, TUNING
from mkt.scenes.rendering import regions
from mkt.scenes.two_cameras import homographies
from mkt.scenes.varied import KINDS, Varied
from mkt.trackers.two_cameras import on_ground
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
    assert "told [px]" in shown[0].table and "told [px]" not in shown[1].table
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


def test_the_values_of_a_wish_come_in_the_order_of_the_seeds(monkeypatch):
    """However the table is sorted: differences are of runs on the same scene."""
    seeds = [1002, 1000, 1001]
    rows = pd.DataFrame(
        {"tracker": "a", "source": "light", "seed": seeds, "hits": seeds}
    )
    others = rows.assign(tracker="b", hits=0)[::-1]
    monkeypatch.setattr(wishes, "runs", lambda: pd.concat([rows, others]))
    told = []

    def wish(value):
        told.extend(value("light", name, "hits").tolist() for name in "ab")
        return wishes.talking_helps(lambda *cell: np.zeros(3))

    monkeypatch.setitem(wishes.WISHES, "toy", wish)
    wishes.verdicts("toy")
    assert told == [[1000, 1001, 1002], [0, 0, 0]]


@pytest.mark.parametrize("wish", wishes.WISHES.values(), ids=wishes.WISHES)
def test_a_wish_that_comes_true_is_a_gain(wish):
    """All others are better than these; and of cameras those that talk are not lost."""
    worse = "bhattacharyya", "ellipse", "by hand", "talking"
    parts = wish(
        lambda kind, label, number: np.array([not label.startswith(worse)]) * 1
    )
    few = [part for part in parts if part.text.startswith("110 hard bins over")]
    rest = [part for part in parts if part not in few]
    assert rest and all(part.values == [1] and not part.below for part in rest)
    assert all(part.values == [-1] and part.ours for part in few)
    assert any(not part.ours for part in parts)


def test_hard_bins_are_the_same_ones_on_the_same_scenes():
    hard = {("light", "110 bins"): 0.1, ("light", "930 bins"): 0.2}
    hard |= {("noise", "930 bins"): 0.4, ("noise", "110 bins"): 0.3}

    def value(kind, label, number):
        name, bins = label.split(", ")
        return hard[kind, bins] if name == "bhattacharyya" else 1.0

    gains = {part.text: part.values for part in wishes.neighbours_help(value)}
    assert len(gains) == 5 * 4
    for text, gain in gains.items():
        *_, kind, bins = text.split(", ")
        few = text.startswith("110 hard bins over")
        assert gain == pytest.approx(0.3 - 1 if few else 1 - hard[kind, bins])


def test_the_camera_with_the_wall_counts_after_the_first_frame(monkeypatch):
    """It has its target in half of the frames; the other one, in all of them."""
    errors = np.zeros((41, 2))
    errors[[0, *range(21, 41)], 0] = 2 * wishes.NEAR
    monkeypatch.setattr(wishes, "exchanged", lambda *asked: {"errors": errors})
    rows = wishes._exchange_rows(7)
    assert [row["tracker"] for row in rows] == list(wishes.EXCHANGES)
    assert all((row["hits"], row["lost"], row["seed"]) == (0.5, 1, 7) for row in rows)


def test_a_camera_that_is_off_takes_what_it_sees_for_too_far_to_the_left(monkeypatch):
    class Told(Exception):
        pass

    def pair(believed, talking):
        raise Told(believed)

    monkeypatch.setattr(wishes, "TwoCameras", pair)
    with pytest.raises(Told) as told:
        wishes.exchanged.__wrapped__(0, True, 20.0)
    point, (believed,) = np.array([[150.0, 110.0]]), told.value.args
    for H, taken, off in zip(homographies(), believed, (0, 20), strict=True):
        np.testing.assert_allclose(
            on_ground(taken, through(H, point)), point - [off, 0]
        )


def test_behind_the_wall_has_two_sides():
    there = np.array([[x, 120.0, 0, 20, 10] for x in (100, 160, 250)])
    assert wishes.behind_the_wall(there).tolist() == [False, True, False]


@pytest.mark.parametrize("kind", wishes.WAYS)
def test_a_learnt_motion_has_four_times_the_noise_of_its_tracks(kind):
    scenes = [Varied(kind, seed).scene() for seed in TUNING]
    tracks = [regions(one, one.target, np.arange(one.length)) for one in scenes]
    sigma = wishes.motions()[f"learnt on {kind}"].sigma
    assert sigma == pytest.approx(4 * np.array(learnt(tracks).sigma), rel=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_scenes_are_short_and_the_same_for_a_seed(kind):
    one, two = (Varied(kind, 7).sequence() for _ in range(2))
    assert len(one) == 60 and np.array_equal(one.frames[30], two.frames[30])
    assert np.array_equal(one.truth, two.truth)


def test_shapes_differ_in_where_they_look_alone():
    trackers = wishes.shapes().values()
    assert len({(one.n, one.lam, one.bins, one.motion) for one in trackers}) == 1


def test_the_curve_of_the_camera_that_is_told_is_the_table_s():
    fig, shown = FIGURES["own.two_cameras"].draw(30)
    lines = {line.get_label(): line.get_ydata() for line in fig.axes[2].lines}
    for name in ("alone", "told"):
        assert (lines[name] == shown[f"{name} [px]"]).all()


@pytest.mark.parametrize("name", ["own.neighbours", "own.silhouettes"])
def test_the_table_has_the_curves_as_they_are_drawn(name):
    fig, shown = FIGURES[name].draw(30)
    drawn = {line.get_label(): line for ax in fig.axes for line in ax.lines}
    for label in shown.table.columns.drop("x [px]"):
        assert (drawn[label].get_ydata() == shown[label]).all()
        assert shown[label].max() == 1


def test_the_path_of_a_target_begins_where_its_sequence_does():
    fig, _ = FIGURES["own.learnt_motion"].draw(30, k=3, ahead=4)
    (path,) = (line for line in fig.axes[0].lines if line.get_ls() == "-")
    assert len(path.get_xdata()) == 8
