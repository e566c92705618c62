"""A judge and the program of a student: what one piece does costs no other piece."""

import json
import os
import subprocess
import sys
import time
from collections import namedtuple
from enum import Enum

import numpy as np
import pytest

from mkt.course.labs import student as students
from mkt.course.labs.judge import Judge, judged
from mkt.course.labs.student import Cell, Student, TheirError, Trouble
from mkt.course.labs.values import LARGEST, TooLarge, pack, unpack
from mkt.course.labs.variants import LONGEST, written_name
from mkt.files import ROOT
from tests.course.toy_lab import GOOD, answer

pytestmark = pytest.mark.slow

Point = namedtuple("Point", "x y")
ADD = Cell("add", "def add(a, b):\n    return a + b")


def verdicts(theirs, checks, limit=1.5):
    """What fails, {name: why}, of pieces of code by name."""
    cells = [Cell(*pair) for pair in checks.items()]
    return judged([], cells, theirs, limit, boxed=False)


def test_a_loop_that_asks_the_judge_without_end_costs_the_next_check_nothing():
    loop = Cell("endless", "def endless(asked):\n    while asked():\n        pass")
    checks = {
        "calls back": "endless(lambda: True)",
        "adds": "assert add(1, 2) == 3",
        "adds again": "assert add(5, 5) == 10, add(5, 5)",
    }
    for _ in range(3):  # where the interrupt lands is chance
        said = verdicts([loop, ADD], checks)
        assert list(said) == ["calls back"]


