"""Many runs at once: trackers x sources x seeds, over processes, kept on disk.

A `Job` is a tracker under a label, a source, and a seed; its result is one row of
numbers.  Rows are kept (`mkt.experiments.cache`) under all that they depend on, each as
a whole, so that an interrupted sweep goes on where it stopped (at most the sources
under way are lost), two sweeps may run at once, and nothing stale is ever read.

joblib runs the jobs, by default in processes of this machine.  A sweep that outgrows
the machine runs unchanged on a cluster with this package installed; rows come back over
the network, so the machines need no common disk:

    from dask.distributed import Client          # pip install distributed
    from joblib import parallel_config

    with Client("tcp://scheduler:8786"), parallel_config(backend="dask"):
        rows = sweep(jobs(trackers, sources, range(5)))
"""

import json
import reprlib
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import groupby
from operator import attrgetter
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pandas as pd
from tqdm import tqdm

from mkt import checks, evaluation
from mkt.evaluation import JUDGED, evaluate, mean_of
from mkt.experiments import cache, dependencies
from mkt.experiments.processes import spread
from mkt.experiments.timing import Clocked, one_thread
from mkt.files import DataError, whole
from mkt.tracking import Sequence, Source, Track, Tracker, check_tracker, track

EFFORT = "evaluations", "steps"  # NaN for a tracker that does not report it
NUMBERS = (*JUDGED, "cpu_ms", *EFFORT)
WHO = "tracker", "source", "seed", "item", "ground", "refused"
ROWS = cache.Shelf("rows", ".json", cache.as_json, json.loads)


class Named(Source, Protocol):
    """A source with a name, under which tables put its runs together.

    If it reads files it needs an ``identity`` too, see `mkt.tracking.Source`.
    """

    @property
    def name(self) -> str:
        """What tables call it."""
        ...


@dataclass(frozen=True)
class Job:
    """One run.

    Parameters
    ----------
    label : str
        What tables call the tracker.
    tracker : Tracker
    source : Named
    seed : int
        Of the tracker's random numbers.
    """

    label: str
    tracker: Tracker
    source: Named
    seed: int = 0

    def key(self, source: str = "") -> str | None:
        """The key under which its row is kept, None where it cannot be kept.

        Parameters
        ----------
        source : str
            What identifies the source, where it is known: to look at all files of a
            recorded one takes a while.
        """
        code = dependencies.code_of(self.tracker, self.source, evaluation)
        origin = source or cache.identity(self.source)
        if code is None or origin is None:
            return None
        return cache.key(self.label, self.tracker, origin, self.seed, code)


def jobs(
    trackers: Mapping[str, Tracker],
    sources: Iterable[Named],
    seeds: Iterable[int] = (0,),
) -> list[Job]:
    """Every tracker on every source with every seed.

    Raises
    ------
    ValueError
        For trackers without labels, labels that are no text or number, what is no
        tracker, what gives no sequence, and seeds that are not whole.
    """
    if not isinstance(trackers, Mapping):
        raise ValueError("trackers has no labels; give a dict, {label: tracker}")
    for tracker in trackers.values():
        check_tracker(tracker)
    sources, seeds = _several("sources", sources), _several("seeds", seeds)
    for source in sources:
        if not (hasattr(source, "sequence") and hasattr(source, "name")):
            raise ValueError(
                f"{reprlib.repr(source)} is no source of a sequence; give one such as "
                'mkt.Drawn("base", 1) or mkt.Carphone(), not the sequence itself'
            )
    for seed in seeds:
        checks.check_seed(seed)
    every = list(map(int, seeds))  # numpy's own cannot be kept as text
    named = [(_checked_label(label), one) for label, one in trackers.items()]
    return [
        Job(label, tracker, source, seed)
        for source in sources
        for label, tracker in named
        for seed in every
    ]


def _checked_label(label: Any) -> str | int | float:
    """A label that is the same when it comes back from a file; else a ValueError.

    A tuple would come back as a list, and no table counts runs under None or NaN.
    """
    label = label.item() if isinstance(label, np.generic) else label
    if not isinstance(label, str | int | float) or label != label:
        raise ValueError(
            f"trackers has the label {reprlib.repr(label)}; give a text or a number"
        )
    return label


