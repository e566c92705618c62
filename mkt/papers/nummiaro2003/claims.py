"""The claims of [N03], on the sequences of `mkt.scenes.nummiaro2003`.

The paper is by K. Nummiaro, E. Koller-Meier and L. Van Gool, 2003.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from mkt.colors import ColorBins
from mkt.evaluation import HIT
from mkt.experiments.claims import Part, Runs, claim, over_seeds
from mkt.experiments.statistics import PAIRS, SHARE
from mkt.experiments.timing import milliseconds, one_thread
from mkt.histograms import coefficient
from mkt.papers import runs as kept
from mkt.papers.nummiaro2003.sequences import held
from mkt.regions import as_regions
from mkt.scenes import nummiaro2003 as stories
from mkt.scenes.drawn import drawn
from mkt.scenes.layers import Layer
from mkt.scenes.paths import standing
from mkt.scenes.rendering import Scene, render
from mkt.trackers.adaptive import Adaptive
from mkt.trackers.appearance import place
from mkt.trackers.ellipses import Disc
from mkt.trackers.opencv import MeanShift
from mkt.types import Array, ArrayLike, NDArray, Region, Regions, Rng

PAPER = Adaptive()
FIXED = replace(PAPER, alpha=0.0)  # no update: the initialisation alone
REAL_TIME = 40.0  # [ms] a frame, at 25 frames a second
CLUTTERED, OCCLUDED = "clutter", ("hidden", "occlusion", "passers", "pillars")
BY_HUE = "the filter by hue"
HUES = ColorBins("hsv", (16, 1, 1))  # what is pale or dark has one bin
RIVALS = {
    "adaptive": PAPER,
    BY_HUE: replace(PAPER, bins=HUES),
    "meanshift": MeanShift(),
}
DOUBLED = 1.5  # doubling N or pixels: more than this factor is growth
TIMED = np.array([160.0, 120.0, 0.0, 40.0, 50.0])  # the region whose cost is measured
# Factors on it: half axes of 20 x 25 and of 80 x 100 pixels.
HALF, TWICE = np.array([1, 1, 1, 0.5, 0.5]), np.array([1, 1, 1, 2.0, 2.0])
TRIALS = 15  # of a timed step
AFTER = 25  # frames in which the target must be found again
AROUND = 8  # frames before and after a short pass within which the mode must stay
NEAR = 30  # frames before and after the tree in which the student may be hidden


def _share(text: str, values: ArrayLike, bound: float, ours: bool = False) -> Part:
    """A part on the share of the runs in which something is so."""
    return Part(text, np.asarray(values, float), bound, statistic=SHARE, ours=ours)


def _pairs(text: str, values: pd.Series, ours: bool = False) -> Part:
    """A part on the difference of two such shares."""
    return Part(text, values.to_numpy(), 0, statistic=PAIRS, margin=0.1, ours=ours)


def clocked(tracker: Adaptive = PAPER, region: Region = TIMED) -> dict[str, float]:
    """CPU time of the parts of a step, on one thread and 320x240 pixels.

    Parameters
    ----------
    tracker : Adaptive
    region : (5,) array [px, rad]
        On which it starts.

    Returns
    -------
    dict of float [ms]
        frame : all of it.
        weighing : the bin image, the histograms and the coefficients.
        histograms : those of the particles alone, with their coefficients.
    """
    rng = np.random.default_rng(0)
    frame = render(Scene(Layer("hopper", 80.0, standing(160, 120)), length=1), 0)
    image = tracker.bins(frame)
    with one_thread():
        state, _ = tracker.step(tracker.init(frame, region, rng), frame, rng)

        def step():
            tracker.step(state, frame, rng)

        def weigh():
            tracker.observe(tracker.bins(frame), state.particles, state.model)

        def count():
            tracker.observe(image, state.particles, state.model)

        parts = {"frame": step, "weighing": weigh, "histograms": count}
        return {name: milliseconds(work, TRIALS) for name, work in parts.items()}


@claim("N03-a", "Section 7: real time on an 800 MHz PC with N = 100")
def runs_in_real_time(runs: Runs) -> list[Part]:
    """With 100 samples the filter runs in real time.

    CPU time of a frame of 320x240 on one thread, half axes of 40 and 50 px, 512 bins;
    real time means 25 frames a second.  A machine of today cannot but keep it, so this
    says nothing about the one of 2003.  Repeats of one step, no scenes.
    """
    times = np.array([clocked()["frame"] for _ in runs.seeds])
    text = "CPU time a frame, N = 100, this machine"
    return [Part(text, times, REAL_TIME, below=True, unit="ms", ours=True)]


@claim("N03-b", "figure 5")
def weighting_takes_the_time(runs: Runs) -> list[Part]:
    """Weighting takes most of the time, which grows with samples, region size and bins.

    Factors on the CPU time of the histograms when N goes from 200 to 400, or the half
    axes from 20 x 25 to 80 x 100 pixels at N = 100 with a point for each pixel, as in
    the paper; and on the one of the whole frame when 64 bins become 4,096.  Before the
    runs that size was asked of our fixed grid of points in each ellipse, which cannot
    cost more: ours since then.  To weight is also to find the bin of every pixel; the
    histograms and coefficients alone take less than half.  More than 1.5 times as much
    for twice of N or of the area is growth, which is 1.5^4 for sixteen times the area.
    Of more bins it is asked only to cost more, of which twice as many do not show much.
    All times are repeats on the one machine that made the release.
    """
    times = pd.DataFrame([clocked() for _ in runs.seeds])
    n = len(runs.seeds)
    few, many = (replace(PAPER, n=n) for n in (200, 400))
    points = [round(np.prod(2 * (TIMED * by)[3:])) for by in (HALF, TWICE)]
    coarse, fine = (replace(PAPER, disc=Disc(samples=n)) for n in points)
    small, large = (replace(PAPER, bins=ColorBins("rgb", (k,) * 3)) for k in (4, 16))
    samples = _factors("histograms", (few, TIMED), (many, TIMED), n)
    pixels = _factors("histograms", (coarse, TIMED * HALF), (fine, TIMED * TWICE), n)
    grid = _factors("histograms", (PAPER, TIMED * HALF), (PAPER, TIMED * TWICE), n)
    bins = _factors("frame", (small, TIMED), (large, TIMED), n)
    share = (times["weighing"] / times["frame"]).to_numpy()
    return [
        Part("share of the time for weighting", share, 0.5),
        Part("time at N = 400 over N = 200", samples, DOUBLED, unit="x"),
        Part("time with sixteen times the area", pixels, DOUBLED**4, unit="x"),
        Part("time with 4,096 bins over 64", bins, 1, unit="x"),
        Part(
            "time with sixteen times the area, our fixed grid",
            grid,
            DOUBLED**4,
            unit="x",
            ours=True,
        ),
    ]


def _factors(
    part: str,
    low: tuple[Adaptive, Region],
    high: tuple[Adaptive, Region],
    repeats: int,
) -> Array:
    """How many times as long a part of a step takes in another setting, (repeats,)."""
    ratios = [clocked(*high)[part] / clocked(*low)[part] for _ in range(repeats)]
    return np.array(ratios)


def student(seed: int, tracker: Adaptive = FIXED) -> dict[str, float]:
    """What becomes of a run over the student sequence.

    Returns
    -------
    dict of float
        lost : 1 when declared lost behind the tree.
        found : 1 when found again within 25 frames after it.
        bridged : 1 when the mode stays the same at both short passes.
        passed : 1 when a frame in the eight after each of them is a hit.
        late : frames from the leaving to the loss that stays, NaN for never.
        learnt : share of the frames behind the tree in which the model is updated.
    """
    scene = stories.students(seed)
    clip = kept.clip(scene)
    track = kept.run(replace(tracker, zones=stories.doors(scene)), scene, seed)
    visible, away = clip.visibility, track.lost
    hit = held(track, clip.truth) > HIT
    start, end = stories.TREE - NEAR, stories.TREE + NEAR
    hidden = start + np.flatnonzero(visible[start:end] == 0)
    out = hidden[-1] + 1
    gone = np.flatnonzero(visible > 0)[-1] + 1
    for_good = np.flatnonzero(~away)[-1] + 1
    found = hit[out : out + AFTER].any() and not away[out + AFTER]
    passing = [away[k - AROUND : k + AROUND + 1] for k in stories.PASSES]
    passed = all(hit[k + 1 : k + AROUND + 1].any() for k in stories.PASSES)
    return {
        "lost": float(away[hidden].any()),
        "found": float(found),
        "bridged": float(not np.any(passing)),
        "passed": float(passed),
        "late": float(for_good - gone) if away[-1] else np.nan,
        "learnt": float(track.info["updated"][hidden].mean()),
    }


# An alpha for both sequences: of .01, .02, .03, .05 and .1, with which 12, 11, 6, 2 and
# 1 of the tuning seeds 500 to 511 find the student again, and which all help the van.
SLOW = 0.02
WALKERS = {
    "ours": FIXED,
    "stubborn": replace(FIXED, patience=stories.STUDENTS),  # never initialises again
    "strict": replace(FIXED, b=0.3),
    "slow": replace(PAPER, alpha=SLOW),
    "learns": PAPER,
    "printed gate": replace(PAPER, rho_min=0.9),
}


def walks(seed: int) -> dict[str, dict[str, float]]:
    """`student` for each of `WALKERS`."""
    return {name: student(seed, tracker) for name, tracker in WALKERS.items()}


def _walked(seeds: Sequence[int]) -> dict[str, pd.DataFrame]:
    """A table for each of `WALKERS`, with a row for each seed."""
    rows = over_seeds(walks, seeds)
    return {name: pd.DataFrame([row[name] for row in rows]) for name in WALKERS}


@claim("N03-c", "figures 6 and 7")
def short_occlusions_are_bridged(runs: Runs) -> list[Part]:
    """Propagation alone bridges short occlusions, long ones need the initialisation.

    Shares of the runs over the student sequence, samples waiting at the sides of the
    tree and of the image.  For comparison a tracker that never returns to the
    initialisation.  Two lines have no say, because they follow from the set-up: who
    passes hides the student for three frames at most, the tree for about thirty, and
    the patience is five.  The paper does not say whether the model learns here, nor its
    rate: lines without the update, and with a rate of .02, which was chosen on other
    runs of the student's.  The last two, ours, are with the rate of N03-d.  Those with
    an update came after the runs of the others, and the first line after them all.
    """
    walked = _walked(runs.seeds)
    ours = walked["ours"]
    gain = ours["found"] - walked["stubborn"]["found"]
    rates = {"slow": SLOW, "learns": PAPER.alpha}
    return [
        _share("hit within 8 frames after each short pass", ours["passed"], 0.8),
        _share("short passes without a change of mode", ours["bridged"], 0.8, True),
        _share("declared lost behind the tree", ours["lost"], 0.8, True),
        _share("found again after the tree", ours["found"], 0.8),
        _pairs("found again, with initialisation minus without", gain),
        *(
            _share(
                f"{text}, alpha = {rate:g}", walked[name][what], 0.8, name == "learns"
            )
            for name, rate in rates.items()
            for what, text in (
                ("lost", "declared lost behind the tree"),
                ("found", "found again after the tree"),
            )
        ),
    ]


def traffic(seed: int, alpha: float, look: str = "fades") -> dict[str, float]:
    """What becomes of a run through traffic.

    Returns
    -------
    dict of float
        hits : the share of true positives, none while the tracker searches.
        scale : the mean error of H_x, as a share of it.
    """
    hit, off = _driven(seed, alpha, look)
    return {"hits": float(hit.mean()), "scale": float(off.mean())}


def _driven(seed: int, alpha: float, look: str) -> tuple[NDArray, Array]:
    """In which frames (T - 1,) of a run the van is held, and the error of H_x."""
    scene = stories.traffic(seed, look)
    truth = kept.clip(scene).truth
    track = kept.run(replace(PAPER, alpha=alpha), scene, seed)
    off = np.abs(track.regions[1:, 3] / truth[1:, 3] - 1)
    return held(track, truth)[1:] > HIT, off


def nearer(seed: int) -> float:
    """Error of H_x with the update minus without, over the frames in which both hold.

    Of the van that takes other colours.
    """
    (hit, off), (hit_still, off_still) = (
        _driven(seed, alpha, "fades") for alpha in (PAPER.alpha, 0.0)
    )
    both = hit & hit_still
    return float(off[both].mean() - off_still[both].mean())


def drives(seed: int) -> dict[tuple[float, str], dict[str, float]]:
    """`traffic` without and with the update: {(alpha, look): dict}."""
    rates = [(alpha, look) for look in stories.LOOKS for alpha in (0.0, PAPER.alpha)]
    return {case: traffic(seed, *case) for case in [*rates, (SLOW, "fades")]}


@claim("N03-d", "figures 8 and 9")
def the_update_estimates_the_scale_better(runs: Runs) -> list[Part]:
    """When the appearance changes, the update keeps the target and betters its scale.

    A van in traffic that grows, with the update minus without, at alpha = .1 and with
    the printed radius of the kernel.  The paper speaks of viewing angles and of
    rotations out of the plane: here the van takes other colours all over, or it turns
    as a box does, whose old side stays in sight until frame 135.  A tracker that has
    lost the van has a size too, and that counts.  The paper says "better", so that more
    than none is asked; a gain of .2 is what we had asked for before the runs, and is
    ours.  The last lines are ours, too: when the scale alone changes, the model has
    nothing to learn, and forgets its own size; the gain at the rate of .02 with which
    N03-c finds the student again; and, put last, the error of the size over the frames
    in which both hold the van, which leaves out what a lost one makes of it.
    """
    rows = over_seeds(drives, runs.seeds)

    def gains(look: str, number: str, alpha: float = PAPER.alpha) -> Array:
        learning, still = (
            np.array([row[rate, look][number] for row in rows]) for rate in (alpha, 0.0)
        )
        return learning - still

    compared = "with update minus without"
    hits, off = f"share of true positives, {compared}", f"error of H_x, {compared}"
    fades, box = gains("fades", "hits"), gains("turns", "hits")
    alone = gains("same", "scale")
    return [
        Part(f"other colours: {hits}", fades, 0),
        Part(f"other colours: {off}", gains("fades", "scale"), 0, below=True),
        Part(f"a box that turns: {hits}", box, 0),
        Part(f"a box that turns: {off}", gains("turns", "scale"), 0, below=True),
        Part(f"other colours: {hits}", fades, 0.2, ours=True),
        Part(f"a box that turns: {hits}", box, 0.2, ours=True),
        Part(f"scale alone: {off}", alone, 0, True, ours=True),
        Part(
            f"other colours: {hits}, alpha = {SLOW:g}",
            gains("fades", "hits", SLOW),
            0,
            ours=True,
        ),
        Part(
            f"other colours: {off}, where both hold",
            np.array(over_seeds(nearer, runs.seeds)),
            0,
            below=True,
            ours=True,
        ),
    ]


@claim("N03-e", "Section 6: b = 0.1")
def a_tenth_is_enough_to_start(runs: Runs) -> list[Part]:
    """A kick-off fraction of 0.1 is enough to find the target again.

    The student sequence, without model update; with it see N03-c.  False starts are
    runs in which the mode is "tracking" more than five frames after the student left
    the view.  At first a loss before the student left passed for one in time, too;
    since then, after the first runs, it is none.  On this ground nothing appears by
    chance, so that b = .02 would do as well.  The last line, ours, compares with b =
    .3.
    """
    walked = _walked(runs.seeds)
    ours = walked["ours"]
    gain = ours["found"] - walked["strict"]["found"]
    said = "loss declared within 5 frames of leaving, for good"
    in_time = (ours["late"] >= 0) & (ours["late"] <= 5)
    return [
        _share("found again after the tree", ours["found"], 0.8),
        _share(said, in_time, 0.8),
        _pairs("found again, b = .1 minus b = .3", gain, ours=True),
    ]


@claim("N03-f", "Section 6: mu + 2 sigma, 95 %")
def the_condition_rejects_the_background(runs: Runs) -> list[Part]:
    """The appearance condition rejects 95 % of the background.

    The share of positions on a photograph, two half axes or more from where the object
    was, whose coefficient with the object is below mu + 2 sigma: on the positions from
    which mu and sigma come, and on three to four times as many others at random.  A
    normal distribution would give 97.7 %.
    """
    shares = pd.DataFrame(over_seeds(rejection, runs.seeds))
    return [
        Part(f"share rejected, {where}", shares[where].to_numpy(), 0.95)
        for where in ("same positions", "others")
    ]


def rejection(seed: int) -> dict[str, float]:
    """Shares of a background that (15) rejects, for item and ground of the seed.

    Returns
    -------
    dict of float
        same positions : of those from which mu and sigma come.
        others : of positions at random.
    """
    rng = np.random.default_rng((14, seed))
    clip = _somewhere(seed, rng).sequence()
    frame, truth = clip.frames[0], clip.truth[0]
    state = PAPER.init(frame, truth, rng)
    known = state.background @ np.sqrt(state.model.q)
    ellipses = _apart(truth, state.model.half_axes, 4 * len(known), frame.shape, rng)
    others = PAPER.disc.histograms(PAPER.bins(frame), ellipses)
    rho = coefficient(others, state.model.q)
    return {
        "same positions": float(np.mean(known <= state.limit)),
        "others": float(np.mean(rho <= state.limit)),
    }


def _somewhere(seed: int, rng: Rng) -> Scene:
    """One frame, with the item of a seed at a random place before its ground."""
    x, y = rng.uniform([60, 60], [260, 180])
    path = ((0.0, x, y, 0.0, 1.0),)
    pair = drawn("base", seed)
    return Scene(Layer(pair.item, 50.0, path), pair.ground, 1, seed=seed)


def _apart(
    truth: Region, half_axes: Array, n: int, shape: tuple[int, ...], rng: Rng
) -> Regions:
    """Those of n random ellipses that do not touch the one at the truth."""
    centres = place(("anywhere",), shape, half_axes, n, rng)
    off = (centres - truth[:2]) / (2 * half_axes)
    centres = centres[np.sum(off**2, 1) > 1]
    n = len(centres)
    ellipses = np.column_stack([centres, np.zeros(n), np.tile(half_axes, (n, 1))])
    return as_regions(ellipses)


@claim("N03-g", "Section 5, (11)")
def the_condition_stops_the_learning(runs: Runs) -> list[Part]:
    """The update condition keeps the model from learning while the target is hidden.

    The share of the runs in which the model is updated in no frame behind the tree, at
    alpha = .1 as in N03-d, where the coefficient of the mean state is above .9, the
    printed number read as a coefficient.  Ours: above .8, as in N03-d; the same at a
    rate of .02; and whether the student is found again, since what the model has learnt
    before the tree stays.  The claim was put after some of these runs; its first lines
    had the mean share of frames, of which runs that are all alike say nothing.
    """
    walked = _walked(runs.seeds)
    strict = walked["printed gate"]
    still = "the model learns nothing behind the tree"
    return [
        _share(f"{still}, above .9", strict["learnt"] == 0, 0.8),
        _share(f"{still}, above .8", walked["learns"]["learnt"] == 0, 0.8, ours=True),
        _share(
            f"{still}, above .8, alpha = {SLOW:g}",
            walked["slow"]["learnt"] == 0,
            0.8,
            ours=True,
        ),
        _share("found again after the tree, above .9", strict["found"], 0.8, ours=True),
    ]


@claim("N03-h", "Section 1", **dict.fromkeys((CLUTTERED, *OCCLUDED), RIVALS))
def it_is_more_reliable_than_mean_shift(runs: Runs) -> list[Part]:
    """In clutter and behind occlusions fewer runs are lost than with mean shift.

    A run is lost when none of its last ten frames is a hit.  The paper names several
    hypotheses and a model of the motion as the reason, and compares elsewhere.  Mean
    shift is OpenCV's: it knows hues alone, and its box keeps its size.  So in lines of
    ours the filter has hues alone, too.  The claim was put after the first runs.
    """
    return [
        part
        for kind in (CLUTTERED, *OCCLUDED)
        for part in (
            _fewer_lost(runs, kind, "adaptive"),
            _fewer_lost(runs, kind, BY_HUE, ours=True),
        )
    ]


def _fewer_lost(runs: Runs, kind: str, label: str, ours: bool = False) -> Part:
    """A part on the runs that mean shift loses more than a filter."""
    lost, theirs = (runs(kind, name, "lost") for name in (label, "meanshift"))
    text = f"{kind}: share of runs lost, mean shift minus {label}"
    return _pairs(text, pd.Series(theirs - lost), ours)
