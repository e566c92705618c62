"""One ground plane, seen by two cameras, of which the first has a wall before it.

The ground is a `Scene` from above; each camera sees it through a homography, and the
wall stands in the image of the first, where the target passes on its way.

Explained in notebook 17.
"""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from mkt.checks import check_seed
from mkt.scenes.drawn import drawn
from mkt.scenes.layers import Layer
from mkt.scenes.paths import WIDTH, lots, way
from mkt.scenes.rendering import Scene, regions, render
from mkt.scenes.textures import texture
from mkt.types import Array, Frame, Region, Regions

SIZE = 320, 240  # [px] of the ground and of both images
FRAMES = 60
WALL = 130, 190  # [px] columns of the first image that the wall hides
# Where the corners of the ground, clockwise from the upper left, are seen [px].
VIEWS = (
    ((40, 20), (300, 0), (319, 239), (0, 225)),
    ((0, 5), (275, 30), (319, 220), (10, 239)),
)


@dataclass(frozen=True)
class TwoViews:
    """What moves on the ground, and how both cameras see it.

    Parameters
    ----------
    seed : int
        Of the path, the item, the ground and the noise.

    Raises
    ------
    ValueError
        For a seed that is none.
    """

    seed: int = 0

    def __post_init__(self):
        check_seed(self.seed)

    @cached_property
    def ground(self) -> Scene:
        """The `Scene` from above: the target crosses it behind the wall and turns."""
        rng = lots(42, self.seed)
        times = np.linspace(0, FRAMES, 5)
        x = np.linspace(55, 265, 5) + rng.uniform(-8, 8, 5)
        y = rng.uniform(90, 150, 5)
        angles = np.cumsum(rng.normal(0, 0.15, 5))
        path = way(times, x, y, angles - angles[0])
        lot = drawn("base", self.seed)
        target = Layer(lot.item, 0.8 * WIDTH, path)
        return Scene(target, lot.ground, FRAMES, seed=self.seed, size=SIZE)

    @property
    def truth(self) -> Regions:
        """The true regions on the ground, (T, 5) [px, rad]."""
        return regions(self.ground, self.ground.target, np.arange(FRAMES))

    def frames(self, k: int) -> tuple[Frame, Frame]:
        """Frame k of both cameras, (H, W, 3) uint8 RGB."""
        above = render(self.ground, k)
        first, second = (cv2.warpPerspective(above, H, SIZE) for H in homographies())
        first[:, slice(*WALL)] = cv2.resize(texture("bricks"), SIZE)[
            :, slice(*WALL), :3
        ]
        return first, second


def homographies() -> tuple[Array, Array]:
    """The homographies (3, 3) of both cameras, from the ground to the image."""
    width, height = np.array(SIZE) - 1
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    first, second = (
        np.array(
            cv2.getPerspectiveTransform(corners, np.array(view, np.float32)), float
        )
        for view in VIEWS
    )
    return first, second


def seen(H: Array, region: Region) -> Region:
    """The region (5,) in an image of one on the ground: its centre and its x axis.

    Parameters
    ----------
    H : (3, 3) array
        From the ground to the image [px].
    region : (5,) array [px, rad]
        On the ground.
    """
    x, y, theta, hx, hy = region
    along = np.array([np.cos(theta), np.sin(theta)])
    across = np.array([-along[1], along[0]])
    ends = [region[:2] + hx * along, region[:2] - hx * along]
    sides = [region[:2] + hy * across, region[:2] - hy * across]
    points = np.array([[region[:2], *ends, *sides]])
    centre, right, left, low, high = cv2.perspectiveTransform(points, H)[0]
    axis = right - left
    width = np.linalg.norm(low - high)
    angle = np.arctan2(axis[1], axis[0])
    return np.array([*centre, angle, np.linalg.norm(axis) / 2, width / 2])
