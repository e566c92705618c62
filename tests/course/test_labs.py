"""The labs: what solutions, empty labs and wrong answers get."""

import ast
import copy
import functools
import itertools
import re
import tomllib
from pathlib import Path

import nbformat
import numpy as np
import pytest

from mkt.course.book import checks
from mkt.course.labs import marks, notebooks
from mkt.course.labs.judge import Judge, names_of_others
from mkt.course.labs.notebooks import STUBS, name, of_role, points, released, role
from mkt.course.labs.student import (
    CHANGED,
    UNWRITTEN,
    Cell,
    Function,
    Student,
    TheirError,
)
from mkt.course.labs.values import lock
from mkt.evaluation import overlap
from mkt.histograms import coefficient
from mkt.particles import Particles
from mkt.scenes import rendering
from mkt.scenes.cards import card
from tests.lot import DAY

LABS = notebooks.labs()
each_lab = pytest.mark.parametrize("lab", LABS)


def answers_of(lab):
    """The file of what students might write in a lab."""
    return Path(__file__).parent / "labs" / f"{lab}.toml"


def might_write(lab, kind):
    """{title: what a student might write}: a "mistake", or what is "right".

    Empty where there is none, so that the tests of the other labs begin all the same.
    """
    path = answers_of(lab)
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    return {one["title"]: one for one in tomllib.loads(text).get(kind, [])}


def wrong_answers(lab):
    """{title: what a student might write, and which checks must notice it}."""
    return might_write(lab, "mistake")


def right_answers(lab):
    """{title: what a student might write, unlike the solution and as good}."""
    return might_write(lab, "right")


def returning_nothing(lab):
    """(title, cell, code) of each function to write, as if its return were forgotten.

    The title is what a check must say.
    """
    return [
        (
            f"{node.name} returns nothing: is there a `return`",
            cell,
            f"{solution.source}\n\n\ndef {node.name}(*_, **__):\n    pass",
        )
        for cell, solution in of_role(lab, "solution").items()
        for node in ast.parse(solution.source).body
        if isinstance(node, ast.FunctionDef)
    ]


@functools.cache
def tried(lab):
    """What failed in the empty lab, in the solved one, and with each other answer.

    As {title: {cell: words}}.
    """
    others = wrong_answers(lab) | right_answers(lab)
    return _tried(LABS[lab], answered_by_lot(lab), others)


def written(lab):
    """{function that students write: how many things it returns}."""
    return {
        node.name: max(
            len(one.value.elts) if isinstance(one.value, ast.Tuple) else 1
            for one in ast.walk(node)
            if isinstance(one, ast.Return)
        )
        for solution in of_role(lab, "solution").values()
        for node in ast.parse(solution.source).body
        if isinstance(node, ast.FunctionDef)
    }


def code(notebook, *roles):
    """The code cells of a notebook in these roles."""
    return [
        Cell(name(cell), cell.source)
        for cell in notebook.cells
        if cell.cell_type == "code" and role(cell) in roles
    ]


def judging(lab, notebook):
    """A judge of a lab for a notebook, and the student, who has to be closed."""
    student = Student(code(notebook, "solution", "given", None), 60, boxed=False)
    student.start()
    return Judge(code(lab, "given"), code(lab, "check"), student), student


def answered_by_lot(lab):
    """A lab with a right answer to each piece, its own or another; others each day."""
    notebook = copy.deepcopy(LABS[lab])
    for title, solution in of_role(notebook, "solution").items():
        others = [o["code"] for o in right_answers(lab).values() if o["cell"] == title]
        solution.source = [solution.source, *others][DAY % (1 + len(others))]
    return notebook


def _tried(lab, answered, others):
    judge, student = judging(lab, released(lab))
    with student:
        result = {"empty": student.failures | judge.verdicts()}
    judge, student = judging(lab, answered)
    with student:
        result["answered"] = student.failures | judge.verdicts()
        solution = {
            title: Cell(title, cell.source)
            for title, cell in of_role(lab, "solution").items()
        }
        for cell in solution.values():
            student.run(cell)
        result["solved"] = judge.verdicts()
        pieces = [(title, one["cell"], one["code"]) for title, one in others.items()]
        for title, cell, source in pieces + returning_nothing(lab):
            student.run(Cell(cell, source))
            result[title] = verdicts_below(lab, cell, judge)
            student.run(solution[cell])
    return result


