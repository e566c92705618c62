"""Sweeps: kept, resumable, the same over any number of processes and machines."""

import dataclasses
import json
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from joblib import parallel_config

from mkt.experiments import sweep as sweeps
from mkt.experiments.cache import SEAL
from mkt.experiments.statistics import summaries
from mkt.experiments.sweep import Job, jobs, rows_of, sweep
from mkt.files import ROOT, DataError
from mkt.scenes.drawn import Drawn, drawn
from mkt.sequences.video import Frames
from mkt.trackers.by_name import TRACKERS
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD
from mkt.tracking import Sequence, Track

TWO = SSD(iterations=2)


@dataclasses.dataclass(frozen=True)
class Short:
    """Eight frames of a scene will do."""

    drawn: Drawn

    @property
    def name(self) -> str:
        return self.drawn.name

    def sequence(self) -> Sequence:
        return dataclasses.replace(self.drawn.scene(), length=8).sequence()


def short_jobs(n=2, tracker=TWO):
    return [Job("ssd", tracker, Short(Drawn("base", k)), k) for k in range(n)]


@pytest.fixture
def done(monkeypatch):
    """The seeds of the jobs that are run, which here costs nothing."""
    seeds = []

    def run(job):
        seeds.append(job.seed)
        return {"seed": job.seed, "tracker": job.label}

    monkeypatch.setattr(sweeps, "run", run)
    return seeds


def rows_in(kept):
    return sorted(
        json.loads(p.read_bytes()[SEAL:])["seed"] for p in kept.rglob("*.json")
    )


def test_jobs_are_all_trackers_on_all_sources_with_all_seeds():
    made = jobs({"a": TWO, "b": SSD()}, [Drawn("base"), Drawn("blur")], range(3))
    assert len(made) == 2 * 2 * 3 and len({repr(job) for job in made}) == 12
    assert {job.label for job in made} == {"a", "b"}


def test_seeds_may_be_numpy_s_and_a_parameter_may_stand_alone(kept):
    made = jobs({"ssd": SSD()}, [Short(Drawn("base"))], np.arange(2))
    rows = sweep(made, processes=1, parameters="iterations")
    assert rows["seed"].tolist() == [0, 1] and rows["iterations"].tolist() == [10, 10]
    assert made == jobs({"ssd": SSD()}, [Short(Drawn("base"))], range(2))
    own = [dataclasses.replace(job, seed=np.int64(job.seed)) for job in made]
    assert sweep(own, processes=1)["seed"].tolist() == [0, 1]


def test_labels_may_be_numpy_s(kept):
    trackers = {steps: SSD(iterations=int(steps)) for steps in np.arange(1, 3)}
    made = jobs(trackers, [Short(Drawn("base"))])
    assert sweep(made, processes=1)["tracker"].tolist() == [1, 2]
    assert rows_in(kept) == [0, 0]


def test_labels_are_the_same_when_they_come_back(kept):
    trackers = {label: TWO for label in ("a", 2, 0.1)}
    made = jobs(trackers, [Short(Drawn("base"))])
    first, second = (sweep(made, processes=1)["tracker"].tolist() for _ in range(2))
    assert first == second == ["a", 2, 0.1]


class Whole(Short):
    """Its truth is whole pixels."""

    def sequence(self) -> Sequence:
        clip = super().sequence()
        return dataclasses.replace(clip, truth=clip.truth.round().astype(int))


class Halfway(SSD):
    """Starts half a pixel beside, which it writes into the region that it is given."""

    def init(self, frame, region, rng):
        region[:2] += 0.5
        return super().init(frame, region, rng)


def test_a_truth_of_whole_numbers_is_no_reason_to_refuse():
    row = sweeps.run(Job("own", Halfway(), Whole(Drawn("base"))))
    assert row["refused"] == "" and row["overlap"] > 0.5


def test_a_sweep_of_no_jobs_has_the_columns_of_any_other():
    assert {"source", "tracker", "overlap"} <= set(sweep([]).columns)
    assert not len(sweep([])) and summaries(sweep([])).empty


