"""The table of the marks, which a teacher opens in a spreadsheet and adds to.

What comes from students cannot do anything there: text that a spreadsheet would take
for a formula, and characters that steer a terminal, are made harmless.
"""

import csv
import io
import re
from collections.abc import Iterable
from pathlib import Path

from mkt.files import DataError, whole

FORMULA = ("=", "+", "-", "@")
SEPARATORS = ",;\t"
# Of the table, before and after the checks and questions.
COLUMNS = (
    ("student", "lab", "points", "of", "total", "maximum"),
    ("state", "note", "answers", "file", "sha256"),
)
RENEWED = "total", "state"  # they are written anew
NEEDED = [one for part in COLUMNS for one in part if one not in RENEWED]
# States of rows that do not count: an older version, and a file no longer there.
OLDER, GONE = "older", "gone"
# Version 0.2.0 wrote this into notes in place of a state.
FORMERLY = "an older version of this file", "this file is no longer in the folder"
# What may be too long for it, and where the whole is then.
SHORTENED = {
    "note": "a run into a new table has the whole on its page",
    "answers": "the whole is in {file}",
}
ROOM = 32_767  # [characters] that a cell of a spreadsheet holds
ENDLESS = 2**31 - 1  # [characters] of a cell that is read

Row = dict[str, str]


def harmless(text: str) -> str:
    """A text that is only read, wherever it is shown.

    A tab, and any other kind of space, becomes a plain one, and what cannot be printed
    a question mark; a spreadsheet takes what follows an apostrophe for text.
    """
    text = "".join(map(_printable, text))
    formula = text.lstrip().startswith(FORMULA)
    return f"'{text}" if formula and not _is_number(text) else text


def _printable(letter: str) -> str:
    if letter.isprintable() or letter == "\n":
        return letter
    return " " if letter.isspace() else "\ufffd"


def _is_number(text: str) -> bool:
    return text.lstrip("+-").replace(".", "", 1).isdecimal()


def number(text: str) -> float:
    """What a number says, with a point or a comma; ValueError for what is none."""
    return float(text.replace(",", "."))


def read(path: Path) -> list[Row]:
    """The rows of a table, also of one that a spreadsheet has saved.

    Columns and rows that a teacher has added are in them, too; the latter have no file.
    Empty lines are not.

    Raises
    ------
    ValueError
        For a file that is no table of ours.
    mkt.files.DataError
        For one of ours that has lost a column, or has one without a heading.
    """
    csv.field_size_limit(ENDLESS)
    text = _text(path)
    found = csv.DictReader(io.StringIO(text, newline=""), delimiter=separator(path))
    _has_columns(path, found.fieldnames or ())
    rows = list(found)
    if any(row.get("") or any(row.get(None) or ()) for row in rows):
        raise DataError(
            path,
            "there is text in a column without a heading",
            "write one above it, in the first line",
        )
    named = [{key: value or "" for key, value in row.items() if key} for row in rows]
    return [_with_zeros(row) for row in named if any(row.values())]


def _with_zeros(row: Row) -> Row:
    """A row whose student has the zeros again that a spreadsheet took from a number."""
    folder = re.split(r"[/\\]", row["file"])[0]
    number = row["student"]
    both = folder.isdecimal() and number.isdecimal()
    same = both and folder.lstrip("0") == number.lstrip("0")
    return row | {"student": folder} if same else row


def _has_columns(path: Path, names: Iterable[str]) -> None:
    missing = [one for one in NEEDED if one not in names]
    if len(missing) > len(NEEDED) / 2:
        raise ValueError(
            f"{path}: it is there already, and no table of marks; "
            "choose another name, or remove it"
        )
    if missing:
        raise DataError(
            path,
            f"no column is called {', '.join(missing)} any more",
            "give it back its name, or take it from a copy; or grade into a new table",
        )


def separator(path: Path) -> str:
    """What stands between two cells of a table."""
    return max(SEPARATORS, key=_text(path).partition("\n")[0].count)


def _text(path: Path) -> str:
    data = path.read_bytes().replace(b"\r\n", b"\n")  # as Windows ends a line
    if b"\0" in data:
        raise DataError(
            path,
            "it is in UTF-16, or a workbook, or no text at all",
            "save it as CSV in UTF-8, or choose another name",
        )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:  # what German Windows saves by itself
        return data.decode("cp1252", "replace")


def write(path: Path, columns: Iterable[str], rows: Iterable[Row], comma: str) -> None:
    """Write a table as a whole, sorted by student and lab; a teacher's rows are last.

    Notes and answers for which a spreadsheet has no room are shortened.

    Parameters
    ----------
    path : Path
    columns : iterable of str
    rows : iterable of dict
        What a row does not have stays empty.
    comma : str
        What stands between two cells.
    """

    def order(row: Row) -> tuple:
        place = row["student"], row["lab"], row["file"]
        return (False, place) if row["file"] else (True, ())

    # Its first mark (utf-8-sig) tells spreadsheets how to read umlauts.
    with (
        whole(path) as half,
        half.open("w", newline="", encoding="utf-8-sig") as file,
    ):
        writer = csv.DictWriter(file, list(columns), delimiter=comma)
        writer.writeheader()
        for row in sorted(rows, key=order):
            cells = {key: harmless(value) for key, value in row.items()}
            writer.writerow(cells | {key: _short(cells, key) for key in SHORTENED})


def _short(row: Row, key: str) -> str:
    """A text that a cell holds."""
    text = row.get(key, "")
    if len(text) <= ROOM:
        return text
    end = f"\n[shortened here; {SHORTENED[key].format(file=row['file'])}]"
    return text[: ROOM - len(end)] + end
