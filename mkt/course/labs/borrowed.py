"""Solutions that use what does the work already: said, and never graded.

A lab needs the library for its own checks and figures, so a piece can be "solved" by
one call of it.  Whether that is a student's own work is for a person to say: the note
of the teacher's table names it, and so does ``labs check`` to the student.
"""

from nbformat import NotebookNode

from mkt.course.labs.notebooks import lent, may_use, name, of_role
from mkt.course.labs.source import LONGEST, first, functions, imported, used

USES = "{}: uses {}, ready-made; what the piece asks for is to be own work"
LONG = f"{{}}: has more than {LONGEST} letters, of which the rest was not read"
NUMBER = "my_number"  # a piece that may be typed, or computed with whatever is there


def borrowed(lab: NotebookNode, notebook: NotebookNode) -> list[str]:
    """Which cells use what the lab has for itself, in sentences.

    Of a solution that is all that it imports from `LENDERS`, what it uses of what the
    lab or a cell of the student's own imports from there, under whatever name, and the
    lab's own functions, without those that its own solutions use.  Of a cell of the
    student's own it is an import that may take the place of a solution.

    Parameters
    ----------
    lab : NotebookNode
        With its solutions, or as it was released.
    notebook : NotebookNode
        A student's.
    """
    solutions = of_role(lab, "solution")
    ours = of_role(lab, "given", "check")
    codes = [cell for cell in notebook.cells if cell.cell_type == "code"]
    theirs = [(name(cell), cell.source) for cell in codes if name(cell) not in ours]
    told = lent(lab) - {*may_use(lab)}
    told |= {
        here
        for cell, source in theirs
        for here, _ in imported(source)
        if cell not in solutions
    }
    pieces = {one for cell in solutions.values() for one in functions(cell.source)}
    said = []
    for cell, source in theirs:
        if cell in solutions:
            names = _ready_made(source, told) if cell != NUMBER else set()
        else:
            names = _put_in(source, pieces)
        if names:
            said.append(USES.format(cell, " and ".join(sorted(names))))
        if len(source) > LONGEST:
            said.append(LONG.format(cell))
    return list(dict.fromkeys(said))


def _ready_made(source: str, told: set[str]) -> set[str]:
    """What a solution uses that is to be told, and all that it imports itself."""
    there = imported(source)
    told = told | {here for here, _ in there}
    calls = {one for one in used(source) if first(one) in told}
    named = {first(one) for one in calls}
    return calls | {whole for here, whole in there if here not in named}


def _put_in(source: str, pieces: set[str]) -> set[str]:
    """What a cell of the student's own may put in the place of pieces by an import."""
    return {there for here, there in imported(source) if here in {"*", *pieces}}
