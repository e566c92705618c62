"""A camera runs for hours: what a tracker keeps does not grow.

And no frame is held on to.
"""

import gc
import pickle
import tracemalloc
import weakref

import numpy as np
import pytest

from mkt.regions import from_box
from mkt.trackers import by_name

pytestmark = pytest.mark.slow

WARM, LENGTH = 100, 400  # frames, before which caches may still fill; in all
PERIOD, HIDDEN = 100, 15  # frames; the target is hidden at the end of each period


def blocks(seed, size, side):
    """An image of random colours in blocks of some pixels a side."""
    colors = np.random.default_rng(seed).integers(0, 256, (*size, 3), np.uint8)
    return colors.repeat(side, 0).repeat(side, 1)


BACKGROUND = blocks(1, (9, 12), 4)
TARGET = blocks(2, (4, 4), 3)
START = from_box([24, 12, 12, 12])


def picture(k):
    """Frame k (36, 48, 3): the target goes round in a circle."""
    frame = BACKGROUND.copy()
    if k % PERIOD < PERIOD - HIDDEN:
        x, y = 18 + round(6 * np.cos(k / 8)), 12 + round(6 * np.sin(k / 8))
        frame[y : y + 12, x : x + 12] = TARGET
    return frame


def light(name):
    """The tracker of a name, with few particles where it has any."""
    tracker = by_name.TRACKERS[name]
    if hasattr(tracker, "n") or hasattr(tracker, "filter"):
        return by_name.with_particles(name, 20)
    return tracker


QUICK = by_name.quick()


@pytest.mark.parametrize("name", QUICK)
def test_hundreds_of_frames_later_no_more_is_kept(name):
    tracker, rng = light(name), np.random.default_rng(0)
    alive, used = [], {}
    state = tracker.init(picture(0), START, rng)
    for k in range(1, LENGTH + 1):
        frame = picture(k)
        alive.append(weakref.ref(frame))
        state, _ = tracker.step(state, frame, rng)
        del frame, _
        if k == WARM:
            tracemalloc.start()
        if k in (WARM + 1, LENGTH):
            gc.collect()
            alive = [ref for ref in alive if ref() is not None]
            used[k] = len(pickle.dumps(state)), tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    (size, memory), (size_later, memory_later) = used.values()
    assert len(alive) <= 1
    assert size_later <= size + 16  # a whole number may take a few bytes more
    # An array for each frame would make more; other threads of the tests make some.
    assert memory_later - memory < 120_000


def test_opencv_holds_no_frame_of_the_past():
    tracker, rng = by_name.TRACKERS["mil"], np.random.default_rng(0)
    alive = []
    state = tracker.init(picture(0), START, rng)
    for k in range(1, 12):
        frame = picture(k)
        alive.append(weakref.ref(frame))
        state, _ = tracker.step(state, frame, rng)
        del frame, _
    gc.collect()
    assert sum(ref() is not None for ref in alive) <= 1
