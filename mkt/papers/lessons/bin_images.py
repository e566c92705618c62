"""Teaching figures of the chapter on more than colour: two bin images, and priors."""

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mkt.colors import BinImage, ColorBins, Joined
from mkt.edges import EdgeBins
from mkt.figures.registry import Shown, at_most, figure, grid_columns, shown
from mkt.histograms import Target, learn
from mkt.kernels import Kernels
from mkt.plotting import CONTRAST, DASHES, draw_map, draw_truth, show_frame
from mkt.regions import displaced
from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene
from mkt.trackers.newton import Prior
from mkt.types import Array, Frame, Region

KERNELS = Kernels("3x3", samples=2400)
PLACE = np.linspace(-40, 40, 33)  # [px]
TURNS = np.linspace(-90, 90, 61)  # [deg]
GROWTH = np.linspace(-0.7, 0.5, 61)  # logarithm of the size
PARTS = ColorBins(), EdgeBins()
HEIGHT = 18  # O(x) of nine kernels where nothing is alike
FOOT = -0.5  # where axes begin: a dot at 0 is whole


def scene(item: str = "car", ground: str = "workshop", **more: Any) -> Scene:
    """An object in the middle of three frames; it stands still unless told otherwise.

    Parameters
    ----------
    item, ground : str
        Textures.
    **more
        Further fields of the `Scene`.
    """
    return Scene(Layer(item, 80.0, ((0.0, 159.5, 119.5, 0.0, 1.0),)), ground, 3, **more)


def moving(before: Scene, speed: float) -> Scene:
    """The same, while the object goes to the right at a speed [px/frame]."""
    ends = [(t, 159.5 + speed * (t - 1), 119.5, 0.0, 1.0) for t in (0.0, 2.0)]
    return replace(before, target=replace(before.target, path=tuple(ends)), shutter=0.9)


CAR, CAMOUFLAGED = scene(), scene("motorcycle")
# Where the target is learnt, and what is looked at then.
LOOKS = {
    "plain": (CAR, CAR),
    "same colours around": (CAMOUFLAGED, CAMOUFLAGED),
    "another light": (CAR, replace(CAR, light=((0.0, 0.4, 0.7, 1.0),))),
    "blur": (CAR, moving(CAR, 24.0)),
}


def looked_at(name: str, joined: Joined) -> tuple[Target, BinImage, Frame, Region]:
    """What was learnt, in which bin image to look for it, the frame and the truth."""
    before, after = (each.sequence() for each in LOOKS[name])
    target = learn(joined(before.frames[1]), before.truth[1], KERNELS)
    frame = after.frames[1]
    return target, joined(frame), frame, after.truth[1]


@figure(
    "own.bin_images",
    size=(10, 3.4),
    share=(0.0, 1.0, 0.1),
    look=list(LOOKS),
)
def bin_images(
    fig: Figure, *, share: float = 0.3, look: str = "another light"
) -> Shown:
    """Where one bin image is flat, the other is a pit.

    Left, the frame in which the target is looked for, dashed where it is.  Then the
    squared distance d_m^2, which is O(x) of (6) over 18, of the regions around the true
    place, in the bins of colour, in the directions of the edges, and in both, the
    second with the share of the slider; the cross is the lowest place, and above each
    map stands what its colours go from and to.  Learnt in a sharp frame in white
    light.  Synthetic data.
    """
    margins = {"left": 0.01, "right": 0.985, "bottom": 0.15, "top": 0.88}
    axes = fig.subplots(1, 4, width_ratios=(1.25, 1, 1, 1), gridspec_kw=margins)
    named = {"colours": 0.0, "edges": 1.0, f"both, edges {share:g}": share}
    surfaces: dict[str, Array] = {}
    for ax, (name, part) in zip(axes[1:], named.items(), strict=True):
        target, image, frame, region = looked_at(look, Joined(PARTS, (1 - part, part)))
        grid = displaced(region, PLACE, PLACE[:, None])
        surfaces[name] = target.distances(image, grid) ** 2
        low, high = surfaces[name].min(), surfaces[name].max()
        draw_map(ax, PLACE, PLACE, surfaces[name], xlabel="x [px]")
        ax.set_title(f"{name}:\n{low:.2f} to {high:.2f}")
        ax.invert_yaxis()
        ax.set_yticks([-40, 0, 40] if ax is axes[1] else [])
    axes[1].set_ylabel("y [px]", labelpad=-8)
    show_frame(axes[0], frame, look)
    draw_truth(axes[0], region)
    columns = dict(zip(("colours", "edges", "both"), surfaces.values(), strict=True))
    table = grid_columns({"y [px]": PLACE}, {"x [px]": PLACE}, **columns)
    off = {f"off_{name}": lowest(surface) for name, surface in columns.items()}
    return shown(table, **off)


def lowest(surface: Array) -> float:
    """How far the lowest point of a surface over `PLACE` is from its middle [px]."""
    row, column = np.unravel_index(surface.argmin(), surface.shape)
    return float(np.hypot(PLACE[row], PLACE[column]))


