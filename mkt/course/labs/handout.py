"""All that a student needs, and nothing that the student must not see.

A folder and a zip with the library, the chapters, and the labs as they are released;
the two commands of its README set it up.  The labs are in it twice, once for `labs
check`, which restores what a student has deleted.  Without the folder of their
solutions nothing in it knows a hidden check.
"""

import shutil
import subprocess
from pathlib import Path

from mkt.course.book.checks import strip_file
from mkt.course.labs.notebooks import HANDOUT, ORIGINALS, release
from mkt.files import ROOT

# What a clone has and a student does not need, beside what git does not know.
LEFT_OUT = (
    "tests",
    ".ci",
    ".github",
    ".pre-commit-config.yaml",
    "notebooks/labs",
    "notebooks/handout",
    "COURSE.md",  # which tells a teacher what the comparison of copies overlooks
)
README = """\
# Multiple kernel tracking: the course

Nothing but Python (3.11 or later) is needed.  In a terminal in this folder,

    python3 -m mkt lab

sets everything up, which takes some minutes the first time, and opens the chapters and
the labs.  The labs are in `{labs}`.  To hear how you are doing, save and run

    python3 -m mkt labs check {first}

as often as you like.  On Windows it is `py` in place of `python3`.

Hand in the notebook under the name that it has.

The labs and chapters follow three papers: [T09], Teulière, Marchand and Eck 2009,
[N03], Nummiaro, Koller-Meier and Van Gool 2003, and [C14], Córdoba, Koike and Vidal
2014.  "As we have it" means: in our print, which may have a slip that others have not.
"""


def write(folder: Path) -> list[Path]:
    """Write the handout.

    Parameters
    ----------
    folder : Path
        It must not be there yet, and neither must a file of the same name with .zip.

    Returns
    -------
    list of Path
        The folder and the zip.

    Raises
    ------
    ValueError
        Where something is in the way, or a file that git knows is not there.  Then,
        and whatever else goes wrong, nothing is left behind.
    """
    folder = folder.resolve()
    archive = folder.with_name(f"{folder.name}.zip")
    for path in (folder, archive):
        if path.exists():
            raise ValueError(f"-o {path}: it is there already; choose another name")
    if folder.is_relative_to(ROOT):
        raise ValueError(f"-o {folder}: choose a place outside of {ROOT}")
    names = _files()
    try:
        _fill(folder, names)
        shutil.make_archive(str(folder), "zip", folder.parent, folder.name)
    except BaseException:  # also Ctrl-C
        shutil.rmtree(folder, ignore_errors=True)
        archive.unlink(missing_ok=True)
        raise
    return [folder, archive]


def _fill(folder: Path, names: list[str]) -> None:
    """Copy files of the clone, and write what only a handout has."""
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, folder / name)
        if name.endswith(".ipynb"):  # of the teacher's session it keeps nothing
            strip_file(folder / name)
    release(folder / _inside(ORIGINALS))
    labs = [path.name for path in release(folder / _inside(HANDOUT))]
    text = README.format(labs=_inside(HANDOUT), first=labs[0] if labs else "LAB")
    (folder / "README.md").write_text(text, encoding="utf-8")
    _let_git_take_the_labs(folder / ".gitignore")


def _let_git_take_the_labs(ignored: Path) -> None:
    """Let git take the released labs, which it ignores in a clone."""
    lines = ignored.read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [line for line in lines if line.strip("/\n") != _inside(HANDOUT)]
    ignored.write_text("".join(kept), encoding="utf-8")


def _inside(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def _files() -> list[str]:
    """The files of the clone that git knows, without what is left out.

    Raises
    ------
    ValueError
        Where this is no clone, or files are missing in it.
    """
    listed = ["git", "-C", str(ROOT), "ls-files", "-z"]
    try:
        done = subprocess.run(listed, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        raise ValueError(
            f"{ROOT}: only a git clone can be handed out, whose files git lists"
        ) from None
    known = done.stdout.split("\0")
    names = [name for name in known if name and not _left_out(name)]
    missing = [name for name in names if not (ROOT / name).is_file()]
    if missing:
        raise ValueError(
            f"{ROOT}: {', '.join(missing)}: not there, though git knows of it; "
            "bring it back with `git restore`, or take it out with `git rm`"
        )
    return names


def _left_out(name: str) -> bool:
    return any(name == one or name.startswith(f"{one}/") for one in LEFT_OUT)
