"""Intervals that cover what they should, tests that seldom cry, sums that add up."""

import functools
import re
from itertools import islice

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from mkt.experiments.statistics import (
    FRACTION,
    MEAN,
    MEDIAN,
    PAIRS,
    SHARE,
    STATISTICS,
    holm,
    interval,
    p_value,
    summaries,
)
from mkt.experiments.sweep import NUMBERS, write_table

FAKE = {
    "source": "base",
    "refused": "",
    "overlap": 0.5,
    "position": 1.0,
    "orientation": 2.0,
    "scale": 0.1,
    "hits": 1.0,
    "evaluations": 9.0,
    "cpu_ms": 3.0,
}
SCENES, TRIALS = 32, 1500  # as many scenes as claims have; simulated experiments


def skewed(rng):
    return rng.exponential(1, SCENES)


def ceiling(rng):
    return np.minimum(rng.normal(0.9, 0.2, SCENES), 1)


def flags(rng):
    return (rng.random(SCENES) < 0.8).astype(float)


def pairs(rng):
    """Two trackers that fail in 40 and 20 % of scenes, partly the same ones."""
    hard, other = rng.random((2, SCENES))
    shared = np.where(rng.random(SCENES) < 0.5, hard, other)
    return (hard < 0.4) * 1.0 - (shared < 0.2)


def truth(draw):
    rng = np.random.default_rng(9)
    return np.concatenate([draw(rng) for _ in range(20_000)])


@pytest.mark.slow
@pytest.mark.parametrize(
    "statistic, draw, least, most",
    [
        (MEDIAN, skewed, 0.945, 0.02),
        (MEAN, ceiling, 0.93, 0.035),
        (SHARE, flags, 0.95, 0.02),
        (PAIRS, pairs, 0.93, None),  # its test is of 0 alone, see below
    ],
    ids=lambda value: getattr(value, "name", None) or getattr(value, "__name__", ""),
)
def test_an_interval_of_95_percent_covers_that_at_the_number_of_scenes(
    statistic, draw, least, most
):
    """Simulated; a bootstrap of the same covers down to 82 %."""
    known, rng = statistic.value(truth(draw)), np.random.default_rng(0)

    @functools.cache  # of flags most trials draw as many as another one
    def ends(values):
        return interval(np.array(values), statistic)[1:]

    @functools.cache
    def alarm(values, side):
        bound = 0.8 if statistic is SHARE else known
        return p_value(np.array(values), statistic, bound, side) < 0.025

    drawn = (tuple(np.sort(draw(rng)).tolist()) for _ in range(3 * TRIALS))
    covered = [low <= known <= high for low, high in map(ends, islice(drawn, TRIALS))]
    assert least <= np.mean(covered)
    if most is not None:
        sides = TRIALS * ["greater"] + TRIALS * ["less"]
        alarms = [alarm(*each) for each in zip(drawn, sides, strict=True)]
        assert np.mean(alarms) <= most


def test_equal_trackers_are_seldom_called_different():
    rng = np.random.default_rng(0)
    same = [rng.permutation(np.repeat([1, 0, 0, -1], 8)) for _ in range(3)]
    assert p_value(same[0], PAIRS, 0, "greater") > 0.5
    drawn = (rng.choice([-1, 0, 1], SCENES) for _ in range(TRIALS))
    alarms = [p_value(values, PAIRS, 0, "greater") < 0.025 for values in drawn]
    assert np.mean(alarms) < 0.025


def test_runs_that_are_all_alike_leave_a_share_uncertain():
    assert interval(np.ones(8), SHARE)[1] == pytest.approx(0.631, abs=1e-3)
    assert p_value(np.ones(8), SHARE, 0.8, "greater") > 0.1
    _, low, high = interval(np.zeros(32), PAIRS)
    assert low < -0.05 and high > 0.05


def test_the_median_s_interval_ends_at_sorted_values():
    """The 10th and the 23rd of 32, from tables of the binomial distribution."""
    value, low, high = interval(np.arange(1, 33))
    assert (value, low, high) == (16.5, 10, 23)
    assert interval(np.arange(5))[1:] == (-np.inf, np.inf)


def test_nothing_proves_nothing():
    for statistic in (MEDIAN, MEAN, SHARE, PAIRS):
        assert np.isnan(interval([], statistic)).all()
        assert p_value([], statistic, 0, "greater") == 1


