"""What is wrong with this machine, and how to mend it: ``python3 -m mkt doctor``.

Each check is a generator of `Finding` objects, and none of them stops the others.  The
first ones need only the standard library, so that they run where the set-up itself
fails.
"""

import importlib.metadata
import importlib.util
import os
import platform
import shutil
import struct
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from mkt.course import environment
from mkt.files import ELSEWHERE

FINE, NOTE, WRONG = "ok", "note", "wrong"
ROOM = 2.0  # [GB] for the environment, the caches and the book
PICTURE_SIZE = (64, 48)  # [px] of what is written in each video format
PICTURES = 5
# What draws the sliders, and the box by mouse: packages and their parts of JupyterLab.
EXTENSIONS = {
    "ipywidgets": "@jupyter-widgets/jupyterlab-manager",
    "anywidget": "anywidget",
}
OPENCV = (
    "opencv-python",
    "opencv-python-headless",
    "opencv-contrib-python",
    "opencv-contrib-python-headless",
)
# Of Chromium without a window first: the tests take half the CPU with it.
BROWSERS = (
    "chromium-headless-shell",
    "chromium",
    "chromium-browser",
    "google-chrome",
    "msedge",
)


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at.

    Parameters
    ----------
    state : str
        `FINE`, `NOTE` or `WRONG`.
    name : str
    found : str
    remedy : str
        How to mend it.
    """

    state: str
    name: str
    found: str
    remedy: str = ""

    def __str__(self) -> str:
        line = f"{self.state:6}{self.name:14}{self.found}"
        return f"{line}\n{'':20}-> {self.remedy}" if self.remedy else line


def main() -> int:
    """Print all findings as they come.

    Returns
    -------
    int
        The exit code: 1 when something is wrong.
    """
    wrong = 0
    for finding in diagnose():
        print(finding, flush=True)
        wrong += finding.state == WRONG
    if wrong == 0:
        print("\nNothing is wrong.")
        return 0
    things = "1 thing" if wrong == 1 else f"{wrong} things"
    print(f"\n{things} to mend, see the arrows above.")
    return 1


def diagnose() -> Iterator[Finding]:
    """All findings, one after the other."""
    yield from machine()
    if environment.is_by_hand():
        words = f"{sys.prefix}, into which somebody has installed the library"
        yield Finding(FINE, "environment", words)
        yield from each(codecs, data_sets)
        return
    yield from _folder(environment.ROOT)
    yield from virtual_environment()
    if environment.is_current():
        yield from each(
            packages, one_opencv, codecs, widgets, kernel, data_sets, browser
        )
        yield box()


def _judged(
    fine: bool, name: str, found: str, remedy: str, otherwise: str = WRONG
) -> Finding:
    """A finding that is fine, or else needs its remedy."""
    return (
        Finding(FINE, name, found) if fine else Finding(otherwise, name, found, remedy)
    )


def machine() -> Iterator[Finding]:
    """Python and the processor."""
    bits = struct.calcsize("P") * 8
    system = f"{platform.system()} {platform.machine()}"
    yield _judged(
        bits == 64,
        "Python",
        f"{platform.python_version()}, {bits} bit, {system}",
        "the packages come for 64 bit only: install a 64-bit Python",
    )
    cores = os.cpu_count() or 1
    yield _judged(
        cores > 1,
        "cores",
        str(cores),
        "the book is executed on two at a time; it will take twice as long",
        NOTE,
    )


def _folder(root: Path) -> Iterator[Finding]:
    """The room for what is made in the clone, and the right to make it."""
    free = shutil.disk_usage(root).free / 1e9
    yield _judged(
        free > ROOM or environment.VENV.exists(),
        "disk",
        f"{free:.1f} GB free",
        f"make room for {ROOM:g} GB, or move the checkout",
    )
    if not os.access(root, os.W_OK):
        found = f"{root} cannot be written"
        if environment.is_current():  # which somebody has set up for all
            yield Finding(NOTE, "folder", found, ELSEWHERE)
        else:
            yield Finding(WRONG, "folder", found, "clone into a folder of your own")


def virtual_environment() -> Iterator[Finding]:
    """Whether this program's environment, or .venv, is as wanted, or could be made."""
    yield _state_of_environment()
    if not environment.has_installer():
        yield Finding(
            WRONG,
            "venv",
            "this Python lacks the modules venv and ensurepip",
            "on Debian or Ubuntu: sudo apt install python3-venv",
        )


def _state_of_environment() -> Finding:
    stamp = environment.stamp_of(environment.VENV)
    here = environment.stamp_of(Path(sys.prefix))
    wanted = environment.wanted_stamp()
    if wanted == here or (wanted == stamp and environment.PYTHON.exists()):
        return Finding(FINE, "environment", "set up")
    if obstacle := environment.obstacle():
        return Finding(WRONG, "environment", *obstacle)
    words = {
        None: "not set up yet",
        environment.UNFINISHED: "the set-up was stopped half-way",
        wanted: "its Python is not there any more",
    }
    return Finding(
        NOTE,
        "environment",
        words.get(stamp, "the list of packages, Python or the folder has changed"),
        "`python3 -m mkt lab`, or any other command, sets it up and needs the network "
        "for it",
    )


def _anew() -> str:
    """The remedy for an environment that is not as the list of packages says."""
    return f"delete {environment.VENV} and run this again"


