"""How fast the core is: CPU time on one thread, the contenders in turn, medians and their ratios.

Wall-clock times of different days say little; here every contender runs once a round, seven rounds, and the ratio is the median
of the ratios within a round.  ``python3 -m mkt bench`` prints the tables.
"""

import os

for _library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")  # read when numpy is loaded

import time
import tracemalloc
from dataclasses import replace

import cv2
import numpy as np
from tqdm import tqdm

from mkt import figures
from mkt.figures import teuliere2009
from mkt.histograms import ColorBins, histograms, learn
from mkt.kernels import Kernels
from mkt.regions import displaced, warp, warp_matrices
from mkt.scenarios import base
from mkt.scenes import Layer, Scene, sequence
from mkt.trackers import catalogue
from mkt.trackers.ssd import differentiate, moved, newton_step
from mkt.tracking import track

ROUNDS = 7
SIZE = (80, 60)  # of the object [px]: 4,800 samples
ONE_FRAME = ("teuliere2009.fig1", "teuliere2009.fig2", "teuliere2009.fig3", "teuliere2009.fig4", "own.newton", "own.resampling", "own.interaction", "own.approach", "own.video")


def main():
    """Print all tables."""
    cv2.setNumThreads(1)
    for table in (histogram_table, memory_table, surface_table, slider_table, step_table, tracker_table):
        print(table(), end="\n\n")


def rounds(contenders, repeats=ROUNDS):
    """CPU time of functions run in turn.  contenders: dict name -> function.  Returns dict name -> (repeats,) [ms]."""
    times = {name: [] for name in contenders}
    for _ in tqdm(range(repeats), disable=None, leave=False):
        for name, function in contenders.items():
            start = time.process_time()
            function()
            times[name].append(1e3 * (time.process_time() - start))
    return {name: np.array(t) for name, t in times.items()}


def _frame_and_particles(n, seed=0):
    """The bin image of a synthetic frame, 320 x 240, and n regions scattered round its object."""
    scene = sequence(Scene(Layer("astronaut", SIZE[0], ((0.0, 160.0, 120.0, 0.2, 1.0),)), length=1))
    rng = np.random.default_rng(seed)
    spread = rng.normal(0, [12, 12, 0.2, 0, 0], (n, 5))
    return scene.frames[0], np.array([160.0, 120.0, 0.2, SIZE[0] / 2, SIZE[1] / 2]) + spread


