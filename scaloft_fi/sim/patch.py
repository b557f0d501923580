"""Replace single values of a YAML document by dotted path; the new value keeps its own place."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError, did_you_mean


def patched(item: Item, path: str, value: Item) -> Item:
    """Replace the value at dotted `path` of a document; an entry of a list is addressed by its index.

    Raises:
        InputError: there is no such path; the message begins with the place of `value`.
    """
    changed = _replaced(item, path.split("."), value)
    if changed is None:
        raise InputError(f"{value.place}: no path {path!r} in {item.path.name}{did_you_mean(path, dict(leaves(item)))}")
    return changed


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


def overridden(documents: Mapping[str, Item], overrides: Mapping[str, float | str | bool]) -> dict[str, Item]:
    """Replace single values of documents; a path such as `sensors.depth.latency_s` begins with the document's name.

    Raises:
        InputError: there is no such path.
    """
    changed = dict(documents)
    for path, value in overrides.items():
        name, _, rest = path.partition(".")
        place = Item(Path("overrides"), 1, path, value)
        if name not in changed or not rest:
            raise InputError(f"overrides: no document for {path!r}{did_you_mean(name, changed)}")
        changed[name] = patched(changed[name], rest, place)
    return changed
