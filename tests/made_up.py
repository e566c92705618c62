"""Results that nobody measured, so that pages can be written with nothing run."""

from itertools import cycle

import pandas as pd

from mkt.course.book import pages
from mkt.experiments import claims, leaderboard


def results():
    """Every claim with made-up lines, one for each verdict."""
    lines = tuple(
        claims.Line(f"<{verdict}>", "> 1", value, value, value, "deg", verdict)
        for value, verdict in enumerate(pages.BADGES)
    )
    verdicts = cycle(pages.BADGES)
    return [
        claims.Result(claim, lines, 16, next(verdicts))
        for claim in claims.CLAIMS.values()
    ]


def boards():
    """A board on which one of two made-up trackers would not start."""
    run = {
        "source": "made up",
        "seed": 0,
        "overlap": 0.625,
        "hits": 0.875,
        "hits_of_all": 0.75,
        "area": 0.61,
        "lost": 0.0,
        "cpu_ms": 4.2,
        "refused": "",
    }
    rows = [run | {"tracker": "ssd"}, run | {"tracker": "mil", "refused": "too dark"}]
    return [leaderboard.Board("Nowhere", "No data at all.", pd.DataFrame(rows))]
