"""What is wrong with this machine, and how to mend it: ``python3 -m mkt doctor``.

Each check is a generator of `Finding` objects, and none of them stops the others.  The first ones need only the standard library, so that
they run where the set-up itself fails.
"""

import importlib.metadata
import importlib.util
import os
import platform
import shutil
import struct
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from mkt import __main__ as bootstrap

ROOM = 2.0  # [GB] for the environment, the caches and the book
FINE, NOTE, WRONG = "ok", "note", "wrong"
CODEC_SIZE, CODEC_FRAMES = (64, 48), 5
EXTENSIONS = {"ipywidgets": "@jupyter-widgets/jupyterlab-manager", "anywidget": "anywidget"}  # what draws the sliders, and the box by mouse


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at: `FINE`, `NOTE` or `WRONG`, its name, what was found, and how to mend it."""

    state: str
    name: str
    found: str
    remedy: str = ""

    def __str__(self):
        return f"{self.state:6}{self.name:14}{self.found}" + f"\n{'':20}-> {self.remedy}" * bool(self.remedy)


def main():
    """Print all findings as they come.  Returns the exit code: 1 when something is wrong."""
    findings = []
    for finding in diagnose():
        print(finding, flush=True)
        findings.append(finding)
    wrong = sum(finding.state == WRONG for finding in findings)
    print(f"\n{wrong} thing{'s' * (wrong > 1)} to mend, see the arrows above." if wrong else "\nNothing is wrong.")
    return int(wrong > 0)


def diagnose():
    """All findings, one after the other."""
    yield from machine()
    yield from environment()
    if bootstrap.stamp_of(Path(sys.prefix)) == bootstrap.wanted_stamp():
        for check in (packages, one_opencv, codecs, widgets, kernel, data_sets, browser):
            yield from check()


def machine():
    """Python, the processor and the room on the disk."""
    bits = struct.calcsize("P") * 8
    yield Finding(FINE if bits == 64 else WRONG, "Python", f"{platform.python_version()}, {bits} bit, {platform.system()} {platform.machine()}",
                  "" if bits == 64 else "the packages come for 64 bit only: install a 64-bit Python")
    cores = os.cpu_count() or 1
    yield Finding(FINE if cores > 1 else NOTE, "cores", str(cores), "" if cores > 1 else "the book is executed on two at a time; it will take twice as long")
    free = shutil.disk_usage(bootstrap.ROOT).free / 1e9
    enough = free > ROOM or bootstrap.VENV.exists()
    yield Finding(FINE if enough else WRONG, "disk", f"{free:.1f} GB free", "" if enough else f"make room for {ROOM:g} GB, or move the checkout")
    if not os.access(bootstrap.ROOT, os.W_OK):
        yield Finding(WRONG, "folder", f"{bootstrap.ROOT} cannot be written", "clone into a folder of your own: environment, caches and book live beside the code")


def environment():
    """Whether the environment of this program, or .venv, is as it should be, or could be made."""
    stamp = bootstrap.stamp_of(bootstrap.VENV)
    if bootstrap.wanted_stamp() in (stamp, bootstrap.stamp_of(Path(sys.prefix))):
        yield Finding(FINE, "environment", "set up")
    elif stamp is None and bootstrap.VENV.exists() and any(bootstrap.VENV.iterdir()):
        yield Finding(WRONG, "environment", f"{bootstrap.VENV} was not made by mkt", "move it away or delete it")
    else:
        words = {None: "not set up yet", bootstrap.UNFINISHED: "the set-up was stopped half-way"}.get(stamp, "the list of packages, Python or the folder has changed")
        yield Finding(NOTE, "environment", words, "`python3 -m mkt lab`, or any other command, sets it up and needs the network for it")
    if not shutil.which("uv") and not (importlib.util.find_spec("venv") and importlib.util.find_spec("ensurepip")):
        yield Finding(WRONG, "venv", "this Python lacks the modules venv and ensurepip", "on Debian or Ubuntu: sudo apt install python3-venv")


def packages():
    """The installed versions against environment.txt."""
    from packaging.requirements import Requirement

    lines = bootstrap.REQUIREMENTS.read_text(encoding="utf-8").splitlines()
    wanted = [Requirement(line) for line in lines if line and line[0] not in "#-"]
    here = [r for r in wanted if r.marker is None or r.marker.evaluate()]
    off = [f"{r.name} is {_version(r.name) or 'missing'}, not {r.specifier}" for r in here if not r.specifier.contains(_version(r.name) or "0")]
    yield Finding(WRONG if off else FINE, "packages", "; ".join(off[:3]) + ", ..." * (len(off) > 3) if off else f"{len(here)} as listed",
                  f"delete {bootstrap.VENV} and run this again" if off else "")


def _version(name):
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return ""


def one_opencv():
    """Two wheels of OpenCV write into one folder, and the one that came first is broken."""
    wheels = [name for name in ("opencv-python", "opencv-python-headless", "opencv-contrib-python", "opencv-contrib-python-headless") if _version(name)]
    yield Finding(FINE if len(wheels) == 1 else WRONG, "OpenCV", ", ".join(f"{name} {_version(name)}" for name in wheels),
                  "" if len(wheels) == 1 else f"two share one folder: delete {bootstrap.VENV} and run this again")


def codecs():
    """Every format that `mkt.recording` writes is written and read back."""
    import numpy as np

    from mkt import recording
    from mkt.video import VideoFile

    picture = np.random.default_rng(0).integers(0, 256, (*CODEC_SIZE[::-1], 3), np.uint8)
    for ending, codec in recording.CODECS.items():
        try:
            with TemporaryDirectory() as folder:
                path = Path(folder) / f"try{ending}"
                with recording.video(path, CODEC_SIZE, 25) as writer:
                    for _ in range(CODEC_FRAMES):
                        writer.write(picture)
                frames = len(VideoFile(path))
            trouble = "" if frames == CODEC_FRAMES else f"{frames} of {CODEC_FRAMES} frames came back"
        except (OSError, ValueError) as error:
            trouble = str(error)
        yield Finding(WRONG if trouble else FINE, f"video {ending}", trouble or f"{codec}, written and read back", "choose another ending with -o" if trouble else "")


def widgets():
    """The parts of JupyterLab that draw the sliders."""
    for package, extension in EXTENSIONS.items():
        there = (Path(sys.prefix) / "share/jupyter/labextensions" / extension / "package.json").is_file()
        yield Finding(FINE if there else WRONG, package, f"{_version(package)}, its part of JupyterLab is {'there' if there else 'missing'}",
                      "" if there else f"delete {bootstrap.VENV} and run this again")


def kernel():
    """Whether notebooks run in this environment: a kernel of the same name in the home folder would be taken first."""
    from jupyter_client.kernelspec import KernelSpecManager, NoSuchKernel

    try:
        spec = KernelSpecManager().get_kernel_spec("python3")
        own = Path(spec.argv[0]).parent == Path(sys.executable).parent or not Path(spec.argv[0]).is_absolute()
        yield Finding(FINE if own else WRONG, "kernel", spec.argv[0], "" if own else f"notebooks would run in that Python: delete {spec.resource_dir}")
    except NoSuchKernel:
        yield Finding(WRONG, "kernel", "no kernel named python3", f"delete {bootstrap.VENV} and run this again")


def data_sets():
    """The optional benchmarks."""
    from mkt import archives

    try:
        good, troubles = archives.usable()
        yield Finding(FINE, "data sets", f"{len(good)} sequences of {', '.join(dict.fromkeys(f.archive.name for f in good))}" if good
                      else "none, and none is needed; `python3 -m mkt data` lists those that can be used")
    except ValueError as error:
        troubles = [str(error)]
    for trouble in troubles:
        yield Finding(WRONG, "data sets", trouble, "or unset MKT_DATA: everything works without")


def browser():
    """What the tests in a browser would take."""
    found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    yield Finding(FINE if found else NOTE, "browser", found or "no Chromium or Chrome on the path", "" if found else "the tests in a browser are skipped; reading the book needs any browser")
