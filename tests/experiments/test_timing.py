"""The clock: how many threads it lets run, and what it says of several rounds."""

import cv2
import pytest

from mkt.experiments import timing


@pytest.fixture
def threads():
    """OpenCV's number of threads, which comes back."""
    before = cv2.getNumThreads()
    yield
    cv2.setNumThreads(before)


def test_one_thread_is_left_to_opencv_for_a_while_alone(threads):
    cv2.setNumThreads(2)
    with timing.one_thread():
        assert cv2.getNumThreads() == 1
    assert cv2.getNumThreads() == 2


def test_two_threads_that_want_one_leave_what_was_there(threads):
    cv2.setNumThreads(2)
    first, second = timing.one_thread(), timing.one_thread()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert cv2.getNumThreads() == 1
    second.__exit__(None, None, None)
    assert cv2.getNumThreads() == 2


def test_the_time_of_several_rounds_is_the_shortest():
    clock = iter([0, 3, 10, 11, 20, 22.0]).__next__
    assert timing.milliseconds(lambda: None, 3, clock) == 1000
