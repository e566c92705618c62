"""Judged claims as text for a terminal and as rows for a file."""

import textwrap

from mkt.claims import RULE

WIDTH = 132


def as_text(results):
    """The claims with their lines in aligned columns, and the rule.  results: of `mkt.claims.judge`."""
    widths = [max(len(cell) for cells in columns for cell in cells) for columns in zip(*([*zip(*map(_cells, r.lines))] for r in results))]
    lines = [f"The papers' claims over {results[0].seeds} seeds: value [95 % interval]", ""]
    for result in results:
        lines += [f"{result.claim.id}  {result.verdict.upper()}: {result.claim.sentence}", f"       in the paper: {result.claim.printed}"]
        lines += ["       " + "  ".join(cell.ljust(width) for cell, width in zip(_cells(line), widths)).rstrip() for line in result.lines] + [""]
    return "\n".join([*lines, *textwrap.wrap(RULE, WIDTH)])


def _cells(line):
    return line.text, line.condition, measured(line), line.verdict


def measured(line):
    """A line's value with its interval and unit, as text."""
    return f"{_number(line.value)} [{_number(line.low)}, {_number(line.high)}] {line.unit}".rstrip()


def _number(value):
    return f"{value:.3g}" if abs(value) < 100 else f"{value:.0f}"


def as_rows(results):
    """One dict a line, for `mkt.sweeps.table`."""
    return [{"claim": r.claim.id, "sentence": r.claim.sentence, "paper": r.claim.printed, "claim verdict": r.verdict, "measured": line.text,
             "condition": line.condition, "value": line.value, "low": line.low, "high": line.high, "unit": line.unit, "verdict": line.verdict,
             "seeds": r.seeds} for r in results for line in r.lines]
