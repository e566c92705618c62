"""What live figures are given: objects, grounds, paths and recorded runs, as JSON.

Pictures that a figure bins are stored without loss: a compressed ground has a third of
its pixels in other bins, and trackers then lose what Python's do not lose.
"""

from collections.abc import Iterable
from functools import partial
from itertools import product
from typing import Any

import cv2
import matplotlib
import numpy as np

from mkt.colors import SPACES, ColorBins
from mkt.evaluation import HIT, LAST, SEEN
from mkt.figures.live import DATA
from mkt.figures.pictures import data_uri, image_file
from mkt.figures.registry import FIGURES
from mkt.papers import runs
from mkt.papers.cordoba2014 import resampling
from mkt.papers.lessons import beats, benchmark, chance, servoing
from mkt.papers.lessons.trackers import spread_distances
from mkt.papers.nummiaro2003 import steps
from mkt.papers.teuliere2009 import tracking
from mkt.papers.teuliere2009.histograms import HIGHEST, WIDTH, still
from mkt.plotting import CONTRAST, DESIRED, SURFACE, TWELVE, bin_colors
from mkt.plotting import TRACKERS as COLORS
from mkt.regions import corners
from mkt.scenes.drawn import Drawn
from mkt.scenes.layers import Layer
from mkt.scenes.nummiaro2003 import TREE, doors, students
from mkt.scenes.rendering import Scene, regions
from mkt.scenes.teuliere2009 import hidden
from mkt.scenes.textures import OBJECTS, texture
from mkt.servoing.controller import Servo
from mkt.servoing.features import Camera
from mkt.servoing.robot import Workspace
from mkt.trackers.adaptive import Adaptive
from mkt.trackers.appearance import background
from mkt.trackers.by_name import LABELS, quick
from mkt.types import Frame, NDArray

QUALITY = 50  # of frames that are only looked at
STEP = 0.25  # frames between the places of a path: its shutter opens and shuts at them
# [px] across the table's picture, enough for where each camera goes, and of half the
# car in it.
TABLE, WIDE_TABLE, HALF = 640, 860, 36
BRICKS = 200  # [px] across, of the picture of a screen
LOSSLESS = (cv2.IMWRITE_WEBP_QUALITY, 101)
LOSSY = (cv2.IMWRITE_WEBP_QUALITY, QUALITY)


@DATA.register("workshop")
def _workshop() -> dict[str, str]:
    """The workshop without anything before it."""
    nobody = Layer("car", 1.0, ((0.0, -999.0, 0.0, 0.0, 1.0),))
    empty = Scene(nobody, length=1, noise=0.0).sequence().frames[0]
    return {"picture": _picture(empty, LOSSLESS)}


@DATA.register("teuliere2009.fig3")
@DATA.register("teuliere2009.fig4")
@DATA.register("own.root_locus")
def _viridis() -> dict[str, list[list[int]]]:
    """The colours of surfaces, from low to high."""
    colors = matplotlib.colormaps[SURFACE](np.arange(256), bytes=True)[:, :3]
    return {"viridis": colors.tolist()}


@DATA.register("teuliere2009.fig1")
def _histograms() -> dict[str, Any]:
    """The colour of each bin, and where the axis of the bars ends."""
    return {
        "highest": HIGHEST,
        "colors": {
            space: (255 * bin_colors(ColorBins(space))).round().astype(int).tolist()
            for space in SPACES
        },
    }


def _object(item: str, bins: ColorBins) -> dict[str, Any]:
    """The frames of figure 3: one to look at, and the bins of both."""
    clip = still(item)
    return {
        "region": clip.truth[0].tolist(),
        "frame": _picture(clip.frames[1]),
        "m": bins.m,
        "bins": _bins(clip.frames, bins),
    }


def _sprite(item: str) -> dict[str, str]:
    """An object as a frame shows it, without the frame."""
    return {"picture": _picture(_reduced(item, round(WIDTH)), LOSSLESS)}