def test_a_check_has_its_own_time_whatever_the_cells_took_before_it():
    crash = Cell("crash", "import os\ndef crash():\n    os._exit(1)")
    slow = Cell("slow", "import time\ntime.sleep(1.2)")
    late = Cell("late", "def late():\n    time.sleep(0.6)\n    return 1")
    checks = {"dies": "crash()", "is late": "assert late() == 1"}
    assert list(verdicts([crash, late, slow], checks)) == ["dies"]


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such signals")
def test_a_judge_that_is_ended_leaves_no_folder_behind(tmp_path):
    endless = Cell("endless", "open('begun', 'w').close()\nwhile True:\n    pass")
    case = {"given": [], "checks": [], "theirs": [endless], "limit": 9, "boxed": False}
    process = subprocess.Popen(
        [sys.executable, "-m", "mkt.course.labs.judge"],
        cwd=ROOT,
        env=os.environ | {"TMPDIR": str(tmp_path)},
        stdin=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    process.stdin.write(json.dumps(case))
    process.stdin.close()
    end = time.monotonic() + 60
    while not list(tmp_path.glob("*/begun")) and time.monotonic() < end:
        time.sleep(0.01)
    assert list(tmp_path.glob("*/begun"))
    process.terminate()
    assert process.wait(timeout=60) and not list(tmp_path.iterdir())


def test_who_calls_back_without_end_is_stopped_in_time(monkeypatch):
    monkeypatch.setattr(students, "PATIENCE", 0.5)
    spam = Cell(
        "spam",
        "import gc\n"
        "from mkt.course.labs.accused import Accused\n"
        "def spam(asked):\n"
        "    me = next(o for o in gc.get_objects() if type(o).__name__ == 'Accused')\n"
        "    while True:\n"
        "        try:\n"
        "            me.say({'back': 0, 'args': (), 'kwargs': {}})\n"
        "        except BaseException:\n"
        "            pass\n",
    )
    start = time.monotonic()
    with Student([spam], 0.5, boxed=False) as student:
        check = Cell("check", "spam(lambda: 1)")
        assert Judge([], [check], student).verdicts()["check"]
    assert time.monotonic() - start < 20


def test_a_failure_of_ours_is_no_verdict_on_the_student(monkeypatch):
    def refused(*_, **__):
        raise BlockingIOError(11, "Resource temporarily unavailable")

    crash = Cell("crash", "import os\ndef crash():\n    os._exit(1)")
    with Student([crash, ADD], 5, boxed=False) as student:
        judge = Judge([], [Cell("c", "crash()"), Cell("a", "add(1, 2)")], student)
        monkeypatch.setattr(students.subprocess, "Popen", refused)
        with pytest.raises(Trouble, match="cannot be started.*unavailable"):
            judge.verdicts()


def test_a_word_of_a_check_is_the_word_in_the_students_code_for_is_as_well():
    same = Cell("same", "def same(how):\n    return how is 'tiles'")
    assert verdicts([same], {"same": "assert same('tiles')"}, 5) == {}


def test_no_figure_of_a_cell_is_open_in_the_next_one():
    """Or one that draws many takes the memory of the other pieces."""
    draws = Cell("draws", "import matplotlib.pyplot as plt\nfig = plt.figure()")
    left = Cell("left", "n = len(plt.get_fignums())\ndef left():\n    return n")
    assert verdicts([draws, left], {"left": "assert left() == 0"}, 20) == {}


def test_what_a_student_says_is_one_line():
    words = "def add(a, b):\n    raise ValueError('x\\nan older version of this file')"
    said = verdicts([Cell("add", words)], {"adds": "add(1, 2)"})
    assert "\n" not in said["adds"]


def answered(value):
    """A value as the judge sees it."""
    kept = []
    message = pack(value, lambda one: kept.append(one) or len(kept) - 1)
    return unpack(message, lambda *told: told)


class Few(list):
    """A list by another name."""


class Word(str, Enum):  # noqa: UP042 (the str of a StrEnum is what it should be)
    """A word by another name."""

    KEEP = "keep"


class Measured:
    """What numpy takes for an array, as it does a series of pandas."""

    def __init__(self, *values):
        self.values = values

    def __array__(self, dtype=None, copy=None):
        return np.array(self.values, dtype)


@pytest.mark.parametrize(
    "value, seen",
    [
        (range(3), [0, 1, 2]),
        (Few([1, 2]), [1, 2]),
        (Word.KEEP, "keep"),
        (Measured(None), (0, "Measured", [], [])),
        (True, True),
        (type("Deep", (float,), {})(0.5), 0.5),
        (2 + 1j, 2 + 1j),
        ({"a": (1, None)}, {"a": (1, None)}),
        (Point(1, None), (0, "Point", ["x", "y"], [1, None])),
        (iter([1]), (0, "list_iterator", [], [])),
    ],
)
def test_what_is_plain_in_a_value_is_seen_by_the_judge(value, seen):
    assert answered(value) == seen


def test_arrays_are_seen_as_they_are_and_each_in_one_place():
    arrays = [np.arange(6.0).reshape(2, 3), np.zeros((0, 4)), np.float32(2.5)]
    for one, other in zip(answered(arrays), arrays, strict=True):
        np.testing.assert_array_equal(one, other)
        assert one.dtype == other.dtype
    np.testing.assert_array_equal(answered(Measured(1, 2)), [1, 2])
    with pytest.raises(TypeError):
        unpack(b'[["l", [["a", 0], ["a", 0]]], [["<f8", [1]]]]\n' + bytes(8), None)


def test_a_named_tuple_can_be_taken_apart_and_a_generator_is_named():
    two = Cell(
        "two",
        "from collections import namedtuple\n"
        "P = namedtuple('P', 'x y')\n"
        "def two():\n    return P(1, 2)\n"
        "def is_point(p):\n    return isinstance(p, P)\n"
        "def lazy():\n    return (k for k in range(2))",
    )
    checks = {
        "two": "x, y = two()\nassert x + y + two().y + two()[0] + len(two()) == 8",
        "tuple": "assert isinstance(two(), tuple) and two()[:1] == (1,)",
        "equal": "assert two() == (1, 2) and {two(): 3}[1, 2] == 3",
        "inside": "assert 1 in two() and 3 not in two() and two() + (3,) == (1, 2, 3)",
        "there": "assert is_point(two()) and not is_point((1, 2))",
        "array": "import numpy as np\nassert np.shape(two()) == (2,)",
        "lazy": "x, y = lazy()",
    }
    said = verdicts([two], checks, 5)
    assert list(said) == ["lazy"] and "of the type generator" in said["lazy"]
    assert "return numbers, a tuple" in said["lazy"]


def test_nothing_that_a_cell_prints_is_kept():
    """Or who prints much in each call takes the memory of the other pieces."""
    loud = Cell("loud", "print('z' * 1_000_000)")
    held = Cell(
        "held",
        "def held():\n"
        "    from IPython import get_ipython\n"
        "    return len(str(get_ipython().history_manager.outputs))",
    )
    assert verdicts([loud, held], {"held": "assert held() < 1000, held()"}, 9) == {}


def test_no_name_is_looked_for_in_a_cell_without_end():
    plain = 'def my_name():\n    return "Ada"\n'
    notebook = answer(**GOOD)
    notebook.cells[0].source = plain
    notebook.cells[0].metadata["nbgrader"]["grade_id"] = "my_name"
    assert written_name(notebook) == "Ada"
    notebook.cells[0].source = plain + "x = " + "[1]," * LONGEST
    start = time.process_time()
    written_name(notebook)
    assert time.process_time() - start < 5


def test_an_object_that_stays_there_says_what_to_do():
    with Student([Cell("f", "def f():\n    return object()")], 5, boxed=False) as one:
        with pytest.raises(TheirError, match="of the type object"):
            abs(students.Function(one, "f", dict)())


OBJECTS = Cell(
    "objects",
    "import numpy as np\n"
    "def method():\n    return np.ones(3).sum\n"  # its () forgotten
    "def lazy():\n    return map(float, [1])",
)


@pytest.mark.parametrize(
    "deed",
    ["method() - 1.0", "1.0 - method()", "ones - method()", "lazy() < 3", "1 in lazy()"]
    + ["int(lazy())", "-lazy()", "lazy()[0]", "np.allclose(lazy(), 3)"],
)
def test_what_a_check_does_to_an_object_tells_the_student_of_what_type_it_is(deed):
    check = f"import numpy as np\nones = np.ones(3)\nassert {deed}"
    said = verdicts([OBJECTS], {"check": check}, 5)["check"]
    assert said.startswith("your code gives an object of the type ")
    assert "Kept" not in said


def test_an_object_in_a_message_is_called_by_its_type():
    checks = {
        "told": "assert lazy() == 1, f'1, not {lazy()}'",
        "short": "assert lazy() == 1, f'1, not {lazy():.3f}'",
        "among": "assert [lazy()] == 1, f'1, not {[lazy()]}'",
        "shape": "import numpy as np\nassert np.shape(method()) == (3,), 'not (3,)'",
    }
    assert verdicts([OBJECTS], checks, 5) == {
        "told": "1, not an object of the type map",
        "short": "1, not an object of the type map",
        "among": "1, not [an object of the type map]",
        "shape": "not (3,)",
    }


def test_what_is_too_large_for_a_check_is_told_as_such():
    """And the process goes on, also where it was said to the judge's own function."""
    vast = Cell(
        "vast",
        "import numpy as np\n"
        f"def fits():\n    return np.zeros({LARGEST - 10_000}, np.uint8)\n"
        "def large():\n    return np.zeros(9_000_000)\n"
        "def endless():\n    return np.broadcast_to(0.0, (10**6, 10**6))\n"
        "def tells(judge):\n    return judge(large())\n"
        "def in_itself(judge):\n    a = []\n    a.append(a)\n    return judge(a)\n"
        "started = [1]\n"
        "def once():\n    return started.pop()",
    )
    checks = {
        "first": "assert once() == 1",
        "fits": "assert fits().sum() == 0",
        "large": "assert large().sum() == 0",
        "endless": "endless()",
        "tells": "tells(lambda array: array.sum())",
        "in itself": "in_itself(lambda given: 1)",
        "same process": "once()",
    }
    said = verdicts([vast], checks, 9)
    assert set(said) == {*checks} - {"first", "fits"}
    assert "your code gives 72.0 MB, and a check takes at most 67.1" in said["large"]
    assert said["tells"] == said["large"]
    assert "RecursionError" in said["in itself"]
    assert "IndexError" in said["same process"]


def test_a_message_has_an_end():
    empty = len(pack(np.zeros(0, np.uint8), id))
    room = LARGEST - empty - len(str(LARGEST)) + 1  # the length is written in it
    assert len(pack(np.zeros(room, np.uint8), id)) == LARGEST
    with pytest.raises(TooLarge):
        pack(np.zeros(room + 1, np.uint8), id)


def test_a_word_is_that_of_the_lab_however_it_is_given():
    own = Cell("own", "def own(a='x', *, how='x'):\n    return a is how is 'tiles'")
    assert verdicts([own], {"is": "assert own('tiles', how='tiles')"}, 5) == {}


def test_a_check_that_python_cannot_read_says_so_and_stops_no_other():
    said = verdicts(
        [ADD], {"odd": "%timeit add(1, 2)", "adds": "assert add(1, 2) == 3"}
    )
    assert list(said) == ["odd"] and "SyntaxError" in said["odd"]
