"""The JSON Schema of an entry, found out by its own reader: a stand-in answers whatever the reader asks, and notes it.

A reader that depends on more than one kind of answer shows only what it asks of the stand-in's.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scaloft_fi.document import LARGEST, Item
from scaloft_fi.views.documents.build import Schema


@dataclass
class Notes:
    """What was asked of a stand-in.

    Attributes:
        schema: as a schema without descriptions.
        keys: the stand-in of each key that was asked for.
        needed: the keys without which the reader does not go on.
        each: the stand-in of each entry of a list; None where no list was asked for.
    """

    schema: Schema = field(default_factory=dict)
    keys: dict[str, Probe] = field(default_factory=dict)
    needed: set[str] = field(default_factory=set)
    each: Probe | None = None


class Probe(Item):
    """Stands for a value of YAML that is not there: it answers with the least value that is allowed."""

    notes: Notes

    def __init__(self, name: str) -> None:
        super().__init__(Path("probe"), 0, name, {})
        object.__setattr__(self, "notes", Notes())  # items are frozen

    def get(self, key: str) -> Item | None:
        """Answer with an entry, which is optional."""
        return self.notes.keys.setdefault(key, Probe(key))

    def need(self, key: str, meaning: str = "") -> Item:
        """Answer with an entry, which is needed."""
        self.notes.needed.add(key)
        return self.notes.keys.setdefault(key, Probe(key))

    def close(self) -> None:
        """Refuse nothing."""

    def mapping(self, *, most: int = 0) -> dict[str, Item]:
        """Answer with no entries."""
        self.notes.schema.setdefault("type", "object")
        return {}

    def items(self, *, most: int = 0) -> tuple[Item, ...]:
        """Answer with one entry."""
        self.notes.schema["type"] = "array"
        self.notes.each = Probe(f"{self.name}[0]")
        return (self.notes.each,)

    def __iter__(self) -> Iterator[Item]:
        return iter(self.items())

    def text(self) -> str:
        """Answer with a text."""
        self.notes.schema.update({"type": "string", "minLength": 1})
        return "text"

    def number(
        self, *, least: float = -LARGEST, most: float = LARGEST, above: float = -math.inf, infinite: bool = False
    ) -> float:
        """Answer with the least number that is allowed, or 0."""
        bounds = {"minimum": least, "maximum": most, "exclusiveMinimum": above}
        told = {name: bound for name, bound in bounds.items() if abs(bound) < LARGEST}
        self.notes.schema.update({"type": "number", **told})
        return max(least, above + 1e-9) if "minimum" in told or "exclusiveMinimum" in told else min(0.0, most)

    def whole(self, *, least: int = 0, most: int = int(LARGEST)) -> int:
        """Answer with the least number that is allowed."""
        self.notes.schema.update({"type": "integer", "minimum": least, **({"maximum": most} if most < LARGEST else {})})
        return least

    def flag(self) -> bool:
        """Answer with true."""
        self.notes.schema.update({"type": "boolean"})
        return True

    def choice(self, allowed: Sequence[str]) -> str:
        """Answer with the first choice."""
        self.notes.schema.update({"enum": [str(one) for one in allowed]})
        return str(allowed[0])

    def numbers(self, count: int | None = None, *, least: float = -LARGEST, most: float = LARGEST) -> tuple[float, ...]:
        """Answer with numbers of the least value that is allowed, or 0."""
        each = Probe(self.name)
        value = each.number(least=least, most=most)
        size = {"minItems": count, "maxItems": count} if count is not None else {}
        self.notes.schema.update({"type": "array", "items": each.notes.schema, **size})
        return (value,) * (count if count is not None else 1)

    def plain(self) -> Any:
        """Answer with nothing."""
        return {}


def probed(read: Callable[[Item], Any], about: str, texts: Mapping[str, str], *, closed: bool) -> Schema:
    """The schema of the mapping that a function reads.

    Args:
        read: the function.
        about: what the mapping is.
        texts: what each key is.
        closed: whether no other keys are allowed; not where the reader may ask for more of other values.
    """
    probe = Probe("entry")
    try:
        read(probe)
    except Exception:  # noqa: BLE001 - the reader of a plugin may not take what stands in
        closed = False
    return _schema(probe, about, texts, closed=closed)


def _schema(probe: Probe, about: str, texts: Mapping[str, str], *, closed: bool) -> Schema:
    notes = probe.notes
    schema = dict(notes.schema)
    if notes.each is not None:
        schema["items"] = _schema(notes.each, "", texts, closed=closed)
    if notes.keys:
        told = {key: texts.get(key, key.replace("_", " ")) for key in notes.keys}
        keys = {key: _schema(entry, told[key], texts, closed=closed) for key, entry in notes.keys.items()}
        schema |= {"type": "object", "properties": keys, "required": [key for key in keys if key in notes.needed]}
        schema |= {"additionalProperties": False} if closed else {}
    return ({"description": about} if about else {}) | schema
