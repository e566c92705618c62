"""What an adaptive filter learns of the target and of its background."""

import numpy as np
import pytest

from mkt.colors import BinImage
from mkt.trackers import appearance
from mkt.trackers.ellipses import Disc


@pytest.mark.parametrize("axes", [(1.0, 1.0), (2.0, 3.0), (0.1, 40.0)])
def test_a_small_target_in_a_large_frame_has_some_ellipses_and_no_millions(axes):
    image = BinImage(np.zeros((540, 960), np.uint8), 4)
    roots = appearance.background(Disc(), image, np.array(axes))
    assert appearance.MOST / 2 < len(roots) < 1.1 * appearance.MOST


def test_the_background_leaves_out_the_target():
    """On a plain image with one blot, no background ellipse sees the blot."""
    labels = np.zeros((120, 160), np.uint16)
    labels[42:58, 72:88] = 7
    image = BinImage(labels, 512)
    region = np.array([79.5, 49.5, 0.0, 12.0, 12.0])
    without, with_it = (
        appearance.background(Disc(), image, region[3:], where)
        for where in (region, None)
    )
    assert not without[:, 7].any() and with_it[:, 7].any()
    everything = np.array([80.0, 60.0, 0, 160, 120])
    with pytest.raises(ValueError, match="no background"):
        appearance.background(Disc(), image, everything[3:], everything)


def test_the_threshold_is_mean_plus_two_spreads():
    roots = np.sqrt(np.array([[1.0, 0], [0.64, 0.36], [0.36, 0.64]]))
    limit = appearance.threshold(roots, np.array([1.0, 0.0]))
    assert limit == pytest.approx(0.8 + 2 * np.std([1, 0.8, 0.6]))


@pytest.mark.parametrize("half_axes", [(20.0, 10.0), (0.5, 30.0)])
def test_the_background_is_looked_at_on_a_grid_of_its_own_size(half_axes):
    """From the first pixel on, every so many half axes, and not closer than a pixel."""
    image = BinImage(np.zeros((60, 80), np.uint8), 3)
    looked = []

    class Watching(Disc):
        def histograms(self, image, regions):
            looked.append(regions)
            return super().histograms(image, regions)

    appearance.background(Watching(), image, np.array(half_axes))
    columns, rows = (np.unique(looked[0][:, k]) for k in (0, 1))
    for places, side, half in zip((columns, rows), (80, 60), half_axes, strict=True):
        between = max(appearance.EVERY * half, 1)
        np.testing.assert_allclose(places, np.arange(0, side, between))
    assert len(looked[0]) == len(columns) * len(rows)
    assert (looked[0][:, 2:] == (0, *half_axes)).all()


def test_the_background_begins_where_two_ellipses_touch():
    """Half axes 20 and 10 round a target of 30 and 20: 50 along x and 30 along y."""
    image = BinImage(np.zeros((240, 320), np.uint8), 3)
    target, halves = np.array([160.0, 120.0, 0, 30.0, 20.0]), np.array([20.0, 10.0])
    looked = []

    class Watching(Disc):
        def histograms(self, image, regions):
            looked.append(regions)
            return super().histograms(image, regions)

    appearance.background(Watching(), image, halves, target)
    off = (looked[0][:, :2] - target[:2]) / (50, 30)
    r = np.hypot(*off.T)
    assert 1 < r.min() < 1.2
