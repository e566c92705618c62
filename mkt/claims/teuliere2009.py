"""The claims of [T09]: C. Teulière, E. Marchand, L. Eck, ICRA 2009."""

import time
from dataclasses import replace

import numpy as np
from joblib import Parallel, delayed

from mkt.claims import Part, claim, contenders, setting
from mkt.figures.teuliere2009 import cost_surfaces
from mkt.figures.teuliere2009_servoing import REVERSALS, experiment, rms, run, self_motion
from mkt.kernels import Kernels
from mkt.scenarios import base
from mkt.scenes import sequence
from mkt.sweeps import one_thread
from mkt.trackers.combined import Combined
from mkt.trackers.particle_filter import ParticleFilter
from mkt.trackers.ssd import SSD
from mkt.tracking import track

LITERAL = SSD(derivative_of_c=False)  # (8) taken for a constant
CUT = SSD(Kernels("cut"), derivative_of_c=False)  # and kernels that reach beyond the object, where its n pixels end
EVERY_PIXEL = 4800  # samples: all pixels of an object of 80 x 60
LENGTH, ROUNDS = 20, 3  # frames and repeats of a timed run
MARGIN = 0.02  # of overlap: less is taken for equal; half a pixel of an object of 80 x 60


@claim("T09-a", "figure 3")
def several_kernels_feel_a_rotation(runs):
    """With several kernels the distance reacts to a rotation, with one it hardly does.

    The curvature of the squared distance along the rotation, at the true place, for nine kernels over that for one.
    """
    ratios = []
    for seed in range(runs.seeds):
        _, theta, surfaces = cost_surfaces("3x3", 1.0, "hsv", setting(seed)[1], 20, seed)
        near = np.abs(theta) <= np.deg2rad(30)
        one, nine = (np.polyfit(theta[near], surface[near, 30] ** 2, 2)[0] for surface in surfaces)
        ratios.append(nine / max(one, 1e-3))
    return [Part("curvature, nine kernels over one", ratios, 5)]


@claim("T09-b", "figures 6 and 7, row (2)", **{scenario: contenders("ssd", "pf-500") for scenario in ("base", "occlusion", "hidden")})
def ssd_is_accurate_but_fails_at_an_occlusion(runs):
    """SSD with nine kernels is accurate, but a total occlusion makes it fail.

    A run fails when in none of its last ten frames the object is found with its orientation right to 45 degrees.  "hidden" is the sequence of
    our figures 6 and 7, hidden for half as long as in "occlusion".
    """
    parts = [Part("base: overlap, SSD minus 500 particles", runs("base", "ssd", "overlap") - runs("base", "pf-500", "overlap"), 0)]
    for scenario in ("occlusion", "hidden"):
        ssd, pf = (runs(scenario, name, "failed") for name in ("ssd", "pf-500"))
        parts += [Part(f"{scenario}: share of runs in which SSD fails", ssd, 0.5, statistic=np.mean),
                  Part(f"{scenario}: that share minus the one of 500 particles", ssd - pf, 0, statistic=np.mean)]
    return parts


@claim("T09-c", "figure 5, rows (2) and (3)",
       **{scenario: contenders("ssd", "pf-500", literal=LITERAL, cut=CUT) for scenario in ("fast", "blur")})
def blur_shrinks_ssd(runs):
    """Under motion blur SSD falls into a wrong minimum by shrinking, the particle filter with nine parts does not.

    "fast" is the sequence of our figure 5.  Shrunk is a region of less than half of the true area.  The literal reading of (8) leaves out the
    derivative of its C; figure 2 does not say where the kernels end, and cut ones reach beyond the object's pixels.
    """
    return [part for scenario in ("fast", "blur") for part in _shrinking(runs, scenario)]


def _shrinking(runs, scenario):
    pf, readings = runs(scenario, "pf-500", "shrunk"), {"ssd": "SSD", "literal": "literal SSD", "cut": "literal SSD with cut kernels"}
    failed = runs(scenario, "ssd", "failed") - runs(scenario, "pf-500", "failed")
    return [
        *(Part(f"{scenario}: share of frames shrunk, {text} minus 500 particles", runs(scenario, name, "shrunk") - pf, 0, statistic=np.mean)
          for name, text in readings.items()),
        Part(f"{scenario}: share of frames shrunk, 500 particles", pf, 0.1, below=True, statistic=np.mean),
        Part(f"{scenario}: share of runs that fail, SSD minus 500 particles", failed, 0, statistic=np.mean),
    ]


@claim("T09-d", "figure 6, row (1)", base=contenders("pf-1", "pf-500"))
def one_kernel_misses_the_orientation(runs):
    """A particle filter with a single kernel estimates the orientation poorly, even with 500 particles."""
    one, nine = (runs("base", name, "orientation") for name in ("pf-1", "pf-500"))
    return [
        Part("base: error of the orientation, one kernel", one, 10, unit="deg"),
        Part("base: that error over the one of nine parts", one / nine, 2),
    ]


@claim("T09-e", "figure 6, rows (3) and (4)", base=contenders("pf-75", "pf-500"))
def few_particles_are_less_precise(runs):
    """The particle filter is less precise with 75 particles than with 500."""
    return [Part(f"base: error of the {what}, 75 particles over 500", runs("base", "pf-75", what) / runs("base", "pf-500", what), 1)
            for what in ("position", "orientation")]


