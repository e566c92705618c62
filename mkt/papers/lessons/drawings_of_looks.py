"""Drawings of what a tracker looks at: chapters 1 to 3, 15 and 17.

See `mkt.papers.lessons.pencil`.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Ellipse, Polygon, Rectangle

from mkt.autoregression import AutoRegression
from mkt.colors import ColorBins
from mkt.edges import EdgeBins
from mkt.histograms import coefficient, distance, learn
from mkt.kernels import Kernels
from mkt.neighbours import hsv_counts, shared
from mkt.papers.lessons.pencil import (
    BLUE,
    BOX,
    MIDDLE,
    ORANGE,
    PURPLE,
    arrow,
    boxes,
    canvas,
    drawing,
)
from mkt.papers.teuliere2009.histograms import still
from mkt.particles import Particles
from mkt.plotting import CURRENT, DESIRED, EIGHT, TRUTH
from mkt.regions import corners, displaced
from mkt.types import Array, Frame, NDArray

# A toy car of few pixels, seen from above: ground, body, roof, stripe.
TOY = np.array(
    [
        [int(label) for label in row]
        for row in (
            "00000000000000",
            "00111111111000",
            "01111222113100",
            "01111222113100",
            "01111222113100",
            "01111222113100",
            "00111111111000",
            "00000000000000",
        )
    ]
)
TOY_COLORS = "0.85", BLUE, ORANGE, PURPLE
RADIUS = 2.6  # of the kernel [pixels of the toy]
FRICTION = 0.005  # the floor of the valley is as rough as that
BEFORE, AFTER = (6.5, 4.0), (9.2, 4.0)  # its two places


def toy_histogram(x: float, y: float) -> Array:
    """The histogram (4,) of the toy's colours under a kernel with its centre there.

    The pixels stay where they are; the place of the kernel decides their weights.
    """
    rows, columns = np.indices(TOY.shape) + 0.5
    weights = 1 - ((columns - x) ** 2 + (rows - y) ** 2) / RADIUS**2
    counts = np.bincount(TOY.ravel(), np.maximum(weights, 0).ravel(), minlength=4)
    return counts / counts.sum()


@drawing("01", 9, 2.9)
def kernel_over_pixels(fig: Figure) -> None:
    """Region, kernel, histogram: chapter 1.

    Left, a turned box in an image, the region, with its centre, its angle and its half
    axes; the map g leads to it from the square in which the object lies from -1 to 1,
    and f leads back. Middle, a round kernel slides from the roof of a toy car of
    coloured pixels towards its stripe: the pixels stay, only their weights change.
    Right, the two histograms, before and after, with their coefficient and distance.
    """
    _draw_two_frames(canvas(fig, 34, 29, (0, 0, 34 / 90, 1)))
    _draw_toy(fig.add_axes((0.39, 0.04, 0.31, 0.86)))
    _draw_two_histograms(fig.add_axes((0.755, 0.17, 0.235, 0.57)))


def _draw_two_frames(ax: Axes) -> None:
    """The object's own frame and the image's, and the maps between them."""
    ax.set(ylim=(29, 0))
    ax.text(5.5, 2, "the object", **MIDDLE)
    ax.text(23, 2, "the image", **MIDDLE)
    ax.add_patch(Rectangle((1.5, 9), 8, 8, fc="aliceblue", ec=BLUE, lw=2))
    ax.text(1.5, 19, "$-1$", **MIDDLE)
    ax.text(9.5, 19, "$1$", **MIDDLE)
    ax.add_patch(Rectangle((14, 4), 19, 21, fc="none", ec="0.6"))
    region = np.array([23.5, 14.5, 0.4, 6.5, 4.2])
    ax.add_patch(Polygon(corners(region), fc="aliceblue", ec=BLUE, lw=2))
    centre = region[:2]
    along = np.array([np.cos(0.4), np.sin(0.4)])
    across = np.array([-along[1], along[0]])
    for way, length, name, aside in (
        (along, 6.5, "$h_x$", 1.4 * across),
        (across, 4.2, "$h_y$", -1.5 * along),
    ):
        arrow(ax, centre, centre + length * way)
        ax.text(*(centre + 0.6 * length * way + aside), name, **MIDDLE)
    ax.plot(*centre, "o", color=TRUTH, ms=4)
    ax.plot([23.5, 31.5], [14.5, 14.5], ":", color=TRUTH, lw=1)
    ax.text(28.6, 15.5, r"$\theta$", **MIDDLE)
    ax.text(23, 12.6, "$c$", **MIDDLE)
    bow = {"connectionstyle": "arc3,rad=-0.35"}
    arrow(ax, (10, 10.5), (17.3, 11), **bow)
    ax.text(12, 7, "$g$", **MIDDLE)
    arrow(ax, (18.5, 17.5), (10, 15.5), **bow)
    ax.text(12, 19.5, r"$f_{\mathbf{x}}$", **MIDDLE)
    ax.text(17, 27.3, r"five numbers: $(c_x, c_y, \theta, h_x, h_y)$", **MIDDLE)


def _draw_toy(ax: Axes) -> None:
    """The toy's pixels, and a kernel before and after a move."""
    height, width = TOY.shape
    for row, column in np.ndindex(TOY.shape):
        color = TOY_COLORS[TOY[row, column]]
        ax.add_patch(Rectangle((column, row), 1, 1, fc=color, ec="white", lw=0.8))
    for place, style in ((BEFORE, "-"), (AFTER, "--")):
        for edge, line in (("white", 4), (TRUTH, 1.8)):
            shape = Circle(place, RADIUS, fill=False, ec=edge, lw=line, ls=style)
            ax.add_patch(shape)
    arrow(ax, BEFORE, AFTER, lw=1.8)
    ax.text(width / 2, -0.9, "the kernel moves", **MIDDLE)
    ax.text(width / 2, height + 0.9, "the pixels stay", **MIDDLE)
    ax.set(xlim=(0, width), ylim=(height + 1.6, -1.6), aspect="equal")
    ax.set_axis_off()


