"""What work costs: CPU time, of this process, of one thread where that matters.

Wall-clock times of different days say little.  Contenders therefore run in turn
(`side_by_side`), and a ratio is the median of the ratios within a round.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from collections.abc import Sequence as Series
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from threading import Lock
from typing import Any

import cv2
import numpy as np
from tqdm import tqdm

from mkt.types import Array, ArrayLike

ROUNDS = 7


@contextmanager
def one_thread() -> Iterator[None]:
    """OpenCV and numpy's linear algebra with a single thread for a while.

    Several threads hinder each other on a busy machine, and blur a measured time: the
    time that one of them waits for another counts as its own.
    """
    _LIMITS.enter()
    try:
        yield
    finally:
        _LIMITS.leave()


class _Limits:
    """The limits of the whole program.

    Whoever asks first, in any thread of Python, sets them, and the last one to leave
    restores what was there before.
    """

    def __init__(self):
        self._lock = Lock()
        self._users = 0
        self._undo = ExitStack()

    def enter(self) -> None:
        """One more wants them."""
        with self._lock:
            self._users += 1
            if self._users == 1:
                self._undo.callback(cv2.setNumThreads, cv2.getNumThreads())
                cv2.setNumThreads(1)
                self._undo.enter_context(_controller().limit(limits=1))

    def leave(self) -> None:
        """One less."""
        with self._lock:
            self._users -= 1
            if self._users == 0:
                self._undo.close()


_LIMITS = _Limits()


@lru_cache(maxsize=1)
def _controller() -> Any:
    """The libraries that have threads; to look for them takes milliseconds."""
    # Not above: it sets a variable of the environment when it is imported.
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


class Clocked:
    """The frames of a sequence, and the CPU time [s] that it took to make them.

    That time is not the tracker's.
    """

    def __init__(self, frames: Series):
        self.frames, self.seconds = frames, 0.0

    def __len__(self) -> int:
        return len(self.frames)

    def __getitem__(self, k):
        start = time.process_time()
        frame = self.frames[k]
        self.seconds += time.process_time() - start
        return frame


def milliseconds(work: Callable[[], Any], repeats: int = 5) -> float:
    """CPU time of a piece of work in this thread [ms], the shortest of some repeats.

    Disturbances can only make it longer.

    Parameters
    ----------
    work : callable
    repeats : int
    """
    times = []
    for _ in range(repeats):
        start = time.thread_time()
        work()
        times.append(time.thread_time() - start)
    return 1e3 * min(times)


def exponent(sizes: ArrayLike, costs: ArrayLike) -> float:
    """The power of the sizes with which costs (n,) grow, fitted to the logarithms.

    Parameters
    ----------
    sizes, costs : (n,) array_like
        Above 0.
    """
    return float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])


def side_by_side(
    contenders: Mapping[Any, Callable[[], Any]], repeats: int = ROUNDS
) -> dict[Any, Array]:
    """CPU times of pieces of work that are done in turn.

    Returns
    -------
    dict of (repeats,) arrays [ms]
    """
    times: dict[Any, list[float]] = {name: [] for name in contenders}
    for _ in tqdm(range(repeats), disable=None, leave=False):
        for name, work in contenders.items():
            start = time.process_time()
            work()
            times[name].append(1e3 * (time.process_time() - start))
    return {name: np.array(spent) for name, spent in times.items()}
