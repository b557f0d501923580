"""The seams: named, typed edges between two stages, or a setting where a stage uses it.  Faults are patched in here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Protocol, TypeVar

import numpy as np

from scaloft_fi.stack.fields import field_names, number_fields

S = TypeVar("S")


class Wire(Protocol):
    """Carries samples over the seams."""

    def listens(self, seam: str) -> bool:
        """Whether the wire counts or changes samples of `seam`; a fast path may skip only other seams."""
        ...

    def cross(self, seam: str, t_s: float, sample: S | None) -> S | None:
        """Carry `sample` (None = nothing is sent at this tick) over `seam`; returns what arrives."""
        ...


class PlainWire:
    """Delivers every sample unchanged."""

    def listens(self, seam: str) -> bool:
        """Return False for every seam."""
        return False

    def cross(self, seam: str, t_s: float, sample: S | None) -> S | None:
        """Return `sample`."""
        return sample


UNITS: Mapping[str, str] = MappingProxyType(
    {
        "s": "s",
        "m": "m",
        "mps": "m/s",
        "mps2": "m/s2",
        "rad": "rad",
        "radps": "rad/s",
        "deg": "deg",
        "hz": "Hz",
        "n": "N",
        "v": "V",
        "ev": "EV",
    }
)
"""Units by the ending of a field's name, as in `range_m`."""


def _whole(sample: Any) -> Any:
    return sample


@dataclass(frozen=True)
class Seam:
    """One place where a fault can be patched in.

    Attributes:
        name: unique name.
        message: type of the sample.
        rate_hz: how often the seam is polled [Hz].
        edge: from which stage to which.
        effect: the part of a sample that its consumer acts on; two samples differ only where this part does.
        units: of the fields whose name does not end in their unit; "" for a plain number.

    Raises:
        ValueError: `units` names no field, or the rate is not positive.
    """

    name: str
    message: type
    rate_hz: float
    edge: str
    effect: Callable[[Any], Any] = _whole
    units: Mapping[str, str] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        unknown = [name for name in self.units if name not in field_names(self.message)]
        if unknown:
            raise ValueError(f"seam {self.name!r}: {self.message.__name__} has no field {unknown[0]!r}")
        if not self.rate_hz > 0.0:
            raise ValueError(f"seam {self.name!r}: rate_hz={self.rate_hz:g} must be positive")

    def unit(self, field: str) -> str:
        """The unit of a field: declared, else the ending of its name, else "" for a plain number."""
        return self.units.get(field, UNITS.get(field.rpartition("_")[2], "") if "_" in field else "")

    @property
    def number_units(self) -> Mapping[str, str]:
        """The unit of each field of numbers."""
        return {name: self.unit(name) for name in number_fields(self.message)}

    def differ(self, original: Any, delivered: Any) -> bool:
        """Whether the consumer acts on something else than the producer sent."""
        if original is delivered:
            return False
        if original is None or delivered is None:
            return True
        return not _equal(self.effect(original), self.effect(delivered))


def _equal(a: Any, b: Any) -> bool:
    if a is b:
        return True
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(_equal, a, b))
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return _equal_arrays(np.asarray(a), np.asarray(b))
    return bool(a == b)


def _equal_arrays(a: np.ndarray[Any, Any], b: np.ndarray[Any, Any]) -> bool:
    """`numpy.array_equal(a, b, equal_nan=True)` in half the time."""
    if a.shape != b.shape:
        return False
    if a.size <= _FEW:
        return all(map(_same, a.ravel().tolist(), b.ravel().tolist()))
    return bool((a == b).all() or _same(a, b).all())


def _same(a: Any, b: Any) -> Any:
    """Whether two numbers, or each pair of those in two arrays, are equal or both NaN."""
    return (a == b) | ((a != a) & (b != b))


_FEW = 16
"""Arrays of at most this size are compared number by number, which is faster."""
