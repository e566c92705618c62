"""What the drawings take."""

import matplotlib.pyplot as plt
import numpy as np

from mkt.colors import ColorBins
from mkt.plotting import draw_histogram, draw_map


def test_a_histogram_may_be_a_list():
    """As a student's may be, who has written it without numpy."""
    bins = ColorBins()
    q = np.zeros(bins.m)
    q[[3, 40]] = 0.25, 0.75
    heights = []
    for given in (q, q.tolist()):
        fig, ax = plt.subplots()
        draw_histogram(ax, given, bins)
        (bars,) = ax.collections
        heights.append([path.get_extents().height for path in bars.get_paths()])
        plt.close(fig)
    assert heights[0] == heights[1] == [0.25, 0.75]


def test_a_flat_surface_has_a_map_without_contours():
    fig, ax = plt.subplots()
    mesh = draw_map(ax, np.arange(3.0), np.arange(2.0), np.full((2, 3), 0.5))
    assert list(ax.collections) == [mesh]
    plt.close(fig)
