"""Where the code of strangers runs: bubblewrap's box, and limits inside it.

In the box there is no network, no home and no other process; the system, Python and
the library can be read, and nothing can be written but a /tmp and a /dev/shm that
vanish; the latter is where Python's locks between processes are.
"""

import os
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import matplotlib
import psutil

from mkt.files import DATA, PACKAGE, ROOT

MISSING = (
    "bubblewrap, which keeps the students' programs away from your files and the "
    "network, is not on this machine: on Debian or Ubuntu, sudo apt install bubblewrap"
)
GIGABYTE = 2**30
MEMORY = 4 * GIGABYTE  # [bytes] of a process
TOGETHER = 6 * GIGABYTE  # [bytes] of all that a process has started, and itself
OFTEN = 0.2  # [s] between two looks at that
PROCESSES = 64
ROOM = GIGABYTE // 4  # [bytes] of all files in /tmp, and of those in /dev/shm
NOBODY = 65534
FONTS = "/tmp/matplotlib"
SYSTEM = ("/usr", "/etc/ld.so.cache", "/etc/alternatives")
LINKS = ("/bin", "/lib", "/lib64", "/sbin")  # into /usr, or folders on old systems


def program() -> str | None:
    """Where bubblewrap is, None without it."""
    return shutil.which("bwrap")


def refusal() -> str:
    """Why no box can be made here, in a sentence; "" where one can."""
    if not program():
        return MISSING
    done = subprocess.run(boxed(["true"]), capture_output=True, text=True)
    if done.returncode == 0:
        return ""
    return f"bubblewrap is on this machine, and may not run: {done.stderr.strip()}"


def boxed(command: list[str]) -> list[str]:
    """A command that runs another one in a box of its own."""
    readable = [*SYSTEM, *dict.fromkeys([sys.prefix, sys.base_prefix])]
    readable += [str(PACKAGE), str(DATA)]
    return [
        program() or "bwrap",
        *("--unshare-ipc", "--unshare-pid", "--unshare-net", "--unshare-uts"),
        *("--unshare-cgroup-try", "--die-with-parent", "--new-session", "--clearenv"),
        *_as_nobody(),
        *("--proc", "/proc", "--dev", "/dev"),
        *_writable("/dev/shm"),
        *_writable("/tmp"),
        *_fonts(),
        # Behind /tmp, which would hide a clone that is below it.
        *(word for path in readable for word in _bound(Path(path))),
        *(word for link in LINKS for word in _linked(Path(link))),
        *("--remount-ro", "/", "--remount-ro", "/dev", "--chdir", "/tmp"),
        *(word for pair in _environment().items() for word in ("--setenv", *pair)),
        *command,
    ]


def _as_nobody() -> list[str]:
    """Root keeps the right to become nobody, which `limit` does; others need no right.

    The number of root's processes cannot be limited.
    """
    if os.geteuid() == 0:
        rights = ("--cap-add", "CAP_SETUID", "--cap-add", "CAP_SETGID")
        return ["--cap-drop", "ALL", *rights]
    return ["--unshare-user", "--disable-userns", "--cap-drop", "ALL"]


def _bound(path: Path) -> list[str]:
    """Words that make a path readable, if it is there, and the folders above it."""
    above = [str(folder) for folder in reversed(path.parents)][1:]
    passed = [word for one in above for word in ("--perms", "0755", "--dir", one)]
    return [*passed, "--ro-bind-try", str(path), str(path)]


def _linked(link: Path) -> list[str]:
    if link.is_symlink():
        return ["--symlink", str(link.readlink()), str(link)]
    return ["--ro-bind-try", str(link), str(link)]


def _writable(path: str) -> list[str]:
    return ["--perms", "1777", "--size", str(ROOM), "--tmpfs", path]


def _fonts() -> list[str]:
    """Matplotlib's list of the fonts, which it would make anew every time."""
    lists = Path(matplotlib.get_cachedir()).glob("fontlist-*.json")
    places = ((str(path), f"{FONTS}/{path.name}") for path in lists)
    binds = [word for place in places for word in ("--ro-bind-try", *place)]
    return ["--perms", "1777", "--dir", FONTS, *binds]


def _environment() -> dict[str, str]:
    """All that a program in the box knows of its surroundings."""
    return {
        "HOME": "/tmp",
        "PATH": f"{sys.prefix}/bin:/usr/bin:/bin",
        "LANG": "C.UTF-8",
        "MPLCONFIGDIR": FONTS,
        "PYTHONPATH": str(ROOT),
        "PYTHONDONTWRITEBYTECODE": "1",
        "OPENBLAS_NUM_THREADS": "1",
        "OPENCV_FOR_THREADS_NUM": "1",
    }


def environment_outside() -> dict[str, str]:
    """The environment of a program that is trusted and has no box."""
    return os.environ | {"PYTHONPATH": str(ROOT)}


def limit() -> None:
    """Take from this process, for good, what a lab does not need."""
    import resource  # not on Windows, where there is no bubblewrap either

    if os.geteuid() == 0:
        os.setgroups([])
        os.setgid(NOBODY)
        os.setuid(NOBODY)
    for kind, most in (
        (resource.RLIMIT_AS, MEMORY),
        (resource.RLIMIT_NPROC, PROCESSES),
        (resource.RLIMIT_FSIZE, ROOM),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(kind, (most, most))


@contextmanager
def within(limit: float, late: Callable[[], object]) -> Iterator[None]:
    """Call `late` if what is inside the ``with`` takes longer [s]."""
    timer = threading.Timer(limit, late)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def used(pid: int) -> int:
    """The memory [bytes] of a process and all that it has started; 0 where it ended."""
    total = 0
    with suppress(psutil.Error):
        first = psutil.Process(pid)
        for process in (first, *first.children(recursive=True)):
            with suppress(psutil.Error):
                total += process.memory_info().rss
    return total


def watch(process: subprocess.Popen) -> None:
    """End a process, and its box with it, when all in it take too much memory.

    A limit of the system's is for each process, and there may be `PROCESSES` of them.
    """
    while process.poll() is None:
        if used(process.pid) > TOGETHER:
            process.kill()
        time.sleep(OFTEN)
