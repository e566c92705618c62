"""The table of the marks, which a teacher opens in a spreadsheet and adds to.

What comes from students cannot do anything there: text that a spreadsheet would take
for a formula, and characters that steer a terminal, are made harmless.
"""

import csv
import io
from collections.abc import Iterable
from pathlib import Path

from mkt.files import whole

FORMULA = ("=", "+", "-", "@", "\t", "\r")
SEPARATORS = ",;\t"
KEYS = ("student", "lab", "file", "sha256")  # those of a table of ours

Row = dict[str, str]


def harmless(text: str) -> str:
    """A text that is only read, wherever it is shown.

    What cannot be printed becomes a question mark; a spreadsheet takes what follows an
    apostrophe for text.
    """
    text = "".join(
        one if one.isprintable() or one == "\n" else "\ufffd" for one in text
    )
    return f"'{text}" if text.startswith(FORMULA) and not _is_number(text) else text


def _is_number(text: str) -> bool:
    return text.lstrip("+-").replace(".", "", 1).isdecimal()


def read(path: Path) -> list[Row]:
    """The rows of a table, also of one that a spreadsheet has saved.

    Raises
    ------
    ValueError
        For a file that is no table of ours.
    """
    text = _text(path)
    rows = csv.DictReader(io.StringIO(text, newline=""), delimiter=separator(path))
    if not set(KEYS) <= set(rows.fieldnames or ()):
        raise ValueError(
            f"{path}: it is there already, and no table of marks; "
            "choose another name, or remove it"
        )
    return [{key: value or "" for key, value in row.items() if key} for row in rows]


def separator(path: Path) -> str:
    """What stands between two cells of a table."""
    return max(SEPARATORS, key=_text(path).partition("\n")[0].count)


def _text(path: Path) -> str:
    data = path.read_bytes()
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:  # what German Windows saves by itself
        return data.decode("cp1252", "replace")


def write(path: Path, columns: Iterable[str], rows: Iterable[Row], comma: str) -> None:
    """Write a table as a whole, sorted by student and lab.

    Parameters
    ----------
    path : Path
    columns : iterable of str
    rows : iterable of dict
        What a row does not have stays empty.
    comma : str
        What stands between two cells.
    """

    def order(row: Row) -> tuple[str, str, str]:
        return row["student"], row["lab"], row["file"]

    # Its first mark (utf-8-sig) tells spreadsheets how to read umlauts.
    with (
        whole(path) as half,
        half.open("w", newline="", encoding="utf-8-sig") as file,
    ):
        writer = csv.DictWriter(file, list(columns), delimiter=comma)
        writer.writeheader()
        for row in sorted(rows, key=order):
            writer.writerow({key: harmless(value) for key, value in row.items()})
