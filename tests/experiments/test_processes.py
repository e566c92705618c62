"""Work that is spread over processes comes back, in order where that is asked for."""

import os
import time

import pytest

from mkt.experiments.processes import spread


def waiting(name, quick):
    """The name and the process; "slow" waits until "quick" has long been done."""
    if name == "slow":
        while not quick.exists():
            time.sleep(0.05)
        time.sleep(1)
    else:
        quick.touch()
    return name, os.getpid()


@pytest.mark.parametrize("processes", [1, 2])
@pytest.mark.parametrize("in_order", [True, False])
def test_results_come_back_in_order_or_as_they_come(processes, in_order, tmp_path):
    quick = tmp_path / "done"
    if processes == 1:
        quick.touch()  # nobody else could
    work = [("slow", quick), ("quick", quick), ("last", quick)]
    found = list(spread(waiting, work, processes, in_order=in_order))
    names = [name for name, _ in found]
    assert sorted(names) == ["last", "quick", "slow"]
    assert (names[0] == "slow") == (in_order or processes == 1)
    assert ({own for _, own in found} == {os.getpid()}) == (processes == 1)
