"""How fast the core is: CPU time on one thread, the contenders in turn.

Every contender runs once in a round, and the ratio is the median of the ratios within a
round (`mkt.experiments.timing`): seven rounds, and three of whole trackers.
``python3 -m mkt bench`` prints the tables.
"""

import tracemalloc
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import cv2
import numpy as np

from mkt.colors import BinImage, ColorBins
from mkt.experiments.timing import ROUNDS, exponent, one_thread, side_by_side
from mkt.figures.registry import FIGURES
from mkt.histograms import histograms, learn
from mkt.kernels import Kernels
from mkt.papers.teuliere2009.histograms import cost_surfaces
from mkt.regions import displaced, warp, warp_matrices
from mkt.scenes.drawn import Drawn
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene
from mkt.trackers import by_name
from mkt.trackers.newton import differentiate, moved, newton_step
from mkt.tracking import track
from mkt.types import Array, Frame, NDArray, Regions

SIZE = (80, 60)  # of the object [px]: 4,800 samples
ASPECT = SIZE[0] / SIZE[1]
PARTS = 9
PARTICLES = 500  # regions whose histograms are timed
COUNTS = (125, 250, 500, 1000, 2000)  # of regions, against which time is fitted
TILES = Kernels("tiles", "uniform", aspect=ASPECT, samples=4800)
SMOOTH = Kernels("3x3", "epanechnikov", aspect=ASPECT, samples=4800)
STEPS = 200  # of Gauss-Newton, timed together
FRAMES = 40  # of a timed track
ONE_FRAME = (
    "teuliere2009.fig1",
    "teuliere2009.fig2",
    "teuliere2009.fig3",
    "teuliere2009.fig4",
    "own.newton",
    "own.resampling",
    "own.interaction",
    "own.approach",
    "own.video",
)
TIMED = ("combined", "ssd", "pf-75", "pf-500", "guided", "mil")


def main() -> None:
    """Print all tables."""
    with one_thread():
        for table in (
            histogram_table,
            memory_table,
            surface_table,
            slider_table,
            step_table,
            tracker_table,
        ):
            print(table(), end="\n\n")


def _frame_and_particles(n: int) -> tuple[Frame, Regions]:
    """A synthetic frame, 320 x 240, and n regions scattered round its object."""
    turned = ((0.0, 160.0, 120.0, 0.2, 1.0),)
    clip = Scene(Layer("astronaut", SIZE[0], turned), length=1).sequence()
    scatter = np.random.default_rng(0).normal(0, [12, 12, 0.2, 0, 0], (n, 5))
    region = np.array([160.0, 120.0, 0.2, SIZE[0] / 2, SIZE[1] / 2])
    return clip.frames[0], region + scatter


