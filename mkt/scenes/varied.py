"""Scenes for the four wishes of [N03]: a light, a noise, an outline or a way of moving.

Explained in notebook 17.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from mkt import checks
from mkt.scenes.drawn import drawn
from mkt.scenes.layers import Layer
from mkt.scenes.paths import LENGTH, WIDTH, lots, roaming
from mkt.scenes.rendering import Scene
from mkt.scenes.textures import CUT_OUT
from mkt.tracking import Sequence

NOISE = 20.0  # grey levels, of the kind "noise"
FRAMES = 60  # of a run


@dataclass(frozen=True)
class Varied:
    """The first frames of a scene under a name of its own, as a source of runs.

    Parameters
    ----------
    name : str
        Of one of `KINDS`.
    seed : int

    Raises
    ------
    ValueError
        For another name, and for a seed that is none.
    """

    name: str
    seed: int

    def __post_init__(self):
        checks.one_of(self, name=KINDS)
        checks.check_seed(self.seed)

    def scene(self) -> Scene:
        """The `Scene`, of 60 frames."""
        return replace(KINDS[self.name](self.seed), length=FRAMES)

    def sequence(self) -> Sequence:
        """The `Sequence`."""
        return self.scene().sequence(self.name)


def calm(seed: int, **target: Any) -> Scene:
    """A drawn scene of the kind "base", in which fields of the target may differ."""
    scene = drawn("base", seed).scene()
    return replace(scene, target=replace(scene.target, **target))


def swift(seed: int) -> Scene:
    """Short bursts: another way-point every eight frames, under a fast shutter."""
    rng = lots(41, seed)
    lot = drawn("base", seed)
    target = Layer(lot.item, WIDTH, roaming(rng, every=8, turn=0.3))
    return Scene(target, lot.ground, LENGTH, shutter=0.0, seed=seed)


KINDS: dict[str, Callable[[int], Scene]] = {
    "light": lambda seed: drawn("illumination", seed).scene(),
    "noise": lambda seed: replace(calm(seed), noise=NOISE),
    "cut-out": lambda seed: calm(seed, texture=CUT_OUT[seed % 2]),
    "car": lambda seed: calm(seed, texture="car"),
    "calm": calm,
    "swift": swift,
}
