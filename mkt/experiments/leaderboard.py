"""All trackers on all sequences: who follows best, how surely, and at what cost.

The protocol: a tracker is told the true region in the first frame and nothing after it;
every tracker has one setting for all sequences; what counts are the frames in which the
target is seen.  The same seeds for all; a tracker that draws no random numbers runs
once on a recorded sequence, for it would only repeat itself.  A tracker that refuses a
target scores nothing on it.

`recorded` runs over the benchmarks that are found (`mkt.sequences.benchmarks`),
`synthetic` over the twins (`mkt.scenes.cordoba2014`); both give a `Board`.
``python3 -m mkt bench tracking`` prints the first, or the second where there are no
benchmarks, and the book shows the second.

Explained in notebook 14.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from tabulate import tabulate

from mkt.experiments.statistics import interval
from mkt.experiments.sweep import Job, known, sweep
from mkt.scenes.cordoba2014 import KINDS
from mkt.scenes.drawn import Drawn, drawn
from mkt.sequences import benchmarks
from mkt.trackers import by_name
from mkt.trackers.by_name import LABELS
from mkt.tracking import Tracker

SEEDS = 5
# What a tracker scores that would not start.
REFUSED = {"overlap": 0.0, "hits": 0.0, "hits_of_all": 0.0, "area": 0.0, "lost": 1.0}
HEAD = (
    "tracker",
    "overlap",
    "over seeds",
    "95 % over sequences",
    "true positives [%]",
    "of all frames [%]",
    "area",
    "lost [%]",
    "CPU ms",
)
LEGEND = """\
*overlap*: mean over the seen frames, the seeds, and the sequences.  *over seeds*: the
smallest and the largest of these means for one seed, where several ran.  *95 % over
sequences*: bootstrap, as if these sequences were a few out of many like them.  *true
positives*: seen frames with an overlap above .2; *of all frames*: the same out of all
frames, hidden ones too, as [C14] counts.  *area*: under the success curve, as in OTB.
*lost*: runs without a hit in their last ten frames.  *CPU ms*: for each frame, median
over the runs."""


@dataclass(frozen=True)
class Board:
    """Results on one kind of data.

    Parameters
    ----------
    title : str
    data : str
        A sentence on what the data are.
    rows : DataFrame
        Of `mkt.experiments.sweep.sweep`.
    """

    title: str
    data: str
    rows: pd.DataFrame


@dataclass(frozen=True)
class Place:
    """A tracker's place.

    Parameters
    ----------
    name : str
    overlap : float
        Mean over the sequences.
    seeds : (low, high), optional
        The smallest and the largest mean for one seed, where several ran.
    interval : (low, high)
        95 % over sequences.
    hits, hits_of_all, area, lost, cpu_ms : float
    cells : dict
        Sequence -> (overlap, true positives).
    """

    name: str
    overlap: float
    seeds: tuple[float, float] | None
    interval: tuple[float, float]
    hits: float
    hits_of_all: float
    area: float
    lost: float
    cpu_ms: float
    cells: dict[str, tuple[float, float]]


def recorded(
    names: Iterable[str] = (),
    seeds: int = SEEDS,
    processes: int = -1,
    only_known: bool = False,
) -> tuple[list[Board], list[str]]:
    """Trackers, all by default, on every benchmark sequence that can be used.

    Parameters
    ----------
    names : iterable of str
    seeds, processes : int
    only_known : bool
        Run nothing.

    Returns
    -------
    boards : list of one `Board`, or empty
        Empty where there are no sequences, or not all runs are known.
    troubles : list of str
        What is wrong with the sequences that were left out.

    Raises
    ------
    ValueError
        For an unknown tracker, and without a seed.
    """
    trackers = _trackers(names, seeds)
    found, troubles = benchmarks.usable()
    jobs = _repeated(trackers, found, seeds) if found else []
    if only_known:
        rows = known(jobs)
        table = pd.DataFrame() if None in rows else pd.DataFrame(rows)
    else:
        table = sweep(jobs, processes)
    if table.empty:
        return [], troubles
    titles = ", ".join(dict.fromkeys(one.archive.name for one in found))
    there = "; ".join(f"{one.name}, {words}" for one, words in found.items())
    data = (
        f"Real sequences: {there}. None of them was used to choose a parameter of our "
        "tracker."
    )
    return [Board(titles, data, table)], troubles


def _repeated(
    trackers: Mapping[str, Tracker], found: Iterable[benchmarks.Found], seeds: int
) -> list[Job]:
    """Jobs for every seed of the trackers that draw, and for one of the others."""
    repeats = {label: seeds if draws(one) else 1 for label, one in trackers.items()}
    return [
        Job(label, trackers[label], source, seed)
        for source in found
        for label, n in repeats.items()
        for seed in range(n)
    ]


def synthetic(
    names: Iterable[str] = (), seeds: int = SEEDS, processes: int = -1
) -> Board:
    """Trackers, all by default, on the synthetic twins.

    Each seed has another item, ground and path.  Raises as `recorded` does.
    """
    return _synthetic(_drawn_jobs(_trackers(names, seeds), seeds), processes)


def for_the_book(processes: int = -1) -> list[Board]:
    """The boards of the book.

    They are two seeds of the twins, one of the slow trackers; and the benchmarks, if
    all their runs are known.
    """
    quick = [name for name in by_name.TRACKERS if name not in by_name.SLOW]
    jobs = _drawn_jobs(_trackers(quick, 2), 2)
    jobs += _drawn_jobs(_trackers(by_name.SLOW, 1), 1)
    return [_synthetic(jobs, processes), *recorded(only_known=True)[0]]


def _drawn_jobs(trackers: Mapping[str, Tracker], seeds: int) -> list[Job]:
    return [
        Job(label, tracker, drawn(kind, seed), seed)
        for kind in KINDS
        for label, tracker in trackers.items()
        for seed in range(seeds)
    ]


def _synthetic(jobs: list[Job], processes: int) -> Board:
    data = (
        "Synthetic twins of six kinds of sequence, whose truth is exact: "
        f"{', '.join(KINDS)}. Each seed has an item, a ground and a path of its own."
    )
    return Board("Synthetic", data, sweep(jobs, processes))


def _trackers(names: Iterable[str], seeds: int) -> dict[str, Tracker]:
    if seeds < 1:
        raise ValueError(f"{seeds} seeds; there must be at least 1")
    return {name: by_name.get(name) for name in list(names) or by_name.TRACKERS}


def draws(tracker: Tracker) -> bool:
    """Whether a tracker uses its random numbers: found out over three frames."""
    clip, rng = Drawn("base").sequence(), np.random.default_rng(0)
    before = rng.bit_generator.state
    state = tracker.init(clip.frames[0], clip.truth[0], rng)
    for frame in clip.frames[1:3]:
        state, _ = tracker.step(state, frame, rng)
    return rng.bit_generator.state != before


def ranking(rows: pd.DataFrame) -> list[Place]:
    """The trackers in order of their mean overlap.

    Parameters
    ----------
    rows : DataFrame
        Of a `Board`.
    """
    scored = rows.copy()
    for number, value in REFUSED.items():
        scored[number] = scored[number].where(scored["refused"] == "", value)
    groups = scored.groupby("tracker", sort=False)
    places = [_place(str(name), runs) for name, runs in groups]
    return sorted(places, key=lambda place: -place.overlap)


def _place(name: str, runs: pd.DataFrame) -> Place:
    numbers = ["overlap", "hits", "hits_of_all", "area", "lost"]
    by_source = runs.groupby("source", sort=False)[numbers].mean()
    by_seed = runs.groupby("seed")["overlap"].mean()
    means = by_source.mean()
    _, low, high = interval(by_source["overlap"].to_numpy(), statistic=np.mean)
    times = runs.loc[runs["refused"] == "", "cpu_ms"]
    return Place(
        name,
        means["overlap"],
        (by_seed.min(), by_seed.max()) if len(by_seed) > 1 else None,
        (low, high),
        means["hits"],
        means["hits_of_all"],
        means["area"],
        means["lost"],
        times.median(),
        {str(s): (row["overlap"], row["hits"]) for s, row in by_source.iterrows()},
    )


def overall(places: list[Place]) -> list[list[str]]:
    """The first table: a row of texts under `HEAD` for each place."""
    return [
        [
            LABELS.get(place.name, place.name),
            _two(place.overlap),
            _range(place.seeds) if place.seeds else "",
            _range(place.interval),
            f"{100 * place.hits:.1f}",
            f"{100 * place.hits_of_all:.1f}",
            _two(place.area),
            f"{100 * place.lost:.0f}",
            f"{place.cpu_ms:.2g}" if np.isfinite(place.cpu_ms) else "",
        ]
        for place in places
    ]


def by_sequence(places: list[Place]) -> tuple[list[str], list[list[str]]]:
    """The second table: its head, and for each place overlap / true positives [%]."""
    names = list(dict.fromkeys(name for place in places for name in place.cells))
    rows = [
        [LABELS.get(p.name, p.name), *(_cell(p.cells.get(name)) for name in names)]
        for p in places
    ]
    return ["tracker", *names], rows


def refusals(rows: pd.DataFrame) -> list[str]:
    """Which trackers would not start where, and why, in sentences."""
    refused = rows.loc[rows["refused"] != "", ["tracker", "source", "refused"]]
    return [
        f"{LABELS.get(name, name)} would not start on {source}: {why}"
        for name, source, why in refused.drop_duplicates().itertuples(index=False)
    ]


def extent(board: Board) -> str:
    """How many sequences and runs a board has, in words."""
    n = board.rows["source"].nunique()
    return f"{n} sequence{'' if n == 1 else 's'}, {len(board.rows)} runs"


def as_markdown(board: Board) -> str:
    """A board with both tables, and what the columns mean."""
    places = ranking(board.rows)
    head, rows = by_sequence(places)
    parts = [
        f"## {board.title}: {extent(board)}",
        board.data,
        _table(HEAD, overall(places)),
        LEGEND,
        "Overlap / true positives [%] on each sequence:",
        _table(head, rows),
        *refusals(board.rows),
    ]
    return "\n\n".join(parts)


def _table(head: Iterable[str], rows: list[list[str]]) -> str:
    return tabulate(rows, list(head), tablefmt="github", disable_numparse=True)


def _cell(numbers: tuple[float, float] | None) -> str:
    if numbers is None:
        return ""
    return f"{_two(numbers[0])} / {100 * numbers[1]:.0f}"


def _range(ends: tuple[float, float]) -> str:
    return f"{_two(ends[0])} to {_two(ends[1])}"


def _two(share: float) -> str:
    return f"{share:.2f}"
