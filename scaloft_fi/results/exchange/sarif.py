"""The survivors as SARIF 2.1.0, so that code scanning shows each on the line of its cell of the deviation matrix."""

from __future__ import annotations

from typing import Any
from urllib.parse import quote

from scaloft_fi.results.exchange.dossier import Dossier, verdict
from scaloft_fi.results.scoring.score import MutantScore

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


def sarif(dossier: Dossier) -> dict[str, Any]:
    """The log as plain JSON values: a rule is a cell with a survivor, a result is that survivor."""
    survivors = dossier.survivors
    cells = list(dict.fromkeys(dossier.cell(mutant).name for mutant in survivors))
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
        "results": [_result(dossier, mutant, cells.index(dossier.cell(mutant).name)) for mutant in survivors],
    }
    return {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}


def _result(dossier: Dossier, mutant: MutantScore, rule: int) -> dict[str, Any]:
    name, line = dossier.place(mutant)
    region = {"startLine": line}
    return {
        "ruleId": dossier.cell(mutant).name,
        "ruleIndex": rule,
        "level": "warning",
        "message": {"text": f"{mutant.subject.id} {verdict(mutant)}."},
        "locations": [{"physicalLocation": {"artifactLocation": {"uri": quote(name)}, "region": region}}],
        "partialFingerprints": {"mutant/v1": mutant.subject.id},
    }
