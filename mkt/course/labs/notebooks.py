"""What a lab is: a notebook whose cells carry nbgrader's metadata, in four roles.

========  ===================  ====================================================
role      nbgrader's metadata  in the student's version
========  ===================  ====================================================
solution  solution             a stub replaces what stands between the marks
check     grade, locked        without its hidden tests; cannot be edited
question  solution, grade      a text cell: a stub replaces the model answer, and a
                               person reads the student's
given     locked               the same, but cannot be edited
========  ===================  ====================================================

All other cells are the student's own to change; the cell with the id "teacher", which
says whose version this is, is left out.
"""

import copy
import hashlib
import re
import shutil
from pathlib import Path

import nbformat
from nbformat import NotebookNode

from mkt.course.labs import LIMIT
from mkt.course.labs.source import first, functions, imported, used
from mkt.files import NOTEBOOKS, whole

FOLDER = NOTEBOOKS / "labs"  # the teacher's versions
HANDOUT = FOLDER.with_name("handout")  # the students', where JupyterLab shows them
# As they were released, in a handout, which has no teacher's versions; a folder that
# JupyterLab does not show, so that nobody works in it.
ORIGINALS = HANDOUT / ".originals"
# Those of nbgrader; what is said when the first one is run is ours.
STUBS = {
    "code": "# YOUR CODE HERE\nraise NotImplementedError('not written yet')",
    "markdown": "YOUR ANSWER HERE",
}
MAY_USE = "mkt_may_use"  # in the metadata of a lab without its solutions
CONFIGURATION = """\
import os

# A check that writes to the standard error, as a warning does, would have no points.
os.environ["PYTHONWARNINGS"] = "ignore"
c = get_config()
c.CourseDirectory.course_id = "mkt"
c.ClearSolutions.code_stub = {{"python": {stub!r}}}
c.ExecutePreprocessor.timeout = {limit}
c.ExecutePreprocessor.interrupt_on_timeout = True  # and go on with the next cell
"""
# Not the marks of a solution or of hidden tests, which look like headings.
_HEADING = r"^#{1,6} (?!(?:BEGIN|END) )(.+)$"
# By nbgrader's "solution", "grade" and "locked".
_ROLES = {
    (True, False, False): "solution",
    (False, True, True): "check",
    (True, True, False): "question",
    (False, False, True): "given",
}


def labs() -> dict[str, NotebookNode]:
    """The labs with their solutions, {name: notebook}, in order."""
    return _read(FOLDER)


def originals() -> dict[str, NotebookNode]:
    """The labs as students get them, also where their solutions are not."""
    found = labs() or _read(ORIGINALS)
    return {title: released(lab) for title, lab in found.items()}


def _read(folder: Path) -> dict[str, NotebookNode]:
    return {
        path.stem: nbformat.read(path, 4) for path in sorted(folder.glob("*.ipynb"))
    }


def solved() -> dict[str, NotebookNode]:
    """The same as `labs`; ValueError where there are none, as in a handout."""
    if known := labs():
        return known
    raise ValueError(
        f"{FOLDER}: there are no labs with their solutions; a teacher's clone has them"
    )


def role(cell: NotebookNode) -> str | None:
    """The role of a cell (see the module's text), or None."""
    meta = _nbgrader(cell)
    solution, grade, locked = (
        bool(meta.get(key)) for key in ("solution", "grade", "locked")
    )
    return _ROLES.get((solution, grade, locked))


def name(cell: NotebookNode) -> str:
    """What a cell is called in reports: its grade_id, or "cell" and its id.

    The latter has a blank in it, so that it cannot pass for a grade_id.
    """
    title = _nbgrader(cell).get("grade_id")
    return title if title and isinstance(title, str) else f"cell {cell.get('id')}"


def _nbgrader(cell: NotebookNode) -> dict:
    """What nbgrader says of a cell; in a file from elsewhere it may be anything."""
    meta = cell.metadata.get("nbgrader")
    return meta if isinstance(meta, dict) else {}


def points(cell: NotebookNode) -> float:
    """The points of a check or of a question; 0 where a student has lost them."""
    said = _nbgrader(cell).get("points")
    return said if isinstance(said, int | float) else 0


def of_role(notebook: NotebookNode, *roles: str) -> dict[str, NotebookNode]:
    """The cells of a notebook in these roles, {grade_id: cell}, in order.

    Of two cells with the same grade_id the last one counts.
    """
    return {name(cell): cell for cell in notebook.cells if role(cell) in roles}


def lent(lab: NotebookNode) -> set[str]:
    """The names of functions and modules that the cells of a lab lend."""
    cells = of_role(lab, "given", "check").values()
    sources = [cell.source for cell in cells if cell.cell_type == "code"]
    made = {one for source in sources for one in functions(source)}
    return made | {here for source in sources for here, _ in imported(source)}


