"""`scaloft-fi operators`: list the study's operators, without flying."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from scaloft_fi.mutants.operator import Argument, Operator
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.registry import PLUGIN_GROUP
from scaloft_fi.stack.declaration import UNITS
from scaloft_fi.verbs.listing import Listing, Record, number_range, tell_listing
from scaloft_fi.verbs.names import operators
from scaloft_fi.verbs.options import Option, StudyFolder, TableFormat, TablesFolder
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Output, anything, count, flag, listing, number, optional, record, text, texts

if TYPE_CHECKING:
    from scaloft_fi.study import Study


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


def example_of(operator: Operator) -> list[dict[str, Any]]:
    """The polls of an operator's example: time [s], what is sent, what arrives; of a random operator one draw."""
    example = operator.example
    tap = operator.tap(example.context(), example.arguments)
    polls = ((place / example.rate_hz, sample) for place, sample in enumerate(example.before))
    return [
        {"t_s": round(t_s, 6), "sent": sample_text(sample), "arrives": sample_text(tap(t_s, sample))}
        for t_s, sample in polls
    ]


OVERVIEW = {
    "operator": "name",
    "arguments": "signature",
    "needs": "needs",
    "seams": "fits",
    "what it does": "summary",
}
_BOUND = "nothing bounds it, or it is no number"
_ARGUMENT = record(
    "an argument",
    {
        "name": text("its name"),
        "kind": text("what it is"),
        "unit": text("its unit; empty for none"),
        "range": text("what is allowed, in words"),
        "least": optional(number("least number"), _BOUND),
        "above": optional(number("every number is above this"), _BOUND),
        "most": optional(number("greatest number"), _BOUND),
        "choices": texts("the allowed texts; empty for any"),
        "required": flag("whether a fault must give it"),
        "default": anything("its value when it is left out; null where it is required"),
    },
)
_POLL = record(
    "a poll",
    {
        "t_s": number("time", "s"),
        "sent": text("the sample that is sent"),
        "arrives": text("the sample that arrives"),
    },
)
FORM = Output(
    "operators",
    "1.0",
    "the operators that faults can use",
    {
        "operators": listing(
            "the operators",
            record(
                "an operator",
                {
                    "name": text("its name"),
                    "summary": text("what it does, in a sentence"),
                    "about": text("all that it says of itself"),
                    "arguments": listing("its arguments", _ARGUMENT),
                    "needs": text("what it needs of a message"),
                    "seams": texts("the seams of this study that it fits"),
                    "cells": texts("the cells that use it"),
                    "at_events": flag("whether it can strike at events of the flight"),
                    "package": text("the installed package that declares it"),
                    "message": text("type of the samples of its example"),
                    "rate_hz": number("how often the seam of its example is polled", "Hz"),
                    "given": listing(
                        "the arguments of its example",
                        record("an argument", {"name": text("its name"), "value": anything("its value")}),
                    ),
                    "polls": listing("its example; of a random operator one draw", _POLL),
                    "signature": text("names of the arguments, in brackets those that may be left out"),
                    "fits": count("how many seams"),
                },
            ),
        )
    },
    rows="operators",
)
_KINDS = {
    float: "number",
    int: "whole number",
    str: "text",
    bool: "true or false",
    object: "number, text, true or false",
}
_OF_FIELD = ("amount", "sigma", "value")
"""Arguments in the unit of the field that the argument `field` names."""


def operator_list(study: Study) -> Listing:
    """Every operator that the installed packages and the study's stack declare; `FORM` says what a record has.

    Raises:
        InputError: a part of the study cannot be read.
    """
    matrix, seams = study.matrix, study.stack.seams  # reading the stack declares its own operators
    used: dict[str, list[str]] = {}
    for cell in matrix:
        for fault in cell.faults:
            used.setdefault(fault.operator, []).append(cell.name)
    records = []
    for name in sorted(OPERATORS):
        one = OPERATORS[name]
        fits = [seam.name for seam in seams if one.need.met_by(seam.message)]
        records.append(_record(one, fits, list(dict.fromkeys(used.get(name, ())))))
    notes = (
        f"seams: how many of the stack {study.stack.name} it fits.",
        "`scaloft-fi operators NAME` shows one whole, with an example.",
    )
    return Listing("operator", f"Operators: {len(records)}", OVERVIEW, tuple(records), _sheet, FORM, notes)


