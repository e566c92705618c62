"""The page "Twenty tasks" of the book does what it says, in a few lines each."""

import ast
import re
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

import mkt
from mkt.course.book.pages import HERE
from mkt.figures.registry import FIGURES
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene
from mkt.sequences.writing import video_writer
from mkt.trackers import by_name

pytestmark = pytest.mark.slow

PAGE = (HERE / "templates" / "tasks.md").read_text(encoding="utf-8")
LINES = 5  # of a task, at most
TASKS = [int(number) for number in re.findall(r"^### (\d+)\.", PAGE, re.M)]


def blocks():
    """The code of the page, block by block, each with the number of its task or 0."""
    parts = re.split(r"^### (\d+)\.", PAGE, flags=re.M)
    texts = [(0, parts[0]), *zip(map(int, parts[1::2]), parts[2::2], strict=True)]
    return [
        (number, code)
        for number, text in texts
        for code in re.findall(r"```python\n(.*?)```", text, re.S)
    ]


def test_there_are_twenty_and_two_in_order():
    assert TASKS == list(range(1, 23))
    assert {number for number, _ in blocks()} == {0, *TASKS}


@pytest.mark.parametrize("number, code", blocks())
def test_a_task_takes_few_lines_and_no_private_name(number, code):
    lines = [line for line in code.splitlines() if line.strip()]
    assert len(lines) <= LINES
    assert max(map(len, lines)) <= 88
    names = [node.attr for node in ast.walk(ast.parse(code)) if hasattr(node, "attr")]
    assert not [name for name in names if name.startswith("_")]


@pytest.fixture
def a_ball(tmp_path, monkeypatch):
    """A folder with ball.mp4, in which the tasks are run; what they add is removed."""
    monkeypatch.chdir(tmp_path)
    clip = Scene(Layer("car", 50, ((0, 90, 60, 0, 1),)), length=3).sequence()
    with video_writer("ball.avi", (320, 240), 25.0) as writer:
        for frame in clip.frames:
            writer.write(frame)
    Path("ball.avi").rename("ball.mp4")
    for registry in (by_name.TRACKERS, FIGURES):
        assert len(registry)  # all are found before the list is copied
        monkeypatch.setattr(registry, "_entries", dict(registry._entries))
    monkeypatch.setattr(by_name, "LABELS", dict(by_name.LABELS))
    yield
    plt.close("all")


def test_all_tasks_can_be_typed_in_one_after_the_other(a_ball, tmp_path, capsys):
    names = {"__name__": "tasks"}
    for _, code in blocks():
        exec(code, names)
    assert len(names["mine"]) == 3 and len(names["own"]) == 60
    assert names["target"].q.shape[0] == 9
    assert names["surface"].shape == (41, 41)
    assert names["surface"].argmin() == 20 * 41 + 20  # least where it was learnt
    assert names["few"].n == 100
    assert names["crowd"].info["particles"].shape == (len(names["clip"]), 100, 5)
    assert len(names["rows"]) == 2 * 6
    assert {path.name for path in tmp_path.glob("out.*")} == {"out.webm", "out.csv"}
    assert "999" in capsys.readouterr().out
    still = mkt.track(mkt.TRACKERS["still"], names["clip"])
    assert (still.regions == names["clip"].truth[0]).all()
    assert mkt.FIGURES["own.red"].draw(k=5)[1]["red"].mean() > 0
