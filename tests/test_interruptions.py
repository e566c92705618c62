"""Stopped at any moment, run twice at once, or without room on the disk.

What is kept is whole, and what is wrong is said in a sentence.
"""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import cv2
import nbformat
import numpy as np
import pandas as pd
import pytest

from mkt.course import book, cli
from mkt.course.book import contents, execute
from mkt.experiments import sweep as sweeps
from mkt.experiments.cache import SEAL
from mkt.experiments.sweep import ROWS, Job, sweep, write_table
from mkt.files import ROOT, named, whole
from mkt.own_video import recording
from mkt.regions import from_box
from mkt.scenes.drawn import Drawn
from mkt.sequences.video import VideoFile
from mkt.sequences.writing import CODECS, video_writer
from mkt.trackers.ssd import SSD
from mkt.tracking import Sequence
from tests.lot import DAY

pytestmark = pytest.mark.slow

# Each job has a scene of its own, for the jobs on one scene are kept together.  From 10
# on their names are in the order of their numbers, which is that of the runs.
JOBS = [Job("ssd", SSD(), Drawn("base", 10 + seed), seed) for seed in range(25)]
# The same jobs and rows, in a program that imports no more than they need.
SWEEP = """
from mkt.experiments import sweep as sweeps
from mkt.experiments.sweep import Job
from mkt.scenes.drawn import Drawn
from mkt.trackers.ssd import SSD
def long_row(job):
    return {"seed": job.seed, "text": str(job.seed) * 200_000}
sweeps.run = long_row
jobs = [Job("ssd", SSD(), Drawn("base", 10 + seed), seed) for seed in range(25)]
print(*sweeps.sweep(jobs, processes=1)["seed"])
"""


def long_row(job):
    return {"seed": job.seed, "text": str(job.seed) * 200_000}


LONG = pd.DataFrame([long_row(job) for job in JOBS])


@pytest.fixture(autouse=True)
def kept(tmp_path, monkeypatch):
    """The folder in which results of this test are kept, empty at first."""
    folder = tmp_path / "kept"
    monkeypatch.setenv("MKT_CACHE", str(folder))
    return folder


def started():
    """A program that does all jobs, each of which is a long row."""
    return subprocess.Popen(
        [sys.executable, "-c", SWEEP],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def wait_for_rows(kept, count, process):
    """Wait until there are so many files of rows, or the program has ended."""
    wait_until(process, lambda: len(list(kept.rglob("*.json"))) >= count)


def wait_until(process, there):
    """Wait until something is there, or the program has ended."""
    end = time.monotonic() + 60
    while not there() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.0005)


def kept_seeds():
    """The seeds of the jobs whose rows are kept, in order."""
    rows = (ROWS.get(job.key()) for job in JOBS)
    return [row["seed"] for row in rows if row]


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such signals")
@pytest.mark.parametrize("rows", [1, 13])
@pytest.mark.parametrize(
    "blow", [signal.SIGINT, signal.SIGKILL], ids=["Ctrl-C", "killed"]
)
def test_a_sweep_stopped_at_any_moment_goes_on_with_the_same_rows(
    kept, monkeypatch, blow, rows
):
    done = []

    def counted(job):
        done.append(job.seed)
        return long_row(job)

    process = started()
    wait_for_rows(kept, rows, process)
    process.send_signal(blow)
    process.communicate(timeout=60)
    before = kept_seeds()
    # The last file that was seen may still have had its other name.
    assert len(before) >= rows - 1
    monkeypatch.setattr(sweeps, "run", counted)
    assert sweep(JOBS, processes=1).equals(LONG)
    assert sorted(before + done) == list(range(len(JOBS)))


