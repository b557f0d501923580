"""A mapping of declared things by unique name: refuses duplicates, answers a miss with the nearest name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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

    def declare(self, name: str, entry: T) -> None:
        """Add `entry` under `name`.

        Raises:
            ValueError: the name is taken.
        """
        if name in self._entries:
            raise ValueError(f"{self.noun} {name!r} is declared twice")
        self._entries[name] = entry

    def __getitem__(self, name: str) -> T:
        try:
            return self._entries[name]
        except KeyError:
            raise InputError(f"no {self.noun} {name!r}{did_you_mean(name, self._entries)}") from None

    def __contains__(self, name: object) -> bool:
        return name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)


def load_plugins() -> None:
    """Import every module that an installed package names in the entry-point group `scaloft_fi.plugins`."""
    for entry_point in entry_points(group=PLUGIN_GROUP):
        entry_point.load()