def argument_facts(argument: Argument) -> dict[str, Any]:
    """An argument of an operator as plain JSON values."""
    allowed = argument.allowed
    least, above, most = map(_finite, (allowed.least, allowed.above, allowed.most))
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
    return {
        "name": argument.name,
        "kind": _KINDS[argument.kind],
        "unit": _unit(argument),
        "range": words,
        "least": least if numeric else None,
        "above": above if numeric else None,
        "most": most if numeric else None,
        "choices": list(argument.choices),
        "required": argument.required,
        "default": None if argument.required else argument.default,
    }


def _finite(bound: float) -> float | None:
    return bound if math.isfinite(bound) else None


def _unit(argument: Argument) -> str:
    if argument.of_field or argument.name in _OF_FIELD:
        return "of the field"
    if argument.kind not in (float, int):
        return ""
    return UNITS.get(argument.name.rpartition("_")[2], "") if "_" in argument.name else ""


def _record(one: Operator, seams: list[str], cells: list[str]) -> Record:
    arguments = [argument_facts(argument) for argument in one.arguments.values()]
    return {
        "name": one.name,
        "summary": one.summary,
        "about": " ".join(inspect.cleandoc(one.make.__doc__ or "").split()),
        "arguments": arguments,
        "needs": one.need.words,
        "seams": seams,
        "cells": cells,
        "at_events": one.awaits_events,
        "package": package_of(one.make),
        "message": one.example.message.__name__,
        "rate_hz": one.example.rate_hz,
        "given": [{"name": name, "value": value} for name, value in one.example.arguments.items()],
        "polls": example_of(one),
        "signature": ", ".join(name if argument.required else f"[{name}]" for name, argument in one.arguments.items()),
        "fits": len(seams),
    }


def _sheet(one: Record) -> list[tuple[str, str]]:
    given = ", ".join(f"{each['name']}={_said(each['value'])}" for each in one["given"]) or "no arguments"
    return [
        ("does", one["about"]),
        *(("arguments", _argument(argument)) for argument in one["arguments"]),
        ("needs", one["needs"]),
        ("fits the seams", ", ".join(one["seams"]) or "none of this study"),
        ("cells", ", ".join(one["cells"])),
        ("at events", "yes: a phase such as #waypoint is allowed" if one["at_events"] else ""),
        ("declared by", one["package"]),
        ("example", f"{one['message']} at {one['rate_hz']:g} Hz, {given}"),
        *(("polls", f"{poll['t_s']:g} s: {poll['sent']} -> {_arrives(poll)}") for poll in one["polls"]),
    ]


def _arrives(poll: dict[str, Any]) -> str:
    same = poll["arrives"] == poll["sent"] != "nothing"
    return "the same" if same else str(poll["arrives"])


def _argument(argument: dict[str, Any]) -> str:
    unit = f" [{argument['unit']}]" if argument["unit"] else ""
    default = "" if argument["required"] else f", {_said(argument['default']) or 'nothing'} when left out"
    return f"{argument['name']}: {argument['range'] or argument['kind']}{unit}{default}"


def _said(value: Any) -> str:
    return (
        f"{value:g}"
        if isinstance(value, int | float) and not isinstance(value, bool)
        else str(value).lower()
        if isinstance(value, bool)
        else str(value)
    )


@verb(
    "operators",
    examples=(
        ("List all operators", "scaloft-fi operators"),
        ("Show one whole, with its example", "scaloft-fi operators delay"),
        ("Write those that begin with `drop` as JSON", "scaloft-fi operators 'drop*' --format json"),
    ),
)
def operators_command(
    *,
    names: Annotated[tuple[str, ...], Option("", "", metavar="[NAME]...", complete=operators)] = (),
    study_folder: StudyFolder,
    style: TableFormat,
    tables_folder: TablesFolder,
) -> None:
    """List the operators that faults can use.

    Without a NAME an overview; NAME, or a pattern with *, ? or [, shows these whole: arguments with units and
    ranges, the seams of this study that it fits, the package that declares it, and samples before and after it.
    """
    tell_listing(operator_list, names, style, study_folder, tables=tables_folder)
