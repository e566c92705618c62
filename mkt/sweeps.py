"""Repeated runs: trackers x scenarios x seeds, over processes, cached on disk, with medians and bootstrap intervals.

A job is a handful of names and numbers; its result is one row.  `Job` is a run on a synthetic scene, `Recorded` one on a real sequence.
Rows are kept in ``.cache/sweeps`` under a hash of the job and of all that it can depend on, each written in one piece, so that an interrupted
sweep goes on where it stopped (at most the scenes under way are lost), two sweeps may run at once, and nothing stale or half-written is ever read.

joblib runs the jobs, over this machine's processes by itself.  A sweep that outgrows the machine runs unchanged on a cluster with
this package installed; rows come back over the network, so the machines need no common disk:

    from dask.distributed import Client          # pip install distributed
    from joblib import parallel_config

    with Client("tcp://scheduler:8786"), parallel_config(backend="dask"):
        rows = sweep(jobs)

Reading order: `Job`, `run`, `score`, `sweep`; then `interval`, `summaries`, `table`.
"""

import ast
import csv
import hashlib
import json
import sys
import time
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import groupby
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from joblib import Parallel, delayed
from tqdm import tqdm

from mkt.archives import Found
from mkt.evaluation import HIT, errors, judged, overlaps, success, true_positives
from mkt.files import whole
from mkt.scenarios import SCENARIOS
from mkt.scenes import sequence
from mkt.tracking import follow, track
from mkt.twins import TWINS

PACKAGE = Path(__file__).parent
CACHE = PACKAGE.parent / ".cache" / "sweeps"
SCENES = SCENARIOS | TWINS
TURNED = 45.0  # [deg] beyond this the orientation is not the target's
SHRUNK = 0.5  # share of the true area below which a region has shrunk
NUMBERS = ("overlap", "hits", "hits_of_all", "area", "position", "orientation", "scale", "shrunk", "lost", "failed", "cpu_ms", "evaluations", "steps")
SUMMARISED = ("overlap", "position", "orientation", "scale", "hits", "lost", "evaluations", "cpu_ms")
SHARES = ("lost", "failed")  # 0 or 1 a run: their mean says more than their median


@dataclass(frozen=True)
class Job:
    """One run: a tracker under a name, a scenario, the seed of the scene and of the tracker, the object and its background."""

    name: str
    tracker: Any
    scenario: str
    seed: int = 0
    object: str = "car"
    background: str = "workshop"

    @property
    def scene(self):
        """What jobs on the same frames have in common; they are run together, so that each frame is rendered once."""
        return self.scenario, self.seed, self.object, self.background

    def clip(self):
        """The `Sequence`."""
        return sequence(SCENES[self.scenario](self.seed, self.object, self.background))


@dataclass(frozen=True)
class Recorded:
    """One run on a real sequence: a tracker under a name, the `Found` sequence, its name and its files' fingerprint, the tracker's seed."""

    name: str
    tracker: Any
    found: Found = field(repr=False)  # the same files at another place are the same job
    scenario: str
    fingerprint: str
    seed: int = 0
    object: str = ""
    background: str = ""

    @property
    def scene(self):
        """Each for itself: to read a frame again costs little."""
        return self.scenario, self.seed, self.name, ""

    def clip(self):
        """The `Sequence`."""
        return self.found.read()


class Clocked:
    """The frames of a `Sequence`, with the CPU time [s] that it took to make them: that time is not the tracker's."""

    def __init__(self, frames):
        self.frames, self.seconds = frames, 0.0

    def __len__(self):
        return len(self.frames)

    def __getitem__(self, k):
        start = time.process_time()
        frame = self.frames[k]
        self.seconds += time.process_time() - start
        return frame


def run(job):
    """Do one job.  Returns its row: who and what, the numbers of `score`, and what it cost.

    cpu_ms: CPU time [ms a frame], on a machine that is busy with other jobs; evaluations: regions looked at in a frame.
    steps: of the optimiser in a frame, over the frames in which it ran, NaN where there is none.
    refused: why the tracker would not start on this target, empty where it did; all numbers are NaN then.
    """
    clip = job.clip()
    clip = replace(clip, frames=Clocked(clip.frames))
    row = {key: getattr(job, key) for key in ("name", "scenario", "seed", "object", "background")}
    try:
        next(follow(job.tracker, clip, job.seed))
    except ValueError as error:
        return row | dict.fromkeys(NUMBERS, np.nan) | {"refused": str(error)}
    clip.frames.seconds, start = 0.0, time.process_time()
    result = track(job.tracker, clip, seed=job.seed)
    milliseconds = 1e3 * (time.process_time() - start - clip.frames.seconds) / len(clip)
    steps = [k for k in result.info.get("steps", [])[1:] if k]
    cost = {"cpu_ms": milliseconds, "evaluations": float(np.mean(result.info["evaluations"][1:])), "steps": float(np.mean(steps)) if steps else np.nan}
    return row | score(result, clip) | cost | {"refused": ""}