def may_use(lab: NotebookNode) -> list[str]:
    """What a lab lends that its solutions use: those of students may, too.

    A lab without them, as it was released, has it in its metadata.
    """
    if MAY_USE in lab.metadata:
        return lab.metadata[MAY_USE]
    solutions = of_role(lab, "solution").values()
    theirs = {first(one) for cell in solutions for one in used(cell.source)}
    return sorted(theirs & lent(lab))


def headings(notebook: NotebookNode) -> dict[str, str]:
    """Where each cell is found in JupyterLab, which shows no ids.

    Returns
    -------
    dict
        Name of the cell -> the heading above it, or else its name.
    """
    places = {}
    heading = None
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            titles = re.findall(_HEADING, cell.source, re.MULTILINE)
            heading = titles[-1] if titles else heading
        places[name(cell)] = heading or name(cell)
    return places


def released(lab: NotebookNode) -> NotebookNode:
    """The student's version of a lab: without solutions, hidden tests and outputs.

    Its cells have nbgrader's checksums, by which nbgrader finds what a student has
    edited.
    """
    student = copy.deepcopy(lab)
    student.metadata[MAY_USE] = may_use(lab)
    student.cells = [cell for cell in student.cells if cell.get("id") != "teacher"]
    for cell in student.cells:
        cell.source = _without(cell.source, "HIDDEN TESTS")
        if cell.cell_type == "code":
            cell.update(outputs=[], execution_count=None)
        if role(cell) in ("solution", "question"):
            cell.source = _without(cell.source, "SOLUTION", STUBS[cell.cell_type])
        if role(cell):
            cell.metadata["deletable"] = False
        if role(cell) in ("check", "given"):
            cell.metadata["editable"] = False
        if role(cell):
            cell.metadata["nbgrader"]["checksum"] = _checksum(cell)
    return student


def _checksum(cell: NotebookNode) -> str:
    """What ``nbgrader.utils.compute_checksum`` says of a cell."""
    meta = cell.metadata["nbgrader"]
    flags = [str(meta[key]) for key in ("grade", "solution", "locked")]
    worth = [str(float(meta["points"]))] if meta["grade"] else []
    parts = [cell.source, cell.cell_type, *flags, meta["grade_id"], *worth]
    return hashlib.md5("".join(parts).encode(), usedforsecurity=False).hexdigest()


def for_nbgrader(folder: Path) -> list[Path]:
    """Write a course of nbgrader's: its configuration, and every lab as a source.

    The sources have solutions and hidden tests, which ``nbgrader generate_assignment``
    takes away, and no line that says whose version this is.

    Parameters
    ----------
    folder : Path
        Which must not be there yet.

    Raises
    ------
    ValueError
        Where it is, or where there are no labs.
    """
    if folder.exists():
        raise ValueError(f"-o {folder}: it is there already; choose another name")
    known = solved()
    configuration = CONFIGURATION.format(limit=LIMIT, stub=STUBS["code"])
    texts = {folder / "nbgrader_config.py": configuration}
    for title, lab in known.items():
        lab.cells = [cell for cell in lab.cells if cell.get("id") != "teacher"]
        texts[folder / "source" / title / f"{title}.ipynb"] = nbformat.writes(lab)
    try:
        for path, text in texts.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text.rstrip("\n") + "\n", encoding="utf-8")
    except BaseException:  # half a course would be in the way of the next try
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return list(texts)


def _without(source: str, mark: str, stub: str = "") -> str:
    """A source without the lines between the marks, a stub in their place if given.

    The stub is indented as they were.
    """
    lines: list[str] = []
    inside = False
    for line in source.split("\n"):
        if f"### BEGIN {mark}" in line:
            inside = True
            indent = line[: len(line) - len(line.lstrip())]
            lines += [indent + text for text in stub.splitlines()]
        elif f"### END {mark}" in line:
            inside = False
        elif not inside:
            lines.append(line)
    return "\n".join(lines)


def release(folder: Path) -> dict[Path, bool]:
    """Write the student's version of every lab into a folder.

    Returns
    -------
    dict
        Path -> whether it was written: a file that is there already may have work in
        it, and stays.

    Raises
    ------
    ValueError
        Where that is the folder of the labs themselves, whose solutions would be lost,
        or where there are none.
    """
    if folder.resolve() == FOLDER.resolve():
        raise ValueError(
            f"-o {folder}: that is where the labs with their solutions are; "
            "choose another folder"
        )
    known = originals()
    if not known:
        raise ValueError(f"{FOLDER}: there are no labs to release; ask your teacher")
    folder.mkdir(parents=True, exist_ok=True)
    places = {folder / f"{title}.ipynb": lab for title, lab in known.items()}
    return {path: _written(path, lab) for path, lab in places.items()}


def _written(path: Path, lab: NotebookNode) -> bool:
    if path.exists():
        return False
    with whole(path) as half:
        half.write_text(nbformat.writes(lab) + "\n", encoding="utf-8")
    return True
