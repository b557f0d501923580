"""The matrix as plain data: one record for each cell, as a HAZOP worksheet has its rows."""

from __future__ import annotations

from typing import Any

from scaloft_fi.hazop.matrix import Cell, Fault, Matrix, SeverityClass, class_of
from scaloft_fi.hazop.render import expectation, ladder, mark, yaml_text

HEADER = (
    "cell",
    "parameter",
    "guideword",
    "status",
    "deviation",
    "causes",
    "effect",
    "severity",
    "requirements",
    "reason",
    "predicted",
    "seam",
    "operator",
    "arguments",
    "magnitudes",
    "expected",
    "default_mutant",
)

SHORT_HEADER = ("parameter", "guideword", "default", "requirements", "deviation, or why it is not meaningful")


def record(cell: Cell, severity: SeverityClass | None) -> dict[str, Any]:
    """Return one cell and its class of severity as a JSON object."""
    return {
        "cell": cell.name,
        "guideword": cell.guideword,
        "parameter": cell.parameter,
        "status": str(cell.status),
        "deviation": cell.deviation,
        "causes": list(cell.causes),
        "effect": cell.effect,
        "severity": class_of(severity) or None,
        "requirements": list(cell.requirements),
        "reason": cell.reason,
        "predicted": cell.predicted,
        "default_mutant": _default_mutant(cell),
        "faults": [_fault_record(cell, fault) for fault in cell.faults],
    }


def rows(matrix: Matrix) -> list[list[str]]:
    """Return a row of texts for each cell, under `HEADER`; several entries of one column are joined by `; `."""
    return [
        [
            cell.name,
            cell.parameter,
            cell.guideword,
            str(cell.status),
            cell.deviation,
            "; ".join(cell.causes),
            cell.effect,
            class_of(matrix.severities.get(cell.name)),
            "; ".join(cell.requirements),
            cell.reason,
            cell.predicted,
            "; ".join(fault.seam for fault in cell.faults),
            "; ".join(fault.operator for fault in cell.faults),
            "; ".join(
                " ".join(f"{name}={yaml_text(value)}" for name, value in fault.arguments.items())
                for fault in cell.faults
            ),
            "; ".join(filter(None, map(ladder, cell.faults))),
            "; ".join(filter(None, map(expectation, cell.faults))),
            _default_mutant(cell),
        ]
        for cell in matrix
    ]


def short_rows(matrix: Matrix) -> list[list[str]]:
    """Return a row for each cell, under `SHORT_HEADER`."""
    return [[cell.parameter, cell.guideword, mark(cell), ", ".join(cell.requirements), cell.told] for cell in matrix]


def _default_mutant(cell: Cell) -> str:
    if not cell.faults:
        return ""
    first = cell.faults[0]
    return cell.mutant_ids(first, first.magnitude.default if first.magnitude else None)[0]


def _fault_record(cell: Cell, fault: Fault) -> dict[str, Any]:
    magnitude, expected = fault.magnitude, fault.expected
    return {
        "seam": fault.seam,
        "operator": fault.operator,
        "arguments": dict(fault.arguments),
        "magnitude": {
            "argument": magnitude.argument,
            "unit": magnitude.unit,
            "scale": magnitude.scale,
            "ladder": [magnitude.text(rung) for rung in magnitude.ladder],
            "default": magnitude.text(magnitude.default),
        }
        if magnitude
        else None,
        "phases": fault.phases,
        "expected": {
            "status": expected.status,
            "reason": expected.reason,
            "magnitudes": list(expected.magnitudes),
        }
        if expected
        else None,
        "mutants": [name for rung in fault.rungs for name in cell.mutant_ids(fault, rung)],
    }
