"""Holds an operator to its example, for the tests of the package that declares it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scaloft_fi.mutants.operator import Occurrences, TapError
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.registry import load_plugins

DIGITS = 1e-9
"""How much two equal numbers may differ."""
TRIED_S = 30.0
"""How long the samples of an example are sent again, so that a fault that begins late acts [s]."""


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

    Two more taps get the same samples for 30 s, and the same must arrive from both.

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
    one.check("example", example.message, example.arguments)
    event = Occurrences()
    try:
        arrived, lasting = one.arrived(), (one.arrived(TRIED_S), one.arrived(TRIED_S))
        one.tap(replace(example.context(), event=event), example.arguments)
    except TapError as error:
        return OperatorCheck(name, (), (str(error),))
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
    differing = [place / example.rate_hz for place, pair in enumerate(zip(*lasting, strict=True)) if not alike(*pair)]
    if differing:
        failures.append(
            f"two flights differ at {differing[0]:g} s, where the samples of its example go on: random numbers must "
            "come from context.rng, the memory of a tap must be its own, and a sample is never written to"
        )
    if one.awaits_events and not event.awaited:
        failures.append("its argument phase_s must shift windows that it takes from its context")
    if not one.summary.endswith("."):
        failures.append("its docstring must begin with a sentence: it is what lists of operators show")
    return OperatorCheck(name, arrived, tuple(failures))


def alike(one: Any, other: Any) -> bool:
    """Whether two samples are equal but for the last digits of their numbers."""
    if isinstance(one, tuple):
        return type(one) is type(other) and len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, np.ndarray | float):
        of_numbers = isinstance(other, np.ndarray | float | int) and np.shape(one) == np.shape(other)
        return of_numbers and np.allclose(one, other, 0.0, DIGITS, equal_nan=True)
    return bool(one == other)
