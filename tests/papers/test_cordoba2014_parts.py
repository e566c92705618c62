"""What the figures of [C14] are made of, on toy sequences: nothing is tracked."""

import pytest

from mkt.papers.cordoba2014.looks import LOOKS, RIVALS


@pytest.mark.parametrize("pair", LOOKS.values(), ids=LOOKS)
def test_resampling_alone_tells_the_two_of_a_look_apart(pair):
    pfhr, sir = (RIVALS[name] for name in pair)
    assert type(pfhr) is not type(sir)
    assert (pfhr.n, pfhr.bins, pfhr.kernels) == (sir.n, sir.bins, sir.kernels)
