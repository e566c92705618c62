"""Drawings of cameras and of the loop that moves them: chapters 7, 8 and 16.

See `mkt.papers.lessons.pencil`.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Polygon, Rectangle
from scipy.linalg import null_space

from mkt.papers.lessons.pencil import (
    BLUE,
    MIDDLE,
    ORANGE,
    PURPLE,
    arrow,
    boxes,
    canvas,
    drawing,
)
from mkt.plotting import CURRENT, DESIRED, TRUTH
from mkt.regions import corners
from mkt.servoing.features import Camera, interaction_matrix
from mkt.servoing.robot import Workspace, move
from mkt.types import Array

CAR = (0.0, 0.0, np.pi / 2)  # on the table [m, rad]
LINES = 0.15  # [m] between two lines of the table
MIDDLE_OF_IMAGE = (159.5, 119.5, np.pi / 2, 50.0, 31.25)  # where it is seen [px, rad]
AXES = {"x": DESIRED, "y": CURRENT, "z": TRUTH}
SAME_GAIN = 0.5  # lambda dt of the four errors of chapter 8


def projected(camera: Camera, pose: Array, points: Array) -> Array:
    """Points (n, 3) [m] of the world in the image of a camera, (n, 2) [px]."""
    with_one = np.column_stack([points, np.ones(len(points))])
    u, v, depth = camera.matrix @ (np.linalg.inv(pose) @ with_one.T)[:3]
    return np.column_stack([u, v]) / depth[:, None]


def circling(workspace: Workspace, pose: Array) -> Array:
    """The twist (6,) that the four features do not notice, with v_x = 1 m/s.

    Of the null space of L it is what is nearest to a motion along x.
    """
    region = workspace.truth(pose, CAR)
    unseen = null_space(interaction_matrix(region, workspace.camera, workspace.surface))
    twist = unseen @ unseen[0]
    return twist / twist[0]


@drawing("07", 9, 3.3)
def camera_over_table(fig: Figure) -> None:
    """A camera over a table, and the motion that it does not notice: chapter 7.

    Left, in three dimensions, a table with a toy car on it and three places of a
    camera on an arc above; the one in the middle has its axes: x to the right, y down
    in the image, z forward to the table. Right, what the camera sees from the left end
    of the arc, from the middle and from the right end: the lines of the table run
    together at one side or the other, but the car hardly moves.
    """
    workspace = Workspace()
    middle = workspace.facing(MIDDLE_OF_IMAGE, CAR)
    twist = circling(workspace, middle)
    poses = [move(middle, twist, t) for t in (-0.35, 0.0, 0.35)]
    _draw_scene(fig.add_axes((-0.01, -0.01, 0.45, 1.12), projection="3d"), poses)
    for k, pose in enumerate(poses):
        ax = fig.add_axes((0.43 + 0.19 * k, 0.2, 0.18, 0.5))
        ax.set_title(("from the left", "from above", "from the right")[k])
        _draw_view(ax, workspace, pose)
    fig.text(0.715, 0.08, "the table moves, the car does not", ha="center")


def _table_lines(reach: float = 0.6) -> list[Array]:
    """The ends (2, 3) [m] of the lines of a squared table."""
    at = np.arange(-reach, reach + LINES / 2, LINES)
    ends = np.array([-reach, reach])
    along = [np.column_stack([ends, [y, y], [0, 0]]) for y in at]
    return along + [np.column_stack([[x, x], ends, [0, 0]]) for x in at]


def _car(workspace: Workspace) -> Array:
    """The corners of the car on the table (4, 3) [m]."""
    flat = corners(np.array([*CAR, *(workspace.sides / 2)]))
    return np.column_stack([flat, np.zeros(4)])


def _draw_scene(ax: Any, poses: Sequence[Array]) -> None:
    """Table, car, cameras; up is -Z."""
    workspace = Workspace()
    for line in _table_lines(0.45):
        ax.plot(*_up(line).T, color="0.75", lw=0.7)
    ax.plot(*_up(_closed(_car(workspace))).T, color=BLUE, lw=2.5)
    for k, pose in enumerate(poses):
        _draw_camera(ax, workspace.camera, pose, "0.45" if k != 1 else TRUTH)
    centre, turn = poses[1][:3, 3], poses[1][:3, :3]
    for (name, color), axis in zip(AXES.items(), turn.T, strict=True):
        ends = _up(np.array([centre, centre + 0.3 * axis]))
        ax.plot(*ends.T, color=color, lw=2)
        place = _up((centre + 0.36 * axis)[None])[0]
        ax.text(*place, f"${name}$", color=color, **MIDDLE)
    arc = np.array([pose[:3, 3] for pose in _arc(poses)])
    ax.plot(*_up(arc).T, ":", color="0.45", lw=1.5)
    ax.set(xlim=(-0.42, 0.42), ylim=(-0.42, 0.42), zlim=(-0.05, 0.95))
    ax.set_box_aspect((0.84, 0.84, 1), zoom=1.1)
    ax.view_init(18, -65)
    ax.set_axis_off()


def _arc(poses: Sequence[Array]) -> list[Array]:
    """Poses between the first and the last, on the way of the camera."""
    twist = circling(Workspace(), poses[1])
    return [move(poses[1], twist, t) for t in np.linspace(-0.35, 0.35, 15)]


def _draw_camera(ax: Any, camera: Camera, pose: Array, color: str) -> None:
    """Four edges from the centre to a picture 20 cm in front of it."""
    width, height = camera.size
    sides = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [width / 2, height / 2]
    ends = 0.2 * np.column_stack([sides / camera.focal, np.ones(4)])
    ends = _up(ends @ pose[:3, :3].T + pose[:3, 3])
    centre = _up(pose[None, :3, 3])[0]
    ax.plot(*_closed(ends).T, color=color, lw=1.2)
    for end in ends:
        ax.plot(*zip(centre, end, strict=True), color=color, lw=1.2)


def _up(points: Array) -> Array:
    """Points of the world as they are drawn: towards the camera is up."""
    return points * [1, -1, -1]


def _closed(points: Array) -> Array:
    return np.vstack([points, points[:1]])


def _draw_view(ax: Axes, workspace: Workspace, pose: Array) -> None:
    """The table and the car as the camera sees them, without pictures."""
    for line in _table_lines():
        ax.plot(*projected(workspace.camera, pose, line).T, color="0.7", lw=0.8)
    outline = workspace.outline(pose, CAR)
    ax.add_patch(Polygon(outline, fc="aliceblue", ec=BLUE, lw=2))
    nose = outline[[1, 2]].mean(axis=0)
    ax.plot(*nose, "o", color=BLUE, ms=5)
    width, height = workspace.camera.size
    ax.set(xlim=(0, width), ylim=(height, 0), xticks=[], yticks=[], aspect="equal")
    ax.spines[:].set(visible=True, color="0.5")


def delayed(gain: float, delay: int, frames: int) -> Array:
    """The error of a loop with delay after one push, e_0 = 1.

    e_{k+1} = e_k - gain e_{k-d}, and nothing was wrong before the push.

    Parameters
    ----------
    gain : float
        lambda dt, the gain in a frame.
    delay : int
        d, in frames.
    frames : int

    Returns
    -------
    (frames,) array
    """
    errors = [0.0] * delay + [1.0]
    while len(errors) < delay + frames:
        errors.append(errors[-1] - gain * errors[-1 - delay])
    return np.array(errors[delay:])


@drawing("08", 9, 3)
def loop_with_delay(fig: Figure) -> None:
    """The loop, and what a delay does to it: chapter 8.

    Left, the loop: camera, tracker, error of the features, a delay of d frames, the
    law, and the robot that moves the camera. Right, the error after one push for four
    delays and the same gain: without delay it halves in each frame; with one frame of
    delay it shoots past zero once and comes back; with two it swings for long; with
    three it grows.
    """
    ax = canvas(fig, 54, 30, (0, 0, 0.6, 1))
    boxes(
        ax, ["camera", "tracker:\nregion", "features\n$e = s - s^*$"], [7, 26, 46], 24
    )
    boxes(ax, ["robot moves\nthe camera", "law\n$v = -\\lambda L^+ e$"], [7, 26], 6)
    ax.text(46, 6, "wait\n$d$ frames", bbox=_waiting(), **MIDDLE)
    for start, end in (
        ((11.2, 24), (20.4, 24)),
        ((31.4, 24), (39.4, 24)),
        ((46, 19.4), (46, 10.4)),
        ((40.8, 6), (33.2, 6)),
        ((18.8, 6), (14, 6)),
        ((7, 10.4), (7, 21.4)),
    ):
        arrow(ax, start, end)
    ax.text(12, 15, "one frame\nlater", **MIDDLE)
    _draw_errors(fig.add_axes((0.66, 0.17, 0.29, 0.72)))


def _waiting() -> dict[str, Any]:
    return {"boxstyle": "round,pad=0.5", "fc": "#fff4dc", "ec": ORANGE}


def _draw_errors(ax: Axes) -> None:
    """The error over the frames, for no delay up to three frames."""
    colors = TRUTH, BLUE, ORANGE, PURPLE
    ax.axhline(0, color="0.6", lw=0.8)
    for delay, color in enumerate(colors):
        errors = delayed(SAME_GAIN, delay, 16)
        label = "no delay" if not delay else f"$d$ = {delay}"
        ax.plot(errors, ".-", color=color, lw=1.6, label=label)
    ax.set(xlim=(0, 15), ylim=(-2.4, 2), xlabel="frame")
    ax.set(xticks=[0, 5, 10, 15], yticks=[-1, 0, 1])
    ax.set_title(f"error after a push, $\\lambda\\,\\Delta t$ = {SAME_GAIN}")
    ax.legend(loc="lower left", ncols=2, borderaxespad=0, columnspacing=1)


def turned_card(angle: float, depth: float = 0.8) -> Array:
    """The pose of a camera that looks at a card turned about its upright axis.

    Parameters
    ----------
    angle : float [rad]
    depth : float [m]
        From the camera to the middle of the card.

    Returns
    -------
    (4, 4) array
        The middle of the card is the origin of the world, see `Workspace`.
    """
    cos, sin = np.cos(angle), np.sin(angle)
    pose = np.eye(4)
    pose[:3, :3] = [[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]]
    pose[:3, 3] = pose[:3, :3] @ [0, 0, -depth]
    return pose


@drawing("16", 9, 2.9)
def plane_in_space(fig: Figure) -> None:
    """A card that turns away, and its picture: chapter 16.

    Left, in three dimensions, a camera and a card with squares, turned by 55 degrees
    about its upright axis. Right, the picture of the card: a quadrilateral, its nearer
    side higher than its farther one, which a homography makes of a square, and the
    best rectangle of the card's own shape, which fits neither side.
    """
    workspace = Workspace(width=0.3)
    pose = turned_card(np.deg2rad(55), 0.5)
    card = (0.0, 0.0, 0.0)
    _draw_card(fig.add_axes((-0.03, -0.1, 0.5, 1.2), projection="3d"), workspace, pose)
    ax = fig.add_axes((0.6, 0.07, 0.39, 0.86))
    sides = workspace.sides / 2
    for line in _squares(*sides):
        ax.plot(*projected(workspace.camera, pose, line).T, color=BLUE, lw=0.9)
    outline = workspace.outline(pose, card)
    ax.add_patch(Polygon(outline, fill=False, ec=BLUE, lw=2.5))
    best = corners(workspace.truth(pose, card))
    ax.add_patch(Polygon(best, fill=False, ec=DESIRED, lw=2, ls="--"))
    width, height = workspace.camera.size
    ax.add_patch(Rectangle((0, 0), width, height, fill=False, ec="0.5"))
    ax.set(xlim=(-2, width + 2), ylim=(height + 2, -2), aspect="equal")
    ax.set_axis_off()
    ax.text(10, 22, "a homography: it fits", color=BLUE, va="center")
    words = "the best rectangle:\nit does not"
    ax.text(10, 234, words, color=DESIRED, va="bottom")
    fig.text(0.51, 0.53, "$H$", size=13, **MIDDLE)
    fig.add_artist(_over(0.47, 0.55, 0.45))


def _over(start: float, end: float, y: float) -> FancyArrowPatch:
    """An arrow across the Figure, in its fractions."""
    style = {"arrowstyle": "-|>", "color": TRUTH, "mutation_scale": 14, "lw": 1.4}
    return FancyArrowPatch((start, y), (end, y), **style)


def _squares(x: float, y: float, columns: int = 6, rows: int = 4) -> list[Array]:
    """The ends (2, 3) [m] of the lines that cut a card into parts."""
    across = [np.array([[-x, v, 0], [x, v, 0]]) for v in np.linspace(-y, y, rows + 1)]
    along = [np.array([[u, -y, 0], [u, y, 0]]) for u in np.linspace(-x, x, columns + 1)]
    return across + along


def _draw_card(ax: Any, workspace: Workspace, pose: Array) -> None:
    """Camera and card as the camera has them: z ahead, drawn to the right, y down."""
    inverse = np.linalg.inv(pose)

    def placed(points):
        x, y, z = (points @ inverse[:3, :3].T + inverse[:3, 3]).T
        return z, -x, -y

    for line in _squares(*(workspace.sides / 2)):
        ax.plot(*placed(line), color=BLUE, lw=1.2)
    flat = corners(np.array([0, 0, 0, *(workspace.sides / 2)]))
    for corner in np.column_stack([flat, np.zeros(4)]):
        z, x, y = (part[0] for part in placed(corner[None]))
        ax.plot([0, z], [0, x], [0, y], color="0.7", lw=0.8)
    lens = 0.1 * np.array([[-0.4, -0.3], [0.4, -0.3], [0.4, 0.3], [-0.4, 0.3]])
    ends = _closed(np.column_stack([np.full(4, 0.1), lens]))
    ax.plot(*ends.T, color=TRUTH, lw=1.4)
    for end in ends[:4]:
        ax.plot(*zip((0, 0, 0), end, strict=True), color=TRUTH, lw=1.4)
    ax.text(0.06, 0, -0.1, "camera", ha="center")
    ax.set(xlim=(0, 0.6), ylim=(-0.2, 0.2), zlim=(-0.2, 0.2))
    ax.set_box_aspect((0.6, 0.4, 0.4), zoom=1.15)
    ax.view_init(22, -72)
    ax.set_axis_off()
