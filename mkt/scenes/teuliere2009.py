"""The sequences that figures 5 to 7 of [T09] show: seed, item, ground -> `Scene`.

The path depends on the seed, the sensor noise on `Scene.seed`.
"""

from dataclasses import replace

import numpy as np

from mkt.checks import is_whole
from mkt.scenes import SCENES
from mkt.scenes.layers import Layer
from mkt.scenes.paths import WIDTH, lots, roaming, way
from mkt.scenes.rendering import Scene, regions
from mkt.scenes.textures import wall

PASSING = 24.0  # [px/frame] of a screen, beside the target


@SCENES.register("fast")
def fast(
    seed: int, item: str = "car", ground: str = "workshop", exposure: float = 0.9
) -> Scene:
    """Figure 5: translation, rotation and scale, blurred by their speed.

    The shutter is open for the share `exposure` of the frame period.  The speed is
    ours: over 16 seeds .11 of the item's width per frame, at most .32.
    """
    rng = lots(6, seed)
    target = Layer(item, WIDTH, roaming(rng, 60, every=10, turn=0.4))
    return Scene(target, ground, 60, shutter=exposure, seed=seed)


@SCENES.register("hidden")
def hidden(
    seed: int,
    item: str = "car",
    ground: str = "workshop",
    first: int = 46,
    frames: int = 5,
) -> Scene:
    """Figures 6 and 7: translation and rotation, then a total occlusion.

    The item is totally hidden from frame `first` on for some frames.  The speed is
    ours: over 16 seeds .07 of the item's width per frame, at most .24; the paper calls
    its own fast.

    Raises
    ------
    ValueError
        For fewer frames than one.
    """
    if not is_whole(frames, 1):
        raise ValueError(f"frames is {frames!r}; give a whole number, at least 1")
    rng = lots(7, seed)
    target = Layer(item, WIDTH, roaming(rng, 80, every=16, growth=0.0))
    scene = Scene(target, ground, 80, seed=seed)
    return replace(scene, front=(screen(scene, first, frames),))


def screen(scene: Scene, first: int, frames: int) -> Layer:
    """A screen carried past the target from right to left.

    The whole target is behind it during the exposures of just these frames.  It goes
    along with the target, and past it at `PASSING`, so that every path is
    hidden for the same time.
    """
    half = scene.shutter / 2
    ends = np.array([first - half, first + frames - 1 + half])
    _, _, theta, hx, hy = regions(scene, scene.target, ends).T
    # Half widths of the upright box, when it disappears and when it is back.
    reach = np.abs(hx * np.cos(theta)) + np.abs(hy * np.sin(theta))
    times = np.arange(-1.0, scene.length + 1)
    left = -reach[0] - PASSING * (times - ends[0])
    right = reach[1] - PASSING * (times - ends[1])
    x, y = regions(scene, scene.target, times)[:, :2].T
    width = float(np.ceil(right[0] - left[0]))
    material = wall(scene.background)
    return Layer(material, width, way(times, x + (left + right) / 2, y))
