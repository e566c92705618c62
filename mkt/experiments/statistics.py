"""How sure a number over runs is: bootstrap intervals, and summaries of many runs."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from scipy import stats

from mkt.types import ArrayLike

DRAWS = 2000
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
SHARES = ("lost", "failed")  # 0 or 1 for a run: their mean says more than their median


def interval(
    values: ArrayLike, level: float = 0.95, statistic: Callable = np.median
) -> tuple[float, float, float]:
    """A statistic of values and its bootstrap interval.

    Parameters
    ----------
    values : (n,) array_like
    level : float
    statistic : callable
        Such as `numpy.median`, with an `axis`.

    Returns
    -------
    value, low, high : float
        All NaN where a value is.
    """
    values = np.asarray(values, float)
    value = float(statistic(values))
    if not np.isfinite(values).all():
        return np.nan, np.nan, np.nan
    if np.ptp(values) == 0:
        return value, value, value
    result = stats.bootstrap(
        (values,),
        statistic,
        n_resamples=DRAWS,
        confidence_level=level,
        method="percentile",
        rng=np.random.default_rng(0),
    )
    low, high = result.confidence_interval
    return value, float(low), float(high)


def summaries(rows: pd.DataFrame) -> pd.DataFrame:
    """One line for each source and tracker: how many runs, and each number's interval.

    Parameters
    ----------
    rows : DataFrame
        Of `mkt.experiments.sweep.sweep`.

    Returns
    -------
    DataFrame
        Columns source, tracker, runs, then each number of `SUMMARISED` with its ends,
        such as overlap, overlap_low, overlap_high.  Medians, but means of the shares of
        runs that were lost.
    """
    cells = rows.groupby(["source", "tracker"], sort=False)
    lines = [
        {"source": source, "tracker": tracker, "runs": len(cell)} | _summary(cell)
        for (source, tracker), cell in cells
    ]
    return pd.DataFrame(lines)


def _summary(cell: pd.DataFrame) -> dict[str, float]:
    result = {}
    for name in SUMMARISED:
        statistic = np.mean if name in SHARES else np.median
        value, low, high = interval(cell[name].to_numpy(), statistic=statistic)
        result |= {name: value, f"{name}_low": low, f"{name}_high": high}
    return result