@pytest.mark.parametrize(
    "trackers, sources, seeds, said",
    [
        (SSD(), [Drawn("base")], (0,), "trackers has no labels"),
        ({"ssd": SSD}, [Drawn("base")], (0,), "is no tracker"),
        ({("ssd", 10): SSD()}, [Drawn("base")], (0,), r"label \('ssd', 10\); give a"),
        ({None: SSD()}, [Drawn("base")], (0,), "label None; give a text or a number"),
        ({np.nan: SSD()}, [Drawn("base")], (0,), "label nan; give a text or a number"),
        ({"ssd": SSD()}, Drawn("base"), (0,), "sources is Drawn.*several"),
        ({"ssd": SSD()}, "base", (0,), "sources is 'base'; give several"),
        ({"ssd": SSD()}, ["base"], (0,), "'base' is no source of a sequence"),
        ({"ssd": SSD()}, [SimpleNamespace(sequence=len)], (0,), "is no source of a"),
        ({"ssd": SSD()}, [Drawn("base").sequence()], (0,), "not the sequence itself"),
        ({"ssd": SSD()}, [Drawn("base")], 3, "seeds is 3; give several"),
        ({"ssd": SSD()}, [Drawn("base")], [1.9], "seed is 1.9"),
        ({"ssd": SSD()}, [Drawn("base")], [-1], "seed is -1"),
    ],
)
def test_what_makes_no_jobs_is_said(trackers, sources, seeds, said):
    with pytest.raises(ValueError, match=said):
        jobs(trackers, sources, seeds)


@pytest.mark.parametrize("name", ["steps", "overlap", "seed", "refused"])
def test_a_parameter_does_not_take_the_place_of_what_was_measured(name):
    with pytest.raises(ValueError, match=f"parameters has '{name}'"):
        sweep(short_jobs(), processes=1, parameters=["n", name])


def test_runs_are_measured_on_one_thread(monkeypatch, two_threads):
    def run(job):
        return {"seed": job.seed, "threads": cv2.getNumThreads()}

    monkeypatch.setattr(sweeps, "run", run)
    assert sweep(short_jobs(), processes=1)["threads"].tolist() == [1, 1]


def test_rows_come_in_order_and_from_the_cache(kept, monkeypatch):
    rows = sweep(short_jobs(), processes=1)
    assert rows["seed"].tolist() == [0, 1] and rows["source"].tolist() == ["base"] * 2
    assert len(list(kept.rglob("*.json"))) == 2
    monkeypatch.setattr(sweeps, "run", lambda job: pytest.fail("not read"))
    again = sweep(short_jobs()[::-1], processes=1)
    assert again[::-1].reset_index(drop=True).equals(rows)


def test_a_source_is_asked_before_and_after_its_runs_what_identifies_it(done):
    class Recorded(Short):
        asked = []

        def identity(self):
            self.asked.append(1)
            return "a film"

    recorded = Recorded(Drawn("base"))
    sweep(jobs({"a": TWO, "b": SSD()}, [recorded], range(3)), processes=1)
    assert len(recorded.asked) == 2 and len(done) == 6


@dataclasses.dataclass(frozen=True)
class Weighted(SSD):
    """A tracker that reads a file, and says what is in it."""

    weights: Path = Path()

    def identity(self):
        return f"{self} {self.weights.read_text()}"


@dataclasses.dataclass(frozen=True)
class Labelled(Short):
    """A source that reads a file, and says what is in it."""

    truth: Path = Path()

    def identity(self):
        return f"{self} {self.truth.read_text()}"


def test_a_mistake_in_what_identifies_a_source_is_told():
    class Wrong(Short):
        def identity(self):
            return "a film" + 1

    class WrongTracker(SSD):
        identity = Wrong.identity

    said = "^identity of Wrong.*: can only concatenate"
    with pytest.raises(ValueError, match=said):
        Job("x", SSD(), Wrong(Drawn("base"))).key()
    with pytest.raises(ValueError, match=said):
        Job("x", WrongTracker(), Drawn("base")).key()


