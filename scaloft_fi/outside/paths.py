"""The user's own mapping of fields: a path of the border's message to a path of the sample, perhaps times a number."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from scaloft_fi.outside.plain import MisfitError

AXES = {"x": 0, "y": 1, "z": 2}


class Mapped(NamedTuple):
    """A path of the sample, and what its number is multiplied by in the border's message."""

    path: tuple[str, ...]
    factor: float = 1.0


def mapped(text: str) -> Mapped:
    """Read `velocity.x` or `velocity.x * 1000`.

    >>> mapped("velocity.x * 1000")
    Mapped(path=('velocity', 'x'), factor=1000.0)

    Raises:
        ValueError: the factor is no number, or zero.
    """
    path, _, factor = text.partition("*")
    number = float(factor) if factor else 1.0
    if not number or number != number:
        raise ValueError(f"{text!r}: the factor must be a number other than zero")
    return Mapped(tuple(path.strip().split(".")), number)


def given(plain: Any, fields: Mapping[str, str]) -> Any:
    """The border's message for the plain values of a sample; without fields they are the message.

    >>> given({"velocity": [1.0, 2.0, 3.0]}, {"linear.x": "velocity.x * 100"})
    {'linear': {'x': 100.0}}
    """
    if not fields:
        return plain
    message: dict[str, Any] = {}
    for theirs, ours in fields.items():
        way, factor = mapped(ours)
        value = plain
        for key in way:
            value = value[AXES[key]] if isinstance(value, list) else value[key]
        *parents, last = theirs.split(".")
        place = message
        for parent in parents:
            place = place.setdefault(parent, {})
        place[last] = value if factor == 1.0 else value * factor
    return message


def taken(message: Any, fields: Mapping[str, str]) -> Any:
    """The plain values of a sample for a message of the border.

    >>> taken({"linear": {"x": 100.0}}, {"linear.x": "velocity.x * 100"})
    {'velocity': [1.0, 0.0, 0.0]}

    Raises:
        MisfitError: the message lacks a field.
    """
    if not fields:
        return message
    plain: dict[str, Any] = {}
    for theirs, ours in fields.items():
        way, factor = mapped(ours)
        value = message
        for key in theirs.split("."):
            if not isinstance(value, dict) or key not in value:
                raise MisfitError(f"{theirs} is missing")
            value = value[key]
        if factor != 1.0:
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise MisfitError(f"{theirs} must be a number")
            value = _divided(theirs, value, factor)
        if way[-1] in AXES and len(way) == 2:
            plain.setdefault(way[0], [0.0, 0.0, 0.0])[AXES[way[-1]]] = value
        else:
            plain[way[0]] = value
    return plain


def _divided(path: str, value: float, factor: float) -> float:
    try:
        return value / factor
    except OverflowError:
        raise MisfitError(f"{path} is too large") from None


def picked(message: object, paths: Iterable[str]) -> Any:
    """The attributes of a message that stand at these paths, as nested mappings; what is missing is left out.

    >>> from types import SimpleNamespace
    >>> picked(SimpleNamespace(linear=SimpleNamespace(x=1.0, y=2.0)), ["linear.x", "angular.z"])
    {'linear': {'x': 1.0}}
    """
    plain: dict[str, Any] = {}
    for path in paths:
        value: Any = message
        for key in path.split("."):
            value = getattr(value, key, None)
        if value is None:
            continue
        *parents, last = path.split(".")
        place = plain
        for parent in parents:
            place = place.setdefault(parent, {})
        place[last] = value
    return plain
