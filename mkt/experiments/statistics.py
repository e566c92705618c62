"""How sure a number over runs is: exact intervals, tests, and summaries of many runs.

Five kinds of number, each with its interval and its test; the values are one for each
run, and runs are taken as independent of each other.  Scenes of one object are more
alike than those of two, so that an interval speaks for new paths of these objects:

* `MEDIAN` of any values: the interval ends at two of the sorted values, which covers
  the median whatever the distribution is; the sign test, in which a value that equals
  the bound speaks against what is claimed.
* `MEAN` of any values: Student's t, which goes by their spread.  Of values that are
  all alike it says nothing: how far off another one may lie is not to be seen in them.
* `FRACTION`, the mean of values from 0 to 1, such as overlaps and shares of frames:
  the same, within 0 and 1; and where all are alike, the interval of `SHARE` tells in
  how many runs it may still be otherwise, by all that there is.
* `SHARE` of the runs in which something is so, values 0 and 1: Clopper and Pearson's
  interval; the binomial test.
* `PAIRS`, the difference of two such shares over the same runs, values -1, 0 and 1: the
  interval of Agresti and Min (2005), which adds half a run to each of the four cells;
  McNemar's exact test.

A bootstrap of eight runs covers 90 %, not 95, and where eight runs of eight succeeded
it says 100 % for certain: that is why there is none here.  The tests simulate how
much the intervals here cover.

Explained in notebook 14.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import scipy

from mkt.checks import of_kind
from mkt.types import Array, ArrayLike, NDArray

SUMMARISED = (
    "overlap",
    "position",
    "orientation",
    "scale",
    "hits",
    "lost",
    "evaluations",
    "cpu_ms",
)
DUST = 1e-12  # of the values: what rounding alone makes of equal ones
SHARES = ("lost",)  # 0 or 1 for a run: the mean says more than the median


@dataclass(frozen=True)
class Statistic:
    """A kind of number over runs.

    Parameters
    ----------
    name : str
    value : callable
        Values (n,) -> the number.
    ends : callable
        Values (n,), level -> both ends of its interval.
    test : callable
        Values (n,), bound, "greater" or "less" -> p-value of the one-sided test of
        whether the number lies on that side of the bound.
    """

    name: str
    value: Callable[[Array], float]
    ends: Callable[[Array, float], tuple[float, float]]
    test: Callable[[Array, float, str], float]


def _median_ends(values: Array, level: float) -> tuple[float, float]:
    """Two of the sorted values; infinite where there are too few."""
    n = len(values)
    ordered = np.sort(values)
    k = int(scipy.stats.binom.ppf((1 - level) / 2, n, 0.5))
    return (ordered[k - 1], ordered[n - k]) if k else (-np.inf, np.inf)


def _sign_test(values: Array, bound: float, side: str) -> float:
    """Values that equal the bound are not beyond it, as for the interval's ends."""
    beyond = values > bound if side == "greater" else values < bound
    return _binomial(int(np.sum(beyond)), len(values), 0.5, "greater")


def _mcnemar_test(values: Array, bound: float, side: str) -> float:
    """Of the runs in which both are alike nothing is learnt: they are left out."""
    return _sign_test(values[values != bound], bound, side)


def _all_alike(values: Array) -> bool:
    """Whether values (n,) differ by no more than rounding does, or there is but one."""
    return bool(np.ptp(values) <= DUST * np.max(np.abs(values)))


def _mean_ends(values: Array, level: float) -> tuple[float, float]:
    if _all_alike(values):
        return -np.inf, np.inf
    mean, error = float(np.mean(values)), float(scipy.stats.sem(values))
    ends = scipy.stats.t.interval(level, len(values) - 1, mean, error)
    return float(ends[0]), float(ends[1])


def _fraction_ends(values: Array, level: float) -> tuple[float, float]:
    if not _all_alike(values):
        low, high = _mean_ends(values, level)
        return max(low, 0.0), min(high, 1.0)
    value = _mean(values)
    _, others = _share_ends(np.zeros(len(values)), level)
    return value - others * value, value + others * (1 - value)


def _t_test(values: Array, bound: float, side: str) -> float:
    if _all_alike(values):
        return 1.0
    return float(scipy.stats.ttest_1samp(values, bound, alternative=side).pvalue)


def _share_ends(values: Array, level: float) -> tuple[float, float]:
    test = scipy.stats.binomtest(int(np.sum(values)), len(values))
    ends = test.proportion_ci(level, method="exact")
    return float(ends.low), float(ends.high)


def _share_test(values: Array, bound: float, side: str) -> float:
    return _binomial(int(np.sum(values)), len(values), bound, side)


def _pairs_ends(values: Array, level: float) -> tuple[float, float]:
    n = len(values) + 2
    more, fewer = np.sum(values > 0) + 0.5, np.sum(values < 0) + 0.5
    gain = (more - fewer) / n
    error = np.sqrt(more + fewer - n * gain**2) / n
    reach = scipy.stats.norm.ppf((1 + level) / 2) * error
    return max(float(gain - reach), -1.0), min(float(gain + reach), 1.0)


def _binomial(k: int, n: int, p: float, side: str) -> float:
    """The p-value of k of n, 1 where there is nothing to count."""
    return float(scipy.stats.binomtest(k, n, p, alternative=side).pvalue) if n else 1.0


def _mean(values: Array) -> float:
    return float(np.mean(values))


