"""What students wrote as Python reads it, whatever it is."""

import ast

LONGEST = 10_000  # [letters] that are read, each for half a kilobyte of memory


def parsed(source: str) -> ast.Module:
    """A cell as Python reads it; empty where it cannot, which others say."""
    try:
        return ast.parse(source)
    # The last two are what Python says of what is nested too deep.
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        return ast.Module([], [])