@dataclasses.dataclass(frozen=True)
class Learning(Weighted):
    """A tracker whose file, or any other, is written anew while it runs."""

    written: Path = Path()

    def init(self, frame, region, rng):
        self.written.write_text("two")
        return super().init(frame, region, rng)


@pytest.mark.parametrize("changing", ["weights", "truth"])
def test_a_row_of_what_changed_meanwhile_is_not_kept(changing, tmp_path, kept):
    """Nobody knows which of both it was."""
    weights, truth = tmp_path / "weights", tmp_path / "truth"
    for path in weights, truth:
        path.write_text("one")
    tracker = Learning(weights=weights, written=tmp_path / changing)
    job = Job("x", tracker, Labelled(Drawn("base"), truth))
    sweep([job], processes=1)
    assert not list(kept.rglob("*.json"))
    sweep([job], processes=1)
    assert len(list(kept.rglob("*.json"))) == 1


def test_what_reads_a_file_says_itself_when_it_has_changed(tmp_path):
    path = tmp_path / "file.txt"
    base = Drawn("base")
    made = [
        Job("x", Weighted(weights=path), base),
        Job("x", SSD(), Labelled(base, path)),
    ]
    keys = []
    for content in ("one", "one", "two"):
        path.write_text(content)
        keys.append([job.key() for job in made])
    assert keys[0] == keys[1] and None not in keys[0]
    assert not {*keys[0]} & {*keys[2]}


def test_a_row_says_what_was_run_and_what_it_took():
    (row,) = sweep(short_jobs(1), processes=1).to_dict("records")
    assert row["tracker"] == "ssd" and row["refused"] == ""
    assert row["overlap"] > 0.7 and row["cpu_ms"] > 0 and 1 <= row["steps"] <= 2
    (row,) = sweep([Job("x", TWO, drawn("base", 5), 1)], 1).to_dict("records")
    assert (row["item"], row["ground"]) == ("astronaut", "tissue")


def test_steps_are_those_of_the_frames_in_which_the_optimiser_ran():
    info = {"steps": np.array([np.nan, 3, 0, 5])}
    track = Track(np.zeros((4, 5)), np.ones(4), np.zeros(4, bool), info)
    assert sweeps._effort(track)["steps"] == 4


def test_the_frame_in_which_a_tracker_learns_costs_no_search():
    info = {"evaluations": np.array([np.nan, 4, 6, 5])}
    track = Track(np.zeros((4, 5)), np.ones(4), np.zeros(4, bool), info)
    assert sweeps._effort(track)["evaluations"] == 5


def test_a_tracker_that_refuses_its_target_has_a_row_of_nothing():
    class Refusing(SSD):
        def init(self, frame, region, rng):
            raise ValueError("too dark")

    row = sweeps.run(Job("ssd", Refusing(), Short(Drawn("base"))))
    assert row["refused"] == "too dark" and np.isnan(row["overlap"])


class Spoilt(Short):
    def sequence(self):
        clip = super().sequence()
        return dataclasses.replace(clip, frames=Torn(len(clip)))


class Torn(Frames):
    def _read(self, index):
        raise DataError("frame.jpg", "cut short", "download it again")


class Untrue(Short):
    def sequence(self):
        clip = super().sequence()
        return dataclasses.replace(clip, truth=np.full_like(clip.truth, np.nan))


@pytest.mark.parametrize(
    "job, said",
    [
        (Job("x", SSD(), Spoilt(Drawn("base"))), "frame.jpg"),
        (Job("x", SSD(), Untrue(Drawn("base"))), "no true region"),
        (Job("x", SSD(), Short(Drawn("base")), -1), "seed is -1"),
        (Job("x", "ssd", Short(Drawn("base"))), "is no tracker"),
    ],
)
def test_what_is_wrong_with_a_job_or_its_data_is_no_refusal(job, said):
    with pytest.raises((ValueError, TypeError), match=said):
        sweeps.run(job)


