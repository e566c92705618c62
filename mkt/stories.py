"""The sequences of [N03], rebuilt: seed -> a `Scene`, and the head in a real video.

The paper's videos (PETS2001, students before a university, a factory) cannot be had; these scenes ask of a tracker what the paper says that
they asked.  Paths vary with the seed, around a common story; all pictures are flat, so a turn out of the image plane is a slow mixture of two
views, which differ in their colours.
"""

import numpy as np

from mkt.datasets import carphone
from mkt.scenes import Layer, Scene
from mkt.tracking import Sequence

STUDENTS, TREE, HEAD = 222, 101, 450  # frames of figure 6, the frame behind the tree, frames of figure 10: printed
PASSES = 45, 165  # frames of the two short occlusions: ours, figure 7 is not legible
TREE_X, TREE_WIDTH = 160.0, 76.0  # [px]
PERSON = 36.0  # width of a student [px]
PACE = 8.0  # [px a frame] at which others pass


def _way(times, x, y, scales=1.0):
    """Way-points of an upright layer.  Returns a tuple for `Layer.path`."""
    table = np.column_stack(np.broadcast_arrays(times, x, y, 0.0, scales)).round(3)
    return tuple(tuple(map(float, row)) for row in table)


def students(seed, tree=TREE_WIDTH):
    """Figures 6 and 7: a student walks from the left to the right, behind a tree, is passed twice by others, and leaves the view.

    tree: its width [px]; ours hides all of the student for about 20 frames around frame 101.  Those who pass come from the right, each of
    another colour, and hide most of the student for a few frames.  The student is out of the view after about frame 205.
    """
    rng = np.random.default_rng((11, seed))
    times = np.arange(0.0, STUDENTS + 12, 11)
    x = np.interp(times, [0, TREE, STUDENTS], [30, TREE_X, 365]) + rng.normal(0, 1.5, len(times)) * (np.abs(times - TREE) > 15)
    y = rng.uniform(115, 145) + np.cumsum(rng.normal(0, 2, len(times)))
    target = Layer("astronaut", PERSON, _way(times, x, y))
    trunk = Layer("grass", float(tree), _way([0], TREE_X, np.interp(TREE, times, y)))
    others = [Layer("hopper", 1.1 * PERSON, _passing(times, x, y, frame), hue=hue) for frame, hue in zip(PASSES, rng.permutation([60.0, 140.0, 220.0]))]
    return Scene(target, "gravel", STUDENTS, front=(*others, trunk), seed=seed)


def _passing(times, x, y, frame):
    """The way of somebody who meets the layer on this way at a frame, coming from the right."""
    place, height = np.interp(frame, times, x), np.interp(frame, times, y)
    return _way([0, times[-1]], place - PACE * (np.array([0, times[-1]]) - frame), height)


def doors(scene):
    """Where the student of a scene may appear again, as zones of a tracker: on both sides of the tree; with "borders" for those of the image."""
    tree = scene.front[-1]
    _, x, y, *_ = tree.path[0]
    return tuple((x + side * (tree.width + PERSON) / 2, y, PERSON / 3, PERSON / 3) for side in (-1, 1)) + ("borders",)


def parking(seed, target="car"):
    """Figure 4: a parking place seen from above, with a person who walks and a car that turns while it comes closer; 150 frames.

    target: "car" or "person"; the other one moves behind.  The car doubles its size and comes to show another view.  Raises ValueError for any other target.
    """
    rng = np.random.default_rng((12, seed))
    times = np.arange(0.0, 176, 25)
    walk = Layer("astronaut", 26.0, _way(times, np.linspace(40, 250, 8) + rng.normal(0, 5, 8), np.linspace(205, 150, 8) + rng.normal(0, 5, 8)))
    drive = _way(times, np.linspace(270, 90, 8) + rng.normal(0, 6, 8), np.linspace(45, 120, 8) + rng.normal(0, 4, 8), np.linspace(0.6, 1.3, 8))
    car = Layer("car", 80.0, drive, view=_side(), turn=((50.0, 0.0), (110.0, 1.0)))
    layers = {"car": car, "person": walk}
    if target not in layers:
        raise ValueError(f"target is {target!r}; it must be car or person")
    chosen = layers.pop(target)
    return Scene(chosen, "gravel", 150, behind=tuple(layers.values()), seed=seed)


def traffic(seed, turns=True, growth=1.8):
    """Figures 8 and 9: a car ahead, seen from a car: it moves fast on the screen, grows by a factor, and turns; 150 frames.

    turns: without, the scale alone changes and the car looks the same all the time.
    """
    rng = np.random.default_rng((13, seed))
    times = np.arange(0.0, 176, 25)
    x, y = np.clip(160 + np.cumsum(rng.normal(0, 22, 8)), 90, 230), 120 + rng.normal(0, 10, 8)
    scales = growth ** np.clip((times - 15) / 110, 0, 1)
    shake = np.column_stack([np.arange(0.0, 161, 10), rng.normal(0, 4, (17, 2)), np.zeros(17), np.ones(17)])
    car = Layer("car", 72.0, _way(times, x, y, scales), view=_side() if turns else None, turn=((15.0, 0.0), (135.0, 1.0)))
    return Scene(car, "workshop", 150, camera=tuple(tuple(map(float, row)) for row in shake.round(3)), seed=seed)


def _side():
    """The car's other view: the same shape in other colours."""
    return Layer("car", 80.0, ((0.0, 0.0, 0.0, 0.0, 1.0),), hue=100.0)


def head():
    """Figure 10: the head of the clip `mkt.datasets.carphone`, played forward and backward up to 450 frames, with our annotation.

    Returns a `Sequence`.  Raises DataError as `carphone` does.
    """
    clip = carphone()
    frames = list(clip.frames)  # 9 MB, kept: each is shown four times
    turn = np.abs((np.arange(HEAD) + len(clip) - 1) % (2 * (len(clip) - 1)) - (len(clip) - 1))
    return Sequence("head", [frames[k] for k in turn], clip.truth[turn], clip.visibility[turn], clip.source, clip.upright, clip.fps)
