"""Sweeps: cached, resumable, the same over any number of processes; intervals that cover."""

import json

import numpy as np
import pytest

from mkt import sweeps
from mkt.sweeps import Job, interval, score, sweep
from mkt.trackers.ssd import SSD
from mkt.tracking import Sequence, Track

JOBS = [Job("ssd", SSD(iterations=2), "base", seed) for seed in range(2)]


@pytest.fixture(autouse=True)
def short(monkeypatch):
    """Eight frames will do."""
    import dataclasses

    from mkt.scenarios import SCENARIOS, base

    monkeypatch.setitem(SCENARIOS, "base", lambda *arguments: dataclasses.replace(base(*arguments), length=8))


def test_rows_come_in_order_and_from_the_cache(tmp_path, monkeypatch):
    rows = sweep(JOBS, processes=1, cache=tmp_path)
    assert [row["seed"] for row in rows] == [0, 1] and len(list(tmp_path.iterdir())) == 2
    monkeypatch.setattr(sweeps, "run", lambda job: pytest.fail("the cache was not read"))
    assert sweep(JOBS[::-1], processes=1, cache=tmp_path) == rows[::-1]


def test_an_interrupted_sweep_goes_on_where_it_stopped(tmp_path, monkeypatch):
    real, done = sweeps.run, []

    def interrupted(job):
        if done:
            raise KeyboardInterrupt
        done.append(job)
        return real(job)

    monkeypatch.setattr(sweeps, "run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        sweep(JOBS, processes=1, cache=tmp_path)
    assert [json.loads(path.read_text())["seed"] for path in tmp_path.glob("*.json")] == [0]
    done.clear()
    assert len(sweep(JOBS, processes=1, cache=tmp_path)) == 2 and len(done) == 1


def test_other_parameters_are_another_job(tmp_path):
    sweep(JOBS[:1], processes=1, cache=tmp_path)
    sweep([Job("ssd", SSD(iterations=3), "base", 0)], processes=1, cache=tmp_path)
    assert len(list(tmp_path.glob("*.json"))) == 2


def test_score_counts_visible_frames_only():
    truth = np.tile([50.0, 50, 0, 10, 10], (20, 1))
    visible = np.ones(20)
    visible[5:8] = 0
    found = truth.copy()
    found[5:8, 0] = 500  # nobody sees it
    found[10:12, 0] += 30  # a miss
    clip = Sequence("made up", range(20), truth, visible)
    row = score(Track(found, np.ones(20), np.zeros(20, bool), {}), clip)
    assert row["hits"] == pytest.approx(14 / 16) and row["lost"] == 0 and row["position"] == pytest.approx(60 / 16)
    found[9:, 0] = 500
    assert score(Track(found, np.ones(20), np.zeros(20, bool), {}), clip)["lost"] == 1


def test_the_interval_of_a_median_covers_it():
    rng = np.random.default_rng(0)
    covered = sum(low <= 0 <= high for _, low, high in (interval(rng.normal(0, 1, 40), draws=400) for _ in range(100)))
    assert 85 <= covered <= 100
