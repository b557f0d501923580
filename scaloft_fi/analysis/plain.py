"""Results as plain JSON values."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any


def plain(value: Any) -> Any:
    """A result as plain JSON values: a dataclass or named tuple by its fields, an enum by its value, a tuple as a list.

    >>> from scaloft_fi.analysis.ratio import Ratio
    >>> plain({"tested": Ratio(8, 15), "mutants": ("LATE-human@3s",)})
    {'tested': {'part': 8, 'whole': 15}, 'mutants': ['LATE-human@3s']}
    """
    if isinstance(value, Enum):
        return value.value
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if hasattr(value, "_asdict"):
        return plain(value._asdict())
    if isinstance(value, Mapping):
        return {plain(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, Collection) and not isinstance(value, str):
        return [plain(entry) for entry in value]
    return value
