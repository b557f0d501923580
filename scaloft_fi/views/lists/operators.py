"""The operators that a study can use: arguments, what each needs of a message, where it fits, and its example."""

from __future__ import annotations

import inspect
import math
from typing import TYPE_CHECKING, Any

from scaloft_fi.mutants.operator import Argument, Operator
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.stack.declaration import UNITS
from scaloft_fi.views.lists.listing import Listing, Record, number_range
from scaloft_fi.views.lists.origin import package_of
from scaloft_fi.views.lists.samples import example_of
from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import anything, count, flag, listing, number, optional, record, text, texts

if TYPE_CHECKING:
    from scaloft_fi.study import Study

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
