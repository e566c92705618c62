"""What hypothesis draws from: regions, points and frames."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays


def regions(size=(64, 48), largest=40.0):
    """Regions (5,) in and around an image of the size (width, height)."""
    width, height = size
    return st.tuples(
        st.floats(-width, 2 * width),
        st.floats(-height, 2 * height),
        st.floats(-7, 7),
        st.floats(0.5, largest),
        st.floats(0.5, largest),
    ).map(np.array)


def points(n=5):
    """Canonical points (n, 2)."""
    return arrays(float, (n, 2), elements=st.floats(-1, 1))


def frames(size=(64, 48)):
    """Frames (H, W, 3) uint8 of coloured noise in blocks of up to 8 px."""
    width, height = size

    def draw(seed, block):
        rng = np.random.default_rng(seed)
        shape = (height // block + 1, width // block + 1, 3)
        blocks = rng.integers(0, 256, shape, dtype=np.uint8)
        enlarged = blocks.repeat(block, 0).repeat(block, 1)
        return np.ascontiguousarray(enlarged[:height, :width])

    return st.builds(draw, st.integers(0, 2**32 - 1), st.integers(1, 8))
