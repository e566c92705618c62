"""What tests of figures ask: the numbers that one shows."""

from mkt.figures.registry import FIGURES


def numbers(name, **parameters):
    """What a figure shows with some parameters."""
    return FIGURES[name].draw(**parameters)[1]
