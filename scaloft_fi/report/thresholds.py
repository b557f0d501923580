"""The margins of a campaign for the page, situation by situation, each beside what it is measured against."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.mutants.mutant import parse, split_magnitude
from scaloft_fi.results.kills.kill_matrix import KillMatrix
from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.requirement import Kind, Requirement
from scaloft_fi.results.worksheet.margin import Margin, Subject, Tried, lowest, margins


def thresholds(
    outcomes: Iterable[Outcome], cells: Matrix, matrix: KillMatrix, requirements: Sequence[Requirement]
) -> list[dict[str, Any]]:
    """Every fault with an order of which some situation has two magnitudes, in the matrix's order of cells.

    Returns:
        Per fault `least`, its margin over all situations, `against`, the names of the requirements that kill it, else
        of those that its cell puts at risk, and per situation the ends of its margin, with the robustness of those
        requirements at both, null where none was flown; `counts` is false where the scores count no kill.
    """
    found = margins(outcomes, cells)
    counted = _counted(matrix)
    safety = [requirement.name for requirement in requirements if requirement.kind is Kind.SAFETY]
    order = {cell.name: place for place, cell in enumerate(cells)}
    searched = [
        (subject, listed) for subject, listed in found.items() if any(len(margin.tried) > 1 for margin in listed)
    ]
    searched.sort(key=lambda entry: (order[entry[0].cell], entry[0].unit, entry[0].phase_s))
    return [_entry(subject, listed, cells, safety, counted) for subject, listed in searched]


def _counted(matrix: KillMatrix) -> set[tuple[Subject, float, str]]:
    """Fault, magnitude and situation of every kill that the scores count."""
    found: set[tuple[Subject, float, str]] = set()
    for row in matrix.mutants:
        name = parse(row.id)
        magnitude, unit = split_magnitude(name.magnitude)
        if not isinstance(magnitude, str):
            found |= {(Subject(name.cell, unit, name.phase_s), magnitude, key) for key in row.kills}
    return found


def _entry(
    subject: Subject,
    listed: Sequence[Margin],
    cells: Matrix,
    safety: Sequence[str],
    counted: set[tuple[Subject, float, str]],
) -> dict[str, Any]:
    killers = {name for margin in listed for tried in margin.tried for name in tried.requirements}
    at_risk = cells.cell(subject.cell).requirements
    against = [name for name in safety if name in (killers or at_risk)] or list(safety)
    least = lowest(listed)
    told = [margin for margin in listed if margin.told]
    return {
        "fault": str(subject),
        "cell": subject.cell,
        "unit": subject.unit,
        "worse": told[0].scale.sign if told else 1,
        "least": str(least) if least else "",
        "situations_flown": len(listed),
        "against": against,
        "situations": [_situation(subject, margin, against, counted) for margin in told],
    }


def _situation(
    subject: Subject, margin: Margin, against: Sequence[str], counted: set[tuple[Subject, float, str]]
) -> dict[str, Any]:
    (key,) = margin.situations
    at = {tried.magnitude: tried for tried in margin.tried}
    survivor, kill = (at.get(end) if end is not None else None for end in (margin.survives, margin.kills))
    return {
        "key": key,
        "margin": str(margin),
        "survives": _plain(margin.survives),
        "kills": _plain(margin.kills),
        "by": list(kill.requirements) if kill else [],
        "rho": {name: [_rho(survivor, name), _rho(kill, name)] for name in against},
        "again": [_plain(magnitude) for magnitude in margin.again],
        "flown": [_plain(magnitude) for magnitude in sorted(at, key=margin.scale.severity)],
        "counts": margin.kills is None or (subject, margin.kills, key) in counted,
    }


def _rho(tried: Tried | None, requirement: str) -> float | str | None:
    rho: Mapping[str, float] = dict(tried.rho) if tried else {}
    return _plain(rho.get(requirement))


def _plain(value: float | None) -> float | str | None:
    """A number of JSON, which has no infinite ones."""
    return value if value is None or math.isfinite(value) else f"{value:g}"
