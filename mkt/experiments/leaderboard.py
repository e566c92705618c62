"""All trackers on all sequences: who follows best, how surely, and at what cost.

The protocol: a tracker is told the true region in the first frame and nothing after it;
every tracker has one setting for all sequences; what counts are the frames in which the
target is seen.  All trackers have the same seeds, but a tracker that draws no random
numbers runs only once on a recorded sequence, because it would only repeat itself.  A
tracker that refuses a target scores nothing on it.

`recorded` runs over the benchmarks that are found (`mkt.sequences.benchmarks`),
`synthetic` over all kinds of drawn scene (`mkt.scenes`); both give a `Board`, which
`ranking` puts in order; `mkt.experiments.leaderboard_as_text` writes them down.
Intervals and differences are taken over cases.  A case is a seed of the drawn scenes,
each with paths of its own and a pair of object and ground that it shares with other
seeds (`mkt.scenes.drawn`), or a sequence of a benchmark.  ``python3 -m mkt bench
tracking`` prints the first, or the second where there are no benchmarks; `shipped` has
both as they were run for the release (`mkt.experiments.shipped`), which is what the
book shows.

Explained in notebook 14.
"""

import itertools
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd
from tqdm import tqdm

from mkt.experiments import shipped as release
from mkt.experiments.processes import spread
from mkt.experiments.statistics import MEAN, holm, interval, p_value, refused
from mkt.experiments.sweep import Job, Named, rows_of, sweep
from mkt.experiments.timing import one_thread
from mkt.files import DataError
from mkt.scenes import SCENES
from mkt.scenes.drawn import HELD_BACK, Drawn, drawn
from mkt.sequences import benchmarks, tracks
from mkt.sequences.parts import LONGEST, parts
from mkt.trackers import by_name
from mkt.trackers.by_name import LABELS
from mkt.tracking import Tracker, track
from mkt.types import ArrayLike

SEEDS = range(5)  # of the random numbers on a recorded sequence
# What a tracker scores that would not start.
REFUSED = {"overlap": 0.0, "hits": 0.0, "hits_of_all": 0.0, "area": 0.0, "lost": 1.0}
# Where the settings of `guided` were chosen on BoBoT, see data/trials_of_guided.md.
CHOSEN_ON = r".*/Vid_[ACF]_"
RECKONED = "The CPU time of guided is reckoned, not measured, see data/README.md."
LEVEL = 0.025  # of a test on one side, for who is ahead of whom


@dataclass(frozen=True)
class Board:
    """Results on one kind of data.

    Parameters
    ----------
    title : str
    data : str
        Sentences on what the data are.
    rows : DataFrame
        Of `mkt.experiments.sweep.sweep`.
    case : str
        The column whose values are taken as independent of each other, "seed" or
        "source".
    jobs : list of Job
        The jobs that made the rows, one for each; none for rows that were read.
    """

    title: str
    data: str
    rows: pd.DataFrame
    case: str
    jobs: list[Job] = field(default_factory=list)


@dataclass(frozen=True)
class Place:
    """A tracker's place.

    Parameters
    ----------
    name : str
    places : (first, last)
        The first and the last place that it may have.
    overlap : float
        Mean over the sequences.
    interval : (low, high)
        95 % over cases.
    behind : (value, low, high), optional
        The overlap of the first tracker minus this one's; None for the first.
    hits, hits_of_all, area, lost, cpu_ms : float
    cells : dict
        Sequence -> (overlap, true positives).
    cases : list of float
        The mean overlap in each case.
    """

    name: str
    places: tuple[int, int]
    overlap: float
    interval: tuple[float, float]
    behind: tuple[float, float, float] | None
    hits: float
    hits_of_all: float
    area: float
    lost: float
    cpu_ms: float
    cells: dict[str, tuple[float, float]]
    cases: list[float]