def verdicts_below(lab, title, judge):
    """What the checks below a cell say; those above it see nothing of it."""
    names = [name(cell) for cell in lab.cells]
    below = {*names[names.index(title) :]}
    said = {one.name: judge.verdict(one) for one in judge.checks if one.name in below}
    return {check: words for check, words in said.items() if words}


@functools.cache
def tried_in_a_notebook(lab):
    """Which checks fail in a notebook with each other answer, as {title: {check}}.

    All cells run in one process there, as with nbgrader, and nothing is copied.
    """
    cells = {cell.name: cell for cell in code(LABS[lab], "solution", "given", "check")}
    checks = of_role(LABS[lab], "check")
    space = {}
    for cell in cells.values():
        exec(cell.source, space)
    result = {}
    for title, one in (wrong_answers(lab) | right_answers(lab)).items():
        names = [*cells]
        below = [c for c in names[names.index(one["cell"]) :] if c in checks]
        exec(one["code"], space)
        result[title] = {c for c in below if raises(cells[c].source, space)}
        exec(cells[one["cell"]].source, space)
    return result


def raises(source, space):
    """Whether a cell ends with an error."""
    try:
        with np.errstate(all="ignore"):
            exec(source, space)
    except Exception:
        return True
    return False


def lost(lab, failures):
    return [mark.check for mark in marks.marks(LABS[lab], failures) if mark.words]


def test_random_numbers_are_drawn_from_the_judges_and_no_others_are_sent():
    draw = "def draw(*rngs):\n    return sum(rng.random() for rng in rngs)"
    with Student([Cell("draw", draw)], 60, boxed=False) as student:
        drawn = Function(student, "draw", dict)
        for seed in range(20):
            rng, same = (np.random.default_rng(seed) for _ in range(2))
            assert drawn(rng, rng) == same.random() + same.random()
            assert rng.random() == same.random()
            assert student.generators == [rng]


def test_what_is_locked_arrives_locked_and_who_changes_it_is_told_what_to_do():
    change = "def change(crowd):\n    crowd.regions[0] += 1\n    return crowd.regions"
    with Student([Cell("change", change)], 60, boxed=False) as student:
        changed = Function(student, "change", dict)
        crowd = Particles(np.zeros((2, 5)), np.zeros((2, 2)))
        assert changed(crowd)[0].min() == 1 and crowd.regions.max() == 0
        lock(*crowd)
        with pytest.raises(TheirError, match=re.escape(CHANGED)):
            changed(crowd)


# Answers that are right but for a leading axis of no elements: those of one function,
# with arrays of at least so many axes, and of a tuple the one at that place.
EMPTYING = """
import numpy as np

asked = {{"name": "", "emptied": False}}


def empty(name="", place=0, axes=0):
    was = asked["emptied"]
    asked.update(name=name, place=place, axes=axes, emptied=False)
    return was


def emptied(value):
    if not isinstance(value, np.ndarray | np.floating) or value.ndim < asked["axes"]:
        return value
    asked["emptied"] = True
    return np.zeros((0, *value.shape))


def emptying(name, right):
    def answer(*args, **kwargs):
        value = right(*args, **kwargs)
        if name != asked["name"]:
            return value
        if isinstance(value, tuple):
            places = enumerate(value)
            return tuple(emptied(v) if k == asked["place"] else v for k, v in places)
        return value if asked["place"] else emptied(value)

    return answer


for name in {names}:
    globals()[name] = emptying(name, globals()[name])
"""


def passed_by_empty_answers(lab):
    """The checks that give their points for answers without elements.

    As (check, function, place in a tuple, axes, from which line on).
    """
    names = sorted(written(lab))
    last = Cell("emptying", EMPTYING.format(names=names))
    with Student([*code(lab, "solution", "given"), last], 60, boxed=False) as student:
        checks = code(lab, "check")
        judge = Judge(code(lab, "given"), [*checks, Cell("", "empty")], student)
        return [
            (check.name, *case)
            for check in checks
            for case in emptied_cases(lab, check)
            if passes(judge, check, *case)
        ]