@pytest.mark.parametrize(
    "values, statistic, bound, side, said",
    [
        ([1, 0, 1], SHARE, 0.5, "two-sided", "side is 'two-sided'"),
        ([0.9, 0.9], SHARE, 0.5, "greater", "among (0, 1)"),
        ([2, 0, 1], PAIRS, 0, "less", "among (-1, 0, 1)"),
        ([1, 0, 1], PAIRS, 0.5, "less", "bound is 0.5"),
        ([1, 0], SHARE, 2, "greater", "bound is 2"),
        ([0.1, 0.2], MEAN, np.nan, "less", "bound is nan"),
    ],
)
def test_what_has_no_test_is_refused(values, statistic, bound, side, said):
    with pytest.raises(ValueError, match=re.escape(said)):
        p_value(values, statistic, bound, side)


@pytest.mark.parametrize("level", [-1, 0, 1, 2, np.nan])
def test_an_interval_holds_neither_nothing_nor_all(level):
    with pytest.raises(ValueError, match="level is .*; it must lie between 0 and 1"):
        interval([1.0, 2.0], MEDIAN, level)


@pytest.mark.parametrize("statistic, values", [(SHARE, [0.5]), (PAIRS, [-0.5, 1])])
def test_values_that_are_no_shares_have_no_interval(statistic, values):
    with pytest.raises(ValueError, match="one for each run"):
        interval(values, statistic)


def test_a_statistic_is_no_word():
    with pytest.raises(ValueError, match="statistic is of the type str; give MEDIAN"):
        interval([1.0, 2.0], "mean")


def test_a_difference_of_shares_is_at_most_1():
    assert interval([1], PAIRS)[2] == 1 and interval([-1], PAIRS)[1] == -1


def test_what_could_not_be_measured_proves_nothing():
    for statistic in (MEDIAN, MEAN):
        assert np.isnan(interval([1.0, np.nan, 2.0], statistic)).all()
        assert p_value([9.0, np.nan, 9.0], statistic, 1, "greater") == 1


@pytest.mark.parametrize("statistic", [MEDIAN, MEAN])
def test_one_run_proves_nothing(statistic):
    for side in ("greater", "less"):
        assert p_value([0.5], statistic, 0, side) > 0.4


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12))
def test_holm_raises_keeps_the_order_and_is_exact_for_the_smallest(p):
    raised = holm(p)
    assert (raised >= p).all() and (raised <= 1).all()
    assert (np.diff(raised[np.argsort(p)]) >= 0).all()
    assert raised.min() == pytest.approx(min(1, len(p) * min(p)))


@given(st.floats(0, 1), st.integers(1, 40))
def test_of_runs_all_alike_a_fraction_knows_how_many_may_be_otherwise(value, n):
    """If one of them were 0 or 1 more often than the ends say, it would be here."""
    _, low, high = interval(np.full(n, value), FRACTION)
    others = 1 - 0.025 ** (1 / n)  # Clopper and Pearson of none in n
    assert low == pytest.approx((1 - others) * value, abs=1e-9)
    assert high == pytest.approx(value + others * (1 - value), abs=1e-9)


def test_a_fraction_has_the_interval_of_a_mean_within_0_and_1():
    values = np.array([0.2, 0.5, 0.6, 0.4])
    assert interval(values, FRACTION) == interval(values, MEAN)
    beyond = [1.0, 1, 0.2, 1]
    assert interval(beyond, MEAN)[2] > 1 == interval(beyond, FRACTION)[2]
    with pytest.raises(ValueError, match="fraction must lie between 0 and 1"):
        interval([0.5, 1.1], FRACTION)


@pytest.mark.parametrize("p", [[0.1, np.nan], [[0.1]], [-0.1], [1.5]])
def test_holm_takes_a_row_of_probabilities(p):
    with pytest.raises(ValueError, match="p_values are .* from 0 to 1"):
        holm(p)


def test_holm_of_a_textbook():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])


def test_a_tie_is_not_beyond_the_bound_but_of_pairs_it_is_left_out():
    values = np.array([0, 0, 0, 1, 1, 1, 1, 1])
    for sign, side in ((1, "greater"), (-1, "less")):
        of_all = stats.binomtest(5, 8, alternative="greater").pvalue
        assert p_value(sign * values, MEDIAN, 0, side) == of_all
        of_five = stats.binomtest(5, 5, alternative="greater").pvalue
        assert p_value(sign * values, PAIRS, 0, side) == of_five


@given(
    st.lists(st.integers(-2, 2), min_size=1, max_size=40),
    st.sampled_from(["greater", "less"]),
)
def test_a_median_is_beyond_a_bound_only_where_its_interval_is(values, side):
    """Whatever is tied: the test and the interval are of the same two sorted values."""
    _, low, high = interval(values)
    beyond = low > 0 if side == "greater" else high < 0
    assert (p_value(values, MEDIAN, 0, side) <= 0.025) == beyond


