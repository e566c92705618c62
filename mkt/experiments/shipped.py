"""What was measured once for a release, as tidy tables in ``data/``.

``claims.csv`` has a row for each line of a claim and each seed, ``claims_again.csv``
the same on scenes that nobody had seen when the claims were put, ``tracking.csv`` and
``bobot.csv`` a row for each run of a tracker (`mkt.experiments.sweep.run`), and so have
``ablation.csv`` and ``wishes.csv``, with fewer columns.  Beside each lies a JSON file:
the command that makes the table again, the day, the seeds, the versions of all packages
that numbers depend on, and a hash of the code.  Book and figures read these tables, so
that no build of the book runs trackers for hours; where the code has changed since,
`changed` says so, and tests run a sample of the rows again.
"""

import datetime
import hashlib
import inspect
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mkt.experiments import dependencies
from mkt.experiments.claims import CLAIMS, Measured, Part, judge
from mkt.experiments.claims_as_text import row_of
from mkt.experiments.statistics import STATISTICS
from mkt.experiments.sweep import NUMBERS
from mkt.files import DATA, PACKAGE, DataError, whole
from mkt.trackers import by_name
from mkt.tracking import Tracker

CLAIMED, AGAIN, TRACKED, BOBOT, ABLATED, WISHED = (
    DATA / f"{name}.csv"
    for name in ("claims", "claims_again", "tracking", "bobot", "ablation", "wishes")
)
PAPERS, FIGURES = PACKAGE / "papers", PACKAGE / "figures"
RANKED = ("tracking", "bobot")  # tables whose parts are trackers
# Where the code begins that the numbers of all tables depend on, and of these four.
RUNS = (PACKAGE / "experiments" / "sweep.py", *sorted(PACKAGE.glob("scenes/*.py")))
OF_CLAIMS = ("claims", "claims_again")
STARTS = {
    **dict.fromkeys(OF_CLAIMS, sorted(PACKAGE.glob("papers/*/claims.py"))),
    "ablation": [  # which takes its trackers by name
        PAPERS / "cordoba2014" / "ablation.py",
        PACKAGE / "trackers" / "hybrid_resampling.py",
        PACKAGE / "trackers" / "particle_filter.py",
    ],
    "wishes": [PAPERS / "lessons" / "wishes.py"],
}
BY_NAME = PACKAGE / "trackers" / "by_name.py"  # imports all trackers, and runs none
COMMANDS = {
    CLAIMED: "python3 -m mkt claims --release",
    AGAIN: "python3 -m mkt claims --again --release",
    TRACKED: "python3 -m mkt bench tracking --release",
    BOBOT: "python3 -m mkt bench tracking --release",
    ABLATED: ".venv/bin/python -m mkt.papers.cordoba2014.ablation",
    WISHED: ".venv/bin/python -m mkt.papers.lessons.wishes",
}
DIGITS = "%.7g"
WORDS = ("item", "ground", "refused")  # of a run; where empty, a table has no text
NO_WORDS = dict.fromkeys(WORDS, "")


@dataclass(frozen=True)
class Made:
    """How a table was made.

    Parameters
    ----------
    command : str
        The command that makes it again.
    date : str
        The day of the newest numbers, as 2026-11-22.
    seeds : str
        The first, and the one after the last, as 1000:1032.
    versions : list of str
        Of Python and the packages that numbers depend on.
    code : dict
        Part of the table -> a hash of its code, see `codes_of`.
    content : str
        A hash of the table itself, so that one that was cut is not taken for whole.
    """

    command: str
    date: str
    seeds: str
    versions: list[str]
    code: dict[str, str]
    content: str


