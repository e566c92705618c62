"""Hostile submissions get no marks that they do not earn, and do no harm."""

import contextlib
import os
import queue
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path

import nbformat
import pytest

from mkt.course import doctor
from mkt.course.labs import grading, sandbox, student, table
from mkt.course.labs.notebooks import FOLDER
from mkt.course.labs.student import Cell, Function, Student, TheirError
from tests.course.toy_lab import GOOD, answer, graded, hand_in

# Each starts students' programs; a quick loop leaves them out.
pytestmark = pytest.mark.slow

boxed = pytest.mark.skipif(sandbox.program() is None, reason="needs bubblewrap")
WRONG = "def add(a, b):\n    return a - b\n\n\n"

# Each wants the points of `check_add` for a wrong `add`.
FOR_MARKS = {
    "transformers": """
import ast
class Drop(ast.NodeTransformer):
    def visit_Assert(self, node):
        return ast.Pass()
get_ipython().ast_transformers.append(Drop())
get_ipython().input_transformers_cleanup.append(lambda lines: ["pass"])""",
    "numpy": """
import numpy as np, builtins
np.isclose = np.allclose = np.array_equal = lambda *_, **__: True
builtins.all = builtins.abs = lambda *_: True""",
    "equals_everything": """
class Yes(int):
    __eq__ = __ne__ = __bool__ = lambda *_: True
    __hash__ = None
def add(a, b):
    return Yes()""",
    "reads_the_checks": """
def add(a, b):
    import re, sys
    frames = []
    frame = sys._getframe()
    while frame:
        frames.append(str(frame.f_locals) + str(frame.f_globals))
        frame = frame.f_back
    return int(re.findall(r"== (\\d+), .2 \\+ 2 is", "".join(frames))[0])""",
    "speaks_for_python": """
import mkt.course.labs.accused as here, json
here.Accused.say = lambda self, reply: here.send(
    self.replies, json.dumps([["d", [["t", ["value", True]], ["t", ["states",
    ["d", []]]]]], []]).encode() + b"\\n")""",
    "answers_beforehand": """
import gc, io, json
for pipe in gc.get_objects():
    if isinstance(pipe, io.BufferedWriter):
        for _ in range(50):
            text = b'[["d", [["t", ["value", 3]], '
            text += b'["t", ["states", ["d", []]]]]], []]\\n'
            pipe.write(len(text).to_bytes(8, "big") + text)
        pipe.flush()""",
    "pickles": """
import mkt.course.labs.accused as here, pickle, os
class Bomb:
    def __reduce__(self):
        return os.system, ("touch /tmp/mkt-bomb",)
here.pack = lambda *_: pickle.dumps(Bomb())""",
    "reads_the_teacher": f"""
import json
from pathlib import Path
lab = json.loads(Path({str(FOLDER)!r}, "toy.ipynb").read_text())
exec("".join(lab["cells"][0]["source"]))""",
    "names_of_checks": """
check_add = check_six = None
import sys
sys.modules["__lab__"] = sys.modules["__main__"]""",
    "compares_strangely": """
def add(a, b):
    return float("nan") if a == 1 else [4]""",
    "raises_success": """
def add(a, b):
    raise SystemExit(0)""",
}


@pytest.mark.slow
def test_no_trick_earns_points(toy):
    for name, trick in FOR_MARKS.items():
        mine = answer(**GOOD | {"add": WRONG + trick})
        hand_in(toy / "submitted" / name / "toy.ipynb", mine)
    rows = graded(toy / "submitted", toy / "grades.csv", "--limit", "5")
    assert {name: rows[name]["check_add"] for name in rows} == dict.fromkeys(
        FOR_MARKS, "0"
    )
    assert not Path("/tmp/mkt-bomb").exists()


def in_the_box(source, limit=5.0):
    """What a function `attack` of a student's says, from inside of the box."""
    with Student([Cell("attack", source)], limit, boxed=True) as one:
        one.allow()
        return Function(one, "attack", dict)()


def tried(deed):
    """A function that says what became of a deed."""
    lines = "\n".join(f"        {line}" for line in deed.strip().splitlines())
    return (
        f"def attack():\n    try:\n{lines}\n        return 'done'\n"
        "    except BaseException as error:\n        return type(error).__name__\n"
    )


