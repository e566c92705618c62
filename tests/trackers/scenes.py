"""What tests of several trackers look at: short scenes of one car."""

from dataclasses import replace

from mkt.scenes.layers import Layer
from mkt.scenes.rendering import Scene

STANDING = Scene(Layer("car", 80.0, ((0.0, 159.5, 119.5, 0.2, 1.0),)), length=30)
START, END = (0.0, 110.0, 110.0, 0.0, 1.0), (40.0, 190.0, 130.0, 0.0, 1.2)
GROWING = Scene(Layer("car", 80.0, (START, END)), "grass", 40)


def short(scene, length=30):
    """The sequence of a scene that ends earlier."""
    return replace(scene, length=length).sequence()