def packages() -> Iterator[Finding]:
    """The installed versions against environment.txt."""
    from packaging.requirements import Requirement

    lines = environment.REQUIREMENTS.read_text(encoding="utf-8").splitlines()
    # Comments, options and the hashes below a package begin otherwise.
    named = [line.rstrip(" \\") for line in lines if line[:1].isalnum()]
    wanted = [Requirement(line) for line in named]
    here = [one for one in wanted if one.marker is None or one.marker.evaluate()]
    off = [
        f"{one.name} is {_version(one.name) or 'missing'}, not {one.specifier}"
        for one in here
        if not one.specifier.contains(_version(one.name) or "0")
    ]
    shown = [*off[:3], "..."] if len(off) > 3 else off
    found = "; ".join(shown) or f"{len(here)} as listed"
    yield _judged(not off, "packages", found, _anew())


def _version(name: str) -> str:
    """The version of an installed package, "" where there is none."""
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return ""


def each(*checks: Callable[[], Iterator[Finding]]) -> Iterator[Finding]:
    """What the checks find; a broken package stops that one alone."""
    again = "install it again, with mkt" if environment.is_by_hand() else _anew()
    for check in checks:
        try:
            yield from check()
        except ImportError as error:
            name = check.__name__.replace("_", " ")
            yield Finding(WRONG, name, str(error), again)


def one_opencv() -> Iterator[Finding]:
    """Two wheels of OpenCV write into one folder, and the first of them is broken."""
    wheels = [name for name in OPENCV if _version(name)]
    yield _judged(
        len(wheels) == 1,
        "OpenCV",
        ", ".join(f"{name} {_version(name)}" for name in wheels) or "none",
        f"two share one folder: {_anew()}" if wheels else _anew(),
    )


def codecs() -> Iterator[Finding]:
    """Every format that `mkt.sequences.writing` writes is written and read back."""
    from mkt.sequences.writing import CODECS

    for ending, codec in CODECS.items():
        trouble = _trouble_with(ending)
        yield _judged(
            not trouble,
            f"video {ending}",
            trouble or f"{codec}, written and read back",
            "choose another ending with -o",
        )


def _trouble_with(ending: str) -> str:
    """What goes wrong when a video is written and read back, "" if nothing does."""
    import numpy as np

    from mkt.sequences.video import VideoFile
    from mkt.sequences.writing import video_writer

    width, height = PICTURE_SIZE
    rng = np.random.default_rng(0)
    picture = rng.integers(0, 256, (height, width, 3), np.uint8)
    try:
        with TemporaryDirectory() as folder:
            path = Path(folder) / f"try{ending}"
            with video_writer(path, PICTURE_SIZE, 25) as writer:
                for _ in range(PICTURES):
                    writer.write(picture)
            read = len(VideoFile(path))
    except (OSError, ValueError) as error:
        return str(error)
    return "" if read == PICTURES else f"{read} of {PICTURES} frames came back"


def widgets() -> Iterator[Finding]:
    """The parts of JupyterLab that draw the sliders."""
    folder = Path(sys.prefix) / "share" / "jupyter" / "labextensions"
    for package, extension in EXTENSIONS.items():
        there = (folder / extension / "package.json").is_file()
        state = "there" if there else "missing"
        found = f"{_version(package)}, its part of JupyterLab is {state}"
        yield _judged(there, package, found, _anew())


def kernel() -> Iterator[Finding]:
    """Whether notebooks run in this environment.

    A kernel of the same name in the home folder would be taken first.
    """
    from jupyter_client.kernelspec import KernelSpecManager, NoSuchKernel

    try:
        spec = KernelSpecManager().get_kernel_spec("python3")
    except NoSuchKernel:
        yield Finding(WRONG, "kernel", "no kernel named python3", _anew())
        return
    program = Path(spec.argv[0])
    own = program.parent == Path(sys.executable).parent or not program.is_absolute()
    yield _judged(
        own,
        "kernel",
        spec.argv[0],
        f"notebooks would run in that Python: delete {spec.resource_dir}",
    )


def data_sets() -> Iterator[Finding]:
    """The optional benchmarks."""
    from mkt.sequences import benchmarks

    try:
        good, troubles = benchmarks.usable()
    except (ValueError, OSError) as error:
        troubles = [str(error)]
    else:
        names = ", ".join(dict.fromkeys(one.archive.name for one in good))
        none = (
            "none, and none is needed; `python3 -m mkt data` lists those that can be "
            "used"
        )
        found = f"{len(good)} sequences of {names}" if good else none
        yield Finding(FINE, "data sets", found)
    remedy = "or unset MKT_DATA: everything works without"
    yield from (Finding(WRONG, "data sets", trouble, remedy) for trouble in troubles)


def box() -> Finding:
    """What keeps the students' programs apart where a teacher grades labs."""
    from mkt.course.labs import sandbox

    found = sandbox.program()
    why = sandbox.refusal()
    missing = "may not run" if found else "not on the path"
    return _judged(
        not why,
        "bubblewrap",
        f"{missing}, and only needed to grade labs" if why else str(found),
        why,
        NOTE,
    )


def browser() -> Iterator[Finding]:
    """What the tests in a browser would need."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    yield _judged(
        found is not None,
        "browser",
        found or "no Chromium or Chrome on the path",
        "the tests in a browser are skipped; reading the book needs any browser",
        NOTE,
    )
