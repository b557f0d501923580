"""The shapes of JSON values, as parts of a JSON Schema (draft 2020-12); each says what its value is and in which unit.

A record is closed: it has each of its keys, and no others.  What may be missing is null (`optional`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

Shape = Mapping[str, Any]
"""A JSON Schema."""


def text(about: str, one_of: Iterable[str] = ()) -> Shape:
    """A text; `one_of` lists all values that it can have."""
    allowed = [str(value) for value in one_of]
    return {"type": "string", "description": about, **({"enum": allowed} if allowed else {})}


def number(about: str, unit: str = "") -> Shape:
    """A finite number; the unit stands behind what it is: `time [s]`."""
    return {"type": "number", "description": f"{about} [{unit}]" if unit else about}


def count(about: str) -> Shape:
    """A whole number from 0."""
    return {"type": "integer", "minimum": 0, "description": about}


def flag(about: str) -> Shape:
    """True or false."""
    return {"type": "boolean", "description": about}


def anything(about: str) -> Shape:
    """A value whose shape somebody else decides, such as an argument of an operator."""
    return {"description": about}


def optional(shape: Shape, missing: str = "") -> Shape:
    """The value, or null; `missing` says what null means where the name does not."""
    about = f"{shape['description']}; null: {missing}" if missing else shape["description"]
    return {"anyOf": [{**shape, "description": about}, {"type": "null"}], "description": about}


def record(about: str, keys: Mapping[str, Shape]) -> Shape:
    """An object with exactly these keys."""
    return {
        "type": "object",
        "description": about,
        "properties": dict(keys),
        "required": list(keys),
        "additionalProperties": False,
    }


def listing(about: str, each: Shape) -> Shape:
    """A list of values of one shape."""
    return {"type": "array", "description": about, "items": each}


def by_name(about: str, each: Shape) -> Shape:
    """An object whose keys are names of the study, such as requirements, with values of one shape."""
    return {"type": "object", "description": about, "additionalProperties": each}


def ratio(about: str) -> Shape:
    """`part` of `whole`; 0 of 0 is no share."""
    return record(about, {"part": count("how many of them"), "whole": count("how many there are")})


def texts(about: str) -> Shape:
    """A list of texts."""
    return listing(about, {"type": "string"})


def inner(shape: Shape) -> Shape:
    """The shape of a value that is not null."""
    alternatives = shape.get("anyOf")
    return alternatives[0] if alternatives else shape
