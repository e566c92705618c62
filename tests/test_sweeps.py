"""Sweeps: cached, resumable, the same over any number of processes and machines; intervals that cover."""

import csv
import dataclasses
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from joblib import parallel_config

from mkt import scenarios, sweeps
from mkt.sweeps import PACKAGE, Job, interval, score, summaries, sweep, table
from mkt.trackers.ssd import SSD
from mkt.tracking import Sequence, Track

JOBS = [Job("ssd", SSD(iterations=2), "base", seed) for seed in range(2)]
FAKE = {"scenario": "base", "overlap": 0.5, "position": 1.0, "orientation": 2.0, "scale": 0.1, "hits": 1.0, "evaluations": 9.0, "cpu_ms": 3.0}


@pytest.fixture(autouse=True)
def short(monkeypatch):
    """Eight frames will do."""
    base = scenarios.base
    monkeypatch.setitem(sweeps.SCENES, "base", lambda *arguments: dataclasses.replace(base(*arguments), length=8))


@pytest.fixture
def done(monkeypatch):
    """The seeds of the jobs that are run, which here costs nothing."""
    seeds = []
    monkeypatch.setattr(sweeps, "run", lambda job: seeds.append(job.seed) or {"seed": job.seed, "name": job.name})
    return seeds


def test_rows_come_in_order_and_from_the_cache(tmp_path, monkeypatch):
    rows = sweep(JOBS, processes=1, cache=tmp_path)
    assert [row["seed"] for row in rows] == [0, 1] and len(list(tmp_path.iterdir())) == 2
    monkeypatch.setattr(sweeps, "run", lambda job: pytest.fail("the cache was not read"))
    assert sweep(JOBS[::-1], processes=1, cache=tmp_path) == rows[::-1]


def test_other_parameters_are_another_job(tmp_path, done):
    sweep(JOBS[:1], processes=1, cache=tmp_path)
    sweep([Job("ssd", SSD(iterations=3), "base", 0)], processes=1, cache=tmp_path)
    assert done == [0, 0] and len(list(tmp_path.iterdir())) == 2


KILLED = """
import os, sys
from mkt import sweeps
def run(job):
    if job.seed == 3:
        os._exit(9)
    return {"seed": job.seed}
sweeps.run = run
sweeps.sweep([sweeps.Job("ssd", None, "base", seed) for seed in range(6)], processes=1, cache=sys.argv[1])
"""


def test_a_sweep_that_was_killed_goes_on_where_it_stopped(tmp_path, done):
    assert subprocess.run([sys.executable, "-c", KILLED, tmp_path], cwd=PACKAGE.parent, capture_output=True, timeout=60).returncode == 9
    assert sorted(json.loads(path.read_text())["seed"] for path in tmp_path.glob("*.json")) == [0, 1, 2]
    rows = sweep([Job("ssd", None, "base", seed) for seed in range(6)], processes=1, cache=tmp_path)
    assert [row["seed"] for row in rows] == list(range(6)) and done == [3, 4, 5]


@pytest.mark.parametrize("content", [b"", b'{"seed": 1, "na', b"\xff\xfe\x00"], ids=["empty", "half", "not text"])
def test_a_broken_file_of_the_cache_is_a_missing_one(tmp_path, done, content):
    good = sweep(JOBS, processes=1, cache=tmp_path)
    next(tmp_path.iterdir()).write_bytes(content)
    assert sweep(JOBS, processes=1, cache=tmp_path) == good and len(done) == 3
    assert sweep(JOBS, processes=1, cache=tmp_path) == good and len(done) == 3


def test_two_sweeps_at_once_leave_whole_rows(tmp_path, done):
    jobs = [Job("ssd", None, "base", seed) for seed in range(40)]
    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(lambda order: sweep(order, processes=1, cache=tmp_path), [jobs, jobs[::-1]])
    assert first == second[::-1] and [row["seed"] for row in first] == list(range(40))
    assert sorted(json.loads(path.read_text())["seed"] for path in tmp_path.iterdir()) == list(range(40))


def apart_from_time(rows):
    return [{key: value for key, value in row.items() if key != "cpu_ms"} for row in rows]


