"""The deviation matrix for programs: what `matrix` prints as JSON; apart from the verb, since margins need numpy."""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.hazop.matrix import Cell, Fault, SeverityClass
from scaloft_fi.verbs.margin import CellMargin
from scaloft_fi.views.output import Output


@dataclass(frozen=True)
class ToldFault:
    """A fault.

    Attributes:
        fault: how the deviation is made.
        mutants: ids in the catalogue.
    """

    fault: Fault
    mutants: tuple[str, ...]
    KEYS = (
        *("fault.seam", "fault.operator", "fault.arguments", "fault.magnitude", "fault.phases", "fault.expected"),
        "mutants",
    )


@dataclass(frozen=True)
class ToldCell:
    """A cell.

    Attributes:
        cell: of the matrix.
        severity: class of severity, one of the study's own; in no ratio; null: it has none.
        default_mutant: id of the mutant that its name stands for; empty where it has none.
        faults: how the deviation is made.
    """

    cell: Cell
    severity: str | None
    default_mutant: str
    faults: tuple[ToldFault, ...]
    KEYS = (
        *("cell=cell.name", "cell.guideword", "cell.parameter", "cell.status", "cell.deviation", "cell.causes"),
        *("cell.effect", "severity", "cell.requirements", "cell.reason", "cell.predicted", "default_mutant", "faults"),
    )

    @classmethod
    def of(cls, cell: Cell, severity: SeverityClass | None) -> ToldCell:
        """What is told of a cell with its class of severity."""
        faults = (
            ToldFault(one, tuple(id_ for rung in one.rungs for id_ in cell.mutant_ids(one, rung)))
            for one in cell.faults
        )
        return cls(cell, severity.id if severity else None, cell.default_id if cell.faults else "", tuple(faults))


@dataclass(frozen=True)
class MatrixCell:
    """A cell.

    Attributes:
        told: the cell.
        margins: with --margins: the margins of its faults, over all situations; null: not asked for.
    """

    told: ToldCell
    margins: tuple[CellMargin, ...] | None
    KEYS = ("told.*", "margins")


@dataclass(frozen=True)
class MatrixCells:
    """The deviation matrix, every cell with its reason.

    Attributes:
        cells: the cells, parameter by parameter.
    """

    cells: tuple[MatrixCell, ...]


MATRIX = Output("matrix", "1.1", MatrixCells, rows="cells")