def _draw_two_histograms(ax: Axes) -> None:
    q, moved = toy_histogram(*BEFORE), toy_histogram(*AFTER)
    places = np.arange(4)
    ax.bar(places - 0.2, q, 0.38, color=TOY_COLORS, ec=TRUTH, lw=1.2)
    ax.bar(places + 0.2, moved, 0.38, color=TOY_COLORS, ec=TRUTH, lw=1.2, ls="--")
    rho = float(coefficient(q, moved))
    title = f"before (—), after (– –)\n$\\rho$ = {rho:.2f}, $d$ = {distance(rho):.2f}"
    ax.set(title=title, xticks=[], yticks=[0, 0.5, 1], ylim=(0, 1))
    ax.set_xlabel("the four colours")


def rolled(z: NDArray, start: tuple[int, int]) -> list[tuple[int, int]]:
    """The way of a ball over a surface: always to the lowest of the eight neighbours.

    It stops where none is lower by more than `FRICTION`.

    Parameters
    ----------
    z : (M, N) array
        Heights.
    start : row, column

    Returns
    -------
    list of (row, column)
        From start to end.
    """
    path = [start]
    while True:
        row, column = path[-1]
        rows = range(max(row - 1, 0), min(row + 2, z.shape[0]))
        columns = range(max(column - 1, 0), min(column + 2, z.shape[1]))
        lowest = min(((r, c) for r in rows for c in columns), key=lambda cell: z[cell])
        if z[lowest] >= z[path[-1]] - FRICTION:
            return path
        path.append(lowest)


def landscape(layout: str) -> tuple[Array, Array, NDArray]:
    """The distance round the car of chapter 2, on a coarse grid.

    Parameters
    ----------
    layout : str
        Of kernels.

    Returns
    -------
    x : (17,) array [px]
    degrees : (17,) array
    z : (17, 17) array
        Rotation down, x across.
    """
    clip = still("car")
    bins = ColorBins()
    region = clip.truth[0]
    x, degrees = np.linspace(-20, 20, 17), np.linspace(-60, 60, 17)
    learnt, seen = (bins(frame) for frame in clip.frames)
    target = learn(learnt, region, Kernels(layout, samples=5760))
    grid = displaced(region, x, 0, np.deg2rad(degrees)[:, None])
    return x, degrees, target.distances(seen, grid)