def test_two_sweeps_in_two_processes_leave_one_whole_row_a_job(kept):
    processes = [started() for _ in range(2)]
    answers = [process.communicate(timeout=120)[0].split() for process in processes]
    assert answers == [[str(job.seed) for job in JOBS]] * 2
    rows = [json.loads(path.read_bytes()[SEAL:]) for path in kept.rglob("*.*")]
    assert sorted(row["seed"] for row in rows) == list(range(len(JOBS)))


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
    said = r"a\.txt cannot be written: No space left on device; make room there"
    with pytest.raises(OSError, match=said), named("a.txt"):
        raise OSError(28, "No space left on device")
    said = r"none.a\.txt cannot be written: No such file or directory; choose another"
    with (
        pytest.raises(OSError, match=said),
        whole(tmp_path / "none" / "a.txt") as half,
    ):
        half.write_text("")


# No room: a limit on the size of files fails in the same calls as a full disk


@contextmanager
def room_for(size):
    """For a while, no file may be longer than `size` [bytes]."""
    resource = pytest.importorskip("resource")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_sweep_goes_on_where_the_disk_is_full(kept, monkeypatch, capsys):
    def growing_row(job):
        return {"seed": job.seed, "text": "x" * 1000 * job.seed}

    monkeypatch.setattr(sweeps, "run", growing_row)
    with room_for(5500):
        rows = sweep(JOBS, processes=1)
    assert rows["seed"].tolist() == list(range(len(JOBS)))
    assert kept_seeds() == list(range(6))
    assert len(list(kept.rglob("*.*"))) == 6
    assert capsys.readouterr().err.count(f"{kept} cannot be written (") == 1


def test_a_table_without_room_leaves_the_old_one(tmp_path):
    path = tmp_path / "rows.csv"
    write_table(pd.DataFrame([{"a": 1}]), path)
    long = pd.DataFrame([{"a": "x" * 20_000}])
    with room_for(5000), pytest.raises(OSError, match="rows.csv cannot be written"):
        write_table(long, path)
    assert path.read_text() == "a\n1\n" and list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("ending", ["png", "pdf", "svg", "csv"])
def test_a_figure_without_room_is_said_and_leaves_nothing(ending, tmp_path):
    path = tmp_path / f"figure.{ending}"
    words = ["figure", "teuliere2009.fig2", "-o", str(path)]
    with room_for(100), pytest.raises(SystemExit) as stopped:
        cli.run(cli.parse(words))
    assert stopped.value.code.startswith(f"mkt figure: {path} cannot be written: ")
    assert not list(tmp_path.iterdir())


class Still:
    """A tracker that answers where it was told."""

    def init(self, frame, region, rng):
        return region

    def step(self, state, frame, rng):
        return state, {"region": state, "score": 0.5, "lost": False}


@pytest.fixture(scope="module")
def noise():
    """Frames that no codec makes small."""
    frames = np.random.default_rng(0).integers(0, 256, (40, 48, 64, 3), np.uint8)
    truth = np.tile(from_box([10, 10, 20, 20]), (40, 1))
    return Sequence("noise", list(frames), truth, np.ones(40))


def recorded(clip, output):
    """Track in a clip and write the files; returns how many frames were written."""
    return recording.record(Still(), clip, output)


@pytest.mark.parametrize("ending", CODECS)
def test_a_video_without_room_is_said(ending, noise, tmp_path, capfd):
    said = "(only .* of 40 frames|frame .*) could (not )?be written; make room there"
    with room_for(30_000), pytest.raises(OSError, match=rf"full{ending}: {said}"):
        recorded(noise, tmp_path / f"full{ending}")
    assert recorded(noise, tmp_path / f"found{ending}") == 40


def test_a_full_disk_ends_the_track_at_once(noise, tmp_path):
    frames = 60 * list(noise.frames)  # more than the encoder holds back
    truth, seen = np.tile(noise.truth, (60, 1)), np.ones(len(frames))
    long = Sequence("long", frames, truth, seen)
    with room_for(200_000), pytest.raises(OSError, match="frame .* could not be"):
        recorded(long, tmp_path / "full.mkv")
    rows = (tmp_path / "full.csv").read_text().count("\n") - 1
    assert 0 < rows < len(frames) / 2


