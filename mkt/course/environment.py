"""The environment of all commands: ``.venv``, made from environment.txt.

It is made by uv where there is one, else by pip, and takes nothing whose hash is not in
the list.  Only the standard library is used here, so that it starts on a bare Python.
The stamp of an environment is written last: a set-up that was interrupted carries the
word `UNFINISHED` instead, and the next run begins it again.  Where a user has installed
the library by hand, nothing is made: commands run in that environment.

Reading order: `ensure`, `build`.
"""

import hashlib
import importlib.metadata
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from mkt.files import ROOT, alone, is_clone, whole

VENV = ROOT / ".venv"
LOCK = ROOT / ".venv.lock"
PYTHON = VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
REQUIREMENTS = ROOT / "environment.txt"
STAMP_NAME = "mkt-stamp"
UNFINISHED = "unfinished"
# The package networkx is no network.
TROUBLE = re.compile(
    r"connection|resolve|dns|\bnetwork\b|timed out|failed to fetch"
    r"|no matching distribution found"
)
COST = "the download of 330 MB; it takes 1.5 GB of disk"
NO_VENV = """\
This Python lacks the modules venv and ensurepip.
On Debian or Ubuntu: sudo apt install python3-venv
(or python{}.{}-venv), on Fedora: sudo dnf install python3-pip.  Then run this again."""
READ_ONLY = (
    "{} cannot be written, and has no environment for this Python.  Clone into a "
    "folder of your own, or let whoever keeps this one set it up for all, as in "
    "README.md."
)
NO_NETWORK = """\
The packages could not be fetched: this first step needs a network connection
(or a proxy or mirror that pip is told of).
Run the same command again when it is there: it begins anew what is half made."""
FAILED = """\
The set-up failed, the lines above say why.
Run the same command again once it is mended: it begins anew what is half made."""

# With all processors, which takes half as long as pip, who has one.  Files that are no
# Python of today stay as they are.
COMPILE = (
    "import compileall, sysconfig; "
    "compileall.compile_dir(sysconfig.get_path('purelib'), quiet=2, workers=0)"
)

Step = tuple[str, list[str]]  # what it does, and its command


def wanted_stamp() -> str:
    """What the environment must have been made from.

    That is both lists of packages, the version of Python, and this place.
    """
    lists = REQUIREMENTS.read_bytes() + (ROOT / "pyproject.toml").read_bytes()
    here = f"{sys.version.split()[0]} {ROOT}".encode()
    return hashlib.sha256(lists + here).hexdigest()


def is_by_hand() -> bool:
    """Whether somebody has installed this library into this Python, with pip.

    Then they look after its packages, and no other environment is made.
    """
    if not is_clone():
        return True
    found = importlib.metadata.distributions(name="mkt")
    origins = (one.read_text("direct_url.json") for one in found)
    urls = {json.loads(origin)["url"] for origin in origins if origin}
    own = Path(sys.prefix).resolve() == VENV.resolve()
    return ROOT.as_uri() in urls and not own


def is_current() -> bool:
    """Whether this very program runs in the environment that is wanted."""
    return is_clone() and stamp_of(Path(sys.prefix)) == wanted_stamp()


def is_made() -> bool:
    """Whether ``.venv`` is the environment that is wanted."""
    return stamp_of(VENV) == wanted_stamp()


def stamp_of(environment: Path) -> str | None:
    """What an environment was made from.

    It is the word for a half-made one, and None when this program did not make it, as
    far as can be read.
    """
    try:
        return (environment / STAMP_NAME).read_text("utf-8", "replace")
    except OSError:
        return None


def has_installer() -> bool:
    """Whether there is uv, or pip can be had in a new environment."""
    modules = "venv", "ensurepip"
    return bool(shutil.which("uv") or all(map(importlib.util.find_spec, modules)))


def ensure() -> None:
    """Make ``.venv``, or renew it, unless it is as wanted already."""
    if not (is_made() and PYTHON.exists()):
        if not os.access(ROOT, os.W_OK):
            sys.exit(READ_ONLY.format(ROOT))
        with alone(LOCK, "set-up"):
            make()


def make() -> None:
    """Make ``.venv``, or renew it, unless somebody else has done so meanwhile."""
    found = stamp_of(VENV)
    if found == wanted_stamp() and PYTHON.exists():
        return
    if trouble := obstacle():
        what, remedy = trouble
        sys.exit(f"{what}, and is left as it is: {remedy}, then run this again.")
    if Path(sys.prefix).resolve() == VENV.resolve():
        sys.exit(
            "The list of packages has changed, and .venv cannot be renewed from within."
            "  Leave it with `deactivate`, then run this again."
        )
    build(renew=found not in (None, UNFINISHED))