def codes_of(table: Path) -> dict[str, str]:
    """The hashes of the code that the parts of a table depend on, as it is now.

    A ranking has a part for each tracker, under its name; every other table is one
    part, under its own.  Of these it is what is measured, however figures are drawn.
    """
    if table.stem in RANKED:
        return {name: _code_of_tracker(it) for name, it in by_name.TRACKERS.items()}
    files = reachable([*STARTS.get(table.stem, ()), *RUNS, *_claimants(table)])
    measuring = (path for path in sorted(files) if FIGURES not in path.parents)
    return {table.stem: _short("\n".join(map(dependencies.stripped, measuring)))}


def _code_of_tracker(tracker: Tracker) -> str:
    """Of its code, its settings, and the scenes."""
    return _short(repr(tracker) + dependencies.state([_home(tracker), *RUNS]))


def _claimants(table: Path) -> list[Path]:
    """The files of the trackers that the claims run; none of another table."""
    if table.stem not in OF_CLAIMS:
        return []
    needs = (cells for claim in CLAIMS.values() for cells in claim.needs.values())
    return sorted({_home(tracker) for cells in needs for tracker in cells.values()})


def _home(tracker: Tracker) -> Path:
    """The file of a tracker's class."""
    return Path(inspect.getfile(type(tracker)))


