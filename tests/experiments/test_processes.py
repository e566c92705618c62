"""Work that is spread over processes comes back, in order where that is asked for."""

import os
import time

import pytest

from mkt.experiments.processes import spread


def late(delay, name):
    """The name and the process, after a while."""
    time.sleep(delay)
    return name, os.getpid()


@pytest.mark.parametrize("processes", [1, 2])
@pytest.mark.parametrize("in_order", [True, False])
def test_results_come_back_in_order_or_as_they_come(processes, in_order):
    work = [(0.5, "slow"), (0.0, "quick"), (0.0, "last")]
    found = list(spread(late, work, processes, in_order=in_order))
    names = [name for name, _ in found]
    assert sorted(names) == ["last", "quick", "slow"]
    if in_order or processes == 1:
        assert names == ["slow", "quick", "last"]
    else:
        assert names[-1] == "slow"
    assert ({own for _, own in found} == {os.getpid()}) == (processes == 1)
