"""Reads YAML documents into items that keep their places, within limits that hold before memory is used."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from scaloft_fi.errors import InputError, shown
from scaloft_fi.item import ITEMS, Item, Scalar
from scaloft_fi.reading import read_text

DEPTH = 50
"""Deepest nesting of a document."""
DIGITS = 100
"""Most characters of a number."""
KEY = 200
"""Most characters of a key."""
KEPT = 1 << 16
"""Documents of at most so many characters are parsed once for as long as they are used."""

_TOO_DEEP = f"the file must be nested at most {DEPTH} deep"
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_TEXT = "tag:yaml.org,2002:str"
_NUMBERS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")


def load(path: Path) -> Item:
    """Read one YAML file.

    Raises:
        InputError: the file cannot be read, is not YAML, repeats a key, has a tag, or exceeds a limit.
    """
    text = read_text(path)
    read = _parsed_once if len(text) <= KEPT else _parsed
    try:
        return _placed(read(text, path.name), path)
    except _FlawError as flaw:
        raise InputError(f"{path}:{flaw.line}: {flaw}") from flaw


class _FlawError(Exception):
    """What is wrong with a document, at a line."""

    def __init__(self, line: int, sentence: str) -> None:
        super().__init__(sentence)
        self.line = line


def _parsed(text: str, name: str) -> Item:
    """The item of a document, in no folder yet.

    Args:
        text: the document.
        name: its file's name.

    Raises:
        _FlawError: the document is not YAML, or not of the kind that `load` allows.
    """
    loader = _LOADER(text)
    try:
        return _Document(loader, name).item()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        line = mark.line + 1 if mark else 1
        if error.problem and "nesting depth" in error.problem:  # libyaml has a limit too, and reads ahead of its events
            raise _FlawError(line, _TOO_DEEP) from error
        raise _FlawError(line, f"not valid YAML: {error.problem}") from error
    except yaml.YAMLError as error:
        raise _FlawError(1, f"not valid YAML: {' '.join(str(error).split())}") from error
    finally:
        loader.dispose()


_parsed_once = lru_cache(maxsize=128)(_parsed)


def _placed(item: Item, path: Path) -> Item:
    """The item at a path; a copy, because an item notes which of its keys are known."""

    def copy(item: Item) -> Item:
        value = item.value
        if isinstance(value, dict):
            value = {key: copy(entry) for key, entry in value.items()}
        elif isinstance(value, tuple):
            value = tuple([copy(entry) for entry in value])
        return Item(path, item.line, item.name, value)

    return copy(item)


class _Document:
    """Builds the items of one document from the events of the parser, so that every limit holds before memory is used.

    Aliases are allowed: an alias stands for a copy of the anchored value, and the copies count against `ITEMS`.
    """

    def __init__(self, loader: Any, name: str) -> None:
        self._loader = loader
        self._path = Path(name)
        self._left = ITEMS
        self._anchors: dict[str, Item | None] = {}
        """The value of each anchor; None while the value is being read."""

    def item(self) -> Item:
        """The one value of the document."""
        next_event = self._loader.get_event
        next_event()  # the start of the stream
        if isinstance(next_event(), yaml.StreamEndEvent):
            raise _FlawError(1, "the file is empty")
        item = self._read(next_event(), self._path.name, 0, 0)
        next_event()  # the end of the document
        if not isinstance(event := next_event(), yaml.StreamEndEvent):
            raise self._error(event, "a second document must stand in a file of its own")
        return item

    def _read(self, event: Any, name: str, key_line: int, depth: int) -> Item:
        """The item that begins with `event`; the place of a mapping or list under a key is the place of the key."""
        line = _line(event)
        self._count(event, depth)
        if isinstance(event, yaml.AliasEvent):
            if event.anchor not in self._anchors:
                raise self._error(event, f"alias {shown(event.anchor)} has no anchor above it")
            anchored = self._anchors[event.anchor]
            if anchored is None:
                raise self._error(event, f"{name} contains itself")
            return self._copy(event, anchored, name, key_line, depth)
        if event.tag is not None:
            raise self._error(event, f"{name} has the tag {shown(event.tag)}; write the value without a tag")
        if event.anchor is not None:
            self._anchors[event.anchor] = None
        if isinstance(event, yaml.ScalarEvent):
            item = Item(self._path, line, name, self._scalar(event, name))
        else:
            inner = self._entries if isinstance(event, yaml.MappingStartEvent) else self._list
            item = Item(self._path, key_line or line, name, inner(name, depth + 1))
        if event.anchor is not None:
            self._anchors[event.anchor] = item
        return item

    def _entries(self, name: str, depth: int) -> dict[str, Item]:
        entries: dict[str, Item] = {}
        next_event: Any = self._loader.get_event
        while not isinstance(event := next_event(), yaml.MappingEndEvent):
            if not isinstance(event, yaml.ScalarEvent) or event.tag is not None:
                raise self._error(event, f"a key of {name} must be a single word")
            # Keys are the text of the event, because YAML would read a bare NO as false.
            key: str = event.value
            if len(key) > KEY:
                raise self._error(event, f"key {shown(key)} must have at most {KEY} characters")
            if key in entries:
                raise self._error(event, f"key {key!r} occurs twice in {name}")
            entries[key] = self._read(next_event(), key, _line(event), depth)
        return entries

    def _list(self, name: str, depth: int) -> tuple[Item, ...]:
        items: list[Item] = []
        while not isinstance(event := self._loader.get_event(), yaml.SequenceEndEvent):
            items.append(self._read(event, f"{name}[{len(items)}]", 0, depth))
        return tuple(items)

    def _scalar(self, event: Any, name: str) -> Scalar:
        text: str = event.value
        tag = self._loader.resolve(yaml.ScalarNode, text, event.implicit)
        if tag == _TEXT:
            return text
        if tag in _NUMBERS and len(text) > DIGITS:
            raise self._error(event, f"{name}={shown(text)} must have at most {DIGITS} digits")
        try:
            value = self._loader.construct_object(yaml.ScalarNode(tag, text, event.start_mark, event.end_mark))
        except ValueError as error:  # a value that looks like a date but is none
            raise self._error(event, f"{name}={shown(text)} cannot be read: {error}") from error
        return value if value is None or isinstance(value, int | float) else text

    def _copy(self, event: Any, item: Item, name: str, key_line: int, depth: int) -> Item:
        """A copy of an anchored item under another name, which knows no key yet."""
        if isinstance(item.value, dict):
            entries = {key: self._again(event, entry, key, depth) for key, entry in item.value.items()}
            return Item(item.path, key_line or item.line, name, entries)
        if isinstance(item.value, tuple):
            items = (self._again(event, entry, f"{name}[{i}]", depth) for i, entry in enumerate(item.value))
            return Item(item.path, key_line or item.line, name, tuple(items))
        return Item(item.path, item.line, name, item.value)

    def _again(self, event: Any, entry: Item, name: str, depth: int) -> Item:
        self._count(event, depth + 1)
        return self._copy(event, entry, name, 0, depth + 1)

    def _count(self, event: Any, depth: int) -> None:
        self._left -= 1
        if self._left < 0:
            raise self._error(event, f"the file must have at most {ITEMS:,} values, those that aliases repeat included")
        if depth > DEPTH:
            raise self._error(event, _TOO_DEEP)

    def _error(self, event: Any, sentence: str) -> _FlawError:
        return _FlawError(_line(event), sentence)


def _line(event: Any) -> int:
    line: int = event.start_mark.line + 1
    return line