def _short(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def reachable(files: Iterable[Path]) -> set[Path]:
    """The files of the library that some files can reach by imports, themselves too.

    Unlike `mkt.experiments.dependencies.reachable` it leaves out what the registries of
    figures and claims find in the papers: if a figure is named, its file is among the
    first ones.  Only a first file that makes such a registry reaches all of them.
    """
    first = list(files)
    return set(dependencies.reachable(first, lambda path: _next(path, path in first)))


def _next(path: Path, first: bool) -> list[Path]:
    """The files that a file imports; for a first one also what its registries find.

    Who takes a tracker by its name depends on none of the others.
    """
    if path == BY_NAME:
        return []
    imported = dependencies.imported(path)
    if first or PAPERS in path.parents:
        return imported
    # Nothing below the papers imports from them: it is a registry that looks there.
    return [other for other in imported if PAPERS not in other.parents]


def changed(table: Path, made: Made) -> list[str]:
    """The parts of a table whose code has changed since it was made."""
    now = codes_of(table)
    return [part for part, code in now.items() if made.code.get(part) != code]


def write_claims(measured: Iterable[Measured], table: Path = CLAIMED) -> None:
    """Keep what was measured for a release, and of other claims what is there.

    Raises
    ------
    ValueError
        For no claim at all, for other seeds than those of the claims that are kept, for
        seeds that do not follow one another, and as `check_kept` does.
    OSError
        Where it cannot be written.
    """
    fresh = {one.claim.name: one for one in measured}
    if not fresh:
        raise ValueError(
            "measured is empty; give what was measured of one claim or more"
        )
    check_kept(fresh, table)
    seeds = next(iter(fresh.values())).seeds
    known = {one.claim.name: one for one in _kept(fresh, table)} | fresh
    if others := {tuple(one.seeds) for one in known.values()} - {tuple(seeds)}:
        raise ValueError(
            f"other claims have the seeds {list(others)[0]}; measure all of them"
        )
    measured = [known[name] for name in CLAIMS if name in known]
    lines = [
        {"claim": one.claim.name, "line": k} | _described(part)
        for one in measured
        for k, part in enumerate(one.parts)
    ]
    rows = [
        {"claim": one.claim.name, "line": k, "seed": seed, "value": value}
        for one in measured
        for k, part in enumerate(one.parts)
        for seed, value in zip(one.seeds, np.asarray(part.values, float), strict=True)
    ]
    _write(table, pd.DataFrame(rows), measured[0].seeds, {"lines": lines})


def check_kept(fresh: Iterable[str], table: Path = CLAIMED) -> None:
    """Refuse to measure some claims where the numbers of the others are of older code.

    The table has one hash for all of them: theirs would pass for new ones.

    Raises
    ------
    ValueError
        Where the code has changed since.
    DataError
        Where the table cannot be read.
    """
    others = _kept(fresh, table)
    if others and changed(table, read_claims(table)[1]):
        command = COMMANDS.get(table, COMMANDS[CLAIMED])
        raise ValueError(
            f"the code has changed since {others[0].claim.name} of {table.name} was "
            f"measured; measure all claims, with {command}"
        )


def _kept(fresh: Iterable[str], table: Path) -> list[Measured]:
    """The claims of a table that are not measured anew."""
    names = {*fresh}
    if names >= {*CLAIMS} or not table.exists():
        return []
    return [one for one in read_claims(table)[0] if one.claim.name not in names]


def _described(part: Part) -> dict[str, Any]:
    """A part without its values."""
    return {
        "text": part.text,
        "bound": part.bound,
        "below": part.below,
        "unit": part.unit,
        "statistic": part.statistic.name,
        "margin": part.margin,
        "ours": part.ours,
    }


def read_claims(table: Path = CLAIMED) -> tuple[list[Measured], Made]:
    """The measured claims of a release, and how they were made.

    Raises
    ------
    DataError
        Where the table cannot be read.
    """
    rows, made, more = _read(table, "claim", "line", "seed", "value")
    try:
        parts = _parts(rows, more["lines"])
        seeds = seeds_of(made)
        measured = [Measured(CLAIMS[n], seeds, tuple(p)) for n, p in parts.items()]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise _unreadable(table, error) from None
    return measured, made


def _parts(
    rows: pd.DataFrame, lines: Iterable[Mapping[str, Any]]
) -> dict[str, list[Part]]:
    """The parts of each claim, from the values and from how each line is described."""
    parts: dict[str, list[Part]] = {}
    cells = rows.groupby(["claim", "line"])["value"]
    for line in lines:
        words = dict(line)
        name, k = words.pop("claim"), words.pop("line")
        words["statistic"] = STATISTICS[words["statistic"]]
        part = Part(values=cells.get_group((name, k)).to_numpy(), **words)
        parts.setdefault(name, []).append(part)
    return parts


def claimed(names: Iterable[str] = (), table: Path = CLAIMED) -> list[Measured]:
    """What was measured for some claims of the release, for all by default.

    Parameters
    ----------
    names : iterable of str
    table : Path
        ``CLAIMED``, or ``AGAIN`` for the same on other scenes.

    Raises
    ------
    ValueError
        For an unknown name; DataError where the table cannot be read or lacks it.
    """
    wanted = [CLAIMS[name].name for name in list(names) or CLAIMS]
    known = {one.claim.name: one for one in read_claims(table)[0]}
    if missing := [name for name in wanted if name not in known]:
        raise DataError(
            table,
            f"has no runs of {missing[0]}",
            f"make it again with {COMMANDS[table]}",
        )
    return [known[name] for name in wanted]


def verdicts(*names: str) -> pd.DataFrame:
    """The lines of some claims as they were judged for the release.

    Parameters
    ----------
    *names : str
        Such as "T09-e"; all by default.

    Returns
    -------
    DataFrame
        Columns claim, measured, asked, here and verdict, all as text: see
        `mkt.experiments.claims_as_text.row_of`.

    Raises
    ------
    ValueError
        For an unknown name; DataError where the numbers cannot be read.
    """
    rows = [
        {"claim": result.claim.name} | row_of(line)
        for result in map(judge, claimed(names))
        for line in result.lines
    ]
    return pd.DataFrame(rows)


def write_runs(rows: pd.DataFrame, seeds: Sequence[int], table: Path) -> None:
    """Keep the runs of trackers for a release.  Raises OSError."""
    _write(table, rows, seeds, {})


def renewed(table: Path, fresh: pd.DataFrame) -> pd.DataFrame:
    """The runs of a ranking, those of some trackers replaced by fresh ones.

    Raises
    ------
    ValueError
        Where a tracker has not run on all sources of the table, or has run on others
        than the trackers that stay.
    DataError
        Where the table cannot be read.
    """
    rows, _ = read_runs(table)
    kept = rows[~rows["tracker"].isin(fresh["tracker"])]
    _check_sources(table, rows, fresh, alone=kept.empty)
    rows = pd.concat([kept, fresh])
    places = {"source": list(rows["source"].unique()), "tracker": [*by_name.TRACKERS]}
    return rows.sort_values(
        ["source", "tracker", "seed"],
        key=lambda each: (
            each.map(places[each.name].index) if each.name in places else each
        ),
        ignore_index=True,
    )


def _check_sources(
    table: Path, rows: pd.DataFrame, fresh: pd.DataFrame, alone: bool
) -> None:
    """Refuse fresh runs whose means are not over the sources of the table's rows.

    Where no other tracker stays, that is where they are `alone`, sources may be added.
    """
    wanted = {*rows["source"]}
    for name, runs in fresh.groupby("tracker"):
        found = {*runs["source"]}
        missing, new = sorted(wanted - found), sorted(found - wanted)
        if missing:
            raise ValueError(
                f"{table.name} has {missing[0]}, on which {name} has not run now; run "
                "it on all sequences of the table"
            )
        if new and not alone:
            raise ValueError(
                f"{table.name} has no {new[0]}, on which {name} has run; run all "
                "trackers on it"
            )


def read_runs(table: Path) -> tuple[pd.DataFrame, Made]:
    """The runs of a release, and how they were made.

    Raises
    ------
    DataError
        Where the table cannot be read.
    """
    rows, made, _ = _read(table, "tracker", "source", "seed", *NUMBERS)
    return rows.astype({name: object for name in WORDS}).fillna(NO_WORDS), made


def read_table(table: Path, *columns: str) -> tuple[pd.DataFrame, Made]:
    """A table of any kind that has some columns, and how it was made.

    Raises
    ------
    DataError
        Where the table cannot be read.
    """
    rows, made, _ = _read(table, *columns)
    return rows, made


def seeds_of(made: Made) -> range:
    """The seeds of a table."""
    first, after = map(int, made.seeds.split(":"))
    return range(first, after)


def _write(
    table: Path, rows: pd.DataFrame, seeds: Sequence[int], more: dict[str, Any]
) -> None:
    if not len(seeds) or list(seeds) != list(range(seeds[0], seeds[-1] + 1)):
        raise ValueError(f"the seeds {list(seeds)} do not follow one another")
    with whole(table) as half:
        rows.to_csv(half, index=False, float_format=DIGITS, lineterminator="\n")
    made = {
        "command": COMMANDS[table] if table in COMMANDS else "",
        "date": datetime.date.today().isoformat(),
        "seeds": f"{seeds[0]}:{seeds[-1] + 1}",
        "versions": dependencies.versions(),
        "code": codes_of(table),
        "content": _content(table),
    }
    with whole(table.with_suffix(".json")) as half:
        text = json.dumps({"made": made} | more, indent=1) + "\n"
        half.write_text(text, encoding="utf-8")


def _read(table: Path, *columns: str) -> tuple[pd.DataFrame, Made, dict[str, Any]]:
    try:
        rows = pd.read_csv(table)
        rows[list(columns)]  # raises KeyError
        more = json.loads(table.with_suffix(".json").read_text(encoding="utf-8"))
        made = Made(**more.pop("made"))
        if made.content != _content(table):
            raise ValueError("it is not the table that its JSON file was written for")
    except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise _unreadable(table, error) from None
    return rows, made, more


def _content(table: Path) -> str:
    """A hash of a table's lines, however they end."""
    return _short(table.read_text(encoding="utf-8"))


def _unreadable(table: Path, error: Exception) -> DataError:
    remedy = "take it from the repository again"
    command = COMMANDS.get(table)
    remedy += f", or make it with `{command}`" if command else ""
    return DataError(table, f"cannot be read ({error})", remedy)
