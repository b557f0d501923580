"""The deviation matrix as plain JSON values: what `matrix` prints for programs.

`scaloft-fi matrix`: the deviation matrix, every cell with its reason.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from scaloft_fi.console import tell, width, wrapped
from scaloft_fi.hazop.load import find_study, load_matrix
from scaloft_fi.hazop.matrix import Cell, CellStatus, Matrix, SeverityClass
from scaloft_fi.hazop.render import blocks, cells, grid_table, legend, overview, sheet, tally
from scaloft_fi.hazop.worksheet import HEADER, SHORT_HEADER, rows, short_rows
from scaloft_fi.hazop.worksheet import record as cell_record
from scaloft_fi.verbs import names
from scaloft_fi.verbs.margin import CELL_MARGINS
from scaloft_fi.verbs.options import campaign_option, format_option, operability_option, study_option
from scaloft_fi.verbs.score_record import SEVERITY
from scaloft_fi.verbs.verb import verb
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
)
from scaloft_fi.views.table import Format, csv_text, tabulated

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


def matrix_values(matrix: Matrix, margins: Mapping[str, Sequence[Mapping[str, Any]]] | None = None) -> dict[str, Any]:
    """Plain JSON values of the form `MATRIX`; `margins` as of `cell_margin_values`."""
    return {
        "cells": [
            {
                **cell_values(cell, matrix.severities.get(cell.name)),
                "margins": None if margins is None else margins[cell.name],
            }
            for cell in matrix
        ]
    }


@verb(
    "matrix",
    examples=(
        ("See every cell of the study's matrix", "scaloft-fi matrix"),
        ("Read one cell whole: causes, effect, fault, mutants", "scaloft-fi matrix --cell LATE-human"),
        ("Compare the smallest magnitude that is killed in each cell", "scaloft-fi matrix --margins"),
    ),
)
@study_option
@click.option(
    "--cell", shell_complete=names.cells, metavar="NAME", help="Tell one cell whole, by its name GUIDEWORD-parameter."
)
@click.option(
    "--guideword",
    "guidewords",
    multiple=True,
    shell_complete=names.guidewords,
    metavar="WORD",
    help="Only this guideword (repeatable).",
)
@click.option(
    "--parameter",
    "parameters",
    multiple=True,
    shell_complete=names.parameters,
    metavar="NAME",
    help="Only this parameter (repeatable).",
)
@click.option("--grid", "grid_only", is_flag=True, help="Only the grid, without the list of cells.")
@click.option(
    "--margins",
    "with_margins",
    is_flag=True,
    help="The grid with the smallest magnitude that is killed in every cell, from the flights of --campaign.",
)
@operability_option
@campaign_option
@format_option
def matrix_command(
    study_folder: Path | None,
    cell: str | None,
    guidewords: tuple[str, ...],
    parameters: tuple[str, ...],
    grid_only: bool,
    with_margins: bool,
    operability: bool,
    campaign: str,
    style: str,
) -> None:
    """Print the HAZOP deviation matrix: a grid of marks, then every cell with its deviation or its reason."""
    if cell and (guidewords or parameters or grid_only or with_margins):
        raise click.UsageError("--cell tells one cell and goes with no --guideword, --parameter, --grid or --margins")
    matrix = load_matrix(find_study(study_folder) / "hazop")
    if cell or style == "json":
        matrix = _with_events(matrix, study_folder)
    if style == "json" and not with_margins:
        chosen = matrix.cell(cell) if cell else None
        words = [chosen.guideword] if chosen else [word.upper() for word in guidewords]
        names = [chosen.parameter] if chosen else [name.lower() for name in parameters]
        tell(_json(matrix.only(words, names)))
        return
    if cell:
        tell(f"{_one(matrix, cell, style, study_folder)}\n")
        return
    shown = matrix.only([word.upper() for word in guidewords], [name.lower() for name in parameters])
    if with_margins:
        tell(f"{_margins(shown, study_folder, campaign, style, operability=operability)}\n")
        return
    tell(f"{_grid(shown, style) if grid_only else _all(shown, style)}\n")


def _with_events(matrix: Matrix, study_folder: Path | None) -> Matrix:
    """The matrix with the events at which its faults may strike; only stack and world tell them, and need numpy."""
    if not any(fault.phases for cell in matrix for fault in cell.faults):
        return matrix
    from scaloft_fi.study import Study

    return Study.open(study_folder).matrix


def _all(matrix: Matrix, style: str) -> str:
    if style == "table":
        hint = f"one cell whole: `scaloft-fi matrix --cell {next(iter(matrix)).name}`; the grid alone: `--grid`"
        return "\n\n".join([overview(matrix, width()), cells(matrix, width()), wrapped(hint, width())])
    if style == "csv":
        return _tabulated(HEADER, rows(matrix), style)
    return _tabulated(SHORT_HEADER, short_rows(matrix), style)


def _grid(matrix: Matrix, style: str) -> str:
    if style == "table":
        return overview(matrix, width())
    header, lines = grid_table(matrix)
    header = ["parameter", *header[1:]]
    return _tabulated(header, lines, style)


def _json(matrix: Matrix, margins: Mapping[str, Sequence[Mapping[str, Any]]] | None = None) -> str:

    return MATRIX.json(matrix_values(matrix, margins))


def _margins(matrix: Matrix, study_folder: Path | None, campaign: str, style: str, *, operability: bool) -> str:
    # a campaign needs numpy, the matrix alone does not
    from scaloft_fi.judge.requirement import Kind
    from scaloft_fi.study import Study
    from scaloft_fi.verbs.margin import LEGEND, LEGEND_AT, cell_margin_values, cell_margins
    from scaloft_fi.verbs.snapshot import snapshot

    study = Study.open(study_folder)
    kind = Kind.OPERABILITY if operability else Kind.SAFETY
    with snapshot(study, campaign) as now:
        study, matrix = now.study, now.study.matrix
        by_cell = cell_margins(now.outcomes, now.score, study.matrix, kind)
        if style == "json":
            return _json(matrix, cell_margin_values(now.outcomes, now.score, study.matrix, kind)).rstrip("\n")
    header = ["parameter", *(word.id for word in matrix.guidewords)]
    lines = [[p.id, *(by_cell[f"{word.id}-{p.id}"] for word in matrix.guidewords)] for p in matrix.parameters]
    if style == "table":
        return "\n".join(
            [
                blocks(["", *header[1:]], lines, width()),
                "",
                legend(LEGEND, width(), LEGEND_AT),
                "",
                wrapped(tally(matrix), width()),
            ]
        )
    return _tabulated(header, lines, style)


def _one(matrix: Matrix, name: str, style: str, study_folder: Path | None) -> str:
    cell = matrix.cell(name)
    if style == "table":
        return sheet(matrix, cell, _edges(study_folder) if cell.faults else {}, width())
    row = rows(matrix.only([cell.guideword], [cell.parameter]))[0]
    if style == "csv":
        return _tabulated(HEADER, [row], style)
    lines = [[name, text] for name, text in zip(HEADER[1:], row[1:], strict=True) if text]
    return _tabulated(("cell", cell.name), lines, style)


def _edges(study_folder: Path | None) -> Mapping[str, str]:
    from scaloft_fi.study import Study  # the stack's declaration is the only part that needs numpy

    return {seam.name: seam.edge for seam in Study.open(study_folder).stack.seams}


def _tabulated(header: Sequence[str], lines: Sequence[Sequence[str]], style: str) -> str:
    if style == "csv":
        return csv_text(header, lines).rstrip("\n")
    return tabulated(header, lines, Format(style), "latex_longtable" if style == Format.LATEX else "")
