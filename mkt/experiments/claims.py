"""What the papers say in words, put to the test over seeds.

Each claim has its numbers, and a verdict by a rule laid down beforehand.

``@claim("T09-e", "figure 6, (3) against (4)", base=contenders("pf-75", "pf-500"))``
registers a function ``runs -> [Part, ...]``.  Its docstring is the claim in our words;
the keyword arguments say which trackers are to be run on which kind of scene.  The
function gets the numbers of all these runs and returns its parts, each with the bound
that the claim sets it.

**The rule.**  A part *holds* when its whole 95 % bootstrap interval lies beyond the
bound, on the claimed side; it *holds in part* when only its value does; else it *does
not hold here*, and neither does one that equals the bound or could not be measured.  A
claim holds when all of its parts hold, does not when none of them does, even in part,
and holds in part otherwise.  The bounds stand beside the parts in the source, written
before the runs, and no claim that fails is tuned away.

The scenes of the seeds are those of `mkt.scenes.drawn`.  Trackers are compared on the
same scenes, run by run.
"""

import inspect
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from mkt.experiments.statistics import interval
from mkt.experiments.sweep import Job, sweep
from mkt.registry import Registry, natural
from mkt.scenes.drawn import drawn
from mkt.trackers import by_name
from mkt.tracking import Tracker
from mkt.types import Array

HOLDS, IN_PART, FAILS = "holds", "holds in part", "does not hold here"
SEEDS = 16
FEWEST = 6  # with fewer runs no interval of a median can be trusted to 95 %
RULE = (
    f'A line "{HOLDS}" when its whole 95 % interval (bootstrap over the runs) lies '
    f'beyond the bound, "{IN_PART}" when only its value does, and else "{FAILS}". '
    "A claim holds when all of its lines do, does not when none does even in part, "
    "and holds in part otherwise."
)
PAPERS = ("T09", "N03", "C14")  # in the order of the book

Cell = tuple[str, str]  # a kind of scene, and the label of a tracker


def _order(name: str) -> tuple:
    paper = name.partition("-")[0]
    return PAPERS.index(paper) if paper in PAPERS else len(PAPERS), natural(name)


CLAIMS = Registry("claim", "mkt.papers", order=_order)


@dataclass(frozen=True)
class Claim:
    """A registered claim.

    Parameters
    ----------
    name : str
        Such as T09-e.
    printed : str
        Where the paper shows it.
    needs : dict
        The trackers to run, {kind of scene: {label: tracker}}.
    function : callable
    """

    name: str
    printed: str
    needs: dict[str, dict[str, Tracker]]
    function: Callable

    @property
    def sentence(self) -> str:
        """The claim in our words: first sentence of the docstring."""
        return _paragraphs(self.function)[0].replace("\n", " ")

    @property
    def remark(self) -> str:
        """How it is measured: the docstring after its first sentence, as one line."""
        return " ".join(_paragraphs(self.function)[1:]).replace("\n", " ")

    def jobs(self, seeds: int) -> dict[Cell, list[Job]]:
        """What must be run for it, for each cell one job a seed."""
        return {
            (kind, label): [
                Job(label, tracker, drawn(kind, seed), seed) for seed in range(seeds)
            ]
            for kind, trackers in self.needs.items()
            for label, tracker in trackers.items()
        }


def _paragraphs(function: Callable) -> list[str]:
    return (inspect.getdoc(function) or "").split("\n\n")


@dataclass(frozen=True)
class Part:
    """One number of a claim.

    Parameters
    ----------
    text : str
        What it is.
    values : (n,) array
        Over runs.
    bound : float
        Which it must exceed, or stay below.
    below : bool
    unit : str
    statistic : callable
        Of the values, such as `numpy.median`.
    """

    text: str
    values: Array
    bound: float
    below: bool = False
    unit: str = ""
    statistic: Callable = np.median


