"""A tracker from a file of the user's own, in every command that takes a tracker."""

import sys
from functools import partial

import pytest
from joblib.externals.loky import get_reusable_executor

from mkt.course import cli, own_tracker
from mkt.experiments import leaderboard
from mkt.sequences.video import VideoFile
from mkt.trackers import by_name
from tests.own_video import films

CODE = """
from dataclasses import dataclass, field
import numpy as np
from mkt import report

@dataclass(frozen=True)
class Still:
    shift: float = 0.0

    def init(self, frame, region, rng):
        return region + [self.shift, 0, 0, 0, 0]

    def step(self, state, frame, rng):
        return state, report(state, 0.1, False, 1)

@dataclass(frozen=True)
class Silent(Still):
    def step(self, state, frame, rng):
        return state, {"region": state, "score": 1.0, "lost": False}

@dataclass(frozen=True)
class Stumbling(Still):
    def step(self, state, frame, rng):
        return state["nothing"]

@dataclass(frozen=True)
class Empty(Still):
    def step(self, state, frame, rng):
        pass

@dataclass(frozen=True)
class Bare(Still):
    def step(self, state, frame, rng):
        return state, {"region": state, "lost": False}

@dataclass(frozen=True)
class Short(Still):
    def step(self, state, frame, rng):
        return state, report(state[:4], 0.1, False, 1)

@dataclass(frozen=True)
class Late(Still):
    def step(self, state, frame, rng):
        if state[0] > 82:
            int("one")
        return state + [1, 0, 0, 0, 0], report(state, 0.1, False, 1)

@dataclass(frozen=True)
class Wrong(Still):
    def init(self, frame, region, rng):
        return np.zeros(3) + np.zeros(4)

@dataclass(frozen=True)
class Forgetful(Still):
    def step(self, state, frame):
        return state, report(state, 0.1, False, 1)

@dataclass(frozen=True)
class Curt(Still):
    def init(self, r):
        return r

@dataclass(frozen=True)
class Fields:
    init: int = 1
    step: int = 2

@dataclass(frozen=True)
class Listing(Still):
    shift: list = field(default_factory=list)

class Loose(Still):
    def __init__(self, shift): pass

moved = Still(shift=50.0)
words = "no tracker"
"""


