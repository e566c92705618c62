"""``lab`` opens JupyterLab on the notebooks."""

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

from mkt.course import stripping
from mkt.course.commands import Commands, command
from mkt.files import NOTEBOOKS, PACKAGE, ROOT, whole

SETTINGS = PACKAGE / "course" / "jupyterlab"
FIRST = "01_color_histograms.ipynb"
AS_ROOT = (
    "JupyterLab refuses to run as root, as whom a notebook could do anything; log in "
    "as somebody else, or in a container of your own add --allow-root"
)
COPIES = "{} cannot be written, so you work on copies in {}"


def add(commands: Commands) -> None:
    """Describe the command."""
    parser = command(
        commands,
        "lab",
        run,
        "open the notebooks in JupyterLab",
        "Opens JupyterLab on the folder notebooks/ in your browser, with the first\n"
        "chapter; Ctrl-C ends it.  Everything after `lab` is handed to it.\n"
        "Where the clone cannot be written, it opens copies in your own folder\n"
        "mkt-notebooks, and leaves those that are there.  In a clone it tells\n"
        "git to look past outputs, so that to run a chapter changes nothing there.",
        "lab",
        "lab --no-browser --port 9000",
        clone=True,
    )
    parser.usage = "python3 -m mkt lab [-h] [JUPYTERLAB ARGUMENT ...]"


def run(args) -> int | None:
    """Open JupyterLab on the notebooks, with our settings: it does not ask for news."""
    if hasattr(os, "geteuid") and os.geteuid() == 0 and "--allow-root" not in args.rest:
        raise ValueError(AS_ROOT)
    from jupyterlab.labapp import main

    folder = writable()
    ours = [
        f"--ServerApp.root_dir={folder}",
        f"--LabApp.app_settings_dir={SETTINGS}",
    ]
    if (Path(folder) / FIRST).exists():
        ours.append(f"--LabApp.default_url=/lab/tree/{FIRST}")
    try:
        return main([*ours, *args.rest])
    finally:
        if folder == NOTEBOOKS:
            _tell_git()


def writable() -> Path:
    """The folder of the notebooks, or that of the user's copies."""
    if os.access(NOTEBOOKS, os.W_OK):
        _tell_git()
        return NOTEBOOKS
    own = Path.home() / "mkt-notebooks"
    own.mkdir(exist_ok=True)
    for path in (*NOTEBOOKS.glob("*.ipynb"), *NOTEBOOKS.glob("*.md")):
        if not (own / path.name).exists():
            with whole(own / path.name) as half:
                shutil.copyfile(path, half)
    print(COPIES.format(NOTEBOOKS, own), file=sys.stderr)
    return own


def _tell_git() -> None:
    """Let git in this clone strip notebooks before it compares them.

    Git still calls a notebook changed if its size differs.  Adding those that differ in
    nothing else stages nothing, and lets git see that they are the same.
    """
    if not (shutil.which("git") and (ROOT / ".git").exists()):
        return
    program = Path(sys.executable), Path(stripping.__file__)
    clean = shlex.join(path.as_posix() for path in program)
    _git("config", "--local", "filter.mkt.clean", clean)
    seeming = set(_git("ls-files", "--modified", "notebooks"))
    real = set(_git("diff", "--name-only", "--relative", "notebooks"))
    if same := sorted(seeming - real):
        _git("add", *same)


def _git(*words: str) -> list[str]:
    """The lines that git answers, none where this is no clone of git's."""
    command = ["git", "-C", str(ROOT), *words]
    return subprocess.run(command, capture_output=True, text=True).stdout.splitlines()
