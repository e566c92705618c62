"""The text of chapters as a reader checks it: worked answers, and numbers in prose.

A chapter's worked answers are the blocks of code in its text.  Its numbers are those
that stand in sentences; a number is *held* where a cell of the chapter, or an answer,
puts out the same one, rounded as in the text.  Numbers of folded answers, which come
from figures, are put out by a last cell, "numbers", which the page leaves out.
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import nbformat

from mkt.course.book import checks, depends, execute
from mkt.course.book.contents import Chapter
from tests.lot import DAY

BLOCK = re.compile(r"^```python\n(.*?)^```", re.M | re.S)
# What is no sentence: code, formulas, names of files, tags, headings, words for places.
NO_PROSE = re.compile(
    r"```.*?```|\$\$.*?\$\$|\$[^$]*\$|`[^`]*`|\]\([^)]*\)|<[^>]*>|^#.*?$"
    r"|\*\*\d+\.\*\*|(?:chapters?|figures?|table|lab|exercise|frames?|seeds?|run|row|"
    r"scene|section|equations?|Algorithms?|to) [\d.,()]+(?:(?: and | to |, )\(?\d+\)?)*"
    r"|\(\d+\)|\[\w+\]|\b[TNC]\d\d-\w\b|\b(?:19|20)\d\d\b",
    re.M | re.S | re.I,
)
NUMBER = re.compile(r"(?<![\w.])(?:\d+\.\d+|\.\d+|\d{2,})(?![\w])")
PUT_OUT = re.compile(r"(?<![\w.])-?\d*\.?\d+(?:e[-+]?\d+)?")


def answers(notebook: nbformat.NotebookNode) -> list[tuple[str, str]]:
    """The id of its cell and the code of each worked answer."""
    return [
        (cell.id, block)
        for cell in notebook.cells
        if cell.cell_type == "markdown"
        for block in BLOCK.findall(cell.source)
    ]


def of_today(chapters: Sequence[Chapter]) -> Sequence[Chapter]:
    """Every second chapter, and tomorrow the others.

    Answers, and the cells that hold numbers of the prose, take a quarter of the time
    of all chapters.
    """
    return chapters[DAY % 2 :: 2]


def with_answers(chapter: Chapter, folder: Path) -> Chapter:
    """A chapter that goes on with its answers as cells, in a folder.

    All of its cells are run, those too that the page leaves out.
    """
    notebook = checks.strip(nbformat.read(chapter.notebook, 4))
    for cell in notebook.cells:
        cell.metadata.pop("tags", None)
    notebook.cells += [
        nbformat.v4.new_code_cell(block, id=f"{cell}-{k}")
        for k, (cell, block) in enumerate(answers(notebook))
    ]
    path = folder / chapter.notebook.name
    nbformat.write(notebook, path)
    return replace(chapter, notebook=path, timeout=3 * chapter.timeout)


def executed(chapters: Sequence[Chapter], folder: Path) -> dict:
    """The chapters with their answers, executed.

    What came out before the answers is the chapter alone, and is kept as that.
    """
    answered = execute.execute_all([with_answers(each, folder) for each in chapters])
    for chapter in chapters:
        alone = checks.strip(nbformat.read(chapter.notebook, 4))
        key = depends.of_chapter(alone, execute.ARGUMENTS)
        known = execute.with_outputs(alone, answered[chapter.name])
        execute.CHAPTERS.put(key, known)
    return answered


def outputs(notebook: nbformat.NotebookNode) -> str:
    """All that an executed notebook puts out as text, but for its figures."""
    shown = {cell.id for cell, _ in checks.figure_cells(notebook)}
    texts = []
    for cell in checks.code_cells(notebook):
        for output in cell.outputs if cell.id not in shown else []:
            data = output.get("data", {})
            texts.append(output.get("text") or data.get("text/plain", ""))
    return "\n".join(texts)


def in_prose(notebook: nbformat.NotebookNode) -> list[tuple[str, str]]:
    """The id of its cell and each number that stands in a sentence."""
    return [
        (cell.id, number)
        for cell in notebook.cells
        if cell.cell_type == "markdown"
        for number in NUMBER.findall(NO_PROSE.sub(" ", cell.source))
    ]


def is_held(number: str, values: list[float]) -> bool:
    """Whether a number is one of the values, rounded to its digits.

    A share may stand in a sentence as a percentage.
    """
    digits = len(number.partition(".")[2])
    allowed = 0.5001 * 10**-digits
    return any(
        abs(abs(value) * factor - float(number)) <= allowed
        for value in values
        for factor in (1, 100)
    )


def values_of(text: str) -> list[float]:
    """All numbers in what cells put out."""
    return [float(number) for number in PUT_OUT.findall(text)]
