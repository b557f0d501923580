"""Operators: declared functions that turn one seam's samples into faulty ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.cell import Value
from scaloft_fi.mutants.argument import ALL, VECTORS, Argument, arguments_of, check_against_field
from scaloft_fi.registry import Registry
from scaloft_fi.stack.seam import SEAMS

Tap = Callable[[float, Any | None], Any | None]
"""(time [s], sample or None when nothing is sent at this poll) -> what arrives.

A tap keeps its memory in its own attributes (a copy of the tap is independent of it) and never writes into a sample.
"""

Samples = tuple[Any, ...]
ANY = tuple(SEAMS)


@dataclass(frozen=True)
class TapContext:
    """What a tap may know of the flight it is patched into.

    Attributes:
        period_s: time between two polls of the seam [s].
        rng: the mutant's own stream in this flight; no other channel draws from it.
        duration_s: nominal mission time of the situation [s].
        facts: of the situation's nominal flight: `sighting_s` (None when no person is ever seen), `home_x`,
            `home_y` [m], `cruise_mps`, `slow_mps` [m/s], `gyro_sigma_radps` [rad/s], `accel_sigma_mps2` [m/s2].
    """

    period_s: float
    rng: np.random.Generator
    duration_s: float = 60.0
    facts: Mapping[str, float | None] = field(default_factory=dict)

    def fact(self, name: str, otherwise: float) -> float:
        """A fact, or `otherwise` where it is unknown."""
        known = self.facts.get(name)
        return otherwise if known is None else known


@dataclass(frozen=True)
class Example:
    """What an operator does to a few samples, one per poll from t = 0; it documents the operator and is its test.

    Attributes:
        seam: on which seam.
        arguments: of the operator.
        before: what is sent.
        after: what arrives; where chance decides, a law that (before, after) must satisfy.
        facts: of the tap's context.
        duration_s: nominal mission time [s].
    """

    seam: str
    arguments: Mapping[str, Value]
    before: Samples
    after: Samples | Callable[[Samples, Samples], bool]
    facts: Mapping[str, float | None] = field(default_factory=dict)
    duration_s: float = 60.0

    def context(self, seed: int = 0) -> TapContext:
        """The context the example runs in."""
        rng = np.random.Generator(np.random.Philox(seed))
        return TapContext(1.0 / SEAMS[self.seam].rate_hz, rng, self.duration_s, self.facts)


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
        seams: where it can be patched in.
        make: (context, **arguments) -> a fresh tap.
        arguments: its arguments by name.
        example: what it does.
    """

    name: str
    seams: tuple[str, ...]
    make: Callable[..., Tap]
    arguments: Mapping[str, Argument]
    example: Example

    @property
    def summary(self) -> str:
        """First sentence of the operator's docstring."""
        return " ".join((self.make.__doc__ or "").split("\n\n")[0].split())

    def check(self, seam: str, arguments: Mapping[str, Any]) -> dict[str, Value]:
        """The arguments as the operator takes them, defaults not filled in.

        Raises:
            OperatorError: the seam does not exist or does not fit; an argument is unknown, missing, of another type or
                out of range.
        """
        if seam not in SEAMS:
            raise OperatorError("seam", f"no seam {seam!r}{did_you_mean(seam, SEAMS)}")
        if seam not in self.seams:
            fitting = did_you_mean(seam, self.seams)
            raise OperatorError("seam", f"operator {self.name!r} does not fit seam {seam!r}{fitting}")
        checked: dict[str, Value] = {}
        for name, value in arguments.items():
            if name not in self.arguments:
                known = did_you_mean(name, self.arguments)
                raise OperatorError(name, f"operator {self.name!r} has no argument {name!r}{known}")
            with self._telling(name):
                checked[name] = self.arguments[name].check(value, SEAMS[seam].message)
        missing = [name for name, argument in self.arguments.items() if argument.required and name not in checked]
        if missing:
            raise OperatorError("operator", f"operator {self.name!r} lacks the argument {missing[0]!r}")
        self._check_field(SEAMS[seam].message, checked)
        return checked

    def _check_field(self, message: type, checked: dict[str, Value]) -> None:
        name = str(checked.get("field", ALL))
        if checked.get("component") and "field" in self.arguments and name not in VECTORS:
            raise OperatorError("component", f"operator {self.name!r}: field={name!r} has no components x, y, z")
        if self.name == "set":
            with self._telling("value"):
                checked["value"] = check_against_field(message, name, checked["value"])

    @contextmanager
    def _telling(self, argument: str) -> Iterator[None]:
        try:
            yield
        except InputError as error:
            raise OperatorError(argument, f"operator {self.name!r}: {error}") from None

    def tap(self, context: TapContext, arguments: Mapping[str, Value]) -> Tap:
        """A fresh tap with checked `arguments`."""
        return self.make(context, **arguments)

    def period_s(self, arguments: Mapping[str, Value]) -> float | None:
        """The time after which the fault recurs, or at which it strikes once [s]; None when it cannot be shifted."""
        if "phase_s" not in self.arguments:
            return None
        name = "period_s" if "period_s" in self.arguments else "at_s"
        return float(arguments.get(name, self.arguments[name].default))


OPERATORS = Registry[Operator]("operator")


def operator(
    name: str, *, seams: tuple[str, ...] = ANY, example: Example
) -> Callable[[Callable[..., Tap]], Callable[..., Tap]]:
    """Declare the decorated factory (context, *, arguments) -> tap as operator `name`.

    Raises:
        ValueError: the name is taken, or a seam does not exist.
    """
    unknown = [seam for seam in seams if seam not in SEAMS]
    if unknown:
        raise ValueError(f"operator {name!r} names the unknown seam {unknown[0]!r}")

    def declare(make: Callable[..., Tap]) -> Callable[..., Tap]:
        OPERATORS.declare(name, Operator(name, seams, make, arguments_of(make), example))
        return make

    return declare