def test_summaries_of_a_sweep_are_a_table_on_disk(tmp_path):
    overlaps = np.linspace(0.5, 0.9, 8)
    rows = pd.DataFrame(
        FAKE | {"tracker": name, "overlap": overlap, "lost": float(k < 2)}
        for name in ("a", "b")
        for k, overlap in enumerate(overlaps)
    )
    write_table(summaries(rows), tmp_path / "cells.csv")
    cells = pd.read_csv(tmp_path / "cells.csv")
    assert cells["tracker"].tolist() == ["a", "b"] and cells["runs"].tolist() == [8, 8]
    first = cells.iloc[0]
    assert first["overlap"] == pytest.approx(0.7) and first["lost"] == 0.25
    assert 0.5 <= first["overlap_low"] < 0.7 < first["overlap_high"] <= 0.9
    assert first["lost_low"] == pytest.approx(0.032, abs=1e-3)
    write_table(rows, tmp_path / "rows.csv")
    assert len((tmp_path / "rows.csv").read_text().splitlines()) == 17


def test_a_run_that_was_refused_is_counted_and_hides_no_other():
    good = [FAKE | {"tracker": "a"}] * 9
    refused = FAKE | dict.fromkeys(NUMBERS, np.nan) | {"tracker": "a", "refused": "no"}
    (line,) = summaries(pd.DataFrame([*good, refused])).to_dict("records")
    assert (line["runs"], line["refused"], line["overlap"]) == (10, 1, 0.5)


def test_a_table_that_is_read_back_says_the_same(tmp_path):
    """Also where no run was refused, of which a file has an empty column."""
    good = [FAKE | {"tracker": "a", "lost": 0.0}] * 3
    nothing = dict.fromkeys(NUMBERS, np.nan)
    no = FAKE | nothing | {"tracker": "b", "refused": "too dark"}
    for count, rows in enumerate((good, [*good, no])):
        before = pd.DataFrame(rows)
        write_table(before, tmp_path / "rows.csv")
        after = pd.read_csv(tmp_path / "rows.csv")
        pd.testing.assert_frame_equal(summaries(after), summaries(before))
        assert summaries(after)["refused"].sum() == count


@pytest.mark.parametrize("statistic", STATISTICS.values(), ids=list(STATISTICS))
def test_values_are_one_for_each_run(statistic):
    table = pd.DataFrame({"lost": [0.0, 1.0, 1.0]})
    assert interval(table["lost"], statistic)
    with pytest.raises(ValueError, match=r"the shape \(3, 1\); give one for each run"):
        interval(table, statistic)


def test_means_and_pairs_have_the_formulas_of_the_books():
    """Student's t, and Agresti and Min's interval, which adds two runs."""
    values = np.random.default_rng(0).normal(1, 1, 8)
    expected = stats.t.interval(0.95, 7, values.mean(), stats.sem(values))
    assert interval(values, MEAN)[1:] == pytest.approx(expected)
    gain = (8.5 - 2.5) / 22
    reach = stats.norm.ppf(0.975) * np.sqrt(11 - 22 * gain**2) / 22
    pairs = interval(np.repeat([1, -1, 0], [8, 2, 10]), PAIRS)
    assert pairs == pytest.approx((0.3, gain - reach, gain + reach))


@pytest.mark.parametrize(
    "statistic, values, bound",
    [
        (MEAN, np.random.default_rng(0).normal(1, 1, 8), 0),
        (MEDIAN, np.arange(1.0, 9), 0.5),
        (SHARE, np.ones(8), 0.5),
        (PAIRS, np.ones(8), 0),
    ],
)
def test_a_test_has_the_side_that_it_is_asked_for(statistic, values, bound):
    above = p_value(values, statistic, bound, "greater")
    assert above < 0.05 < p_value(values, statistic, bound, "less")


@pytest.mark.parametrize("bound", [0.5, 0.7, 0.9])
@pytest.mark.parametrize("values", [np.full(8, 0.7), [0.1 + 0.2, 0.3] * 8, np.ones(1)])
def test_of_runs_that_are_all_alike_but_for_rounding_a_mean_says_nothing(values, bound):
    """Where ten of ten are 0, one in four may still be something else."""
    assert p_value(values, MEAN, bound, "greater") == 1
    assert p_value(values, MEAN, bound, "less") == 1
    assert interval(values, MEAN)[1:] == (-np.inf, np.inf)