@pytest.fixture
def own(tmp_path, monkeypatch):
    """A folder with a module of trackers, from which Python runs."""
    (tmp_path / "resting.py").write_text(CODE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield tmp_path
    for name in [name for name in by_name.TRACKERS if ":" in name]:
        del by_name.TRACKERS._entries[name], by_name.LABELS[name]
    for name in "resting", "mistaken":
        sys.modules.pop(name, None)


def run(*words):
    return cli.run(cli.parse([*map(str, words)])) or 0


def tried(own, name, output, frames=3):
    """Track a car by a class of the module."""
    films.write(own / "car.mkv", films.driving(frames).frames)
    words = ("--box", "55,48,50,24", "--tracker", f"resting:{name}")
    run("track", "car.mkv", *words, *(("-o", output) if output else ()))


def test_it_tracks_and_does_so_again_when_it_is_said_again(own):
    films.write(own / "car.mkv", films.driving(4).frames)
    box = ("--box", "55,48,50,24")
    run("track", "car.mkv", *box, "--tracker", "resting:moved", "-o", "a.mkv")
    settings = ("track", "--settings", "a.json")
    run(*settings, "--tracker", "resting:moved", "-o", "b.mkv")
    assert (own / "a.csv").read_text() == (own / "b.csv").read_text()
    cells = (own / "a.csv").read_text().splitlines()[2].split(",")
    assert float(cells[1]) == 55 + 25 - 0.5 + 50


def test_settings_of_another_tracker_are_refused(own):
    films.write(own / "car.mkv", films.driving(3).frames)
    run("track", "car.mkv", "--box", "55,48,50,24", "--tracker", "ssd", "-o", "a.csv")
    other = ("--tracker", "resting:Still", "-o", "b.csv")
    with pytest.raises(SystemExit, match="a.json is of ssd; leave --tracker out"):
        run("track", "--settings", "a.json", *other)
    assert not (own / "b.csv").exists()


def test_a_file_alone_names_no_code_that_is_run(own):
    tried(own, "Still", "a.mkv")
    del by_name.TRACKERS._entries["resting:Still"], by_name.LABELS["resting:Still"]
    said = "a.json: made with a tracker of your own.*--tracker resting:Still"
    with pytest.raises(SystemExit, match=said):
        run("track", "--settings", "a.json", "-o", "b.mkv")


@pytest.mark.slow
def test_it_is_drawn_where_a_figure_has_a_choice_and_only_there(own):
    tracker = ("--tracker", "resting:Still")
    run("figure", "own.run", "-o", "run.csv", *tracker)
    assert "tracker=resting:Still" in (own / "run.csv").read_text()
    with pytest.raises(SystemExit, match="own.run shows one of your own"):
        run("figure", "teuliere2009.fig6", "-o", "x.csv", *tracker)


@pytest.mark.slow
def test_it_stands_on_the_board(own, monkeypatch, capsys):
    few = partial(leaderboard.synthetic, processes=1, kinds=["base"])
    alone = partial(leaderboard.write_tracks, processes=1)
    monkeypatch.delenv("MKT_DATA", raising=False)
    monkeypatch.setattr(leaderboard, "synthetic", few)
    monkeypatch.setattr(leaderboard, "write_tracks", alone)
    words = ("ssd", "--tracker", "resting:Still", "--seeds", "0:2", "--tracks", "t")
    run("bench", "tracking", *words)
    assert "resting:Still" in capsys.readouterr().out
    names = {path.name for path in (own / "t").glob("resting_Still-*")}
    both = {f"resting_Still-base-{seed}" for seed in (0, 1)}
    assert names == {f"{name}{ending}" for name in both for ending in (".csv", ".txt")}


def test_what_fails_while_it_runs_is_told_with_its_line(own):
    with pytest.raises(SystemExit) as stopped:
        tried(own, "Stumbling", "a.mkv")
    line = 1 + CODE.splitlines().index('        return state["nothing"]')
    assert f"resting.py, line {line}: IndexError: " in stopped.value.code
    assert "correct it there" in stopped.value.code


def test_a_fault_of_the_library_s_own_is_not_called_the_user_s(own):
    """Of a tracker that is an object of its class, it has no line to correct."""
    code = "from mkt.trackers.ssd import SSD\n\nplain = SSD()\n"
    (own / "mistaken.py").write_text(code)
    tracker = by_name.TRACKERS[own_tracker.enter("mistaken:plain")]
    with pytest.raises(Exception) as failed:
        tracker.step(None, None, None)
    assert own_tracker.failed(failed.value) is None


@pytest.mark.parametrize(
    "name, said",
    [
        ("Empty", r"Empty.step must return \(state, info\).*; it returned None"),
        ("Bare", "Bare.step: its info has no 'score'; make it with mkt.report"),
        ("Short", r"Short.step: its region has the shape \(4,\)"),
        ("Wrong", "resting.py, line .*could not be broadcast.*; correct it there"),
    ],
)
def test_what_it_returns_is_looked_at_and_nothing_is_left_of_a_try(own, name, said):
    with pytest.raises(SystemExit, match=said):
        tried(own, name, "a.mkv")
    assert not [*own.glob("a.*")]


def test_a_slip_has_its_line_and_what_was_found_before_it_is_named(own):
    with pytest.raises(SystemExit) as stopped:
        tried(own, "Late", "a.csv", frames=8)
    line = 1 + CODE.splitlines().index('            int("one")')
    said, note = stopped.value.code.splitlines()
    assert f"resting.py, line {line}: ValueError: invalid literal" in said
    rows = (own / "a.csv").read_text().splitlines()
    assert note.startswith(
        f"Of {len(rows) - 1} frames, what could be written is in a.csv, a.json."
    )


FAILING = """
from dataclasses import dataclass
from mkt import report

class Odd(Exception):
    def __init__(self, one, two):
        super().__init__(one + two)

@dataclass(frozen=True)
class Failing:
    def init(self, frame, region, rng):
        return region, 0

    def step(self, state, frame, rng):
        region, k = state
        if k == 3:
            {}
        return (region, k + 1), report(region, 0.1, False, 1)
"""


@pytest.fixture
def failing(own, monkeypatch):
    """A function that writes a tracker which fails in its fourth step, anew each time.

    The processes for it start after it has been written.
    """
    monkeypatch.delenv("MKT_DATA", raising=False)

    def write(how):
        (own / "mistaken.py").write_text(FAILING.format(how))
        get_reusable_executor().shutdown()

    yield write
    get_reusable_executor().shutdown()


BOARD = ("bench", "tracking", "--seeds", "1000:1001", "mistaken:Failing")
FIGURE = ("figure", "own.run", "-o", "x.png", "--tracker", "mistaken:Failing")


@pytest.mark.slow
@pytest.mark.parametrize(
    "words, how, said",
    [
        (BOARD, "1 / 0", "ZeroDivisionError: division by zero"),
        (BOARD, "raise ValueError('mine')", "ValueError: mine"),
        (BOARD, "raise Odd('o', 'dd')", "RuntimeError: Odd: odd"),
        (FIGURE, "1 / 0", "ZeroDivisionError: division by zero"),
        (FIGURE, "report([1])", "TypeError: report.. missing 3"),
    ],
    ids=["board", "board, value", "board, odd", "figure", "figure, type"],
)
def test_what_fails_in_another_process_or_a_figure_has_its_line_too(
    failing, words, how, said
):
    failing(how)
    with pytest.raises(SystemExit, match=f"mistaken.py, line 17: {said}.*correct it"):
        run(*words)


@pytest.mark.slow
def test_what_the_library_refuses_in_another_process_is_a_sentence(failing):
    failing("report([1, 2, 3, 4, float('nan')], 0.1, False, 1)")
    with pytest.raises(SystemExit, match="^mkt bench: the estimate .* is not finite"):
        run(*BOARD)


def test_its_name_makes_the_name_of_a_file(own, capsys):
    tried(own, "Still", None)
    assert "car-resting_Still.webm" in capsys.readouterr().out
    films.write(own / "a:b.mkv", films.driving(3).frames)
    assert len(VideoFile(own / "a:b.mkv")) == 3


@pytest.mark.parametrize("words", [("bench", "tracking"), ("track", "x.mkv")])
def test_a_name_without_its_module_is_told_what_one_of_ones_own_looks_like(own, words):
    said = "no tracker 'Still'; there are .*one of your own is MODULE:CLASS"
    with pytest.raises(SystemExit, match=said):
        run(*words, "--tracker", "Still")


def test_what_a_board_would_miss_is_said_before_the_runs(own):
    with pytest.raises(SystemExit, match="resting:Silent: its info has no evaluations"):
        run("bench", "tracking", "resting:Silent")


@pytest.mark.parametrize(
    "name, said",
    [
        ("resting:Nothing", "no attribute 'Nothing'"),
        ("nowhere:Still", "No module named 'nowhere'"),
        ("resting:Loose", "missing 1 required positional argument"),
        ("resting:words", "is not a tracker"),
        ("resting:Fields", "is not a tracker"),
        ("resting:Listing", "unhashable type: 'list'; take a tuple for a list"),
        (
            "resting:Forgetful",
            r"step takes \(state, frame\); write it with \(self, state, frame, rng\)",
        ),
        (
            "resting:Curt",
            r"init takes \(r\); write it with \(self, frame, region, rng\), as it",
        ),
        (":", "give the tracker as module:Class"),
    ],
)
def test_what_is_no_tracker_is_refused_in_a_sentence(own, name, said):
    with pytest.raises(ValueError, match=said):
        own_tracker.enter(name)


MISTAKEN = """
from dataclasses import dataclass

@dataclass(frozen=True)
class Hasty:
    def __post_init__(self):
        int("one")
"""
NOTED = "e = ValueError('mine')\ne.add_note('first\\nsecond')\nraise e\n"
LEAVING = MISTAKEN.replace('int("one")', "raise SystemExit")


@pytest.mark.parametrize(
    "code, name, said",
    [
        ("x = 1\ndef f(:\n", "T", "line 2: SyntaxError: invalid syntax; correct it"),
        ("\nx = nothing\n", "T", "line 2: NameError: name 'nothing' is not defined;"),
        ("import resting\n1 / 0\n", "T", "line 2: ZeroDivisionError: division by zero"),
        ("import nowhere\n", "T", "line 1: ModuleNotFoundError: No module named"),
        ("import json\n\njson.loads('[')\n", "T", "line 3: json.* Expecting value"),
        (MISTAKEN, "Hasty", "line 7: ValueError: invalid literal for int"),
        ("import sys\nsys.exit(0)\n", "T", "line 2: SystemExit: 0; correct it there"),
        (LEAVING, "Hasty", "line 7: SystemExit; correct it there"),
        (NOTED, "T", "line 3: ValueError: mine; correct it there"),
    ],
    ids="syntax name error import below made exit exit,made noted".split(),
)
def test_a_mistake_in_it_is_the_user_s_and_has_its_line(own, code, name, said):
    (own / "mistaken.py").write_text(code)
    words = ("--box", "9,9,20,20", "--tracker", f"mistaken:{name}")
    with pytest.raises(SystemExit, match=f"^mkt track: .*mistaken.py, {said}"):
        run("track", "car.mkv", *words)
