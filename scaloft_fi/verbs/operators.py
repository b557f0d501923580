"""`scaloft-fi operators`: list the study's operators, without flying."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Annotated, Any, ClassVar

import numpy as np

from scaloft_fi.mutants.operator import Argument, Operator
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.registry import PLUGIN_GROUP
from scaloft_fi.stack.declaration import UNITS
from scaloft_fi.study import Study
from scaloft_fi.verbs.listing import Entry, Listing, number_range
from scaloft_fi.verbs.names import operators
from scaloft_fi.verbs.options import Option
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Answer, Output

OWN = "scaloft-fi"


def package_of(made: Callable[..., Any] | str) -> str:
    """The package that declares what a function makes: a distribution with a plugin, else the module's first name.

    Args:
        made: the function, or the name of its module.
    """
    module = made if isinstance(made, str) else made.__module__
    first = module.partition(".")[0]
    if first == __name__.partition(".")[0]:
        return OWN
    named = {plugin.module.partition(".")[0]: plugin.dist for plugin in entry_points(group=PLUGIN_GROUP)}
    distribution = named.get(first)
    return distribution.name if distribution else first


NOTHING = "nothing"
MOST_NUMBERS = 8
"""Arrays with more numbers are told by their shape and the first row."""


def sample_text(sample: Any) -> str:
    """A sample by its fields; `nothing` where none is sent.

    >>> from scaloft_fi.mutants.sample import Reading
    >>> sample_text(Reading(0.05, 1.0)), sample_text(None)
    ('stamp_s=0.05, value=1', 'nothing')
    """
    if sample is None:
        return NOTHING
    return ", ".join(f"{name}={_value(value)}" for name, value in zip(sample._fields, sample, strict=True))


def _value(value: Any) -> str:
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, int | float | np.number):
        return f"{float(value) + 0.0:.4g}"  # -0.0 + 0.0 is 0.0
    if isinstance(value, np.ndarray):
        if value.size <= MOST_NUMBERS:
            return f"[{', '.join(map(_value, value.tolist()))}]"
        first = f"[{', '.join(map(_value, np.atleast_2d(value)[0].tolist()[:MOST_NUMBERS]))}]"
        return f"{' x '.join(map(str, value.shape))}, first row {first}"
    if hasattr(value, "_fields"):
        return f"({sample_text(value)})"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return str(value)


OVERVIEW = {"operator": "name", "arguments": "signature", "needs": "needs", "seams": "fits", "what it does": "summary"}


@dataclass(frozen=True)
class ListedArgument:
    """An argument.

    Attributes:
        name: its name.
        kind: what it is.
        unit: its unit; empty for none.
        range: what is allowed, in words.
        least: least number; null: nothing bounds it, or it is no number.
        above: every number is above this; null: nothing bounds it, or it is no number.
        most: greatest number; null: nothing bounds it, or it is no number.
        choices: the allowed texts; empty for any.
        required: whether a fault must give it.
        default: its value when it is left out; null where it is required.
    """

    name: str
    kind: str
    unit: str
    range: str
    least: float | None
    above: float | None
    most: float | None
    choices: tuple[str, ...]
    required: bool
    default: Any

    def __str__(self) -> str:
        unit = f" [{self.unit}]" if self.unit else ""
        default = "" if self.required else f", {_said(self.default) or 'nothing'} when left out"
        return f"{self.name}: {self.range or self.kind}{unit}{default}"


@dataclass(frozen=True)
class GivenArgument:
    """An argument.

    Attributes:
        name: its name.
        value: its value.
    """

    name: str
    value: Any

    def __str__(self) -> str:
        return f"{self.name}={_said(self.value)}"


@dataclass(frozen=True)
class Poll:
    """A poll.

    Attributes:
        t_s: time [s].
        sent: the sample that is sent.
        arrives: the sample that arrives.
    """

    t_s: float
    sent: str
    arrives: str

    def __str__(self) -> str:
        same = self.arrives == self.sent != NOTHING
        return f"{self.t_s:g} s: {self.sent} -> {'the same' if same else self.arrives}"


@dataclass(frozen=True)
class ListedOperator(Entry):
    """An operator.

    Attributes:
        summary: what it does, in a sentence.
        about: all that it says of itself.
        arguments: its arguments.
        needs: what it needs of a message.
        seams: the seams of this study that it fits.
        cells: the cells that use it.
        at_events: whether it can strike at events of the flight.
        package: the installed package that declares it.
        message: type of the samples of its example.
        rate_hz: how often the seam of its example is polled [Hz].
        given: the arguments of its example.
        polls: its example; of a random operator one draw.
    """

    summary: str
    about: str
    arguments: tuple[ListedArgument, ...]
    needs: str
    seams: tuple[str, ...]
    cells: tuple[str, ...]
    at_events: bool
    package: str
    message: str
    rate_hz: float
    given: tuple[GivenArgument, ...]
    polls: tuple[Poll, ...]
    KEYS: ClassVar = (
        *("name", "summary", "about", "arguments", "needs", "seams", "cells", "at_events", "package"),
        *("message", "rate_hz", "given", "polls", "signature", "fits"),
    )

    @property
    def signature(self) -> str:
        """Names of the arguments, in brackets those that may be left out."""
        return ", ".join(one.name if one.required else f"[{one.name}]" for one in self.arguments)

    @property
    def fits(self) -> int:
        """How many seams."""
        return len(self.seams)

    def sheet(self) -> Sequence[tuple[str, str]]:
        """The operator whole."""
        return [
            ("does", self.about),
            *(("arguments", str(argument)) for argument in self.arguments),
            ("needs", self.needs),
            ("fits the seams", ", ".join(self.seams) or "none of this study"),
            ("cells", ", ".join(self.cells)),
            ("at events", "yes: a phase such as #waypoint is allowed" if self.at_events else ""),
            ("declared by", self.package),
            ("example", f"{self.message} at {self.rate_hz:g} Hz, {', '.join(map(str, self.given)) or 'no arguments'}"),
            *(("polls", str(poll)) for poll in self.polls),
        ]


@dataclass(frozen=True)
class Operators:
    """The operators that faults can use.

    Attributes:
        operators: the operators.
    """

    operators: tuple[ListedOperator, ...]


FORM = Output("operators", "1.0", Operators, rows="operators")
_KINDS = {
    float: "number",
    int: "whole number",
    str: "text",
    bool: "true or false",
    object: "number, text, true or false",
}
_OF_FIELD = ("amount", "sigma", "value")
"""Arguments in the unit of the field that the argument `field` names."""


def operator_list(study: Study) -> Listing[ListedOperator]:
    """Every operator that the installed packages and the study's stack declare.

    Raises:
        InputError: a part of the study cannot be read.
    """
    matrix, stack = study.matrix, study.stack  # reading the stack declares its own operators
    listed = tuple(
        ListedOperator(
            name=name,
            summary=one.summary,
            about=" ".join(inspect.cleandoc(one.make.__doc__ or "").split()),
            arguments=tuple(map(argument_facts, one.arguments.values())),
            needs=one.need.words,
            seams=tuple(seam.name for seam in stack.seams if one.need.met_by(seam.message)),
            cells=tuple(cell.name for cell in matrix if any(fault.operator == name for fault in cell.faults)),
            at_events=one.awaits_events,
            package=package_of(one.make),
            message=one.example.message.__name__,
            rate_hz=one.example.rate_hz,
            given=tuple(GivenArgument(*each) for each in one.example.arguments.items()),
            polls=tuple(_polls(one)),
        )
        for name in sorted(OPERATORS)
        for one in [OPERATORS[name]]
    )
    notes = (
        f"seams: how many of the stack {stack.name} it fits.",
        "`scaloft-fi operators NAME` shows one whole, with an example.",
    )
    return Listing("operator", f"Operators: {len(listed)}", OVERVIEW, listed, FORM, notes)


def _polls(operator: Operator) -> Iterator[Poll]:
    example = operator.example
    tap = operator.tap(example.context(), example.arguments)
    for place, sample in enumerate(example.before):
        t_s = place / example.rate_hz
        yield Poll(round(t_s, 6), sample_text(sample), sample_text(tap(t_s, sample)))


def argument_facts(argument: Argument) -> ListedArgument:
    """What is told of an argument of an operator."""
    allowed = argument.allowed
    bounds = (allowed.least, allowed.above, allowed.most)
    least, above, most = (bound if math.isfinite(bound) else None for bound in bounds)
    words = number_range(least, most)
    if above is not None:
        words = f"above {above:g}" + (f", up to {most:g}" if most is not None else "")
    numeric = argument.kind in (float, int)
    if argument.field is not None:
        words = "a field of numbers, or all" if argument.field.number else "a field, or all"
    elif argument.choices:
        words = "one of " + ", ".join(choice or '""' for choice in argument.choices)
    elif not numeric:
        words = ""
    return ListedArgument(
        name=argument.name,
        kind=_KINDS[argument.kind],
        unit=_unit(argument),
        range=words,
        least=least if numeric else None,
        above=above if numeric else None,
        most=most if numeric else None,
        choices=tuple(argument.choices),
        required=argument.required,
        default=None if argument.required else argument.default,
    )


def _unit(argument: Argument) -> str:
    if argument.of_field or argument.name in _OF_FIELD:
        return "of the field"
    if argument.kind not in (float, int):
        return ""
    return UNITS.get(argument.name.rpartition("_")[2], "") if "_" in argument.name else ""


def _said(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, int | float) else str(value)


@verb(
    "operators",
    examples=(
        ("List all operators", "scaloft-fi operators"),
        ("Show one whole, with its example", "scaloft-fi operators delay"),
        ("Write those that begin with `drop` as JSON", "scaloft-fi operators 'drop*' --format json"),
    ),
)
def operators_command(
    study: Study, names: Annotated[tuple[str, ...], Option("", "", metavar="[NAME]...", complete=operators)] = ()
) -> Answer:
    """List the operators that faults can use.

    Without a NAME an overview; NAME, or a pattern with *, ? or [, shows these whole: arguments with units and
    ranges, the seams of this study that it fits, the package that declares it, and samples before and after it.
    """
    return operator_list(study).answer(names)
