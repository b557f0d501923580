"""The dry check of a whole study."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.checks.documents import check_documents
from scaloft_fi.checks.finding import Finding, Findings, Severity
from scaloft_fi.checks.found import check_dispositions, check_found, check_sources
from scaloft_fi.checks.matrix import check_matrix
from scaloft_fi.checks.requirements import KnownSignals, check_requirements, kinds_in
from scaloft_fi.checks.situations import GridCheck, check_grid
from scaloft_fi.checks.stack import check_command_of, check_plugins, check_stack_choice, known_signals
from scaloft_fi.checks.world import check_vehicle, check_world
from scaloft_fi.sim.grids import grid_names
from scaloft_fi.study import SituationKeys, Study

if TYPE_CHECKING:
    from scaloft_fi.sim.world import World
    from scaloft_fi.stack.declaration import Declaration

NOT_CHECKED = "not checked"


@dataclass(frozen=True)
class Check:
    """What the check of a study found.

    Attributes:
        folder: the study.
        findings: errors, then notes, each in the order in which they were found.
        counts: what was checked, by name: how much of it, in words.
    """

    folder: Path
    findings: tuple[Finding, ...]
    counts: tuple[tuple[str, str], ...]

    @property
    def errors(self) -> int:
        """Number of errors."""
        return sum(finding.severity is Severity.ERROR for finding in self.findings)


def check_study(folder: Path, *, fly: bool = False) -> Check:
    """Check every part of a study on its own; nothing is written, and without `fly` nothing is flown.

    Args:
        folder: the study.
        fly: whether one baseline flight shows which seams the stack polls.
    """
    findings = Findings()
    plugins = check_plugins(findings)
    documents = check_documents(folder, findings)
    study = Study(folder)
    sim = folder / "sim"
    stack = check_stack_choice(study, findings)
    world = check_world(sim / "world.yaml", findings)
    check_vehicle(sim, findings)
    known = _known(study, stack, world, findings)
    requirements = 0
    if known is not None:
        requirements = check_requirements(sim / "requirements.yaml", known, findings)
    grids = [check_grid(study, known, findings), *_further(study, stack, world, findings)]
    matrix = check_matrix(study, stack, kinds_in(sim / "requirements.yaml"), findings)
    finds = check_found(study, findings) if matrix.matrix else 0
    survivors = 0
    if matrix.matrix is not None:
        survivors = check_dispositions(study, matrix.matrix, SituationKeys(study), findings)
    if not findings.errors:
        check_sources(study, findings)
        check_command_of(study, findings)
    polled = NOT_CHECKED
    if fly:
        from scaloft_fi.checks.flown import check_seams

        polled = check_seams(study, findings)
    seams = f"{len(stack.seams)} of the stack {stack.name!r}" if stack else NOT_CHECKED
    counts = (
        ("documents", str(documents)),
        ("plugins", str(plugins)),
        ("requirements", str(requirements) if known else NOT_CHECKED),
        *(pair for grid in grids for pair in _told(grid)),
        ("cells", f"{len(matrix.cells)}, {sum(bool(cell.faults) for cell in matrix.cells)} of them with faults"),
        ("mutants", NOT_CHECKED if matrix.mutants is None else str(matrix.mutants)),
        ("seams", seams),
        ("seams that the stack polls", polled if fly else f"{NOT_CHECKED} without a flight: `scaloft-fi check --fly`"),
        ("found situations", str(finds)),
        ("accepted survivors", str(survivors)),
    )
    ordered = sorted(findings, key=lambda finding: finding.severity is Severity.NOTE)
    return Check(folder, tuple(ordered), counts)


def _known(study: Study, stack: Declaration | None, world: World | None, findings: Findings) -> KnownSignals | None:
    with findings.collecting():
        return known_signals(study, stack, world)
    return None


def _further(study: Study, stack: Declaration | None, world: World | None, findings: Findings) -> Iterator[GridCheck]:
    """The check of each further grid, with the world that it makes of the study's by what it adds."""
    names: tuple[str, ...] = ()
    with findings.collecting():
        _, *names = grid_names(study.folder / "sim")
    for name in names:
        other = replace(study, grid_name=name)
        own = None
        if world is not None:
            with findings.collecting():
                own = other.grid.world()
        yield check_grid(other, _known(other, stack, own, findings), findings)


def _told(grid: GridCheck) -> Iterator[tuple[str, str]]:
    """What was checked of a grid, in words."""
    yield f"grid {grid.name}: predicates", str(grid.predicates)
    if not grid.built:
        yield f"grid {grid.name}: situations", NOT_CHECKED
        return
    which = "all of them" if grid.built == grid.situations else f"{grid.built} of them, with every pair of values"
    yield f"grid {grid.name}: situations", f"{grid.situations}, built {which}"
    yield f"grid {grid.name}: pairs of values", str(grid.pairs)
    yield f"grid {grid.name}: places and legs with room for the hull", str(grid.legs)
