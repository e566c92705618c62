"""All trackers on all sequences: who follows best, how sure is that, and what does it cost?

The protocol: a tracker is told the true region in the first frame and nothing after it; every tracker has one setting for all sequences;
what counts are the frames in which the target is seen.  The same seeds for all; a tracker that draws no random numbers runs once on a
recorded sequence, for it would only repeat itself.  A tracker that refuses a target scores nothing on it.

`recorded` runs over the benchmarks that are found (`mkt.archives`), `synthetic` over the twins (`mkt.twins`); both give a `Board`.
``python3 -m mkt bench tracking`` prints the first, or the second where there are no benchmarks, and the book shows the second.

Explained in notebook 14.
"""

from dataclasses import dataclass, replace

import numpy as np

from mkt import archives
from mkt.claims import setting
from mkt.scenarios import base
from mkt.scenes import sequence
from mkt.sweeps import CACHE, Job, Recorded, interval, known, sweep
from mkt.trackers import catalogue
from mkt.twins import TWINS

SEEDS = 5
SYNTHETIC = tuple(TWINS)
REFUSED = {"overlap": 0.0, "hits": 0.0, "hits_of_all": 0.0, "area": 0.0, "lost": 1.0}  # what a tracker scores that would not start
HEAD = ("tracker", "overlap", "over seeds", "95 % over sequences", "true positives [%]", "of all frames [%]", "area", "lost [%]", "CPU ms")
LEGEND = """*overlap*: mean over the seen frames, the seeds, and the sequences.  *over seeds*: the smallest and the largest of these means for one seed,
where several ran.  *95 % over sequences*: bootstrap, as if these sequences were a few out of many like them.  *true positives*: seen frames with an
overlap above .2; *of all frames*: the same out of all frames, hidden ones too, as [C14] counts.  *area*: under the success curve, as in OTB.
*lost*: runs without a hit in their last ten frames.  *CPU ms*: a frame, median over the runs."""


@dataclass(frozen=True)
class Board:
    """Results on one kind of data: a title, a sentence on what the data are, and the rows of the runs."""

    title: str
    data: str
    rows: list[dict]


