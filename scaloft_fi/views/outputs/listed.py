"""Every form of JSON that a verb prints, by verb; a verb with a form of its own gets a line here."""

from __future__ import annotations

import json
from importlib import import_module

from scaloft_fi.views.outputs.output import Output

OUTPUTS: dict[str, str] = {
    "new": "scaloft_fi.views.runs.written:NEW",
    "matrix": "scaloft_fi.views.worksheet.matrix_record:MATRIX",
    "mutants": "scaloft_fi.views.mutant_record:MUTANTS",
    "signals": "scaloft_fi.views.lists.signals:FORM",
    "seams": "scaloft_fi.views.lists.seams:FORM",
    "operators": "scaloft_fi.views.lists.operators:FORM",
    "axes": "scaloft_fi.views.lists.axes:FORM",
    "map": "scaloft_fi.views.pictures.situation_plan:MAP",
    "run": "scaloft_fi.views.score.score_form:RUN",
    "margin": "scaloft_fi.views.worksheet.margin_record:MARGIN",
    "seek": "scaloft_fi.views.runs.seek_record:SEEK",
    "merge": "scaloft_fi.views.runs.merged:MERGE",
    "replay": "scaloft_fi.views.flights.replayed:REPLAY",
    "check": "scaloft_fi.views.checks:CHECK",
    "status": "scaloft_fi.views.flights.status:STATUS",
    "score": "scaloft_fi.views.score.score_form:SCORE",
    "kills": "scaloft_fi.views.kills.kill_record:KILLS",
    "coverage": "scaloft_fi.views.coverage.coverage_record:COVERAGE",
    "worksheet": "scaloft_fi.views.worksheet.worksheet_record:WORKSHEET",
    "dispositions": "scaloft_fi.views.dispositions:DISPOSITIONS",
    "report": "scaloft_fi.views.report.written:REPORT",
    "diff": "scaloft_fi.views.flights.compare:DIFF",
    "export": "scaloft_fi.views.flights.export:EXPORT",
    "judge": "scaloft_fi.views.flights.judged:JUDGE",
    "doctor": "scaloft_fi.views.runs.installation:DOCTOR",
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
