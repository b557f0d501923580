"""Builds the settings of a stack from plain data: nested frozen dataclasses and named tuples from mappings.

An unknown, missing or mistyped setting is refused, and so is a number outside its `Bounds`.  A field with a default may
be left out; a field of type `Mapping[str, X]` takes a mapping of any keys.
"""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Mapping
from typing import Annotated, Any, TypeVar, get_origin, get_type_hints

C = TypeVar("C")
Number = TypeVar("Number", int, float)


@dataclasses.dataclass(frozen=True)
class Bounds:
    """Allowed numbers of a setting, `least` <= number <= `most`: `Annotated[float, Bounds(least=0.0)]`."""

    least: float = -1e9
    most: float = 1e9


Scalar = str | int | float | bool
Positive = Annotated[float, Bounds(least=1e-6)]
NotNegative = Annotated[float, Bounds(least=0.0)]
Count = Annotated[int, Bounds(least=1, most=1_000)]


class ConfigError(ValueError):
    """A setting is unknown, missing or of the wrong type; `path` says which."""

    def __init__(self, path: str, complaint: str) -> None:
        super().__init__(f"{path}: {complaint}")
        self.path = path
        self.complaint = complaint


def build(cls: type[C], data: Mapping[str, Any], path: str = "stack") -> C:
    """Build the dataclass or named tuple `cls` from `data`, field by field.

    Raises:
        ConfigError: naming the setting, what is wrong with it, and the nearest known name.
    """
    hints = get_type_hints(cls, include_extras=True)
    names, optional = _names(cls)
    for key in data:
        if key not in names:
            near = difflib.get_close_matches(key, names, n=1)
            raise ConfigError(f"{path}.{key}", "unknown setting" + (f"; did you mean {near[0]!r}?" if near else ""))
    values = {}
    for name in names:
        if name in data:
            values[name] = _convert(hints[name], data[name], f"{path}.{name}")
        elif name not in optional:
            raise ConfigError(path, f"lacks the setting {name!r}")
    return cls(**values)


def _names(cls: type) -> tuple[list[str], set[str]]:
    """The fields of a dataclass or named tuple, and those of them that have a default."""
    if hasattr(cls, "_fields"):
        return list(cls._fields), set(getattr(cls, "_field_defaults", ()))
    fields = dataclasses.fields(cls)
    missing = dataclasses.MISSING
    have = {field.name for field in fields if field.default is not missing or field.default_factory is not missing}
    return [field.name for field in fields], have


def _convert(hint: Any, value: Any, path: str) -> Any:
    marks = getattr(hint, "__metadata__", ())
    hint = hint.__origin__ if marks else hint
    if dataclasses.is_dataclass(hint) or hasattr(hint, "_fields"):
        if not isinstance(value, Mapping):
            raise ConfigError(path, "must be a mapping of settings")
        return build(hint, value, path)
    if get_origin(hint) is Mapping:
        if not isinstance(value, Mapping):
            raise ConfigError(path, "must be a mapping")
        return {key: _convert(hint.__args__[1], entry, f"{path}.{key}") for key, entry in value.items()}
    if hint == Scalar:
        if not isinstance(value, str | int | float | bool):
            raise ConfigError(path, "must be a text, a number, true or false")
        return value
    if hint is float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ConfigError(path, f"{value!r} must be a number")
        return float(_bounded(value, marks, path))
    if hint is int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise ConfigError(path, f"{value!r} must be a whole number")
        return _bounded(value, marks, path)
    if hint is Any:
        return value
    if hint is str or hint is bool:
        if not isinstance(value, hint):
            raise ConfigError(path, f"{value!r} must be {'a text' if hint is str else 'true or false'}")
        return value
    if not isinstance(value, list | tuple):
        raise ConfigError(path, f"{value!r} must be a list")
    inner = hint.__args__
    if inner[-1] is Ellipsis:
        inner = inner[:1] * len(value)
    if len(inner) != len(value):
        raise ConfigError(path, f"must be a list of {len(inner)}")
    return tuple(_convert(inner[i], entry, f"{path}[{i}]") for i, entry in enumerate(value))


def _bounded(value: Number, marks: tuple[Any, ...], path: str) -> Number:
    bounds = next((mark for mark in marks if isinstance(mark, Bounds)), Bounds())
    if not bounds.least <= value <= bounds.most:
        raise ConfigError(path, f"{value!r} must be a number from {bounds.least:g} to {bounds.most:g}")
    return value
