"""How well a track fits the truth: overlap and errors.

Explained in notebook 02.
"""

from typing import NamedTuple

import numpy as np
import shapely

from mkt.regions import area, corners, from_box, to_box, wrap_angle


class Errors(NamedTuple):
    """Errors of regions against the truth, one array (...) each: position [px], orientation [rad, in [0, pi]], scale as the logarithm
    of the ratio of sizes, 0 where they agree, NaN where the truth is."""

    position: np.ndarray
    orientation: np.ndarray
    scale: np.ndarray


def overlap(regions, truth, upright=False):
    """Area of the intersection over area of the union, (19) of [C14], of rotated rectangles.

    regions, truth: (..., 5) [px, rad]; upright: compare the upright boxes round them, for truths without an orientation.
    Returns (...) in [0, 1], NaN where either is not finite.
    """
    regions, truth = np.broadcast_arrays(np.asarray(regions, float), np.asarray(truth, float))
    known = np.isfinite(regions).all(-1) & np.isfinite(truth).all(-1)
    if upright:
        regions, truth = from_box(to_box(regions)), from_box(to_box(truth))
    a, b = (shapely.polygons(corners(r[known])) for r in (regions, truth))
    result = np.full(known.shape, np.nan)
    result[known] = shapely.area(shapely.intersection(a, b)) / shapely.area(shapely.union(a, b))
    return result


def errors(regions, truth):
    """Errors in position, orientation and scale.

    regions, truth: (..., 5) [px, rad].  Returns `Errors`.
    """
    regions, truth = np.asarray(regions, float), np.asarray(truth, float)
    return Errors(
        np.linalg.norm(regions[..., :2] - truth[..., :2], axis=-1),
        np.abs(wrap_angle(regions[..., 2] - truth[..., 2])),
        0.5 * np.log(area(regions) / area(truth)),
    )
