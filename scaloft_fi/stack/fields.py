"""Fields of messages: the kinds that operators ask for, and which fields of a message are of which kind.

A message is a `typing.NamedTuple`.  A field's kind follows from its annotation: `float`, `int`, `bool` and `str` are
plain; `Vector`, `Image` and `Stamp` carry a kind beside their type.
"""

from __future__ import annotations

from enum import StrEnum
from functools import cache
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Point = tuple[float, float, float]


class Kind(StrEnum):
    """The kind of a field, beside its type."""

    STAMP = "a time stamp"
    VECTOR = "a vector"
    IMAGE = "an image"


Stamp = Annotated[float, Kind.STAMP]
"""A time stamp [s]."""
Vector = Annotated[Array, Kind.VECTOR]
"""(3,) the components x, y, z."""
Image = Annotated[Array, Kind.IMAGE]
"""(H, W) one number for each pixel, 0 where the sensor saw nothing."""


def field_names(message: type) -> tuple[str, ...]:
    """All fields of a message."""
    return tuple(getattr(message, "_fields", ()))


def number_fields(message: type) -> tuple[str, ...]:
    """Fields that are a number, a tuple of numbers, or an array of numbers."""
    return _sorted(message).numbers


def stamp_fields(message: type) -> tuple[str, ...]:
    """Fields that are time stamps."""
    return _sorted(message).stamps


def image_fields(message: type) -> tuple[str, ...]:
    """Fields that are images."""
    return _sorted(message).images


def vector_fields(message: type) -> tuple[str, ...]:
    """Fields with the components x, y, z."""
    return _sorted(message).vectors


def field_type(message: type, field: str) -> Any:
    """The annotated type of one field, without its kind."""
    return get_type_hints(message)[field]


class _Fields(NamedTuple):
    numbers: tuple[str, ...]
    vectors: tuple[str, ...]
    images: tuple[str, ...]
    stamps: tuple[str, ...]


@cache
def _sorted(message: type) -> _Fields:
    """The fields of a message by kind, cached because operators look them up at every sample."""
    types, kinds = get_type_hints(message), get_type_hints(message, include_extras=True)

    def of(kind: Kind) -> tuple[str, ...]:
        return tuple(name for name in field_names(message) if kind in getattr(kinds[name], "__metadata__", ()))

    return _Fields(
        numbers=tuple(name for name in field_names(message) if _numeric(types[name])),
        vectors=tuple(name for name in field_names(message) if types[name] == Point or name in of(Kind.VECTOR)),
        images=of(Kind.IMAGE),
        stamps=of(Kind.STAMP),
    )


def _numeric(hint: Any) -> bool:
    if hint in (float, int):
        return True
    if get_origin(hint) is tuple:
        return all(entry is float for entry in get_args(hint))
    # from numpy 2.5 on the origin of `NDArray[...]` is `NDArray` itself
    return get_origin(hint) in (np.ndarray, NDArray) and "float64" in str(hint)