def _several(field: str, things: Iterable[Any]) -> list[Any]:
    """The things as a list; ValueError for a single one."""
    if isinstance(things, str) or not isinstance(things, Iterable):
        raise ValueError(f"{field} is {reprlib.repr(things)}; give several, as a list")
    return list(things)


def run(job: Job) -> dict[str, Any]:
    """Do one job.

    Returns
    -------
    dict
        tracker, source, seed, item, ground : who and what; the last two of drawn
        scenes.
        The numbers of `mkt.evaluation.evaluate`.
        cpu_ms : CPU time [ms/frame], on a machine that is busy with other jobs.
        evaluations : regions looked at in a frame; NaN where the tracker does not
        report them.
        steps : of the optimiser in a frame, over those in which it ran; NaN without.
        refused : why the tracker would not start on this target, empty where it did;
        all numbers are NaN then.
    """
    clip = job.source.sequence()
    frames = Clocked(clip.frames)
    clip = replace(clip, frames=frames)
    seed = int(job.seed)  # numpy's own cannot be kept as text
    row = {"tracker": job.label, "source": job.source.name, "seed": seed}
    row |= {name: getattr(job.source, name, "") for name in ("item", "ground")}
    if refused := _refusal(job, clip):
        return row | dict.fromkeys(NUMBERS, np.nan) | {"refused": refused}
    frames.seconds = 0.0
    start = time.process_time()
    result = track(job.tracker, clip, job.seed)
    seconds = time.process_time() - start - frames.seconds
    cost = {"cpu_ms": 1e3 * seconds / len(clip)} | _effort(result)
    return row | evaluate(result, clip) | cost | {"refused": ""}


def _refusal(job: Job, clip: Sequence) -> str:
    """Why the tracker would not start on this target, empty where it does.

    What is wrong with the job or its data is raised, here or by `track`.
    """
    first = np.array(clip.truth[0], float)
    if job.seed < 0 or not np.isfinite(first).all():
        return ""
    check_tracker(job.tracker)
    frame = clip.frames[0]
    try:
        job.tracker.init(frame, first, np.random.default_rng(job.seed))
    except ValueError as error:
        if isinstance(error, DataError):
            raise
        return str(error)
    return ""


def _effort(result: Track) -> dict[str, float]:
    """The effort of a track, which does not depend on how fast the machine is."""
    nothing = np.empty(0)
    looked, steps = (result.info.get(name, nothing) for name in EFFORT)
    return {"evaluations": mean_of(looked[1:]), "steps": mean_of(steps[steps > 0])}


def _identities(jobs: list[Job]) -> list[str]:
    """What identifies the source of each job; each source is asked once.

    Empty where nothing does.
    """
    asked = {id(job.source): job.source for job in jobs}
    known = {number: cache.identity(source) or "" for number, source in asked.items()}
    return [known[id(job.source)] for job in jobs]


def sweep(
    jobs: Iterable[Job], processes: int = -1, parameters: str | Iterable[str] = ()
) -> pd.DataFrame:
    """Do all jobs that are not yet known, in parallel, with a progress bar.

    Parameters
    ----------
    jobs : iterable of Job
    processes : int
        At once; -1 for as many as there are cores.
    parameters : str, or iterable of str
        Fields of the trackers that are to be columns too, "n" or "filter.n"; NaN where
        a tracker has none of that name.

    Returns
    -------
    DataFrame
        The rows of `run`, in the order of the jobs.

    Raises
    ------
    ValueError
        For a parameter that has the name of another column, or that no tracker has; and
        for another number of processes.
    DataError
        For a source that cannot be read to its end; rows of the others are kept first.
    """
    jobs = list(jobs)
    names = [parameters] if isinstance(parameters, str) else list(parameters)
    if taken := sorted({*names} & {*WHO, *NUMBERS}):
        raise ValueError(
            f"parameters has {taken[0]!r}, a column that every sweep has; leave it "
            "out, and let the labels of the trackers say it"
        )
    _check_parameters(jobs, names)
    rows, broken = rows_of(jobs, processes)
    for error in broken.values():
        raise error
    columns = {name: [_parameter(job, name) for job in jobs] for name in names}
    known = None if rows else [*WHO, *NUMBERS]  # of no jobs at all
    return pd.DataFrame(rows, columns=known).assign(**columns)


