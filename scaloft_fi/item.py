"""A value of a YAML document with its place; an error names file, line, key and the nearest valid key."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scaloft_fi.errors import InputError, did_you_mean, shown

LARGEST = 1e9
"""Largest number of a setting that states no bounds of its own."""
ITEMS = 30_000
"""Most values of a document, those that an alias repeats included."""
MOST = 1_000
"""Most entries of a list or mapping of which each entry costs time or memory in every flight."""

Scalar = str | int | float | bool | None


@dataclass(frozen=True)
class Item:
    """One YAML value with its place.  `value` is a scalar, a tuple of items, or a mapping of items by key."""

    path: Path
    line: int
    name: str
    value: Scalar | tuple[Item, ...] | dict[str, Item]
    _taken: set[str] = field(default_factory=set, compare=False, repr=False)

    @property
    def place(self) -> str:
        """`file:line`, the beginning of every error message."""
        return f"{self.path}:{self.line}"

    def error(self, allowed: str) -> InputError:
        """The error for a value that is not allowed here."""
        value = "{...}" if isinstance(self.value, dict) else "[...]" if isinstance(self.value, tuple) else None
        return InputError(f"{self.place}: {self.name}={value or shown(self.value)} must be {allowed}")

    def mapping(self, *, most: int = ITEMS) -> dict[str, Item]:
        """The entries of a mapping by key, at most `most` of them."""
        if not isinstance(self.value, dict):
            raise self.error("a mapping of keys to values")
        if len(self.value) > most:
            raise self.error(f"a mapping of at most {most:,} keys")
        return self.value

    def items(self, *, most: int = ITEMS) -> tuple[Item, ...]:
        """The entries of a list, at most `most` of them."""
        if not isinstance(self.value, tuple):
            raise self.error("a list")
        if len(self.value) > most:
            raise self.error(f"a list of at most {most:,} values")
        return self.value

    def __iter__(self) -> Iterator[Item]:
        return iter(self.items())

    def text(self) -> str:
        """A non-empty string."""
        if not isinstance(self.value, str) or not self.value.strip():
            raise self.error("a text")
        return " ".join(self.value.split())

    def number(
        self, *, least: float = -LARGEST, most: float = LARGEST, above: float = -math.inf, infinite: bool = False
    ) -> float:
        """A number within `least` <= value <= `most` and value > `above`; `infinite` allows the infinities too."""
        if isinstance(self.value, bool) or not isinstance(self.value, int | float) or math.isnan(self.value):
            raise self.error("a number")
        if math.isinf(self.value):
            if infinite:
                return self.value
            raise self.error("a finite number")
        if not (least <= self.value <= most and self.value > above):
            lowest = (f"> {above:g}", above) if above >= least else (f">= {least:g}", least)
            beyond = abs(self.value) > LARGEST
            told = [text for text, bound in (lowest, (f"<= {most:g}", most)) if beyond or abs(bound) < LARGEST]
            raise self.error(" and ".join(told))
        return float(self.value)

    def whole(self, *, least: int = 0, most: int = int(LARGEST)) -> int:
        """A whole number within `least` <= value <= `most`."""
        if isinstance(self.value, bool) or not isinstance(self.value, int) or not least <= self.value <= most:
            within = f" and <= {most}" if isinstance(self.value, int) and self.value > most else ""
            raise self.error(f"a whole number >= {least}{within}")
        return self.value

    def flag(self) -> bool:
        """Either true or false."""
        if not isinstance(self.value, bool):
            raise self.error("true or false")
        return self.value

    def choice(self, allowed: Sequence[str]) -> str:
        """One of `allowed`."""
        if str(self.value) not in allowed:
            hint = did_you_mean(str(self.value), allowed)
            raise InputError(f"{self.place}: {self.name}={shown(self.value)} is not known{hint}")
        return str(self.value)

    def numbers(self, count: int | None = None, *, least: float = -LARGEST, most: float = LARGEST) -> tuple[float, ...]:
        """A list of numbers within `least` <= value <= `most`, `count` of them when given."""
        values = tuple(item.number(least=least, most=most) for item in self.items())
        if count is not None and len(values) != count:
            raise self.error(f"a list of {count} numbers")
        return values

    def plain(self) -> Any:
        """The bare Python value: dicts, lists and scalars.

        Raises:
            InputError: a number is not finite.
        """
        if isinstance(self.value, dict):
            return {key: item.plain() for key, item in self.value.items()}
        if isinstance(self.value, tuple):
            return [item.plain() for item in self.value]
        if isinstance(self.value, float) and not math.isfinite(self.value):
            raise self.error("a finite number")
        return self.value

    def get(self, key: str) -> Item | None:
        """The entry of a mapping under `key`, or None; from now on the key counts as known."""
        self._taken.add(key)
        return self.mapping().get(key)

    def need(self, key: str, meaning: str = "") -> Item:
        """The entry of a mapping under `key`.

        Args:
            key: the key.
            meaning: what it is to hold, for those who left it out.

        Raises:
            InputError: there is none.
        """
        entry = self.get(key)
        if entry is None:
            entries = self.mapping()
            for near in difflib.get_close_matches(key, sorted(entries.keys() - self._taken)[:MOST], n=1, cutoff=0.75):
                raise InputError(f"{entries[near].place}: unknown key {near!r} in {self.name}; did you mean {key!r}?")
            raise InputError(f"{self.place}: {self.name} lacks the key {key!r}{f': {meaning}' if meaning else ''}")
        return entry

    def close(self) -> None:
        """Refuse unknown keys: the keys that no call of `get` or `need` has read.

        Raises:
            InputError: a key is unknown; the message names the first unknown key and the nearest known key.
        """
        for key, item in self.mapping().items():
            if key not in self._taken:
                raise InputError(f"{item.place}: unknown key {key!r} in {self.name}{did_you_mean(key, self._taken)}")
