"""The keys of a JSON Schema."""

from __future__ import annotations

from collections.abc import Iterator

from scaloft_fi.model import Schema

Pointer = tuple[str | int, ...]


def keys_of(schema: Schema | bool, pointer: Pointer = ()) -> Iterator[Pointer]:
    """The pointer of every key of a schema."""
    if isinstance(schema, bool):
        return
    for key, one in schema.get("properties", {}).items():
        yield (*pointer, "properties", key)
        yield from keys_of(one, (*pointer, "properties", key))
    for pattern, one in schema.get("patternProperties", {}).items():
        yield from keys_of(one, (*pointer, "patternProperties", pattern))
    for word in ("additionalProperties", "items", "then"):
        if isinstance(schema.get(word), dict):
            yield from keys_of(schema[word], (*pointer, word))
    for word in ("oneOf", "anyOf", "allOf"):
        for place, one in enumerate(schema.get(word, ())):
            yield from keys_of(one, (*pointer, word, place))