for _item in OBJECTS:
    DATA.add(f"sprite-{_item}", partial(_sprite, _item))
    for _space in SPACES:
        _made = partial(_object, _item, ColorBins(_space))
        DATA.add(f"surfaces-{_item}-{_space}", _made)


@DATA.register("own.beats")
def _beats() -> dict[str, Any]:
    """The film: what it is painted of, and where the car is."""
    scene = beats.film()
    car = _reduced(scene.target.texture, 2 * round(scene.target.width))
    bricks = _reduced("bricks", round(beats.BRICKS))
    return {
        "size": scene.size,
        "truth": scene.sequence().truth.round(3).tolist(),
        "car": _picture(car, LOSSLESS),
        "bricks": _picture(bricks),
    }


@DATA.register("teuliere2009.fig6")
def _wall() -> dict[str, Any]:
    """What figure 6 is painted of, beside the workshop and the car of the film."""
    seeds = FIGURES["teuliere2009.fig6"].sliders["seed"]
    scenes = [hidden(seed) for seed in seeds]
    scene = scenes[0]
    times = np.arange(-1, scene.length + STEP, STEP)
    paths = [regions(each, each.target, times) for each in scenes]
    return {
        "size": scene.size,
        "length": scene.length,
        "shutter": scene.shutter,
        "first": tracking.FIRST,
        "runs": tracking.RUNS,
        "limits": {"seen": SEEN, "last": LAST, "hit": HIT},
        "times": [-1, STEP],
        "halves": paths[0][0, 3:].tolist(),
        "paths": [path[:, :3].round(3).tolist() for path in paths],
        "bricks": _picture(_reduced("bricks", BRICKS), LOSSLESS),
        "trackers": [
            {"name": name, "label": LABELS[name], "color": color}
            for name, color in COLORS.items()
        ],
    }


@DATA.register("own.interaction")
def _interaction() -> dict[str, Any]:
    """The table, and the six motions of the camera."""
    return _table(WIDE_TABLE) | {
        "halves": servoing.HALVES,
        "push": servoing.PUSH.tolist(),
        "motions": servoing.MOTIONS,
        "moved": servoing.MOVED,
    }


@DATA.register("own.approach")
def _approach() -> dict[str, Any]:
    """The table, and what the loop needs to know."""
    servo = Servo()
    return _table(TABLE) | {
        "desired": servo.desired,
        "wanted": corners(servo.desired).tolist(),
        "styles": [
            {"color": style["color"], "dashes": style["ls"]}
            for style in servoing.STYLES
        ],
    }


def _table(width: int) -> dict[str, Any]:
    """The table from above with the car on it, and the camera that looks down on it."""
    work = Workspace()
    camera = Camera(size=(width, width))
    above = Workspace(camera, table=servoing.TABLE)
    middle = (width - 1) / 2
    pose = above.facing((middle, middle, np.pi / 2, HALF, HALF), servoing.CAR)
    metres = -pose[2, 3] / camera.focal  # of a pixel, on the table
    ends = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * width / 2
    return {
        "focal": work.camera.focal,
        "size": work.camera.size,
        "sides": work.sides.tolist(),
        "car": servoing.CAR,
        "picture": _picture(servoing.pale_view(above, pose)),
        "corners": (pose[:2, 3] + metres * ends @ pose[:2, :2].T).tolist(),
    }


@DATA.register("nummiaro2003.fig3")
def _waiting() -> dict[str, Any]:
    """The model of the student, and how alike the background is to it."""
    scene = students(0)
    tracker = Adaptive()
    clip = runs.clip(scene)
    model = tracker.learn(clip.frames[0], clip.truth[0])
    image = tracker.bins(clip.frames[TREE])
    roots = background(tracker.disc, image, model.half_axes)
    k = steps.IN_FULL_VIEW
    student = steps.coefficients(tracker, clip.frames[k], clip.truth[k], model)
    filled = np.flatnonzero(model.q)
    return {
        "size": scene.size,
        "doors": doors(scene)[:-1],
        "samples": tracker.disc.samples,
        "share": tracker.b,
        "halfAxes": model.half_axes.tolist(),
        "model": list(zip(filled.tolist(), model.q[filled].tolist(), strict=True)),
        "background": (roots @ np.sqrt(model.q)).round(4).tolist(),
        "student": float(student),
    }


