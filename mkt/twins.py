"""Synthetic twins of the six kinds of sequence in Table 1 of [C14], for whoever has no benchmark: seed, object and background -> a `Scene`.

Each has the difficulty of its original and none of its content.  The objects stay upright, as the boxes of the benchmark do.  Paths are random but
smooth; everything follows from the arguments.
"""

import numpy as np

from mkt.scenes import Layer, Scene

LENGTH = 150
WIDTH = 64.0  # of the object [px]
MIDDLE = np.array([160.0, 120.0])
SHUTTER = 0.1  # of the frame period: blur is not the question here, and a sharp frame is rendered at once
EDGES = 60.0, 50.0  # [px] how near to the border of the image the object's centre may come


def clutter(seed, object="car", background="workshop"):
    """Before things of its own colours, seen by a camera that moves and zooms: four shuffled copies of the object lie about."""
    rng = np.random.default_rng((21, seed))
    places = MIDDLE + np.array([[-95, -60], [95, -65], [-90, 70], [100, 60]]) + rng.normal(0, 12, (4, 2))
    others = tuple(Layer(object, WIDTH, ((0.0, float(x), float(y), 0.0, 1.0),), hue=hue, shuffle=3) for (x, y), hue in zip(places, (0.0, 30.0, 160.0, 60.0)))
    return Scene(Layer(object, WIDTH, wander(rng, 25, 0.15)), background, LENGTH, behind=others, camera=shaky(rng, 10, 0.12), shutter=SHUTTER, seed=seed)


def passers(seed, object="car", background="workshop"):
    """Outdoors: three larger look-alikes, the object in slightly other colours, come from either side and hide it totally for some frames each."""
    rng = np.random.default_rng((22, seed))
    path = wander(rng, 30, 0.15)
    front = []
    for frame in (40, 80, 120):
        x, y = position(path, frame)
        speed = rng.choice([-1, 1]) * rng.uniform(5, 8)
        way = [[0, x - speed * frame, y, 0, 1], [LENGTH, x + speed * (LENGTH - frame), y, 0, 1]]
        front.append(Layer(object, 1.7 * WIDTH, _way(way), hue=float(rng.choice([24, 40, 60])), shuffle=int(rng.integers(1, 4))))
    return Scene(Layer(object, WIDTH, path), background, LENGTH, front=tuple(front), shutter=SHUTTER, seed=seed)


def pillars(seed, object="car", background="workshop"):
    """Indoors: the object walks behind three pillars, and the camera goes along with it."""
    rng = np.random.default_rng((23, seed))
    times = np.arange(0, LENGTH + 25, 25.0)
    x = 160 + rng.choice([-1, 1]) * rng.uniform(4, 6) * (times - LENGTH / 2) + rng.normal(0, 6, len(times))
    path = _way(np.column_stack([times, x, 120 + rng.normal(0, 8, len(times)), 0 * times, growth(rng, len(times), 0.1)]))
    follow = np.column_stack([times, 160 - x + rng.normal(0, 12, len(times)), rng.normal(0, 6, len(times)), rng.normal(0, 0.01, len(times)), 1 + 0 * times])
    fronts = tuple(Layer(name, rng.uniform(1.5, 1.8) * WIDTH, _way([[0, *position(path, frame), 0, 1]]))
                   for name, frame in zip(("bricks", "tissue", "grass"), (35, 75, 115)))
    return Scene(Layer(object, WIDTH, path), background, LENGTH, front=fronts, camera=_way(follow), shutter=SHUTTER, seed=seed)


def scale(seed, object="car", background="workshop"):
    """The size goes from about half to about twice what it was, and back."""
    rng = np.random.default_rng((24, seed))
    return Scene(Layer(object, WIDTH, wander(rng, 25, 0.45)), background, LENGTH, shutter=SHUTTER, seed=seed)


def trajectory(seed, object="car", background="workshop"):
    """Kicked about: from wall to wall in steps of up to about half of the object a frame, with sudden turns."""
    rng = np.random.default_rng((25, seed))
    times = np.arange(0, LENGTH + 8, 8.0)
    places = rng.uniform(EDGES, 2 * MIDDLE - EDGES, (len(times), 2))
    places[0] = places[1] = MIDDLE
    way = _way(np.column_stack([times, places, 0 * times, growth(rng, len(times), 0.15)]))
    return Scene(Layer(object, WIDTH, way), background, LENGTH, camera=shaky(rng, 8, 0.05), shutter=SHUTTER, seed=seed)


def background_change(seed, object="car", background="workshop"):
    """A slow pan over four grounds of other colours, one after the other."""
    rng = np.random.default_rng((26, seed))
    times = np.arange(0, LENGTH + 25, 25.0)
    x = 160 + 8 * (times - times[0])
    y = 120 + rng.normal(0, 15, len(times))
    path = _way(np.column_stack([times, x + rng.normal(0, 15, len(times)), y, 0 * times, growth(rng, len(times), 0.2)]))
    grounds = tuple(Layer(name, 320.0, ((0.0, 160.0 + 320 * k, 120.0, 0.0, 1.2),)) for k, name in enumerate(("tissue", "gravel", "table", "grass"), 1))
    pan = np.column_stack([times, 160 - x, rng.normal(0, 6, len(times)), 0 * times, 1 + 0 * times])
    return Scene(Layer(object, WIDTH, path), background, LENGTH, behind=grounds, camera=_way(pan), shutter=SHUTTER, seed=seed)


def wander(rng, step, spread):
    """Way-points of a walk that begins in the middle and stays inside the image.

    step: standard deviation [px] from one way-point to the next, 15 frames later; spread: bound on the logarithm of the size.
    """
    times = np.arange(0, LENGTH + 15, 15.0)
    steps = rng.normal(0, step, (len(times), 2))
    steps[0] = 0
    places = np.clip(MIDDLE + np.cumsum(steps, 0), EDGES, 2 * MIDDLE - EDGES)
    return _way(np.column_stack([times, places, 0 * times, growth(rng, len(times), spread)]))


def growth(rng, n, spread):
    """n sizes, the first of them 1, their logarithms within `spread` of 0."""
    sizes = rng.uniform(-spread, spread, n)
    sizes[0] = 0
    return np.exp(sizes)


def shaky(rng, step, zoom):
    """Way-points of a camera that wanders about by `step` [px] and zooms by up to `zoom`, the logarithm of the size."""
    times = np.arange(0, LENGTH + 15, 15.0)
    shifts = rng.normal(0, step, (len(times), 2))
    shifts[0] = 0
    return _way(np.column_stack([times, shifts, rng.normal(0, 0.01, len(times)), growth(rng, len(times), zoom)]))


def position(path, frame):
    """Where a path is at a frame, about, (x, y) [px]."""
    table = np.array(path)
    return np.interp(frame, table[:, 0], table[:, 1]), np.interp(frame, table[:, 0], table[:, 2])


def _way(table):
    return tuple(tuple(map(float, row)) for row in np.round(np.asarray(table, float), 3))


TWINS = {"clutter": clutter, "passers": passers, "pillars": pillars, "scale": scale, "trajectory": trajectory, "background": background_change}
