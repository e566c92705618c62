"""Cards that turn in space: textured planes under perspective, with exact truth.

A card moves as the items of `mkt.scenes.questions` do and tilts out of the image plane
besides: its way-points by up to 45 degrees about each of its axes, and the smooth curve
through them now and then by more, up to 79.  It faces the camera in the first frame,
where it is learnt.

Shown in notebook 16.
"""

import numpy as np

from mkt.checks import check_known
from mkt.scenes.drawn import GROUNDS
from mkt.scenes.layers import Layer
from mkt.scenes.paths import LENGTH, Path, as_path, lots, roaming, way
from mkt.scenes.rendering import Scene
from mkt.types import Rng

CARDS = ("badge", "cat", "motorcycle", "astronaut")
CARD_WIDTH = 100.0  # [px] at scale 1
STEEPEST = np.pi / 4
EVERY = 30  # frames from one way-point to the next
KINDS = ("base", "blur", "noise", "occlusion")


def card(kind: str, seed: int) -> Scene:
    """The scene that a seed gives: sixteen seeds are all pairs of a card and a ground.

    Parameters
    ----------
    kind : str
        "base"; "blur": the shutter is open nearly all the time; "noise": five times as
        much; "occlusion": a slab of gravel, a third as wide as the card, comes down
        through the image and hides up to .29 of the card on its way in the scenes that
        are held back, and up to .48 over 300 seeds.
    seed : int

    Raises
    ------
    ValueError
        For an unknown kind, and for a seed that is none.
    """
    check_known("kind", kind, KINDS)
    rng = lots(16, seed)
    path = roaming(rng, every=EVERY, turn=0.3, growth=0.2)
    item, ground = CARDS[seed % 4], GROUNDS[seed // 4 % 4]
    target = Layer(item, CARD_WIDTH, path, tilt=tilting(rng))
    slab = Layer("gravel", 34.0, way([0.0, LENGTH], 160.0, [40.0, 200.0]))
    return Scene(
        target,
        ground,
        LENGTH,
        front=(slab,) if kind == "occlusion" else (),
        shutter=0.9 if kind == "blur" else 0.5,
        noise=15.0 if kind == "noise" else 3.0,
        seed=seed,
    )


def tilting(rng: Rng) -> Path:
    """A smooth random tilt (frame, about x [rad], about y [rad]) that starts flat."""
    times = np.arange(-EVERY, LENGTH + EVERY, EVERY, dtype=float)
    tilts = rng.uniform(-STEEPEST, STEEPEST, (len(times), 2))
    tilts[:2] = 0
    return as_path(np.column_stack([times, tilts]))
