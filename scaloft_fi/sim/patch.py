"""Replace single values of YAML documents by dotted path, or add entries; a new value keeps its own place."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError, did_you_mean

PARTS = ("world", "vehicle", "sensors")
"""The documents that an axis may change."""


def qualified(path: str, value: Item) -> str:
    """The path with the name of its document in front; a path without one is a path of the world.

    Raises:
        InputError: the path belongs to the stack under test.
    """
    head = path.partition(".")[0]
    if head == "stack":
        sentence = f"{path!r} belongs to the stack under test; an axis may change {', '.join(PARTS)}"
        raise InputError(f"{value.place}: {sentence}")
    return path if head in PARTS else f"world.{path}"


def patched(documents: Mapping[str, Item], changes: Mapping[str, Item]) -> dict[str, Item]:
    """Replace values of documents by dotted paths such as `sensors.depth.latency_s`, each with its document's name.

    An entry of a list is addressed by its index.

    Raises:
        InputError: there is no such path; the message begins with the place of the value.
    """
    new = dict(documents)
    for path, value in changes.items():
        name, _, rest = path.partition(".")
        changed = _replaced(new[name], rest.split("."), value) if name in new and rest else None
        if changed is None:
            known = [f"{name}.{inner}" for name, document in documents.items() for inner, _ in leaves(document)]
            raise InputError(f"{value.place}: no path {path!r} in the study{did_you_mean(path, known)}")
        new[name] = changed
    return new


def found(documents: Mapping[str, Item], path: str) -> Item | None:
    """The value at a dotted path with its document's name; None where there is none."""
    name, _, rest = path.partition(".")
    if name not in documents:
        return None
    return next((item for inner, item in leaves(documents[name]) if inner == rest), None)


def overlap(first: str, second: str) -> bool:
    """Whether two paths are one, or one is a part of the other."""
    return f"{first}.".startswith(f"{second}.") or f"{second}.".startswith(f"{first}.")


def _replaced(item: Item, parts: Sequence[str], value: Item) -> Item | None:
    if not parts:
        return Item(value.path, value.line, item.name, value.value)
    if isinstance(item.value, dict):
        # A key may contain dots; the longest matching key wins.
        for length in range(len(parts), 0, -1):
            key = ".".join(parts[:length])
            if key in item.value:
                inner = _replaced(item.value[key], parts[length:], value)
                return inner and Item(item.path, item.line, item.name, {**item.value, key: inner})
    if isinstance(item.value, tuple) and parts[0].isdigit() and int(parts[0]) < len(item.value):
        number = int(parts[0])
        inner = _replaced(item.value[number], parts[1:], value)
        return inner and Item(item.path, item.line, item.name, (*item.value[:number], inner, *item.value[number + 1 :]))
    return None


def leaves(item: Item, path: str = "") -> Iterator[tuple[str, Item]]:
    """Yield the dotted path and the item of every scalar in a document."""
    if isinstance(item.value, dict):
        for key, entry in item.value.items():
            yield from leaves(entry, f"{path}.{key}" if path else key)
    elif isinstance(item.value, tuple):
        for number, entry in enumerate(item.value):
            yield from leaves(entry, f"{path}.{number}" if path else str(number))
    else:
        yield path, item


def added(documents: Mapping[str, Item], additions: Item) -> dict[str, Item]:
    """The documents with the entries of `additions`, a mapping of `patch.PARTS` to entries; each keeps its own place.

    Raises:
        InputError: an entry belongs to another document, or exists already.
    """
    new = dict(documents)
    for name, entries in additions.mapping().items():
        if name not in PARTS:
            raise InputError(f"{entries.place}: no document {name!r} to add to{did_you_mean(name, PARTS)}")
        new[name] = _joined(new[name], entries, name)
    return new


def _joined(item: Item, more: Item, path: str) -> Item:
    entries = dict(item.mapping())
    for key, entry in more.mapping().items():
        inner = f"{path}.{key}"
        if key not in entries:
            entries[key] = entry
        elif isinstance(entries[key].value, dict) and isinstance(entry.value, dict):
            entries[key] = _joined(entries[key], entry, inner)
        else:
            raise InputError(f"{entry.place}: {inner} exists already; an axis changes it with `set`")
    return Item(item.path, item.line, item.name, entries)
