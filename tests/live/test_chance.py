"""The page's binomial distribution is Python's."""

import numpy as np
import pytest
import scipy
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from mkt.figures.live import MODULES
from mkt.papers.lessons.chance import false_start
from tests.live.conftest import assert_found, fixture_of

MODULE = (MODULES / "binomial.js").read_text("utf-8")
RUN = """
const { n, p, b } = data;
return { each: live.binomial(n, p), false: live.falseStart(n, p, b) };
"""
few = settings(
    max_examples=60, deadline=None, phases=[Phase.generate], derandomize=True
)


binomial = fixture_of(MODULE)


def agrees(engine, n, percent, b):
    found = engine(RUN, n=n, p=percent / 100, b=b)
    expected = scipy.stats.binom.pmf(np.arange(n + 1), n, percent / 100)
    np.testing.assert_allclose(found["each"], expected, rtol=1e-9, atol=1e-300)
    false = float(false_start(n, percent / 100, b))
    assert found["false"] == pytest.approx(false, rel=1e-9, abs=1e-300)


def everywhere(engine):
    sizes, shares = st.integers(25, 400), st.floats(0.5, 20)
    limits = st.integers(2, 40).map(lambda b: b / 100)
    agrees(engine, 100, 5, 0.29)  # whose product is less than 29
    few(given(sizes, shares, limits)(lambda n, p, b: agrees(engine, n, p, b)))()


def test_the_count_is_distributed_as_in_python(binomial):
    everywhere(binomial)


FAULTS = {
    "as many start, too": (" - each)", ")"),
    "odds without the rest": ("Math.log(p) - Math.log1p(-p)", "Math.log(p)"),
    "one sample too many": ("(n - k + 1) / k", "(n - k + 2) / k"),
    "the limit rounded": ("Math.floor(b * n + 1e-9)", "Math.round(b * n)"),
    "one draw fewer": ("[n * Math.log1p(-p)]", "[(n - 1) * Math.log1p(-p)]"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_found(binomial, fault):
    assert_found(binomial, MODULE, *FAULTS[fault], everywhere)
