"""The matrix as plain data: a row for each cell, as a HAZOP worksheet has them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from scaloft_fi.hazop.matrix import Cell, Fault, Matrix, class_of
from scaloft_fi.hazop.render import expectation, ladder, mark, yaml_text

SHORT_HEADER = ("parameter", "guideword", "default", "requirements", "deviation, or why it is not meaningful")


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
