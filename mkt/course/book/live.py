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
from itertools import islice, product
from typing import Any

import cv2
import matplotlib
import numpy as np

from mkt.colors import SPACES, ColorBins
from mkt.evaluation import HIT, LAST, SEEN
from mkt.figures.film import webm
from mkt.figures.registry import FIGURES
from mkt.figures.static_panel import label
from mkt.files import PACKAGE
from mkt.papers.lessons import beats, benchmark
from mkt.papers.lessons.trackers import spread_distances
from mkt.papers.teuliere2009 import tracking
from mkt.papers.teuliere2009.histograms import WIDTH, still
from mkt.plotting import EIGHT, SURFACE, bin_colors
from mkt.plotting import TRACKERS as COLORS
from mkt.scenes.drawn import Drawn
from mkt.scenes.rendering import Layer, Scene, regions
from mkt.scenes.teuliere2009 import hidden
from mkt.scenes.textures import OBJECTS, texture
from mkt.sequences.carphone import carphone
from mkt.trackers.by_name import LABELS, SLOW, TRACKERS
from mkt.types import Frame, NDArray

MODULES = PACKAGE / "live"
SCRIPT = "live.js"
COMMENT = re.compile(r"^ *//.*\n", re.MULTILINE)
IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./(\w+)\.js";', re.MULTILINE)
EXPORT = re.compile(
    r"^export ((?:async )?(?:const|function|class) (\w+))", re.MULTILINE
)
QUALITY = 50  # of frames that are only looked at
PLAYED = 75  # frames of the clip, a quarter of a megabyte less than all
STEP = 0.25  # frames between the places of a path: its shutter opens and shuts at them
BRICKS = 200  # [px] across, of the picture of a screen
LOSSLESS = (cv2.IMWRITE_WEBP_QUALITY, 101)
FINE = (cv2.IMWRITE_WEBP_QUALITY, 92)  # of what is binned
LOSSY = (cv2.IMWRITE_WEBP_QUALITY, QUALITY)


def scripts() -> dict[str, str]:
    """{name below the static folder: text} of all that the live figures need."""
    data = {
        "beats": _beats(),
        "fig1": _histograms(),
        "fig2": {"fields": _fields("teuliere2009.fig2")},
        "fig3": {"fields": _fields("teuliere2009.fig3"), "viridis": _viridis()},
        "fig4": _blur(),
        "fig6": _wall(),
        "newton": {"fields": _fields("own.newton")},
        "resampling": _resampling(),
        "root_locus": {"fields": _fields("own.root_locus"), "viridis": _viridis()},
        "success": _success(),
        "track": _clip(),
    }
    data |= {
        f"surfaces-{item}-{space}": _object(item, ColorBins(space))
        for item in OBJECTS
        for space in SPACES
    } | {f"sprite-{item}": _sprite(item) for item in OBJECTS}
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
    text = COMMENT.sub("", text)  # a third of what a reader would load
    text = EXPORT.sub(r"\1", IMPORT.sub(r"const \1 = \2_js;", text))
    body = f"{text}\nreturn {{ {exported} }};"
    return f"{before}const {name}_js = (() => {{\n{body}\n}})();\n"


def _beats() -> dict[str, Any]:
    """The film of own.beats: what it is painted of, and where the car is."""
    scene = beats.film()
    car = _reduced(scene.target.texture, 2 * round(scene.target.width))
    return {
        "size": scene.size,
        "truth": scene.sequence().truth.round(3).tolist(),
        "ground": _ground(),
        "car": _uri("webp", _webp(car, LOSSLESS)),
        "bricks": _uri("webp", _webp(_reduced("bricks", round(beats.BRICKS)))),
        "fields": _fields("own.beats"),
    }


def _wall() -> dict[str, Any]:
    """What figure 6 is painted of, beside the ground and the car of own.beats."""
    fields = _fields("teuliere2009.fig6")
    scenes = [hidden(seed) for seed in map(int, fields["seed"]["options"])]
    scene = scenes[0]
    times = np.arange(-1, scene.length + STEP, STEP)
    paths = [regions(each, each.target, times) for each in scenes]
    return {
        "fields": fields,
        "size": scene.size,
        "length": scene.length,
        "shutter": scene.shutter,
        "first": tracking.FIRST,
        "runs": tracking.RUNS,
        "limits": {"seen": SEEN, "last": LAST, "hit": HIT},
        "times": [-1, STEP],
        "halves": paths[0][0, 3:].tolist(),
        "paths": [path[:, :3].round(3).tolist() for path in paths],
        "bricks": _uri("webp", _webp(_reduced("bricks", BRICKS), FINE)),
        "trackers": [
            {"name": name, "label": LABELS[name], "color": color}
            for name, color in COLORS.items()
        ],
    }


def _ground() -> str:
    """The workshop without anything before it."""
    nobody = Layer("car", 1.0, ((0.0, -999.0, 0.0, 0.0, 1.0),))
    empty = Scene(nobody, length=1, noise=0.0).sequence().frames[0]
    return _uri("webp", _webp(empty, LOSSLESS))


