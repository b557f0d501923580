"""The campaign as a report of mutation-testing-report-schema 2, which mutation-testing-elements and others show.

A mutant stands in the file and on the line of its cell of the deviation matrix; the situations are its tests, and
cover it where they put it to the test.  Its readers know two scores.  Their mutation score, killed / (killed + survived
+ no coverage), is ours: detected mutants of those flown.  Their score of covered code, killed / (killed + survived), is
detected mutants of those put to the test.  For that, of the default mutants of credible cells

- `Killed` is detected,
- `Survived` is put to the test and not detected, which undecided ones are too,
- `NoCoverage` is not put to the test,
- `Pending` is every one where there is no baseline pool to decide by: readers then show no score,

and accepted survivors and what no ratio counts (controls, other magnitudes) are `Ignored`: readers show the score
without accepted survivors.  The reason says more than the status.
"""

from __future__ import annotations

from typing import Any

from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.views.exchange.dossier import Dossier
from scaloft_fi.views.exchange.format import export_format

SCHEMA_VERSION = "2"
THRESHOLDS = {"high": 80, "low": 60}
"""Where readers turn the colour of a score: the defaults of StrykerJS."""


@export_format("mutation-testing", "mutation-testing-report-schema 2")
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
            dossier.grid_file: {"tests": [{"id": key, "name": f"{key}: {dossier.words(key)}"} for key in situations]}
        },
    }


def _mutant(dossier: Dossier, mutant: MutantScore, line: int) -> dict[str, Any]:
    cell = dossier.cell(mutant)
    return {
        "id": mutant.subject.id,
        "mutatorName": cell.guideword,
        "description": cell.deviation,
        "replacement": mutant.subject.id,
        "location": {"start": {"line": line, "column": 1}, "end": {"line": line, "column": 1 + len(cell.guideword)}},
        "status": _status(dossier, mutant),
        "statusReason": _reason(dossier, mutant),
        "coveredBy": [result.situation for result in mutant.results if result.tested],
        "killedBy": list(mutant.killing),
        "testsCompleted": len(mutant.results),
    }


def _status(dossier: Dossier, mutant: MutantScore) -> str:
    if not dossier.roster.counts(mutant.subject):
        return "Ignored"
    if not mutant.flown:
        return "RuntimeError"
    if not dossier.score.pooled:
        return "Pending"
    if mutant.detected:
        return "Killed"
    if dossier.acceptance(mutant):
        return "Ignored"
    return "Survived" if mutant.tested else "NoCoverage"


def _reason(dossier: Dossier, mutant: MutantScore) -> str:
    reason = dossier.verdict(mutant) + dossier.find_told(mutant)
    if dossier.roster.is_control(mutant.subject):
        return f"a control, in no ratio: {reason}"
    if accepted := dossier.acceptance(mutant):
        return f"{accepted}; {reason}"
    return reason if dossier.roster.counts(mutant.subject) else f"in no ratio, only its cell's default is: {reason}"