def test_a_cluster_gives_the_same_rows(tmp_path):
    from distributed import Client, LocalCluster

    jobs = [Job("ssd", SSD(iterations=2), "illumination", seed) for seed in range(2)]
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster, Client(cluster):
        with parallel_config(backend="dask"):
            rows = sweep(jobs, cache=tmp_path / "cluster")
    assert apart_from_time(rows) == apart_from_time(sweep(jobs, processes=1, cache=tmp_path / "here"))
    assert len(list((tmp_path / "cluster").iterdir())) == 2


def test_what_a_job_imports_is_hashed_and_nothing_else():
    code = "import sys, mkt.sweeps, mkt.trackers.catalogue; print(*(m.__file__ for n, m in sys.modules.items() if n.startswith('mkt.')))"
    loaded = set(subprocess.run([sys.executable, "-c", code], cwd=PACKAGE.parent, capture_output=True, text=True, check=True).stdout.split())
    hashed = set(map(str, sweeps.sources()))
    assert loaded <= hashed
    assert all(set(map(str, sweeps._imported(PACKAGE / path))) <= hashed for path in hashed)
    assert not {path.stem for path in sweeps.sources()} & {"cli", "claims", "widgets", "bench", "plotting", "teuliere2009", "pages"}


def test_the_hash_feels_code_but_no_comment(tmp_path, monkeypatch):
    source, hashes = tmp_path / "module.py", set()
    monkeypatch.setattr(sweeps, "sources", lambda: [source])
    for text in ("x = 1", "x = 1  # one", "x = 2"):
        source.write_text(text)
        hashes.add(sweeps.library_hash.__wrapped__())
    assert len(hashes) == 2


def made_up():
    """A target that stands still for twenty frames, hidden in three, and an estimate that agrees: truth, visibility, estimate."""
    truth, visible = np.tile([50.0, 50, 0, 10, 10], (20, 1)), np.ones(20)
    visible[5:8] = 0
    found = truth.copy()
    found[5:8, 0] = 500  # nobody sees it
    return truth, visible, found


def scored(truth, visible, found):
    return score(Track(found, np.ones(20), np.zeros(20, bool), {}), Sequence("made up", range(20), truth, visible))


def test_score_counts_visible_frames_only():
    truth, visible, found = made_up()
    found[10:12, 0] += 30  # a miss
    row = scored(truth, visible, found)
    assert row["hits"] == pytest.approx(14 / 16) and row["lost"] == 0 and row["position"] == pytest.approx(60 / 16)
    found[9:, 0] = 500
    assert scored(truth, visible, found)["lost"] == 1


def test_score_tells_turned_shrunk_and_lost_apart():
    truth, visible, found = made_up()
    turned, shrunk = found.copy(), found.copy()
    turned[8:, 2] = np.deg2rad(90)
    shrunk[8:, 3:] *= 0.6
    assert [scored(truth, visible, f)["failed"] for f in (found, turned, shrunk)] == [0, 1, 0]
    assert [scored(truth, visible, f)["shrunk"] for f in (found, turned, shrunk)] == [0, 0, 12 / 16]
    assert scored(truth, visible, turned)["lost"] == 0 and scored(truth, visible, turned)["orientation"] == pytest.approx(90 * 12 / 16)


def test_the_interval_of_a_median_covers_it():
    rng = np.random.default_rng(0)
    covered = sum(low <= 0 <= high for _, low, high in (interval(rng.normal(0, 1, 40), draws=400) for _ in range(100)))
    assert 85 <= covered <= 100
    assert np.isnan(interval([1.0, np.nan, 2.0])).all()


def test_summaries_of_a_sweep_are_a_table_on_disk(tmp_path):
    rows = [FAKE | {"name": name, "overlap": overlap, "lost": lost} for name in ("a", "b") for overlap, lost in ((0.5, 0), (0.6, 0), (0.9, 0), (0.8, 1))]
    table(summaries(rows), tmp_path / "cells.csv")
    cells = list(csv.DictReader((tmp_path / "cells.csv").open()))
    assert [(cell["name"], cell["runs"]) for cell in cells] == [("a", "4"), ("b", "4")]
    assert float(cells[0]["overlap"]) == 0.7 and float(cells[0]["lost"]) == 0.25
    assert 0.5 <= float(cells[0]["overlap_low"]) < 0.7 < float(cells[0]["overlap_high"]) <= 0.9
    table(rows, tmp_path / "rows.csv")
    assert len((tmp_path / "rows.csv").read_text().splitlines()) == 9
