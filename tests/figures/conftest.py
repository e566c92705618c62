"""Figures that are registered for one test and forgotten after it."""

import pytest

from mkt.figures.registry import FIGURES


@pytest.fixture(autouse=True)
def forgotten(monkeypatch):
    """What a test registers is gone when it ends."""
    assert len(FIGURES)  # all of the book's are there before
    monkeypatch.setattr(FIGURES, "_entries", dict(FIGURES._entries))
