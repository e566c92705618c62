"""What hypothesis draws from: regions, points and frames."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays


def regions(size=(64, 48), largest=40.0):
    """Regions (5,) in and around an image of the size (width, height)."""
    width, height = size
    return st.builds(
        lambda *numbers: np.array(numbers),
        st.floats(-width, 2 * width), st.floats(-height, 2 * height), st.floats(-7, 7), st.floats(0.5, largest), st.floats(0.5, largest),
    )


def points(n=5):
    """Canonical points (n, 2)."""
    return arrays(float, (n, 2), elements=st.floats(-1, 1))


def frames(size=(64, 48)):
    """Frames (H, W, 3) uint8 of coloured noise in blocks of up to 8 px."""
    def draw(seed, block):
        width, height = size
        blocks = np.random.default_rng(seed).integers(0, 256, (height // block + 1, width // block + 1, 3), dtype=np.uint8)
        return np.ascontiguousarray(blocks.repeat(block, 0).repeat(block, 1)[:height, :width])

    return st.builds(draw, st.integers(0, 2**32 - 1), st.integers(1, 8))
