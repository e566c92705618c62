"""The page's search through the weights finds, and counts, what Python's does."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from mkt.experiments.timing import exponent
from mkt.figures.live import MODULES
from mkt.papers.cordoba2014.resampling import ancestors, spans
from tests.live.conftest import assert_found, fixture_of

MODULE = (MODULES / "searching.js").read_text("utf-8")
RUN = """
const { cumulative, u, numbers } = data;
const found = [true, false].map((anew) => live.ancestors(cumulative, u, anew));
const rows = [true, false].map((anew) => live.spans(found[1].chosen, anew));
const points = numbers.map((each) => each.map(Math.log));
return { found, rows, slope: live.slope(points), sizes: live.geometric(25, 400, 7) };
"""
few = settings(
    max_examples=60, deadline=None, phases=[Phase.generate], derandomize=True
)
weights = st.lists(st.floats(1e-3, 1), min_size=2, max_size=30)
costs = st.lists(
    st.tuples(st.integers(2, 900), st.integers(2, 900)),
    min_size=2,
    max_size=6,
    unique_by=lambda pair: pair[0],
)


searching = fixture_of(MODULE)


def agrees(engine, w, offset, numbers):
    cumulative = np.cumsum(w)
    u = (np.arange(len(w)) + offset) / len(w) * cumulative[-1]
    found = engine(RUN, cumulative=cumulative.tolist(), u=u.tolist(), numbers=numbers)
    for k, anew in enumerate((True, False)):
        chosen, comparisons = ancestors(cumulative, u, anew)
        assert found["found"][k]["chosen"] == chosen.tolist()
        assert found["found"][k]["comparisons"] == comparisons
        assert found["rows"][k] == spans(chosen, anew).tolist()
    assert found["slope"] == pytest.approx(exponent(*np.transpose(numbers)), abs=1e-6)
    assert found["sizes"] == np.geomspace(25, 400, 7).round().astype(int).tolist()


def everywhere(engine):
    offsets = st.floats(0.01, 0.99)
    few(given(weights, offsets, costs)(lambda a, b, c: agrees(engine, a, b, c)))()


def test_both_readings_find_and_count_the_same(searching):
    everywhere(searching)


FAULTS = {
    "it never begins anew": ("if (anew) i = 0;", ""),
    "a place on the border": ("place > cumulative[i]", "place > cumulative[i] + 1e-2"),
    "one comparison less": ("comparisons++;\n    while", "while"),
    "a row too long": ("[anew || !draw ? 0 : chosen[draw - 1], last]", "[0, last]"),
    "through the first point": ("all + of(x - mx, y - my)", "all + of(x, y)"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_found(searching, fault):
    assert_found(searching, MODULE, *FAULTS[fault], everywhere)
