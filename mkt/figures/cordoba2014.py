"""Figures 1 to 6 of [C14]: window matching, SIR and PFHR in clutter, and behind what hides the target."""

import numpy as np

from mkt.evaluation import judged, overlaps, true_positives
from mkt.figures import figure
from mkt.figures.cordoba2014_material import COLORS, NAMES, contenders, material, run, runs, said, source
from mkt.plotting import TRUTH, draw_box, show_frame
from mkt.regions import CX, CY

RUNS = 4  # of a figure over one sequence: the tracker's random numbers differ
BACK = slice(5, 15)  # seen frames after an occlusion in which the target must be found again
_OCCLUSION = {"particles": [25, 75, 200], "n_lim": [0.1, 0.5, 1.0]}


def found_again(iou, sequence):
    """After how many of the occlusions a tracker is back on the target.

    iou: (..., T - 1) of `mkt.evaluation.overlaps`.  Back is a hit in most of the sixth to fifteenth seen frame after it.  Returns the counts (...) and of
    how many occlusions.
    """
    seen = np.isfinite(iou.reshape(-1, iou.shape[-1])[0])
    ends = np.flatnonzero(~seen[:-1] & seen[1:]) + 1
    back = [np.nanmean(iou[..., end:][..., seen[end:]][..., BACK] > 0.2, -1) > 0.5 for end in ends if seen[end:].sum() > BACK.start]
    return np.sum(back, 0) if back else np.zeros(iou.shape[:-1]), len(back)


def film(canvas, kind, trackers, seed=0):
    """A film strip of eight frames with the boxes of all trackers.  Returns the numbers shown."""
    origin = source(kind)
    sequence = material(origin)
    regions = {name: run(tracker, origin, seed) for name, tracker in trackers.items()}
    frames = moments(sequence)
    axes = canvas.subplots(2, 4, gridspec_kw={"left": 0.005, "right": 0.995, "bottom": 0.005, "top": 0.86, "hspace": 0.18, "wspace": 0.03}).ravel()
    for ax, k in zip(axes, frames):
        frame = sequence.frames[k]
        hidden = "" if sequence.visibility[k] > 0.5 else ", hidden"
        show_frame(ax, frame, f"frame {k}{hidden}")
        if np.isfinite(sequence.truth[k]).all():
            draw_box(ax, sequence.truth[k], TRUTH, lw=2.4)
            draw_box(ax, sequence.truth[k], "white", lw=1.2, ls=(0, (3, 3)))
        for name, found in regions.items():
            draw_box(ax, found[k], COLORS[name], lw=2)
        ax.set(xlim=(-0.5, frame.shape[1] - 0.5), ylim=(frame.shape[0] - 0.5, -0.5))
    _legend(canvas, trackers, said(kind, origin))
    share = {name: float(true_positives(overlaps(found, sequence), hidden=True)) for name, found in regions.items()}
    return {"frames": frames, "true positives": share, "regions": regions}