def obstacle() -> tuple[str, str] | None:
    """What stands where ``.venv`` is to be made, and the remedy; None for nothing."""
    if VENV.is_symlink():
        return f"{VENV} is a link to an environment of others", "delete the link"
    if stamp_of(VENV) is None and VENV.exists() and any(VENV.iterdir()):
        return f"{VENV} was not made by mkt", "move it away or delete it"
    return None


def build(renew: bool) -> None:
    """Make ``.venv`` from nothing.

    The stamp comes last, so whatever stops this, the next run begins it again.
    """
    if not has_installer():
        sys.exit(NO_VENV.format(*sys.version_info[:2]))
    uv = shutil.which("uv")
    if renew:
        say(f"The list of packages has changed: renewing {VENV}")
    else:
        say(f"First use: setting up {VENV}")
    how = "uv, some seconds" if uv else "pip, one or two minutes"
    say(f"with {how} plus {COST}.")
    clear()
    work = steps(uv)
    for number, (doing, command) in enumerate(work, 1):
        say(f"  {number}/{len(work)} {doing}")
        execute(command)
    mark(wanted_stamp())
    say("Set up.")


def clear() -> None:
    """Empty ``.venv`` and mark it as unfinished; the mark stays while the rest goes."""
    VENV.mkdir(exist_ok=True)
    mark(UNFINISHED)
    for path in VENV.iterdir():
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        elif path.name != STAMP_NAME:
            path.unlink()


def mark(stamp: str) -> None:
    """Write what ``.venv`` was made from."""
    with whole(VENV / STAMP_NAME) as half:
        half.write_text(stamp, "utf-8")


def steps(uv: str | None) -> list[Step]:
    """The commands of a set-up.

    The packages of the list are checked against their hashes; the clone, which has
    none, comes after them and fetches nothing.  What pip has installed is compiled, so
    that it starts as fast for those who may not write there.
    """
    python = str(PYTHON)
    if uv:
        make = [uv, "venv", "--quiet", "--allow-existing", "--seed"]
        make += ["--python", sys.executable, str(VENV)]
        pip = [uv, "pip", "install", "--quiet", "--python", python]
    else:
        make = [sys.executable, "-m", "venv", str(VENV)]
        pip = [python, "-m", "pip", "install", "--disable-pip-version-check"]
        pip += ["--no-compile"]
    listed = ["--require-hashes", "--only-binary", ":all:", "-r", str(REQUIREMENTS)]
    clone = ["--no-deps", "--no-build-isolation", "-e", str(ROOT)]
    return [
        ("making the environment", make),
        ("installing the packages", [*pip, *listed]),
        *([] if uv else [("compiling them", [python, "-c", COMPILE])]),
        ("installing this clone", [*pip, *clone]),
    ]


def execute(command: list[str]) -> None:
    """Run one step, counting the packages where somebody watches.

    Ends the program with a plain message when it fails.
    """
    lines: list[str] = []
    with subprocess.Popen(
        command,
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    ) as process:
        try:
            for line in process.stdout or ():
                lines.append(line)
                if sys.stderr.isatty():
                    count(lines)
        except KeyboardInterrupt:
            process.kill()  # a SIGTERM has not reached it, as Ctrl-C has
            raise
    if process.returncode:
        fail("".join(lines[-12:]))


def count(lines: list[str]) -> None:
    """Show on one line how far pip has come, from what it printed so far."""
    if lines[-1].startswith("Collecting"):
        done = sum(line.startswith("Collecting") for line in lines)
        total = REQUIREMENTS.read_text("utf-8").count("==")
        name = lines[-1].split()[1][:50]
        sys.stderr.write(f"\r      {done} of about {total}: {name:<50}")
    elif lines[-1].startswith("Installing collected"):
        sys.stderr.write(f"\r      {'unpacking':<66}\n")


def fail(output: str) -> None:
    """Say what went wrong in one sentence, after the last words of the installer."""
    sys.stderr.write(f"\n{output}\n")
    if TROUBLE.search(output.lower()):
        sys.exit(NO_NETWORK)
    sys.exit(FAILED)


def say(text: str) -> None:
    """A line of progress, apart from the command's own output."""
    print(text, file=sys.stderr, flush=True)


def become(command: list[str]) -> int:
    """Run a command in this program's place; returns the exit code.

    Then Ctrl-C reaches this command and nothing else.
    """
    if os.name != "nt":
        os.execv(command[0], command)
    process = subprocess.Popen(command)
    while True:
        try:
            return process.wait()
        except KeyboardInterrupt:  # the command got it too, and decides when to end
            continue
