"""Plain values as items of a document, and what a model reads from them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

from scaloft_fi.document import Item
from scaloft_fi.model import read

T = TypeVar("T")


def item_of(value: Any, name: str = "entry", file: str = "s.yaml") -> Item:
    """The item of a plain value, all of it on line 1."""
    if isinstance(value, dict):
        value = {key: item_of(one, key, file) for key, one in value.items()}
    elif isinstance(value, list | tuple):
        value = tuple(item_of(one, f"{name}[{place}]", file) for place, one in enumerate(value))
    return Item(Path(file), 1, name, value)


def build(cls: type[T], values: dict[str, Any]) -> T:
    """The model that is read from plain values."""
    return read(cls, item_of(values, "stack"))