def warp_and_nine_histograms(image: BinImage, regions: Regions) -> NDArray:
    """The obvious way, (N, 9, m).

    Cut each region out with warpAffine, then call calcHist once for each tile.
    """
    m, (w, h) = image.m, SIZE
    canonical = np.array([[2 / w, 0, 1 / w - 1], [0, 2 / h, 1 / h - 1], [0, 0, 1]])
    how = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    q = np.empty((len(regions), PARTS, m), np.float32)
    for out, a in zip(q, warp_matrices(regions) @ canonical, strict=True):
        patch = cv2.warpAffine(image.labels, a, SIZE, flags=how, borderValue=m)
        for j in range(PARTS):
            row, column = divmod(j, 3)
            rows = slice(row * h // 3, (row + 1) * h // 3)
            columns = slice(column * w // 3, (column + 1) * w // 3)
            tile = patch[rows, columns]
            out[j] = cv2.calcHist([tile], [0], None, [m], [0, m]).ravel()
    return q / np.maximum(q.sum(-1, keepdims=True), 1)


def one_shot_numpy(image: BinImage, kernels: Kernels, regions: Regions) -> NDArray:
    """All positions, all look-ups and all counts in one array each, (N, 9, m)."""
    n = len(regions)
    m = image.m
    labels = image.labels
    height, width = labels.shape
    places = np.rint(warp(regions, kernels.points)).astype(int)
    x, y = np.moveaxis(places, -1, 0)
    inside = (0 <= x) & (x < width) & (0 <= y) & (y < height)
    part = kernels.parts + PARTS * np.arange(n)[:, None]
    seen = labels[y.clip(0, height - 1), x.clip(0, width - 1)]
    index = (part * m + seen)[inside]
    q = np.bincount(index, minlength=n * PARTS * m).reshape(n, PARTS, m)
    return q / np.maximum(q.sum(-1, keepdims=True), 1)


def histogram_table() -> str:
    """Histograms of `PARTICLES` regions in our two ways and two others, as text."""
    frame, regions = _frame_and_particles(PARTICLES)
    lines = [
        f"Histograms of {PARTICLES} regions, 9 parts, 4,800 samples, 320 x 240: CPU ms "
        f"(median of {ROUNDS}, one thread), ratio to the first"
    ]
    for bins in (ColorBins("hsv", (8, 8, 8)), ColorBins()):
        times = side_by_side(_histogram_ways(bins(frame), regions))
        lines += _rows(f"{bins.m} bins: ", times)
    return "\n".join(lines)


def _histogram_ways(
    image: BinImage, regions: Regions
) -> dict[str, Callable[[], NDArray]]:
    return {
        "matrix product, remap, two-channel calcHist": lambda: histograms(
            image, TILES, regions
        ),
        "nine Epanechnikov kernels, sparse product": lambda: histograms(
            image, SMOOTH, regions
        ),
        "warpAffine and nine calcHist a region": lambda: warp_and_nine_histograms(
            image, regions
        ),
        "one-shot numpy": lambda: one_shot_numpy(image, TILES, regions),
    }


def _rows(prefix: str, times: Mapping[Any, Array], digits: int = 2) -> list[str]:
    first = next(iter(times.values()))
    return [
        f"  {prefix + name:<56}{np.median(t):9.{digits}f}{np.median(t / first):8.1f} x"
        for name, t in times.items()
    ]


def memory_table() -> str:
    """CPU time against the number of regions, and memory at the largest, as text."""
    frame, regions = _frame_and_particles(max(COUNTS))
    image = ColorBins()(frame)
    work = {n: (lambda n=n: histograms(image, TILES, regions[:n])) for n in COUNTS}
    medians = [np.median(t) for t in side_by_side(work).values()]
    cells = "".join(f"{n:>7}: {t:.2f}" for n, t in zip(COUNTS, medians, strict=True))
    peak = _peak(lambda: histograms(image, TILES, regions))
    return (
        f"Regions: CPU ms{cells}\n  fitted exponent {exponent(COUNTS, medians):.2f}; "
        f"peak extra memory at {max(COUNTS)}, the result included: {peak:.1f} MB"
    )


def _peak(work: Callable[[], Any]) -> float:
    """Peak of the memory [MB] that a piece of work asks for."""
    tracemalloc.start()
    work()
    peak = tracemalloc.get_traced_memory()[1] / 2**20
    tracemalloc.stop()
    return peak


def _drawn(name: str) -> None:
    """Draw a figure as a slider does."""
    FIGURES[name].draw()[0].canvas.draw()


def surface_table() -> str:
    """CPU time of the data behind figure 3 of [T09], and of the whole figure."""
    times = side_by_side(
        {
            "both 61 x 61 surfaces": lambda: cost_surfaces(
                "3x3", 1.0, "hsv", "car", 20
            ),
            "the figure, computed and drawn": lambda: _drawn("teuliere2009.fig3"),
        }
    )
    head = "teuliere2009.fig3: CPU ms (median), ratio to the first"
    return "\n".join([head, *_rows("", times)])


def slider_table() -> str:
    """CPU time of a slider's step: the figures of one frame, computed and drawn."""
    times = side_by_side({name: (lambda name=name: _drawn(name)) for name in ONE_FRAME})
    head = "A slider's step: CPU ms (median), ratio to the first"
    return "\n".join([head, *_rows("", times)])


def step_table() -> str:
    """CPU time of one Gauss-Newton step of nine kernels, in all and by parts."""
    frame, (region, *_) = _frame_and_particles(1)
    image = ColorBins()(frame)
    target = learn(image, region, Kernels("3x3"))
    start = displaced(region, 2, 1, 0.05, 1.03)
    q, dq = differentiate(target, image, start)

    def step():
        moved(start, newton_step(*differentiate(target, image, start), target.q))

    work = {
        "one step": step,
        "of it, histograms and their derivatives": lambda: differentiate(
            target, image, start
        ),
        "of it, the solution": lambda: newton_step(q, dq, target.q),
    }
    times = side_by_side({name: _repeated(one) for name, one in work.items()})
    each = {name: t / STEPS for name, t in times.items()}
    head = (
        f"Gauss-Newton, {len(target.kernels.points)} samples: CPU ms (median), ratio "
        "to the first"
    )
    return "\n".join([head, *_rows("", each, digits=3)])


def _repeated(work: Callable[[], Any]) -> Callable[[], None]:
    def many():
        for _ in range(STEPS):
            work()

    return many


def tracker_table() -> str:
    """CPU time a frame of whole trackers on the same 320 x 240 frames, as text."""
    clip = replace(Drawn("base").scene(), length=FRAMES).sequence()
    clip = replace(clip, frames=list(clip.frames))
    fine = Kernels("tiles", "uniform", samples=4800)
    trackers = {by_name.LABELS[name]: by_name.TRACKERS[name] for name in TIMED}
    trackers["(3) at the full grid"] = replace(by_name.TRACKERS["pf-500"], kernels=fine)
    work = {name: (lambda one=one: track(one, clip)) for name, one in trackers.items()}
    times = side_by_side(work, repeats=3)
    each = {name: t / FRAMES for name, t in times.items()}
    head = "Trackers: CPU ms a frame (median of 3), ratio to the first"
    return "\n".join([head, *_rows("", each)])
