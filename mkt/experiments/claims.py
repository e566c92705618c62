"""What the papers say in words, put to the test over scenes.

Each claim has its numbers, and a verdict by a rule laid down beforehand.

``@claim("T09-e", "figure 6, (3) against (4)", base=contenders("pf-75", "pf-500"))``
registers a function ``runs -> [Part, ...]``.  Its docstring is the claim in our words;
the keyword arguments say which trackers are to be run on which kind of scene.  The
function gets the numbers of all these runs and returns its parts, each with the bound
that the claim sets it.

**The rule.**  A part is *supported* when the test of `mkt.experiments.statistics` for
its kind of number says so at 2.5 % on one side, and *contradicted* when the test of the
other side does after Holm's correction over the parts of the claim.  What is neither
is a *tie* when the whole 95 % interval lies within a margin of equality that the part
names, and else *inconclusive*.  A claim stands only if all of its parts do: it has the
verdict of the worst of them, contradicted before inconclusive before tie.  So a single
part makes it contradicted, and the more parts, the more often by chance; that is what
the correction is for.  To be supported all of them are needed, which chance does not
make easier.  Parts that
the paper did not write (`ours`), and those that are true whatever happens, are shown
but do not count.  The bounds stand beside the parts in the source, most of them written
before the runs, and no claim that fails is tuned away.  A part that was brought nearer
to the paper's words later mostly says so, and the former one stays beside it, as ours,
where it tells something still.  Six claims, and parts of others, were put when part of
their runs was known, and say so.

The scenes are those of `mkt.scenes.drawn` for the seeds `SEEDS`, on which no parameter
was chosen.  Trackers are compared on the same scenes, run by run.
`mkt.experiments.shipped` keeps what was measured for a release.
"""

import inspect
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd
from tqdm import tqdm

from mkt.checks import check_seed, of_kind
from mkt.experiments import cache
from mkt.experiments.processes import spread
from mkt.experiments.statistics import MEDIAN, Statistic, holm, interval, p_value
from mkt.experiments.sweep import Job, sweep
from mkt.experiments.timing import one_thread
from mkt.registry import Registry, by_group
from mkt.scenes.drawn import HELD_BACK, drawn
from mkt.trackers import by_name
from mkt.tracking import Tracker
from mkt.types import Array

SUPPORTED, TIE = "supported", "tie"
INCONCLUSIVE, CONTRADICTED = "inconclusive", "contradicted"
WORST_FIRST = (CONTRADICTED, INCONCLUSIVE, TIE, SUPPORTED)
UNTESTED = "cannot fail here"  # of a claim all of whose parts have no say
SEEDS = HELD_BACK
FEWEST = 6  # with fewer runs no interval of a median reaches 95 %
LEVEL = 0.025  # of a test on one side
RULE = f"""\
A line is "{SUPPORTED}" when an exact or a t test says so at 2.5 %, and "{CONTRADICTED}"
when the test of the other side does after Holm's correction over the lines of the
claim. Else it is a "{TIE}" when its whole 95 % interval lies within a margin of
equality, and "{INCONCLUSIVE}" when not. A claim has the verdict of the worst of its
lines. Lines that are ours, or that cannot fail, stand apart and have no say."""
PAPERS = ("T09", "N03", "C14")  # in the order of the book

Cell = tuple[str, str]  # a kind of scene, and the label of a tracker

