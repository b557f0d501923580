"""Holds an operator to its example, for the tests of the package that declares it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scaloft_fi.mutants.operator import Occurrences
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.registry import load_plugins

DIGITS = 1e-9
"""How much two equal numbers may differ."""


@dataclass(frozen=True)
class OperatorCheck:
    """What `check_operator` found.

    Attributes:
        operator: name of the operator.
        arrived: the samples that arrive where those of the example are sent, None where none arrives.
        failures: a sentence for each thing that does not hold; empty for a sound operator.
    """

    operator: str
    arrived: tuple[Any, ...]
    failures: tuple[str, ...]

    def __str__(self) -> str:
        return "\n".join([f"operator {self.operator!r}: {len(self.failures)} failures", *self.failures])


def operators_of(package: str) -> tuple[str, ...]:
    """The names of the operators that a package or module declares, in the order of declaration; plugins are loaded.

    >>> operators_of("scaloft_fi.mutants.operators.sensors")[:3]
    ('scale_range', 'min_score', 'narrow')
    """
    load_plugins()
    return tuple(name for name, one in OPERATORS.items() if f"{one.make.__module__}.".startswith(f"{package}."))


def check_operator(name: str) -> OperatorCheck:
    """Send the samples of an operator's example through a tap of it, and hold what arrives against the example.

    Args:
        name: of the operator; plugins are loaded.

    Raises:
        InputError: there is no such operator, or its example has arguments that it does not take.

    >>> check_operator("delay").failures
    ()
    """
    load_plugins()
    one = OPERATORS[name]
    example = one.example
    tap = one.tap(example.context(), one.check("example", example.message, example.arguments))
    arrived = tuple(tap(place / example.rate_hz, sample) for place, sample in enumerate(example.before))
    failures = []
    if callable(example.after):
        if not example.after(example.before, arrived):
            failures.append(f"its example does not hold: {arrived} arrives")
    else:
        if len(example.after) != len(arrived):
            failures.append(f"its example has {len(example.after)} samples after, and {len(arrived)} arrive")
        failures += [
            f"sample {place} of its example: {there} arrives, not {said}"
            for place, (said, there) in enumerate(zip(example.after, arrived, strict=False))
            if not alike(said, there)
        ]
    one.tap(replace(example.context(), event=(event := Occurrences())), example.arguments)
    if one.awaits_events and not event.awaited:
        failures.append("its argument phase_s must shift windows that it takes from its context")
    if not one.summary.endswith("."):
        failures.append("its docstring must begin with a sentence: it is what lists of operators show")
    return OperatorCheck(name, arrived, tuple(failures))


def alike(one: Any, other: Any) -> bool:
    """Whether two samples are equal but for the last digits of their numbers."""
    if isinstance(one, tuple):
        return type(one) is type(other) and len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, np.ndarray):
        return isinstance(other, np.ndarray) and one.shape == other.shape and np.allclose(one, other, 0.0, DIGITS)
    if isinstance(one, float) and isinstance(other, float):
        return one == other or abs(one - other) < DIGITS
    return bool(one == other)