def emptied_cases(lab, check):
    """Which answers a check may find empty, and from which line on."""
    for title in sorted(names_of_others([check]) & {*written(lab)}):
        for place, axes in itertools.product(range(written(lab)[title]), (0, 1)):
            for start in ("# ", "### BEGIN HIDDEN TESTS"):
                if start in check.source:
                    yield title, place, axes, start


def passes(judge, check, title, place, axes, start):
    """Whether a check says nothing though answers are empty from a line on."""
    call = f"empty({title!r}, {place}, {axes})\n{start}"
    said = judge.verdict(check._replace(source=check.source.replace(start, call, 1)))
    judge.student.allow()
    emptied = judge.space["empty"]()
    assert emptied or not said, said
    return emptied and not said


# The labs


@pytest.mark.slow
@each_lab
def test_the_solution_gets_full_marks(lab):
    assert tried(lab)["solved"] == {}


@pytest.mark.slow
@each_lab
def test_every_cell_runs_with_a_right_answer_to_each_piece(lab):
    """Which may change nothing below: other answers each day."""
    assert tried(lab)["answered"] == {}


@pytest.mark.slow
@each_lab
def test_the_empty_lab_gets_no_points_and_every_check_says_that_something_is_not_written(  # noqa: E501
    lab,
):
    given = marks.marks(LABS[lab], tried(lab)["empty"])
    assert [mark for mark in given if mark.points or mark.words != UNWRITTEN] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "lab, title", [(lab, title) for lab in LABS for title in wrong_answers(lab)]
)
def test_a_typical_wrong_answer_loses_its_points_and_no_others(lab, title):
    assert lost(lab, tried(lab)[title]) == wrong_answers(lab)[title]["loses"]


@pytest.mark.slow
@pytest.mark.parametrize(
    "lab, title",
    [
        (lab, title)
        for lab in LABS
        for title, one in wrong_answers(lab).items()
        if "told" in one
    ],
)
def test_a_wrong_answer_is_told_the_remedy(lab, title):
    told = wrong_answers(lab)[title]["told"]
    assert [words for words in tried(lab)[title].values() if told not in words] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "lab, title", [(lab, title) for lab in LABS for title in right_answers(lab)]
)
def test_a_right_answer_written_otherwise_gets_full_marks(lab, title):
    assert tried(lab)[title] == {}


@pytest.mark.slow
@each_lab
def test_a_notebook_refuses_what_the_judge_refuses(lab):
    """Also of answers that change what they are given: the judge gives copies."""
    said = tried(lab)
    assert {
        title: (failed, {*said[title]})
        for title, failed in tried_in_a_notebook(lab).items()
        if failed != {*said[title]}
    } == {}


@pytest.mark.slow
@pytest.mark.parametrize(
    "lab", [lab for lab in LABS if "my_name" in of_role(LABS[lab], "solution")]
)
def test_a_name_that_python_cannot_read_costs_one_point_and_stops_no_other_cell(lab):
    notebook = copy.deepcopy(LABS[lab])
    of_role(notebook, "solution")[
        "my_name"
    ].source = "def my_name():\n    return Li Wei"
    with Student(code(notebook, "solution", "given"), 60, boxed=False) as student:
        judge = Judge(code(notebook, "given"), code(notebook, "check"), student)
        assert [*student.failures] == ["my_name"]
        assert [*judge.verdicts()] == ["check_number"]


@pytest.mark.slow
@pytest.mark.parametrize("lab", [*LABS][DAY % 2 :: 2])
def test_an_answer_without_elements_gets_no_points(lab):
    """For numpy, no elements are all equal to whatever they are compared with."""
    assert passed_by_empty_answers(LABS[lab]) == []


@pytest.mark.slow
@each_lab
def test_a_forgotten_return_is_called_that(lab):
    words = {title: tried(lab)[title] for title, _, _ in returning_nothing(LABS[lab])}
    assert words
    assert [
        title
        for title, said in words.items()
        if not any(title in line for line in said.values())
    ] == []


@each_lab
def test_the_teachers_version_says_so_first_and_the_students_does_not(lab):
    assert (
        LABS[lab].cells[0].source.startswith("*The teacher's version, with solutions.")
    )
    assert "teacher's version" not in nbformat.writes(released(LABS[lab]))


