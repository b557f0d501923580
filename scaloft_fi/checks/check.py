"""The dry check of a whole study: its documents, its finds and sources, the seams that its stack polls."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.checks.finding import Finding, Findings, Severity
from scaloft_fi.checks.matrix import KnownSignals, check_matrix, check_requirements, kinds_in
from scaloft_fi.checks.situations import (
    GridCheck,
    check_command_of,
    check_grid,
    check_plugins,
    check_stack_choice,
    grid_of,
    known_signals,
)
from scaloft_fi.checks.world import check_vehicle, check_world
from scaloft_fi.document import Item, is_there, load
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.load import SHEETS
from scaloft_fi.sim.found import FILE
from scaloft_fi.sim.found import FILE as FOUND
from scaloft_fi.sim.grid import FOLDER as GRIDS
from scaloft_fi.sim.grid import WITH_FOUND, grid_names, is_grid_name
from scaloft_fi.sim.load import DOCUMENTS
from scaloft_fi.study import SituationKeys, Study, read_disposition

if TYPE_CHECKING:
    from collections.abc import Collection

    from scaloft_fi.hazop.matrix import Matrix
    from scaloft_fi.sim.world import World
    from scaloft_fi.stack.declaration import Declaration


NEEDED = {"hazop": ("guidewords", "parameters"), "sim": (*DOCUMENTS, "requirements")}
OPTIONAL = {"hazop": ("score", "severities", "dispositions"), "sim": ("sources", Path(FOUND).stem, "flyer", "record")}


def check_documents(folder: Path, findings: Findings) -> int:
    """Read every YAML file of the study; returns how many there are.

    Args:
        folder: the study.
        findings: takes the findings.
    """
    paths = list(_read_by_verbs(folder))
    for path in paths:
        with findings.collecting():
            load(path)
    for path in _stray(folder, paths):
        near = did_you_mean(path.stem, (*NEEDED[path.parent.name], *OPTIONAL[path.parent.name]))
        findings.note(f"{path}:1", "no verb reads this file", f"name it as one that is read{near}")
    for path in sorted((folder / "sim" / GRIDS).glob("*.y*ml")):
        if path.suffix != ".yaml" or not is_grid_name(path.stem):
            allowed = "letters, digits, - and _, and end it in .yaml"
            findings.wrong(f"{path}:1", "no verb reads this grid", f"name the file with {allowed}")
    for path in sorted((folder / "hazop" / SHEETS).glob("*.yml")):
        findings.wrong(f"{path}:1", "no verb reads this file", "end its name in .yaml")
    return len(paths)


def _read_by_verbs(folder: Path) -> Iterator[Path]:
    for part, names in NEEDED.items():
        yield from (folder / part / f"{name}.yaml" for name in names)
    for part, names in OPTIONAL.items():
        yield from (path for name in names if (path := folder / part / f"{name}.yaml").exists())
    yield from sorted((folder / "hazop" / SHEETS).glob("*.yaml"))
    yield from sorted(path for path in (folder / "sim" / GRIDS).glob("*.yaml") if is_grid_name(path.stem))


def _stray(folder: Path, known: list[Path]) -> Iterator[Path]:
    for part in NEEDED:
        yield from (path for path in sorted((folder / part).glob("*.y*ml")) if path not in known)


def check_seams(study: Study, findings: Findings) -> tuple[int | None, str]:
    """Fly the baseline once in the first situation, and hold every poll against the declaration.

    Returns:
        How many seams the stack polls, and ""; or None, and why nothing was flown.
    """
    from scaloft_fi.campaign.flights.check_stack import polls_of

    if findings.errors:
        return None, "not flown, because the study has errors"
    if study.command is not None:
        return None, "not flown, because a command flies this study"
    situation, place = study.grid.situations[0], str(study.folder / "sim" / "stack.yaml")
    seen = polls_of(study, situation)
    for failure in seen.failures:
        remedy = "mend the stack, or its declaration"
        findings.add(Finding(Severity.ERROR, place, 1, failure, situation.key, remedy))
    if seen.silent:
        what = f"in one baseline flight nothing was sent over {', '.join(seen.silent)}"
        remedy = "a fault there is reached only in situations that bring samples"
        findings.add(Finding(Severity.NOTE, place, 1, what, situation.key, remedy))
    return seen.polled, ""


def check_found(study: Study, findings: Findings) -> int:
    """The finds and breaks of the study; returns how many there are.  Those that no longer fit are notes."""
    path = study.folder / "sim" / FILE
    if not is_there(path):
        return 0
    count = 0
    with findings.collecting():
        known, places = study.finds, _places(path)
        count = len(known.finds) + len(known.breaks) + len(known.misfits)
        for name, why in known.misfits.items():
            what = f"{name} does not fit the study any more, so every verb leaves it out: {why}"
            findings.note(places.get(name, f"{path}:1"), what.replace("; ", ", "), "seek anew, or remove the entry")
    return count


def _places(path: Path) -> dict[str, str]:
    document = load(path)
    parts = [document.get(key) for key in ("finds", "breaks")]
    return {name: entry.place for part in parts if part is not None for name, entry in part.mapping().items()}


def check_dispositions(study: Study, matrix: Matrix, situations: Collection[str], findings: Findings) -> int:
    """Every accepted survivor; returns how many there are.

    Args:
        study: the study.
        matrix: its matrix.
        situations: keys of its grids.
        findings: takes the findings.
    """
    path = study.dispositions_path
    if not is_there(path):
        return 0

    def read(entry: tuple[str, Item]) -> None:
        read_disposition(*entry, matrix, situations)

    entries: tuple[tuple[str, Item], ...] = ()
    with findings.collecting():
        entries = tuple(load(path).mapping().items())
        findings.each(read, entries)
        _ = study.dispositions  # tells what is there twice
    return len(entries)


def check_sources(study: Study, findings: Findings) -> None:
    """Sources of numbers that the study does not have."""
    path = study.folder / "sim" / "sources.yaml"
    if not is_there(path):
        return
    with findings.collecting():
        numbers, document = study.sim.numbers, load(path)
        for name, item in document.mapping().items():
            if not any(f"{number}.".startswith(f"{name}.") for number in numbers):
                findings.note(item.place, f"{name!r} is no number of the study", "name the dotted path of one")


@dataclass(frozen=True)
class Checked:
    """How much was checked; null where an error before it left a part unchecked.

    Attributes:
        documents: YAML files.
        plugins: plugins of this installation.
        requirements: requirements; null: an error before it left it unchecked.
        cells: cells of the matrix.
        faulty: cells of the matrix that have faults.
        mutants: mutants that matrix and catalogue have; null: an error before it left it unchecked.
        seams: seams that the stack declares; null: an error before it left it unchecked.
        polled: seams that the stack polls in one baseline flight; null: nothing was flown.
        unflown: why nothing was flown; empty where it was.
        found: situations in sim/found.yaml.
        accepted: survivors in hazop/dispositions.yaml.
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


@dataclass(frozen=True)
class Check:
    """What the dry check of a study found.

    Attributes:
        study: folder of the study.
        errors: findings that a verb refuses, or that make flights mean nothing; the exit code is then 2.
        notes: findings that somebody should know.
        findings: errors, then notes, each in the order in which they were found.
        checked: how much was checked.
        grids: how much of each grid was checked, the study's own first.
    """

    study: Path
    errors: int
    notes: int
    findings: tuple[Finding, ...]
    checked: Checked
    grids: tuple[GridCheck, ...]


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
    )
    ordered = sorted(findings, key=lambda finding: finding.severity is Severity.NOTE)
    errors = findings.errors
    return Check(folder, errors, len(ordered) - errors, tuple(ordered), checked, grids)


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
