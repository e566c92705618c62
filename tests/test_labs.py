"""The labs: solutions get full marks, empty ones none, wrong ones lose what they should; and the commands survive whatever is handed in."""

import ast
import asyncio
import copy
import csv
import functools
import json
import tomllib
from pathlib import Path

import nbformat
import pytest

from mkt import cli
from mkt.book import checks
from mkt.labs import grading, notebooks
from mkt.labs.kernel import UNWRITTEN, kernel, run
from mkt.labs.notebooks import STUBS, of_role, points, released

LABS = notebooks.labs()
each_lab = pytest.mark.parametrize("lab", LABS)


def wrong_answers(lab):
    """{title: what a student might write, and which checks must notice}, from tests/labs."""
    path = Path(__file__).parent / "labs" / f"{lab}.toml"
    mistakes = tomllib.loads(path.read_text(encoding="utf-8"))["mistake"] if path.is_file() else []
    return {mistake["title"]: mistake for mistake in mistakes}


@functools.cache
def tried(lab):
    """What failed in the empty lab, in the solved one, and with each wrong answer in its turn: {title: {cell: words}}, all in one kernel."""
    return asyncio.run(_tried(LABS[lab], wrong_answers(lab)))


async def _tried(lab, mistakes):
    async with kernel() as client:
        result = {"empty": await run(client, released(lab).cells), "solved": await run(client, lab.cells)}
        for title, mistake in mistakes.items():
            solution = of_role(lab, "solution")[mistake["cell"]]
            result[title] = await run(client, [nbformat.from_dict(solution | {"source": mistake["code"]}), *of_role(lab, "check").values()])
            await run(client, [solution])
        return result


def lost(lab, failures):
    return [mark.check for mark in grading.marks(LABS[lab], LABS[lab], failures) if mark.words]


# The labs

@each_lab
def test_the_solution_gets_full_marks_and_every_cell_of_it_runs(lab):
    assert tried(lab)["solved"] == {}


@each_lab
def test_the_empty_lab_gets_no_points_and_every_check_says_that_something_is_not_written(lab):
    marks = grading.marks(LABS[lab], LABS[lab], tried(lab)["empty"])
    assert [mark for mark in marks if mark.points or mark.words != UNWRITTEN] == []


@pytest.mark.parametrize("lab, title", [(lab, title) for lab in LABS for title in wrong_answers(lab)])
def test_a_typical_wrong_answer_loses_its_points_and_no_others(lab, title):
    assert lost(lab, tried(lab)[title]) == wrong_answers(lab)[title]["loses"]


@each_lab
def test_every_lab_has_wrong_answers_a_question_and_points(lab):
    assert len(wrong_answers(lab)) >= 3
    assert of_role(LABS[lab], "question")
    assert all(points(cell) > 0 for cell in of_role(LABS[lab], "check", "question").values())


@each_lab
def test_the_empty_lab_has_neither_solutions_nor_hidden_tests(lab):
    text = nbformat.writes(released(LABS[lab]))
    assert "BEGIN " not in text and "END " not in text
    for cell in of_role(released(LABS[lab]), "solution", "question").values():
        assert STUBS[cell.cell_type].split("\n")[-1] in cell.source


@each_lab
def test_every_assertion_of_a_check_says_in_words_what_is_wrong(lab):
    wordless = [cell.id for cell in of_role(LABS[lab], "check").values() for node in ast.walk(ast.parse(cell.source))
                if isinstance(node, ast.Assert) and node.msg is None]
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
    for step in (preprocessors.CheckCellMetadata, preprocessors.ClearSolutions, preprocessors.ClearHiddenTests, preprocessors.LockCells):
        theirs, _ = step().preprocess(theirs, {})
    assert theirs.cells == released(LABS[lab]).cells