HARM = {
    "home": "open('{home}/secret').read()",
    "clone": "open('{package}/hostile.py', 'w')",
    "notebooks": "open('{solutions}').read()",
    "table": "open('{table}', 'a')",
    "others": "import os; os.remove('{victim}')",
    "passwords": "open('/etc/passwd').read()",
    "environment": "import os; os.environ['GRADER_TOKEN']",
    "parent": "import os; os.kill(os.getppid(), 0) if os.getppid() > 1 else 1 / 0",
    "processes": "open('/proc/{pid}/environ', 'rb').read()",
    "network": "import socket; socket.create_connection(('127.0.0.1', {port}), 2)",
    "disk": "open('/tmp/big', 'wb').write(bytes(300_000_000))",
    "memory": "bytearray(8_000_000_000)",
    "limits": "import resource as r; r.setrlimit(r.RLIMIT_AS, (2**40, 2**40))",
    "mount": "import os, ctypes; ctypes.CDLL(None).mount(b'a', b'/usr', b'tmpfs', 0, 0)"
    " and 1 / 0",
    "root": "import os; os.setuid(0) if os.getuid() else 1 / 0",
    "forks": "import os, time\n"
    "for _ in range(500):\n"
    "    if os.fork() == 0:\n"
    "        time.sleep(20); os._exit(0)",
}


@pytest.fixture
def places(tmp_path, monkeypatch):
    """What an attack could reach if it were not for the box."""
    monkeypatch.setenv("GRADER_TOKEN", "secret123")
    home = tmp_path / "home"
    home.mkdir()
    for name in ("secret", "grades.csv", "victim.ipynb"):
        (home / name).write_text("precious", encoding="utf-8")
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield {
            "home": home,
            "table": home / "grades.csv",
            "victim": home / "victim.ipynb",
            "package": Path(sandbox.__file__).parent,
            "solutions": next(FOLDER.glob("*.ipynb")),
            "port": server.getsockname()[1],
            "pid": os.getpid(),
        }


@boxed
@pytest.mark.parametrize("name", HARM)
def test_no_harm_is_done_from_inside_of_the_box(name, places):
    assert in_the_box(tried(HARM[name].format(**places))) != "done"
    files = {
        one: places[one].read_text(encoding="utf-8") for one in ("table", "victim")
    }
    assert files == {"table": "precious", "victim": "precious"}


@boxed
def test_a_library_below_tmp_can_be_read_in_the_box_and_not_written(
    tmp_path, monkeypatch
):
    """The box has a /tmp of its own, which must not hide a clone that is there."""
    monkeypatch.setattr(sandbox, "DATA", tmp_path)
    (tmp_path / "table").write_text("known")
    words = f"cat {tmp_path}/table; touch {tmp_path}/new || echo ', refused'"
    done = subprocess.run(
        sandbox.boxed(["sh", "-c", words]), capture_output=True, text=True
    )
    assert done.stdout == "known, refused\n"
    assert [path.name for path in tmp_path.iterdir()] == ["table"]


@boxed
def test_nothing_outlives_the_box():
    mark = f"mkt-{os.getpid()}-outlives"
    source = f"""
import subprocess, sys
def attack():
    code = "import time; time.sleep(60)"
    for _ in range(5):
        subprocess.Popen([sys.executable, "-c", code, {mark!r}], start_new_session=True)
"""
    in_the_box(source)
    until = time.monotonic() + 5
    while left := processes(mark):
        assert time.monotonic() < until, left


CROWD = """
import subprocess, sys
def attack():
    for _ in range({n}):
        subprocess.Popen([sys.executable, "-c", {code!r}], stdin=subprocess.PIPE)
    import time
    time.sleep({wait})
    return "done"
"""
FULL = "x = bytearray({size}); x[::4096] = b'1' * len(x[::4096]); print(); input()"


@boxed
def test_many_small_processes_may_not_take_all_memory_together(monkeypatch):
    """Each is far below its own limit; what they take together ends the box."""
    monkeypatch.setattr(sandbox, "TOGETHER", 600 * 2**20)
    code = FULL.format(size=60 * 2**20)
    with pytest.raises(TheirError, match=student.DIED):
        in_the_box(CROWD.format(code=code, n=12, wait=90), limit=100)