@drawing("02", 9, 3)
def ball_on_a_surface(fig: Figure) -> None:
    """Two balls on two landscapes: chapter 2.

    Two surfaces of the distance over place and rotation, computed for the car of this
    chapter. Left, with one kernel, a valley that is flat along the rotation: a ball
    that begins turned by 45 degrees rolls down to its floor and stays turned. Right,
    with nine kernels, a pit: the ball from the same place rolls to the true place and
    angle.
    """
    titles = {"one": "one kernel: a valley", "3x3": "nine kernels: a pit"}
    for left, (layout, title) in zip((0.02, 0.52), titles.items(), strict=True):
        ax = fig.add_axes((left, 0.02, 0.46, 0.98), projection="3d")
        ax.computed_zorder = False  # pyright: ignore[reportAttributeAccessIssue]
        x, degrees, z = landscape(layout)
        _draw_rolling(ax, x, degrees, z)
        fig.text(left + 0.23, 0.93, title, ha="center")


def _draw_rolling(ax: Axes, x: Array, degrees: Array, z: NDArray) -> None:
    """A surface, and a ball that rolls from the corner at 15 px and 45 degrees."""
    style = {"color": "aliceblue", "edgecolor": "0.55", "lw": 0.5, "shade": False}
    style |= {"rcount": 17, "ccount": 17}
    ax.plot_surface(*np.meshgrid(x, degrees), z, **style)  # pyright: ignore[reportAttributeAccessIssue]
    cells = tuple(np.transpose(rolled(z, (14, 14))))
    way = x[cells[1]], degrees[cells[0]], z[cells] + 0.02
    ax.plot(*way, color=DESIRED, lw=2)
    ax.plot(*(part[:1] for part in way), "o", color="white", mec=DESIRED, ms=9)
    ax.plot(*(part[-1:] for part in way), "o", color=DESIRED, mec=TRUTH, ms=10)
    ax.set(xticks=[], yticks=[], zticks=[], zlim=(0, 0.8))  # pyright: ignore[reportArgumentType]
    ax.set_xlabel("x", labelpad=-12)
    ax.set_ylabel("rotation", labelpad=-12)
    ax.set_zlabel("distance", labelpad=-12)  # pyright: ignore[reportAttributeAccessIssue]
    ax.view_init(32, -58)  # pyright: ignore[reportAttributeAccessIssue]


def instants(row: Array, count: int, step: int) -> Array:
    """A row of pixels (N, 3) that moves right by a step in each instant, (count, N, 3).

    Their mean is what a camera sees whose shutter is open for as long.
    """
    return np.stack([np.roll(row, k * step, axis=0) for k in range(count)])


@drawing("02 blur", 9, 2.2)
def open_shutter(fig: Figure) -> None:
    """What an open shutter does: chapter 2.

    Four rows of coloured pixels, an object of blue, orange and purple that moves right
    by two pixels from row to row while the shutter is open. Below, the row that the
    camera delivers: the mean of these four, in which no pixel has a colour of the
    object.
    """
    ax = canvas(fig, 90, 22)
    parts = ((BLUE, 3), (ORANGE, 3), (PURPLE, 3))
    colors = [color for color, count in parts for _ in range(count)]
    row = np.full((26, 3), 0.9)
    row[4:13] = [tuple(int(c[k : k + 2], 16) / 255 for k in (1, 3, 5)) for c in colors]
    seen = instants(row, count=4, step=2)
    for k, moved in enumerate(seen):
        _draw_strip(ax, moved, 18.5 - 3 * k)
    _draw_strip(ax, seen.mean(axis=0), 2.5)
    ax.text(1, 15.2, "instants while\nthe shutter is open", va="center")
    ax.text(1, 3.7, "the frame: their mean", va="center")
    arrow(ax, (53, 9), (53, 5.4))


def _draw_strip(ax: Axes, row: Array, y: float) -> None:
    for k, color in enumerate(row):
        place = 24 + 2.4 * k, y
        ax.add_patch(Rectangle(place, 2.4, 2.4, fc=tuple(color), ec="white", lw=0.6))


