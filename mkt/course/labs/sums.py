"""The sum of a row's points, with those that a teacher has typed into the table."""

import math
from collections.abc import Mapping

from nbformat import NotebookNode

from mkt.course.labs.notebooks import of_role, points
from mkt.course.labs.pages import TYPED_ELSEWHERE
from mkt.course.labs.table import Row, number

Labs = Mapping[str, NotebookNode]


def sum_up(rows: list[Row], sources: Labs) -> None:
    """Write the totals of rows that count; rows without a file are a teacher's own.

    Where a typed number has a decimal comma, sums have one, too: a spreadsheet that
    writes 2,5 may take 5.5 for a day in May.

    Raises
    ------
    ValueError
        Naming all that is no number of points.
    """
    wrong = []
    mark = "," if _has_comma(rows, sources) else "."
    for row in rows:
        if not row["file"]:
            continue
        row["total"] = ""
        if row["lab"] not in sources or not row["points"]:
            continue
        try:
            _sum_one(row, sources[row["lab"]], mark)
        except ValueError as error:
            wrong.append(str(error))
    if wrong:
        raise ValueError("; ".join(wrong))


def counts(row: Row) -> bool:
    """Whether a row is of a file that is there, and not an older version of it.

    Those have the state `table.GONE` or `table.OLDER`, whatever was typed beside it.
    """
    return bool(row["file"]) and not row.get("state")


def unread(row: Row, sources: Labs) -> str:
    """Whose row has no total yet, and for want of which points; "" where none waits."""
    waits = row["points"] and not row["total"] and counts(row)
    if row["lab"] not in sources or not waits:
        return ""
    questions = of_role(sources[row["lab"]], "question")
    blank = ", ".join(one for one in questions if not row.get(one))
    return f"{row['student']}, {row['lab']}: {blank}"


def _has_comma(rows: list[Row], sources: Labs) -> bool:
    """Whether a number of points in these rows has a decimal comma."""
    return any(
        "," in text
        for row in rows
        if row["file"] and row["lab"] in sources
        for text in _typed(row, sources[row["lab"]])
    )


def _typed(row: Row, lab: NotebookNode) -> list[str]:
    """The numbers of a row that may be typed; among them a sum that is not ours."""
    checks, questions = (
        [row.get(piece, "") for piece in of_role(lab, which)]
        for which in ("check", "question")
    )
    return [*checks, *questions, "" if all(checks) else row["points"]]


def _sum_one(row: Row, lab: NotebookNode, mark: str) -> None:
    """Sum up one row, with this decimal mark."""
    by_checks = _sum(row, lab, "check")
    if by_checks is None:
        by_checks = _read(row["points"], math.inf, row)
    typed = _sum(row, lab, "question")
    row["points"] = f"{by_checks:g}".replace(".", mark)
    if typed is not None and counts(row):
        row["total"] = f"{by_checks + typed:g}".replace(".", mark)
        lines = row["note"].splitlines()
        row["note"] = "\n".join(one for one in lines if one != TYPED_ELSEWHERE)


def _sum(row: Row, lab: NotebookNode, role: str) -> float | None:
    """The points of all checks or of all questions, None while some are missing."""
    pieces = of_role(lab, role)
    typed = [row.get(piece, "") for piece in pieces]
    if not all(typed):
        return None
    most = [points(cell) for cell in pieces.values()]
    return sum(_read(text, of, row) for text, of in zip(typed, most, strict=True))


def _read(text: str, most: float, row: Row) -> float:
    """The number of points that a text says; ValueError where it says none."""
    try:
        value = number(text)
    except ValueError:
        value = -1
    # Python reads "1_0" as 10; a sum of checks that was typed has no upper end.
    if not 0 <= value <= most or math.isinf(value) or "_" in text:
        end = "on" if math.isinf(most) else f"to {most:g}"
        raise ValueError(
            f"{row['student']}, {row['lab']}: {text!r} in the table is not a number of "
            f"points from 0 {end}"
        )
    return value
