"""The claims as the book shows them: judged once for each state of the library.

Their runs are kept by themselves, but some claims count or time something anew whenever
they are judged.
"""

import json
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from mkt.course.book import depends
from mkt.experiments import claims
from mkt.experiments.cache import Shelf, as_json

# Half of what `python3 -m mkt claims` takes, so that a book from nothing is ready in
# minutes.
SEEDS = 8
VERDICTS = Shelf("claims", ".json", as_json, json.loads)


def kept(
    judge: Callable[..., list[claims.Result]] = claims.judge,
) -> list[claims.Result]:
    """All claims, judged over `SEEDS` seeds, put to the test if they are not known.

    Parameters
    ----------
    judge : callable
        Called with seeds=.

    Returns
    -------
    list of `mkt.experiments.claims.Result`

    Raises
    ------
    OSError
        When they cannot be kept.
    """

    def make() -> list[dict[str, Any]]:
        return [_as_record(result) for result in judge(seeds=SEEDS)]

    records = VERDICTS.kept(depends.of_claims(SEEDS), make)
    return [_result(record) for record in records]


def _as_record(result: claims.Result) -> dict[str, Any]:
    return {
        "claim": result.claim.name,
        "verdict": result.verdict,
        "lines": [asdict(line) for line in result.lines],
    }


def _result(record: dict[str, Any]) -> claims.Result:
    return claims.Result(
        claims.CLAIMS[record["claim"]],
        tuple(claims.Line(**line) for line in record["lines"]),
        SEEDS,
        record["verdict"],
    )
