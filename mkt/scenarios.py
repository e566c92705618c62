"""Named tests for trackers: seed, object and background -> a `Scene`.

Five scenarios that each ask one question (base, look-alike, occlusion, blur, illumination), and the two sequences of [T09] that its figures
5 to 7 show.  The paths are random but smooth; everything follows from the arguments.

Used in notebooks 04 to 06.
"""

from dataclasses import replace

import numpy as np

from mkt.scenes import Layer, Scene, regions

LENGTH = 120
WIDTH = 80.0  # of the object [px]


def path(rng, length=LENGTH, every=20, turn=0.5, growth=0.25):
    """Way-points of a smooth random walk inside the image, one each `every` frames.

    turn: standard deviation of the rotation from one to the next [rad]; growth: bound on the logarithm of the size.
    Returns a tuple for `Layer.path`.
    """
    times = np.arange(0, length + every, every, dtype=float)
    places = rng.uniform([70, 60], [250, 180], (len(times), 2))
    angles = np.cumsum(rng.normal(0, turn, len(times)))
    scales = np.exp(rng.uniform(-growth, growth, len(times)))
    table = np.column_stack([times, places, angles - angles[0], scales / scales[0]])
    # It starts from rest, so that the first frame, where it is learnt, is sharp.
    return _rounded(np.concatenate([table[:1] - [[2, 0, 0, 0, 0]], table[:1] - [[1, 0, 0, 0, 0]], table[:1], table[1:] + [[2, 0, 0, 0, 0]]]))


def _rounded(table):
    return tuple(tuple(map(float, row)) for row in np.round(table, 3))


def base(seed, object="car", background="workshop"):
    """Translation, rotation and scale at a moderate speed."""
    rng = np.random.default_rng((1, seed))
    return Scene(Layer(object, WIDTH, path(rng)), background, LENGTH, seed=seed)


def look_alike(seed, object="car", background="workshop"):
    """Two others cross the path: the same colours in another arrangement, and the same object in other colours."""
    rng = np.random.default_rng((2, seed))
    twins = Layer(object, WIDTH, path(rng), shuffle=3), Layer(object, WIDTH, path(rng), hue=120.0)
    return Scene(Layer(object, WIDTH, path(rng)), background, LENGTH, behind=twins, seed=seed)


def occlusion(seed, object="car", background="workshop", first=46, hidden=10):
    """A panel sweeps over the image and hides the object totally for about `hidden` frames from frame `first` on."""
    rng = np.random.default_rng((3, seed))
    target = path(rng, growth=0.0)
    return Scene(Layer(object, WIDTH, target), background, LENGTH, front=(panel(target, first, hidden),), seed=seed)


def panel(target, first, hidden, width=150.0, texture="bricks"):
    """A wall that comes from the left and hides the layer on this path from frame `first` on for about `hidden` frames."""
    table = np.array(target)
    x = np.interp([first, first + hidden], table[:, 0], table[:, 1])
    slack = width / 2 - WIDTH / 2 * 1.25  # the object's half diagonal must fit too
    start, end = x[0] - slack, x[1] + slack
    speed = max((end - start) / hidden, 4.0)
    way = [(0.0, start - speed * first, 120.0, 0.0, 1.0), (float(LENGTH), start + speed * (LENGTH - first), 120.0, 0.0, 1.0)]
    return Layer(texture, width, _rounded(np.array(way)))


def blur(seed, object="car", background="workshop"):
    """Fast bursts under a shutter that is open nearly all the time."""
    rng = np.random.default_rng((4, seed))
    return Scene(Layer(object, WIDTH, path(rng, every=8, turn=0.3)), background, LENGTH, shutter=0.9, seed=seed)


def illumination(seed, object="car", background="workshop"):
    """The light dims, brightens and changes its colour."""
    rng = np.random.default_rng((5, seed))
    gains = np.exp(rng.uniform(-0.5, 0.2, (4, 1)) + rng.normal(0, 0.12, (4, 3)))
    light = np.column_stack([[0.0, 40.0, 80.0, 120.0], np.concatenate([np.ones((1, 3)), gains[1:]])])
    return Scene(Layer(object, WIDTH, path(rng)), background, LENGTH, light=_rounded(light), seed=seed)


def fast(seed, object="car", background="workshop", exposure=0.9):
    """The sequence of figure 5 of [T09]: translation, rotation and scale, so fast that a shutter open for `exposure` of the frame period blurs it.

    The path is the seed's, the sensor noise that of `Scene.seed`.  The speed is ours: about an eighth of the object's width a frame, up to a quarter.
    """
    rng = np.random.default_rng((6, seed))
    return Scene(Layer(object, WIDTH, path(rng, 60, every=10, turn=0.4)), background, 60, shutter=exposure, seed=seed)


def hidden(seed, object="car", background="workshop", first=46, frames=5):
    """The sequence of figures 6 and 7 of [T09]: fast translation and rotation at a fixed size, totally hidden from frame `first` on for some frames.

    The path is the seed's, the sensor noise that of `Scene.seed`.  The speed is ours: about a thirteenth of the object's width a frame, up to a sixth.
    """
    rng = np.random.default_rng((7, seed))
    scene = Scene(Layer(object, WIDTH, path(rng, 80, every=16, growth=0.0)), background, 80, seed=seed)
    return replace(scene, front=(screen(scene, first, frames),))


def screen(scene, first, frames, speed=24.0, texture="bricks"):
    """A screen carried past the target from right to left: the whole target is behind it during the exposures of just these frames.

    It goes along with the target, and past it at `speed` [px a frame], so that every path is hidden for the same time.  Returns a `Layer`.
    """
    ends = np.array([first - scene.shutter / 2, first + frames - 1 + scene.shutter / 2])
    _, _, theta, hx, hy = regions(scene, scene.target, ends).T
    reach = np.abs(hx * np.cos(theta)) + np.abs(hy * np.sin(theta))  # half width of the upright box
    times = np.arange(-1.0, scene.length + 1)
    left, right = (side - speed * (times - end) for side, end in zip((-reach[0], reach[1]), ends))
    way = np.column_stack([times, regions(scene, scene.target, times)[:, :2], 0 * times, 1 + 0 * times])
    way[:, 1] += (left + right) / 2
    return Layer(texture, float(np.ceil(right[0] - left[0])), _rounded(way))


SCENARIOS = {"base": base, "look-alike": look_alike, "occlusion": occlusion, "blur": blur, "illumination": illumination, "fast": fast, "hidden": hidden}
