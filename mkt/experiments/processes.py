"""Work in several processes, by joblib."""

import copy
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Any

from mkt.checks import MOST, is_whole
from mkt.experiments.dependencies import own_scenes
from mkt.scenes import SCENES

SENT: dict[str, Any] = {}  # the user's own scenes, as the last work brought them


def spread(
    function: Callable[..., Any],
    arguments: Iterable[tuple[Any, ...]],
    processes: int = -1,
    *,
    in_order: bool = True,
) -> Iterator[Any]:
    """What a function returns for each tuple of arguments, as it comes.

    The processes know the scenes of the user's own that are registered here.

    Parameters
    ----------
    function : callable
    arguments : iterable of tuple
    processes : int
        At once; -1 for as many as there are cores, -2 for one less, and so on.
    in_order : bool
        Whether a result waits for those of the tuples before.

    Yields
    ------
    object

    Raises
    ------
    ValueError
        For another number of processes.
    """
    if not is_whole(processes, -MOST) or processes == 0:
        raise ValueError(
            f"processes is {processes!r}; give how many at once, or -1 for as many as "
            "there are cores"
        )
    # Not above: it sets a variable of the environment when it is imported.
    from joblib import Parallel, delayed

    kind = "generator" if in_order else "generator_unordered"
    own = own_scenes()
    calls = (delayed(_called)(own, function, *each) for each in arguments)
    yield from Parallel(n_jobs=processes, return_as=kind)(calls)


def _called(
    own: Mapping[str, Any], function: Callable[..., Any], *arguments: Any
) -> Any:
    """What a function returns, in a process that may never have run the user's file.

    An error that could not be put together again where it arrives, which breaks all
    processes, comes as a RuntimeError of its words.
    """
    SENT.update(own)
    for name in own:
        if name not in SCENES:
            SCENES.add(name, partial(_sent, name))
    try:
        return function(*arguments)
    except Exception as error:
        if _can_be_sent(error):
            raise
        raise RuntimeError(f"{type(error).__name__}: {error}") from error


def _sent(name: str, *words: Any, **more: Any) -> Any:
    """A scene of the user's own; an earlier program may have sent another one."""
    return SENT[name](*words, **more)


def _can_be_sent(error: Exception) -> bool:
    """Whether it is put together from its arguments, as a copy is too."""
    try:
        copy.copy(error)
    except Exception:  # whatever its class raises
        return False
    return True