class Bad(Spoilt):
    """Its name comes before that of `Short`, and so does its turn."""


def test_a_broken_source_is_told_after_the_others_are_kept(kept):
    jobs = [Job("ssd", TWO, Bad(Drawn("base"))), *short_jobs(2)]
    with pytest.raises(DataError, match="frame.jpg: cut short; download it again"):
        sweeps.sweep(jobs, 1)
    assert rows_in(kept) == [0, 1]


def lacking(*_):
    raise DataError("model.npz", "no such file", "check the spelling")


@pytest.mark.parametrize("method", ["init", "step"])
def test_what_a_tracker_lacks_is_no_fault_of_the_source(method):
    tracker = type("Lacking", (SSD,), {method: lacking})()
    with pytest.raises(DataError, match="model.npz"):
        sweeps.rows_of(short_jobs(1, tracker), 1)


def test_a_tracker_that_does_not_tell_its_cost_has_a_row_without_it():
    class Silent(SSD):
        def step(self, state, frame, rng):
            state, info = super().step(state, frame, rng)
            kept = {"region", "score", "lost"}
            return state, {name: info[name] for name in kept}

    row = sweeps.run(Job("silent", Silent(), Short(Drawn("base"))))
    assert row["overlap"] > 0.7 and row["cpu_ms"] > 0
    assert np.isnan([row["evaluations"], row["steps"]]).all()


def test_other_parameters_are_another_job(kept, done):
    sweep(short_jobs(1), processes=1)
    sweep(short_jobs(1, SSD(iterations=3)), processes=1)
    assert done == [0, 0] and len(list(kept.rglob("*.json"))) == 2


KILLED = """
import os, sys
from mkt.experiments import sweep as sweeps
from mkt.scenes.drawn import Drawn
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD
def run(job):
    if job.seed == 3:
        os._exit(9)
    return {"seed": job.seed, "tracker": job.label}
sweeps.run = run
tracker = SSD(iterations=2)
jobs = [sweeps.Job("ssd", tracker, Drawn("base", k), k) for k in range(6)]
sweeps.sweep(jobs, processes=1)
"""


@pytest.mark.slow
def test_a_sweep_that_was_killed_goes_on_where_it_stopped(kept, done):
    program = subprocess.run(
        [sys.executable, "-c", KILLED], cwd=ROOT, capture_output=True, timeout=60
    )
    assert program.returncode == 9, program.stderr
    assert rows_in(kept) == [0, 1, 2]
    rows = sweep([Job("ssd", TWO, Drawn("base", k), k) for k in range(6)], 1)
    assert rows["seed"].tolist() == list(range(6)) and done == [3, 4, 5]


@pytest.mark.parametrize(
    "content",
    [b"", b'{"seed": 1, "na', b"\xff\xfe\x00"],
    ids=["empty", "half", "not text"],
)
def test_a_broken_file_of_the_cache_is_a_missing_one(kept, done, content):
    good = sweep(short_jobs(), processes=1)
    next(kept.rglob("*.json")).write_bytes(content)
    assert sweep(short_jobs(), processes=1).equals(good) and len(done) == 3
    assert sweep(short_jobs(), processes=1).equals(good) and len(done) == 3


def test_two_sweeps_at_once_leave_whole_rows(kept, done):
    made = [Job("ssd", TWO, Drawn("base", k), k) for k in range(40)]
    with ThreadPoolExecutor(2) as pool:
        orders = [made, made[::-1]]
        first, second = pool.map(lambda order: sweep(order, processes=1), orders)
    assert first["seed"].tolist() == list(range(40)) == second["seed"].tolist()[::-1]
    assert rows_in(kept) == list(range(40))


