"""Is it there, and where to wait for it: the appearance condition and the placing of samples, Section 6 of [N03].

The coefficient of the model with ellipses all over the background has a mean mu and a spread sigma, (13) and (14).  A sample *appears* when
its own coefficient exceeds mu + 2 sigma, (15).  The paper calls that 95 %; one-sided and for a normal distribution it would be 97.7 %.
"""

import numpy as np

BAND = 1.0  # width of the band along the borders, in half axes


def background(disc, image, m, half_axes, without=None, every=0.5):
    """Square roots of the histograms of ellipses all over a frame, (I, m): enough for the coefficient with any model.

    image: (H, W) bin numbers below m; half_axes: (2,) [px]; every: the step of the grid, in half axes.
    without: a region (5,) [px] that no ellipse may touch.  Raises ValueError when that leaves none.
    """
    height, width = image.shape
    x, y = (np.arange(0, side, max(every * half, 1)) for side, half in zip((width, height), half_axes))
    centres = np.stack(np.meshgrid(x, y), -1).reshape(-1, 2)
    if without is not None:
        centres = centres[np.sum(((centres - without[:2]) / (without[3:] + half_axes)) ** 2, 1) > 1]
    if not len(centres):
        raise ValueError(f"the region {np.round(without, 1)} leaves no background to compare with; choose a smaller one")
    return np.sqrt(disc.histograms(image, m, np.column_stack([centres, np.zeros(len(centres)), np.tile(half_axes, (len(centres), 1))])))


def threshold(roots, q, sigmas=2.0):
    """mu + 2 sigma of the coefficient of a background, from `background` (I, m), with the model q (m,): (13) to (15)."""
    rho = roots @ np.sqrt(q)
    return float(rho.mean() + sigmas * rho.std())


def place(zones, shape, half_axes, n, rng):
    """Centres (n, 2) [px] where the target may appear, the zones taking turns.

    zones: "anywhere"; "borders", a band along the four sides of the image; or a door (x, y, spread x, spread y) [px], Gaussian.
    shape: (height, width) of the image; half_axes: (2,) of the target [px].  Raises ValueError for an unknown zone, or none.
    """
    if not zones:
        raise ValueError("zones is empty; name at least one of anywhere, borders, (x, y, spread x, spread y)")
    centres = np.empty((n, 2))
    for k, zone in enumerate(zones):
        centres[k::len(zones)] = _in_zone(zone, np.array(shape[1::-1], float), half_axes, len(centres[k::len(zones)]), rng)
    return centres


def _in_zone(zone, size, half_axes, n, rng):
    if zone == "anywhere":
        return rng.uniform(0, size - 1, (n, 2))
    if zone == "borders":
        centres, depth = rng.uniform(0, size - 1, (n, 2)), rng.uniform(0, BAND, (n, 2)) * half_axes
        vertical = rng.random(n) < size[1] / size.sum()  # as many a pixel of border on every side
        axis = np.where(vertical, 0, 1)
        k = np.arange(n)
        centres[k, axis] = np.where(rng.random(n) < 0.5, depth[k, axis], (size - 1)[axis] - depth[k, axis])
        return centres
    if isinstance(zone, str) or len(zone) != 4:
        raise ValueError(f"zone {zone!r} is unknown; there are anywhere, borders, and doors (x, y, spread x, spread y)")
    return rng.normal(zone[:2], zone[2:], (n, 2))
