"""Repeated runs: trackers x scenarios x seeds, over processes, cached on disk, with medians and bootstrap intervals.

A job is a handful of names and numbers; its result is one row.  Rows are kept in ``.cache/sweeps`` under a hash of the job and of the
library's source, each written in one piece, so that an interrupted sweep goes on where it stopped and nothing stale is ever read.

joblib runs the jobs: over this machine's processes by itself, over a cluster's inside ``joblib.parallel_config(backend="dask")`` with
a `dask.distributed.Client` of that cluster.
"""

import hashlib
import json
import os
import time
from dataclasses import asdict, dataclass
from functools import lru_cache
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from tqdm import tqdm

from mkt.evaluation import errors, overlap
from mkt.scenarios import SCENARIOS
from mkt.scenes import sequence
from mkt.tracking import track

PACKAGE = Path(__file__).parent
CACHE = PACKAGE.parent / ".cache" / "sweeps"
HIT = 0.2  # overlap above which a frame counts as a true positive, T_lim of [C14]


@dataclass(frozen=True)
class Job:
    """One run: a tracker under a name, a scenario, the seed of the scene and of the tracker, the object and its background."""

    name: str
    tracker: Any
    scenario: str
    seed: int = 0
    object: str = "car"
    background: str = "workshop"


@lru_cache(maxsize=1)
def library_hash():
    """Hash of everything a result can depend on: the source of the package without its figures, pages and commands."""
    sources = sorted([*PACKAGE.glob("*.py"), *(PACKAGE / "trackers").glob("*.py")])
    return hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()


def run(job):
    """Do one job.  Returns its row: who and what, then the numbers of `score` and the CPU time [ms a frame]."""
    clip = sequence(SCENARIOS[job.scenario](job.seed, job.object, job.background))
    for frame in clip.frames:
        pass  # rendered now, so that the clock sees the tracker alone
    start = time.process_time()
    result = track(job.tracker, clip, seed=job.seed)
    milliseconds = 1e3 * (time.process_time() - start) / len(clip)
    names = {key: value for key, value in asdict(job).items() if key != "tracker"}
    return names | score(result, clip) | {"cpu_ms": milliseconds, "evaluations": float(np.mean(result.info["evaluations"][1:]))}


def score(result, clip):
    """What a `Track` is worth on its `Sequence`: means over the visible frames, dict of floats.

    overlap; hits, the share of frames with an overlap above .2; position [px], orientation [rad], scale [log]; lost, 1 when the last
    ten frames are all misses.
    """
    shown = clip.visibility > 0.5
    shown[0] = False  # the tracker was told where the target is
    iou, e = overlap(result.regions, clip.truth, clip.upright), errors(result.regions, clip.truth)
    means = {name: float(np.mean(np.abs(values[shown]))) for name, values in {"overlap": iou, **e._asdict()}.items()}
    return means | {"hits": float(np.mean(iou[shown] > HIT)), "lost": float((iou[shown][-10:] <= HIT).all())}


def sweep(jobs, processes=-1, cache=CACHE):
    """Do all jobs that are not yet in the cache, in parallel, with a progress bar.  Returns their rows in order, list of dicts."""
    missing = sorted((job for job in jobs if not _place(job, cache).is_file()), key=_scene)
    groups = [list(group) for _, group in groupby(missing, _scene)]  # one scene is rendered once, for all of its trackers
    done = Parallel(n_jobs=processes, return_as="generator_unordered")(delayed(_keep)(group, cache) for group in groups)
    with tqdm(total=len(missing), desc="runs", unit="run", disable=None if missing else True) as bar:
        for count in done:
            bar.update(count)
    return [json.loads(_place(job, cache).read_text()) for job in jobs]


def _place(job, cache):
    return Path(cache) / (hashlib.sha256(f"{job!r} {library_hash()}".encode()).hexdigest()[:32] + ".json")


def _scene(job):
    return job.scenario, job.seed, job.object, job.background


def _keep(group, cache):
    """Do some jobs and put each row into the cache in one piece.  Returns how many."""
    for job in group:
        place = _place(job, cache)
        place.parent.mkdir(parents=True, exist_ok=True)
        half = place.with_suffix(f".{os.getpid()}")
        half.write_text(json.dumps(run(job)))
        os.replace(half, place)
    return len(group)


def interval(values, level=0.95, draws=2000, statistic=np.median):
    """A statistic of values (n,) and its bootstrap interval.  Returns (value, low, high)."""
    values = np.asarray(values, float)
    samples = np.random.default_rng(0).choice(values, (draws, len(values)))
    low, high = np.quantile(statistic(samples, axis=1), [(1 - level) / 2, (1 + level) / 2])
    return float(statistic(values)), float(low), float(high)
