"""Answers of verbs, held against the forms that they declare."""

from __future__ import annotations

import csv
import io
import json
from typing import Any

from jsonschema import Draft202012Validator

from scaloft_fi.reference import output_of

READERS: tuple[tuple[str, ...], ...] = (
    ("matrix",),
    ("matrix", "--grid"),
    ("matrix", "--cell", "LATE-human"),
    ("matrix", "--margins", "--parameter", "human"),
    ("mutants", "--cell", "LATE-human"),
    ("mutants", "--check"),
    ("signals",),
    ("signals", "speed_mps"),
    ("seams",),
    ("operators",),
    ("axes",),
    ("axes", "--grid", "search"),
    ("status",),
    ("score",),
    ("kills",),
    ("kills", "--show", "suite", "--situation", "T0O0W0D0H?"),
    ("kills", "--show", "subsumption"),
    ("coverage",),
    ("dispositions",),
    ("worksheet",),
    ("diff", "CAMPAIGN", "CAMPAIGN"),
    ("doctor", "--no-flight"),
)
"""Verbs that print tables and fly nothing, on a campaign."""


def of_form(verb: str, text: str) -> dict[str, Any]:
    """The JSON that a verb printed, which has the verb's form."""
    told = json.loads(text)
    Draft202012Validator(output_of(verb).schema, format_checker=Draft202012Validator.FORMAT_CHECKER).validate(told)
    assert isinstance(told, dict)
    return told


def one_table(text: str) -> list[dict[str, str]]:
    """The rows of a CSV text that is one table: every row as long as the line of names."""
    names, *rows = list(csv.reader(io.StringIO(text, newline="")))
    assert {len(row) for row in rows} <= {len(names)}
    assert len(set(names)) == len(names)
    return [dict(zip(names, row, strict=True)) for row in rows]
