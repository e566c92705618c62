"""What students handed in: which files of a folder are whose, and of which lab."""

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

# What systems and nbgrader leave beside what was handed in.
ASIDE = {"__pycache__", "__MACOSX", "timestamp.txt"}


class Submission(NamedTuple):
    """A file that a student handed in.

    Attributes
    ----------
    student : str
    lab : str, optional
        The name of the lab, None where the file's name has none in it.
    path : Path
    """

    student: str
    lab: str | None
    path: Path

    @property
    def is_notebook(self) -> bool:
        """Whether it is one by its name."""
        return self.path.suffix.lower() == ".ipynb"


def handed_in(folder: Path, names: Iterable[str]) -> list[Submission]:
    """The same as `submissions`, where there is something to grade.

    Raises
    ------
    ValueError
        Where there is no such folder, or no notebook in it.
    """
    if folder.is_file():
        raise ValueError(f"{folder}: this is a file; give the folder that it is in")
    if not folder.is_dir():
        raise ValueError(f"{folder}: there is no such folder")
    found = submissions(folder, names)
    if not any(one.is_notebook for one in found):
        raise ValueError(
            f"{folder}: no notebooks in there; it takes STUDENT/LAB/LAB.ipynb, "
            "STUDENT/LAB.ipynb or STUDENT_LAB.ipynb"
        )
    return found


def submissions(folder: Path, names: Iterable[str]) -> list[Submission]:
    """The files that were handed in, also those that are no notebooks.

    They are STUDENT/[.../]LAB.ipynb, as nbgrader's ``submitted`` has them, or
    STUDENT_LAB.ipynb; the name of the lab may stand anywhere in that of the file.
    Hidden files do not count.

    Parameters
    ----------
    folder : Path
    names : iterable of str
        Of the labs.
    """
    names = list(names)
    files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return [
        _submission(folder, path, names)
        for path in files
        if not any(map(_is_aside, path.relative_to(folder).parts))
    ]


def _is_aside(part: str) -> bool:
    return part.startswith(".") or part in ASIDE


def _submission(folder: Path, path: Path, names: list[str]) -> Submission:
    lab = next((lab for lab in names if lab in path.stem), None)
    parts = path.relative_to(folder).parts
    if len(parts) > 1:
        student = parts[0]
    else:
        student = path.stem.partition(lab or path.stem)[0].strip("_- ")
    return Submission(student or folder.resolve().name, lab, path)
