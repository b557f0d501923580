"""Operators: declared factories of taps, which turn the samples of one seam into faulty samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.cell import Value
from scaloft_fi.mutants.argument import ALL, Argument, arguments_of, check_against_field
from scaloft_fi.mutants.facts import Facts
from scaloft_fi.mutants.need import ANYTHING, Need
from scaloft_fi.mutants.window import Occurrences, Times, Windows
from scaloft_fi.registry import Registry
from scaloft_fi.stack.fields import vector_fields
from scaloft_fi.stack.rates import TICK_HZ

Tap = Callable[[float, Any | None], Any | None]
"""(time [s], sample, or None when nothing is sent at this poll) -> sample that arrives, or None.

A tap keeps its memory in its own attributes, so that a copy of the tap is independent, and never writes into a sample.
"""

Samples = tuple[Any, ...]


@dataclass(frozen=True)
class TapContext:
    """What a tap may know of the flight that it is patched into.

    Attributes:
        period_s: time between two polls of the seam [s].
        rng: random numbers of the mutant in this flight; nothing else draws from them.
        facts: of situation, vehicle and sensors.
        event: the occurrences of the event at which the fault strikes; None for a fault that strikes at times.
    """

    period_s: float
    rng: np.random.Generator
    facts: Facts = field(default_factory=Facts)
    event: Occurrences | None = None

    def windows(self, period_s: float, phase_s: float, length_s: float) -> Windows:
        """Windows of `length_s` [s] each of a fault that recurs.

        They open each `period_s` [s], shifted by `phase_s` [s].  If the fault strikes at an event, they open at each
        occurrence instead, but none sooner than `period_s` after the one before: an event that the fault itself
        brings about does not make it permanent.
        """
        if self.event is None:
            return Windows.periodic(period_s, phase_s, length_s)
        return Windows(self.event.openings(apart_s=period_s), length_s)

    def window(self, at_s: float, length_s: float) -> Windows:
        """The window of a fault that happens once: at `at_s` [s], or at the first occurrence of the event."""
        return Windows(Times(at_s) if self.event is None else self.event.openings(apart_s=math.inf), length_s)


@dataclass(frozen=True)
class Example:
    """A few samples before and after an operator, one for each poll from t = 0; it documents and tests the operator.

    Attributes:
        message: type of the samples.
        arguments: of the operator.
        before: samples that are sent.
        after: samples that arrive; for a random operator a predicate that (before, after) must satisfy.
        facts: of the tap's context.
        rate_hz: how often the seam is polled [Hz].
    """

    message: type
    arguments: Mapping[str, Value]
    before: Samples
    after: Samples | Callable[[Samples, Samples], bool]
    facts: Facts = field(default_factory=Facts)
    rate_hz: float = TICK_HZ

    def context(self, seed: int = 0) -> TapContext:
        """The context of the example's tap."""
        rng = np.random.Generator(np.random.Philox(seed))
        return TapContext(1.0 / self.rate_hz, rng, self.facts)


class OperatorError(InputError):
    """An operator does not fit a seam, or an argument is wrong.

    The sentence names no file; the caller knows the place of `about` and puts it first.

    Attributes:
        about: "seam", "operator" or the argument's name.
    """

    def __init__(self, about: str, sentence: str) -> None:
        super().__init__(sentence)
        self.about = about


@dataclass(frozen=True)
class Operator:
    """One declared operator.

    Attributes:
        name: unique name, as in the study's YAML.
        need: what it requires of a seam's message.
        make: (context, **arguments) -> a fresh tap.
        arguments: its arguments by name.
        example: samples before and after it.
    """

    name: str
    need: Need
    make: Callable[..., Tap]
    arguments: Mapping[str, Argument]
    example: Example

    @property
    def summary(self) -> str:
        """First sentence of the operator's docstring."""
        return " ".join((self.make.__doc__ or "").split("\n\n")[0].split())

    @cached_property
    def awaits_events(self) -> bool:
        """Whether its taps open their windows at the event of their context."""
        event = Occurrences()
        self.make(replace(self.example.context(), event=event), **self.example.arguments)
        return event.awaited

    def check(self, seam: str, message: type, arguments: Mapping[str, Any]) -> dict[str, Value]:
        """`arguments`, converted to the types that the operator takes; defaults are not filled in.

        Args:
            seam: name of the seam.
            message: type of the seam's samples.
            arguments: as in the study.

        Raises:
            OperatorError: the message does not meet the operator's need; an argument is unknown, missing, of another
                type or out of range.
        """
        if not self.need.met_by(message):
            sentence = f"operator {self.name!r} needs {self.need.words}, but seam {seam!r} carries {message.__name__}"
            raise OperatorError("seam", sentence)
        checked: dict[str, Value] = {}
        for name, value in arguments.items():
            if name not in self.arguments:
                known = did_you_mean(name, self.arguments)
                raise OperatorError(name, f"operator {self.name!r} has no argument {name!r}{known}")
            try:
                checked[name] = self.arguments[name].check(value, message)
            except InputError as error:
                raise self._error(name, error) from None
        missing = [name for name, argument in self.arguments.items() if argument.required and name not in checked]
        if missing:
            raise OperatorError("operator", f"operator {self.name!r} lacks the argument {missing[0]!r}")
        self._check_field(message, checked)
        return checked

    def _check_field(self, message: type, checked: dict[str, Value]) -> None:
        field = str(checked.get("field", ALL))
        if checked.get("component") and "field" in self.arguments and field not in vector_fields(message):
            raise OperatorError("component", f"operator {self.name!r}: field={field!r} has no components x, y, z")
        for name, argument in self.arguments.items():
            if argument.of_field:
                try:
                    checked[name] = check_against_field(message, field, checked[name])
                except InputError as error:
                    raise self._error(name, error) from None

    def _error(self, argument: str, error: InputError) -> OperatorError:
        return OperatorError(argument, f"operator {self.name!r}: {error}")

    def tap(self, context: TapContext, arguments: Mapping[str, Value]) -> Tap:
        """A fresh tap with checked `arguments`."""
        return self.make(context, **arguments)


OPERATORS = Registry[Operator]("operator", "scaloft-fi operators")


def operator(
    name: str, *, example: Example, need: Need = ANYTHING
) -> Callable[[Callable[..., Tap]], Callable[..., Tap]]:
    """Declare the decorated factory (context, *, arguments) -> tap as operator `name`.

    Raises:
        ValueError: the name is taken, or the example's message does not meet `need`.
    """
    if not need.met_by(example.message):
        raise ValueError(f"operator {name!r} needs {need.words}, which its example's message lacks")

    def declare(make: Callable[..., Tap]) -> Callable[..., Tap]:
        OPERATORS.declare(name, Operator(name, need, make, arguments_of(make), example))
        return make

    return declare
