"""The clock: how many threads it lets run, and what it says of several rounds."""

import time

import cv2
import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from mkt.experiments import timing


def of_algebra():
    """The numbers of threads of numpy's linear algebra."""
    libraries = threadpool_info()
    return {one["num_threads"] for one in libraries if one["user_api"] == "blas"}


def test_one_thread_is_left_to_opencv_for_a_while_alone(two_threads):
    with timing.one_thread():
        assert cv2.getNumThreads() == 1
    assert cv2.getNumThreads() == 2


def test_one_thread_is_left_to_linear_algebra_for_a_while_alone():
    with threadpool_limits(2, "blas"):
        with timing.one_thread():
            assert of_algebra() == {1}
        assert of_algebra() == {2}


def test_two_threads_that_want_one_leave_what_was_there(two_threads):
    first, second = timing.one_thread(), timing.one_thread()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert cv2.getNumThreads() == 1
    second.__exit__(None, None, None)
    assert cv2.getNumThreads() == 2


def test_the_time_of_several_rounds_is_the_shortest(monkeypatch):
    clock = iter([0, 3, 10, 11, 20, 22.0]).__next__
    monkeypatch.setattr(time, "thread_time", clock)
    assert timing.milliseconds(lambda: None, 3) == 1000


@pytest.mark.parametrize("power", [0.5, 1, 2])
def test_the_exponent_is_the_power_with_which_costs_grow(power):
    sizes = np.array([10, 20, 50, 400])
    assert timing.exponent(sizes, 3 * sizes**power) == pytest.approx(power)


def test_contenders_work_in_turn_and_each_has_its_own_times(monkeypatch):
    now, done = [0.0], []

    def work(name, seconds):
        done.append(name)
        now[0] += seconds

    monkeypatch.setattr(time, "process_time", lambda: now[0])
    contenders = {"a": lambda: work("a", 0.25), "b": lambda: work("b", 0.5)}
    times = timing.side_by_side(contenders, 3)
    assert "".join(done) == "ababab"
    assert {name: each.tolist() for name, each in times.items()} == {
        "a": [250.0] * 3,
        "b": [500.0] * 3,
    }
