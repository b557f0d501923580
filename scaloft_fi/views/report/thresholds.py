"""The margins of a campaign for the page, situation by situation, each beside what it is measured against."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from scaloft_fi.analysis.margin import Margin, lowest, margins
from scaloft_fi.analysis.score import Score
from scaloft_fi.analysis.survivor import FAILING, PhasedFault, Tried
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind, Requirement
from scaloft_fi.views.worksheet.margin_text import finite, margin_text


def thresholds(
    outcomes: Iterable[Outcome], scored: Score, cells: Matrix, requirements: Sequence[Requirement]
) -> list[dict[str, Any]]:
    """Every fault with an order of which some situation has two magnitudes, in the matrix's order of cells.

    Returns:
        Per fault `least`, its margin over all situations, `against`, the names of the requirements that are violated,
        else of those that its cell puts at risk, and per situation the ends of its margin, with the robustness of those
        requirements at both, null where none was put to the test.
    """
    by_fault = margins(outcomes, scored, cells)
    safety = [requirement.name for requirement in requirements if requirement.kind is Kind.SAFETY]
    order = {cell.name: place for place, cell in enumerate(cells)}
    several = [(fault, own) for fault, own in by_fault.items() if any(len(margin.tried) > 1 for margin in own)]
    several.sort(key=lambda entry: (order[entry[0].cell], entry[0].unit, entry[0].phase_s, entry[0].event))
    return [_entry(fault, own, cells, safety) for fault, own in several]


def _entry(fault: PhasedFault, listed: Sequence[Margin], cells: Matrix, safety: Sequence[str]) -> dict[str, Any]:
    tried = [tried for margin in listed for tried in margin.tried if tried.reaction in FAILING]
    violated = {name for one in tried for name in one.requirements}
    at_risk = cells.cell(fault.cell).requirements
    against = [name for name in safety if name in (violated or at_risk)] or list(safety)
    least = lowest(listed)
    known = [margin for margin in listed if margin.known]
    return {
        "fault": str(fault),
        "cell": fault.cell,
        "unit": fault.unit,
        "worse": known[0].scale.sign if known else 1,
        "least": margin_text(least) if least else "",
        "situations_flown": len(listed),
        "against": against,
        "situations": [_situation(margin, against) for margin in known],
    }


def _situation(margin: Margin, against: Sequence[str]) -> dict[str, Any]:
    (key,) = margin.situations
    at = {tried.magnitude: tried for tried in margin.tried}
    survivor, strong = (at.get(end) if end is not None else None for end in (margin.survives, margin.end))
    return {
        "key": key,
        "margin": margin_text(margin),
        "survives": finite(margin.survives),
        "seen": finite(margin.seen),
        "kills": finite(margin.kills),
        "by": list(strong.requirements) if strong else [],
        "rho": {name: [_rho(survivor, name), _rho(strong, name)] for name in against},
        "again": [finite(magnitude) for magnitude in margin.again],
        "flown": [finite(magnitude) for magnitude in sorted(at, key=margin.scale.strength)],
    }


def _rho(tried: Tried | None, requirement: str) -> float | str | None:
    rho: Mapping[str, float] = dict(tried.rho) if tried else {}
    return finite(rho.get(requirement))