def recorded(
    names: Iterable[str] = (),
    seeds: Sequence[int] = SEEDS,
    processes: int = -1,
    archive: str = "",
    on: Iterable[str] = (),
    starts: int = 0,
) -> tuple[list[Board], list[str]]:
    """Trackers, all by default, on every benchmark sequence that can be used.

    Parameters
    ----------
    names : iterable of str
    seeds : sequence of int
    processes : int
    archive : str
        Only this benchmark, such as BoBoT.
    on : iterable of str
        Only these sequences, see `mkt.sequences.benchmarks.named`.
    starts : int
        From as many frames of each, forwards and as many backwards, see
        `mkt.sequences.parts`; 0 for each from its first frame to its last.

    Returns
    -------
    boards : list of one `Board`, or empty
        Empty where there are no sequences.
    troubles : list of str
        What is wrong with the sequences that were left out.

    Raises
    ------
    ValueError
        For an unknown tracker, without a seed, and for an unknown sequence.
    DataError
        For a folder of benchmarks that is not there.
    """
    trackers = _trackers(names, seeds)
    usable, troubles = benchmarks.usable(map(benchmarks.named, on))
    found = {o: w for o, w in usable.items() if archive in ("", o.archive.name)}
    sources: list[Named] = list(found)
    if starts:
        sources = [part for one in found for part in parts(one, starts)]
    if not sources:
        return [], troubles
    jobs, rows, broken = _readable(_repeated(trackers, sources, seeds), processes)
    troubles += map(str, broken.values())
    if not jobs:
        return [], troubles
    found = {one: words for one, words in found.items() if one.name not in broken}
    titles = ", ".join(dict.fromkeys(one.archive.name for one in found))
    there = "; ".join(f"{one.name}, {words}" for one, words in found.items())
    data = f"Real sequences: {there}."
    if starts:
        data += (
            f" {len({job.source for job in jobs})} parts of them, at most {LONGEST} "
            f"frames long: each sequence from {counted(starts, 'frame')} forwards, and "
            f"from {starts} backwards."
        )
        rows[["start", "way"]] = [(job.source.start, job.source.way) for job in jobs]
    return [Board(titles, data, rows, "source", jobs)], troubles


def _readable(
    jobs: list[Job], processes: int
) -> tuple[list[Job], pd.DataFrame, dict[str, DataError]]:
    """The jobs whose sources are whole, their rows, and what is wrong with the others.

    A sequence of which one part is broken is left out with all its parts.
    """
    rows, broken = rows_of(jobs, processes)
    done = [k for k, job in enumerate(jobs) if job.source.name not in broken]
    return [jobs[k] for k in done], pd.DataFrame([rows[k] for k in done]), broken


def _repeated(
    trackers: Mapping[str, Tracker],
    found: Iterable[Named],
    seeds: Sequence[int],
) -> list[Job]:
    """Jobs for every seed of the trackers that draw, and for one of the others."""
    repeats = {
        label: seeds if draws(one) else seeds[:1] for label, one in trackers.items()
    }
    return [
        Job(label, trackers[label], source, seed)
        for source in found
        for label, each in repeats.items()
        for seed in each
    ]


def synthetic(
    names: Iterable[str] = (),
    seeds: Sequence[int] = HELD_BACK,
    processes: int = -1,
    kinds: Iterable[str] = SCENES,
) -> Board:
    """Trackers, all by default, on drawn scenes of all kinds by default.

    Each seed has a path of its own; its item is one of four, and so is its ground, see
    `mkt.scenes.drawn`.  Raises as `recorded` does, and for an unknown kind.
    """
    trackers = _trackers(names, seeds)
    jobs = [
        Job(label, tracker, drawn(kind, seed), seed)
        for kind in kinds
        for label, tracker in trackers.items()
        for seed in seeds
    ]
    return replace(_drawn_board(sweep(jobs, processes)), jobs=jobs)


def _drawn_board(rows: pd.DataFrame) -> Board:
    pairs = rows[["item", "ground"]].drop_duplicates()
    items, grounds = pairs.nunique()
    kinds = rows["source"].unique()
    data = (
        f"Drawn scenes whose truth is exact, of {counted(len(kinds), 'kind')}: "
        f"{', '.join(kinds)}. Of each kind {counted(rows['seed'].nunique(), 'scene')}, "
        f"of {counted(len(pairs), 'pair')} of object and ground: "
        f"{counted(items, 'object')} before {counted(grounds, 'ground')}, each scene "
        "on a path of its own. The intervals speak for new paths of these objects, and "
        "not for new objects."
    )
    return Board("Drawn scenes", data, rows, "seed")


