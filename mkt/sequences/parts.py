"""Parts of a recorded sequence: from other frames on, forwards and backwards.

How well a target is followed from the first frame on depends on that frame: on how the
target looks in it, and on what it meets next.  OTB therefore starts trackers in other
frames as well, which it calls temporal robustness.  Played backwards, a sequence is
another one, of the same target among the same things.

Parts overlap in time, so they are no independent cases: differences between trackers
are still taken over whole sequences (`mkt.experiments.leaderboard`).
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from mkt.evaluation import SEEN
from mkt.sequences.benchmarks import Found
from mkt.tracking import Sequence
from mkt.types import NDArray

LONGEST, SHORTEST = 350, 60  # frames of a part; a short sequence is halved at most


@dataclass(frozen=True)
class Part:
    """The frames of a sequence from one of them on, at most `LONGEST`.

    Parameters
    ----------
    found : Found
        The whole sequence; a part has its name in tables.
    start : int
        The frame, from 0.
    way : {1, -1}
        Forwards or backwards.
    """

    found: Found
    start: int
    way: int = 1

    @property
    def name(self) -> str:
        """That of the whole sequence."""
        return self.found.name

    def identity(self) -> str:
        """That of the whole sequence, and which part it is."""
        return f"{self.found.identity()} from {self.start} by {self.way}"

    def sequence(self) -> Sequence:
        """The `Sequence`.

        Raises
        ------
        DataError
            As `mkt.sequences.benchmarks.Found.sequence` does.
        """
        clip = self.found.sequence()
        end = self.start + LONGEST * self.way
        return clip.part(slice(self.start, None if end < 0 else end, self.way))


def parts(found: Found, n: int) -> list[Part]:
    """`n` parts forwards and `n` backwards, from frames spread evenly.

    Each begins where the target is seen, and will be once more; two that would begin
    in the same frame are one.

    Raises
    ------
    DataError
        As `mkt.sequences.benchmarks.Found.sequence` does.
    """
    seen = found.sequence().visibility > SEEN
    shortest = min(SHORTEST, len(seen) // 2)
    last = len(seen) - 1
    spread = np.linspace(0, last - shortest, n).round().astype(int)
    forwards = [Part(found, k) for k in _next_seen(seen, spread)]
    back = [Part(found, last - k, -1) for k in _next_seen(seen[::-1], spread)]
    return [*forwards, *back]


def _next_seen(seen: NDArray, places: Iterable[int]) -> list[int]:
    """The next frames in which the target is seen, each once, but not its last one."""
    there = np.flatnonzero(seen)[:-1]
    index = np.unique(np.searchsorted(there, list(places)))
    return there[index[index < len(there)]].tolist()
