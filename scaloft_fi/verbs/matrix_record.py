"""The deviation matrix as plain JSON values: what `matrix` prints for programs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from scaloft_fi.hazop.matrix import Cell, CellStatus, Matrix, SeverityClass
from scaloft_fi.hazop.worksheet import record as cell_record
from scaloft_fi.verbs.margin import CELL_MARGINS, CellMargin
from scaloft_fi.verbs.score_record import SEVERITY
from scaloft_fi.views.output import (
    Output,
    Shape,
    anything,
    by_name,
    flag,
    listing,
    number,
    optional,
    record,
    text,
    texts,
    writer_of,
)

ARGUMENTS = by_name("arguments of the operator", anything("a value; an infinite number is the text inf"))


CELL: Mapping[str, Shape] = {
    "cell": text("its name, GUIDEWORD-parameter"),
    "guideword": text("the guideword"),
    "parameter": text("the parameter"),
    "status": text("what it is", [status.value for status in CellStatus]),
    "deviation": text("what differs from the design intent"),
    "causes": texts("what could bring it about"),
    "effect": text("what it does, locally, then to the flight"),
    "severity": SEVERITY,
    "requirements": texts("the requirements at risk"),
    "reason": text("why it is not meaningful; else empty"),
    "predicted": text("what the study predicts; empty where it predicts nothing"),
    "default_mutant": text("id of the mutant that its name stands for; empty where it has none"),
    "faults": listing(
        "how the deviation is made",
        record(
            "a fault",
            {
                "seam": text("where it is patched in"),
                "operator": text("what alters the samples"),
                "arguments": ARGUMENTS,
                "magnitude": optional(
                    record(
                        "the argument that varies",
                        {
                            "argument": text("its name"),
                            "unit": text("of the ladder's numbers; empty for names"),
                            "scale": number("the argument is scale x magnitude"),
                            "ladder": texts("the magnitudes, as in ids"),
                            "default": text("the magnitude that the name of the cell stands for, as in ids"),
                        },
                    ),
                    "none varies",
                ),
                "phases": flag("whether the catalogue has it at later times and at events too"),
                "expected": optional(
                    record(
                        "what the study expects of its flights",
                        {
                            "status": text("the status"),
                            "reason": text("why"),
                            "magnitudes": texts("for which magnitudes, as in ids; empty for all"),
                        },
                    ),
                    "nothing",
                ),
                "mutants": texts("ids in the catalogue"),
            },
        ),
    ),
}
"""A cell of the matrix."""


MATRIX = Output(
    "matrix",
    "1.1",
    "the deviation matrix, every cell with its reason",
    {"cells": listing("the cells, parameter by parameter", record("a cell", {**CELL, "margins": CELL_MARGINS}))},
    rows="cells",
)


def cell_values(cell: Cell, severity: SeverityClass | None) -> dict[str, Any]:
    """A cell and its class of severity as plain JSON values of `CELL`."""
    told = cell_record(cell, severity)
    for fault in told["faults"]:
        fault["arguments"] = argument_values(fault["arguments"])
    return told


def argument_values(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of an operator, infinite ones as texts."""
    return {name: "inf" if value == math.inf else value for name, value in arguments.items()}


def matrix_values(matrix: Matrix, margins: Mapping[str, tuple[CellMargin, ...]] | None = None) -> dict[str, Any]:
    """Plain JSON values of the form `MATRIX`; `margins` as of `cell_margins`."""
    return {
        "cells": [
            {
                **cell_values(cell, matrix.severities.get(cell.name)),
                "margins": writer_of(tuple[CellMargin, ...] | None)(margins and margins[cell.name]),
            }
            for cell in matrix
        ]
    }