#: The median, its exact interval, and the sign test.
#:
#: :meta hide-value:
MEDIAN = Statistic(
    "median", lambda values: float(np.median(values)), _median_ends, _sign_test
)
#: The mean, with Student's interval and test.
#:
#: :meta hide-value:
MEAN = Statistic("mean", _mean, _mean_ends, _t_test)
#: The mean of values from 0 to 1, with Student's interval and test.
#:
#: :meta hide-value:
FRACTION = Statistic("fraction", _mean, _fraction_ends, _t_test)
#: A share of yes or no, with an interval and a test of the binomial distribution.
#:
#: :meta hide-value:
SHARE = Statistic("share", _mean, _share_ends, _share_test)
#: The difference of two such shares over the same cases, with McNemar's test.
#:
#: :meta hide-value:
PAIRS = Statistic("difference of shares", _mean, _pairs_ends, _mcnemar_test)
STATISTICS = {one.name: one for one in (MEDIAN, MEAN, FRACTION, SHARE, PAIRS)}


def interval(
    values: ArrayLike, statistic: Statistic = MEDIAN, level: float = 0.95
) -> tuple[float, float, float]:
    """A number over runs and its interval.

    Parameters
    ----------
    values : (n,) array_like
    statistic : Statistic
        `MEDIAN`, `MEAN`, `FRACTION`, `SHARE` or `PAIRS`.
    level : float

    Returns
    -------
    value, low, high : float
        All are NaN where there is no value, or one that is not finite.

    Raises
    ------
    ValueError
        For values that are no row of numbers or that the statistic does not have, for
        another level, and for what is no `Statistic`.
    """
    values = _checked(values, statistic)
    if not 0 < level < 1:
        raise ValueError(f"level is {level}; it must lie between 0 and 1")
    if not (len(values) and np.isfinite(values).all()):
        return np.nan, np.nan, np.nan
    return statistic.value(values), *statistic.ends(values, level)


def _checked(values: ArrayLike, statistic: Statistic) -> Array:
    """The values as an array (n,); the exact tests of shares count whole runs."""
    kinds = "MEDIAN, MEAN, FRACTION, SHARE or PAIRS"
    of_kind(statistic, Statistic, "statistic", f"give {kinds}")
    values = np.asarray(values, float)
    if values.ndim != 1:
        raise ValueError(f"values have the shape {values.shape}; give one for each run")
    known = values[np.isfinite(values)]
    if statistic is FRACTION and not ((known >= 0) & (known <= 1)).all():
        raise ValueError("values of a fraction must lie between 0 and 1")
    possible = {SHARE: (0, 1), PAIRS: (-1, 0, 1)}.get(statistic)
    if possible and not np.isin(known, possible).all():
        raise ValueError(
            f"values of a {statistic.name} must be among {possible}, one for each run"
        )
    return values


def p_value(values: ArrayLike, statistic: Statistic, bound: float, side: str) -> float:
    """P-value of the one-sided test that a number lies beyond a bound.

    It is 1 where there is no value, or one that is not finite.

    Parameters
    ----------
    values : (n,) array_like
    statistic : Statistic
    bound : float
        0 for `PAIRS`.
    side : {"greater", "less"}

    Raises
    ------
    ValueError
        For another side, for a bound that is not finite, for values that are no row of
        numbers or that a statistic does not have, for `PAIRS` with another bound, and
        for `SHARE` with one that is no share.
    """
    if not np.isfinite(bound):
        raise ValueError(f"bound is {bound}; it must be a finite number")
    if side not in ("greater", "less"):
        raise ValueError(f'side is {side!r}; it must be "greater" or "less"')
    if statistic is PAIRS and bound != 0:
        raise ValueError(f"bound is {bound}; differences of shares are tested with 0")
    if statistic is SHARE and not 0 <= bound <= 1:
        raise ValueError(f"bound is {bound}; a share lies between 0 and 1")
    values = _checked(values, statistic)
    if not (len(values) and np.isfinite(values).all()):
        return 1.0
    return statistic.test(values, bound, side)


def holm(p_values: Sequence[float]) -> Array:
    """The p-values (m,) of tests that are made together, after Holm (1979).

    Each is raised so that the chance of even one false alarm among all of them stays
    below the level.

    Raises
    ------
    ValueError
        For what is no row of numbers from 0 to 1.
    """
    p = np.asarray(p_values, float)
    if p.ndim != 1 or not ((p >= 0) & (p <= 1)).all():
        raise ValueError(f"p_values are {p}; give a row of numbers from 0 to 1")
    order = np.argsort(p)
    raised = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    result = np.empty(len(p))
    result[order] = np.minimum(raised, 1)
    return result


def summaries(rows: pd.DataFrame) -> pd.DataFrame:
    """One line for each source and tracker: how many runs, and each number's interval.

    Parameters
    ----------
    rows : DataFrame
        Of `mkt.experiments.sweep.sweep`, or read from a file of them.

    Returns
    -------
    DataFrame
        Columns source, tracker, runs, refused (how many of the runs the tracker would
        not start), then each number of `SUMMARISED` over the others with its ends,
        such as overlap, overlap_low, overlap_high.  They are medians, but shares for
        numbers that are 0 or 1 in a run.
    """
    cells = rows.groupby(["source", "tracker"], sort=False)
    lines = [
        {"source": source, "tracker": tracker} | _summary(cell)
        for (source, tracker), cell in cells
    ]
    return pd.DataFrame(lines)


def refused(rows: pd.DataFrame) -> NDArray:
    """Which of the runs (n,) the tracker would not start.

    A file has nothing where a run was not refused, and pandas reads that as NaN.
    """
    return (rows["refused"].notna() & (rows["refused"] != "")).to_numpy()


def _summary(cell: pd.DataFrame) -> dict[str, float]:
    no = refused(cell)
    result = {"runs": len(cell), "refused": int(no.sum())}
    for name in SUMMARISED:
        statistic = SHARE if name in SHARES else MEDIAN
        value, low, high = interval(cell.loc[~no, name], statistic)
        result |= {name: value, f"{name}_low": low, f"{name}_high": high}
    return result