@dataclass(frozen=True)
class Place:
    """A tracker's place: its name, its overlap (mean; smallest and largest over seeds; interval over sequences), and means of the other numbers.

    cells: {sequence: (overlap, true positives)}.
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
    cells: dict


def recorded(names=(), seeds=SEEDS, processes=-1, cache=CACHE, only_known=False):
    """Trackers, all by default, on every benchmark sequence that is found and can be used.

    only_known: run nothing.  Returns a list of one `Board`, or an empty one where there are no sequences, or not all runs are known; and what is
    wrong with the sequences that were left out, a list of sentences.  Raises KeyError for an unknown tracker, ValueError without a seed.
    """
    trackers = _trackers(names, seeds)
    found, troubles = archives.usable()
    marks = {f: f.fingerprint() for f in found}
    repeats = {name: seeds if draws(tracker) else 1 for name, tracker in trackers.items()} if found else {}
    jobs = [Recorded(name, trackers[name], f, f.name, mark, seed) for f, mark in marks.items() for name, n in repeats.items() for seed in range(n)]
    rows = known(jobs, cache) if only_known else sweep(jobs, processes, cache)
    if not rows or None in rows:
        return [], troubles
    titles = ", ".join(dict.fromkeys(f.archive.name for f in found))
    there = "; ".join(f"{f.name}, {words}" for f, words in found.items())
    data = f"Real sequences: {there}. None of them was used to choose a parameter of our tracker."
    return [Board(titles, data, rows)], troubles


def synthetic(names=(), seeds=SEEDS, processes=-1, cache=CACHE):
    """Trackers, all by default, on the synthetic twins, another object, ground and path for each seed.  Returns a `Board`; raises as `recorded` does."""
    return _synthetic([(_trackers(names, seeds), seeds)], processes, cache)


def for_the_book(processes=-1, cache=CACHE):
    """The boards of the book: two seeds of the twins, one of the slow trackers; and the benchmarks, if all their runs are known."""
    quick = [name for name in catalogue.TRACKERS if name not in catalogue.SLOW]
    own = _synthetic([(_trackers(quick, 2), 2), (_trackers(catalogue.SLOW, 1), 1)], processes, cache)
    return [own, *recorded(cache=cache, only_known=True)[0]]


def _synthetic(parts, processes, cache):
    jobs = [Job(name, tracker, scenario, *setting(seed)) for trackers, seeds in parts for scenario in SYNTHETIC for name, tracker in trackers.items()
            for seed in range(seeds)]
    kinds = ", ".join(SYNTHETIC)
    data = f"Synthetic twins of six kinds of sequence, whose truth is exact: {kinds}. Each seed has an object, a ground and a path of its own."
    return Board("Synthetic", data, sweep(jobs, processes, cache))


def _trackers(names, seeds):
    if seeds < 1:
        raise ValueError(f"{seeds} seeds; there must be at least 1")
    return {name: catalogue.get(name) for name in names or catalogue.TRACKERS}


def draws(tracker):
    """Whether a tracker uses its random numbers, found out by running it over three frames."""
    clip, rng = sequence(replace(base(0), length=3)), np.random.default_rng(0)
    before, frames = rng.bit_generator.state, iter(clip.frames)
    state = tracker.init(next(frames), clip.truth[0], rng)
    for frame in frames:
        state, _ = tracker.step(state, frame, rng)
    return rng.bit_generator.state != before


def ranking(rows):
    """The trackers in order of their mean overlap, a list of `Place`.  rows: of a `Board`."""
    runs = {}
    for row in rows:
        runs.setdefault(row["name"], {}).setdefault(row["scenario"], []).append(row | (REFUSED if row["refused"] else {}))
    return sorted((_place(name, cells) for name, cells in runs.items()), key=lambda place: -place.overlap)


def _place(name, cells):
    def mean(key):
        return float(np.mean([np.mean([row[key] for row in cell]) for cell in cells.values()]))

    by_sequence = [np.mean([row["overlap"] for row in cell]) for cell in cells.values()]
    by_seed = [np.mean(overlaps) for overlaps in zip(*[[row["overlap"] for row in cell] for cell in cells.values()])]
    _, low, high = interval(by_sequence, statistic=np.mean)
    times = [row["cpu_ms"] for cell in cells.values() for row in cell if not row["refused"]]
    return Place(name, mean("overlap"), (min(by_seed), max(by_seed)) if len(by_seed) > 1 else None, (low, high), mean("hits"), mean("hits_of_all"),
                 mean("area"), mean("lost"), float(np.median(times)) if times else np.nan,
                 {scenario: tuple(np.mean([[row["overlap"], row["hits"]] for row in cell], 0)) for scenario, cell in cells.items()})


def overall(places):
    """The first table: a row of texts under `HEAD` for each `Place`."""
    return [[catalogue.LABELS[p.name], _two(p.overlap), _range(p.seeds) if p.seeds else "", _range(p.interval), f"{100 * p.hits:.1f}",
             f"{100 * p.hits_of_all:.1f}", _two(p.area), f"{100 * p.lost:.0f}", f"{p.cpu_ms:.2g}" if np.isfinite(p.cpu_ms) else ""] for p in places]


def by_sequence(places):
    """The second table: its head, and a row of texts "overlap / true positives [%]" for each `Place`."""
    names = list(dict.fromkeys(name for place in places for name in place.cells))
    rows = [[catalogue.LABELS[p.name], *(_cell(*p.cells[name]) if name in p.cells else "" for name in names)] for p in places]
    return ["tracker", *names], rows


def refusals(rows):
    """Which trackers would not start where, and why, a list of sentences."""
    refused = [(catalogue.LABELS[row["name"]], row["scenario"], row["refused"]) for row in rows if row["refused"]]
    return [f"{name} would not start on {scenario}: {why}" for name, scenario, why in dict.fromkeys(refused)]


def extent(board):
    """How many sequences and runs a board has, in words."""
    n = len({row["scenario"] for row in board.rows})
    return f"{n} sequence{'s' * (n > 1)}, {len(board.rows)} runs"


def as_markdown(board):
    """A board with both tables, and what the columns mean."""
    places = ranking(board.rows)
    parts = [f"## {board.title}: {extent(board)}", board.data, _table(HEAD, overall(places)), LEGEND,
             "Overlap / true positives [%] on each sequence:", _table(*by_sequence(places)), *refusals(board.rows)]
    return "\n\n".join(parts)


def _table(head, rows):
    widths = [max(map(len, column)) for column in zip(head, *rows)]
    lines = [[text.ljust(width) for text, width in zip(row, widths)] for row in (head, ["-" * width for width in widths], *rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cell(overlap, hits):
    return f"{_two(overlap)} / {100 * hits:.0f}"


def _range(ends):
    return f"{_two(ends[0])} to {_two(ends[1])}"


def _two(share):
    return f"{share:.2f}"
