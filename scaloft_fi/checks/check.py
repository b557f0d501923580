"""The dry check of a whole study."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.checks.documents import check_documents
from scaloft_fi.checks.finding import Finding, Findings, Severity
from scaloft_fi.checks.flown import check_seams
from scaloft_fi.checks.found import check_dispositions, check_found, check_sources
from scaloft_fi.checks.matrix import check_matrix
from scaloft_fi.checks.requirements import KnownSignals, check_requirements, kinds_in
from scaloft_fi.checks.situations import GridCheck, check_grid, grid_of
from scaloft_fi.checks.stack import check_command_of, check_plugins, check_stack_choice, known_signals
from scaloft_fi.checks.world import check_vehicle, check_world
from scaloft_fi.errors import InputError
from scaloft_fi.sim.grids import WITH_FOUND, grid_names
from scaloft_fi.study import SituationKeys, Study

if TYPE_CHECKING:
    from scaloft_fi.sim.world import World
    from scaloft_fi.stack.declaration import Declaration


@dataclass(frozen=True)
class Checked:
    """How much was checked; None where an error before it left a part unchecked.

    Attributes:
        documents: YAML files.
        plugins: plugins of this installation.
        requirements: requirements, each formula against what its signals can read.
        cells: cells of the matrix.
        faulty: those of them that have faults.
        mutants: mutants that the matrix derives, and the catalogue has.
        seams: seams that the stack declares.
        polled: those of them that the stack polls; None without a flight.
        unflown: why there was no such flight; "" where there was.
        found: situations in `sim/found.yaml`.
        accepted: survivors in `hazop/dispositions.yaml`.
        grids: the grids, the study's own first.
    """

    documents: int
    plugins: int
    requirements: int | None
    cells: int
    faulty: int
    mutants: int | None
    seams: int | None
    polled: int | None
    unflown: str
    found: int
    accepted: int
    grids: tuple[GridCheck, ...]


@dataclass(frozen=True)
class Check:
    """What the check of a study found.

    Attributes:
        folder: the study.
        findings: errors, then notes, each in the order in which they were found.
        checked: how much was checked.
    """

    folder: Path
    findings: tuple[Finding, ...]
    checked: Checked

    @property
    def errors(self) -> int:
        """Number of errors."""
        return sum(finding.severity is Severity.ERROR for finding in self.findings)

    @property
    def notes(self) -> int:
        """Number of notes."""
        return len(self.findings) - self.errors


def check_study(folder: Path, *, fly: bool = False) -> Check:
    """Check every part of a study on its own; nothing is written, and without `fly` nothing is flown.

    Args:
        folder: the study.
        fly: whether one baseline flight shows which seams the stack polls.
    """
    findings, study, sim = Findings(), Study(folder), folder / "sim"
    plugins = check_plugins(findings)
    documents = check_documents(folder, findings)
    stack = check_stack_choice(study, findings)
    world = check_world(sim / "world.yaml", findings)
    check_vehicle(sim, findings)
    known = _known(study, stack, world, findings)
    requirements = check_requirements(sim / "requirements.yaml", known, findings) if known else None
    grids = (check_grid(study, grid_of(study, findings), known, findings), *_further(study, stack, world, findings))
    matrix = check_matrix(study, stack, kinds_in(sim / "requirements.yaml"), findings)
    found = accepted = 0
    if matrix.matrix is not None:
        found = check_found(study, findings)
        accepted = check_dispositions(study, matrix.matrix, SituationKeys(study), findings)
    if not findings.errors:
        check_sources(study, findings)
        check_command_of(study, findings)
    polled, unflown = check_seams(study, findings) if fly else (None, "`scaloft-fi check --fly` flies once")
    checked = Checked(
        documents=documents,
        plugins=plugins,
        requirements=requirements,
        cells=len(matrix.cells),
        faulty=sum(bool(cell.faults) for cell in matrix.cells),
        mutants=matrix.mutants,
        seams=len(stack.seams) if stack else None,
        polled=polled,
        unflown=unflown,
        found=found,
        accepted=accepted,
        grids=grids,
    )
    ordered = sorted(findings, key=lambda finding: finding.severity is Severity.NOTE)
    return Check(folder, tuple(ordered), checked)


def _known(study: Study, stack: Declaration | None, world: World | None, findings: Findings) -> KnownSignals | None:
    with findings.collecting():
        return known_signals(study, stack, world)
    return None


def _further(study: Study, stack: Declaration | None, world: World | None, findings: Findings) -> Iterator[GridCheck]:
    """The check of each further grid, with the world that it makes of the study's by what it adds."""
    names: tuple[str, ...] = ()
    with findings.collecting():
        names = grid_names(study.folder / "sim")[1:]
    for name in names:
        if name.endswith(WITH_FOUND) and _has_misfits(study):
            continue  # the finds are told one by one
        other = replace(study, grid_name=name)
        grid, own = grid_of(other, findings), None
        if world is not None and grid is not None:
            with findings.collecting():
                own = grid.world()
        yield check_grid(other, grid, _known(other, stack, own, findings), findings)


def _has_misfits(study: Study) -> bool:
    try:
        return bool(study.finds.misfits)
    except InputError:
        return True
