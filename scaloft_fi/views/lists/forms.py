"""The forms of the JSON that the lists of a study print, by what an entry is."""

from __future__ import annotations

from collections.abc import Mapping

from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import (
    Shape,
    anything,
    by_name,
    count,
    flag,
    listing,
    number,
    optional,
    record,
    text,
    texts,
)

_NO_BOUND = "there is no bound"
_IN_ITS_UNIT = "in its unit"
_BY_PATH = by_name("by path of a document of sim/, the value that is set", anything("a value of YAML"))


def _list(verb: str, about: str, each: str, keys: Mapping[str, Shape]) -> Output:
    return Output(verb, "1.0", about, {verb: listing(about, record(each, keys))}, rows=verb)


SIGNALS = _list(
    "signals",
    "the signals that the study's requirements and the predicates of its axes may use",
    "a signal",
    {
        "name": text("its name"),
        "unit": text("its unit; empty for none"),
        "meaning": text("what it is"),
        "origin": text("where it comes from"),
        "used_in": text("what may use it"),
        "range": text("what it can read, in words"),
        "least": optional(number(f"its least value, {_IN_ITS_UNIT}"), _NO_BOUND),
        "most": optional(number(f"its greatest value, {_IN_ITS_UNIT}"), _NO_BOUND),
        "beyond": text("what it reads where there is nothing to measure; empty where there always is"),
        "compare": text("with what it can be compared, where that is bounded; else empty"),
        "unknown": text("what it reads while nothing is known; empty where it is always known"),
        "recorded": text("where it stands in the record of a simulator outside; else empty"),
        "example": text("a formula that uses it"),
    },
)
SEAMS = _list(
    "seams",
    "the seams of the study's stack, where faults can be patched in",
    "a seam",
    {
        "name": text("its name"),
        "message": text("the type of its samples"),
        "about": text("what the message says of itself"),
        "edge": text("who sends, and who receives"),
        "rate_hz": number("how often it is polled", "Hz"),
        "fields": listing(
            "the fields of a sample",
            record(
                "a field",
                {
                    "name": text("its name"),
                    "kind": text("what it is, in words"),
                    "unit": text("its unit; empty for none"),
                },
            ),
        ),
        "acts_on": texts("the fields that the consumer acts on"),
        "canary": flag("whether `run --mutant` flies a control here"),
        "carried": text("who alters the samples where a command flies; empty where our wire does"),
        "operators": texts("names of the operators that fit"),
        "cells": texts("names of the cells that have a fault here"),
        "used_by": count("how many cells"),
        "fitting": count("how many operators"),
    },
)
OPERATORS = _list(
    "operators",
    "the operators that the study can use",
    "an operator",
    {
        "name": text("its name"),
        "summary": text("what it does, in half a sentence"),
        "about": text("all that it says of itself"),
        "arguments": listing(
            "its arguments",
            record(
                "an argument",
                {
                    "name": text("its name"),
                    "kind": text("what it is, in words"),
                    "unit": text("its unit; `of the field` where it has that of a field; empty for none"),
                    "range": text("what is allowed, in words"),
                    "least": optional(number(f"the least that is allowed, {_IN_ITS_UNIT}"), _NO_BOUND),
                    "above": optional(number(f"what it must be greater than, {_IN_ITS_UNIT}"), _NO_BOUND),
                    "most": optional(number(f"the greatest that is allowed, {_IN_ITS_UNIT}"), _NO_BOUND),
                    "choices": texts("the words that are allowed; empty where it is not one of some words"),
                    "required": flag("whether it must be given"),
                    "default": anything("its value when it is left out; null: it must be given"),
                },
            ),
        ),
        "needs": text("what it needs of a message, in words"),
        "seams": texts("names of the seams of this study that it fits"),
        "cells": texts("names of the cells that use it"),
        "at_events": flag("whether it may strike at events of the flight"),
        "package": text("the package that declares it"),
        "example": record(
            "the example that is its test",
            {
                "message": text("the type of the samples"),
                "rate_hz": number("how often the seam is polled", "Hz"),
                "arguments": by_name("arguments of the operator", anything("a value")),
                "polls": listing(
                    "poll by poll",
                    record(
                        "a poll",
                        {
                            "t_s": number("its time", "s"),
                            "sent": text("the sample that was sent"),
                            "arrives": text("the sample that arrives"),
                        },
                    ),
                ),
            },
        ),
        "signature": text("its arguments in brief"),
        "fits": count("how many seams of this study it fits"),
    },
)
AXES = _list(
    "axes",
    "the axes of the study's grid",
    "an axis",
    {
        "name": text("its id, as in keys of situations"),
        "title": text("what varies"),
        "category": text("of the operational design domain"),
        "kind": text("what it has", ("values", "range", "free")),
        "keys": texts("how keys of situations name its values"),
        "benign": text("its benign value, in words"),
        "summary": text("its values, in words"),
        "values": listing(
            "its values; of a range its bins, of a free axis none",
            record(
                "a value",
                {
                    "name": text("as in keys of situations"),
                    "title": text("what it is"),
                    "set": _BY_PATH,
                    "realised": text("the formula by which a flight is known to have met it, or words that say so"),
                },
            ),
        ),
        "distribution": text("how numbers are drawn; empty for single values"),
        "set": text("of a number, the path that it sets; else empty"),
        "realised": text("of a range, the formula by which a flight is known to have met it; else empty"),
        "unit": text("of a number, its unit; else empty"),
        "from": optional(number("of a number, the least", "its unit"), "it has single values"),
        "to": optional(number("of a number, the greatest", "its unit"), "it has single values"),
        "also": _BY_PATH,
        "only_with": by_name(
            "of a free axis, by another axis, with which of its values it goes", listing("ids", anything("an id"))
        ),
    },
)
FORMS: Mapping[str, Output] = {"signal": SIGNALS, "seam": SEAMS, "operator": OPERATORS, "axis": AXES}
