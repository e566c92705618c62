"""Results that nobody measured, so that pages can be written without running anything."""

from mkt import claims, leaderboard
from mkt.book import pages


def results():
    """Every claim with made-up lines, one for each verdict."""
    lines = tuple(claims.Line(f"<{verdict}>", "> 1", value, value, value, "deg", verdict) for value, verdict in enumerate(pages.BADGES))
    return [claims.Result(claim, lines, 16, verdict) for claim, verdict in zip(claims.registry().values(), [*pages.BADGES] * 9)]


def boards():
    """A board on which one of two made-up trackers would not start."""
    run = {"scenario": "made up", "seed": 0, "overlap": 0.625, "hits": 0.875, "hits_of_all": 0.75, "area": 0.61, "lost": 0.0, "cpu_ms": 4.2, "refused": ""}
    return [leaderboard.Board("Nowhere", "No data at all.", [run | {"name": "ssd"}, run | {"name": "mil", "refused": "too dark"}])]
