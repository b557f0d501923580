"""Samples as plain JSON values and back: the same names, arrays as lists, images packed."""

from __future__ import annotations

import base64
import math
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

from scaloft_fi.stack.messages import Point, field_names, image_fields

SIDE = 4096
"""Greatest height and width of an image."""
LARGEST = 1 << 1023
"""Greatest whole number that is read as a number with a point."""
LONGEST = 1_000
"""Greatest length of a tuple, and of a text."""


class MisfitError(ValueError):
    """A value does not fit its field; the message names the field."""


def to_plain(sample: Any) -> Any:
    """The plain values of a sample: named tuples are mappings, vectors are lists, images packed little-endian doubles.

    >>> from scaloft_fi.stack.messages import Bumper
    >>> to_plain(Bumper(1.5, hull=True, gear=False))
    {'stamp_s': 1.5, 'hull': True, 'gear': False}
    """
    if hasattr(sample, "_fields"):
        images = image_fields(type(sample))
        return {name: (_packed if name in images else to_plain)(getattr(sample, name)) for name in sample._fields}
    if isinstance(sample, np.ndarray):
        return sample.tolist()
    if isinstance(sample, tuple):
        return [to_plain(entry) for entry in sample]
    return sample


def _packed(image: Any) -> dict[str, Any]:
    height, width = image.shape
    data = base64.b64encode(np.ascontiguousarray(image, dtype="<f8").tobytes()).decode("ascii")
    return {"height": height, "width": width, "data": data}


def from_plain(message: type, value: Any, name: str = "data") -> Any:
    """The sample of a message type that plain values stand for.

    Raises:
        MisfitError: a field is missing, unknown, of another type, not finite or too large.
    """
    if not isinstance(value, dict):
        raise MisfitError(f"{name} must be a mapping")
    hints = get_type_hints(message)
    images = image_fields(message)
    unknown = sorted(str(key) for key in value.keys() - hints.keys())
    if unknown:
        raise MisfitError(f"{name}.{unknown[0]} is no field of {message.__name__}: {', '.join(hints)}")
    made = {}
    for field in field_names(message):
        path = f"{name}.{field}"
        if field not in value:
            if field in getattr(message, "_field_defaults", ()):
                continue
            raise MisfitError(f"{path} is missing")
        made[field] = (_image if field in images else _value)(hints[field], value[field], path)
    return message(**made)


def _value(hint: Any, value: Any, path: str) -> Any:
    if hint is float:
        return _number(value, path)
    if hint is int:
        if isinstance(value, bool) or not isinstance(value, int) or abs(value) > 1 << 53:
            raise MisfitError(f"{path} must be a whole number")
        return value
    if hint is bool:
        if not isinstance(value, bool):
            raise MisfitError(f"{path} must be true or false")
        return value
    if hint is str:
        if not isinstance(value, str) or len(value) > LONGEST:
            raise MisfitError(f"{path} must be a text of at most {LONGEST} characters")
        return value
    if hint == Point:
        return tuple(_numbers(value, path, 3))
    if get_origin(hint) is tuple:
        if not isinstance(value, list) or len(value) > LONGEST:
            raise MisfitError(f"{path} must be a list of at most {LONGEST}")
        return tuple(from_plain(get_args(hint)[0], entry, f"{path}[{place}]") for place, entry in enumerate(value))
    return np.array(_numbers(value, path, 4 if path.endswith("attitude") else 3))


def _number(value: Any, path: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise MisfitError(f"{path} must be a number")
    if (isinstance(value, int) and abs(value) > LARGEST) or not math.isfinite(value):
        raise MisfitError(f"{path}={value!r:.20} must be finite")
    return float(value)


def _numbers(value: Any, path: str, count: int) -> list[float]:
    if not isinstance(value, list) or len(value) != count:
        raise MisfitError(f"{path} must be a list of {count} numbers")
    return [_number(entry, f"{path}[{place}]") for place, entry in enumerate(value)]


def _image(_hint: Any, value: Any, path: str) -> Any:
    packed = isinstance(value, dict) and value.keys() == {"height", "width", "data"}
    if not packed or not all(isinstance(value[side], int) and 0 < value[side] <= SIDE for side in ("height", "width")):
        raise MisfitError(f"{path} must have height, width (at most {SIDE}) and data")
    shape = value["height"], value["width"]
    try:
        data = base64.b64decode(value["data"], validate=True)
        image = np.frombuffer(data, dtype="<f8").reshape(shape).astype(np.float64)
    except (ValueError, TypeError) as error:
        raise MisfitError(f"{path}.data must be {shape[0] * shape[1]} packed numbers: {error}") from error
    if not np.isfinite(image).all():
        raise MisfitError(f"{path}.data must be finite")
    return image
