"""What the loaders ask of the YAML documents of a study, compared with the JSON Schemas of these documents."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path, PurePath
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from scaloft_fi import document
from scaloft_fi.document import LARGEST, Item
from scaloft_fi.verbs.documents.listed import DOCUMENTS
from scaloft_fi.verbs.documents.schema import Schema

Path_ = tuple[str | int, ...]
Pointer = tuple[str | int, ...]


@dataclass(frozen=True)
class Question:
    """What a loader asks of a value.

    Attributes:
        file: file of the document.
        path: keys and indices from its root to the value.
        how: name of the method of `Item`.
        what: its arguments.
    """

    file: str
    path: Path_
    how: str
    what: tuple[Any, ...]


@dataclass
class Asked:
    """Every question, and every document in which one was asked, as plain values by file."""

    questions: set[Question] = field(default_factory=set)
    documents: dict[str, Any] = field(default_factory=dict)
    places: dict[tuple[str, int, str], Path_] = field(default_factory=dict)

    def register(self, item: Item, path: Path_ = ()) -> Any:
        """Remember where an item and all below it stand; returns its plain value."""
        self.places.setdefault((str(item.path), item.line, item.name), path)
        if isinstance(item.value, dict):
            return {key: self.register(entry, (*path, key)) for key, entry in item.value.items()}
        if isinstance(item.value, tuple):
            return [self.register(entry, (*path, place)) for place, entry in enumerate(item.value)]
        return item.value

    def ask(self, item: Item, how: str, *what: Any) -> None:
        """Note a question."""
        path = self.places.get((str(item.path), item.line, item.name))
        if path is not None:
            self.questions.add(Question(str(item.path), path, how, what))


@contextmanager
def asking() -> Iterator[Asked]:
    """Note what loaders ask of every document that is loaded meanwhile."""
    asked = Asked()
    with pytest.MonkeyPatch.context() as patch:
        whole = document._placed

        def placed(item: Item, path: Path) -> Item:
            found = whole(item, path)
            asked.documents[str(path)] = asked.register(found)
            return found

        patch.setattr(document, "_placed", placed)
        for how, note in NOTES.items():
            patch.setattr(Item, how, _noting(asked, how, getattr(Item, how), note))
        yield asked


def _noting(asked: Asked, how: str, original: Any, note: Any) -> Any:
    def called(self: Item, *words: Any, **named: Any) -> Any:
        asked.ask(self, how, *note(*words, **named))
        return original(self, *words, **named)

    return called


NOTES: Mapping[str, Any] = {
    "get": lambda key: (key,),
    "text": lambda: (),
    "flag": lambda: (),
    "number": lambda *, least=-LARGEST, most=LARGEST, above=-math.inf, **_: (least, most, above),
    "whole": lambda *, least=0, most=int(LARGEST): (least, most),
    "choice": lambda allowed: (tuple(map(str, allowed)),),
    "items": lambda *, most=0: (most,),
    "mapping": lambda *, most=0: (most,),
}
"""The methods of `Item` that ask, and what is noted of their arguments."""


def document_of(file: str) -> str:
    """The name of the document that a file is; "" for none."""
    fits = [name for name, one in DOCUMENTS.items() if PurePath(file).match(one.files)]
    return fits[0] if fits else ""


class Located:
    """Where the values of one document stand in its schema.

    Args:
        schema: the schema.
        instance: the document as plain values.
    """

    def __init__(self, schema: Schema, instance: Any) -> None:
        self._schema, self._instance = schema, instance
        self._valid: dict[tuple[int, int], bool] = {}
        self._found: dict[tuple[Path_, bool], tuple[Any, list[tuple[Pointer, Schema]]]] = {}

    def at(self, path: Path_, *, every: bool = False) -> list[tuple[Pointer, Schema]]:
        """The parts of the schema for a value; `every` alternative, or those that its document has taken."""
        return self._at(path, every)[1]

    def _at(self, path: Path_, every: bool) -> tuple[Any, list[tuple[Pointer, Schema]]]:
        """The value, and the parts of the schema for it."""
        if (path, every) not in self._found:
            value, nodes = self._instance, [((), self._schema)]
            if path:
                outer, above = self._at(path[:-1], every)
                value, nodes = outer[path[-1]], [found for node in above for found in _below(node, path[-1])]
            spread = [found for node in nodes for found in self._spread(node, value, every)]
            self._found[path, every] = value, spread
        return self._found[path, every]

    def _spread(self, node: tuple[Pointer, Schema], instance: Any, every: bool) -> Iterator[tuple[Pointer, Schema]]:
        pointer, schema = node
        yield node
        for word in ("oneOf", "anyOf", "allOf"):
            for place, one in enumerate(schema.get(word, ())):
                if every or word == "allOf" or self._fits(one, instance):
                    yield from self._spread(((*pointer, word, place), one), instance, every)
        if "then" in schema and (every or self._fits(schema["if"], instance)):
            yield from self._spread(((*pointer, "then"), schema["then"]), instance, every)

    def _fits(self, schema: Schema, instance: Any) -> bool:
        key = (id(schema), id(instance))
        if key not in self._valid:
            self._valid[key] = Draft202012Validator(schema).is_valid(instance)
        return self._valid[key]


def _below(node: tuple[Pointer, Schema], key: str | int) -> Iterator[tuple[Pointer, Schema]]:
    pointer, schema = node
    if isinstance(key, int):
        if "items" in schema:
            yield (*pointer, "items"), schema["items"]
        return
    if key in schema.get("properties", {}):
        yield (*pointer, "properties", key), schema["properties"][key]
        return
    for pattern, each in schema.get("patternProperties", {}).items():
        if re.search(pattern, key):
            yield (*pointer, "patternProperties", pattern), each
    if isinstance(schema.get("additionalProperties"), dict):
        yield (*pointer, "additionalProperties"), schema["additionalProperties"]


def keys_of(schema: Schema, pointer: Pointer = ()) -> Iterator[Pointer]:
    """The pointer of every key of a schema."""
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