def _behind_the_tree(k: int) -> dict[str, Any]:
    """Frame k to look at; and, in the colours that its bins tell apart, to be binned.

    It comes with the place of the student, while most of the student is seen.
    """
    clip = runs.clip(students(0))
    frame = clip.frames[k]
    seen = clip.visibility[k] > SEEN
    return {
        "picture": _picture(frame),
        "binned": _picture(frame & 0xE0, LOSSLESS),  # eight steps a colour
        "truth": clip.truth[k].round(2).tolist() if seen else None,
    }


_FIRST, _LAST, _STEP = FIGURES["nummiaro2003.fig3"].sliders["frame"]
for _k in range(_FIRST, _LAST + 1, _STEP):
    DATA.add(f"doors-{_k}", partial(_behind_the_tree, _k))


@DATA.register("cordoba2014.complexity")
def _readings() -> dict[str, Any]:
    """The two readings of the search, that begun anew first."""
    colors = [resampling.STYLES[anew][1] for anew in resampling.READINGS.values()]
    return {"labels": list(resampling.READINGS), "colors": colors}


@DATA.register("own.chance")
def _chance() -> dict[str, Any]:
    """How long is waited, and what is drawn."""
    return {
        "wait": chance.WAIT,
        "highest": chance.HIGHEST,
        "margin": chance.MARGIN,
        "compared": chance.COMPARED,
        "colors": [CONTRAST[0], DESIRED],
    }


@DATA.register("own.resampling")
def _resampling() -> dict[str, Any]:
    """Distances for each number of particles, darts for each seed."""
    n, seed = (FIGURES["own.resampling"].sliders[name] for name in ("n", "seed"))
    return {
        "distances": {k: spread_distances(k).tolist() for k in range(n[0], n[1] + 1)},
        "uniforms": [
            np.random.default_rng(k).random(n[1]).tolist()
            for k in range(seed[0], seed[1] + 1)
        ],
        "colors": TWELVE,
    }


@DATA.register("own.success")
def _success() -> dict[str, Any]:
    """The trackers of the curves."""
    names = quick()
    styles = zip(names, benchmark.styles(names), strict=True)
    return {
        "trackers": [
            {"label": LABELS[name], "color": style["color"], "dashes": style["ls"]}
            for name, style in styles
        ]
    }


def _runs(scene: str, seed: int) -> dict[str, Any]:
    """Overlaps in the seen frames of a scene, and how many frames there are."""
    iou = benchmark.overlaps_on(Drawn(scene, seed), quick())
    seen = iou[:, np.isfinite(iou[0])].round(7).tolist()
    return {"seen": seen, "frames": iou.shape[1] - 1}


_SLIDERS = FIGURES["own.success"].sliders
for _scene, _seed in product(_SLIDERS["scene"], _SLIDERS["seed"]):
    DATA.add(f"success-{_scene}-{_seed}", partial(_runs, _scene, _seed))


def _reduced(name: str, width: int) -> NDArray:
    """A texture (h, width, 4) of so many pixels across."""
    rgba = texture(name)
    height = round(width * rgba.shape[0] / rgba.shape[1])
    return cv2.resize(rgba, (width, height), interpolation=cv2.INTER_AREA)


def _bins(frames: Iterable[Frame], bins: ColorBins) -> str:
    """Two bin images as one picture: low bytes in red and green, high bits in blue."""
    first, second = (bins(frame).labels.astype(np.uint16) for frame in frames)
    high = (first >> 8) | (second >> 8) << 4
    rgb = np.dstack([first & 255, second & 255, high]).astype(np.uint8)
    return _picture(rgb, LOSSLESS)


def _picture(pixels: NDArray, options: tuple[int, int] = LOSSY) -> str:
    """A picture (h, w, 3) or, with its opacity, (h, w, 4) as an address."""
    return data_uri("image/webp", image_file(pixels, ".webp", *options))
