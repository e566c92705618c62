"""Work that is spread over processes comes back, in order where that is asked for."""

import os
import subprocess
import sys
import time

import pytest

from mkt.experiments.processes import _called, spread
from mkt.files import ROOT
from mkt.scenes import SCENES


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


class Odd(Exception):
    """An error that cannot be made again of what it says."""

    def __init__(self, one, two):
        super().__init__(one + two)


def stumbling():
    raise Odd("o", "dd")


@pytest.mark.parametrize("processes", [1, 2])
def test_an_error_that_cannot_be_sent_comes_in_its_words(processes):
    with pytest.raises(RuntimeError, match="^Odd: odd$"):
        list(spread(stumbling, [()], processes))


OWN_SCENE = """
import mkt
from dataclasses import replace

SHORT = 4

@mkt.SCENES.register("mine")
def mine(seed, item, ground):
    return replace(mkt.SCENES["base"](seed, item, ground), length=SHORT)

def go():
    made = mkt.jobs({"ssd": mkt.SSD()}, [mkt.Drawn("mine", k) for k in range(2)])
    print(*mkt.sweep(made, 2)["source"])

if __name__ == "__main__":
    go()
"""


@pytest.mark.slow
@pytest.mark.parametrize("words", [["own.py"], ["-c", "import own; own.go()"]])
def test_processes_know_a_scene_that_a_script_or_its_module_registers(words, tmp_path):
    (tmp_path / "own.py").write_text(OWN_SCENE)
    folders = os.pathsep.join([str(ROOT), str(tmp_path)])
    done = subprocess.run(
        [sys.executable, *words],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": folders},
        capture_output=True,
        text=True,
    )
    assert done.stdout.split() == ["mine", "mine"], done.stderr


def test_a_process_takes_the_scene_that_was_sent_last(monkeypatch):
    monkeypatch.setattr(SCENES, "_entries", dict(SCENES))

    def look():
        return SCENES["mine"](1, item="car")

    for k in range(2):
        sent = {"mine": lambda seed, item, k=k: (seed, item, k)}
        assert _called(sent, look) == (1, "car", k)