@each_lab
def test_a_student_reads_nothing_of_a_clone_or_of_copies_that_only_the_authors_have(
    lab,
):
    text = nbformat.writes(released(LABS[lab]))
    assert "the clone" not in text and "our copy" not in text


@pytest.mark.slow
@each_lab
def test_the_empty_lab_has_no_faults_outside_its_checks(lab):
    assert marks.faults(LABS[lab], tried(lab)["empty"]) == []


@each_lab
def test_a_check_that_fails_says_its_sentence_without_a_traceback(lab):
    first = next(cell for cell in released(LABS[lab]).cells if cell.cell_type == "code")
    assert first.source.endswith("\n%xmode Minimal")


@each_lab
def test_every_lab_has_a_file_of_answers(lab):
    path = answers_of(lab)
    form = "its form is in CONTRIBUTING.md, under Add a lab"
    assert path.exists(), f"write tests/course/labs/{path.name}; {form}"


@each_lab
def test_every_lab_has_wrong_answers_and_right_ones_a_question_and_points(lab):
    assert len(wrong_answers(lab)) >= 3
    assert len(right_answers(lab)) >= 12
    written = {one["cell"] for one in right_answers(lab).values()}
    assert {*of_role(LABS[lab], "solution")} - written <= {"my_name"}
    assert of_role(LABS[lab], "question")
    assert all(
        points(cell) > 0 for cell in of_role(LABS[lab], "check", "question").values()
    )


@each_lab
def test_every_check_and_question_says_what_it_is_worth(lab):
    cells = released(LABS[lab]).cells
    silent = [
        name(cell)
        for above, cell in itertools.pairwise(cells)
        if role(cell) in ("check", "question")
        and f"{points(cell):g} point" not in above.source + cell.source
    ]
    assert silent == []


@each_lab
def test_every_question_says_to_the_teacher_what_its_points_are_for(lab):
    for cell in of_role(LABS[lab], "question").values():
        assert "*Points: one for " in cell.source
        assert "*Points: " not in nbformat.writes(released(LABS[lab]))


@each_lab
def test_a_question_and_the_place_for_its_answer_are_one_cell(lab):
    """Who writes an answer under the question has then written it in its place."""
    for cell in of_role(released(LABS[lab]), "question").values():
        title = f"## In your own words ({points(cell):g} points, read by a person)\n"
        assert cell.source.startswith(title)
        assert "?" in cell.source.partition(STUBS["markdown"])[0]


@each_lab
def test_the_empty_lab_has_neither_solutions_nor_hidden_tests(lab):
    text = nbformat.writes(released(LABS[lab]))
    assert "BEGIN " not in text and "END " not in text
    for cell in of_role(released(LABS[lab]), "solution", "question").values():
        assert STUBS[cell.cell_type].split("\n")[-1] in cell.source


@each_lab
def test_every_assertion_of_a_check_says_in_words_what_is_wrong(lab):
    wordless = [
        cell.id
        for cell in of_role(LABS[lab], "check").values()
        for node in ast.walk(ast.parse(cell.source))
        if isinstance(node, ast.Assert) and node.msg is None
    ]
    assert wordless == []


@each_lab
def test_a_lab_is_stored_clean(lab):
    ids = [cell.id for cell in LABS[lab].cells]
    assert checks.strip(LABS[lab]) == LABS[lab]
    assert len(set(ids)) == len(ids)


@each_lab
def test_nbgrader_makes_the_same_version_for_students(lab):
    preprocessors = pytest.importorskip("nbgrader.preprocessors")
    theirs = copy.deepcopy(LABS[lab])
    for step in (
        preprocessors.CheckCellMetadata,
        preprocessors.ClearSolutions,
        preprocessors.ClearHiddenTests,
        preprocessors.LockCells,
        preprocessors.ComputeChecksums,
    ):
        theirs, _ = step().preprocess(theirs, {})
    assert [cell for cell in theirs.cells if cell.id != "teacher"] == released(
        LABS[lab]
    ).cells


@each_lab
def test_the_judge_knows_which_functions_are_the_students(lab):
    assert names_of_others(code(LABS[lab], "given", "check")) == {*written(LABS[lab])}


