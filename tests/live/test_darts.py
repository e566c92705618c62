"""The darts on the bar of weights hit as often as the scheme draws."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from mkt.figures.live import MODULES
from mkt.particles import SCHEMES
from tests.live.conftest import assert_found, fixture_of

MODULE = (MODULES / "darts.js").read_text("utf-8")
RUN = "return live.thrown(data.scheme, data.weights, data.drawn);"
few = settings(
    max_examples=60, deadline=None, phases=[Phase.generate], derandomize=True
)
weights = st.lists(st.floats(0, 1), min_size=2, max_size=12).filter(sum).map(np.array)

bar = fixture_of(MODULE)


class Drawn:
    """A generator of the uniforms that were drawn before."""

    def __init__(self, uniforms):
        self._uniforms = uniforms

    def random(self, n=None):
        return self._uniforms[0] if n is None else self._uniforms[:n]


def agrees(engine, scheme, given_weights, seed):
    w = given_weights / given_weights.sum()
    uniforms = np.random.default_rng(seed).random(len(w))
    found = engine(RUN, scheme=scheme, weights=w.tolist(), drawn=uniforms.tolist())
    assert min(found["shares"]) >= 0
    ends = np.cumsum(found["shares"])
    hit = np.searchsorted(ends, found["darts"], side="right")
    offspring = found["certain"] + np.bincount(hit, minlength=len(w))
    wanted = np.bincount(SCHEMES[scheme](w, Drawn(uniforms)), minlength=len(w))
    assert offspring.tolist() == wanted.tolist()


def everywhere(engine):
    few(
        given(st.sampled_from(sorted(SCHEMES)), weights, st.integers(0, 999))(
            lambda scheme, w, seed: agrees(engine, scheme, w, seed)
        )
    )()


def test_as_many_darts_hit_a_share_as_the_particle_has_offspring(bar):
    everywhere(bar)


def test_of_equal_weights_everybody_is_certain_to_live_once(bar):
    agrees(bar, "residual", np.ones(49), 0)  # 49 * (1 / 49) < 1


FAULTS = {
    "one dart for all": ("(i + drawn[i]) / n", "(i + drawn[0]) / n"),
    "a dart in each share of systematic": ("(i + drawn[0]) / n", "(i + drawn[i]) / n"),
    "the whole bar for what is left": ("n * w - certain[i]", "n * w"),
    "nobody is certain": ('"residual" ? Math', '"rest" ? Math'),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_found(bar, fault):
    assert_found(bar, MODULE, *FAULTS[fault], everywhere)
