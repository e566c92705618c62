"""What computes in the pages: the scripts of `mkt/live` as one, and their data.

A browser neither imports modules nor starts workers from pages on a disk.  So the
modules are joined into one plain script, in the order of their imports, and the worker
is a second one, whose text the first carries.  Data are scripts too, since such pages
may not fetch.
"""

import base64
import json
import re
from collections.abc import Iterable
from itertools import islice
from typing import Any

import cv2
import matplotlib
import numpy as np

from mkt.colors import SPACES, ColorBins
from mkt.figures.film import webm
from mkt.figures.registry import FIGURES
from mkt.files import PACKAGE
from mkt.papers.teuliere2009.histograms import still
from mkt.plotting import SURFACE
from mkt.scenes.textures import OBJECTS
from mkt.sequences.carphone import carphone
from mkt.types import Frame, NDArray

MODULES = PACKAGE / "live"
SCRIPT = "live.js"
IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./(\w+)\.js";', re.MULTILINE)
EXPORT = re.compile(
    r"^export ((?:async )?(?:const|function|class) (\w+))", re.MULTILINE
)
QUALITY = 50  # of frames that are only looked at
PLAYED = 75  # frames of the clip, a quarter of a megabyte less than all
LOSSLESS = (cv2.IMWRITE_WEBP_QUALITY, 101)
LOSSY = (cv2.IMWRITE_WEBP_QUALITY, QUALITY)


def scripts() -> dict[str, str]:
    """{name below the static folder: text} of all that the live figures need."""
    data = {"surfaces": _surfaces(), "newton": _newton(), "track": _clip()}
    data |= {
        f"surfaces-{item}-{space}": _object(item, ColorBins(space))
        for item in OBJECTS
        for space in SPACES
    }
    return {SCRIPT: bundle()} | {
        f"live/{name}.js": f"(globalThis.mktData ??= {{}})[{json.dumps(name)}] = "
        f"{json.dumps(content)};\n"
        for name, content in data.items()
    }


def bundle() -> str:
    """The modules as one script that stands for itself."""
    worker = json.dumps(f'"use strict";\n{joined("worker")}')
    page = f"const WORKER = {worker};\n{joined('start')}"
    return f'"use strict";\n(() => {{\n{page}}})();\n'


def joined(name: str, known: set[str] | None = None) -> str:
    """A module after all that it imports, each a function that returns its exports."""
    known = set() if known is None else known
    known.add(name)
    text = (MODULES / f"{name}.js").read_text(encoding="utf-8")
    needed = [other for _, other in IMPORT.findall(text) if other not in known]
    before = "".join(joined(other, known) for other in needed if other not in known)
    exported = ", ".join(found for _, found in EXPORT.findall(text))
    text = EXPORT.sub(r"\1", IMPORT.sub(r"const \1 = \2_js;", text))
    body = f"{text}\nreturn {{ {exported} }};"
    return f"{before}const {name}_js = (() => {{\n{body}\n}})();\n"


def _surfaces() -> dict[str, Any]:
    """What figure 3 needs whatever the object."""
    sliders = FIGURES["teuliere2009.fig3"].sliders
    colors = matplotlib.colormaps[SURFACE](np.arange(256), bytes=True)[:, :3]
    return {
        "viridis": colors.tolist(),
        "items": sliders["item"],
        "layouts": sliders["layout"],
        "spans": sliders["span"][:2],
        "extents": sliders["extent"][:2],
    }


def _newton() -> dict[str, Any]:
    """What own.newton needs beside the car of figure 3."""
    sliders = FIGURES["own.newton"].sliders
    return {
        "layouts": sliders["layout"],
        "spans": sliders["span"][:2],
        "scales": sliders["scale"][:2],
    }


def _object(item: str, bins: ColorBins) -> dict[str, Any]:
    """The frames of figure 3: one to look at, and the bins of both."""
    clip = still(item)
    return {
        "region": clip.truth[0].tolist(),
        "frame": _uri("webp", cv2.imencode(".webp", _bgr(clip.frames[1]), LOSSY)[1]),
        "m": bins.m,
        "bins": _bins(clip.frames, bins),
    }


def _bins(frames: Iterable[Frame], bins: ColorBins) -> str:
    """Two bin images as one picture: low bytes in red and green, high bits in blue."""
    first, second = (bins(frame).labels.astype(np.uint16) for frame in frames)
    high = (first >> 8) | (second >> 8) << 4
    rgb = np.dstack([first & 255, second & 255, high]).astype(np.uint8)
    return _uri("webp", cv2.imencode(".webp", _bgr(rgb), LOSSLESS)[1])


def _clip() -> dict[str, Any]:
    """The clip that the camera's page plays where there is no camera."""
    clip = carphone()
    film, _ = webm(islice(clip.frames, PLAYED), clip.fps)
    return {
        "film": _uri("webm", np.frombuffer(film, np.uint8), "video"),
        "region": clip.truth[0].tolist(),
        "source": clip.source,
    }


def _bgr(frame: Frame) -> NDArray:
    return cv2.cvtColor(frame, cv2.COLOR_RGB2BGR)


def _uri(kind: str, data: NDArray, family: str = "image") -> str:
    return f"data:{family}/{kind};base64,{base64.b64encode(data.tobytes()).decode()}"
