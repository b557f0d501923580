"""Every form of JSON that a verb prints, by verb; a verb with a form of its own gets a line here."""

from __future__ import annotations

import json
from importlib import import_module

from scaloft_fi.views.outputs.output import Output

OUTPUTS: dict[str, str] = {
    "map": "scaloft_fi.views.pictures.situation_plan:MAP",
    "check": "scaloft_fi.views.checks:CHECK",
    "status": "scaloft_fi.views.flights.status:STATUS",
    "dispositions": "scaloft_fi.views.dispositions:DISPOSITIONS",
    "coverage": "scaloft_fi.views.coverage.coverage_record:COVERAGE",
    "diff": "scaloft_fi.views.flights.compare:DIFF",
    "judge": "scaloft_fi.views.flights.judged:JUDGE",
}
"""In the order of the pipeline: where each is declared."""


def output_of(verb: str) -> Output:
    """The form of a verb's JSON.

    Raises:
        KeyError: the verb has none.
    """
    module, name = OUTPUTS[verb].split(":")
    output = getattr(import_module(module), name)
    assert isinstance(output, Output)
    return output


def schema_texts() -> dict[str, str]:
    """The published JSON Schemas: the text of each file by its name."""
    return {f"{one.verb}.json": json.dumps(one.schema, indent=2, ensure_ascii=False) + "\n" for one in outputs()}


def outputs() -> tuple[Output, ...]:
    """Every form."""
    return tuple(map(output_of, OUTPUTS))
