"""Rows of numbers in a text, and where each of them stands.

The text comes from strangers: it is read as numbers and nothing else.  Whatever is
wrong is a `DataError` that names the file, the line and the remedy.
"""

import os
import re
from typing import NamedTuple

import numpy as np

from mkt.files import DataError, existing_file
from mkt.types import Array, ArrayLike, NDArray

# 9,5 before a blank and a further number, or in quotes of its own.
DECIMAL_COMMA = re.compile(r'\d,\d+"?[\t ]+"?[-+.\d]|"[-+]?\d+,\d+"')


class Rows(NamedTuple):
    """Where the rows of an array stand in a text.

    Attributes
    ----------
    path : path
    lines : (T,) int array, optional
        The line of each row, counted from 1; None where there are no lines.
    headed : bool
        Whether the first line is words.
    """

    path: str | os.PathLike
    lines: NDArray | None
    headed: bool = False

    def of(self, mine: NDArray) -> "Rows":
        """Where those of the rows stand for which mine (T,) bool holds."""
        assert self.lines is not None
        return self._replace(lines=self.lines[mine])

    def refuse(self, bad: ArrayLike, what: str, remedy: str) -> None:
        """Refuse the first of the bad rows (T,) bool.

        Raises
        ------
        DataError
        """
        rows = np.flatnonzero(bad)
        if rows.size:
            line = None if self.lines is None else int(self.lines[rows[0]])
            raise DataError(self.path, what, remedy, line)

    def refuse_nan(self, numbers: Array) -> None:
        """Refuse the first row of numbers (T, n) with a NaN.

        Raises
        ------
        DataError
        """
        bad = np.isnan(numbers).any(1)
        self.refuse(bad, "NaN is not allowed in this format", "correct the row")

    def refuse_misnumbered(self, index: Array, form: str, first: int = 0) -> None:
        """Refuse the first row whose number is not one more than that before it.

        Parameters
        ----------
        index : (T,) array
        form : str
            What a row looks like, in words.
        first : int
            The number of the first row.

        Raises
        ------
        DataError
        """
        wrong = index != first + np.arange(len(index))
        self.refuse(
            wrong,
            f"the first column is {index[np.argmax(wrong)]:g}, "
            f"but must count the rows {first}, {first + 1}, {first + 2}, ...",
            f"put missing rows back and all in order, as `{form}`",
        )


def read_rows(
    path: str | os.PathLike, widths: tuple[int, ...], header: bool = False
) -> tuple[Rows, Array]:
    """All numbers of a text file.

    They are separated by commas, semicolons, tabs or spaces, and may stand in quotes;
    blank lines do not count.

    Parameters
    ----------
    path : path
    widths : tuple of int
        How many numbers a row may have; all rows have the same.
    header : bool
        The first line may be words.

    Returns
    -------
    rows : Rows
    numbers : (T, n) array

    Raises
    ------
    DataError
        For a file that is missing, is no text, or holds no rows, and for the first row
        that is wrong.
    """
    table = [
        (number, re.split(r"[,;\s]+", line.replace('"', "").strip(" \t,;")))
        for number, line in enumerate(_lines(path), 1)
        if line.strip()
    ]
    headed = header and bool(table) and _number(table[0][1][0]) is None
    table = table[headed:]
    if not table:
        raise DataError(
            path,
            "no rows of numbers",
            "an empty or header-only file cannot be used: download or annotate it "
            "again",
        )
    first = len(table[0][1])
    width = first if first in widths else widths[0]
    numbers = [_row(path, line, fields, width) for line, fields in table]
    lines = np.array([line for line, _ in table])
    return Rows(path, lines, headed), np.array(numbers)


def _lines(path: str | os.PathLike) -> list[str]:
    """The lines of a text file.

    What is no text is refused, and so are lines whose commas may be decimal ones.
    """
    text = existing_file(path).read_text("utf-8-sig", "replace")
    if "\0" in text:
        raise DataError(
            path,
            "no plain text: it holds bytes of zero, as UTF-16 does",
            "save it as UTF-8, or download it again",
        )
    lines = text.splitlines()
    for number, line in enumerate(lines, 1):
        if what := _unclear(line):
            raise DataError(
                path,
                what,
                "separate numbers by one sign, and write 9.5, not 9,5",
                number,
            )
    return lines


def _unclear(line: str) -> str:
    """Why nobody can say where the numbers of a line end, empty where they can."""
    if ";" in line.strip(";") and "," in line.strip(","):
        return "both commas and semicolons"
    return "what looks like a decimal comma" if DECIMAL_COMMA.search(line) else ""


def _row(
    path: str | os.PathLike, line: int, fields: list[str], width: int
) -> list[float]:
    """The numbers in the fields of a line."""
    if len(fields) != width:
        twice = len(fields) == 2 * width
        hint = ", and write 9.5, not 9,5" if twice else ""
        raise DataError(
            path,
            f"{len(fields)} numbers, but {width} are needed",
            f"correct the row{hint}",
            line,
        )
    values = []
    for field in fields:
        value = _number(field)
        if value is None or np.isinf(value):
            raise DataError(
                path, f"{field[:40]!r} is not a finite number", "correct the row", line
            )
        values.append(value)
    return values


def _number(field: str) -> float | None:
    try:
        return None if "_" in field else float(field)  # Python's own 1_000
    except ValueError:
        return None