def moments(sequence, n=8):
    """Frames to show: evenly spread, but where there are occlusions the middle of each and ten frames after its end come first.  Returns n frames."""
    seen = sequence.visibility > 0.5
    starts, ends = np.flatnonzero(seen[:-1] & ~seen[1:]) + 1, np.flatnonzero(~seen[:-1] & seen[1:]) + 1
    chosen = [k for a, b in list(zip(starts, ends))[:(n - 2) // 2] for k in ((a + b) // 2, min(b + 10, len(sequence) - 1))]
    for k in np.linspace(0, len(sequence) - 1, n + 2).round().astype(int)[1:]:
        if len(set(chosen)) < n and min((abs(k - c) for c in chosen), default=n) >= 6:
            chosen.append(k)
    return sorted({int(k) for k in chosen})[:n]


def curves(canvas, kind, trackers):
    """Normalised horizontal and vertical position of all trackers against the frame.  Returns the numbers shown."""
    origin = source(kind)
    sequence = material(origin)
    height, width = sequence.frames[0].shape[:2]
    seen = judged(sequence)
    seen[0] = True
    axes = canvas.subplots(2, 1, sharex=True, gridspec_kw={"left": 0.075, "right": 0.76, "bottom": 0.1, "top": 0.9, "hspace": 0.12})
    numbers, lines = {}, []
    for name, tracker in trackers.items():
        regions = runs(tracker, origin, RUNS)
        for ax, axis, side in zip(axes, (CX, CY), (width, height)):
            ax.plot(regions[1:, :, axis].T / side, color=COLORS[name], lw=0.6, alpha=0.6)
            ax.plot(regions[0, :, axis] / side, color=COLORS[name], lw=1.8)
        iou = overlaps(regions, sequence)
        share, (back, occlusions) = 100 * true_positives(iou, hidden=True), found_again(iou, sequence)
        numbers[name] = {"true positives": share, "found again": back}
        again = f"\n  found again {np.mean(back):.1f} of {occlusions}" if occlusions else ""
        lines.append((name, f"{NAMES[name]}\n  true positives {share.mean():.1f} %\n  {_range(share)}{again}"))
    for ax, axis, side, label in zip(axes, (CX, CY), (width, height), ("(a) horizontal", "(b) vertical")):
        ax.fill_between(np.arange(len(sequence)), 0, 1, where=~seen, step="mid", color="0.85", lw=0)
        ax.plot(np.where(seen, sequence.truth[:, axis] / side, np.nan), color=TRUTH, lw=1.4)
        ax.set(xlim=(0, len(sequence) - 1), ylim=(0, 1) if axis == CX else (1, 0), ylabel=label)
    axes[1].set_xlabel("frame")
    for k, (name, text) in enumerate(lines):
        canvas.text(0.775, 0.88 - 0.28 * k, text, color=COLORS[name], va="top", fontsize=9, linespacing=1.4)
    canvas.text(0.075, 0.93, said(kind, origin))
    return numbers | {"occlusions": occlusions}


def _range(values):
    return f"({values.min():.1f} to {values.max():.1f})" if len(values) > 1 else "(one run, no chance in it)"


def _legend(canvas, trackers, text):
    canvas.text(0.005, 0.945, text, va="bottom")
    canvas.text(0.62, 0.945, "truth (dashed)", va="bottom")
    for k, name in enumerate(trackers):
        canvas.text(0.77 + 0.08 * k, 0.945, NAMES[name], color=COLORS[name], fontweight="bold", va="bottom")


@figure("cordoba2014.fig1", size=(10, 4.5), **_OCCLUSION, gamma=[0.0, 0.1, 0.4])
def fig1(canvas, *, particles=200, n_lim=0.5, gamma=0.1):
    """Tracking in a cluttered environment: window matching, SIR and PFHR.

    On the synthetic twin "clutter", or on BoBoT's blue mug where MKT_DATA has it, as in the paper.  Run 0 of figure 2.  The paper's WM is misled by things
    that look alike, its SIR gets the size wrong.  n_lim is the N_lim of Algorithm 2 as a share of the particles; gamma the first look's share in (10).
    """
    return film(canvas, "clutter", contenders(particles, n_lim, gamma))


@figure("cordoba2014.fig2", size=(10, 4.8), **_OCCLUSION, gamma=[0.0, 0.1, 0.4])
def fig2(canvas, *, particles=200, n_lim=0.5, gamma=0.1):
    """Cluttered environment: horizontal and vertical position, as a share of the image.

    On the synthetic twin "clutter", or on BoBoT's blue mug where MKT_DATA has it.  Black is the truth, thick is run 0, thin are three more, which the
    paper does not show.  There WM is misled and both filters follow; on the twin it is SIR that is misled.  True positives are frames with an overlap
    above 20 %, out of all frames: their mean, the smallest and the largest.
    """
    return curves(canvas, "clutter", contenders(particles, n_lim, gamma))


@figure("cordoba2014.fig3", size=(10, 4.5), **_OCCLUSION)
def fig3(canvas, *, particles=200, n_lim=0.5):
    """Outdoors with total occlusions by look-alikes: window matching, SIR and PFHR.

    On the synthetic twin "passers", or on BoBoT's dark coat where MKT_DATA has it, as in the paper.  Run 0 of figure 4.  In the paper WM loses the person,
    SIR follows with a wrong size, PFHR finds the person again after a few frames.
    """
    return film(canvas, "passers", contenders(particles, n_lim))


@figure("cordoba2014.fig4", size=(10, 4.8), **_OCCLUSION)
def fig4(canvas, *, particles=200, n_lim=0.5):
    """Outdoors with total occlusions: horizontal and vertical position, as a share of the image.

    On the synthetic twin "passers", or on BoBoT's dark coat where MKT_DATA has it.  Grey: the target is hidden; the paper plots a position of 0 there, here
    the truth has gaps.  In the paper SIR swings to and fro and PFHR comes back after a few frames; here PFHR does come back.  Hidden frames count in the
    denominator, as they do in the paper, and nobody can score in them.  Found again: a hit in most of the sixth to fifteenth seen frame after an
    occlusion, mean over the runs.
    """
    return curves(canvas, "passers", contenders(particles, n_lim))


@figure("cordoba2014.fig5", size=(10, 4.5), **_OCCLUSION)
def fig5(canvas, *, particles=200, n_lim=0.5):
    """Indoors with total occlusions by pillars: window matching, SIR and PFHR.

    On the synthetic twin "pillars", or on BoBoT's person in a hall where MKT_DATA has it (frames reconstructed from re-encoded copies), as in the paper.
    Run 0 of figure 6.  The camera goes along, so that what hides the target comes towards it.  In the paper WM and SIR lose the person.
    """
    return film(canvas, "pillars", contenders(particles, n_lim))


@figure("cordoba2014.fig6", size=(10, 4.8), **_OCCLUSION)
def fig6(canvas, *, particles=200, n_lim=0.5):
    """Indoors with total occlusions: horizontal and vertical position, as a share of the image.

    On the synthetic twin "pillars", or on BoBoT's person in a hall where MKT_DATA has it (frames reconstructed).  Drawn as figure 4 is.  In the paper WM
    and SIR miss the person after an occlusion; here SIR may come back too, where it has drifted to the right side.
    """
    return curves(canvas, "pillars", contenders(particles, n_lim))
