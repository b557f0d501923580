"""The fields of a message in words: what kind each is, and its unit."""

from __future__ import annotations

from typing import Any, get_args, get_origin

from scaloft_fi.stack.declaration import UNITS, Seam
from scaloft_fi.stack.messages import (
    Point,
    field_names,
    field_type,
    image_fields,
    number_fields,
    stamp_fields,
    vector_fields,
)

_PLAIN = {float: "number", int: "whole number", str: "text", bool: "true or false"}


def fields_of(seam: Seam) -> list[dict[str, str]]:
    """Name, kind and unit of each field of a seam's message."""
    return [
        {"name": name, "kind": kind_of(seam.message, name), "unit": _unit(seam, name)}
        for name in field_names(seam.message)
    ]


def _unit(seam: Seam, name: str) -> str:
    if name in stamp_fields(seam.message):
        return "s"
    if name in number_fields(seam.message):
        return seam.unit(name)
    return ""


def kind_of(message: type, name: str) -> str:
    """The kind of a field in words.

    >>> from scaloft_fi.stack.messages import Detections, Imu
    >>> kind_of(Imu, "rate"), kind_of(Imu, "stamp_s")
    ('3 numbers x, y, z', 'time stamp')
    >>> kind_of(Detections, "persons")
    'Person, any number of: label text, score number, bearing_rad number [rad], range_m number [m]'
    """
    if name in stamp_fields(message):
        return "time stamp"
    if name in image_fields(message):
        return "image"
    hint = field_type(message, name)
    if hint == Point or name in vector_fields(message):
        return "3 numbers x, y, z"
    return _said(hint)


def _said(hint: Any) -> str:
    if hint in _PLAIN:
        return _PLAIN[hint]
    if get_origin(hint) is tuple:
        first, *rest = get_args(hint)
        if rest == [Ellipsis]:
            return (
                f"{_inner(first)}, any number of"
                if not field_names(first)
                else f"{first.__name__}, any number of: {_whole(first)}"
            )
        return f"{len(rest) + 1} values"
    if field_names(hint):
        return f"{hint.__name__}: {_whole(hint)}"
    return "numbers" if "float" in str(hint) else "true or false, any number of" if "bool" in str(hint) else "values"


def _inner(hint: Any) -> str:
    return "3 numbers x, y, z" if hint == Point else _said(hint)


def _whole(message: type) -> str:
    def one(name: str) -> str:
        unit = UNITS.get(name.rpartition("_")[2], "") if "_" in name else ""
        return f"{name} {kind_of(message, name)}" + (f" [{unit}]" if unit else "")

    return ", ".join(map(one, field_names(message)))