@claim("T09-f", "figure 6, rows (3) and (5); \"roughly 75 %\" fewer particles",
       **{scenario: contenders("combined", "pf-500") for scenario in ("base", "occlusion", "hidden", "fast", "blur")})
def the_combination_is_as_accurate(runs):
    """The combination with 75 particles is as accurate as the particle filter with 500.

    As accurate means at most .02 of overlap worse.  75 of 500 particles are 85 % fewer; the paper's conclusion says 75 %.
    """
    return [Part(f"{scenario}: overlap, combination minus 500 particles",
                 runs(scenario, "combined", "overlap") - runs(scenario, "pf-500", "overlap"), -MARGIN)
            for scenario in ("base", "occlusion", "hidden", "fast", "blur")]


@claim("T09-g", "Section VI-A: about 3 x", base=contenders("combined", "pf-500"))
def the_combination_is_faster(runs):
    """The combination is about three times as fast as the particle filter with 500 particles.

    CPU time on one thread, measured now, in turn in one process and not while the sweep was running; both trackers look at the same samples.
    "About three" is taken as more than two.
    """
    times = {samples: cpu_ratios(samples, min(runs.seeds, 8)) for samples in (EVERY_PIXEL, Kernels().samples)}
    looked = runs("base", "pf-500", "evaluations") / runs("base", "combined", "evaluations")
    return [*(Part(f"CPU time, 500 particles over combination, {samples} samples", ratios, 2, unit="x") for samples, ratios in times.items()),
            Part("base: regions looked at, 500 particles over combination", looked, 2, unit="x")]


def cpu_ratios(samples, scenes):
    """CPU time of 500 particles over that of the combination, with so many samples in every kernel layout.  Returns (scenes,)."""
    tiles, nine = Kernels("tiles", "uniform", samples=samples), Kernels("3x3", samples=samples)
    rivals = ParticleFilter(n=500, kernels=tiles), Combined(ParticleFilter(n=75, kernels=tiles), SSD(nine))
    with one_thread():
        return np.array([_ratio(rivals, sequence(replace(base(*setting(seed)), length=LENGTH))) for seed in range(scenes)])


def _ratio(rivals, clip):
    """Median over the rounds of the first tracker's CPU time over the second's, the two taking turns on a clip that is rendered already."""
    clip = replace(clip, frames=list(clip.frames))
    return np.median([np.divide(*[_cpu(tracker, clip) for tracker in rivals]) for _ in range(ROUNDS)])


def _cpu(tracker, clip):
    start = time.process_time()
    track(tracker, clip)
    return time.process_time() - start


@claim("T09-h", "Section V", base=contenders("combined", "ssd"), blur=contenders("combined", "ssd"))
def prediction_saves_iterations(runs):
    """The particle filter's prediction lowers the number of Newton iterations.

    Iterations in a frame where the optimiser ran: started at the filter's estimate, over started at the last estimate.
    """
    return [Part(f"{scenario}: iterations, combination over SSD", runs(scenario, "combined", "steps") / runs(scenario, "ssd", "steps"), 1, below=True)
            for scenario in ("base", "blur")]


@claim("T09-i", "figures 9 to 11")
def the_self_motion_is_compensated(runs):
    """In servoing, the estimate of the target's own motion lowers the error, and sudden changes of its velocity leave a transient.

    The combination with 75 particles in the loop at 5 frames a second, over up to ten hands that drive the car.  The paper says "reducing" and "small";
    a fifth and 5 % are what we ask.  In steady motion: between 2.4 s after a change of the velocity and the next; after a reversal: for one second.
    """
    numbers = np.array(Parallel(n_jobs=-1)(delayed(_servoing)(seed) for seed in range(min(runs.seeds, 10))))
    texts = ("RMS error in y, raw measurement over no compensation", "RMS error in y, Kalman filter over no compensation",
             "that of the filter, in steady motion", "filter: largest error after a reversal over RMS in steady motion", "share of steady frames in which the estimate's sign is right")
    return [Part(text, values, bound, below) for text, values, bound, below in zip(texts, numbers.T, (0.2, 0.2, 0.05, 2, 0.95), (True, True, True, False, False))]


@one_thread()
def _servoing(seed):
    """The five numbers of T09-i for one hand."""
    off, raw, filtered = (run(experiment(compensation=compensation, seed=seed)) for compensation in ("off", "raw", "Kalman"))
    t, surface = off.times, experiment().workspace.surface
    steady = ((t > 3.4) & (t < REVERSALS[0])) | ((t > REVERSALS[1] + 2.4) & (t < 13.0))
    turned = np.any([(t > time) & (t <= time + 1) for time in REVERSALS], 0)
    e, calm = filtered.errors[:, 1], rms(filtered.errors[steady, 1])
    right = np.sign(filtered.estimated[1:, 1]) == np.sign(self_motion(filtered, surface))
    without = rms(off.errors[:, 1])
    return rms(raw.errors[:, 1]) / without, rms(e) / without, calm / rms(off.errors[steady, 1]), np.abs(e[turned]).max() / calm, right[steady[1:]].mean()
