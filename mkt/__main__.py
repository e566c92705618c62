"""``python3 -m mkt COMMAND``: set up once, then run the command.  Only the standard library, so that it starts on a bare Python.

The environment lives in ``.venv``, made from environment.txt by uv where there is one, else by pip.  Its stamp is written last: a set-up
that was interrupted carries the word `UNFINISHED` instead, and the next run begins it again.  Reading order: `main`, `ensure`, `build`.
"""

import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
PYTHON = VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
REQUIREMENTS = ROOT / "environment.txt"
STAMP_NAME = "mkt-stamp"
UNFINISHED = "unfinished"
OLDEST = (3, 11)
TROUBLE = ("connection", "resolve", "dns", "network", "timed out", "failed to fetch", "no matching distribution found")


def main():
    """Check the Python and the command line, see to the environment, run the command in it; returns the exit code."""
    if sys.version_info < OLDEST:
        sys.exit("mkt needs Python 3.11 or later, and this is Python {}.{}.  Install a newer one (python.org, or your system's packages)\n"
                 "and call it by name, for example: python3.11 -m mkt book".format(*sys.version_info[:2]))
    from mkt import cli  # not before the check: an old Python could not even read it

    args = cli.parse(sys.argv[1:])  # --help and mistyped commands end here, before anything is installed
    if stamp_of(Path(sys.prefix)) == wanted_stamp():
        return cli.run(args)
    if args.command == "doctor" and stamp_of(VENV) != wanted_stamp():
        return cli.run(args)  # it is asked for where the set-up fails
    ensure()
    return become([str(PYTHON), "-m", "mkt", *sys.argv[1:]])


def become(command):
    """Run a command in this program's place, so that Ctrl-C reaches it and nobody else; returns the exit code."""
    if os.name != "nt":
        os.execv(command[0], command)
    process = subprocess.Popen(command)
    while True:
        try:
            return process.wait()
        except KeyboardInterrupt:  # the command got it too, and decides when to end
            continue


def wanted_stamp():
    """What the environment must have been made from: both lists of packages, the version of Python, and this place."""
    sources = REQUIREMENTS.read_bytes() + (ROOT / "pyproject.toml").read_bytes()
    return hashlib.sha256(sources + f"{sys.version.split()[0]} {ROOT}".encode()).hexdigest()


def stamp_of(environment):
    """What an environment was made from, the word for a half-made one, or None when this program did not make it."""
    stamp = environment / STAMP_NAME
    return stamp.read_text() if stamp.is_file() else None


def ensure():
    """Make ``.venv``, or renew it, unless it is as wanted already."""
    found = stamp_of(VENV)
    if found == wanted_stamp() and PYTHON.exists():
        return
    if Path(sys.prefix).resolve() == VENV.resolve():
        sys.exit("The list of packages has changed, and .venv cannot be renewed from within.  Leave it with `deactivate`, then run this again.")
    if VENV.exists() and any(VENV.iterdir()) and found is None:
        sys.exit(f"{VENV} was not made by mkt and is left as it is.  Move it away or delete it, then run this again.")
    build(renew=found not in (None, UNFINISHED))


def build(renew):
    """Make ``.venv`` from nothing.  The stamp comes last, so whatever stops this, the next run begins it again."""
    uv = shutil.which("uv")
    if not uv and not (importlib.util.find_spec("venv") and importlib.util.find_spec("ensurepip")):
        sys.exit(f"This Python lacks the modules venv and ensurepip.  On Debian or Ubuntu: sudo apt install python3-venv\n"
                 f"(or python{sys.version_info[0]}.{sys.version_info[1]}-venv), on Fedora: sudo dnf install python3-pip.  Then run this again.")
    say(f"{'The list of packages has changed: renewing' if renew else 'First use: setting up'} {VENV}")
    say(f"with {'uv, some seconds' if uv else 'pip, one or two minutes'} plus the download of 250 MB; it takes 1.1 GB of disk.")
    clear()
    for number, (doing, command) in enumerate(steps(uv), 1):
        say(f"  {number}/2 {doing}")
        execute(command)
    (VENV / STAMP_NAME).write_text(wanted_stamp())
    say("Set up.")


def clear():
    """Empty ``.venv`` and mark it as unfinished; the mark stays while the rest is deleted."""
    VENV.mkdir(exist_ok=True)
    stamp = VENV / STAMP_NAME
    stamp.write_text(UNFINISHED)
    for path in VENV.iterdir():
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        elif path != stamp:
            path.unlink()


def steps(uv):
    """The two commands of a set-up, as (what it does, argument list)."""
    if uv:
        return [("making the environment", [uv, "venv", "--quiet", "--allow-existing", "--seed", "--python", sys.executable, str(VENV)]),
                ("installing the packages", [uv, "pip", "install", "--quiet", "--python", str(PYTHON), "-r", str(REQUIREMENTS)])]
    return [("making the environment", [sys.executable, "-m", "venv", str(VENV)]),
            ("installing the packages", [str(PYTHON), "-m", "pip", "install", "--disable-pip-version-check", "-r", str(REQUIREMENTS)])]


def execute(command):
    """Run one step, counting the packages where somebody watches; ends the program with a plain message when it fails."""
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    lines = []
    for line in process.stdout:
        lines.append(line)
        if sys.stderr.isatty():
            count(lines)
    if process.wait():
        fail("".join(lines[-12:]))


def count(lines):
    """Show on one line how far pip has come, from what it printed so far."""
    if lines[-1].startswith("Collecting"):
        done = sum(line.startswith("Collecting") for line in lines)
        total = REQUIREMENTS.read_text().count("==")
        sys.stderr.write(f"\r      {done} of about {total}: {lines[-1].split()[1][:50]:<50}")
    elif lines[-1].startswith("Installing collected"):
        sys.stderr.write(f"\r      {'unpacking':<66}\n")


def fail(output):
    """Say what went wrong in one sentence, after the last words of the installer."""
    sys.stderr.write(f"\n{output}\n")
    if any(word in output.lower() for word in TROUBLE):
        sys.exit("The packages could not be fetched: this first step needs a network connection (or a proxy or mirror that pip is told of).\n"
                 "Nothing is half made; run the same command again when it is there.")
    sys.exit("The set-up failed, the lines above say why.  Nothing is half made; run the same command again once it is mended.")


def say(text):
    """A line of progress, apart from the command's own output."""
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    try:
        code = main()
        sys.stdout.flush()
        sys.exit(code)
    except KeyboardInterrupt:
        say("\nStopped.  Nothing is half made; the next run takes up what is missing.")
        sys.exit(130)  # what shells expect of a program stopped by Ctrl-C
    except BrokenPipeError:  # `| head` has read enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or Python would complain again on its way out
        sys.exit(1)