@pytest.mark.parametrize("room", [10, 1000])
def test_a_table_of_a_video_without_room_is_said(room, noise, tmp_path, capfd):
    said = "found.csv cannot be written: .*; make room there"
    with room_for(room), pytest.raises(OSError, match=said):
        recorded(noise, tmp_path / "found.webm")
    # Without room for its head it has not begun.
    assert (room == 10) == (not list(tmp_path.iterdir()))


def test_a_notebook_without_room_is_executed_and_the_others_are_kept(
    kept, monkeypatch, capsys
):
    async def run(chapter, on_cell):
        notebook = nbformat.read(chapter.notebook, 4)
        notebook.metadata["length"] = "x" * 1_000_000 * chapters.index(chapter)
        return notebook

    chapters = contents.read().chapters[:2]
    monkeypatch.setattr(execute, "run", run)
    with room_for(500_000):
        assert len(execute.execute_all(chapters)) == 2
    assert f"{kept} cannot be written (" in capsys.readouterr().err
    [first] = kept.rglob("*.*")
    executed = nbformat.reads(first.read_bytes()[SEAL:].decode(), 4)
    assert executed.metadata["length"] == ""


def test_a_book_without_room_ends_with_the_sentence(monkeypatch):
    def build():
        with named("index.html"):
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(book, "build", build)
    with pytest.raises(SystemExit) as stopped:
        cli.run(cli.parse(["book"]))
    assert stopped.value.code == (
        "mkt book: index.html cannot be written: No space left on device; "
        "make room there, or choose another place"
    )


# A track, in a program of its own


# What a program may still do after one of the first two is the same for both.  Of those
# that differ, each kind of file has one, tomorrow the other.
BLOWS = [(signal.SIGTERM, ".mkv")]
BLOWS += [
    ((signal.SIGINT, signal.SIGKILL)[(DAY + k) % 2], kind)
    for k, kind in enumerate(CODECS)
]


@pytest.fixture(scope="module")
def long_video(tmp_path_factory):
    """A video of noise, of which much is written however much the encoder holds."""
    path = tmp_path_factory.mktemp("video") / "noise.avi"
    frame = np.random.default_rng(0).integers(0, 256, (240, 320, 3), np.uint8)
    with video_writer(path, (320, 240), 25) as writer:
        for k in range(400):
            writer.write(np.roll(frame, k, 1))
    return path


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such signals")
@pytest.mark.parametrize("blow, ending", BLOWS, ids=lambda it: getattr(it, "name", it))
def test_a_track_stopped_at_any_moment_leaves_files_of_one_run(
    blow, ending, long_video, tmp_path
):
    output = tmp_path / f"x{ending}"
    words = ["track", long_video, "--box", "40,40,80,60", "--tracker", "ssd"]
    process = subprocess.Popen(
        [sys.executable, "-m", "mkt", *words, "-o", output],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    table = output.with_suffix(".csv")
    wait_until(process, lambda: table.exists() and len(table.read_bytes()) > 2000)
    process.send_signal(blow)
    said = process.communicate(timeout=60)[1]
    rows = table.read_text().splitlines()[1:]
    assert all(row.count(",") == 7 for row in rows)
    assert json.loads(output.with_suffix(".json").read_text())["tracker"] == "ssd"
    if blow == signal.SIGKILL:
        assert process.returncode == -blow
        shown = _shown(output)
        assert shown <= len(rows)
        # The encoders of these hand on as they go; VP8 and FFV1 hold much back.
        assert shown or ending not in (".avi", ".mp4")
    else:
        assert process.returncode == 130 and "Traceback" not in said
        assert f"stopped: {len(rows)} of 400 frames are in both" in said
        assert len(VideoFile(output)) == len(rows) < 400


def _shown(path):
    """How many pictures a player shows of a video that may be cut."""
    opened, shown = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG), 0
    while opened.grab():
        shown += 1
    return shown
