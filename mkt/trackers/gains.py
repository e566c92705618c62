"""Following the light by three gains, one for each colour channel.

They stand for how the light has changed between the first look at an object and now.

Histograms of colour change when the light does.  A reference that is learnt anew in
every frame would follow the light, but whatever else comes into the region too, and
drift away. Three gains cannot learn another object: they are estimated from the mean
colours under the kernels, and a change of them is kept only if the histograms then look
more like the reference, which itself never changes.
"""

from typing import NamedTuple

import cv2
import numpy as np

from mkt.checks import checked_frame
from mkt.colors import Bins
from mkt.histograms import Target, coefficient
from mkt.regions import warp_matrices
from mkt.trackers.newton import count, template
from mkt.types import Array, Frame, NDArray, Region

BOUNDS = 0.25, 4.0  # of a gain: two stops up or down


class Light(NamedTuple):
    """What the light was like at the first look, and what it is like now.

    Attributes
    ----------
    target : Target
        The reference.
    bins : Bins
        Those that it was learnt with.
    colors : (J, 3) array
        Mean colours under its kernels at the first look.
    gains : (3,) array
        The gains since.
    """

    target: Target
    bins: Bins
    colors: Array
    gains: Array


def first_light(target: Target, bins: Bins, frame: Frame, region: Region) -> Light:
    """The light under which a target was learnt in a region (5,): all gains 1.

    Parameters
    ----------
    target : Target
    bins : Bins
        Those that it was learnt with.
    frame : (H, W, 3) uint8 array, RGB
    region : (5,) array [px, rad]
    """
    colors = _means(target, _pixels(target, frame, region))
    return Light(target, bins, colors, np.ones(3))


def relit(frame: Frame, gains: Array) -> Frame:
    """A frame, or any pixels (H, W, 3) uint8, as they would be under gains of 1.

    Fractions of a grey level are cut off, so that it is a little too dark.

    Parameters
    ----------
    frame : (H, W, 3) uint8 array, RGB
    gains : (3,) array
        Of red, green and blue, above 0.

    Raises
    ------
    ValueError
        For any other shape or type.
    """
    table = np.clip(np.arange(256)[:, None, None] / gains, 0, 255).astype(np.uint8)
    return cv2.LUT(checked_frame(frame), table)


def followed(light: Light, frame: Frame, region: Region, rate: float = 0.3) -> Light:
    """The light after the object was seen in a region (5,) of a frame.

    Its gains come nearer to what the colours say by the share `rate`.  They may also
    stay or go back towards 1: the gains are taken under which the object looks most
    like its reference.

    Parameters
    ----------
    light : Light
    frame : (H, W, 3) uint8 array, RGB
    region : (5,) array [px, rad]
    rate : float
        In [0, 1].
    """
    pixels = _pixels(light.target, frame, region)
    ratios = _means(light.target, pixels) / light.colors
    learnt = light.target.learnt
    told = np.median(ratios if learnt is None else ratios[learnt], axis=0)
    nearer = np.clip(light.gains ** (1 - rate) * told**rate, *BOUNDS)
    candidates = [light.gains, nearer, light.gains**0.9]
    colors = np.concatenate([relit(pixels, gains) for gains in candidates])
    likeness = [_likeness(light, labels) for labels in light.bins(colors).labels]
    return light._replace(gains=candidates[int(np.argmax(likeness))])


def _pixels(target: Target, frame: Frame, region: Region) -> Frame:
    """The colours under the sample points of a region (5,), (1, n, 3).

    Beyond the image they are those of its border.
    """
    places = warp_matrices(region) @ target.kernels.homogeneous
    x, y = places[:, None].astype(np.float32)
    return cv2.remap(frame, x, y, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)


def _means(target: Target, pixels: Frame) -> Array:
    """Mean colours under the kernels, (J, 3), at least 1."""
    return np.maximum(target.kernels.weights @ pixels[0], 1.0)


def _likeness(light: Light, labels: NDArray) -> float:
    """The mean Bhattacharyya coefficient of bins (n,) at the sample points."""
    target = light.target
    q = count(target, labels, template(target.kernels).columns[:, :1])[..., 0]
    return coefficient(q, target.q).mean()
