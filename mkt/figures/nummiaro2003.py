"""The figures of [N03]: K. Nummiaro, E. Koller-Meier, L. Van Gool, 2003.

The real video is the clip "carphone" that comes inside a pip package (`mkt.datasets.carphone`), with our annotation of the head.
"""

import numpy as np

from mkt.datasets import carphone
from mkt.figures import figure
from mkt.histograms import ColorBins, learn
from mkt.kernels import Kernels
from mkt.plotting import draw_box, draw_ellipse, draw_surface, show_frame
from mkt.regions import displaced

BINS = {"rgb 8x8x8": ColorBins("rgb"), "rgb 4x4x4": ColorBins("rgb", (4, 4, 4)), "hsv 10x10+10": ColorBins()}


@figure("nummiaro2003.fig2", size=(10, 4.4), frame=(0, 119, 7), bins=list(BINS), elliptic=[False, True], extent=(20, 60, 10))
def fig2(canvas, *, frame=35, bins="rgb 8x8x8", elliptic=False, extent=40):
    """The surface of the Bhattacharyya coefficient round a face.

    The right half of the printed figure, on real video: the head is learnt in the first frame of the clip and looked for in a later one,
    everywhere in the dotted rectangle, its centre standing at each place in turn.  The best place is marked in red on the frame and on the surface.
    The printed kernel radius (the root of the sum of both squared half axes) does not vanish on the border of the ellipse; the elliptic one does.
    """
    clip, bins = carphone(), BINS[bins]
    target = learn(bins(clip.frames[0]), clip.truth[0], bins, Kernels("ellipse", elliptic=elliptic))
    dx, dy = np.arange(-extent, extent + 1.0), np.arange(-extent, extent + 1.0)
    truth, image = clip.truth[frame], clip.frames[frame]
    rho = target.coefficients(bins(image), displaced(truth, dx, dy[:, None]).reshape(-1, 5)).reshape(len(dy), len(dx))

    row, column = np.unravel_index(np.argmax(rho), rho.shape)
    best = displaced(truth, dx[column], dy[row])
    left = canvas.add_axes((0.01, 0.08, 0.46, 0.82))
    show_frame(left, image, f"frame {frame}: best (red) {np.hypot(*best[:2] - truth[:2]):.0f} px from annotated (white)")
    draw_ellipse(left, truth, color="white")
    draw_ellipse(left, best, color="#d62728")
    draw_box(left, [*truth[:2], 0, extent, extent], color="yellow", lw=1.2, ls=":")
    right = canvas.add_axes((0.48, 0.02, 0.52, 0.92), projection="3d")
    draw_surface(right, dx, dy, rho, (np.floor(10 * rho.min()) / 10, 1), title=f"coefficient, at most {rho.max():.2f}", xlabel="x [px]", ylabel="y [px]", zlabel=r"$\rho$")
    right.plot(*[[v, v] for v in (dx[column], dy[row])], [rho.max(), 1], color="#d62728", lw=2.5, zorder=9)
    return {"rho": rho, "offset": best[:2] - truth[:2], "x": dx, "y": dy}