def counted(n: int, thing: str) -> str:
    """A number with the word for what is counted, "1 scene" or "2 scenes"."""
    return f"{n} {thing}" if n == 1 else f"{n} {thing}s"


def shipped() -> list[Board]:
    """The boards of the release: drawn scenes, and BoBoT.

    Raises
    ------
    DataError
        Where a table cannot be read.
    """
    drawn_rows, made = release.read_runs(release.TRACKED)
    scenes = _drawn_board(drawn_rows)
    boards = [replace(scenes, data=f"{scenes.data} {RECKONED}")]
    rows, made_there = release.read_runs(release.BOBOT)
    frames = (
        "Real sequences of BoBoT, eight of its twelve, measured where they were on the "
        f"disk. {RECKONED}"
    )
    boards.append(Board("BoBoT", f"{frames} {_on_the_others(rows)}", rows, "source"))
    origins = zip(boards, (made, made_there), strict=True)
    return [_dated(board, one) for board, one in origins]


def _on_the_others(rows: pd.DataFrame) -> str:
    """Who is ahead of whom on the sequences of BoBoT on which nothing was chosen."""
    others = rows[~rows["source"].str.match(CHOSEN_ON)]
    first, *rivals = ranking(Board("", "", others, "source"))
    alike = [one for one in rivals if not _is_ahead(first.cases, one.cases)]
    but = f", but not from {' or from '.join(map(_led, alike))}" if alike else ""
    last = f" to {first.places[1]}" if alike else ""
    apart = len(rivals) - len(alike)
    return (
        "The settings of guided were chosen on A, C, F and the pedestrian 9 of "
        f"PETS09-S2L1, and on drawn scenes. On the {len(first.cases)} others of BoBoT "
        f"{LABELS[first.name]} is first, {first.overlap:.3f}, and the second is "
        f"{_led(rivals[0])}. The test of the leaderboard's places tells the first from "
        f"{apart} of {len(rivals)} rivals{but}: its place is 1{last}.  Of so few "
        "sequences the test rests on a normal distribution."
    )


def _led(place: Place) -> str:
    """A tracker, its overlap, and how far the first is ahead of it, in words."""
    lead, low, high = np.round(place.behind, 3) + 0.0  # no minus before a zero
    return (
        f"{LABELS[place.name]}, {place.overlap:.3f} (a lead of {lead:.3f}, {low:.3f} "
        f"to {high:.3f})"
    )


def for_release(table: Path, names: Iterable[str]) -> Board | None:
    """Some trackers on what a table of the release has; None where that is missing.

    Raises
    ------
    ValueError
        For a broken sequence, without which the table would be another one.
    """
    if table == release.TRACKED:
        return synthetic(names)
    boards, troubles = recorded(names, archive="BoBoT")
    if troubles:
        raise ValueError(f"a release leaves no sequence out: {troubles[0]}")
    return boards[0] if boards else None


def _dated(board: Board, made: release.Made) -> Board:
    data = f"{board.data} The newest runs are of {made.date}, the seeds {made.seeds}."
    return replace(board, data=data)


def _trackers(names: Iterable[str], seeds: Sequence[int]) -> dict[str, Tracker]:
    if not seeds:
        raise ValueError("no seeds; there must be at least one, such as 0:1")
    return {name: by_name.TRACKERS[name] for name in list(names) or by_name.TRACKERS}


def draws(tracker: Tracker) -> bool:
    """Whether a tracker uses its random numbers: found out over three frames."""
    clip = Drawn("base").sequence()
    rng = np.random.default_rng(0)
    before = rng.bit_generator.state
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    for frame in clip.frames[1:3]:
        state, _ = tracker.step(state, frame, rng)
    return rng.bit_generator.state != before


