"""The matrix as plain data: one record for each cell, as a HAZOP worksheet has its rows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from scaloft_fi.hazop.matrix import Cell, Fault, Matrix, SeverityClass, class_of
from scaloft_fi.hazop.render import expectation, ladder, mark, yaml_text

SHORT_HEADER = ("parameter", "guideword", "default", "requirements", "deviation, or why it is not meaningful")


def record(cell: Cell, severity: SeverityClass | None) -> dict[str, Any]:
    """Return one cell and its class of severity as a JSON object."""
    return {
        "cell": cell.name,
        **{name: getattr(cell, name) for name in ("guideword", "parameter", "status", "deviation")},
        "causes": list(cell.causes),
        "effect": cell.effect,
        "severity": class_of(severity) or None,
        "requirements": list(cell.requirements),
        "reason": cell.reason,
        "predicted": cell.predicted,
        "default_mutant": cell.default_id if cell.faults else "",
        "faults": [_fault_record(cell, fault) for fault in cell.faults],
    }


def _arguments(fault: Fault) -> str:
    return " ".join(f"{name}={yaml_text(value)}" for name, value in fault.arguments.items())


_COLUMNS: Mapping[str, Callable[[Cell, Matrix], str]] = {
    "cell": lambda cell, _: cell.name,
    "parameter": lambda cell, _: cell.parameter,
    "guideword": lambda cell, _: cell.guideword,
    "status": lambda cell, _: str(cell.status),
    "deviation": lambda cell, _: cell.deviation,
    "causes": lambda cell, _: "; ".join(cell.causes),
    "effect": lambda cell, _: cell.effect,
    "severity": lambda cell, matrix: class_of(matrix.severities.get(cell.name)),
    "requirements": lambda cell, _: "; ".join(cell.requirements),
    "reason": lambda cell, _: cell.reason,
    "predicted": lambda cell, _: cell.predicted,
    "seam": lambda cell, _: "; ".join(fault.seam for fault in cell.faults),
    "operator": lambda cell, _: "; ".join(fault.operator for fault in cell.faults),
    "arguments": lambda cell, _: "; ".join(map(_arguments, cell.faults)),
    "magnitudes": lambda cell, _: "; ".join(filter(None, map(ladder, cell.faults))),
    "expected": lambda cell, _: "; ".join(filter(None, map(expectation, cell.faults))),
    "default_mutant": lambda cell, _: cell.default_id if cell.faults else "",
}
HEADER = tuple(_COLUMNS)


def rows(matrix: Matrix) -> list[list[str]]:
    """Return a row of texts for each cell, under `HEADER`; several entries of one column are joined by `; `."""
    return [[text(cell, matrix) for text in _COLUMNS.values()] for cell in matrix]


def short_rows(matrix: Matrix) -> list[list[str]]:
    """Return a row for each cell, under `SHORT_HEADER`."""
    return [[cell.parameter, cell.guideword, mark(cell), ", ".join(cell.requirements), cell.told] for cell in matrix]


def _fault_record(cell: Cell, fault: Fault) -> dict[str, Any]:
    magnitude, expected = fault.magnitude, fault.expected
    return {
        "seam": fault.seam,
        "operator": fault.operator,
        "arguments": dict(fault.arguments),
        "magnitude": magnitude
        and {
            **{name: getattr(magnitude, name) for name in ("argument", "unit", "scale")},
            "ladder": [magnitude.text(rung) for rung in magnitude.ladder],
            "default": magnitude.text(magnitude.default),
        },
        "phases": fault.phases,
        "expected": expected
        and {"status": expected.status, "reason": expected.reason, "magnitudes": list(expected.magnitudes)},
        "mutants": [name for rung in fault.rungs for name in cell.mutant_ids(fault, rung)],
    }
