"""The argument over the campaign in goal structuring notation, as the YAML of gsn2x.

Every mutant flown that is not detected stands in it as a counter-goal against the claim it weakens: an argument that
hides what speaks against it convinces nobody.  A survivor that somebody accepted is justified by that, until the last
day of the acceptance; the goal over the others stays undeveloped.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import yaml

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.views.exchange.dossier import Dossier
from scaloft_fi.views.exchange.format import export_format
from scaloft_fi.views.score.answers import false_detections
from scaloft_fi.views.score.verdict import NO_POOL

COUNTER = {
    Verdict.UNDECIDED: "might not have been revealed",
    Verdict.NOT_DETECTED: "would not have been revealed",
    Verdict.NOT_TESTED: "was not put to the test",
}
"""What speaks against the suite, by the verdict on a mutant."""


@export_format("gsn", "the argument in goal structuring notation, for gsn2x")
def gsn(dossier: Dossier) -> str:
    """The argument as YAML text."""
    return yaml.safe_dump(nodes(dossier), sort_keys=False, allow_unicode=True, width=120)


def nodes(dossier: Dossier) -> dict[str, Any]:
    """The argument's nodes by id, the module's head among them."""
    names = ", ".join(requirement.name for requirement in dossier.requirements)
    argument: dict[str, Any] = {
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
        "C3": {"text": f"{len(dossier.score.mutants)} mutants from a HAZOP deviation matrix, seeds {_seeds(dossier)}"},
        "A1": {"text": "The simulator represents the operating environment (argued elsewhere)"},
        "S1": {
            "text": "Argue over the extent of coverage and over its power to reveal faults",
            "supportedBy": ["G2", "G3", "G4"],
        },
        "G2": {"text": _coverage(dossier), "supportedBy": ["Sn1"]},
        "Sn1": {"text": "Coverage table: scaloft-fi score"},
        **_detection(dossier),
    }
    counted = dossier.of(*COUNTER)
    if counted or not dossier.score.pooled:
        argument |= _justified(dossier, counted)
    else:
        argument["G4"] = {"text": "Every mutant flown is detected", "supportedBy": ["Sn3"]}
        argument["Sn3"] = {"text": "Verdict on every mutant: scaloft-fi score"}
    for number, mutant in enumerate(counted, start=1):
        argument[f"CG{number}"] = {
            "text": f"{mutant.subject.id} {COUNTER[mutant.verdict]}{_severity(mutant)}",
            "challenges": "G3",
            "supportedBy": [f"CSn{number}"],
        }
        argument[f"CSn{number}"] = {"text": f"{mutant.subject.id} is {dossier.verdict(mutant)}"}
    return argument


def _severity(mutant: MutantScore) -> str:
    """As in: ` (severity: injury, a person may be hurt)`; empty where its cell has no class."""
    severity = mutant.severity
    return f" (severity: {severity.id}, {severity.title})" if severity else ""


def _justified(dossier: Dossier, counted: Sequence[MutantScore]) -> dict[str, Any]:
    """The goal over the mutants that are not detected: a goal for each that was accepted, one for all others."""
    text, accepted = "Each mutant that is not detected is justified", [m for m in counted if dossier.acceptance(m)]
    if not accepted:
        return {"G4": {"text": text, "undeveloped": True}}
    found: dict[str, Any] = {}
    for number, mutant in enumerate(accepted):
        goal, solution = f"G{5 + number}", f"Sn{4 + number}"
        found[goal] = {"text": f"That {mutant.subject.id} is not detected is justified", "supportedBy": [solution]}
        found[solution] = {"text": f"hazop/dispositions.yaml: {dossier.acceptance(mutant)}"}
    if others := len(counted) - len(accepted):
        found[f"G{5 + len(accepted)}"] = {"text": f"{others} other mutants are justified", "undeveloped": True}
    return {"G4": {"text": text, "supportedBy": [name for name in found if name.startswith("G")]}, **found}


def _coverage(dossier: Dossier) -> str:
    """Of the grid, with the largest strength of which every combination was flown; where there is none, with each."""
    covered = dossier.coverage
    whole = [strength for strength, ratio in covered.t_way if ratio.part == ratio.whole > 0]
    flown = f"{covered.situations} of the situations were flown"
    if whole:
        every = f"combination of the values of any {max(whole)} axes" if max(whole) > 1 else "value of every axis"
        return f"{flown}, among them every {every}"
    parts = ", ".join(f"{strength}-way {ratio}" for strength, ratio in covered.t_way)
    return f"{flown}, of the combinations of their values {parts}"


def _detection(dossier: Dossier) -> dict[str, Any]:
    """The claim over the mutants, and what it rests on; nothing where there is no pool to decide by."""
    scored = dossier.score
    if not scored.pooled:
        return {"G3": {"text": f"The suite detects faults (no verdict: {NO_POOL})", "undeveloped": True}}
    claim = (
        f"The suite detects {scored.mutation_score} of the mutants flown, {scored.firm.part} without any one seed too"
    )
    rule = "more violations of a safety requirement than chance explains, beside the unmutated drone's own flights"
    return {
        "G3": {
            "text": claim,
            "supportedBy": ["Sn2"],
            "inContextOf": ["C4", "C5"],
        },
        "C4": {"text": f"Detected: {rule} (exact stratified test, alpha {scored.alpha:g})"},
        "C5": {"text": false_detections(scored.alpha, scored.tested.part)},
        "Sn2": {"text": "Verdicts and kills: scaloft-fi score; every flight: scaloft-fi export"},
    }


def _seeds(dossier: Dossier) -> str:
    return ", ".join(map(str, dossier.seeds)) or "none"