@drawing("03", 9, 3)
def five_things(fig: Figure) -> None:
    """What goes into a track, and what comes out: chapter 3.

    Left, a frame with a man's head and a box round it. Five things go into track: the
    video, known by its fingerprint, the box in its first frame, the tracker, its
    numbers and the seed. Three files come out: the film, the table with a row for each
    frame, and the settings, which hold the five. An arrow leads from the settings back
    to the five: they give the same track again.
    """
    ax = canvas(fig, 90, 30)
    ax.add_patch(Rectangle((1, 8), 19, 15, fc="aliceblue", ec="0.5"))
    ax.add_patch(Rectangle((12.5, 15), 6.5, 7, fc="white", ec="0.6"))
    shoulders = [(4.5, 8), (5.5, 12), (9, 13), (12.5, 12), (13.5, 8)]
    ax.add_patch(Polygon(shoulders, fc="0.55", ec="none"))
    ax.add_patch(Ellipse((9, 16), 5, 7.2, fc="#dcb28f", ec="none"))
    ax.add_patch(Rectangle((5.8, 11.8), 6.4, 8.4, fill=False, ec=CURRENT, lw=2.5))
    ax.text(10.5, 25, "frame 0", **MIDDLE)
    ax.add_patch(Rectangle((24, 2.8), 18, 26.4, fill=False, ec="0.6", ls="--"))
    five = "video: SHA-256", "box", "tracker", "its numbers", "seed"
    for k, words in enumerate(five):
        y = 26.5 - 5.2 * k
        boxes(ax, [words], [33], y)
        arrow(ax, (42, y), (50.3, 15.6 + 0.12 * (y - 15.6)))
    ax.text(55, 15.6, "track", weight="bold", bbox=BOX | {"ec": CURRENT}, **MIDDLE)
    three = "the film", "the table:\na row per frame", "the settings:\nthe five"
    for words, y in zip(three, (26, 16, 6), strict=True):
        boxes(ax, [words], [78], y)
        arrow(ax, (59.5, 15.6 + 0.12 * (y - 15.6)), (70.4, y))
    ax.plot([78, 78, 33], [3.3, 1, 1], color="0.4", lw=1.2)
    arrow(ax, (33, 1), (33, 2.9), color="0.4")
    ax.text(56, 2.3, "give the same track again", color="0.3", **MIDDLE)


def pale_box() -> Frame:
    """A bright box on a dark ground, (9, 15, 3) uint8, its edges a little soft."""
    grey = np.full((9, 15), 60.0)
    grey[2:7, 4:11] = 200
    grey[[2, 6], 4:11] = grey[2:7, [4, 10]] = 130  # pyright: ignore[reportArgumentType]
    return np.repeat(grey[..., None], 3, axis=2).astype(np.uint8)


@drawing("15", 9, 2.9)
def two_kinds_of_bins(fig: Figure) -> None:
    """Directions beside colours, and a prior beside a cost: chapter 15.

    Left, a pale box on a dark ground; at its edges arrows point to where it becomes
    brighter, in as many colours as there are sectors. Middle, one histogram of both: a
    few bins of colours, then eight bins of directions and one of flat. Right, a cost
    that is nearly flat over the size of the region, a prior, a parabola round the size
    of the last frame, and their sum, which has a clear lowest point.
    """
    box = pale_box()
    labels = EdgeBins()(box).labels
    _draw_directions(fig.add_axes((0.01, 0.05, 0.3, 0.8)), box, labels)
    _draw_both(fig.add_axes((0.36, 0.2, 0.27, 0.62)), box, labels)
    _draw_prior(fig.add_axes((0.7, 0.2, 0.28, 0.62)))
    for x, words in ((0.16, "arrows to the bright"), (0.495, "one histogram of both")):
        fig.text(x, 0.92, words, ha="center")
    fig.text(0.84, 0.92, "a cost and a prior", ha="center")