CLAIMS = Registry("claim", "mkt.papers", order=by_group(PAPERS, "-"))


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
        """The claim in our words: first paragraph of the docstring."""
        return _paragraphs(self.function)[0].replace("\n", " ")

    @property
    def remark(self) -> str:
        """How it is measured: the docstring after its first paragraph, as one line."""
        return " ".join(_paragraphs(self.function)[1:]).replace("\n", " ")

    def jobs(self, seeds: Iterable[int]) -> dict[Cell, list[Job]]:
        """The jobs that it needs: one for each seed of each cell."""
        every = list(seeds)
        return {
            (kind, label): [
                Job(label, tracker, drawn(kind, seed), seed) for seed in every
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
        The bound that the number must exceed, or stay below.
    below : bool
    unit : str
    statistic : Statistic
        What is made of the values.
    margin : float
        How far from the bound the number may lie to be equal to it for all purposes.
    ours : bool
        Whether it is not in the paper, or cannot fail.
    """

    text: str
    values: Array
    bound: float
    below: bool = False
    unit: str = ""
    statistic: Statistic = MEDIAN
    margin: float = 0.0
    ours: bool = False


@dataclass(frozen=True)
class Runs:
    """What a claim's function may look at.

    Parameters
    ----------
    seeds : sequence of int
    rows : dict of DataFrame
        The runs of each cell.
    """

    seeds: Sequence[int]
    rows: dict[Cell, pd.DataFrame]

    def __call__(self, kind: str, label: str, number: str) -> Array:
        """A number of `mkt.experiments.sweep.run` of all runs of a cell, (n,)."""
        return self.rows[kind, label][number].to_numpy(float)


@dataclass(frozen=True)
class Measured:
    """The parts of a claim over some seeds, not yet judged."""

    claim: Claim
    seeds: Sequence[int]
    parts: tuple[Part, ...]


@dataclass(frozen=True)
class Line:
    """A judged part: its value with interval, and the verdict."""

    part: Part
    value: float
    low: float
    high: float
    verdict: str

    @property
    def condition(self) -> str:
        """What is claimed of the value, such as "< 0.2"."""
        return f"{'<' if self.part.below else '>'} {self.part.bound:g}"


@dataclass(frozen=True)
class Result:
    """A judged claim: its lines, over which seeds, and the verdict."""

    claim: Claim
    lines: tuple[Line, ...]
    seeds: Sequence[int]
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
    return {name: by_name.TRACKERS[name] for name in names} | others


def over_seeds(function: Callable[[int], Any], seeds: Sequence[int]) -> list[Any]:
    """What a function returns for each seed, on all cores with one thread each.

    Parameters
    ----------
    function : callable
    seeds : sequence of int
    """
    done = spread(_alone, ((function, seed) for seed in seeds))
    return list(tqdm(done, "seeds", len(seeds), unit="seed", disable=None))


def _alone(function: Callable[[int], Any], seed: int) -> Any:
    with one_thread():
        return function(seed)


def measure(
    names: Iterable[str] = (), seeds: Collection[int] = SEEDS, processes: int = -1
) -> list[Measured]:
    """Run what claims need, all of them by default, and take their numbers.

    Runs that are known are not done again.  A single name may stand alone.  Six seeds
    are enough for a part to be supported; a share of runs that is to exceed .8 needs
    more.

    Raises
    ------
    ValueError
        For an unknown name, for fewer than six seeds, for one that comes twice, and
        for what is no seed.
    """
    of_kind(seeds, Collection, "seeds", f"give at least {FEWEST}, such as range(32)")
    for seed in seeds:
        check_seed(seed)
    if not isinstance(seeds, Sequence):  # such as an array
        seeds = list(map(int, seeds))
    if len(set(seeds)) < len(seeds):
        raise ValueError("some seeds are the same; the same scene counts once")
    if len(seeds) < FEWEST:
        raise ValueError(
            f"{len(seeds)} seeds are too few for an interval of 95 %; "
            f"take at least {FEWEST}"
        )
    names = [names] if isinstance(names, str) else list(names)
    claims = [CLAIMS[name] for name in names or CLAIMS]
    needed = [
        job for one in claims for cell in one.jobs(seeds).values() for job in cell
    ]
    jobs = {_name(job): job for job in needed}
    rows = sweep(jobs.values(), processes).set_axis(list(jobs))
    return [_measured(one, rows, seeds) for one in claims]


def _name(job: Job) -> str:
    return cache.key(job) or repr(job)


def _measured(claim: Claim, rows: pd.DataFrame, seeds: Sequence[int]) -> Measured:
    cells = {
        cell: rows.loc[list(map(_name, jobs))]
        for cell, jobs in claim.jobs(seeds).items()
    }
    return Measured(claim, seeds, tuple(claim.function(Runs(seeds, cells))))


def judge(measured: Measured) -> Result:
    """Put a claim to the test (see the module's text)."""
    said = [part for part in measured.parts if not part.ours]
    own = [[part] for part in measured.parts if part.ours]
    verdicts = {id(part): v for group in [said, *own] for part, v in _verdicts(group)}
    lines = tuple(
        Line(p, *interval(p.values, p.statistic), verdicts[id(p)])
        for p in measured.parts
    )
    overall = worst([verdicts[id(part)] for part in said])
    return Result(measured.claim, lines, measured.seeds, overall)


def _verdicts(parts: Sequence[Part]) -> list[tuple[Part, str]]:
    """Each of the parts that are tested together, with its verdict."""
    claimed = [_p_value(part, "less" if part.below else "greater") for part in parts]
    other = [_p_value(part, "greater" if part.below else "less") for part in parts]
    return [
        (part, _verdict(part, *p))
        for part, *p in zip(parts, claimed, holm(other), strict=True)
    ]


def _p_value(part: Part, side: str) -> float:
    return p_value(part.values, part.statistic, part.bound, side)


def _verdict(part: Part, claimed: float, other: float) -> str:
    """The rule for one part, from the p-values of both sides."""
    if claimed < LEVEL:
        return SUPPORTED
    if other < LEVEL:
        return CONTRADICTED
    _, low, high = interval(part.values, part.statistic)
    equal = max(abs(low - part.bound), abs(high - part.bound)) <= part.margin
    return TIE if equal else INCONCLUSIVE


def worst(verdicts: Iterable[str]) -> str:
    """The verdict of a claim, from those of its parts."""
    found = set(verdicts)
    return next((one for one in WORST_FIRST if one in found), UNTESTED)


def as_records(results: Iterable[Result]) -> list[dict[str, Any]]:
    """One dict for each line of some results: a tidy table of verdicts."""
    return [
        {
            "claim": result.claim.name,
            "sentence": result.claim.sentence,
            "paper": result.claim.printed,
            "claim verdict": result.verdict,
            "measured": line.part.text,
            "in the paper": not line.part.ours,
            "condition": line.condition,
            "value": line.value,
            "low": line.low,
            "high": line.high,
            "unit": line.part.unit,
            "verdict": line.verdict,
            "scenes": len(result.seeds),
        }
        for result in results
        for line in result.lines
    ]
