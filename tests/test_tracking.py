"""A track is columns of one length, whatever the tracker says, and when it says it."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pytest

from mkt.evaluation import restarted
from mkt.scenes.drawn import Drawn
from mkt.trackers.ssd import SSD
from mkt.tracking import LARGE, Sequence, follow, report, track

LENGTH = 6
START = np.array([20.0, 15.0, 0.0, 8.0, 6.0])


def clip(length=LENGTH):
    """A `Sequence` of black frames whose target does not move."""
    frames = np.zeros((length, 30, 40, 3), np.uint8)
    return Sequence("black", frames, np.tile(START, (length, 1)), np.ones(length))


class Walking(NamedTuple):
    """A tracker that goes a random step a frame, and says all that one can say."""

    n: int = 3

    def init(self, frame, region, rng):
        return region

    def step(self, state, frame, rng):
        state = state + [*rng.normal(size=2), 0, 0, 0]
        particles = np.tile(state, (self.n, 1))
        info = report(
            state,
            0.25,
            state[0] > START[0],
            self.n,
            covariance=np.eye(5),
            particles=particles,
            weights=np.full(self.n, 1 / self.n),
            model=np.ones((2, 4)),
            regime="walking",
        )
        return state, info


def columns(result):
    """All columns of a track, by their names."""
    return {"region": result.regions, "score": result.score, "lost": result.lost} | (
        result.info
    )


class Now(Walking):
    """Says its steps in every second frame alone, and a word in the third."""

    def step(self, state, frame, rng):
        state, info = super().step(state, frame, rng)
        k = round(float(state[3]))
        info |= {"steps": k} if k % 2 else {}
        info |= {"word": "three"} if k == 3 else {}
        return state + [0, 0, 0, 1, 0], info


def test_what_some_infos_lack_is_missing_in_their_frames():
    told = track(Now(), clip(8), start=[*START[:3], 1, START[4]]).info
    np.testing.assert_array_equal(
        told["steps"], [np.nan, 1, np.nan, 3, np.nan, 5, np.nan, 7]
    )
    assert told["word"].tolist() == ["", "", "", "three", "", "", "", ""]


def test_one_large_entry_is_kept_by_its_name_and_no_unknown_one():
    kept = track(Walking(), clip(), keep="particles").info
    assert "particles" in kept and "weights" not in kept
    with pytest.raises(ValueError, match="keep has 'particle'; it takes particles, w"):
        track(Walking(), clip(), keep=["particle"])
    with pytest.raises(ValueError, match="keep is of the type NoneType; give names am"):
        track(Walking(), clip(), keep=None)


@pytest.mark.parametrize("keep", [(), LARGE])
def test_all_columns_have_the_length_of_the_sequence(keep):
    result = track(Walking(), clip(), keep=keep)
    for name, column in columns(result).items():
        assert isinstance(column, np.ndarray), name
        assert len(column) == LENGTH, name
    assert result.regions.shape == (LENGTH, 5)
    assert result.info["covariance"].shape == (LENGTH, 5, 5)


def test_frame_0_is_the_start_and_nothing_that_a_step_makes():
    result = track(Walking(), clip(), keep=LARGE)
    assert (result.regions[0] == START).all()
    assert result.score[0] == 1 and not result.lost[0] and result.lost.dtype == bool
    assert result.info.pop("regime").tolist() == ["", *["walking"] * (LENGTH - 1)]
    for name, column in result.info.items():
        assert np.isnan(column[0]).all(), name
        assert np.isfinite(column[1:]).all(), name


def test_large_entries_are_kept_where_they_are_asked_for():
    assert not set(LARGE) & set(track(Walking(), clip()).info)
    for name in LARGE:
        info = track(Walking(), clip(), keep=[name]).info
        assert set(LARGE) & set(info) == {name}
    particles = track(Walking(7), clip(), keep=LARGE).info["particles"]
    assert particles.shape == (LENGTH, 7, 5)


def test_the_score_is_the_likelihood_of_the_distance():
    result = track(Walking(), clip())
    assert result.info["distance"][1:] == pytest.approx(0.25)
    assert result.score[1:] == pytest.approx(np.exp(-20 / 16))


def test_progress_is_told_after_every_frame():
    told = []

    def progress(done, total):
        told.append((done, total))

    track(Walking(), clip(), progress=progress)
    assert told == [(k, LENGTH) for k in range(1, LENGTH + 1)]


def test_the_seed_is_the_run():
    first, again, other = (track(Walking(), clip(), seed) for seed in (1, 1, 2))
    assert (first.regions == again.regions).all()
    assert (first.regions[1:] != other.regions[1:]).any()


def test_a_start_can_be_given_and_is_asked_for():
    elsewhere = START + [5, 0, 0, 0, 0]
    assert (track(Walking(), clip(), start=elsewhere).regions[0] == elsewhere).all()
    untrue = clip()
    untrue.truth[0] = np.nan
    with pytest.raises(ValueError, match="black: the first frame has no true region;"):
        track(Walking(), untrue)


def test_a_sequence_of_one_frame_is_a_track_of_one_region():
    result = track(Walking(), clip(1))
    assert result.regions.shape == (1, 5) and result.info == {}


def test_follow_looks_at_a_frame_when_it_is_asked_for():
    """Nothing is kept, so a long video takes no more memory than a short one."""
    shown = []

    class Frames(list):
        def __iter__(self):
            for k, frame in enumerate(super().__iter__()):
                shown.append(k)
                yield frame

    lazy = replace(clip(), frames=Frames(clip().frames))
    infos = follow(Walking(), lazy)
    assert (next(infos)["region"] == START).all() and shown == [0]
    assert set(next(infos)) > {"region", "score", "lost", "distance", "evaluations"}
    assert shown == [0, 1]


def test_an_estimate_that_is_not_finite_ends_the_run():
    with pytest.raises(ValueError, match="the estimate .* is not finite"):
        report(np.full(5, np.nan), 0.0, False, 1)


@pytest.mark.parametrize(
    "length, seed, said", [(0, 0, "black has no frames"), (2, -1, "seed is -1")]
)
def test_what_cannot_be_followed_is_said(length, seed, said):
    with pytest.raises(ValueError, match=said):
        next(follow(Walking(), clip(length), seed))


def test_who_changes_what_he_was_told_changes_no_run():
    mine, frames = START.copy(), clip()
    infos = follow(SSD(), Drawn("base").sequence(), start=None)
    plain = [next(infos)["region"].copy() for _ in range(4)]
    changed = follow(SSD(), Drawn("base").sequence(), start=None)
    for region in plain:
        told = next(changed)["region"]
        assert (told == region).all()
        told += 60
    next(follow(Walking(), frames, start=mine))["region"][:] = 0
    next(follow(Walking(), frames))["region"][:] = 0
    assert (mine == START).all() and (frames.truth == START).all()


class Trampling(NamedTuple):
    """A tracker that moves the very region that it was given, and that it gives."""

    def init(self, frame, region, rng):
        return region

    def step(self, state, frame, rng):
        state[:2] += 1
        return state, report(START, 0.1, False, 1) | {"region": state}


def test_a_tracker_that_changes_its_start_changes_neither_truth_nor_track():
    mine = clip()
    regions = track(Trampling(), mine).regions
    assert (mine.truth == START).all()
    assert (regions[:, 0] == START[0] + np.arange(LENGTH)).all()


class Halfway(Trampling):
    """Moves its region by half a pixel, in place."""

    def step(self, state, frame, rng):
        state[:2] += 0.5
        return state, report(state, 0.1, False, 1)


def test_a_truth_of_whole_numbers_reaches_a_tracker_as_any_other():
    whole = replace(clip(), truth=clip().truth.astype(int))
    last = track(Halfway(), whole).regions[-1]
    assert last[0] == START[0] + (LENGTH - 1) / 2
    run = restarted(Halfway(), whole)
    assert run.starts == [0] and (run.overlap[1:] > 0).all()


def test_a_start_that_is_changed_later_is_still_where_the_tracker_began():
    sequence, rng = Drawn("base").sequence(), np.random.default_rng(0)
    start = sequence.truth[0].copy()
    state = SSD().init(sequence.frames[0], start, rng)
    start[:] = 0
    assert (state.region == sequence.truth[0]).all()


def test_a_start_that_is_no_region_is_told():
    with pytest.raises(ValueError, match="not finite; give five numbers"):
        track(Walking(), clip(), start=(np.nan, 1, 0, 5, 5))


@pytest.mark.parametrize(
    "change, said",
    [
        ({"truth": np.zeros((LENGTH, 4))}, r"truth has the shape .*, 4\);.*from_box"),
        ({"truth": [START] * LENGTH}, "truth is of the type list"),
        ({"visibility": np.ones(LENGTH + 1)}, "visibility has .* is known$"),
        ({"visibility": np.full(LENGTH, "all")}, "visibility holds <U3; give numbers"),
        ({"visibility": np.full(LENGTH, 1.5)}, "visibility has 1.5 in it"),
        (
            {"truth": np.zeros((LENGTH, 5))},
            "truth has .* area in frame 0; .*NaN",
        ),
        ({"truth": np.full((LENGTH, 5), np.inf)}, "truth is infinite in frame 0; .*Na"),
        ({"truth": np.ma.zeros((LENGTH, 5))}, "truth is masked; give NaN where noth"),
        ({"visibility": np.ma.ones(LENGTH)}, "visibility is masked; give NaN"),
        ({"frames": (k for k in "ab")}, "frames is of the type generator; give a list"),
        ({"fps": 0.0}, "fps is 0.0; it must be positive"),
        ({"fps": np.nan}, "fps is nan"),
    ],
)
def test_what_is_known_fits_the_frames(change, said):
    with pytest.raises(ValueError, match=said):
        replace(clip(), **change)


@pytest.mark.parametrize("tracker", ["ssd", SSD, None], ids=["name", "class", "none"])
def test_what_is_no_tracker_and_no_sequence_is_said(tracker):
    with pytest.raises(ValueError, match="no tracker.* give an object such as mkt.SSD"):
        track(tracker, clip())
    with pytest.raises(ValueError, match="clip is of the type str; give a Sequence"):
        track(SSD(), "ball.mp4")


@dataclass(frozen=True)
class Saying:
    """Says the same of every frame."""

    info: dict

    def init(self, frame, region, rng):
        return None

    def step(self, state, frame, rng):
        return state, self.info


BACK = (30.0, 20.0, 0.0, -9.0, 9.0)


@pytest.mark.parametrize(
    "wrong, said",
    [
        ({"lost": 1}, "its lost is 1; give True or False"),
        ({"lost": "no"}, "its lost is 'no'"),
        ({"region": BACK}, r"its region is \(30, 20, 0, -9, 9\), without area"),
        ({"region": ("a",) * 5}, "its region is .*give five numbers"),
        ({"region": np.zeros(5)}, "its region .* without area"),
        ({"score": None}, "its score is None; give a number"),
        ({"evaluations": None}, "its evaluations is None; give a number"),
        ({"steps": [1, 2]}, r"its steps is \[1, 2\]; give a number"),
        ({"score": np.ones(2)}, r"its score is array\(\[1., 1.\]\)"),
    ],
)
def test_what_a_step_says_is_looked_at(wrong, said):
    right = report(np.ones(5), 0.1, False, 1.0)
    clip = Drawn("base").sequence()
    assert follow(Saying(right), clip) and len(track(Saying(right), clip).lost)
    with pytest.raises(ValueError, match=f"Saying.step: {said}"):
        track(Saying(right | wrong), clip)


class Stumbling(Walking):
    """Counts its steps for each foot, and later in all."""

    def step(self, state, frame, rng):
        state, info = super().step(state, frame, rng)
        k = round(float(state[3]))
        return state + [0, 0, 0, 1, 0], info | {"edges": k if k % 2 else [k, k]}


def test_an_entry_of_another_shape_is_named():
    with pytest.raises(ValueError, match="'edges' of the infos has the shapes"):
        track(Stumbling(), clip())


def test_a_step_may_give_no_region():
    info = report(np.ones(5), 0.1, True, 1.0) | {"region": np.full(5, np.nan)}
    found = track(Saying(info), Drawn("base").sequence())
    assert np.isnan(found.regions[1:]).all() and found.lost[1:].all()


@pytest.mark.parametrize("lost", ["no", "", None, 1, np.nan, [], np.array([True])])
def test_a_target_is_lost_or_it_is_not(lost):
    for said in (True, np.bool_(True), np.array(True)):
        assert report(np.ones(5), 0.1, said, 1)["lost"] is True
    with pytest.raises(ValueError, match="^lost is .*; give True or False"):
        report(np.ones(5), 0.1, lost, 1)


def test_a_report_has_a_region_of_its_own():
    region = np.array([50.0, 40, 0, 20, 10])
    info = report(region, 0.1, False, 1)
    region[0] = 0
    assert info["region"][0] == 50


class Pushing:
    """A tracker that changes the region that it is given."""

    def init(self, frame, region, rng):
        region[:2] += 9
        return region

    def step(self, state, frame, rng):
        return state, report(state, 0.0, False, 1)


def test_a_tracker_that_changes_its_start_does_not_change_the_track():
    clip = replace(Drawn("base", 1).sequence())
    found = track(Pushing(), clip).regions
    np.testing.assert_array_equal(found[0], clip.truth[0])
    np.testing.assert_array_equal(found[1], clip.truth[0] + [9, 9, 0, 0, 0])


class Lending:
    """A tracker whose info, its own dict, has the arrays in which it goes on."""

    def init(self, frame, region, rng):
        return region

    def step(self, state, frame, rng):
        state += 1
        info = {"region": state, "score": 1.0, "lost": False, "mine": state}
        return state, info | {"particles": state[None], "model": state}


def test_what_is_kept_of_a_frame_is_that_of_this_frame():
    told = track(Lending(), clip(), keep=LARGE)
    for column in (told.info["model"], told.info["mine"], told.info["particles"][:, 0]):
        np.testing.assert_array_equal(column[1:], told.regions[1:])


@pytest.mark.parametrize(
    "chosen, fps",
    [
        (slice(1, 5), 25),
        (slice(None, None, 2), 12.5),
        (slice(None, None, -1), 25),
        (slice(0, 3, 10**400), 25 / LENGTH),
    ],
)
def test_of_every_second_frame_there_are_half_as_many_a_second(chosen, fps):
    assert clip().part(chosen).fps == pytest.approx(fps)
    assert not len(clip(0).part(slice(0, 0, 4)))


@pytest.mark.parametrize("chosen", [3, [0, 2]])
def test_a_part_is_a_slice(chosen):
    said = rf"chosen is of the type {type(chosen).__name__}; give a slice"
    with pytest.raises(ValueError, match=said):
        clip().part(chosen)