def _draw_directions(ax: Axes, box: Frame, labels: NDArray) -> None:
    """Pixels in grey, and an arrow in each that is not flat."""
    for row, column in np.ndindex(labels.shape):
        place = column - 0.5, row - 0.5
        grey = str(box[row, column, 0] / 255)
        ax.add_patch(Rectangle(place, 1, 1, fc=grey, ec="none"))
        if labels[row, column] < 8:
            angle = (labels[row, column]) * np.pi / 4
            way = 0.45 * np.array([np.cos(angle), np.sin(angle)])
            middle = np.array([column, row])
            color = EIGHT[labels[row, column]]
            head = {"shrinkB": 0, "mutation_scale": 9, "lw": 2}
            arrow(ax, middle - way, middle + way, color=color, **head)
    ax.set(xlim=(-0.5, 14.5), ylim=(8.5, -0.5), aspect="equal")
    ax.set_axis_off()


def _draw_both(ax: Axes, box: Frame, labels: NDArray) -> None:
    """Shares of three greys and of nine directions, each half of the sum."""
    _, greys = np.unique(box[..., 0], return_counts=True)
    directions = np.bincount(labels.ravel(), minlength=9)
    q = np.concatenate([greys / greys.sum(), directions / directions.sum()]) / 2
    colors = [str(grey / 255) for grey in (60, 130, 200)] + [*EIGHT, "0.92"]
    ax.bar(np.arange(12) + (np.arange(12) > 2), q, 0.9, color=colors, ec=TRUTH, lw=0.6)
    ax.set(xticks=[1, 8], yticks=[], xlim=(-0.8, 12.8))
    ax.set_xticklabels(["$w$ colours", "$1 - w$ edges"])


def _draw_prior(ax: Axes) -> None:
    """A shallow cost, a parabola and their sum, in the colours of `own.priors`."""
    size = np.linspace(0.6, 1.4, 200)
    cost = 0.12 * (size - 1.32) ** 2 + 0.05
    prior = 0.5 * (size - 1) ** 2
    for curve, color, dashes, name in (
        (cost, BLUE, "-", "$O$"),
        (prior, "0.5", "--", "prior"),
        (cost + prior, ORANGE, "-", "sum"),
    ):
        ax.plot(size, curve, dashes, color=color, lw=2, label=name)
        low = curve.argmin()
        ax.plot(size[low], curve[low], "o", color=color, mec=TRUTH)
    ax.set(xticks=[1], xticklabels=["last size"], yticks=[], xlabel="size")
    ax.legend(loc="upper center", ncols=3, columnspacing=0.8, handlelength=1.2)
    ax.set_ylim(-0.01, 0.24)


@drawing("17", 9, 2.5)
def four_wishes(fig: Figure) -> None:
    """Four wishes: chapter 17.

    Four small pictures. Neighbours: two histograms with one full bin each, side by
    side; their coefficient is 0, and it is larger once each bin has shared with its
    neighbours. Shape: an upright ellipse and a person's outline in it, which leaves
    out the ground. Learnt motion: dots of a track, and two rings for the next place,
    as far on as the last step, and nearer, as learnt. Two cameras: one sees the ball,
    the other a wall; the first tells the second.
    """
    titles = "neighbours", "shape", "learnt motion", "two cameras"
    pens = _draw_neighbours, _draw_shape, _draw_learnt, _draw_cameras
    for k, (title, pen) in enumerate(zip(titles, pens, strict=True)):
        left = 0.015 + 0.25 * k
        pen(fig.add_axes((left, 0.17, 0.22, 0.66)))
        fig.text(left + 0.11, 0.9, title, ha="center", weight="bold")


def next_hues() -> tuple[Array, Array]:
    """Histograms of two neighbouring hues: as they are, and shared.

    Returns
    -------
    before, after : (2, hues) arrays
        The two histograms over the hues at full saturation.
    """
    bins = ColorBins()
    hues, saturations, _ = hsv_counts(bins)
    q = np.zeros((2, bins.m))
    q[[0, 1], [4 * saturations + 9, 5 * saturations + 9]] = 1
    after = shared(q, bins)[:, : hues * saturations]
    before = q[:, : hues * saturations]
    return tuple(p.reshape(2, hues, saturations).sum(2) for p in (before, after))  # pyright: ignore[reportReturnType]


