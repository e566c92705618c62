"""Synthetic twins of the six kinds of sequence in Table 1 of [C14].

They are for readers without the benchmark: seed, item and ground -> `Scene`.

Each has the difficulty of its original and none of its content.  The items stay
upright, as the boxes of the benchmark do.  Paths are random but smooth; everything
follows from the arguments.
"""

import numpy as np

from mkt.scenes import SCENES
from mkt.scenes.layers import Layer
from mkt.scenes.paths import (
    EDGES,
    MIDDLE,
    as_path,
    lots,
    position,
    shaking,
    sizes,
    standing,
    wandering,
    way,
)
from mkt.scenes.rendering import Scene
from mkt.scenes.textures import texture

LENGTH = 150
WIDTH, TALLEST = 64.0, 100.0  # of the item, and how high it may be [px]
# Of the frame period: blur is not the question here, and a sharp frame renders at once.
SHUTTER = 0.1
PILLARS = "brick pillar", "stone pillar", "green pillar"
KINDS = ("clutter", "passers", "pillars", "scale", "trajectory", "background")


def _scene(target: Layer, ground: str, seed: int, **more) -> Scene:
    return Scene(target, ground, LENGTH, shutter=SHUTTER, seed=seed, **more)


def _width(item: str) -> float:
    """The width of an item [px], less where it would be too tall."""
    height, width = texture(item).shape[:2]
    return min(WIDTH, TALLEST * width / height)


@SCENES.register("clutter")
def clutter(seed: int, item: str = "car", ground: str = "workshop") -> Scene:
    """The item before things of its own colours; the camera moves and zooms.

    Four shuffled copies of the item lie about.
    """
    rng = lots(21, seed)
    around = np.array([[-95, -60], [95, -65], [-90, 70], [100, 60]])
    places = MIDDLE + around + rng.normal(0, 12, (4, 2))
    behind = tuple(
        Layer(item, _width(item), standing(*place), hue=hue, shuffle=3)
        for place, hue in zip(places, (0.0, 30.0, 160.0, 60.0), strict=True)
    )
    target = Layer(item, _width(item), wandering(rng, LENGTH, 25, 0.15))
    camera = shaking(rng, LENGTH, 10, 0.12)
    return _scene(target, ground, seed, behind=behind, camera=camera)


@SCENES.register("passers")
def passers(seed: int, item: str = "car", ground: str = "workshop") -> Scene:
    """Outdoors: three larger look-alikes come from either side.

    Each is the item in slightly other colours, and hides it totally for some frames.
    """
    rng = lots(22, seed)
    path = wandering(rng, LENGTH, 30, 0.15)
    front = []
    for frame in (40, 80, 120):
        x, y = position(path, frame)
        speed = rng.choice([-1, 1]) * rng.uniform(5, 8)
        ends = np.array([0, LENGTH])
        across = way(ends, x + speed * (ends - frame), y)
        hue = float(rng.choice([24, 40, 60]))
        shuffle = int(rng.integers(1, 4))
        front.append(Layer(item, 1.7 * _width(item), across, hue=hue, shuffle=shuffle))
    return _scene(Layer(item, _width(item), path), ground, seed, front=tuple(front))


@SCENES.register("pillars")
def pillars(seed: int, item: str = "car", ground: str = "workshop") -> Scene:
    """Indoors: the item walks behind three pillars, and the camera goes along."""
    rng = lots(23, seed)
    times = np.arange(0, LENGTH + 25, 25.0)
    n = len(times)
    pace = rng.choice([-1, 1]) * rng.uniform(4, 6)
    x = 160 + pace * (times - LENGTH / 2) + rng.normal(0, 6, n)
    y = 120 + rng.normal(0, 8, n)
    path = way(times, x, y, scale=sizes(rng, n, 0.1))
    camera = way(
        times,
        160 - x + rng.normal(0, 12, n),
        rng.normal(0, 6, n),
        rng.normal(0, 0.01, n),
    )
    frames = (35, 75, 115)
    front = tuple(
        Layer(name, rng.uniform(1.5, 1.8) * WIDTH, way([0], *position(path, frame)))
        for name, frame in zip(PILLARS, frames, strict=True)
    )
    target = Layer(item, _width(item), path)
    return _scene(target, ground, seed, front=front, camera=camera)


@SCENES.register("scale")
def scale(seed: int, item: str = "car", ground: str = "workshop") -> Scene:
    """The size changes to and fro.

    Its factor lies between .48 and 1.72 over the held-back seeds (`mkt.scenes.drawn`),
    typically between two thirds and one and a half.
    """
    rng = lots(24, seed)
    target = Layer(item, _width(item), wandering(rng, LENGTH, 25, 0.45))
    return _scene(target, ground, seed)


@SCENES.register("trajectory")
def trajectory(seed: int, item: str = "car", ground: str = "workshop") -> Scene:
    """The item is kicked about from wall to wall, with sudden turns.

    In each frame it moves by up to about half of the item.
    """
    rng = lots(25, seed)
    times = np.arange(0, LENGTH + 8, 8.0)
    places = rng.uniform(EDGES, 2 * MIDDLE - EDGES, (len(times), 2))
    places[:2] = MIDDLE
    path = way(times, *places.T, scale=sizes(rng, len(times), 0.15))
    camera = shaking(rng, LENGTH, 8, 0.05)
    return _scene(Layer(item, _width(item), path), ground, seed, camera=camera)


@SCENES.register("background")
def background_change(seed: int, item: str = "car", ground: str = "workshop") -> Scene:
    """A slow pan over four grounds of other colours, one after the other."""
    rng = lots(26, seed)
    times = np.arange(0, LENGTH + 25, 25.0)
    n = len(times)
    x, y = 160 + 8 * times, 120 + rng.normal(0, 15, n)
    wobble = rng.normal(0, 15, n)
    path = way(times, x + wobble, y, scale=sizes(rng, n, 0.2))
    behind = tuple(
        Layer(name, 320.0, as_path([[0.0, 160.0 + 320 * k, 120.0, 0.0, 1.2]]))
        for k, name in enumerate(("tissue", "gravel", "table", "grass"), 1)
    )
    pan = way(times, 160 - x, rng.normal(0, 6, n))
    target = Layer(item, _width(item), path)
    return _scene(target, ground, seed, behind=behind, camera=pan)
