"""Stopped at any moment, run twice at once, or without room on the disk: what is kept is whole, and what is wrong is said in a sentence."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import nbformat
import numpy as np
import pytest

from mkt import book, cli, recording, sweeps
from mkt.book import catalogue, execute
from mkt.files import named, whole
from mkt.regions import from_box
from mkt.sweeps import PACKAGE, Job, sweep, table
from mkt.tracking import Sequence

JOBS = [Job("ssd", None, "base", seed) for seed in range(25)]
SWEEP = """
import sys
from mkt import sweeps
sweeps.run = lambda job: {"seed": job.seed, "text": str(job.seed) * 200_000}
rows = sweeps.sweep([sweeps.Job("ssd", None, "base", seed) for seed in range(25)], processes=1, cache=sys.argv[1])
print(*(row["seed"] for row in rows))
"""


def long_row(job):
    return {"seed": job.seed, "text": str(job.seed) * 200_000}


def started(cache):
    return subprocess.Popen([sys.executable, "-c", SWEEP, cache], cwd=PACKAGE.parent, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such signals")
@pytest.mark.parametrize("rows", [1, 13])
@pytest.mark.parametrize("blow", [signal.SIGINT, signal.SIGKILL], ids=["Ctrl-C", "killed"])
def test_a_sweep_stopped_at_any_moment_goes_on_with_the_same_rows(tmp_path, monkeypatch, blow, rows):
    process, end = started(tmp_path), time.monotonic() + 60
    while len(list(tmp_path.glob("*.json"))) < rows and process.poll() is None and time.monotonic() < end:
        time.sleep(0.0005)
    process.send_signal(blow)
    process.communicate(timeout=60)
    kept = [row["seed"] for row in sweeps.known(JOBS, tmp_path) if row]
    assert len(kept) >= rows - 1  # the last file seen may still have been under its other name
    done = []
    monkeypatch.setattr(sweeps, "run", lambda job: done.append(job.seed) or long_row(job))
    assert sweep(JOBS, processes=1, cache=tmp_path) == [long_row(job) for job in JOBS]
    assert sorted(kept + done) == list(range(len(JOBS)))


def test_two_sweeps_in_two_processes_leave_one_whole_row_a_job(tmp_path):
    processes = [started(tmp_path) for _ in range(2)]
    answers = [process.communicate(timeout=120)[0].split() for process in processes]
    assert answers == [[str(job.seed) for job in JOBS]] * 2
    assert sorted(json.loads(path.read_text())["seed"] for path in tmp_path.iterdir()) == list(range(len(JOBS)))


# A file

def test_a_file_is_there_as_a_whole_or_not_at_all(tmp_path):
    path = tmp_path / "a.txt"
    for text in ("old", "new"):
        with whole(path) as half:
            half.write_text(text)
            assert not path.exists() or path.read_text() == "old"
    for trouble in (KeyboardInterrupt, ZeroDivisionError):
        with pytest.raises(trouble), whole(path) as half:
            half.write_text("ha")
            raise trouble
    assert path.read_text() == "new" and list(tmp_path.iterdir()) == [path]


def test_an_error_of_the_disk_names_the_file(tmp_path):
    with pytest.raises(OSError, match=r"a\.txt cannot be written: No space left on device; make room there"), named("a.txt"):
        raise OSError(28, "No space left on device")
    with pytest.raises(OSError, match=r"none.a\.txt cannot be written: No such file or directory"), whole(tmp_path / "none" / "a.txt") as half:
        half.write_text("")


# No room: a limit on the size of files fails in the same calls as a full disk

@contextmanager
def room_for(size):
    resource = pytest.importorskip("resource")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_rows_before_the_disk_was_full_are_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(sweeps, "run", lambda job: {"seed": job.seed, "text": "x" * 1000 * job.seed})
    with room_for(5500), pytest.raises(OSError, match=r"\.json cannot be written: .*; make room there"):
        sweep(JOBS, processes=1, cache=tmp_path)
    assert [row["seed"] for row in sweeps.known(JOBS, tmp_path) if row] == [0, 1, 2, 3, 4, 5]
    assert len(list(tmp_path.iterdir())) == 6


def test_a_table_without_room_leaves_the_old_one(tmp_path):
    path = tmp_path / "rows.csv"
    table([{"a": 1}], path)
    with room_for(5000), pytest.raises(OSError, match="rows.csv cannot be written"):
        table([{"a": "x" * 20_000}], path)
    assert path.read_text() == "a\n1\n" and list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("ending", ["png", "pdf", "svg", "csv"])
def test_a_figure_without_room_is_said_and_leaves_nothing(ending, tmp_path):
    path = tmp_path / f"figure.{ending}"
    with room_for(100), pytest.raises(SystemExit) as stopped:
        cli.run(cli.parse(["figure", "teuliere2009.fig2", "-o", str(path)]))
    assert stopped.value.code.startswith(f"mkt figure: {path} cannot be written: ") and not list(tmp_path.iterdir())


class Still:
    """A tracker that answers where it was told."""

    def init(self, frame, region, rng):
        return region

    def step(self, state, frame, rng):
        return state, {"region": state, "score": 0.5, "lost": False}


@pytest.fixture(scope="module")
def noise():
    """Frames that no codec makes small."""
    frames = list(np.random.default_rng(0).integers(0, 256, (40, 48, 64, 3), np.uint8))
    return Sequence("noise", frames, np.tile(from_box([10, 10, 20, 20]), (40, 1)), np.ones(40))


@pytest.mark.parametrize("ending", recording.CODECS)
def test_a_video_without_room_is_said(ending, noise, tmp_path, capfd):
    with room_for(30_000), pytest.raises(OSError, match=rf"found{ending}: only \d+ of 40 frames could be written; make room there"):
        recording.record(Still(), noise, tmp_path / f"found{ending}")
    assert recording.record(Still(), noise, tmp_path / f"found{ending}") == 40  # there is room again


def test_a_table_of_a_video_without_room_is_said(noise, tmp_path, capfd):
    with room_for(1000), pytest.raises(OSError, match="found.csv cannot be written: .*; make room there"):
        recording.record(Still(), noise, tmp_path / "found.webm")


def test_an_executed_notebook_without_room_is_said_and_the_others_are_kept(tmp_path, monkeypatch):
    chapters = catalogue.read().chapters[:2]

    async def run(chapter, on_cell):
        return nbformat.v4.new_notebook(cells=[nbformat.v4.new_markdown_cell("x" * 50_000 * chapters.index(chapter))])

    monkeypatch.setattr(execute, "run", run)
    with room_for(20_000), pytest.raises(OSError, match=f"{chapters[1].notebook.name} cannot be written: .*; make room there"):
        execute.execute_all(chapters, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [chapters[0].notebook.name]


def test_a_book_without_room_ends_with_the_sentence(monkeypatch):
    def build():
        raise OSError("index.html cannot be written: No space left on device; make room there, or choose another place")

    monkeypatch.setattr(book, "build", build)
    with pytest.raises(SystemExit, match="index.html cannot be written"):
        cli.run(cli.parse(["book"]))
