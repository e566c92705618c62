"""Work in several processes, by joblib."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any


def spread(
    function: Callable[..., Any],
    arguments: Iterable[tuple[Any, ...]],
    processes: int = -1,
    *,
    in_order: bool = True,
) -> Iterator[Any]:
    """What a function returns for each tuple of arguments, as it comes.

    Parameters
    ----------
    function : callable
    arguments : iterable of tuple
    processes : int
        At once; -1 for as many as there are cores.
    in_order : bool
        Whether a result waits for those of the tuples before.

    Yields
    ------
    object
    """
    # Not above: it sets a variable of the environment when it is imported.
    from joblib import Parallel, delayed

    kind = "generator" if in_order else "generator_unordered"
    calls = (delayed(function)(*each) for each in arguments)
    yield from Parallel(n_jobs=processes, return_as=kind)(calls)
