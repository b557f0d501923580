"""The argument over the campaign in goal structuring notation, as the YAML of gsn2x.

Claims carry exact (Clopper-Pearson) intervals.  Every survivor that nobody has justified stands in it as a counter-goal
against the claim it weakens: an argument that hides what speaks against it convinces nobody.
"""

from __future__ import annotations

from typing import Any

import yaml

from scaloft_fi.results.exchange.dossier import Dossier, verdict
from scaloft_fi.results.scoring.ratio import Ratio


def gsn(dossier: Dossier) -> str:
    """The argument as YAML text."""
    return yaml.safe_dump(nodes(dossier), sort_keys=False, allow_unicode=True, width=120)


def nodes(dossier: Dossier) -> dict[str, Any]:
    """The argument's nodes by id, the module's head among them."""
    scored, covered = dossier.score, dossier.coverage
    names = ", ".join(requirement.name for requirement in dossier.requirements)
    found: dict[str, Any] = {
        "module": {"name": "situation_coverage_and_fault_detection", "brief": f"Campaign {dossier.campaign}"},
        "G1": {
            "text": "The test cases sufficiently cover the operating scenarios (SACE artefact [E], activity 29)",
            "supportedBy": ["S1"],
            "inContextOf": ["C1", "C2", "C3", "A1"],
        },
        "C1": {
            "text": f"Operational domain model: {len(dossier.space.axes)} axes, {len(dossier.space.points)} situations"
        },
        "C2": {"text": f"Requirements in signal temporal logic: {names}"},
        "C3": {"text": f"{len(scored.mutants)} mutants from a HAZOP deviation matrix, seeds {_seeds(dossier)}"},
        "A1": {"text": "The simulator represents the operating environment (argued elsewhere)"},
        "S1": {
            "text": "Argue over the extent of coverage and over its power to reveal faults",
            "supportedBy": ["G2", "G3", "G4"],
        },
        "G2": {
            "text": f"{covered.situations.plain} of the situations were flown, and of the 3-way combinations of their "
            f"values {dict(covered.t_way).get(3, Ratio(0, 0)).plain}",
            "supportedBy": ["Sn1"],
        },
        "G3": {
            "text": f"The suite kills {_exact(scored.mutation_score)} of the mutants that it puts to the test",
            "supportedBy": ["Sn2"],
        },
        "Sn1": {"text": "Coverage table: scaloft-fi score"},
        "Sn2": {"text": "Kill matrix: scaloft-fi export"},
    }
    survivors = dossier.survivors
    if survivors:
        found["G4"] = {"text": "Each surviving mutant is justified", "undeveloped": True}
    else:
        found["G4"] = {"text": "No mutant that was put to the test survives", "supportedBy": ["Sn3"]}
        found["Sn3"] = {"text": "Status of every mutant: scaloft-fi score"}
    for number, mutant in enumerate(survivors, start=1):
        found[f"CG{number}"] = {
            "text": f"{mutant.subject.id} would not have been revealed",
            "challenges": "G3",
            "supportedBy": [f"CSn{number}"],
        }
        found[f"CSn{number}"] = {"text": f"{mutant.subject.id}: {verdict(mutant)}"}
    return found


def _exact(ratio: Ratio) -> str:
    if ratio.exact is None:
        return ratio.plain
    low, high = ratio.exact
    return f"{ratio.plain} (exact 95 % interval {100 * low:.0f} to {100 * high:.0f} %)"


def _seeds(dossier: Dossier) -> str:
    return ", ".join(map(str, dossier.seeds)) or "none"
