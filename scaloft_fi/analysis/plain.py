"""Results as plain JSON values."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any


def plain(value: Any) -> Any:
    """A result as plain JSON values: by its own `to_json`, else a dataclass by its fields, an enum by its value.

    >>> from scaloft_fi.analysis.ratio import Ratio
    >>> plain({"tested": Ratio(8, 15), "mutants": ("LATE-human@3s",)})
    {'tested': {'part': 8, 'whole': 15}, 'mutants': ['LATE-human@3s']}
    """
    if hasattr(value, "to_json"):
        return value.to_json()
    if is_dataclass(value):
        return by_field(value)
    if isinstance(value, Enum):
        return value.value
    if hasattr(value, "_asdict"):
        return plain(value._asdict())
    if isinstance(value, Mapping):
        return {plain(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, Collection) and not isinstance(value, str):
        return [plain(entry) for entry in value]
    return value


def by_field(value: Any) -> dict[str, Any]:
    """The fields of a dataclass as plain JSON values."""
    return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
