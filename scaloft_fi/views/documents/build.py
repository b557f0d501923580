"""Parts of the JSON Schemas of YAML documents; each says what its value is, in which unit, and what is allowed.

Mappings are closed: they have the named keys and no others.  Bounds are those of the loaders, and a test holds them to
that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Schema = dict[str, Any]
"""A JSON Schema (draft 2020-12)."""


def text(about: str, *examples: str, pattern: str = "") -> Schema:
    """A text that is not empty; `pattern` is a regular expression that all of it matches."""
    limits = {"pattern": f"^(?:{pattern})$"} if pattern else {"minLength": 1}
    return {"type": "string", "description": about, **limits, **_examples(examples)}


def number(
    about: str,
    unit: str = "",
    *examples: float,
    least: float | None = None,
    above: float | None = None,
    most: float | None = None,
    default: float | None = None,
) -> Schema:
    """A number with `least` <= number <= `most` and number > `above`; `default` stands where it is left out."""
    return {"type": "number", **_about(about, unit), **_bounds(least, above, most), **_rest(default, examples)}


def whole(
    about: str, *examples: int, least: int | None = 0, most: int | None = None, default: int | None = None
) -> Schema:
    """A whole number with `least` <= number <= `most`."""
    return {"type": "integer", "description": about, **_bounds(least, None, most), **_rest(default, examples)}


def flag(about: str, *, default: bool | None = None) -> Schema:
    """True or false."""
    return {"type": "boolean", "description": about, **_rest(default, ())}


def choice(about: str, values: Sequence[str] | Mapping[str, str], *, default: str | None = None) -> Schema:
    """One of some texts; a mapping says what each means."""
    meanings = (
        "".join(f"\n- {value}: {meaning}" for value, meaning in values.items()) if isinstance(values, Mapping) else ""
    )
    return {"enum": list(map(str, values)), "description": about + meanings, **_rest(default, ())}


def fixed(value: str | bool | int, about: str) -> Schema:
    """Exactly this value."""
    return {"const": value, "description": about}


def anything(about: str) -> Schema:
    """A value whose form something else decides."""
    return {"description": about}


def listed(
    about: str, each: Schema, *, least: int = 0, most: int | None = None, examples: Sequence[Any] = ()
) -> Schema:
    """A list of `least` to `most` values."""
    limits = {"minItems": least} if least else {}
    if most is not None:
        limits["maxItems"] = most
    return {"type": "array", "description": about, "items": each, **limits, **_examples(examples)}


def numbers(about: str, count: int, unit: str = "", *examples: Sequence[float], **bounds: float) -> Schema:
    """A list of `count` numbers, each within `least` and `most`."""
    each: Schema = {"type": "number", **_bounds(bounds.get("least"), None, bounds.get("most"))}
    limits = {"minItems": count, "maxItems": count}
    return {"type": "array", **_about(about, unit), "items": each, **limits, **_examples(examples)}


def mapping(about: str, needed: Mapping[str, Schema], optional: Mapping[str, Schema] | None = None) -> Schema:
    """A mapping with these keys, of which the optional ones may be left out."""
    return {
        "type": "object",
        "description": about,
        "properties": {**needed, **(optional or {})},
        "required": list(needed),
        "additionalProperties": False,
    }


def named(about: str, each: Schema, *, pattern: str = "", least: int = 0, most: int | None = None) -> Schema:
    """A mapping whose keys are names of the study; `pattern` is a regular expression that all of a name matches."""
    limits: Schema = {"minProperties": least} if least else {}
    if most is not None:
        limits["maxProperties"] = most
    if pattern:
        names = {"patternProperties": {f"^(?:{pattern})$": each}, "additionalProperties": False}
    else:
        names = {"additionalProperties": each}
    return {"type": "object", "description": about, **names, **limits}


def either(about: str, *alternatives: Schema) -> Schema:
    """One of some forms; where they are mappings, a key with a fixed value tells which."""
    return {"description": about, "oneOf": list(alternatives)}


def _about(about: str, unit: str) -> Schema:
    return {"description": f"{about} [{unit}]" if unit else about}


def _bounds(least: float | None, above: float | None, most: float | None) -> Schema:
    bounds = {"minimum": least, "exclusiveMinimum": above, "maximum": most}
    return {name: _plain(bound) for name, bound in bounds.items() if bound is not None}


def _plain(bound: float) -> float | int:
    return int(bound) if bound == int(bound) else bound


def _rest(default: Any, examples: Sequence[Any]) -> Schema:
    return {**({} if default is None else {"default": default}), **_examples(examples)}


def _examples(examples: Sequence[Any]) -> Schema:
    return {"examples": [list(one) if isinstance(one, tuple) else one for one in examples]} if examples else {}
