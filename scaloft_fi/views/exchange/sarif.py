"""What is not detected as SARIF 2.1.0: code scanning shows each mutant on the line of its cell of the HAZOP matrix.

What is undecided is a note, what is not detected or not tested is a warning.
"""

from __future__ import annotations

from typing import Any
from urllib.parse import quote

from scaloft_fi.analysis.scoring.detection import Verdict
from scaloft_fi.analysis.scoring.mutant_score import MutantScore
from scaloft_fi.views.exchange.dossier import Dossier
from scaloft_fi.views.exchange.format import export_format

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


@export_format("sarif", "what is not detected on the lines of the HAZOP matrix, SARIF 2.1.0")
def sarif(dossier: Dossier) -> dict[str, Any]:
    """The log as plain JSON values: a rule is a cell whose mutant is not detected, a result is that mutant."""
    mutants = dossier.of(Verdict.UNDECIDED, Verdict.NOT_DETECTED, Verdict.NOT_TESTED)
    cells = list(dict.fromkeys(dossier.cell(mutant).name for mutant in mutants))
    rules = [
        {
            "id": name,
            "shortDescription": {"text": dossier.matrix.cell(name).deviation or name},
            "fullDescription": {"text": dossier.matrix.cell(name).effect or name},
            "help": {"text": f"scaloft-fi matrix --cell {name}"},
        }
        for name in cells
    ]
    driver = {"name": "scaloft-fi", "version": dossier.version, "rules": rules}
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "results": [_result(dossier, mutant, cells.index(dossier.cell(mutant).name)) for mutant in mutants],
    }
    return {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}


def _result(dossier: Dossier, mutant: MutantScore, rule: int) -> dict[str, Any]:
    name, line = dossier.place(mutant)
    region = {"startLine": line}
    return {
        "ruleId": dossier.cell(mutant).name,
        "ruleIndex": rule,
        "level": "note" if mutant.verdict is Verdict.UNDECIDED else "warning",
        "message": {"text": f"{mutant.subject.id} is {dossier.verdict(mutant)}{dossier.find_told(mutant)}."},
        "locations": [
            {"physicalLocation": {"artifactLocation": {"uri": quote(name, errors="surrogateescape")}, "region": region}}
        ],
        "partialFingerprints": {"mutant/v1": mutant.subject.id},
    }
