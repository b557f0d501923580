"""YAML documents that keep the place of each value; an error names file, line, key and the nearest valid key."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from scaloft_fi.errors import InputError, did_you_mean

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
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
        shown = (
            "{...}" if isinstance(self.value, dict) else "[...]" if isinstance(self.value, tuple) else repr(self.value)
        )
        return InputError(f"{self.place}: {self.name}={shown} must be {allowed}")

    def mapping(self) -> dict[str, Item]:
        """The entries of a mapping, by key."""
        if not isinstance(self.value, dict):
            raise self.error("a mapping of keys to values")
        return self.value

    def items(self) -> tuple[Item, ...]:
        """The entries of a list."""
        if not isinstance(self.value, tuple):
            raise self.error("a list")
        return self.value

    def __iter__(self) -> Iterator[Item]:
        return iter(self.items())

    def text(self) -> str:
        """A non-empty string."""
        if not isinstance(self.value, str) or not self.value.strip():
            raise self.error("a text")
        return " ".join(self.value.split())

    def number(self, *, least: float = -math.inf, most: float = math.inf, above: float = -math.inf) -> float:
        """A finite number within `least` <= value <= `most` and value > `above`."""
        if isinstance(self.value, bool) or not isinstance(self.value, int | float) or math.isnan(self.value):
            raise self.error("a number")
        if not (least <= self.value <= most and self.value > above):
            bounds = {f">= {least:g}": least, f"> {above:g}": above, f"<= {most:g}": most}
            raise self.error(" and ".join(text for text, bound in bounds.items() if math.isfinite(bound)))
        return float(self.value)

    def whole(self, *, least: int = 0) -> int:
        """A whole number >= `least`."""
        if isinstance(self.value, bool) or not isinstance(self.value, int) or self.value < least:
            raise self.error(f"a whole number >= {least}")
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
            raise InputError(f"{self.place}: {self.name}={self.value!r} is not known{hint}")
        return str(self.value)

    def numbers(self, count: int | None = None) -> tuple[float, ...]:
        """A list of numbers, `count` of them when given."""
        values = tuple(item.number() for item in self.items())
        if count is not None and len(values) != count:
            raise self.error(f"a list of {count} numbers")
        return values

    def plain(self) -> Any:
        """The bare Python value: dicts, lists and scalars."""
        if isinstance(self.value, dict):
            return {key: item.plain() for key, item in self.value.items()}
        if isinstance(self.value, tuple):
            return [item.plain() for item in self.value]
        return self.value

    def get(self, key: str) -> Item | None:
        """The entry of a mapping under `key`, or None; from now on the key counts as known."""
        self._taken.add(key)
        return self.mapping().get(key)

    def need(self, key: str) -> Item:
        """The entry of a mapping under `key`.

        Raises:
            InputError: there is none.
        """
        entry = self.get(key)
        if entry is None:
            entries = self.mapping()
            for near in difflib.get_close_matches(key, sorted(entries.keys() - self._taken), n=1, cutoff=0.75):
                raise InputError(f"{entries[near].place}: unknown key {near!r} in {self.name}; did you mean {key!r}?")
            raise InputError(f"{self.place}: {self.name} lacks the key {key!r}")
        return entry

    def close(self) -> None:
        """Refuse unknown keys: the keys that no call of `get` or `need` has read.

        Raises:
            InputError: a key is unknown; the message names the first unknown key and the nearest known key.
        """
        for key, item in self.mapping().items():
            if key not in self._taken:
                raise InputError(f"{item.place}: unknown key {key!r} in {self.name}{did_you_mean(key, self._taken)}")


def load(path: Path) -> Item:
    """Read one YAML file with the safe loader.

    Raises:
        InputError: the file cannot be read, is not YAML, or repeats a key.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
        raise InputError(f"{path}: cannot be read: {reason}") from error
    loader = _LOADER(text)
    try:
        node = loader.get_single_node()
        if node is None:
            raise InputError(f"{path}:1: the file is empty")
        return _item(loader, node, path, path.name)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        line = mark.line + 1 if mark else 1
        raise InputError(f"{path}:{line}: not valid YAML: {error.problem}") from error
    except yaml.YAMLError as error:
        raise InputError(f"{path}:1: not valid YAML: {' '.join(str(error).split())}") from error
    finally:
        loader.dispose()


def _item(loader: Any, node: yaml.Node, path: Path, name: str, key_line: int = 0, inside: tuple[int, ...] = ()) -> Item:
    """The item of a node; the place of a mapping or list under a key is the place of the key."""
    if id(node) in inside:
        raise InputError(f"{path}:{node.start_mark.line + 1}: {name} contains itself")
    inside = (*inside, id(node))
    line = key_line or node.start_mark.line + 1
    if isinstance(node, yaml.MappingNode):
        entries: dict[str, Item] = {}
        for key_node, value_node in node.value:
            place = key_node.start_mark.line + 1
            if not isinstance(key_node, yaml.ScalarNode):
                raise InputError(f"{path}:{place}: a key of {name} must be a single word")
            # Keys are the text of the node, because YAML would read a bare NO as false.
            key = key_node.value
            if key in entries:
                raise InputError(f"{path}:{place}: key {key!r} occurs twice in {name}")
            entries[key] = _item(loader, value_node, path, key, place, inside)
        return Item(path, line, name, entries)
    if isinstance(node, yaml.SequenceNode):
        items = (_item(loader, entry, path, f"{name}[{i}]", 0, inside) for i, entry in enumerate(node.value))
        return Item(path, line, name, tuple(items))
    try:
        value = loader.construct_object(node)
    except ValueError as error:  # a value that looks like a date but is none
        raise InputError(f"{path}:{node.start_mark.line + 1}: {name}={node.value!r} cannot be read: {error}") from error
    if value is not None and not isinstance(value, str | int | float | bool):
        value = str(getattr(node, "value", value))
    return Item(path, node.start_mark.line + 1, name, value)