def _draw_neighbours(ax: Axes) -> None:
    before, after = next_hues()
    hues = np.arange(before.shape[1])
    for row, (p, q) in enumerate((before, after)):
        base = 1.5 * (1 - row)
        ax.bar(hues - 0.2, p, 0.38, base, color=BLUE)
        ax.bar(hues + 0.2, q, 0.38, base, color=ORANGE)
        ax.plot([-0.5, 9.5], [base] * 2, color="0.6", lw=0.8)
        ax.text(9.5, base + 0.75, f"$\\rho$ = {coefficient(p, q):.1f}", ha="right")
    ax.set(xlim=(-0.6, 9.6), ylim=(-0.1, 2.9))
    ax.set_axis_off()
    ax.text(4.5, -0.5, "hues", **MIDDLE)


def _draw_shape(ax: Axes) -> None:
    ax.add_patch(Ellipse((5, 5), 6.4, 10, fc="0.93", ec="0.5", ls="--", lw=1.5))
    ax.add_patch(Ellipse((5, 8.2), 1.9, 2.2, fc=BLUE, ec="none"))
    body = [(3.7, 6.8), (6.3, 6.8), (6.9, 3.6), (6.1, 3.6), (6.2, 0.5), (5.2, 0.5)]
    body += [(5, 3.2), (4.8, 0.5), (3.8, 0.5), (3.9, 3.6), (3.1, 3.6)]
    ax.add_patch(Polygon(body, fc=BLUE, ec="none"))
    ax.text(9.4, 8.8, "ground", color="0.3", ha="center")
    arrow(ax, (9.2, 8.6), (7, 7.2), color="0.4")
    ax.text(5, -1, "weights of its outline", **MIDDLE)
    ax.set(xlim=(-1, 11), ylim=(-0.4, 10.2), aspect="equal")
    ax.set_axis_off()


def _draw_learnt(ax: Axes) -> None:
    """A track that slows down; the learnt model keeps a share of each change."""
    share = 0.6
    model = AutoRegression((share, 0.9, 0.9), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    here = Particles(np.array([[0.0, 0, 0, 1, 1]]), np.array([[3.0, 1.8, 0, 0]]))
    places = [here.regions[0, :2]]
    for _ in range(2):
        here = model.predict(here, np.random.default_rng(0))
        places.append(here.regions[0, :2])
    track = np.array(places)
    ax.plot(*track.T, "o-", color=TRUTH, ms=6, lw=1)
    ahead = model.predict(here, np.random.default_rng(0)).regions[0, :2]
    same = 2 * track[-1] - track[-2]
    for end, color in ((same, PURPLE), (ahead, ORANGE)):  # as in `own.learnt_motion`
        ax.plot(*end, "o", mfc="none", mec=color, ms=9, mew=2)
    ax.text(*(same + [0.15, 0.2]), "as before", ha="center", va="bottom")
    ax.text(*(ahead + [0.3, -0.35]), "learnt", ha="center", va="top")
    ax.set(xlim=(-0.3, 4.6), ylim=(-0.4, 3.2))
    ax.set_axis_off()


def _draw_cameras(ax: Axes) -> None:
    ax.add_patch(Circle((5, 8), 1, fc=ORANGE, ec=TRUTH))
    ax.add_patch(Rectangle((6.3, 5), 2.6, 0.9, angle=30, fc="0.7", ec="none"))
    for x, way in ((1.6, 1), (8.4, -1)):
        lens = [(x - 0.9, 1), (x + 0.9, 1), (x + 0.5 * way, 2.6)]
        ax.add_patch(Polygon(lens, fc="0.4", ec=TRUTH))
    ax.plot([2.1, 4.6], [2.6, 7.1], "--", color=CURRENT, lw=1.5)
    ax.plot([7.9, 7.2], [2.6, 5.2], "--", color=DESIRED, lw=1.5)
    arrow(ax, (3, 1.6), (7, 1.6), color=CURRENT)
    ax.text(5, 0, "“it is there”", **MIDDLE)
    ax.set(xlim=(0, 10), ylim=(-0.5, 9.5), aspect="equal")
    ax.set_axis_off()