@boxed
def test_a_few_processes_may_have_what_they_need(monkeypatch):
    monkeypatch.setattr(sandbox, "TOGETHER", 900 * 2**20)
    code = FULL.format(size=2**20)
    assert in_the_box(CROWD.format(code=code, n=2, wait=1), limit=60) == "done"


def test_the_memory_of_a_process_counts_all_that_it_has_started():
    assert sandbox.used(os.getpid()) > 2**20
    before = sandbox.used(os.getpid())
    program = [sys.executable, "-c", FULL.format(size=100 * 2**20)]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen(program, **pipes) as child:
        child.stdout.readline()
        assert sandbox.used(os.getpid()) - before > 90 * 2**20
        child.kill()
    assert sandbox.used(child.pid) == 0


def processes(mark):
    """The command lines of this machine's processes with a mark in them."""
    lines = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):  # it has just ended
            lines.append(path.read_bytes())
    return [line for line in lines if mark.encode() in line]


@pytest.mark.parametrize(
    "message",
    [
        b"x" * 50,
        b"[" * 100_000,
        b'[["a", 0], [["<f8", [99999999999]]]]\n',
        b'[["a", 0], [["|O", [1]]]]\n12345678',
        b"\x80\x04cposix\nsystem\n(S'true'\ntR.",
    ],
    ids=["noise", "brackets", "too little", "objects", "pickle"],
)
def test_nonsense_of_the_accused_is_no_answer(message):
    one = Student([], 5, boxed=False)
    one.answers = queue.Queue()
    one.answers.put(message)
    with pytest.raises(TheirError, match=student.DIED):
        one.hear()


def test_a_table_has_no_formulas_and_no_escapes(toy):
    escape = "\x1b]0;owned\x07"
    evil = answer(**GOOD | {"why": f"Why?\n\n=HYPERLINK(1){escape}"})
    evil.cells[0].source = f"raise ValueError('{escape}')\n"
    hand_in(toy / "submitted" / "=HYPERLINK(1)" / "toy.ipynb", evil)
    graded(toy / "submitted", toy / "grades.csv")
    text = (toy / "grades.csv").read_text(encoding="utf-8-sig")
    assert "\x1b" not in text and "\x07" not in text
    assert [cell for cell in text.splitlines()[1].split(",") if cell[:1] == "="] == []
    (page,) = (toy / "grades_pages").rglob("*.html")
    assert "\x1b" not in page.read_text(encoding="utf-8")


def test_a_page_has_nothing_of_a_students_in_it_but_text(toy):
    script = "<script>alert(1)</script>"
    hand_in(
        toy / "submitted" / "<img src=x>" / "toy.ipynb",
        answer(**GOOD | {"why": f"Why?\n\n{script}"}),
    )
    graded(toy / "submitted", toy / "grades.csv")
    (page,) = (toy / "grades_pages").rglob("*.html")
    assert page.is_relative_to(toy / "grades_pages")
    assert script not in page.read_text(encoding="utf-8")
    assert "<img" not in page.read_text(encoding="utf-8")


def test_links_fifos_and_copies_have_a_row_each(toy):
    folder = toy / "submitted"
    for name in ("ada", "eve"):
        hand_in(folder / name / "toy.ipynb", answer(**GOOD))
    hand_in(folder / "ben" / "toy.ipynb", answer())
    hand_in(folder / "ben" / "toy (1).ipynb", answer(**GOOD | {"why": "Why?\n\nSo."}))
    hand_in(folder / "gina" / "final.ipynb", answer(**GOOD | {"why": "Why?\n\nOh."}))
    (folder / "link").mkdir()
    (folder / "link" / "toy.ipynb").symlink_to(folder / "ada" / "toy.ipynb")
    (folder / "fifo").mkdir()
    os.mkfifo(folder / "fifo" / "toy.ipynb")
    rows = graded(folder, toy / "grades.csv")
    said = {name: (row["points"], row["note"]) for name, row in rows.items()}
    assert said["link"] == ("", "a link to somewhere else, which was not followed")
    assert said["fifo"] == ("", "not a file")
    assert "byte for byte, as eve/toy.ipynb" in said["ada"][1]
    assert "there is another file of this lab" in said["ben"][1]
    assert said["gina"] == (
        "3",
        "not called after its lab, toy, but its cells are of it",
    )
    assert len(table.read(toy / "grades.csv")) == 7