@dataclass(frozen=True)
class Runs:
    """What a claim's function may look at.

    Parameters
    ----------
    seeds : int
    rows : dict of DataFrame
        The runs of each cell.
    """

    seeds: int
    rows: dict[Cell, pd.DataFrame]

    def __call__(self, kind: str, label: str, number: str) -> Array:
        """A number of `mkt.experiments.sweep.run` of all runs of a cell, (n,)."""
        return self.rows[kind, label][number].to_numpy(float)


@dataclass(frozen=True)
class Line:
    """A judged part: its text, the condition, its value with interval, the verdict."""

    text: str
    condition: str
    value: float
    low: float
    high: float
    unit: str
    verdict: str


@dataclass(frozen=True)
class Result:
    """A judged claim: its lines, over how many seeds, and the verdict."""

    claim: Claim
    lines: tuple[Line, ...]
    seeds: int
    verdict: str


def claim(name: str, printed: str, **needs: dict[str, Tracker]) -> Callable:
    """Decorator: register a claim (see the module's text).

    Parameters
    ----------
    name : str
    printed : str
        Where the paper shows it, and its number if it prints one.
    **needs
        Kind of scene -> the trackers to run on it, see `contenders`.
    """

    def register(function):
        CLAIMS.add(name, Claim(name, printed, needs, function))
        return function

    return register


def contenders(*names: str, **others: Tracker) -> dict[str, Tracker]:
    """Trackers for a claim, by their names, and others under labels of their own."""
    return {name: by_name.get(name) for name in names} | others


def judge(
    names: Iterable[str] = (), seeds: int = SEEDS, processes: int = -1
) -> list[Result]:
    """Put claims to the test, all of them by default.

    Runs that are known are not done again.

    Raises
    ------
    ValueError
        For an unknown name, and for fewer than six seeds.
    """
    if seeds < FEWEST:
        raise ValueError(
            f"{seeds} seeds are too few for an interval of 95 %; take at least {FEWEST}"
        )
    claims = [CLAIMS[name] for name in list(names) or CLAIMS]
    needed = [
        job for one in claims for cell in one.jobs(seeds).values() for job in cell
    ]
    jobs = list({repr(job): job for job in needed}.values())
    rows = sweep(jobs, processes)
    rows.index = pd.Index([repr(job) for job in jobs])
    return [_judged(one, rows, seeds) for one in claims]


def _judged(claim: Claim, rows: pd.DataFrame, seeds: int) -> Result:
    cells = {
        cell: rows.loc[[repr(job) for job in jobs]]
        for cell, jobs in claim.jobs(seeds).items()
    }
    lines = tuple(line(part) for part in claim.function(Runs(seeds, cells)))
    return Result(claim, lines, seeds, overall([line.verdict for line in lines]))


def line(part: Part) -> Line:
    """A part with its interval and its verdict."""
    value, low, high = interval(part.values, statistic=part.statistic)
    condition = f"{'<' if part.below else '>'} {part.bound:g}"
    result = verdict(value, low, high, part.bound, part.below)
    return Line(part.text, condition, value, low, high, part.unit, result)


def verdict(
    value: float, low: float, high: float, bound: float, below: bool = False
) -> str:
    """The rule for one number with its interval (see the module's text)."""
    if (high < bound) if below else (low > bound):
        return HOLDS
    return IN_PART if (value < bound if below else value > bound) else FAILS


def overall(verdicts: list[str]) -> str:
    """The rule for a claim of several parts."""
    return verdicts[0] if len(set(verdicts)) == 1 else IN_PART


def as_records(results: Iterable[Result]) -> list[dict[str, Any]]:
    """One dict for each line of some results: a tidy table of verdicts."""
    return [
        {
            "claim": result.claim.name,
            "sentence": result.claim.sentence,
            "paper": result.claim.printed,
            "claim verdict": result.verdict,
            "measured": line.text,
            "condition": line.condition,
            "value": line.value,
            "low": line.low,
            "high": line.high,
            "unit": line.unit,
            "verdict": line.verdict,
            "seeds": result.seeds,
        }
        for result in results
        for line in result.lines
    ]
