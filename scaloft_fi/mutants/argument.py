"""Arguments of an operator: declared by annotation, and checked before any flight."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.cell import Value
from scaloft_fi.stack.fields import field_names, field_type, number_fields

ALL = "all"
"""Field name that stands for every number of the sample."""


@dataclass(frozen=True)
class Range:
    """Allowed numbers: `least` <= value <= `most`, and value > `above`."""

    least: float = -math.inf
    most: float = math.inf
    above: float = -math.inf

    def __contains__(self, value: float) -> bool:
        return self.least <= value <= self.most and value > self.above

    def __str__(self) -> str:
        bounds = [f">= {self.least:g}"] * (self.least > -math.inf) + [f"> {self.above:g}"] * (self.above > -math.inf)
        bounds += [f"<= {self.most:g}"] * (self.most < math.inf)
        return " and ".join(bounds) or "a finite number"


@dataclass(frozen=True)
class FieldName:
    """Marks an argument that names a field of the sample; `number`: the field must be numeric, or `all`."""

    number: bool = True


@dataclass(frozen=True)
class FieldValue:
    """Marks an argument that becomes the value of the field that the argument `field` names."""


Number = Annotated[float, Range(least=-1e12, most=1e12)]
Seconds = Annotated[float, Range(least=0.0, most=1e6)]
Hold = Annotated[float, Range(least=0.0)]
Period = Annotated[float, Range(above=0.0, most=1e6)]
Share = Annotated[float, Range(least=0.0, most=1.0)]
Factor = Annotated[float, Range(least=0.0, most=1e6)]
Metres = Annotated[float, Range(least=0.0, most=1e3)]
Degrees = Annotated[float, Range(least=-360.0, most=360.0)]
Place = Annotated[int, Range(least=0.0, most=1e3)]
NumericField = Annotated[str, FieldName()]
AnyField = Annotated[str, FieldName(number=False)]
ValueOfField = Annotated[Value, FieldValue()]
Axis = Literal["x", "y", "z"]
Component = Literal["", "x", "y", "z"]


@dataclass(frozen=True)
class Argument:
    """One argument of an operator.

    Attributes:
        name: in the operator's signature; it ends in the unit.
        kind: float, int, str, bool, or object (any of float, str, bool).
        allowed: bounds of a number.
        choices: allowed texts; empty when every text is allowed.
        field: how the text names a field of the sample; None for other texts.
        of_field: whether the value becomes the value of a field.
        default: inspect.Parameter.empty when the argument is required.
    """

    name: str
    kind: type
    allowed: Range
    choices: tuple[str, ...]
    field: FieldName | None
    of_field: bool
    default: Any

    @property
    def required(self) -> bool:
        """Whether the argument has no default."""
        return self.default is inspect.Parameter.empty

    def check(self, value: Any, message: type) -> Value:
        """`value`, converted to the argument's type.

        Raises:
            InputError: wrong type, out of range, or not one of the allowed texts.
        """
        if self.kind is object:
            return value if isinstance(value, str | bool) else self._number(value)
        if self.kind in (float, int):
            return self._number(value)
        if self.kind is bool:
            if not isinstance(value, bool):
                raise InputError(f"{self.name}={value!r} must be true or false")
            return value
        if not isinstance(value, str):
            raise InputError(f"{self.name}={value!r} must be a text")
        if self.choices and value not in self.choices:
            raise InputError(f"{self.name}={value!r} is not known{did_you_mean(value, self.choices)}")
        if self.field is not None:
            known = number_fields(message) if self.field.number else field_names(message)
            if value not in (*known, ALL):
                kind = "numeric field" if self.field.number else "field"
                raise InputError(
                    f"{self.name}={value!r} is no {kind} of {message.__name__}{did_you_mean(value, known)}"
                )
        return value

    def _number(self, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
            raise InputError(f"{self.name}={value!r} must be a number")
        if value not in self.allowed:
            raise InputError(f"{self.name}={value:g} must be {self.allowed}")
        if self.kind is int:
            if value != int(value):
                raise InputError(f"{self.name}={value:g} must be a whole number")
            return int(value)
        return float(value)


def arguments_of(factory: Callable[..., Any]) -> Mapping[str, Argument]:
    """The keyword-only arguments of an operator's factory, by name, read from its annotations."""
    hints = get_type_hints(factory, include_extras=True)
    parameters = inspect.signature(factory).parameters.values()
    keywords = (p for p in parameters if p.kind is inspect.Parameter.KEYWORD_ONLY)
    return MappingProxyType({p.name: _argument(p.name, hints[p.name], p.default) for p in keywords})


def _argument(name: str, hint: Any, default: Any) -> Argument:
    marks: tuple[Any, ...] = ()
    if get_origin(hint) is Annotated:
        hint, *rest = get_args(hint)
        marks = tuple(rest)
    choices: tuple[str, ...] = ()
    if get_origin(hint) is Literal:
        choices, hint = get_args(hint), str
    allowed = next((mark for mark in marks if isinstance(mark, Range)), Range())
    field = next((mark for mark in marks if isinstance(mark, FieldName)), None)
    of_field = any(isinstance(mark, FieldValue) for mark in marks)
    return Argument(name, hint if isinstance(hint, type) else object, allowed, choices, field, of_field, default)


def check_against_field(message: type, field: str, value: Value) -> Value:
    """`value`, converted to the type of the field `field` of `message`.

    Raises:
        InputError: the field holds another type.
    """
    if field == ALL:
        if not isinstance(value, str | bool):
            return value
        raise InputError(f"value={value!r} must be a number")
    hint = field_type(message, field)
    fits = {float: "a number", int: "a whole number", str: "a text", bool: "true or false"}
    if hint not in fits:
        raise InputError(f"field={field!r} of {message.__name__} holds no single value")
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if hint in (float, int):
        if not number or (hint is int and value != int(value)):
            raise InputError(f"value={value!r} must be {fits[hint]}, as {message.__name__}.{field} is")
        return int(value) if hint is int else float(value)
    if not (isinstance(value, str) if hint is str else isinstance(value, bool)):
        raise InputError(f"value={value!r} must be {fits[hint]}, as {message.__name__}.{field} is")
    return value
