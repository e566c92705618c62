"""What a lab is: a notebook whose cells carry nbgrader's metadata, in four roles, and what becomes of each in the student's version.

==========  ===========================================  =============================================================
role        nbgrader's metadata                          in the student's version
==========  ===========================================  =============================================================
solution    solution                                     what stands between the marks is replaced by a stub
check       grade, locked                                the hidden tests are taken out, the cell cannot be edited
question    solution and grade, a markdown cell          the model answer is replaced by a stub; a person reads the answer
given       locked                                       the same, but it cannot be edited
==========  ===========================================  =============================================================

All other cells are the student's own to change; the cell with the id "teacher", which says whose version this is, is left out.
"""

import copy
import re

import nbformat

from mkt.book.catalogue import NOTEBOOKS
from mkt.files import whole

FOLDER, HANDOUT = NOTEBOOKS / "labs", NOTEBOOKS / "handout"  # the teacher's versions; the students', where JupyterLab shows them
STUBS = {"code": "# YOUR CODE HERE\nraise NotImplementedError()", "markdown": "YOUR ANSWER HERE"}  # those of nbgrader
_ROLES = {(True, False, False): "solution", (False, True, True): "check", (True, True, False): "question", (False, False, True): "given"}


def labs():
    """The labs with their solutions, {name: notebook}, in order."""
    return {path.stem: nbformat.read(path, 4) for path in sorted(FOLDER.glob("*.ipynb"))}


def role(cell):
    """The role of a cell, see the module's text, or None."""
    meta = cell.metadata.get("nbgrader", {})
    return _ROLES.get(tuple(bool(meta.get(key)) for key in ("solution", "grade", "locked")))


def name(cell):
    """What a cell is called in reports: its grade_id, or "cell" and its id, which so cannot pass for a grade_id."""
    return cell.metadata.get("nbgrader", {}).get("grade_id") or f"cell {cell.get('id')}"


def points(cell):
    """The points of a check or of a question."""
    return cell.metadata["nbgrader"]["points"]


def of_role(notebook, *roles):
    """The cells of a notebook in these roles, {grade_id: cell}, in order; of two with the same id the last."""
    return {name(cell): cell for cell in notebook.cells if role(cell) in roles}


def headings(notebook):
    """Where each cell is found in JupyterLab, which shows no ids: {name of the cell: the heading above it, or else its name}."""
    result, heading = {}, None
    for cell in notebook.cells:
        titles = re.findall(r"^#+ (.+)$", cell.source, re.MULTILINE) if cell.cell_type == "markdown" else []
        heading = titles[-1] if titles else heading
        result[name(cell)] = f'under "{heading}"' if heading else name(cell)
    return result


def released(lab):
    """The student's version of a lab: the same cells without solutions and hidden tests."""
    student = copy.deepcopy(lab)
    student.cells = [cell for cell in student.cells if cell.get("id") != "teacher"]
    for cell in student.cells:
        cell.source = _without(cell.source, "HIDDEN TESTS")
        if role(cell) in ("solution", "question"):
            cell.source = _without(cell.source, "SOLUTION", STUBS[cell.cell_type])
        if role(cell):
            cell.metadata["deletable"] = False
        if role(cell) in ("check", "given"):
            cell.metadata["editable"] = False
    return student


def _without(source, mark, stub=None):
    """A source without the lines between the marks; a stub, indented as they were, takes their place."""
    lines, inside = [], False
    for line in source.split("\n"):
        if f"### BEGIN {mark}" in line:
            inside, indent = True, line[:len(line) - len(line.lstrip())]
            lines += [indent + text for text in stub.split("\n")] if stub else []
        elif f"### END {mark}" in line:
            inside = False
        elif not inside:
            lines.append(line)
    return "\n".join(lines)


def release(folder):
    """Write the student's version of every lab into a folder.  Returns {path: whether it was written}: a file that is there may have work in it, and stays.

    Raises ValueError where that is the folder of the labs themselves, whose solutions would be lost.
    """
    if folder.resolve() == FOLDER.resolve():
        raise ValueError(f"-o {folder}: that is where the labs with their solutions are; choose another folder")
    folder.mkdir(parents=True, exist_ok=True)
    return {folder / f"{lab}.ipynb": _written(folder / f"{lab}.ipynb", notebook) for lab, notebook in labs().items()}


def _written(path, lab):
    if path.exists():
        return False
    with whole(path) as half:
        half.write_text(nbformat.writes(released(lab)) + "\n", encoding="utf-8")
    return True