def _blur() -> dict[str, Any]:
    """What figure 4 needs whatever the object."""
    fields = {"fields": _fields("teuliere2009.fig4"), "viridis": _viridis()}
    return fields | {"ground": _ground()}


def _sprite(item: str) -> dict[str, str]:
    """An object as a frame shows it, without the frame."""
    return {"picture": _uri("webp", _webp(_reduced(item, round(WIDTH)), LOSSLESS))}


def _reduced(name: str, width: int) -> NDArray:
    """A texture (h, width, 4) of so many pixels across."""
    rgba = texture(name)
    height = round(width * rgba.shape[0] / rgba.shape[1])
    return cv2.resize(rgba, (width, height), interpolation=cv2.INTER_AREA)


def _histograms() -> dict[str, Any]:
    """What figure 1 needs whatever the object: the colour of each bin."""
    colors = {
        space: (255 * bin_colors(ColorBins(space))).round().astype(int).tolist()
        for space in SPACES
    }
    return {"fields": _fields("teuliere2009.fig1"), "colors": colors}


def _resampling() -> dict[str, Any]:
    """What own.resampling draws: distances for each number, darts for each seed."""
    fields = _fields("own.resampling")
    n, seed = fields["n"], fields["seed"]
    numbers = range(n["low"], n["high"] + 1)
    seeds = range(seed["low"], seed["high"] + 1)
    return {
        "fields": fields,
        "distances": {k: spread_distances(k).tolist() for k in numbers},
        "uniforms": [
            np.random.default_rng(k).random(n["high"]).tolist() for k in seeds
        ],
        "colors": EIGHT,
    }


def _success() -> dict[str, Any]:
    """The runs of own.success: overlaps in the seen frames, and how many there are."""
    entry = FIGURES["own.success"]
    names = [name for name in TRACKERS if name not in SLOW]
    recorded = {}
    for scene, seed in product(entry.sliders["scene"], entry.sliders["seed"]):
        iou = benchmark.overlaps_on(Drawn(scene, seed), names)
        seen = iou[:, np.isfinite(iou[0])].round(4).tolist()
        recorded[f"{scene} {seed}"] = {"seen": seen, "frames": iou.shape[1] - 1}
    styles = zip(names, benchmark.styles(names), strict=True)
    trackers = [
        {"label": LABELS[name], "color": style["color"], "dashes": style["ls"]}
        for name, style in styles
    ]
    return {"fields": _fields(entry.name), "trackers": trackers, "runs": recorded}


def _viridis() -> list[list[int]]:
    """The colours of surfaces, from low to high."""
    colors = matplotlib.colormaps[SURFACE](np.arange(256), bytes=True)[:, :3]
    return colors.tolist()


def _fields(name: str) -> dict[str, dict[str, Any]]:
    """What the page's controls of a figure need to know of its sliders."""
    entry = FIGURES[name]
    return {
        slider: _field(positions, entry.defaults[slider])
        for slider, positions in entry.sliders.items()
    }


def _field(positions: Any, value: Any) -> dict[str, Any]:
    if isinstance(positions, list):
        return {"options": [label(each) for each in positions], "value": label(value)}
    low, high, step = positions
    return {"low": low, "high": high, "step": step, "value": value}


def _object(item: str, bins: ColorBins) -> dict[str, Any]:
    """The frames of figure 3: one to look at, and the bins of both."""
    clip = still(item)
    return {
        "region": clip.truth[0].tolist(),
        "frame": _uri("webp", _webp(clip.frames[1])),
        "m": bins.m,
        "bins": _bins(clip.frames, bins),
    }


def _bins(frames: Iterable[Frame], bins: ColorBins) -> str:
    """Two bin images as one picture: low bytes in red and green, high bits in blue."""
    first, second = (bins(frame).labels.astype(np.uint16) for frame in frames)
    high = (first >> 8) | (second >> 8) << 4
    rgb = np.dstack([first & 255, second & 255, high]).astype(np.uint8)
    return _uri("webp", _webp(rgb, LOSSLESS))


def _clip() -> dict[str, Any]:
    """The clip that the camera's page plays where there is no camera."""
    clip = carphone()
    film, _ = webm(islice(clip.frames, PLAYED), clip.fps)
    return {
        "film": _uri("webm", np.frombuffer(film, np.uint8), "video"),
        "region": clip.truth[0].tolist(),
        "source": clip.source,
    }


def _webp(picture: NDArray, options: tuple[int, int] = LOSSY) -> NDArray:
    """A picture (h, w, 3) or, with its opacity, (h, w, 4) as the bytes of a file."""
    opaque = picture.shape[2] == 3
    code = cv2.COLOR_RGB2BGR if opaque else cv2.COLOR_RGBA2BGRA
    return cv2.imencode(".webp", cv2.cvtColor(picture, code), options)[1]


def _uri(kind: str, data: NDArray, family: str = "image") -> str:
    return f"data:{family}/{kind};base64,{base64.b64encode(data.tobytes()).decode()}"
