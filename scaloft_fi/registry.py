"""A mapping of declared things by unique name: refuses duplicates, answers a miss with the nearest name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from importlib.metadata import entry_points
from typing import Generic, TypeVar

from scaloft_fi.errors import InputError, did_you_mean

T = TypeVar("T")

PLUGIN_GROUP = "scaloft_fi.plugins"


class Registry(Mapping[str, T], Generic[T]):
    """Entries by unique name, in the order they were declared.

    >>> colours = Registry[int]("colour")
    >>> colours.declare("red", 1)
    >>> colours["rad"]
    Traceback (most recent call last):
    scaloft_fi.errors.InputError: no colour 'rad'; did you mean 'red'?
    """

    def __init__(self, noun: str) -> None:
        self.noun = noun
        self._entries: dict[str, T] = {}
        self._promised: dict[str, str] = {}

    def declare(self, name: str, entry: T) -> None:
        """Add `entry` under `name`.

        Raises:
            ValueError: the name is taken.
        """
        self._refuse_taken(name)
        self._entries[name] = entry

    def promise(self, name: str, place: str) -> None:
        """Add the entry that stands at `place`, `module:attribute`, without importing it before it is asked for.

        Raises:
            ValueError: the name is taken.
        """
        self._refuse_taken(name)
        self._promised[name] = place

    def __getitem__(self, name: str) -> T:
        if name in self._promised:
            module, _, attribute = self._promised.pop(name).partition(":")
            self._entries[name] = getattr(import_module(module), attribute)
        try:
            return self._entries[name]
        except KeyError:
            raise InputError(f"no {self.noun} {name!r}{did_you_mean(name, list(self))}") from None

    def __contains__(self, name: object) -> bool:
        return name in self._entries or name in self._promised

    def __iter__(self) -> Iterator[str]:
        return iter((*self._promised, *self._entries))

    def __len__(self) -> int:
        return len(self._entries) + len(self._promised)

    def _refuse_taken(self, name: str) -> None:
        if name in self:
            raise ValueError(f"{self.noun} {name!r} is declared twice")


def load_plugins() -> None:
    """Import every module that an installed package names in the entry-point group `scaloft_fi.plugins`.

    Raises:
        InputError: a plugin cannot be imported, or declares a name that is taken; it names plugin and package.
    """
    for entry_point in entry_points(group=PLUGIN_GROUP):
        try:
            entry_point.load()
        except Exception as error:
            package = entry_point.dist.name if entry_point.dist else entry_point.module
            reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
            raise InputError(
                f"plugin {entry_point.name!r} of package {package!r} cannot be loaded: {reason}; mend or uninstall it"
            ) from error
