"""What the papers say in words, put to the test over seeds: one claim, its numbers, and a verdict by a rule laid down beforehand.

``@claim("T09-e", "figure 6, (3) against (4)", base=contenders("pf-75", "pf-500"))`` registers a function ``runs -> [Part, ...]``.  Its
docstring is the claim in our words; the keyword arguments say which trackers are to be run on which scenario.  The function gets the
numbers of all these runs and returns its parts, each with the bound that the claim sets it.

**The rule.**  A part *holds* when its whole 95 % bootstrap interval lies beyond the bound, on the claimed side; it *holds in part* when only its
value does; else it *does not hold here*, and neither does one that equals the bound or could not be measured.  A claim holds when
all of its parts hold, does not when none of them does, even in part, and holds in part otherwise.  The bounds stand beside the parts
in the source, written before the runs, and no claim that fails is tuned away.

Seed k shows one of four objects before one of four backgrounds, so that 16 seeds are all pairs of them, each on a path of its own.
Trackers are compared on the same scenes, run by run.
"""

import importlib
import inspect
from dataclasses import dataclass
from typing import Callable

import numpy as np

from mkt.sweeps import CACHE, Job, interval, sweep
from mkt.trackers import catalogue

MODULES = ("teuliere2009", "nummiaro2003", "cordoba2014")
HOLDS, IN_PART, FAILS = "holds", "holds in part", "does not hold here"
OBJECTS = ("car", "astronaut", "motorcycle", "hopper")
BACKGROUNDS = ("workshop", "tissue", "bricks", "grass")
SEEDS, FEWEST = 16, 6  # with fewer runs no interval of a median can be trusted to 95 %
RULE = (f'A line "{HOLDS}" when its whole 95 % interval (bootstrap over the runs) lies beyond the bound, "{IN_PART}" when only its value does, and else '
        f'"{FAILS}". A claim holds when all of its lines do, does not when none does even in part, and holds in part otherwise.')
_REGISTRY = {}


@dataclass(frozen=True)
class Claim:
    """A registered claim: its identifier, where the paper shows it, the trackers it needs, {scenario: {name: tracker}}, and its function."""

    id: str
    printed: str
    needs: dict
    function: Callable

    @property
    def sentence(self):
        """The claim in our words: first sentence of the docstring."""
        return inspect.getdoc(self.function).split("\n\n")[0].replace("\n", " ")

    @property
    def remark(self):
        """How it is measured and what to bear in mind: the docstring after its first sentence, as one line."""
        return inspect.getdoc(self.function).partition("\n\n")[2].replace("\n", " ")

    def jobs(self, seeds):
        """What must be run for it, {(scenario, name): [one `Job` a seed]}."""
        return {(scenario, name): [Job(name, tracker, scenario, *setting(seed)) for seed in range(seeds)]
                for scenario, trackers in self.needs.items() for name, tracker in trackers.items()}


@dataclass(frozen=True)
class Part:
    """One number of a claim: what it is, its values (n,) over runs, and the bound that it must exceed, or stay below where `below` is set."""

    text: str
    values: np.ndarray
    bound: float
    below: bool = False
    unit: str = ""
    statistic: Callable = np.median


@dataclass(frozen=True)
class Runs:
    """What a claim's function may look at: the number of seeds, and by a call one number of every run of a tracker on a scenario."""

    seeds: int
    rows: dict

    def __call__(self, scenario, name, key):
        """The number `key` (of `mkt.sweeps.run`) of all runs, (n,)."""
        return np.array([row[key] for row in self.rows[scenario, name]])


@dataclass(frozen=True)
class Line:
    """A judged part: its text, the condition on it, its value with the interval, and the verdict."""

    text: str
    condition: str
    value: float
    low: float
    high: float
    unit: str
    verdict: str


@dataclass(frozen=True)
class Result:
    """A judged claim: the `Claim`, its `Line` objects, over how many seeds, and the verdict."""

    claim: Claim
    lines: tuple[Line, ...]
    seeds: int
    verdict: str


def claim(id, printed, **needs):
    """Decorator: register a claim (see the module's text).  printed: where the paper shows it, and its number if it prints one."""

    def register(function):
        if id in _REGISTRY:
            raise ValueError(f"claim {id}: registered twice")
        _REGISTRY[id] = Claim(id, printed, needs, function)
        return function

    return register


def contenders(*names, **others):
    """Trackers for a claim, {name: tracker}: those of the catalogue by name, and others."""
    return {name: catalogue.get(name) for name in names} | others


def registry():
    """All claims in the order of the papers, dict of id -> `Claim`."""
    for module in MODULES:
        importlib.import_module(f"{__name__}.{module}")
    return dict(_REGISTRY)


def get(id):
    """The `Claim` of an id.  Raises KeyError that lists the known ones."""
    known = registry()
    if id not in known:
        raise KeyError(f"no claim {id!r}; there are {', '.join(known)}")
    return known[id]


def setting(seed):
    """Seed, object and background of a run."""
    return seed, OBJECTS[seed % 4], BACKGROUNDS[seed // 4 % 4]


def judge(ids=(), seeds=SEEDS, processes=-1, cache=CACHE):
    """Put claims to the test, all of them by default, over so many seeds; runs that are in the cache are not done again.

    Returns a list of `Result`.  Raises KeyError for an unknown id, ValueError for fewer than six seeds.
    """
    if seeds < FEWEST:
        raise ValueError(f"{seeds} seeds are too few for an interval of 95 %; take at least {FEWEST}")
    claims = [get(id) for id in ids or registry()]
    jobs = list({repr(job): job for claim in claims for cell in claim.jobs(seeds).values() for job in cell}.values())
    rows = dict(zip(map(repr, jobs), sweep(jobs, processes, cache)))
    return [_judged(claim, {cell: [rows[repr(job)] for job in jobs] for cell, jobs in claim.jobs(seeds).items()}, seeds) for claim in claims]


def _judged(claim, rows, seeds):
    lines = tuple(line(part) for part in claim.function(Runs(seeds, rows)))
    return Result(claim, lines, seeds, overall([line.verdict for line in lines]))


def line(part):
    """A `Part` with its interval and its verdict."""
    numbers = interval(part.values, statistic=part.statistic)
    condition = f"{'<' if part.below else '>'} {part.bound:g}"
    return Line(part.text, condition, *numbers, part.unit, verdict(*numbers, part.bound, part.below))


def verdict(value, low, high, bound, below=False):
    """The rule for one number with its interval (see the module's text).  Returns one of the three verdicts."""
    if (high < bound) if below else (low > bound):
        return HOLDS
    return IN_PART if (value < bound if below else value > bound) else FAILS


def overall(verdicts):
    """The rule for a claim of several parts."""
    return verdicts[0] if len(set(verdicts)) == 1 else IN_PART
