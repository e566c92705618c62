"""Intervals that cover what they should, and summaries that add up."""

import numpy as np
import pandas as pd
import pytest

from mkt.experiments.statistics import interval, summaries
from mkt.experiments.sweep import write_table

FAKE = {
    "source": "base",
    "overlap": 0.5,
    "position": 1.0,
    "orientation": 2.0,
    "scale": 0.1,
    "hits": 1.0,
    "evaluations": 9.0,
    "cpu_ms": 3.0,
}


def test_the_interval_of_a_median_covers_it():
    rng = np.random.default_rng(0)
    intervals = [interval(rng.normal(0, 1, 40)) for _ in range(100)]
    covered = sum(low <= 0 <= high for _, low, high in intervals)
    assert 85 <= covered <= 100
    assert np.isnan(interval([1.0, np.nan, 2.0])).all()
    assert interval([2.0, 2.0, 2.0]) == (2, 2, 2)


def test_summaries_of_a_sweep_are_a_table_on_disk(tmp_path):
    values = ((0.5, 0), (0.6, 0), (0.9, 0), (0.8, 1))
    rows = pd.DataFrame(
        FAKE | {"tracker": name, "overlap": overlap, "lost": lost}
        for name in ("a", "b")
        for overlap, lost in values
    )
    write_table(summaries(rows), tmp_path / "cells.csv")
    cells = pd.read_csv(tmp_path / "cells.csv")
    assert cells["tracker"].tolist() == ["a", "b"] and cells["runs"].tolist() == [4, 4]
    first = cells.iloc[0]
    assert first["overlap"] == pytest.approx(0.7) and first["lost"] == 0.25
    assert 0.5 <= first["overlap_low"] < 0.7 < first["overlap_high"] <= 0.9
    write_table(rows, tmp_path / "rows.csv")
    assert len((tmp_path / "rows.csv").read_text().splitlines()) == 9