# Pieces that have gone wrong, another one that calls them, and the latter's check.
BUILT_ON = [
    *(
        (
            "lab_6_hybrid_resampling",
            "def moved(centres, velocity, runs, walk):\n    return centres",
            "def spread_out(last, velocity, runs, tau, unit, uniform, l0=.4, g=.1):\n"
            "    walk = (l0 + g * tau) * unit * uniform\n"
            "    here = np.tile(last, (len(runs), 1))\n"
            "    return moved(here, tau * velocity, runs, walk)",
            check,
        )
        for check in ("check-width", "check-inertia")
    ),
    (
        "lab_7_servoing",
        "def error(s, goal):\n    return np.asarray(goal) - s",
        "def own_motion(e, before, L, v, dt):\n"
        "    return error(e, before) / dt - L @ v",
        "check-own",
    ),
    (
        "lab_8_plane_in_space",
        "def exponential(A):\n    return np.eye(3) - A\n"
        "def through(H, points):\n    return -points",
        "def velocity(G, points):\n"
        "    back, there = (through(exponential(h * G), points) for h in (-1e-5, 1e-5))"
        "\n    return (there - back) / 2e-5",
        "check_velocity",
    ),
    (
        "lab_8_plane_in_space",
        "def through(H, points):\n    return -points",
        "def divergence(G, points):\n"
        "    def flow(p):\n"
        "        back, there = (through(np.eye(3) + h * G, p) for h in (-1e-4, 1e-4))\n"
        "        return (there - back) / 2e-4\n"
        "    return sum((flow(points + 1e-3 * e) - flow(points - 1e-3 * e)) @ e / 2e-3"
        " for e in np.eye(2))",
        "check_divergence",
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize(
    "lab, wrong, piece, check", BUILT_ON, ids=[check for *_, check in BUILT_ON]
)
def test_what_is_built_on_a_piece_that_has_gone_wrong_keeps_its_points(
    lab, wrong, piece, check
):
    judge, student = judging(LABS[lab], LABS[lab])
    judged = next(one for one in judge.checks if one.name == check)
    with student:
        student.run(Cell("wrong", wrong))
        student.run(Cell("piece", piece))
        assert judge.verdict(judged) == ""


# What is written in one lab


def cell_of(lab, title):
    """The source of a cell."""
    return next(cell.source for cell in LABS[lab].cells if cell.id == title)


def executed(lab, *titles):
    """The names after some cells of a lab, without films."""
    space = {}
    for title in titles:
        exec(cell_of(lab, title).partition("mkt.play(")[0], space)
    return space


@pytest.mark.parametrize("n", [150, 300])
def test_lab_3_draws_the_share_of_as_many_particles_as_there_are(n):
    space = executed("lab_3_particle_filter", "imports")
    clip = space["mkt"].SCENES["hidden"](0).sequence()
    sizes = np.linspace(n, 1, len(clip))  # as `run` returns them
    space |= {"clip": clip, "estimates": clip.truth, "sizes": sizes}
    exec(cell_of("lab_3_particle_filter", "course"), space)
    _, share = space["ax"].lines
    assert np.allclose(share.get_ydata(), sizes / n)


def test_lab_4_prints_the_frames_of_which_its_text_speaks(capsys):
    lab = "lab_4_combining_both"
    executed(lab, "imports", "material")
    said = "more than half hidden in frames 44 to 52, wholly in 46 to 50"
    assert said in capsys.readouterr().out
    assert "from frame 46 on, for five frames" in cell_of(lab, "material-text")


@pytest.mark.slow
def test_lab_4_says_where_its_threshold_lies_and_how_little_it_matters():
    lab = "lab_4_combining_both"
    pieces = ("threshold", "optimise-now", "combined-step", "run")
    names = executed(lab, "imports", "material", "distances", *pieces)
    clip, ours = names["clip"], names["mkt"].Combined().threshold
    limit = names["threshold"](names["in_view"], names["in_hiding"])
    assert f"yours is {limit:.2f}".replace("0.", ".") in cell_of(lab, "threshold-read")
    assert names["in_view"].max() < ours < names["in_hiding"].min()
    for seed in range(3):
        walked = [names["run"](clip, one, seed)[1] > 0 for one in (ours, limit)]
        assert (walked[0] != walked[1]).sum() <= 3


@pytest.mark.slow
def test_lab_6_says_how_large_its_cloud_is_and_when_the_judge_says_hidden():
    lab = "lab_6_hybrid_resampling"
    names = executed(lab, *"imports size verdict moved spread filter pillars".split())
    clip = names["clip"]
    run = names["mkt"].track(names["Filter"](), clip, keep=("particles",))
    lost, shown = run.lost, clip.visibility > 0.5
    ends = np.flatnonzero(shown[1:] & ~shown[:-1]) + 1
    last_seen = [np.flatnonzero(~lost[:end])[-1] for end in ends]
    taus = ends - last_seen
    units = np.sqrt(run.regions[last_seen, 3] * run.regions[last_seen, 4])
    widths = 2 * (0.4 + 0.1 * taus) * units
    words = f"is {widths.min():.0f} to {widths.max():.0f} pixels wide"
    assert words in cell_of(lab, "pillars-predict")
    clouds = [np.ptp(run.info["particles"][end][:, 0]) for end in ends]
    words = f"{min(clouds):.0f} to {max(clouds):.0f} pixels from left to right"
    assert words in cell_of(lab, "pillars-predict")
    assert abs(taus.mean() - 25) < 1
    begins = np.flatnonzero(lost[1:] & ~lost[:-1]) + 1  # each at the rim of a pillar
    assert len(begins) == 3 and clip.visibility[begins].max() < 0.7


@pytest.fixture(scope="module")
def behind_a_car():
    """The names of lab 5 after its runs behind a car."""
    cells = ("imports", "half-life", "learn", "learner", "car", "drift")
    return executed("lab_5_adaptive_model", *cells)


@pytest.mark.slow
def test_who_keeps_the_first_model_and_who_learns_too_fast_lose_the_car_of_lab_5(
    behind_a_car,
):
    """As its question and the model answer have it."""
    car = behind_a_car["car"]
    runs = [behind_a_car[name] for name in ("stays", "hasty", "learns")]
    stays, hasty, learns = (overlap(run.regions, car.truth)[-20:] for run in runs)
    assert stays.max() < 0.05 < hasty.min() and hasty.max() < 0.2 and learns.min() > 0.4


@pytest.mark.slow
def test_the_hasty_tracker_of_lab_5_does_not_notice_and_its_first_model_would(
    behind_a_car,
):
    car, hasty = behind_a_car["car"], behind_a_car["hasty"]
    tracker = behind_a_car["Learner"]()
    first = tracker.learn(car.frames[0], car.truth[0]).q
    image = tracker.bins(car.frames[-1])
    places = np.array([hasty.regions[-1], car.truth[-1]])
    left, right = coefficient(tracker.disc.histograms(image, places), first)
    assert np.nanmin(hasty.info["rho"]) > 0.9 and hasty.info["rho"][-20:].min() > 0.97
    assert left < 0.2 and right > 0.6


def test_lab_8_has_one_name_for_each_motion_in_its_table_figures_and_messages():
    lab = "lab_8_plane_in_space"
    header = cell_of(lab, "exponential-text").split("| | ")[1].split(" |\n")[0]
    names = header.replace("$", "").replace("\\", "").split(" | ")
    assert f"MOTIONS = {tuple(names)}".replace("'", '"') in cell_of(lab, "material")
    assert "PARAMETERS" not in nbformat.writes(LABS[lab])


@pytest.mark.slow
def test_lab_8_says_how_far_its_cards_tilt():
    lab = "lab_8_plane_in_space"
    right_tilt = executed(lab, "imports", "tilt")["tilt"]
    most = max(np.degrees(steepest(seed, right_tilt)) for seed in range(2000, 2060))
    said = re.search(r"up to some (\d+) degrees in all", cell_of(lab, "track-text"))
    assert said and abs(int(said[1]) - most) < 10


def steepest(seed, tilt):
    """The largest tilt [rad] of a card of lab 8, every tenth frame."""
    scene = card("base", seed)
    frames = np.arange(0, scene.length, 10)
    camera = np.array([[scene.focal, 0, 159.5], [0, scene.focal, 119.5], [0, 0, 1]])
    homographies = rendering.homographies(scene, scene.target, frames)
    return max(tilt(H, camera) for H in homographies)
