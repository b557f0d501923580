"""The campaign as a report of mutation-testing-report-schema 2, which mutation-testing-elements and others show.

A mutant stands in the file and on the line of its cell of the deviation matrix; the situations are its tests.  The
schema's statuses are fewer than ours: what was put to the test and not seen is `Survived`, what never changed a sample
is `NoCoverage`, what no ratio counts is `Ignored` with the reason.  So the score "of covered code" that its readers
compute, killed / (killed + survived), is the mutation score.
"""

from __future__ import annotations

from typing import Any

from scaloft_fi.results.exchange.dossier import Dossier, lives, verdict
from scaloft_fi.results.scoring.score import MutantScore
from scaloft_fi.results.status import Status

SCHEMA_VERSION = "2"
THRESHOLDS = {"high": 80, "low": 60}
"""Where readers turn the colour of a score: the defaults of StrykerJS."""

UNTESTED = {
    Status.BASELINE_RED: "Ignored",
    Status.MASKED: "Ignored",
    Status.NOT_INFECTED: "NoCoverage",
    Status.NOT_REACHED: "NoCoverage",
    Status.INVALID: "RuntimeError",
}
"""The projection of the statuses of mutants without an eligible situation."""


def mutation_testing(dossier: Dossier) -> dict[str, Any]:
    """The report as plain JSON values."""
    files: dict[str, dict[str, Any]] = {
        name: {"language": "yaml", "source": text, "mutants": []} for name, text in sorted(dossier.sources.items())
    }
    for mutant in (*dossier.score.mutants, *dossier.score.controls):
        name, line = dossier.place(mutant)
        files[name]["mutants"].append(_mutant(dossier, mutant, line))
    flown = {outcome.situation for outcome in dossier.outcomes}
    situations = sorted(flown, key=dossier.space.rank)
    return {
        "schemaVersion": SCHEMA_VERSION,
        "thresholds": dict(THRESHOLDS),
        "framework": {"name": "scaloft-fi", "version": dossier.version},
        "files": {name: file for name, file in files.items() if file["mutants"]},
        "testFiles": {
            "sim/situations.yaml": {
                "tests": [{"id": key, "name": f"{key}: {dossier.words(key)}"} for key in situations]
            }
        },
    }


def _mutant(dossier: Dossier, mutant: MutantScore, line: int) -> dict[str, Any]:
    cell = dossier.cell(mutant)
    status, reason = _status(mutant), verdict(mutant)
    if not dossier.roster.counts(mutant.subject):
        status, reason = "Ignored", f"in no ratio, only its cell's default is: {reason}"
    return {
        "id": mutant.subject.id,
        "mutatorName": cell.guideword,
        "description": cell.deviation,
        "replacement": mutant.subject.id,
        "location": {"start": {"line": line, "column": 1}, "end": {"line": line, "column": 1 + len(cell.guideword)}},
        "status": status,
        "statusReason": reason,
        "coveredBy": [result.situation for result in mutant.results if result.flown and not result.harmless],
        "killedBy": [result.situation for result in mutant.results if result.kills],
        "testsCompleted": sum(result.flown > 0 for result in mutant.results),
    }


def _status(mutant: MutantScore) -> str:
    if mutant.killed:
        return "Killed"
    return "Survived" if lives(mutant) else UNTESTED[mutant.status]
