"""`scaloft-fi mutants`: the catalogue of mutants; list it, derive it from the matrix, prove it current."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import click

from scaloft_fi.console import say, tell, tell_line, width
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.mutants import catalogue
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.study import Study
from scaloft_fi.verbs import names
from scaloft_fi.verbs.options import Option, StudyFolder, TableFormat, check_own, verb
from scaloft_fi.views.output import Output
from scaloft_fi.views.table import Format, body_text, tabulated


@dataclass(frozen=True)
class Catalogue:
    """The written catalogue.

    Attributes:
        path: its file.
        current: whether it is what the matrix gives.
        written: whether this call has written it.
        mutants: mutants that the matrix gives.
        cells: cells that have mutants.
    """

    path: str
    current: bool
    written: bool
    mutants: int
    cells: int


@dataclass(frozen=True)
class ListedMutant:
    """A mutant.

    Attributes:
        mutant: itself.
        default: whether the name of its cell stands for it.
    """

    mutant: Mutant
    default: bool
    KEYS = ("mutant.*", "default")


@dataclass(frozen=True)
class MutantList:
    """The mutants that the deviation matrix gives.

    Attributes:
        catalogue: the written catalogue.
        mutants: the mutants asked for; with --write and --check all of them.
    """

    catalogue: Catalogue
    mutants: tuple[ListedMutant, ...]


MUTANTS = Output("mutants", "1.0", MutantList, rows="mutants")
_COLUMNS = ("id", "default", "parameter", "guideword", "seam", "operator", "arguments")
_IN_TERMINAL = ("id", "default", "seam", "operator", "arguments")
"""Guideword and parameter are read from the id."""


@verb(
    "mutants",
    examples=(
        ("List the ladder of one cell", "scaloft-fi mutants 'LATE-human*'"),
        ("Derive the catalogue again after an edit of the matrix", "scaloft-fi mutants --write"),
        ("Fail where the catalogue is stale, as in CI", "scaloft-fi mutants --check"),
    ),
)
def mutants_command(
    *,
    patterns: Annotated[tuple[str, ...], Option("", "", metavar="[PATTERN]...", complete=names.mutants)] = (),
    write: Annotated[bool, Option("Derive the catalogue from the matrix and write it.")],
    check: Annotated[bool, Option("Prove that the written catalogue is what the matrix gives.")],
    cells: Annotated[
        tuple[str, ...],
        Option("All mutants of this cell (repeatable).", "--cell", metavar="CELL", complete=names.cells),
    ],
    only_defaults: Annotated[bool, Option("One mutant a cell: its default.", "--defaults")],
    style: TableFormat,
    study_folder: StudyFolder,
) -> None:
    """List, derive, or prove current the catalogue of mutants.

    PATTERN is a cell's name (its default mutant), an id, or a pattern with *, ? or [ over names and ids:
    `LATE-human*` is the whole ladder, `*-human` the default of every cell of `human`.
    """
    if write and check:
        raise click.UsageError("--write and --check exclude each other")
    if (write or check) and (patterns or cells or only_defaults):
        raise click.UsageError("--write and --check are about the whole catalogue; give no pattern with them")

    study = Study.open(study_folder)
    folder = study.folder / "mutants"
    if write:
        check_own(study, study_folder, folder / catalogue.CATALOGUE)
    matrix = study.matrix
    derived = catalogue.check_catalogue(folder, matrix) if check else catalogue.derive(matrix)
    default_ids = {mutant.id for mutant in catalogue.defaults(matrix)}
    path = catalogue.write_catalogue(folder, derived) if write else folder / catalogue.CATALOGUE
    current = write or check or _is_current(folder, matrix)
    chosen = derived if write or check else _chosen(derived, matrix, patterns, cells, only_defaults=only_defaults)
    if style == Format.JSON:
        told = Catalogue(str(path), current, write, len(derived), len(default_ids))
        tell(MUTANTS.json(MutantList(told, tuple(ListedMutant(one, one.id in default_ids) for one in chosen))))
    elif write or (check and style != Format.CSV):
        tell_line(f"{path}: {'' if write else 'current, '}{len(derived)} mutants of {len(default_ids)} cells")
    else:
        tell(f"{_table(chosen, default_ids, style)}\n")


def _is_current(folder: Path, matrix: Matrix) -> bool:
    """Whether the written catalogue is what the matrix gives; a warning says why it is not."""
    try:
        catalogue.check_catalogue(folder, matrix)
    except InputError as error:
        say(f"warning: {error}")
        return False
    return True


def _chosen(
    derived: Sequence[Mutant], matrix: Matrix, patterns: Sequence[str], cells: Sequence[str], *, only_defaults: bool
) -> Sequence[Mutant]:
    """What the user asks for; without a word the whole catalogue."""
    for name in cells:
        catalogue.default_of(matrix.cell(name))  # refuses a cell without mutants, with its reason
    chosen = list(catalogue.select(patterns, matrix, derived))
    known = {mutant.id for mutant in chosen}
    if cells or not patterns:
        chosen += [m for m in derived if (not cells or m.cell in cells) and m.id not in known]
    kept = {mutant.id for mutant in catalogue.defaults(matrix)}
    return [mutant for mutant in chosen if mutant.id in kept or not only_defaults]


def _table(mutants: Sequence[Mutant], default_ids: Collection[str], style: str) -> str:
    rows = [_row(mutant, mutant.id in default_ids) for mutant in mutants]
    if style == "table":
        short = [[row[name] for name in _IN_TERMINAL] for row in rows]
        return body_text(_IN_TERMINAL, short, width(), ("operator", "seam"), marked=False)
    return tabulated(_COLUMNS, [list(row.values()) for row in rows], Format(style))


def _row(mutant: Mutant, default: bool) -> dict[str, Any]:
    said = {name: f"{value:g}" if isinstance(value, float) else value for name, value in mutant.arguments.items()}
    arguments = ", ".join(f"{name}={value}" for name, value in said.items())
    values = (mutant.id, "*" * default, mutant.parameter, mutant.guideword, mutant.seam, mutant.operator, arguments)
    return dict(zip(_COLUMNS, values, strict=True))
