"""What students handed in: which files of a folder are whose, as they are now.

All files are copied before anything of the students' runs.
"""

import hashlib
import re
import shutil
import stat
import unicodedata
from collections.abc import Collection, Container, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from mkt.course.labs.variants import plain_name

# What systems and nbgrader leave beside what was handed in, in small letters; Word and
# its like begin the name of a file that is open with the second of these.
NOT_HANDED_IN = {
    "__pycache__",
    "__macosx",
    "thumbs.db",
    "desktop.ini",
    "timestamp.txt",
}
BEGINNINGS = ".", "~$"
# With which the names of labs begin, should a file have no more of one.
SHORT = r"(?<![^\W\d_])lab_"
NO_LETTERS = r"^[\W\d_]+|[\W\d_]+$"  # at either end
# What stands behind a lab's name and is nobody's, in small letters.
OF_COPIES = {"copy", "copie", "copia", "kopie", "final", "graded", "v", "version"}
LARGEST = 50e6  # [bytes] of a notebook
SHOWN = 3  # files that a sentence lists by name
NOTHING = "nothing was handed in"  # in a folder of a student
ARCHIVES = (".zip", ".tar", ".gz", ".tgz", ".7z", ".rar")
# Sentences that begin so name other students.
OF_OTHERS = SAME_NAME, SAME_FILE, SAME_WORK = (
    "the name in it",
    "the same file, byte for byte, as",
    "the same work:",
)
SECOND = "there is another file of this lab by this student:"
BESIDE = (*OF_OTHERS, SECOND)  # all that a note may say of other files
# Some work: the texts that each of its parts has; one part of a copy has one of them.
Work = list[set[str]]


@dataclass(frozen=True)
class Submission:
    """A file that a student handed in.

    Parameters
    ----------
    student : str
    lab : str, optional
        The name of the lab, None where the file's name has none in it.
    path : Path
        Seen from the folder of all submissions.
    copy : Path, optional
        None where it was not copied.
    sha256 : str
        Of its content, "" where it was not copied.
    trouble : str
        Why it cannot be graded, "" if it can.
    named : bool
        Whether the student stands in its path, not in that of all submissions.
    """

    student: str
    lab: str | None
    path: Path
    copy: Path | None = None
    sha256: str = ""
    trouble: str = ""
    named: bool = True


def handed_in(
    folder: Path, names: Iterable[str], copies: Path, ours: Collection[Path]
) -> list[Submission]:
    """The same as `submissions`, copied, where there is something to grade.

    Parameters
    ----------
    folder : Path
    names : iterable of str
        Of the labs.
    copies : Path
        The folder for the copies.
    ours : collection of Path
        Files and folders that are no submissions, wherever they are.

    Raises
    ------
    ValueError
        Where there is no notebook in it.
    """
    found = [_copied(folder, one, copies) for one in submissions(folder, names, ours)]
    if all(one.trouble for one in found):
        raise ValueError(
            f"{folder}: no notebooks in there; it takes STUDENT/LAB/LAB.ipynb, "
            "STUDENT/LAB.ipynb or STUDENT_LAB.ipynb"
        )
    return found


def submissions(
    folder: Path, names: Iterable[str], ours: Collection[Path]
) -> list[Submission]:
    """What was handed in, even if it is no notebook, or not even a file, or nothing.

    They are STUDENT/[.../]LAB.ipynb, as nbgrader's ``submitted`` has them, or
    STUDENT_LAB.ipynb; the name of the lab may stand anywhere in that of the file, in
    small letters or capitals, and the student's behind it.  In STUDENT_lab_1.ipynb a
    file's name is cut short, but says whose it is, and in STUDENT.ipynb it says nothing
    else.
    Hidden files do not count, nor do those that systems leave.

    Parameters
    ----------
    folder : Path
    names : iterable of str
        Of the labs.
    ours : collection of Path
        Files and folders that do not count either.
    """
    names = list(names)
    left_out = {path.resolve() for path in ours}
    paths = [
        path.relative_to(folder)
        for path in sorted(folder.rglob("*"))
        if path.is_symlink() or not path.is_dir()
        if left_out.isdisjoint(_with_parents(folder, path))
    ]
    found = [
        _submission(folder, path, names)
        for path in paths
        if not any(map(_is_aside, path.parts))
    ]
    some = {one.path.parts[0] for one in found if len(one.path.parts) > 1}
    empty = [
        Submission(path.name, None, path.relative_to(folder), trouble=_nothing(path))
        for path in sorted(folder.iterdir())
        if some  # or none of the folders is a student's
        if path.is_dir() and not path.is_symlink()  # which stands for itself, above
        if not _is_aside(path.name) and path.name not in some
        if left_out.isdisjoint(_with_parents(folder, path))
    ]
    return found + empty


def _nothing(folder: Path) -> str:
    """Why nothing was found in a folder."""
    try:
        next(folder.iterdir(), None)
    except OSError as error:
        return f"cannot be read: {error.strerror or error}"
    return NOTHING


def _with_parents(folder: Path, path: Path) -> list[Path]:
    """A path and the folders above it, without links above the folder."""
    absolute = folder.resolve() / path.relative_to(folder)
    return [absolute, *absolute.parents]


