"""`scaloft-fi matrix`: the deviation matrix, every cell with its reason."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import click

from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.document import is_folder
from scaloft_fi.errors import InputError
from scaloft_fi.hazop import render
from scaloft_fi.hazop.load import find_study, is_packaged, load_matrix
from scaloft_fi.hazop.matrix import Cell, Matrix
from scaloft_fi.output import coloured, joined, printable, tell, width, wrapped
from scaloft_fi.verbs import names
from scaloft_fi.verbs.options import Campaign, Operability, Option, StudyFolder, TableFormat, verb
from scaloft_fi.views.table import Format, tabulated

if TYPE_CHECKING:
    from scaloft_fi.study import Study
    from scaloft_fi.verbs.margin import CellMargin


@verb("matrix")
def matrix_command(
    *,
    study_folder: StudyFolder,
    cell: Annotated[
        str | None,
        Option("Tell one cell whole, by its name GUIDEWORD-parameter.", metavar="NAME", complete=names.cells),
    ],
    guidewords: Annotated[
        tuple[str, ...],
        Option("Only this guideword (repeatable).", "--guideword", metavar="WORD", complete=names.guidewords),
    ],
    parameters: Annotated[
        tuple[str, ...],
        Option("Only this parameter (repeatable).", "--parameter", metavar="NAME", complete=names.parameters),
    ],
    grid_only: Annotated[bool, Option("Only the grid, without the list of cells.", "--grid")],
    with_margins: Annotated[
        bool,
        Option(
            "The grid with the smallest magnitude that is killed in every cell, from the flights of --campaign.",
            "--margins",
        ),
    ],
    operability: Operability,
    campaign: Campaign,
    style: TableFormat,
) -> None:
    """Print the HAZOP deviation matrix: a grid of marks, then every cell with its deviation or its reason.

    Examples:
        See every cell of the study's matrix: `scaloft-fi matrix`
        Read one cell whole: causes, effect, fault, mutants: `scaloft-fi matrix --cell LATE-human`
        Compare the smallest magnitude that is killed in each cell: `scaloft-fi matrix --margins`
    """
    if cell and (guidewords or parameters or grid_only or with_margins):
        raise click.UsageError("--cell tells one cell and goes with no --guideword, --parameter, --grid or --margins")
    matrix, how = load_matrix(find_study(study_folder) / "hazop"), Format(style)
    if (cell or style == "json") and any(fault.phases for one in matrix for fault in one.faults):
        matrix = _opened(study_folder).matrix  # with the events at which faults may strike: stack and world tell them
    chosen = matrix.cell(cell) if cell else None
    words = [chosen.guideword] if chosen else [word.upper() for word in guidewords]
    names = [chosen.parameter] if chosen else [name.lower() for name in parameters]
    shown = matrix.only(words, names)
    if with_margins:
        tell(f"{_margins(study_folder, campaign, how, operability=operability)}\n")
    elif style == "json":
        tell(_json(shown))
    elif chosen:
        tell(f"{_one(matrix, chosen, how, study_folder)}\n")
    elif style == "table":
        tell(_pictured(shown, _signs(study_folder, campaign), grid_only=grid_only))
    else:
        tell(f"{_grid(shown, how) if grid_only else _all(shown, how)}\n")


def _opened(study_folder: Path | None) -> Study:
    """The study; it needs numpy, the matrix alone does not."""
    from scaloft_fi.study import Study

    return Study.open(study_folder)


def _signs(study_folder: Path | None, campaign: str) -> Mapping[str, str]:
    """The sign of each cell of which a campaign flew the default mutant; none where no campaign was flown.

    Raises:
        InputError: another campaign than the default one does not exist, or holds no flight that counts.
    """
    root = Path() if is_packaged(study := find_study(study_folder)) else study
    if campaign == CAMPAIGN and not is_folder(root / "results" / "campaigns" / campaign):
        return {}
    from scaloft_fi.verbs.snapshot import snapshot
    from scaloft_fi.verbs.verdict import signs_of

    allowed = suppress(InputError) if campaign == CAMPAIGN else nullcontext()
    with allowed, snapshot(_opened(study_folder), campaign) as now:
        return signs_of(now.score)
    return {}


def _pictured(matrix: Matrix, signs: Mapping[str, str], *, grid_only: bool) -> str:
    """The matrix for a terminal, with the signs of a campaign if there is one."""
    grid = printable(render.overview(matrix, width(), signs))
    if signs:
        from scaloft_fi.verbs.verdict import with_legend

        grid = with_legend(grid, signs, width(), marked=coloured())
    hint = f"one cell whole: `scaloft-fi matrix --cell {next(iter(matrix)).name}`; the grid alone: `--grid`"
    rest = ["", printable(render.cells(matrix, width())), "", wrapped(hint, width())]
    return joined([grid, *([] if grid_only else rest), ""])


def _all(matrix: Matrix, style: Format) -> str:
    if style == "csv":
        return tabulated(render.HEADER, render.rows(matrix), style)
    return tabulated(render.SHORT_HEADER, render.short_rows(matrix), style)


def _grid(matrix: Matrix, style: Format) -> str:
    header, lines = render.grid_table(matrix, {})
    return tabulated(["parameter", *header[1:]], lines, style)


def _json(matrix: Matrix, margins: Mapping[str, tuple[CellMargin, ...]] | None = None) -> str:
    from scaloft_fi.verbs.margin import MATRIX, told_cells

    return MATRIX.json(told_cells(matrix, margins))


def _margins(study_folder: Path | None, campaign: str, style: Format, *, operability: bool) -> str:
    from scaloft_fi.verbs.margin import LEGEND, LEGEND_AT, margin_texts, margins_of_cells

    matrix, found = margins_of_cells(_opened(study_folder), campaign, operability=operability)
    if style == "json":
        return _json(matrix, found).rstrip("\n")
    by_cell = margin_texts(matrix, found)
    header = ["parameter", *(word.id for word in matrix.guidewords)]
    lines = [[p.id, *(by_cell[f"{word.id}-{p.id}"] for word in matrix.guidewords)] for p in matrix.parameters]
    if style == "table":
        grid, legend = render.blocks(["", *header[1:]], lines, width()), render.legend(LEGEND, width(), LEGEND_AT)
        return "\n".join([grid, "", legend, "", wrapped(render.tally(matrix), width())])
    return tabulated(header, lines, style)


def _one(matrix: Matrix, cell: Cell, style: Format, study_folder: Path | None) -> str:
    if style == "table":
        edges = {seam.name: seam.edge for seam in _opened(study_folder).stack.seams} if cell.faults else {}
        return render.sheet(matrix, cell, edges, width())
    row = render.rows(matrix.only([cell.guideword], [cell.parameter]))[0]
    if style == "csv":
        return tabulated(render.HEADER, [row], style)
    lines = [[name, text] for name, text in zip(render.HEADER[1:], row[1:], strict=True) if text]
    return tabulated(("cell", cell.name), lines, style)
