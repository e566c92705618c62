"""A page for each student: what was right, what was said of the rest, the points."""

import hashlib
import html
import re
from contextlib import suppress
from pathlib import Path

import jinja2
from nbformat import NotebookNode

from mkt.course.labs.marks import ORIGINAL
from mkt.course.labs.notebooks import headings, of_role, points
from mkt.course.labs.submissions import OF_OTHERS
from mkt.course.labs.table import Row, number
from mkt.course.labs.variants import NAME
from mkt.files import whole

TYPED_ELSEWHERE = (
    "the typed points are in the row of an older version, whose answer differs"
)
FOR_TEACHERS = (*OF_OTHERS, TYPED_ELSEWHERE)  # with which lines of a note begin

_TEMPLATES = jinja2.Environment(
    loader=jinja2.FileSystemLoader(Path(__file__).parent),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
)


def folder_of(output: Path) -> Path:
    """The folder for the pages that belong to a table."""
    return output.with_name(f"{output.stem}_pages")


def rubrics_of(output: Path) -> Path:
    """The file of the rubrics that belong to a table."""
    return output.with_name(f"{output.stem}_rubrics.md")


def lock_of(output: Path) -> Path:
    """The file by which one grading waits for another of the same table."""
    return output.with_name(f"{output.name}.lock")


def beside(output: Path) -> list[Path]:
    """All that may lie beside a table of ours, and belongs to it."""
    return [folder_of(output), rubrics_of(output), lock_of(output)]


def write(output: Path, row: Row, lab: NotebookNode, models: bool) -> None:
    """Write the page of a row: FOLDER/STUDENT/LAB.html, with the file's hash in it.

    It is for the student: what the table says of other students is not on it.

    Parameters
    ----------
    output : Path
        The table.
    row : dict
    lab : NotebookNode
        With its solutions.
    models : bool
        Whether to show the model answers, where the row has a total.
    """
    path = _path(output, row)
    where = headings(lab)
    page = _TEMPLATES.get_template("page.html").render(
        row=row,
        title=_title(lab),
        pieces=[
            (check, where[check], row.get(check) or "?", points(cell))
            for check, cell in of_role(lab, "check", "question").items()
        ],
        notes=[n for n in for_students(row) if not _is_settled(n, row, lab)],
        answers=_models(lab) if models and row["total"] else {},
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole(path) as half:
        half.write_text(page, encoding="utf-8")


def for_students(row: Row) -> list[str]:
    """The lines of a note that are on the page."""
    lines = row["note"].splitlines()
    return [one for one in lines if not one.startswith(FOR_TEACHERS)]


def _is_settled(line: str, row: Row, lab: NotebookNode) -> bool:
    """Whether a line finds fault with a check that a teacher gives all its points."""
    check = line.partition(": ")[0]
    checks = of_role(lab, "check")
    if check not in checks or line.endswith(ORIGINAL):
        return False
    try:
        return number(row.get(check, "")) == points(checks[check])
    except ValueError:  # there is none yet
        return False


def is_there(output: Path, row: Row) -> bool:
    """Whether a row has a page."""
    return _path(output, row).is_file()


def remove(output: Path, row: Row) -> None:
    """Remove the page of a row, if it has one."""
    if is_there(output, row):
        _remove(_path(output, row))


def remove_others(output: Path, rows: list[Row]) -> None:
    """Remove the pages that no row has, such as those under a name that was mended."""
    kept = {_path(output, row) for row in rows}
    for path in folder_of(output).glob("*/*.html"):
        if path not in kept and re.search(r"_[0-9a-f]{8}\.html$", path.name):
            _remove(path)


def _remove(path: Path) -> None:
    """Remove a page, and its folder, unless there is more in it."""
    path.unlink()
    with suppress(OSError):
        path.parent.rmdir()


def _path(output: Path, row: Row) -> Path:
    name = f"{row['lab']}_{_short(row['file'] + row['sha256'])}.html"
    return folder_of(output) / _safe(row["student"]) / name


def write_rubrics(output: Path, labs: dict[str, NotebookNode]) -> None:
    """Write TABLE_rubrics.md, by which a person marks the answers.

    Parameters
    ----------
    output : Path
        The table.
    labs : dict
        Those that are in it, with their solutions.
    """
    parts = [
        f"## {title}, {question}: {points(cell):g} points\n\n{_model(cell)}"
        for title, lab in labs.items()
        for question, cell in of_role(lab, "question").items()
    ]
    with whole(rubrics_of(output)) as half:
        half.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _safe(text: str) -> str:
    """A text as the name of a folder; two texts never have the same one."""
    plain = re.sub(r"[^\w -]+", "_", text)[:80]
    return plain if plain == text else f"{plain}_{_short(text)}"


def _short(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()[:8]


def _title(lab: NotebookNode) -> str:
    titles = [re.search(r"^# (.+)$", cell.source, re.MULTILINE) for cell in lab.cells]
    return next((found[1] for found in titles if found), "Lab")


def _models(lab: NotebookNode) -> dict[str, str]:
    """The model solutions and answers, {name of the cell: text}, but nobody's name."""
    return {
        name: re.sub(r"\$([^$]+)\$", _in_letters, _model(cell))
        for name, cell in of_role(lab, "solution", "question").items()
        if name != NAME
    }


def _in_letters(formula: re.Match[str]) -> str:
    r"""A formula for a page that sets none: $\alpha$ is α, which HTML calls &alpha;."""
    upright = re.sub(r"\\mathrm\{(\w+)\}", r"\1", formula[1])
    upright = upright.replace(r"\sqrt ", "√")
    return html.unescape(re.sub(r"\\([A-Za-z]+)", r"&\1;", upright))


def _model(cell: NotebookNode) -> str:
    """A solution or model answer without the marks round it."""
    return re.sub(r"^.*### (BEGIN|END) SOLUTION.*\n?", "", cell.source, flags=re.M)