def _is_aside(part: str) -> bool:
    return part.startswith(BEGINNINGS) or part.casefold() in NOT_HANDED_IN


def _submission(folder: Path, path: Path, names: list[str]) -> Submission:
    stem = path.stem.lower()
    lab = next((lab for lab in names if lab.lower() in stem), None)
    if len(path.parts) > 1:
        student = path.parts[0]
    else:
        student = _beside_its_lab(path.stem, lab)
    named = bool(student)
    # An "e" with its accent, and an "e" and an accent, are one name.
    student = unicodedata.normalize("NFC", student or folder.resolve().name)
    return Submission(student, lab, path, named=named)


def _beside_its_lab(stem: str, lab: str | None) -> str:
    """Whose a file is by its name: what stands before a lab's name, or behind it.

    A file that seems to be of no lab is perhaps called after a student.
    """
    title = re.escape(lab) if lab else SHORT
    before, *behind = re.split(title, stem, maxsplit=1, flags=re.IGNORECASE)
    if named := before.strip("_- "):
        return named
    # What ends a name that is cut short is the lab's; numbers are of nobody.
    word = re.sub(NO_LETTERS, "", behind[0]) if lab else ""
    return "" if word.casefold() in OF_COPIES else word


def _copied(folder: Path, one: Submission, copies: Path) -> Submission:
    """A submission with its copy, or with what is in the way of one."""
    if one.trouble:
        return one
    path = folder / one.path
    copy = copies / f"{len(list(copies.iterdir()))}.ipynb"
    try:
        trouble = _trouble(path)
        if not trouble:
            shutil.copyfile(path, copy, follow_symlinks=False)
    except OSError as error:  # such as a right that the teacher does not have
        trouble = f"cannot be read: {error.strerror or error}"
    if trouble:
        return replace(one, trouble=trouble)
    with copy.open("rb") as file:
        sha256 = hashlib.file_digest(file, "sha256").hexdigest()
    return replace(one, copy=copy, sha256=sha256)


def _trouble(path: Path) -> str:
    about = path.lstat()
    if stat.S_ISLNK(about.st_mode):
        return "a link to somewhere else, which was not followed"
    if not stat.S_ISREG(about.st_mode):
        return "not a file"
    if path.suffix.lower() in ARCHIVES:
        return "an archive: unpack it, then grade again"
    if path.suffix.lower() != ".ipynb":
        return f"not a notebook: {path.suffix or path.name}"
    if about.st_size > LARGEST:
        return (
            f"{about.st_size / 1e6:.0f} MB is too large for a notebook: clear its "
            "outputs (Edit, Clear Outputs of All Cells), save, grade again"
        )
    return ""


def coincidences(
    found: Iterable[Submission],
    names: Mapping[Path, str],
    work: Mapping[Path, Mapping[str, Work]],
    blank: Container[Path] = (),
) -> dict[Path, list[str]]:
    """What is odd about submissions beside one another, {path: sentences}.

    That is a file that others have too, a second one of the same student and lab, and
    the same scene or the same work of two students.

    Parameters
    ----------
    found : iterable of Submission
    names : dict
        The name that stands in each notebook, see `mkt.course.labs.variants`.
    work : dict
        What is compared of each, see `mkt.course.labs.alike`.
    blank : container of Path
        Those in which nothing is written: that they are the same says nothing.
    """
    graded = [one for one in found if not one.trouble]
    return {
        one.path: _odd(
            one, [two for two in graded if two is not one], names, work, blank
        )
        for one in graded
    }


def _odd(
    one: Submission,
    others: list[Submission],
    names: Mapping[Path, str],
    work: Mapping[Path, Mapping[str, Work]],
    blank: Container[Path],
) -> list[str]:
    """The sentences about one submission beside the others."""
    written = names.get(one.path, "")
    plain = plain_name(written)
    of_lab = [other for other in others if one.lab and other.lab == one.lab]
    foreign = [other for other in of_lab if other.student != one.student]
    same_work = {
        f"{SAME_WORK} {what} is also in": [
            other
            for other in foreign
            if _is_same(parts, work.get(other.path, {}).get(what, []))
            if other.sha256 != one.sha256
        ]
        for what, parts in work.get(one.path, {}).items()
    }
    alike = {
        f"{SAME_NAME}, {written!r}, is also in": [
            other
            for other in foreign
            if plain and plain_name(names.get(other.path, "")) == plain
        ],
        **same_work,
        SAME_FILE: [
            other
            for other in others
            if other.sha256 == one.sha256 and one.path not in blank
        ],
        SECOND: [other for other in of_lab if other.student == one.student],
    }
    return [f"{words} {_listed(found)}" for words, found in alike.items() if found]


def _is_same(work: Work, other: Work) -> bool:
    """Whether each part has a text in common; nothing is the same as no work."""
    return bool(other) and not any(map(set.isdisjoint, work, other))


def _listed(found: list[Submission]) -> str:
    """The first files of a list, and how many there are beyond these."""
    more = f" and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    names = ", ".join(str(one.path) for one in found[:SHOWN]) + more
    return names.replace("\n", " ")  # which a file's name may have in it
