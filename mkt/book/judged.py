"""The claims as the book keeps them: many are measured anew at every call, so they are judged once for each state of the library."""

import hashlib
import json
from dataclasses import asdict
from pathlib import Path

from mkt import claims
from mkt.book.execute import library_key
from mkt.files import whole

SEEDS = 8  # half of what `python3 -m mkt claims` takes, so that a book from nothing is ready in minutes


def kept(path, judge=claims.judge):
    """All claims, judged over `SEEDS` seeds: read from a file where this state of the library is known, else put to the test and kept there.

    path: of the file, in a folder that is there; judge: called with seeds=.  Returns a list of `mkt.claims.Result`, raises OSError that names the file.
    """
    key, known = _key(), _read(path)
    if known.get("key") != key:
        results = [{"id": result.claim.id, "verdict": result.verdict, "lines": [asdict(line) for line in result.lines]} for result in judge(seeds=SEEDS)]
        known = {"key": key, "results": results}
        with whole(path) as half:
            half.write_text(json.dumps(known), encoding="utf-8")
    return [claims.Result(claims.get(of["id"]), tuple(claims.Line(**line) for line in of["lines"]), SEEDS, of["verdict"]) for of in known["results"]]


def _key():
    digest = hashlib.sha256(f"{library_key()} {SEEDS}".encode())
    for path in sorted(Path(claims.__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _read(path):
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}  # none yet, or one that cannot be read
