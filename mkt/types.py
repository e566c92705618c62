"""The aliases of the annotations: what an array holds, where its type cannot say it."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

# (H, W, 3) uint8, RGB; OpenCV's own annotations promise less than uint8.
Frame: TypeAlias = NDArray[Any]
Array: TypeAlias = NDArray[np.floating]
Region: TypeAlias = Array  # (5,) float64, see `mkt.regions`
Regions: TypeAlias = Array  # (..., 5) float64
Rng: TypeAlias = np.random.Generator

__all__ = ["Array", "ArrayLike", "Frame", "NDArray", "Region", "Regions", "Rng"]
