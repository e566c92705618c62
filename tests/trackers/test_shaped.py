"""The particle filter whose kernel has the shape of the target."""

import numpy as np
import pytest

from mkt.histograms import learn
from mkt.kernels import Kernels
from mkt.regions import displaced
from mkt.scenes.varied import Varied
from mkt.silhouettes import SIDE
from mkt.trackers.shaped import Shaped


@pytest.mark.parametrize("frame", [np.zeros((9, 9), np.uint8), np.zeros((9, 9, 3))])
def test_a_shape_is_sought_in_a_frame_of_colours_alone(frame):
    with pytest.raises(ValueError, match="a frame must be"):
        Shaped().init(frame, np.array([4.0, 4, 0, 2, 2]), None)


@pytest.mark.parametrize("shape", ["grab-cut", "colour ratio"])
def test_a_shaped_filter_learns_less_of_the_background(shape):
    """On a starfish on grass its q* has less of the colours of the grass."""
    clip = Varied("cut-out", 13).sequence()
    box = Kernels("one", "uniform", span=1.5, elliptic=True)
    rng = np.random.default_rng(0)
    shaped = Shaped(n=10, kernels=box, shape=shape)
    state = shaped.init(clip.frames[0], clip.truth[0], rng)
    plain = learn(shaped.bins(clip.frames[0]), clip.truth[0], box)
    assert state.target.q.shape == plain.q.shape
    assert state.target.q.sum() == pytest.approx(1, abs=1e-5)
    beside = displaced(clip.truth[0], -60, 0)
    grass = learn(shaped.bins(clip.frames[0]), beside, box).q > 0.02
    assert state.target.q[grass].sum() < 0.8 * plain.q[grass].sum()
    assert len(state.target.kernels.mask) == SIDE**2