@figure(
    "own.priors",
    size=(10, 3.8),
    size_prior=(0.0, 40.0, 5.0),
    believed_below=(0.1, 1.0, 0.1),
    turned=(0, 60, 10),
    covered=(0.0, 0.8, 0.1),
)
def priors(
    fig: Figure,
    *,
    size_prior: float = 5.0,
    believed_below: float = 0.7,
    turned: float = 20,
    covered: float = 0.7,
) -> Shown:
    """A prior on the size, and a turn that must earn its place.

    Left, the frame: a wall covers a share of the car, which is turned by some degrees;
    dashed where it is. Middle, O(x) over the size at the true place and angle (blue),
    the prior lambda (log s / s*)^2 (grey, dashed) and their sum (orange); the dots are
    their lowest points.  Right, O(x) over the orientation, and the share of O(x) at the
    first orientation below which a turn is believed: the band; dots at the first
    orientation (dark) and at the lowest point, orange if it is believed and else blue.
    Learnt on the car upright and in full view, in colours and edges; synthetic data.
    """
    at_most(1, covered=covered)
    target, image, frame, region = covered_car(covered, turned)
    upright = displaced(region, dtheta=-np.deg2rad(turned))
    grown = displaced(region, scale=np.exp(GROWTH))
    data = HEIGHT * target.distances(image, grown) ** 2
    prior = Prior(region, np.array([0, 0, 0, size_prior])).cost(grown)
    angles = displaced(upright, dtheta=np.deg2rad(TURNS))
    over_turns = HEIGHT * target.distances(image, angles) ** 2
    ratio = float(over_turns.min() / over_turns[len(TURNS) // 2])

    margins = {"left": 0.01, "right": 0.985, "bottom": 0.15, "top": 0.88}
    left, middle, right = fig.subplots(1, 3, gridspec_kw=margins | {"wspace": 0.25})
    show_frame(left, frame, f"{covered:.0%} covered, turned by {turned:g} deg")
    draw_truth(left, region)
    sizes = _draw_prior(middle, data, prior)
    _draw_turns(right, over_turns, believed_below, ratio)
    table = {"log size": GROWTH, "O over size": data, "prior": prior}
    table |= {"turn [deg]": TURNS, "O over turn": over_turns}
    return shown(table, ratio=ratio, believed=ratio < believed_below, **sizes)


def covered_car(
    covered: float, turned: float
) -> tuple[Target, BinImage, Frame, Region]:
    """As `looked_at`, for a car turned by degrees behind a wall from the left."""
    joined = Joined(PARTS, (2.0, 1.0))
    before = CAR.sequence()
    layer = replace(
        CAR.target, path=((0.0, 159.5, 119.5, float(np.deg2rad(turned)), 1.0),)
    )
    edge = 159.5 - 40 + 80 * covered
    wall = Layer("bricks", 300.0, ((0.0, edge - 150.0, 119.5, 0.0, 1.0),))
    after = replace(CAR, target=layer, front=(wall,)).sequence()
    target = learn(joined(before.frames[1]), before.truth[1], KERNELS)
    return target, joined(after.frames[1]), after.frames[1], after.truth[1]


def _draw_prior(ax: Axes, data: Array, prior: Array) -> dict[str, float]:
    """O over the size, the prior and the sum; where O and the sum are lowest."""
    ax.plot(GROWTH, prior, color="0.5", ls=DASHES[1], label="prior")
    sizes = {}
    curves = {"O": (data, CONTRAST[0]), "sum": (data + prior, CONTRAST[1])}
    for name, (curve, color) in curves.items():
        ax.plot(GROWTH, curve, color=color, label=name)
        k = int(curve.argmin())
        ax.plot(GROWTH[k], curve[k], "o", color=color, ms=8)
        sizes[f"size_{name}"] = float(GROWTH[k])
    highest = max(HEIGHT, 1.05 * (data + prior).max())
    ax.set(xlabel="log (size / true size)", ylabel="O(x)", ylim=(FOOT, highest))
    place = {"loc": "lower center", "bbox_to_anchor": (0.5, 1), "borderaxespad": 0.2}
    ax.legend(ncols=3, **place)
    return sizes


def _draw_turns(ax: Axes, over_turns: Array, share: float, ratio: float) -> None:
    """O over the turn, and the band in which a turn is believed."""
    first = over_turns[len(TURNS) // 2]
    ax.axhspan(0, share * first, color=CONTRAST[1], alpha=0.2, lw=0)
    ax.plot(TURNS, over_turns, color=CONTRAST[0])
    ax.plot(0, first, "o", color="0.3", ms=8)
    k = int(over_turns.argmin())
    believed = ratio < share
    ax.plot(TURNS[k], over_turns[k], "o", color=CONTRAST[int(believed)], ms=8)
    verdict = "believed" if believed else "not believed"
    ax.set(xlabel="turn [deg]", ylabel="O(x)", ylim=(FOOT, HEIGHT))
    ax.set_title(f"over the turn: ratio {ratio:.2f}, {verdict}")
