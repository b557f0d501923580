"""What is not detected as SARIF 2.1.0: code scanning shows each mutant on the line of its cell of the HAZOP matrix.

What is undecided is a note, what is not detected or not tested is a warning.  The message ends with the commands that
fly the most telling flight again and that come next; the help of the rule, which viewers show beside it, and the
properties of the result have all steps.  An accepted survivor is suppressed, with who accepted it, why and until when.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from urllib.parse import quote

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.views.exchange.dossier import Dossier
from scaloft_fi.views.exchange.format import export_format
from scaloft_fi.views.exchange.steps import Step
from scaloft_fi.views.tables.literal import code

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


@export_format("sarif", "what is not detected on the lines of the HAZOP matrix, SARIF 2.1.0")
def sarif(dossier: Dossier) -> dict[str, Any]:
    """The log as plain JSON values: a rule is a cell whose mutant is not detected, a result is that mutant."""
    mutants = dossier.of(Verdict.UNDECIDED, Verdict.NOT_DETECTED, Verdict.NOT_TESTED)
    by_cell: dict[str, list[MutantScore]] = {}
    for mutant in mutants:
        by_cell.setdefault(dossier.cell(mutant).name, []).append(mutant)
    cells, rules = list(by_cell), [_rule(dossier, name, members) for name, members in by_cell.items()]
    driver = {"name": "scaloft-fi", "version": dossier.version, "rules": rules}
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "results": [_result(dossier, mutant, cells.index(dossier.cell(mutant).name)) for mutant in mutants],
    }
    return {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}


def _rule(dossier: Dossier, name: str, mutants: Sequence[MutantScore]) -> dict[str, Any]:
    """The rule of a cell, whose help says what to call about its mutants."""
    told = [Step("cell", "The deviation with its causes", f"scaloft-fi matrix --cell {name}")]
    told += [step for mutant in mutants for step in dossier.steps(mutant)]
    cell = dossier.matrix.cell(name)
    return {
        "id": name,
        "shortDescription": {"text": cell.deviation or name},
        "fullDescription": {"text": cell.effect or name},
        "help": {
            "text": "\n".join(f"{step.does}: {step.command}" for step in told),
            "markdown": "\n".join(f"- {step.does}: {code(step.command)}" for step in told),
        },
    }


def _message(dossier: Dossier, mutant: MutantScore) -> str:
    first = [step for step in dossier.steps(mutant) if step.name in ("replay", "next")]
    commands = "".join(f"  {step.does}: {step.command}." for step in first)
    return f"{mutant.subject.id} is {dossier.verdict(mutant)}.{commands}"


def _suppressions(dossier: Dossier, mutant: MutantScore) -> list[dict[str, Any]]:
    """Every result has the list (SARIF 2.1.0, 3.27.23); it is empty where nobody accepted the mutant."""
    justification = dossier.acceptance(mutant)
    return [{"kind": "external", "status": "accepted", "justification": justification}] if justification else []


def _result(dossier: Dossier, mutant: MutantScore, rule: int) -> dict[str, Any]:
    name, line = dossier.place(mutant)
    region = {"startLine": line}
    return {
        "ruleId": dossier.cell(mutant).name,
        "ruleIndex": rule,
        "level": "note" if mutant.verdict is Verdict.UNDECIDED else "warning",
        "message": {"text": _message(dossier, mutant)},
        "locations": [
            {"physicalLocation": {"artifactLocation": {"uri": quote(name, errors="surrogateescape")}, "region": region}}
        ],
        "suppressions": _suppressions(dossier, mutant),
        "partialFingerprints": {"mutant/v1": mutant.subject.id},
        "properties": {step.name: step.command for step in dossier.steps(mutant)},
    }
