"""Things that are known by name: figures, claims, scenes, trackers.

A `Registry` is a mapping from names to entries.  What registers itself with a decorator
is found by importing all modules of a package the first time that somebody asks, so
there is no list of modules to keep.
"""

import importlib
import pkgutil
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from threading import RLock
from typing import Any, ClassVar


class Registry(Mapping):
    """A mapping {name: entry} that says which names it knows.

    It refuses a name that is taken.  Asked for one that it does not have it lists its
    names, or says what lists them.

    Parameters
    ----------
    kind : str
        What the entries are, in a word, for the messages.
    package : str, optional
        Package whose modules register the entries, imported when first needed.
    order : callable, optional
        Key by which the names are sorted; without it they stay in the order in which
        they were registered.
    listing : str, optional
        A command that lists the names, for a message in which they would be too many.
    """

    # Packages of which a module was stopped half-way, by an error or Ctrl-C: imported
    # once more, it registers again what it had registered, and in any registry.
    _stopped: ClassVar[set[str]] = set()

    def __init__(
        self,
        kind: str,
        package: str | None = None,
        order: Callable[[str], Any] | None = None,
        listing: str = "",
    ):
        self.kind, self._package, self._order = kind, package, order
        self._listing = listing
        self._entries: dict[str, Any] = {}
        self._importing = RLock()

    def add(self, name: str, entry: Any) -> None:
        """Register an entry; ValueError for a name that is taken or no text.

        What was written in a notebook, or in a program itself, can be written again.
        """
        if not isinstance(name, str):
            raise ValueError(f"{self.kind} {name!r}: a name is a text")
        again = _home(self._entries.get(name)) == _home(entry) == "__main__"
        if name in self._entries and not (again or Registry._stopped):
            raise ValueError(f"{self.kind} {name}: registered twice")
        self._entries[name] = entry

    def register(self, name: str) -> Callable[[Any], Any]:
        """Decorator: register a function or class under a name, as it is."""

        def entered(entry):
            self.add(name, entry)
            return entry

        return entered

    def __getitem__(self, name: str) -> Any:
        self._discover()
        if not isinstance(name, str) or name not in self._entries:
            raise UnknownName(self.kind, str(name), list(self), self._listing)
        return self._entries[name]

    def __iter__(self) -> Iterator[str]:
        self._discover()
        return iter(
            sorted(self._entries, key=self._order) if self._order else self._entries
        )

    def __len__(self) -> int:
        self._discover()
        return len(self._entries)

    def _discover(self) -> None:
        # Another thread waits for all names; a module in the package may ask for some.
        with self._importing:
            package, self._package = self._package, None
            if package:
                try:
                    import_all(package)
                except BaseException:
                    self._package = package  # not all were imported
                    Registry._stopped.add(package)
                    raise
                Registry._stopped.discard(package)


def _home(entry: Any) -> str | None:
    """The name of the module in which a function, a class or that of a thing is."""
    return getattr(entry, "__module__", None)


class UnknownName(KeyError, ValueError):  # KeyError is what a Mapping raises
    """A name that a registry does not have; the message lists similar ones and all.

    Parameters
    ----------
    kind, name : str
    known : list of str
        All names that there are.
    listing : str, optional
        A command that lists them; the message has it in their place.
    """

    def __init__(self, kind: str, name: str, known: list[str], listing: str = ""):
        super().__init__(kind, name, known, listing)

    def __str__(self) -> str:
        kind, name, known, listing = self.args
        similar = [other for other in known if other.endswith(f".{name}")]
        similar = similar or get_close_matches(name, known)
        hint = f", perhaps {' or '.join(similar)}" if similar else ""
        every = f"`{listing}` lists all" if listing else f"there are {', '.join(known)}"
        return f"no {kind} {name!r}{hint}; {every}"


def import_all(package: str) -> None:
    """Import every module of a package and of its sub-packages."""
    folder = importlib.import_module(package).__path__
    for module in pkgutil.walk_packages(folder, f"{package}."):
        importlib.import_module(module.name)


def by_group(groups: Sequence[str], sign: str) -> Callable[[str], tuple]:
    """Sort key of names that begin with a group and a sign, the groups in this order.

    Names of no group come last.
    """

    def key(name: str) -> tuple:
        group = name.partition(sign)[0]
        return groups.index(group) if group in groups else len(groups), natural(name)

    return key


def natural(name: str) -> list:
    """Sort key by which fig2 comes before fig10.

    >>> sorted(["fig10", "fig2"], key=natural)
    ['fig2', 'fig10']
    """
    parts = re.split(r"(\d+)", name)
    return [(0, int(part), "") if part.isdecimal() else (1, 0, part) for part in parts]
