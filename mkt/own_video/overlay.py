"""What is drawn on the frames of a video: the outline of what was found, and a grid."""

import cv2
import numpy as np
from matplotlib.figure import Figure

from mkt.plotting import CURRENT, DESIRED, new_figure
from mkt.regions import corners
from mkt.tracking import Info
from mkt.types import Array, Frame, Region

Color = tuple[int, int, int]

DASHES = 5  # on each side
BLACK, WHITE = (0, 0, 0), (255, 255, 255)
STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500)  # px, of the grid
LINES = 20  # of the grid along a side, at most


def annotated(frame: Frame, info: Info, label: str) -> Frame:
    """A copy of a frame with the region of an info outlined, and a label in a corner.

    Green is where the tracker says the target is, dashed red where it says that it lost
    it.

    Parameters
    ----------
    frame : (H, W, 3) uint8 array, RGB
    info : dict
        Of a step, see `mkt.tracking.Tracker`; its region and whether it is lost count.
    label : str

    Returns
    -------
    (H, W, 3) uint8 array, RGB
    """
    image = frame.copy()
    lost = info["lost"]
    thick = max(1, round(frame.shape[0] / 240))
    color = _rgb(DESIRED if lost else CURRENT)
    _outline(image, info["region"], color, thick, dashed=lost)
    text = f"{label} lost" if lost else label
    _write(image, text, (5 * thick, frame.shape[0] - 5 * thick), thick)
    return image


def _outline(
    image: Frame, region: Region, color: Color, thick: int, dashed: bool
) -> None:
    """Draw the four sides, and a tick to the right one, so that the angle shows."""
    c = corners(region)
    sides = np.stack([c, np.roll(c, -1, axis=0)], 1)
    if dashed:
        sides = _dashed(sides)
    tick = np.stack([region[:2], c[1:3].mean(0)])[None]
    lines = np.nan_to_num(16 * np.concatenate([sides, tick])).clip(-1e6, 1e6)
    sixteenths = list(lines.round().astype(np.int32))  # of a pixel
    cv2.polylines(image, sixteenths, False, color, thick, cv2.LINE_AA, shift=4)


def _dashed(sides: Array) -> Array:
    """Dashes (k, 2, 2) along sides (4, 2, 2)."""
    t = np.linspace(0, 1, 2 * DASHES)[:, None]
    return np.concatenate([(a + t * (b - a)).reshape(-1, 2, 2) for a, b in sides])


def _write(image: Frame, text: str, place: tuple[int, int], thick: int) -> None:
    """White letters with a black rim.

    The rim is the same letters moved to four sides: thicker letters would be wider.
    """
    x, y = place
    rim = (-1, 0, BLACK), (1, 0, BLACK), (0, -1, BLACK), (0, 1, BLACK)
    for dx, dy, color in (*rim, (0, 0, WHITE)):
        at = x + dx * thick, y + dy * thick
        size = 0.4 * thick
        font = cv2.FONT_HERSHEY_SIMPLEX
        cv2.putText(image, text, at, font, size, color, thick, cv2.LINE_AA)


def _rgb(color: str) -> Color:
    red, green, blue = bytes.fromhex(color[1:])
    return red, green, blue


def pixel_grid(frame: Frame) -> Figure:
    """A frame under a labelled grid, in the coordinates of a box.

    The image's own corner is 0,0.

    Parameters
    ----------
    frame : (H, W, 3) uint8 array, RGB
    """
    height, width = frame.shape[:2]
    fits = (step for step in STEPS if max(width, height) <= LINES * step)
    step = next(fits, STEPS[-1])
    fig = new_figure((12, 12 * (height / width) + 0.6))
    ax = fig.add_axes((0.05, 0.04, 0.93, 0.9))
    ax.imshow(frame, extent=(0, width, height, 0))
    columns, rows = range(0, width + 1, step), range(0, height + 1, step)
    for color, line in ("black", 1.4), ("white", 0.6):  # seen on any ground
        ax.vlines(columns, 0, height, color, lw=line, alpha=0.6)
        ax.hlines(rows, 0, width, color, lw=line, alpha=0.6)
    ax.set(xticks=columns, yticks=rows, xlim=(0, width), ylim=(height, 0))
    ax.set_aspect("equal")
    ax.tick_params(top=True, labeltop=True)
    return fig