def score(result, clip):
    """What a `Track` is worth on its `Sequence`: means over the judged frames, dict of floats.

    overlap; hits, the share of true positives; hits_of_all, the same out of all frames, hidden ones too; area under the success curve.
    position [px], orientation [deg], scale [log], all without sign.
    shrunk: the share of frames in which the region has less than half of the true area.
    lost, failed: 1 when none of the last ten frames is a hit, or none is one with the orientation right to 45 degrees.
    """
    every, shown = overlaps(result.regions, clip), judged(clip)
    iou, e = every[shown[1:]], errors(result.regions[shown], clip.truth[shown])
    degrees, hit = np.rad2deg(e.orientation), iou > HIT
    right = hit & (clip.upright | (degrees <= TURNED))
    return {
        "overlap": float(np.mean(iou)), "hits": float(true_positives(every)), "hits_of_all": float(true_positives(every, hidden=True)),
        "area": float(np.mean(success(every))), "position": float(np.mean(e.position)),
        "orientation": float(np.mean(degrees)), "scale": float(np.mean(np.abs(e.scale))),
        "shrunk": float(np.mean(np.exp(2 * e.scale) < SHRUNK)),
        "lost": float(not hit[-10:].any()), "failed": float(not right[-10:].any()),
    }


def known(jobs, cache=CACHE):
    """The rows of the jobs that are in the cache, None for the others."""
    return [_kept(_place(job, cache)) for job in jobs]


def sweep(jobs, processes=-1, cache=CACHE):
    """Do all jobs that are not yet in the cache, in parallel, with a progress bar.  Returns their rows in order, list of dicts.

    Raises OSError when a row cannot be kept, as on a full disk; those before it are.
    """
    rows = known(jobs, cache)
    missing = sorted((k for k, row in enumerate(rows) if row is None), key=lambda k: jobs[k].scene)
    groups = [list(group) for _, group in groupby(missing, lambda k: jobs[k].scene)]  # one scene is rendered once, for all of its trackers
    done = Parallel(n_jobs=processes, return_as="generator_unordered")(delayed(_run)({k: jobs[k] for k in group}) for group in groups)
    with tqdm(total=len(missing), desc="runs", unit="run", disable=None if missing else True) as bar:
        for fresh in done:
            for k, row in fresh.items():
                rows[k] = row
                _keep(row, _place(jobs[k], cache))
            bar.update(len(fresh))
    return rows


def _run(group):
    with one_thread():
        return {k: run(job) for k, job in group.items()}


@contextmanager
def one_thread():
    """OpenCV with a single thread for a while: its threads stand in each other's way on a busy machine, and blur a measured time."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(before)


def _place(job, cache):
    return Path(cache) / (hashlib.sha256(f"{job!r} {library_hash()}".encode()).hexdigest()[:32] + ".json")


def _kept(place):
    """The row in a file of the cache, None where there is none or but a part of one."""
    try:
        return json.loads(place.read_text())
    except (FileNotFoundError, ValueError):
        return None


def _keep(row, place):
    """Put a row into the cache in one piece, whoever else may be doing the same."""
    place.parent.mkdir(parents=True, exist_ok=True)
    with whole(place) as half:
        half.write_text(json.dumps(row))


@lru_cache(maxsize=1)
def library_hash():
    """Hash of all that a row can depend on: the `sources`, the packages and Python.  Comments and layout are no part of it."""
    trees = [ast.dump(ast.parse(path.read_text(encoding="utf-8"))) for path in sources()]
    packages = (PACKAGE.parent / "environment.txt").read_text(encoding="utf-8")
    return hashlib.sha256("\n".join([sys.version, packages, *trees]).encode()).hexdigest()


def sources():
    """The files of the package that a job can reach: this one, all trackers, and whatever they import.  Returns a sorted list of paths."""
    found, waiting = set(), [Path(__file__), *(PACKAGE / "trackers").glob("*.py")]
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += _imported(path)
    return sorted(found)


def _imported(path):
    """The files of the package that a file imports, anywhere in it."""
    names = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names += [f"{node.module}.{alias.name}" for alias in node.names]
    parts = [name.split(".")[1:] for name in names if name.startswith("mkt.")]
    places = [PACKAGE.joinpath(*part[:k]) for part in parts for k in range(1, len(part) + 1)]
    return [file for place in places for file in (place.with_suffix(".py"), place / "__init__.py") if file.is_file()]


def interval(values, level=0.95, draws=2000, statistic=np.median):
    """A statistic of values (n,) and its bootstrap interval.  Returns (value, low, high), all NaN where a value is."""
    values = np.asarray(values, float)
    samples = np.random.default_rng(0).choice(values, (draws, len(values)))
    low, high = np.quantile(statistic(samples, axis=1), [(1 - level) / 2, (1 + level) / 2]) if np.isfinite(values).all() else (np.nan, np.nan)
    return float(statistic(values)), float(low), float(high)


def summaries(rows):
    """One line for each scenario and tracker: how many runs, then each number of `SUMMARISED` with its interval.

    rows: of `sweep`.  Returns a list of dicts; the ends of the interval of "overlap" are "overlap_low" and "overlap_high".  Medians,
    but means of the shares of runs that were lost.
    """
    cells = {}
    for row in rows:
        cells.setdefault((row["scenario"], row["name"]), []).append(row)
    return [{"scenario": scenario, "name": name, "runs": len(cell)} | _summary(cell) for (scenario, name), cell in cells.items()]


def _summary(cell):
    result = {}
    for key in SUMMARISED:
        numbers = interval([row[key] for row in cell], statistic=np.mean if key in SHARES else np.median)
        result |= dict(zip((key, f"{key}_low", f"{key}_high"), numbers))
    return result


def table(rows, path):
    """Write rows, dicts of the same keys, as one CSV file with a head line: the rows of a sweep, or their summaries.  Raises OSError."""
    with whole(path) as half, half.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