def write_tracks(board: Board, folder: Path, processes: int = -1) -> None:
    """Run the jobs of a board again, and write what each found, frame by frame.

    That is a table (.csv), and MOT's rows (.txt), see `mkt.sequences.tracks`.  Where a
    tracker refused the target there is neither.

    Parameters
    ----------
    board : Board
    folder : Path
        Made where there is none; a file is TRACKER-SOURCE-SEED, with _ for letters that
        the name of a file may not have, and a number where two would be alike.
    processes : int
        At once; -1 for as many as there are cores.

    Raises
    ------
    OSError
        Where a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    every = zip(board.jobs, refused(board.rows), strict=True)
    jobs = [job for job, no in every if not no]
    paths = [folder / name for name in _file_names(jobs)]
    done = spread(_write_track, zip(jobs, paths, strict=True), processes)
    for _ in tqdm(done, desc="tracks", unit="run", total=len(jobs)):
        pass


def _file_names(jobs: Iterable[Job]) -> list[str]:
    """A name without ending for each job, no two alike, even where case is nothing."""
    names: list[str] = []
    taken: set[str] = set()
    for job in jobs:
        plain = f"{job.label}-{job.source.name}-{job.seed}"
        name = fresh = re.sub(r"[^\w.-]+", "_", plain)
        for number in itertools.count(2):
            if fresh.casefold() not in taken:
                break
            fresh = f"{name}-{number}"
        taken.add(fresh.casefold())
        names.append(fresh)
    return names


def _write_track(job: Job, place: Path) -> None:
    with one_thread():
        found = track(job.tracker, job.source.sequence(), job.seed)
    for ending in (".csv", ".txt"):
        first = getattr(job.source, "first", 0)
        tracks.write(found, place.with_name(f"{place.name}{ending}"), first)


def ranking(board: Board) -> list[Place]:
    """The trackers of a board in order of their mean overlap."""
    scored = board.rows.copy()
    started = ~refused(scored)
    for number, value in REFUSED.items():
        scored[number] = scored[number].where(started, value)
    cases = cases_of(replace(board, rows=scored))
    order = cases.mean().sort_values(ascending=False).index
    return [
        _place(str(name), scored[scored["tracker"] == name], cases[order])
        for name in order
    ]


def cases_of(board: Board) -> pd.DataFrame:
    """The mean overlap of each tracker (columns) in each case (rows)."""
    return board.rows.groupby([board.case, "tracker"])["overlap"].mean().unstack()


def _place(name: str, runs: pd.DataFrame, cases: pd.DataFrame) -> Place:
    """The place of a tracker, given the overlaps of all, the best first."""
    numbers = ["overlap", "hits", "hits_of_all", "area", "lost"]
    by_source = runs.groupby("source", sort=False)[numbers].mean()
    means = by_source.mean()
    own, first = cases[name], cases.columns[0]
    _, low, high = interval(own, MEAN)
    lead = None if name == first else interval(cases[first] - own, MEAN)
    times = runs.loc[~refused(runs), "cpu_ms"]
    return Place(
        name,
        _between(name, cases),
        means["overlap"],
        (low, high),
        lead,
        means["hits"],
        means["hits_of_all"],
        means["area"],
        means["lost"],
        times.median(),
        {str(s): (row["overlap"], row["hits"]) for s, row in by_source.iterrows()},
        own.tolist(),
    )


def _between(name: str, cases: pd.DataFrame) -> tuple[int, int]:
    """The first and the last place that a tracker may have."""
    others = [cases[other] for other in cases.columns if other != name]
    better = sum(_is_ahead(other, cases[name]) for other in others)
    worse = sum(_is_ahead(cases[name], other) for other in others)
    return 1 + better, len(cases.columns) - worse


def _is_ahead(one: ArrayLike, other: ArrayLike) -> bool:
    """Whether the overlaps of one tracker are larger than another's, case by case."""
    return _chance(one, other) < LEVEL


def _chance(one: ArrayLike, other: ArrayLike) -> float:
    return p_value(np.subtract(one, other), MEAN, 0, "greater")


def told_apart(places: Sequence[Place]) -> tuple[int, int, int]:
    """How many pairs of trackers there are, and in how many one is surely ahead.

    Parameters
    ----------
    places : sequence of Place
        In order, as `ranking` gives them.

    Returns
    -------
    pairs, single, together : int
        All; those that the test of the places tells apart, each for itself; and those
        that it still does after Holm's correction over all pairs.
    """
    pairs = itertools.combinations(places, 2)
    p = [_chance(one.cases, other.cases) for one, other in pairs]
    single, together = (int(np.sum(np.asarray(each) < LEVEL)) for each in (p, holm(p)))
    return len(p), single, together
