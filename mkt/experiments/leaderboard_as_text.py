"""A leaderboard as tables: Markdown for a terminal, and rows for the book's pages."""

import textwrap
from collections.abc import Iterable

import numpy as np
import pandas as pd
from tabulate import tabulate

from mkt.experiments.leaderboard import (
    LEVEL,
    Board,
    Place,
    counted,
    ranking,
    told_apart,
)
from mkt.experiments.statistics import refused
from mkt.trackers.by_name import LABELS

WIDTH = 88
HEAD = (
    "tracker",
    "place",
    "overlap",
    "95 %",
    "behind the first",
    "true positives [%]",
    "of all frames [%]",
    "area",
    "lost [%]",
    "CPU ms",
)


def legend(places: list[Place]) -> str:
    """What the columns of the first table mean."""
    words = f"""\
*overlap*: mean over the seen frames, then over runs and sequences; *95 %*: its interval
(Student's t) over cases, which are sequences, or the seeds of drawn scenes, each with
a scene of every kind; unknown for one case alone.  *place*: from the first to the last
that a tracker may have; a paired t-test between cases ({100 * LEVEL:g} % on one side)
compares it with each rival, and two that it cannot tell apart may stand either way
round.  Who is alone in the first place is ahead of each rival.  {_pairs(places)}
*behind the first*: the mean difference over the same cases, with its interval.
*true positives*: seen frames with an overlap above .2; *of all frames*: the same out
of all frames, hidden ones too (as the fractions of [C14] are).  *area*: under the
success curve, as in OTB.  *lost*: runs without a hit in their last ten frames.  *CPU
ms*: for each frame, median over the runs."""
    return textwrap.fill(words, WIDTH)


def _pairs(places: list[Place]) -> str:
    """How many tests the places rest on, and what is left of them together."""
    pairs, single, together = told_apart(places)
    if not pairs:
        return ""
    return (
        f"Each test is made as if it were the only one: {single} of {pairs} pairs are "
        f"told apart, and {together} after Holm's correction over all pairs; where "
        "that is fewer, the places are not sure all together."
    )


def overall(places: list[Place]) -> list[list[str]]:
    """The first table: a row of texts under `HEAD` for each place."""
    return [
        [
            LABELS.get(place.name, place.name),
            _places(*place.places),
            _two(place.overlap),
            _range(place.interval),
            f"{place.behind[0]:.2f} ({_range(place.behind[1:])})"
            if place.behind
            else "",
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
    turned_away = rows.loc[refused(rows), ["tracker", "source", "refused"]]
    return [
        f"{LABELS.get(name, name)} would not start on {source}: {why}"
        for name, source, why in turned_away.drop_duplicates().itertuples(index=False)
    ]


def extent(board: Board) -> str:
    """How many sequences and runs a board has, in words."""
    n = board.rows["source"].nunique()
    runs = counted(len(board.rows), "run")
    if board.case == "seed":
        each = board.rows["seed"].nunique()
        return f"{counted(n, 'kind')} of scene, {each} of each, {runs}"
    return f"{counted(n, 'sequence')}, {runs}"


def as_markdown(board: Board) -> str:
    """A board with both tables, and what the columns mean."""
    places = ranking(board)
    head, rows = by_sequence(places)
    parts = [
        f"## {board.title}: {extent(board)}",
        board.data,
        _table(HEAD, overall(places)),
        legend(places),
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


def _places(first: int, last: int) -> str:
    return f"{first}" if first == last else f"{first}–{last}"


def _range(ends: tuple[float, float]) -> str:
    if not np.isfinite(ends).all():
        return "unknown"
    return f"{_two(ends[0])}–{_two(ends[1])}"


def _two(share: float) -> str:
    return f"{share:.2f}"
