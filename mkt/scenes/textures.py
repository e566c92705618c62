"""What the synthetic scenes are made of: objects with an outline, and grounds.

Some are photographs (`mkt.scenes.photographs`), others are painted
(`mkt.scenes.objects`, `mkt.scenes.grounds`).  All are (h, w, 4) uint8 RGBA arrays,
transparent where the object is not.

Shown in notebook 02.
"""

from functools import lru_cache

import cv2

from mkt.checks import locked
from mkt.scenes import grounds, objects
from mkt.scenes.photographs import PHOTOGRAPHS, photograph
from mkt.types import NDArray

OBJECTS = ("car", "astronaut", "badge", "cat", "cup", "motorcycle", "hopper")
CUT_OUT = ("ring", "starfish")  # objects with a hole, and with limbs
PAINTED = objects.PAINTED | grounds.PAINTED
NAMES = (*PAINTED, *PHOTOGRAPHS)


@lru_cache(maxsize=32)
def texture(name: str) -> NDArray:
    """A texture by its name, at the resolution of its source.

    Parameters
    ----------
    name : str
        One of `NAMES`.

    Returns
    -------
    (h, w, 4) uint8 array
        RGBA, read-only.

    Raises
    ------
    ValueError
        Listing the names.
    """
    if name not in NAMES:
        raise ValueError(f"no texture {name!r}; there are {', '.join(NAMES)}")
    return locked(PAINTED[name]() if name in PAINTED else photograph(name))


def wall(ground: str) -> str:
    """The texture of a wall that stands out before a ground."""
    return "gravel" if ground == "bricks" else "bricks"


@lru_cache(maxsize=32)
def resized(name: str, factor: float) -> NDArray:
    """A texture (h, w, 4) uint8 reduced or enlarged by a factor, without aliasing."""
    rgba = texture(name)
    size = tuple(max(round(factor * side), 2) for side in rgba.shape[1::-1])
    how = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    return locked(cv2.resize(rgba, size, interpolation=how))