@pytest.mark.slow
def test_a_cluster_gives_the_same_rows(tmp_path, monkeypatch):
    from distributed import Client, LocalCluster

    sources = [drawn("illumination", k) for k in range(2)]
    made = [Job("ssd", TWO, source, k) for k, source in enumerate(sources)]
    with (
        LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            local_directory=tmp_path,
        ) as cluster,
        Client(cluster),
        parallel_config(backend="dask"),
    ):
        there = sweep(made)
    monkeypatch.setenv("MKT_CACHE", str(tmp_path / "here"))
    here = sweep(made, processes=1)
    assert there.drop(columns="cpu_ms").equals(here.drop(columns="cpu_ms"))


def test_each_job_gets_its_own_row_made_or_read(done, kept):
    made = jobs({"a": TWO, "b": SSD()}, [Drawn("base")], range(2))
    who = [(job.label, job.seed) for job in made]
    for _ in range(2):
        rows = sweep(made, processes=1)
        assert list(zip(rows["tracker"], rows["seed"], strict=True)) == who
    assert len(done) == len(made)


def test_reading_frames_is_not_on_the_trackers_clock(monkeypatch):
    """A frame takes 5 s to read, a step 4 ms; the first of four frames has no step."""
    now = [0.0]

    class Slow(list):
        def __getitem__(self, k):
            frame = super().__getitem__(k)
            now[0] += 5.0
            return frame

        def __iter__(self):
            return (self[k] for k in range(len(self)))  # a list's own reads past it

    class Timed(SSD):
        def step(self, state, frame, rng):
            now[0] += 0.004
            return super().step(state, frame, rng)

    class Source(Short):
        def sequence(self):
            clip = dataclasses.replace(self.drawn.scene(), length=4).sequence()
            return dataclasses.replace(clip, frames=Slow(clip.frames))

    monkeypatch.setattr(time, "process_time", lambda: now[0])
    row = sweeps.run(Job("ssd", Timed(), Source(Drawn("base"))))
    assert row["cpu_ms"] == pytest.approx(3 * 4.0 / 4)


def test_parameters_are_columns_nan_where_a_tracker_has_none(done, kept):
    both = jobs({"few": ParticleFilter(n=5), "ssd": TWO}, [Drawn("base")])
    rows = sweep(both, processes=1, parameters=["n", "iterations"])
    assert rows["n"].tolist()[0] == 5 and np.isnan(rows["n"].tolist()[1])
    assert np.isnan(rows["iterations"][0]) and rows["iterations"][1] == 2


def test_a_parameter_that_no_tracker_has_is_refused():
    both = jobs({"few": ParticleFilter(n=5), "ssd": TWO}, [Drawn("base")])
    said = "parameters has 'nn', a field that no tracker has; ParticleFilter has n, "
    with pytest.raises(ValueError, match=said):
        sweep(both, processes=1, parameters=["n", "nn"])
    assert not len(sweep([], processes=1, parameters="nn"))


@pytest.mark.parametrize("processes", [0, 1.5, "two", None])
def test_a_number_of_processes_that_is_none_is_refused(processes, kept):
    with pytest.raises(ValueError, match=f"processes is {processes!r}; give how many"):
        sweep(short_jobs(), processes)


class CutOff(list):
    """Frames of which the third cannot be read."""

    def __getitem__(self, k):
        if k == 2:
            raise DataError("a.png", "cut", "get it again")
        return super().__getitem__(k)

    def __iter__(self):
        return (self[k] for k in range(len(self)))


class Nameless:
    """A source of which nothing says what identifies it."""

    def __init__(self, name, broken):
        self.name, self.broken, self.secret = name, broken, lambda: 0

    def sequence(self):
        clip = Drawn("base").sequence().part(slice(0, 3))
        return (
            dataclasses.replace(clip, frames=CutOff(clip.frames))
            if self.broken
            else clip
        )


def test_a_broken_source_takes_no_other_with_it():
    sources = [("good", False), ("bad", True), ("fine", False)]
    jobs = [Job("wm", TRACKERS["wm"], Nameless(*each)) for each in sources]
    rows, broken = rows_of(jobs, 1)
    assert list(broken) == ["bad"]
    assert [row is None for row in rows] == [False, True, False]