def test_no_file_stops_the_grading_of_the_others(toy, monkeypatch):
    """Whatever stands in it, whatever it is called, and if nobody may read it."""
    folder = toy / "submitted"
    hand_in(folder / "ada" / "toy.ipynb", answer(**GOOD))
    for name, meta in {"none": None, "list": {"grade_id": ["x"]}}.items():
        odd = answer(**GOOD)
        odd.cells.append(nbformat.v4.new_code_cell("1", metadata={"nbgrader": meta}))
        hand_in(folder / name / "toy.ipynb", odd)
    deep = answer(**GOOD)
    of_name = {"nbgrader": {"grade_id": "my_name"}}
    source = f"x = {'-' * 100_000}1"
    deep.cells.append(nbformat.v4.new_code_cell(source, metadata=of_name))
    hand_in(folder / "deep" / "toy.ipynb", deep)
    hand_in(folder / "unzipped" / "toy.ip\udcff", "")
    hand_in(folder / "locked" / "toy.ipynb", answer(**GOOD))
    copied = shutil.copyfile

    def copyfile(path, *more, **settings):
        if "locked" in path.parts:
            raise PermissionError(13, "Permission denied")
        return copied(path, *more, **settings)

    monkeypatch.setattr("mkt.course.labs.submissions.shutil.copyfile", copyfile)
    rows = graded(folder, toy / "grades.csv")
    assert {name: row["points"] for name, row in rows.items()} == {
        "ada": "3",
        "none": "3",
        "list": "3",
        "deep": "3",
        "unzipped": "",
        "locked": "",
    }
    assert rows["unzipped"]["note"] == "not a notebook: .ip\ufffd"
    assert rows["locked"]["note"] == "cannot be read: Permission denied"


def test_a_failure_in_looking_at_one_file_stops_no_other(toy, monkeypatch):
    read = grading.read_notebook

    def fails(path):
        if "Lovelace" in path.read_text(encoding="utf-8"):
            raise MemoryError
        return read(path)

    monkeypatch.setattr(grading, "read_notebook", fails)
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(why="Ada Lovelace"))
    hand_in(toy / "submitted" / "bob" / "toy.ipynb", answer(**GOOD))
    grading.grade(toy / "submitted", toy / "grades.csv", trusted=True)
    notes = {row["student"]: row["note"] for row in table.read(toy / "grades.csv")}
    assert notes["ada"].startswith(grading.OURS) and notes["bob"] == ""


def test_a_failure_of_ours_leaves_the_mark_empty_and_ends_in_exit_code_1(
    toy, monkeypatch
):
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(**GOOD))
    monkeypatch.setattr(grading.sandbox, "refusal", lambda: "")
    monkeypatch.setattr(grading.sandbox, "program", lambda: "/bin/false")
    monkeypatch.setattr("mkt.course.labs.judge.sys.executable", "/bin/false")
    troubles = grading.grade(toy / "submitted", toy / "grades.csv")
    assert len(troubles) == 1 and grading.OURS in troubles[0]
    monkeypatch.undo()
    text = (toy / "grades.csv").read_text(encoding="utf-8-sig")
    assert text.splitlines()[1].startswith("ada,toy,,,,")


@pytest.mark.skipif(os.name == "nt", reason="a script is no program there")
def test_a_box_that_may_not_be_made_says_why(tmp_path, monkeypatch):
    bwrap = tmp_path / "bwrap"
    bwrap.write_text(
        "#!/bin/sh\necho setting up uid map: Permission denied >&2; exit 1"
    )
    bwrap.chmod(0o755)
    monkeypatch.setattr(sandbox, "program", lambda: str(bwrap))
    with pytest.raises(ValueError, match="may not run: setting up uid map.*--trust"):
        grading.grade(tmp_path, tmp_path / "grades.csv")
    assert doctor.box().state == doctor.NOTE
    assert "Permission denied" in doctor.box().remedy


def test_without_a_box_nothing_runs_unless_the_students_are_trusted(toy, monkeypatch):
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(**GOOD))
    monkeypatch.setattr(sandbox, "program", lambda: None)
    with pytest.raises(ValueError, match=r"apt install bubblewrap; .*--trust-the-st"):
        grading.grade(toy / "submitted", toy / "grades.csv")
    assert not (toy / "grades.csv").exists()
    assert grading.grade(toy / "submitted", toy / "grades.csv", trusted=True) == []
