"""Operators: declared functions that turn one seam's samples into faulty ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.cell import Value
from scaloft_fi.mutants.argument import ALL, Argument, arguments_of, check_against_field
from scaloft_fi.mutants.facts import Facts
from scaloft_fi.mutants.need import ANYTHING, Need
from scaloft_fi.registry import Registry
from scaloft_fi.stack.fields import vector_fields
from scaloft_fi.stack.rates import TICK_HZ

Tap = Callable[[float, Any | None], Any | None]
"""(time [s], sample or None when nothing is sent at this poll) -> what arrives.

A tap keeps its memory in its own attributes (a copy of the tap is independent of it) and never writes into a sample.
"""

Samples = tuple[Any, ...]


@dataclass(frozen=True)
class TapContext:
    """What a tap may know of the flight it is patched into.

    Attributes:
        period_s: time between two polls of the seam [s].
        rng: the mutant's own stream in this flight; no other channel draws from it.
        message: type of the samples.
        facts: of situation, vehicle and sensors.
    """

    period_s: float
    rng: np.random.Generator
    message: type = tuple
    facts: Facts = Facts()  # noqa: RUF009 - frozen


@dataclass(frozen=True)
class Example:
    """What an operator does to a few samples, one per poll from t = 0; it documents the operator and is its test.

    Attributes:
        message: type of the samples.
        arguments: of the operator.
        before: what is sent.
        after: what arrives; where chance decides, a law that (before, after) must satisfy.
        facts: of the tap's context.
        rate_hz: how often the seam is polled [Hz].
    """

    message: type
    arguments: Mapping[str, Value]
    before: Samples
    after: Samples | Callable[[Samples, Samples], bool]
    facts: Facts = Facts()  # noqa: RUF009 - frozen
    rate_hz: float = TICK_HZ

    def context(self, seed: int = 0) -> TapContext:
        """The context the example runs in."""
        rng = np.random.Generator(np.random.Philox(seed))
        return TapContext(1.0 / self.rate_hz, rng, self.message, self.facts)


class OperatorError(InputError):
    """An operator cannot be used so.  The sentence has no place: whoever knows the place of `about` puts it first.

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
        need: what a seam's message must have.
        make: (context, **arguments) -> a fresh tap.
        arguments: its arguments by name.
        example: what it does.
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

    def check(self, seam: str, message: type, arguments: Mapping[str, Any]) -> dict[str, Value]:
        """The arguments as the operator takes them, defaults not filled in.

        Args:
            seam: name of the seam it is patched in at.
            message: type of the samples there.
            arguments: as the study gives them.

        Raises:
            OperatorError: the message lacks what the operator needs; an argument is unknown, missing, of another type
                or out of range.
        """
        if not self.need.met_by(message):
            sentence = f"operator {self.name!r} needs {self.need.words}; seam {seam!r} carries {message.__name__}"
            raise OperatorError("seam", sentence)
        checked: dict[str, Value] = {}
        for name, value in arguments.items():
            if name not in self.arguments:
                known = did_you_mean(name, self.arguments)
                raise OperatorError(name, f"operator {self.name!r} has no argument {name!r}{known}")
            with self._telling(name):
                checked[name] = self.arguments[name].check(value, message)
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
                with self._telling(name):
                    checked[name] = check_against_field(message, field, checked[name])

    @contextmanager
    def _telling(self, argument: str) -> Iterator[None]:
        try:
            yield
        except InputError as error:
            raise OperatorError(argument, f"operator {self.name!r}: {error}") from None

    def tap(self, context: TapContext, arguments: Mapping[str, Value]) -> Tap:
        """A fresh tap with checked `arguments`."""
        return self.make(context, **arguments)


OPERATORS = Registry[Operator]("operator")


def operator(
    name: str, *, example: Example, need: Need = ANYTHING
) -> Callable[[Callable[..., Tap]], Callable[..., Tap]]:
    """Declare the decorated factory (context, *, arguments) -> tap as operator `name`.

    Raises:
        ValueError: the name is taken, or the example's message lacks what the operator needs.
    """
    if not need.met_by(example.message):
        raise ValueError(f"operator {name!r} needs {need.words}, which its example's message lacks")

    def declare(make: Callable[..., Tap]) -> Callable[..., Tap]:
        OPERATORS.declare(name, Operator(name, need, make, arguments_of(make), example))
        return make

    return declare
