"""Rows of numbers: how many there may be, and what is said of others."""

import pytest

from mkt.files import DataError
from mkt.sequences.rows import read_rows


def test_a_first_row_of_another_width_needs_the_fewest_numbers(tmp_path):
    (tmp_path / "a.txt").write_text("1,2,3\n1,2,3,4\n")
    with pytest.raises(DataError, match="line 1: 3 numbers, but 4 are needed"):
        read_rows(tmp_path / "a.txt", (4, 8))
