"""The JSON Schema of settings that a frozen dataclass declares, as `stack.config.build` reads them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, get_args, get_origin, get_type_hints

from scaloft_fi.stack.config import Bounds, Scalar
from scaloft_fi.views.documents.build import Schema, mapping
from scaloft_fi.views.documents.docstrings import attributes_of, summary_of

NOT_TOLD = Bounds()
"""The bounds of a number that states none."""
Instead = Mapping[str, Schema]
"""Schemas by name of a field, which stand in place of what its type says."""


def settings_schema(cls: type, *, about: str = "", instead: Instead | None = None) -> Schema:
    """The schema of a mapping with the fields of a dataclass or named tuple.

    Args:
        cls: the class; its docstring says what each field is.
        about: what the mapping is; by default the first paragraph of the docstring.
        instead: schemas of fields that the type alone does not tell.
    """
    hints, told = get_type_hints(cls, include_extras=True), attributes_of(cls)
    defaults = _defaults(cls)
    needed: dict[str, Schema] = {}
    optional: dict[str, Schema] = {}
    for name in _names(cls):
        schema = dict((instead or {}).get(name) or _typed(hints[name]))
        schema["description"] = told.get(name) or schema.get("description") or name.replace("_", " ")
        if name in defaults:
            plain = defaults[name]
            optional[name] = schema | ({"default": plain} if isinstance(plain, str | int | float | bool) else {})
        else:
            needed[name] = schema
    return mapping(about or summary_of(cls), needed, optional)


def _names(cls: type) -> tuple[str, ...]:
    if dataclasses.is_dataclass(cls):
        return tuple(field.name for field in dataclasses.fields(cls))
    return tuple(getattr(cls, "_fields", ()))


def _defaults(cls: type) -> Mapping[str, Any]:
    """The default of each field that has one; of one with a factory what the factory makes."""
    if not dataclasses.is_dataclass(cls):
        return dict(getattr(cls, "_field_defaults", {}))
    missing = dataclasses.MISSING
    found: dict[str, Any] = {}
    for field in dataclasses.fields(cls):
        if field.default is not missing:
            found[field.name] = field.default
        elif field.default_factory is not missing:
            found[field.name] = field.default_factory()
    return found


def _typed(hint: Any) -> Schema:
    marks = getattr(hint, "__metadata__", ())
    hint = hint.__origin__ if marks else hint
    if dataclasses.is_dataclass(hint) or hasattr(hint, "_fields"):
        return settings_schema(hint)
    if get_origin(hint) is Mapping:
        return {"type": "object", "additionalProperties": _typed(get_args(hint)[1])}
    if hint == Scalar:
        return {"type": ["string", "number", "boolean"]}
    if hint in (float, int):
        bounds = next((mark for mark in marks if isinstance(mark, Bounds)), NOT_TOLD)
        return {"type": "number" if hint is float else "integer", **_limits(bounds)}
    if hint in (str, bool):
        return {"type": "string" if hint is str else "boolean"}
    if hint is Any:
        return {}
    return _list(get_args(hint))


def _limits(bounds: Bounds) -> Schema:
    told = {"minimum": (bounds.least, NOT_TOLD.least), "maximum": (bounds.most, NOT_TOLD.most)}
    return {name: bound for name, (bound, untold) in told.items() if bound != untold}


def _list(inner: tuple[Any, ...]) -> Schema:
    if inner[-1] is Ellipsis:
        return {"type": "array", "items": _typed(inner[0])}
    each = [_typed(hint) for hint in inner]
    count = {"minItems": len(each), "maxItems": len(each)}
    if all(one == each[0] for one in each):
        return {"type": "array", "items": each[0], **count}
    return {"type": "array", "prefixItems": each, **count}