def warp_and_nine_histograms(image, m, regions):
    """The obvious way: cut each region out with warpAffine, then one calcHist a tile.  Returns (N, 9, m)."""
    w, h = SIZE
    canonical = np.array([[2 / w, 0, 1 / w - 1], [0, 2 / h, 1 / h - 1], [0, 0, 1]])
    q = np.empty((len(regions), 9, m), np.float32)
    for out, a in zip(q, warp_matrices(regions) @ canonical):
        patch = cv2.warpAffine(image, a, SIZE, flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_CONSTANT, borderValue=m)
        for j in range(9):
            rows, columns = divmod(j, 3)
            tile = patch[rows * h // 3:(rows + 1) * h // 3, columns * w // 3:(columns + 1) * w // 3]
            out[j] = cv2.calcHist([tile], [0], None, [m], [0, m]).ravel()
    return q / np.maximum(q.sum(-1, keepdims=True), 1)


def one_shot_numpy(image, m, kernels, regions):
    """All positions, all look-ups and all counts in one array each.  Returns (N, 9, m)."""
    n, j = len(regions), 9
    x, y = np.moveaxis(np.rint(warp(regions, kernels.points)).astype(int), -1, 0)
    inside = (0 <= x) & (x < image.shape[1]) & (0 <= y) & (y < image.shape[0])
    part = kernels.parts + j * np.arange(n)[:, None]
    index = (part * m + image[y.clip(0, image.shape[0] - 1), x.clip(0, image.shape[1] - 1)])[inside]
    q = np.bincount(index, minlength=n * j * m).reshape(n, j, m)
    return q / np.maximum(q.sum(-1, keepdims=True), 1)


def histogram_table(n=500):
    """Histograms of n regions by nine tiles against two other ways, and by nine Epanechnikov kernels, as text."""
    frame, regions = _frame_and_particles(n)
    lines = [f"Histograms of {n} regions, 9 parts, 4,800 samples, 320 x 240: CPU ms (median of {ROUNDS}, one thread), ratio to the first"]
    for bins in (ColorBins("hsv", (8, 8, 8)), ColorBins()):
        image, m = bins(frame), bins.m
        tiles, smooth = (Kernels(*kind, aspect=SIZE[0] / SIZE[1], samples=4800) for kind in (("tiles", "uniform"), ("3x3", "epanechnikov")))
        lines += _rows(f"{m} bins: ", rounds({
            "matrix product, remap, two-channel calcHist": lambda: histograms(image, m, tiles, regions),
            "nine Epanechnikov kernels, sparse product": lambda: histograms(image, m, smooth, regions),
            "warpAffine and nine calcHist a region": lambda: warp_and_nine_histograms(image, m, regions),
            "one-shot numpy": lambda: one_shot_numpy(image, m, tiles, regions),
        }))
    return "\n".join(lines)


def _rows(prefix, times, digits=2):
    first = next(iter(times.values()))
    return [f"  {prefix + name:<56}{np.median(t):9.{digits}f}{np.median(t / first):8.1f} x" for name, t in times.items()]


def memory_table(counts=(125, 250, 500, 1000, 2000)):
    """CPU time against the number of regions, with the fitted exponent, and the peak of memory at the largest, as text."""
    bins = ColorBins()
    frame, regions = _frame_and_particles(max(counts))
    image, tiles = bins(frame), Kernels("tiles", "uniform", aspect=SIZE[0] / SIZE[1], samples=4800)
    times = rounds({n: lambda n=n: histograms(image, bins.m, tiles, regions[:n]) for n in counts})
    medians = [np.median(t) for t in times.values()]
    exponent = np.polyfit(np.log(counts), np.log(medians), 1)[0]
    tracemalloc.start()
    histograms(image, bins.m, tiles, regions)
    peak = tracemalloc.get_traced_memory()[1] / 2**20
    tracemalloc.stop()
    cells = "".join(f"{n:>7}: {t:.2f}" for n, t in zip(counts, medians))
    return f"Regions: CPU ms{cells}\n  fitted exponent {exponent:.2f}; peak extra memory at {max(counts)}, the result included: {peak:.1f} MB"


def surface_table():
    """CPU time of the data behind figure 3 of [T09], and of the whole figure, as text."""
    entry = figures.get("teuliere2009.fig3")
    times = rounds({
        "both 61 x 61 surfaces": lambda: teuliere2009.cost_surfaces("3x3", 1.0, "hsv", "car", 20),
        "the figure, computed and drawn": lambda: entry.draw()[0].canvas.draw(),
    })
    return "\n".join(["teuliere2009.fig3: CPU ms (median), ratio to the first", *_rows("", times)])


def slider_table():
    """CPU time of a slider's step: the figures of one frame, computed and drawn, as text."""
    times = rounds({id: lambda draw=figures.get(id).draw: draw()[0].canvas.draw() for id in ONE_FRAME})
    return "\n".join(["A slider's step: CPU ms (median), ratio to the first", *_rows("", times)])


def step_table(repeats=200):
    """CPU time of one Gauss-Newton step of nine kernels with about 1,200 samples, in all and by parts, as text."""
    bins = ColorBins()
    frame, (region, *_) = _frame_and_particles(1)
    image = bins(frame)
    target = learn(image, region, bins, Kernels("3x3"))
    start = displaced(region, 2, 1, 0.05, 1.03)
    q, dq = differentiate(target, image, start)
    times = rounds({
        "one step": lambda: [moved(start, newton_step(*differentiate(target, image, start), target.q)) for _ in range(repeats)],
        "of it, histograms and their derivatives": lambda: [differentiate(target, image, start) for _ in range(repeats)],
        "of it, the solution": lambda: [newton_step(q, dq, target.q) for _ in range(repeats)],
    })
    rows = _rows("", {name: t / repeats for name, t in times.items()}, digits=3)
    return "\n".join([f"Gauss-Newton, {len(target.kernels.points)} samples: CPU ms (median), ratio to the first", *rows])


def tracker_table(length=40):
    """CPU time a frame of whole trackers on the same 320 x 240 frames, as text."""
    clip = sequence(replace(base(0), length=length))
    clip = replace(clip, frames=list(clip.frames))
    full = replace(catalogue.get("pf-500"), kernels=Kernels("tiles", "uniform", samples=4800))
    trackers = {catalogue.LABELS[name]: catalogue.get(name) for name in ("combined", "ssd", "pf-75", "pf-500", "guided", "mil")}
    times = rounds({name: lambda tracker=tracker: track(tracker, clip) for name, tracker in (trackers | {"(3) at the full grid": full}).items()}, repeats=3)
    rows = _rows("", {name: t / length for name, t in times.items()})
    return "\n".join(["Trackers: CPU ms a frame (median of 3), ratio to the first", *rows])
