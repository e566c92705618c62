"""Judged claims as text for a terminal."""

import textwrap
from collections.abc import Sequence
from math import isfinite

from tabulate import tabulate

from mkt.experiments.claims import RULE, Line, Result

WIDTH = 132


def as_text(results: list[Result]) -> str:
    """The claims with their lines in aligned columns, and the rule."""
    seeds = results[0].seeds
    head = (
        f"The papers' claims over {len(seeds)} scenes of each kind "
        f"(seeds {_seeds(seeds)}),\nor as many repeats of what needs no scene: "
        "value [95 % interval]"
    )
    rule = "\n".join(textwrap.wrap(RULE, WIDTH))
    return "\n\n".join([head, *map(_block, results), rule])


def _seeds(seeds: Sequence[int]) -> str:
    first = min(seeds)
    after = max(seeds) + 1
    together = [*seeds] == [*range(first, after)]
    return f"{first}:{after}" if together else ", ".join(map(str, seeds))


def _block(result: Result) -> str:
    claim = result.claim
    lines = sorted(result.lines, key=lambda line: line.part.ours)
    table = tabulate([row_of(line).values() for line in lines], tablefmt="plain")
    return "\n".join(
        [
            f"{claim.name}  {result.verdict.upper()}: {claim.sentence}",
            f"       in the paper: {claim.printed}",
            textwrap.indent(table, " " * 7),
        ]
    )


def row_of(line: Line) -> dict[str, str]:
    """What a table says of a line.

    That is what was measured, what is asked of it (our bound), the value here with its
    95 % interval, and the verdict, in parentheses where it is ours or cannot fail.
    """
    verdict = f"({line.verdict})" if line.part.ours else line.verdict
    here = {"here": measured(line), "verdict": verdict}
    return {"measured": line.part.text, "asked": line.condition} | here


def measured(line: Line) -> str:
    """A line's value with its interval and unit, as text."""
    width = line.high - line.low
    dust = 1e-4 * width if isfinite(width) else 0  # of rounding, about zero
    three = (line.value, line.low, line.high)
    value, low, high = (_number(0 if abs(x) < dust else x) for x in three)
    return f"{value} [{low}, {high}] {line.part.unit}".rstrip()


def _number(value: float) -> str:
    return f"{value:.3g}" if abs(value) < 100 else f"{value:.0f}"