def rows_of(
    jobs: list[Job], processes: int = -1
) -> tuple[list[dict[str, Any] | None], dict[str, DataError]]:
    """What `sweep` puts into its table, where sources may be broken.

    Returns
    -------
    rows : list of dict or None
        Of each job; None where its source is broken.
    broken : dict
        The name of a source that cannot be read to its end -> what is wrong with it.
    """
    sources = _identities(jobs)
    keys = [job.key(of) for job, of in zip(jobs, sources, strict=True)]
    rows = [None if key is None else ROWS.get(key) for key in keys]
    broken: dict[str, DataError] = {}
    missing = [k for k, row in enumerate(rows) if row is None]
    groups = ((group,) for group in _groups(jobs, missing, sources))
    done = spread(_run_group, groups, processes, in_order=False)
    quiet = None if missing else True
    with tqdm(total=len(missing), desc="runs", unit="run", disable=quiet) as bar:
        for fresh in done:
            now = _identities([jobs[k] for k in fresh])
            for (k, row), source in zip(fresh.items(), now, strict=True):
                if isinstance(row, DataError):
                    broken[jobs[k].source.name] = row
                else:
                    rows[k] = row
                    # What has changed meanwhile, such as weights, may have been read
                    # before or after.
                    if keys[k] is not None and keys[k] == jobs[k].key(source):
                        ROWS.put(keys[k], row)
            bar.update(len(fresh))
    return rows, broken


def _check_parameters(jobs: list[Job], names: list[str]) -> None:
    """Refuse a name, such as a misspelt one, that no tracker has for a field."""
    for name in names:
        if jobs and not any(_has(job, name) for job in jobs):
            tracker = jobs[0].tracker
            known = ", ".join(getattr(tracker, "__dataclass_fields__", ()))
            raise ValueError(
                f"parameters has {name!r}, a field that no tracker has; "
                f"{type(tracker).__name__} has {known or 'none'}"
            )


def _parameter(job: Job, name: str) -> Any:
    """A field of a job's tracker, NaN where it has none of that dotted name."""
    return attrgetter(name)(job.tracker) if _has(job, name) else np.nan


def _has(job: Job, name: str) -> bool:
    """Whether a job's tracker has a field of that dotted name."""
    try:
        attrgetter(name)(job.tracker)
    except AttributeError:
        return False
    return True


def _groups(
    jobs: list[Job], missing: list[int], sources: list[str]
) -> list[dict[int, Job]]:
    """The missing jobs, those on one source together: each frame is rendered once."""

    def source(k: int) -> str:
        return sources[k] or str(id(jobs[k].source))

    ordered = sorted(missing, key=source)
    return [{k: jobs[k] for k in group} for _, group in groupby(ordered, source)]


def _run_group(group: dict[int, Job]) -> dict[int, dict[str, Any] | DataError]:
    """The rows of jobs on one source, or for each what is wrong with that source."""
    try:
        with one_thread():
            return {k: run(job) for k, job in group.items()}
    except DataError:
        first, *_ = group.values()
        if broken := _broken(first.source):
            return dict.fromkeys(group, broken)
        raise  # it is the tracker that lacks something, or the job


def _broken(source: Named) -> DataError | None:
    """What is wrong with the frames of a source, None where all can be read."""
    try:
        for _ in source.sequence().frames:
            pass
    except DataError as error:
        return error
    return None


def write_table(rows: pd.DataFrame, path: Path) -> None:
    """Write a table as one CSV file with a head line.  Raises OSError."""
    with whole(path) as half:
        rows.to_csv(half, index=False, encoding="utf-8", lineterminator="\n")
