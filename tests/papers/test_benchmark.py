"""The figures of the chapter on benchmarks: a table's fractions, success curves."""

from fractions import Fraction

import numpy as np
import pytest

from mkt.papers.cordoba2014.printed import OVERALL, TABLE
from mkt.papers.lessons import benchmark
from mkt.papers.lessons.benchmark import counts
from mkt.plotting import new_figure
from mkt.trackers import by_name
from tests.papers.drawing import numbers


def test_table_1_as_printed_gives_away_its_lengths():
    """Truncated, not rounded; three rows fit a BoBoT sequence but for a row or two.

    And one mean is wrong.
    """
    rows = {row: numbers("own.table_forensics", row=row) for row in TABLE}
    assert 627 in rows["clutter"]["n"] and 452 in rows["pillars"]["n"]
    assert list(rows["trajectory"]["n"]) == [601]
    possible = rows["clutter"]["possible"]
    incomplete = [name for name in possible if not all(possible[name])]
    assert incomplete == ["passers", "scale"]
    rounded = numbers("own.table_forensics", rounding="rounded")["possible"]
    assert not any(all(row) for row in rounded.values())
    means, printed = rows["scale"]["means"], [float(p) for p in OVERALL]
    agree = [
        int(100 * mean + 1e-6) == round(100 * p)
        for mean, p in zip(means, printed, strict=True)
    ]
    assert agree == [False, True, True]


@pytest.mark.parametrize("n", [1, 7, 452, 627, 1016])
def test_every_fraction_is_found_and_no_other(n):
    for k in range(n + 1):
        hundredths = Fraction(10000 * k, n)
        rounded = int(hundredths + Fraction(1, 2))
        assert k in counts(f"{int(hundredths) / 100:.2f}", n)
        assert k in counts(f"{rounded / 100:.2f}", n, "rounded")
    impossible = set(range(10001)) - {10000 * k // n for k in range(n + 1)}
    assert not any(counts(f"{p / 100:.2f}", n) for p in sorted(impossible)[::37])


def test_a_half_is_rounded_up():
    """1 of 32 is 3.125 %."""
    assert counts("3.13", 32, "rounded") == [1]
    assert counts("3.12", 32, "rounded") == []


def test_of_a_long_film_all_fractions_are_found():
    assert counts("50.00", 50_000) == [25_000, 25_001, 25_002, 25_003, 25_004]
    assert counts("50.00", 50_000, "rounded") == list(range(24_998, 25_003))


@pytest.mark.parametrize(
    "given, what",
    [
        (("97.6", 627), "percent is '97.6'; give two decimals"),
        (("976", 627), "percent is '976'; give two decimals"),
        ((97.6, 627), "percent is 97.6; give two decimals in a text"),
        (("97.60", 0), "n is 0; it must be a whole number, at least 1"),
        (("97.60", 627, "ceil"), "rounding is 'ceil'; it must be one of truncated"),
    ],
)
def test_percentages_and_roundings_of_another_kind_are_refused(given, what):
    with pytest.raises(ValueError, match=what):
        counts(*given)


@pytest.mark.slow
def test_the_success_figure_shows_what_the_runs_give():
    low = numbers("own.success", scene="look-alike", limit=0.2)
    high = numbers("own.success", scene="look-alike", limit=0.7)
    quick = by_name.quick()
    assert list(low["names"]) == quick
    assert (low["seen"] >= high["seen"]).all() and (low["all"] <= low["seen"]).all()
    curves = low["curves"]
    assert low["area"] == pytest.approx(curves.mean(1))
    assert (np.diff(curves) <= 0).all()
    assert curves[:, 4] == pytest.approx(low["seen"])  # 4 / 20 is the limit


def test_plain_bars_are_of_seen_frames_and_hatched_ones_of_all():
    ax, names = new_figure((5, 4)).subplots(), ["ssd", "wm"]
    shares = np.array([[0.9, 0.5], [0.6, 0.3], [0.7, 0.4]])
    benchmark._draw_ranking(ax, names, *shares)
    bars = [[bar.get_width() for bar in group] for group in ax.containers]
    assert np.array(bars) == pytest.approx(np.array([[50, 90], [30, 60]]))
