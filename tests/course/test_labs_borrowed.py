"""Who calls ready-made functions is told so, and nobody else is."""

import copy
import tomllib
from pathlib import Path

import nbformat
import pytest

from mkt.course.labs import grading
from mkt.course.labs.borrowed import LONG, USES, borrowed
from mkt.course.labs.notebooks import labs, name, released
from tests.course.toy_lab import GOOD, answer, graded, hand_in

LABS = labs()
KNOWN = Path(__file__).parent / "labs"
CALLS = [
    # The second function that a cell of the lab defines.
    ("lab_1_histograms_and_kernels", "compare", "far(q, x)", "far"),
    (
        "lab_3_particle_filter",
        "systematic",
        "library.systematic(w, u)",
        "library.systematic",
    ),
    ("lab_4_combining_both", "typical_error", "mkt.errors(a, b)", "mkt.errors"),
    ("lab_4_combining_both", "combined_step", "mkt.ColorBins()(f)", "mkt.ColorBins"),
    ("lab_8_plane_in_space", "exponential", "expm(A)", "expm"),
    ("lab_8_plane_in_space", "velocity", "by_a_hair(G, points)", "by_a_hair"),
    ("lab_8_plane_in_space", "tilt", "pieces.tilt(H, C)", "pieces.tilt"),
]
# In other words than a call of what the lab has imported.
HIDDEN = [
    ("moved", "from mkt.homographies import moved as m\n\nmoved = m", "m"),
    ("through", "through = library.through", "library.through"),
    ("exponential", "exponential = expm", "expm"),
    ("exponential", "from scipy.linalg import expm as e\n\nexponential = e", "e"),
    (
        "through",
        "def through(*x):\n    import mkt.homographies as h\n    return h.through(*x)",
        "h.through",
    ),
    (
        "moved",
        "def moved(*x):\n    f = library.moved\n    return f(*x)",
        "library.moved",
    ),
    # An import is enough, from either lender, by whatever way.
    ("moved", "from mkt.homographies import moved", "mkt.homographies.moved"),
    ("through", "from mkt.homographies import *", "mkt.homographies.*"),
    (
        "exponential",
        "import scipy.linalg\n\ndef exponential(A):\n    return scipy.linalg.expm(A)",
        "scipy.linalg.expm",
    ),
]
# Where a cell of the student's own imports it: (that cell, the piece, who uses what).
ELSEWHERE = [
    (
        "from mkt.homographies import moved as m",
        "def moved(*x):\n    return m(*x)",
        "moved: uses m",
    ),
    ("import scipy.linalg as s", "moved = s.expm", "moved: uses s.expm"),
    (
        "from mkt.homographies import moved",
        "",
        "cell own: uses mkt.homographies.moved",
    ),
    (
        "from mkt.homographies import *",
        "",
        "cell own: uses mkt.homographies.*",
    ),
    ("from mkt.homographies import moved as theirs", "", None),
    ("from .mkt import moved", "", None),
]


def solved(title, cell_name, code):
    """The lab with all of its solutions but one, which is another."""
    lab = copy.deepcopy(LABS[title])
    (cell,) = (cell for cell in lab.cells if name(cell) == cell_name)
    cell.source = code
    return lab


@pytest.mark.parametrize("title, cell, call, lent", CALLS)
def test_a_solution_by_a_call_of_what_is_there_is_told(title, cell, call, lent):
    found = borrowed(LABS[title], solved(title, cell, f"def f(*x):\n    return {call}"))
    assert found == [USES.format(cell, lent)]
    made = lent.partition(".")[0]
    for own in (f"def f({made}, *x):\n    return {call}", f"{call} is no Python"):
        assert borrowed(LABS[title], solved(title, cell, own)) == []


@pytest.mark.parametrize("cell, code, used", HIDDEN)
def test_so_is_what_is_imported_renamed_or_handed_on(cell, code, used):
    title = "lab_8_plane_in_space"
    found = borrowed(LABS[title], solved(title, cell, code))
    assert found == [USES.format(cell, used)]


@pytest.mark.parametrize("imports, code, said", ELSEWHERE)
def test_so_is_what_a_cell_of_ones_own_imports(imports, code, said):
    lab = LABS["lab_8_plane_in_space"]
    mine = solved("lab_8_plane_in_space", "moved", code)
    mine.cells.insert(1, nbformat.v4.new_code_cell(imports, id="own"))
    expected = [USES.format(*said.split(": uses "))] if said else []
    assert borrowed(lab, mine) == expected


@pytest.mark.parametrize("decoy", ["", "def moved(*x):\n    return 1"])
def test_a_second_cell_of_the_same_name_hides_nothing(decoy):
    lab = LABS["lab_8_plane_in_space"]
    mine = solved("lab_8_plane_in_space", "moved", "moved = library.moved")
    (cell,) = (cell for cell in mine.cells if name(cell) == "moved")
    again = copy.deepcopy(cell)
    again.source = decoy
    mine.cells.append(again)
    said = [USES.format("moved", "library.moved")]
    assert borrowed(lab, mine) == said


@pytest.mark.parametrize("more, told", [(9_995, False), (9_996, True)])
def test_of_a_cell_that_is_too_long_to_read_it_is_told(more, told):
    mine = solved("lab_8_plane_in_space", "moved", "x = 1" + more * "#")
    said = borrowed(LABS["lab_8_plane_in_space"], mine)
    assert said == ([LONG.format("moved")] if told else [])


def test_what_python_cannot_read_stops_nobody():
    deep = f"x = {'-' * 9_000}1"
    mine = solved("lab_8_plane_in_space", "moved", deep)
    assert borrowed(LABS["lab_8_plane_in_space"], mine) == []


@pytest.mark.parametrize("title", LABS)
def test_nobody_else_is_named(title):
    lab = LABS[title]
    assert borrowed(lab, lab) == borrowed(lab, released(lab)) == []
    known = tomllib.loads((KNOWN / f"{title}.toml").read_text(encoding="utf-8"))
    for right in known["right"]:
        mine = solved(title, right["cell"], right["code"])
        found = borrowed(lab, mine)
        assert len(found) == ("scipy" in right["code"])
        assert borrowed(released(lab), mine) == found  # as `labs check` tells it
    assert borrowed(released(lab), lab) == []


@pytest.mark.slow
def test_the_note_of_a_row_has_it(toy, monkeypatch):
    monkeypatch.setattr(grading, "borrowed", lambda lab, notebook: ["add: calls it"])
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(**GOOD))
    row = graded(toy / "submitted", toy / "grades.csv")["ada"]
    assert "add: calls it" in row["note"].splitlines()
