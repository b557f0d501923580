"""The deviation matrix, cell by cell: seams, operators, requirements, controls; and the catalogue."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from scaloft_fi.checks.finding import Finding, Findings, Severity, finding_of
from scaloft_fi.document import is_there, load
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.load import SHEETS, load_guidewords, load_parameters, misnamed_cells, misnamed_sheets, read_cell
from scaloft_fi.hazop.matrix import (
    SEVERITIES,
    Cell,
    CellStatus,
    Guideword,
    Matrix,
    Parameter,
    SeverityClass,
    load_severities,
)
from scaloft_fi.mutants.catalogue import derive

if TYPE_CHECKING:
    from scaloft_fi.stack.declaration import Declaration
    from scaloft_fi.study import Study

NAMED = 5
"""Seams or cells that a note names."""


@dataclass(frozen=True)
class MatrixCheck:
    """What was read of the matrix.

    Attributes:
        cells: the cells that can be read.
        mutants: number of mutants that the matrix derives; None where it cannot.
        matrix: the whole matrix; None where a part of it cannot be read.
    """

    cells: tuple[Cell, ...] = ()
    mutants: int | None = None
    matrix: Matrix | None = None


def check_matrix(study: Study, stack: Declaration | None, kinds: Mapping[str, str], findings: Findings) -> MatrixCheck:
    """Read the matrix, and hold it against stack and requirements.

    Args:
        study: the study.
        stack: declaration of its stack; None where it cannot be read, which leaves seams and operators unchecked.
        kinds: kind of each requirement by name; empty where they cannot be read.
        findings: takes the findings.
    """
    before, hazop = findings.errors, study.folder / "hazop"
    words: tuple[Guideword, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    places: dict[str, str] = {}
    with findings.collecting():
        path = hazop / "guidewords.yaml"
        words = tuple(Guideword(name, name, "") for name in load(path).mapping())  # where one of them is wrong
        words = load_guidewords(path)
    with findings.collecting():
        path = hazop / "parameters.yaml"
        places = {name: item.place for name, item in load(path).mapping().items()}
        parameters = tuple(Parameter(name, name, "", "", "") for name in places)
        parameters, places = load_parameters(path)
    classes: tuple[SeverityClass, ...] = ()
    with findings.collecting():
        path = hazop / SEVERITIES
        names = load(path).mapping() if is_there(path) else {}
        classes = tuple(SeverityClass(rank, name, name, "") for rank, name in enumerate(names))
        classes = load_severities(path)
    if not words or not parameters:
        return MatrixCheck()
    findings.all_of(misnamed_sheets(hazop / SHEETS, places))
    read = [pair for one in parameters for pair in _cells(study, one, words, stack, classes, findings)]
    cells = [cell for cell, _ in read]
    for cell in cells:
        _check_requirements(cell, kinds, findings)
        if stack is not None:
            _check_faults(cell, words, parameters, findings)
    whole = findings.errors == before
    if whole or len(cells) == len(words) * len(parameters):
        _check_controls(study, cells, stack, findings)
        _check_seams(study, cells, stack, findings)
        _check_severities(study, classes, read, findings)
    if not whole or stack is None:
        return MatrixCheck(tuple(cells))
    matrix: Matrix | None = None
    mutants: int | None = None
    with findings.collecting():
        matrix = study.matrix
        mutants = len(derive(matrix))
        _ = study.catalogue  # reading it compares it with the matrix
    with findings.collecting():
        _ = study.alpha
    return MatrixCheck(tuple(cells), mutants, matrix)


def _cells(
    study: Study,
    parameter: Parameter,
    words: Iterable[Guideword],
    stack: Declaration | None,
    classes: tuple[SeverityClass, ...],
    findings: Findings,
) -> Iterator[tuple[Cell, SeverityClass | None]]:
    path, ids = study.folder / "hazop" / SHEETS / f"{parameter.id}.yaml", [word.id for word in words]
    if not is_there(path):
        return
    with findings.collecting():
        sheet, seams = load(path), stack.by_name if stack else None
        if not findings.all_of(misnamed_cells(sheet, ids)):
            ids = [word for word in ids if word in sheet.mapping()]  # a blank cell may be the one that is misnamed
        yield from findings.each(lambda word: read_cell(sheet, word, parameter.id, seams, classes), ids)


def _check_requirements(cell: Cell, kinds: Mapping[str, str], findings: Findings) -> None:
    for name in cell.requirements if kinds else ():
        if name not in kinds:
            hint = did_you_mean(name, kinds).removeprefix("; ")
            findings.wrong(cell.requirements_place, f"{name!r} of {cell.name} is no requirement", hint)
    deciding = [name for name in cell.requirements if kinds.get(name, "safety") != "reported"]
    if cell.status is CellStatus.CONTROL and not deciding:
        findings.wrong(
            cell.requirements_place,
            f"the control {cell.name} names no requirement of kind safety or operability, so it can never show itself",
            "name the requirement that its fault must violate",
        )


def _check_faults(cell: Cell, words: Iterable[Guideword], parameters: Iterable[Parameter], findings: Findings) -> None:
    """Derive the mutants of each fault alone: operator, seam, arguments and every magnitude must fit."""
    word = next(one for one in words if one.id == cell.guideword)
    parameter = next(one for one in parameters if one.id == cell.parameter)
    for fault in cell.faults:
        alone = {(cell.guideword, cell.parameter): replace(cell, faults=(fault,))}
        try:
            derive(Matrix((word,), (parameter,), alone))
        except InputError as error:
            found = finding_of(str(error))
            takes = f"`scaloft-fi operators {fault.operator}` shows what it takes"
            findings.add(replace(found, remedy=found.remedy or takes))


def _check_controls(study: Study, cells: Iterable[Cell], stack: Declaration | None, findings: Findings) -> None:
    controls = [cell for cell in cells if cell.status is CellStatus.CONTROL]
    place = str(study.folder / "hazop" / SHEETS)
    if not controls:
        what = "no cell is a control, so no flight proves that faults reach the drone"
        remedy = "give a cell `status: control` whose fault no drone survives, such as velocity commands turned round"
        findings.add(Finding(Severity.NOTE, place, None, what, remedy))
    elif stack and stack.canaries and not any(cell.faults[0].seam in stack.canaries for cell in controls):
        names = ", ".join(stack.canaries)
        what = f"no control strikes a seam that carries samples in every situation ({names})"
        remedy = "make a cell with a fault there a control, because `run --mutant` flies one control in one situation"
        findings.add(Finding(Severity.NOTE, place, None, what, remedy))


def _check_seams(study: Study, cells: Iterable[Cell], stack: Declaration | None, findings: Findings) -> None:
    used = {fault.seam for cell in cells for fault in cell.faults}
    seams = list(stack.by_name) if stack else []
    idle = [name for name in seams if name not in used]
    if idle:
        what = f"no cell of the matrix has a fault at {len(idle)} of the stack's {len(seams)} seams: {_some(idle)}"
        remedy = "ask the guidewords of what they carry, or leave them out on purpose; `scaloft-fi seams` counts cells"
        findings.add(Finding(Severity.NOTE, str(study.folder / "hazop" / SHEETS), None, what, remedy))


def _check_severities(
    study: Study,
    classes: Iterable[SeverityClass],
    read: Iterable[tuple[Cell, SeverityClass | None]],
    findings: Findings,
) -> None:
    """Name the credible cells without a class, where the study has classes."""
    lacking = [cell.name for cell, severity in read if cell.status is CellStatus.CREDIBLE and severity is None]
    names = [one.id for one in classes]
    if names and lacking:
        what = f"severity is missing in {len(lacking)} credible cells: {_some(lacking)}"
        remedy = f"give each a class, `severity: {names[0]}` or another of {SEVERITIES}; without one it stands last"
        findings.add(Finding(Severity.NOTE, str(study.folder / "hazop" / SEVERITIES), None, what, remedy))


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:NAMED]) + (f" and {len(names) - NAMED} more" if len(names) > NAMED else "")
