"""Whether the target is there, and where to wait for it: Section 6 of [N03].

The appearance condition, and the placing of particles.

The coefficient of the model with ellipses all over the background has a mean mu and a
spread sigma, (13) and (14).  A particle *appears* when its own coefficient exceeds
mu + 2 sigma, (15).  The paper calls that 95 %; one-sided and for a normal distribution
it would be 97.7 %.
"""

import numpy as np

from mkt.checks import are_finite, in_words
from mkt.colors import BinImage
from mkt.trackers.ellipses import Disc
from mkt.types import Array, NDArray, Region, Rng

BAND = 1.0  # width of the band along the borders, in half axes
EVERY = 0.5  # step of the grid of background ellipses, in half axes
MOST = 5000  # of them: with 512 bins each their histograms take 10 MB

Zone = str | tuple[float, float, float, float]


def background(
    disc: Disc, image: BinImage, half_axes: Array, without: Region | None = None
) -> NDArray:
    """Square roots of the histograms of ellipses all over a frame, some `MOST` at most.

    They are enough for the coefficient with any model.

    Parameters
    ----------
    disc : Disc
    image : BinImage
        The bins of the frame.
    half_axes : (2,) array [px]
    without : (5,) array [px, rad], optional
        A region that no ellipse may touch.

    Returns
    -------
    (I, m) array

    Raises
    ------
    ValueError
        When that region leaves no ellipse.
    """
    height, width = (image.pitch * side for side in image.shape)
    every = np.maximum(EVERY * np.asarray(half_axes), 1)
    every *= max((width * height / every.prod() / MOST) ** 0.5, 1)
    x, y = np.arange(0, width, every[0]), np.arange(0, height, every[1])
    centres = np.stack(np.meshgrid(x, y), -1).reshape(-1, 2) + image.origin
    if without is not None:
        off = (centres - without[:2]) / (without[3:] + half_axes)
        centres = centres[np.sum(off**2, 1) > 1]
        if not len(centres):
            raise ValueError(
                f"the region {in_words(without)} leaves no background to compare "
                "with; choose a smaller one"
            )
    n = len(centres)
    ellipses = np.column_stack([centres, np.zeros(n), np.tile(half_axes, (n, 1))])
    return np.sqrt(disc.histograms(image, ellipses))


def threshold(roots: NDArray, q: NDArray) -> float:
    """Mu + 2 sigma of the coefficient of a background with a model, (13) to (15).

    Parameters
    ----------
    roots : (I, m) array
        Of `background`.
    q : (m,) array
        The model.
    """
    rho = roots @ np.sqrt(q)
    return float(rho.mean() + 2 * rho.std())


def check_zones(zones: tuple[Zone, ...]) -> None:
    """Refuse an unknown zone, or none, with a ValueError."""
    if not (isinstance(zones, tuple | list) and zones):
        raise ValueError(
            f"zones is {zones!r}; name at least one of anywhere, borders, "
            "(x, y, spread x, spread y)"
        )
    for zone in zones:
        door = not isinstance(zone, str) and are_finite(zone, 4) and min(zone[2:]) >= 0
        if not (door or zone in ("anywhere", "borders")):
            raise ValueError(
                f"zone {zone!r} is unknown; there are anywhere, borders, and doors "
                "(x, y, spread x, spread y)"
            )


def place(
    zones: tuple[Zone, ...],
    shape: tuple[int, ...],
    half_axes: Array,
    n: int,
    rng: Rng,
) -> Array:
    """Places where the target may appear, taken from the zones in turn.

    Parameters
    ----------
    zones : tuple
        "anywhere"; "borders", a band along the four sides of the image; or a door
        (x, y, spread x, spread y) [px], Gaussian.
    shape : (height, width, ...) of the image [px]
    half_axes : (2,) array [px]
        Of the target.
    n : int
    rng : numpy.random.Generator

    Returns
    -------
    (n, 2) array [px]
        Centres.

    Raises
    ------
    ValueError
        See `check_zones`.
    """
    check_zones(zones)
    size = np.array(shape[1::-1], float)
    centres = np.empty((n, 2))
    for k, zone in enumerate(zones):
        turn = centres[k :: len(zones)]
        turn[:] = _in_zone(zone, size, half_axes, len(turn), rng)
    return centres


def _in_zone(zone: Zone, size: Array, half_axes: Array, n: int, rng: Rng) -> Array:
    if zone == "anywhere":
        return rng.uniform(0, size - 1, (n, 2))
    if zone == "borders":
        return _along_borders(size, half_axes, n, rng)
    assert not isinstance(zone, str)  # or `check_zones` would have refused it
    return rng.normal(zone[:2], zone[2:], (n, 2))


def _along_borders(size: Array, half_axes: Array, n: int, rng: Rng) -> Array:
    """Centres (n, 2) in a band along the sides, equally many for each pixel of side."""
    centres = rng.uniform(0, size - 1, (n, 2))
    depth = rng.uniform(0, BAND, (n, 2)) * half_axes
    vertical = rng.random(n) < size[1] / size.sum()
    axis = np.where(vertical, 0, 1)
    k = np.arange(n)
    near = depth[k, axis]
    far = (size - 1)[axis] - depth[k, axis]
    centres[k, axis] = np.where(rng.random(n) < 0.5, near, far)
    return centres
