"""Following the light: three gains, one a colour channel, between the first look at an object and now.

Histograms of colour change when the light does.  A reference that is learnt anew in every frame would follow the light, but whatever else
comes into the region too, and drift away.  Three gains cannot learn another object: they are estimated from the mean colours under the
kernels, and a change of them is kept only if the histograms then look more like the reference, which itself never changes.
"""

from typing import NamedTuple

import cv2
import numpy as np

from mkt.histograms import Target, checked_frame, coefficient
from mkt.regions import warp_matrices
from mkt.trackers.ssd import count, template

BOUNDS = 0.25, 4.0  # of a gain: two stops up or down


class Light(NamedTuple):
    """The reference and the mean colours (J, 3) under its kernels at the first look; the gains (3,) since."""

    target: Target
    colors: np.ndarray
    gains: np.ndarray


def first_light(target, frame, region):
    """The `Light` under which a target was learnt in a region (5,) of a frame (H, W, 3): all gains 1."""
    return Light(target, _means(target, _pixels(target, frame, region)), np.ones(3))


def relit(frame, gains):
    """A frame, or any pixels (H, W, 3) uint8, as they would be under gains of 1.  Raises ValueError for any other shape or type."""
    return cv2.LUT(checked_frame(frame), np.clip(np.arange(256)[:, None, None] / gains, 0, 255).astype(np.uint8))


def followed(light, frame, region, rate=0.3):
    """The `Light` after the object was seen in a region (5,) of a frame, its gains nearer to what the colours say by the share `rate`.

    The gains may also stay or go back towards 1: those are taken under which the object looks most like its reference.
    """
    target, pixels = light.target, _pixels(light.target, frame, region)
    says = np.median(_means(target, pixels) / light.colors, axis=0)
    candidates = [light.gains, np.clip(light.gains ** (1 - rate) * says**rate, *BOUNDS), light.gains**0.9]
    return light._replace(gains=max(candidates, key=lambda gains: _likeness(target, relit(pixels, gains))))


def _pixels(target, frame, region):
    """The colours under the sample points of a region (5,), (1, n, 3); beyond the image those of its border."""
    x, y = (warp_matrices(region) @ target.kernels.homogeneous)[:, None].astype(np.float32)
    return cv2.remap(frame, x, y, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)


def _means(target, pixels):
    """Mean colours under the kernels, (J, 3), at least 1."""
    return np.maximum(target.kernels.weights @ pixels[0], 1.0)


def _likeness(target, pixels):
    """The mean Bhattacharyya coefficient of pixels (1, n, 3) at the sample points."""
    q, = count(target, target.bins(pixels)[0], template(target.kernels).columns[:1])
    return coefficient(q, target.q).mean()
