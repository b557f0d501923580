"""Add new entries to the documents of a study, for a grid that needs bodies or happenings of its own."""

from __future__ import annotations

from collections.abc import Mapping

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.sim.patch import PARTS


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
