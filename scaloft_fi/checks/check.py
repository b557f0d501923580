"""The dry check of a whole study: documents, grids, stack and signals, finds and sources, the seams that are polled."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from importlib.metadata import entry_points
from pathlib import Path

from scaloft_fi.analysis.coverage import greedy_array
from scaloft_fi.campaign.flights.check_stack import polls_of
from scaloft_fi.campaign.flights.command import check_command, mapping_of
from scaloft_fi.campaign.runs.request import STRATEGIES, hint
from scaloft_fi.checks import Finding, Findings, Severity, finding_of
from scaloft_fi.checks import parts as pieces
from scaloft_fi.document import Item, is_file, is_there, load
from scaloft_fi.errors import InputError, did_you_mean, refused
from scaloft_fi.hazop.load import SHEETS
from scaloft_fi.hazop.matrix import Cell, Matrix
from scaloft_fi.judge.requirement import ANY, Ranges, cap_of, ranges_of, within_rock, without
from scaloft_fi.judge.space import MOST_LISTED, Space
from scaloft_fi.judge.stl import FormulaError
from scaloft_fi.model import value_of
from scaloft_fi.mutants.operator import TapError
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.outside.border import BORDERS
from scaloft_fi.outside.command import runs
from scaloft_fi.outside.exchange import OutsideConfig
from scaloft_fi.outside.records import load_record_map
from scaloft_fi.registry import PLUGIN_GROUP, load_plugin, plugin_behind
from scaloft_fi.sim import grid as grids_of
from scaloft_fi.sim.happenings import HAPPENINGS
from scaloft_fi.sim.load import DOCUMENTS
from scaloft_fi.sim.load import load as load_sim
from scaloft_fi.sim.log import SIGNALS, clearance_name, signal_names
from scaloft_fi.sim.situation import PARTS, Axis, AxisModel, AxisValue, leaves
from scaloft_fi.sim.stacks import StackChoice
from scaloft_fi.sim.world import GROUND, WALL, World
from scaloft_fi.stack.declaration import TICK_S, Declaration
from scaloft_fi.study import SituationKeys, Study, read_disposition

_SHOWN_IN = re.compile(r",? as in situation \S+")


@dataclass(frozen=True)
class GridCheck:
    """How much of a grid was checked.

    Attributes:
        name: its name.
        situations: its situations; 0 where it cannot be read.
        built: situations whose world, vehicle, sensors and route were built.
        pairs: pairs of values of two axes in these.
        predicates: formulas `realised`.
        legs: places and legs of routes where the hull was compared with rock and bodies.
    """

    name: str
    situations: int = 0
    built: int = 0
    pairs: int = 0
    predicates: int = 0
    legs: int = 0


def check_grid(
    study: Study, grid: grids_of.Grid | None, known: pieces.KnownSignals | None, findings: Findings
) -> GridCheck:
    """Check one grid of a study.

    Args:
        study: the study with that grid.
        grid: as `grid_of` reads it.
        known: its signals; None where they are unknown, which leaves the predicates unchecked.
        findings: takes the findings.
    """
    name = study.grid_name or (grid.name if grid else grids_of.FILE)
    if grid is None and name.endswith(grids_of.WITH_FOUND):
        return GridCheck(name)
    axes = grid.axes if grid else _axes(study, findings)
    predicates = [(axis, value) for axis in axes for value in (*axis.values, *axis.extremes) if value.realised]
    # the situations of a search are in the axes of another grid, which has been checked
    agreed = grid is not None and (
        grid.listed is not None or findings.all_of((*grids_of.contradictions(grid), *grids_of.impossible_worlds(grid)))
    )
    if known is not None:
        passing = grid.passing_signals if grid and agreed else _thinkable(study)
        for axis, value in predicates:
            _check_predicate(axis, value, known, passing, findings)
    if grid is None or not agreed:
        return GridCheck(name, len(grid) if grid else 0, predicates=len(predicates))
    situations, built, pairs, legs = len(grid), 0, 0, 0
    with findings.collecting():
        _check_choice(grid)
        chosen, pairs = _chosen(grid)
        built, legs = _build(study, grid, chosen, findings)
    return GridCheck(name, situations, built, pairs, len(predicates), legs)


def grid_of(study: Study, findings: Findings) -> grids_of.Grid | None:
    """The grid of a study, without a check that its axes agree; None where it cannot be read."""
    folder, name = study.folder / "sim", study.grid_name
    with findings.collecting():
        if name is not None and name.endswith(grids_of.WITH_FOUND):
            return study.grid
        documents = {part: load(folder / f"{part}.yaml") for part in PARTS}
        return grids_of.assembled(_file(study), documents, name)
    return None


def _file(study: Study) -> Item:
    folder, name = study.folder / "sim", study.grid_name
    return load(folder / grids_of.FILE if name is None else folder / grids_of.FOLDER / f"{name}.yaml")


def _axes(study: Study, findings: Findings) -> tuple[Axis, ...]:
    """The axes of a grid that cannot be read whole, those that can be read; what is wrong with the others is told."""
    found: list[Axis] = []
    with findings.collecting():
        for entry in _file(study).need("axes").mapping().values():
            with findings.collecting():
                found.append(value_of(AxisModel, entry).axis)
    return tuple(found)


def _thinkable(study: Study) -> list[str]:
    """The signals that happenings and optional bodies may bring to a grid whose worlds cannot be read."""
    documents = [load(study.folder / "sim" / "world.yaml"), *([_file(study)] if study.grid_name else [])]
    bodies = {path.partition("bodies.")[2].split(".")[0] for document in documents for path, _ in leaves(document)}
    return [
        *(name for kind in HAPPENINGS.values() for name in kind.signals),
        *(f"{body}_{axis}_m" for body in bodies for axis in "xy"),
        *(clearance_name(body) for body in bodies),
    ]


def _check_predicate(
    axis: Axis, value: AxisValue, known: pieces.KnownSignals, passing: Collection[str], findings: Findings
) -> None:
    name = f"{axis.id}{value.id}"
    try:
        pieces.check_predicate(value.realised, value.place, name, known, passing, findings)
    except FormulaError as error:
        findings.error(InputError(f"{value.place}: realised of {name} {error}"))


def _check_choice(grid: grids_of.Grid) -> None:
    """Refuse a `choose` that is no choice.

    Raises:
        InputError: it is none.
    """
    if not any(strategy.pattern.fullmatch(grid.choose) for strategy in STRATEGIES.values()):
        raise InputError(f"{grid.chosen_at}={grid.choose!r} must be {hint()}")


def _chosen(grid: grids_of.Grid) -> tuple[tuple[str, ...], int]:
    """The situations to build, all of a small grid; and how many pairs of values they have."""
    keys = tuple(grid.by_key)
    array, pairs = greedy_array(Space.of(grid), keys, min(2, len(grid.axes)))
    return (keys if len(keys) <= MOST_LISTED else array), pairs


def _build(study: Study, grid: grids_of.Grid, keys: Iterable[str], findings: Findings) -> tuple[int, int]:
    """Build the situations and look at their routes; the same reason in several situations is told once."""
    sim = load_sim(study.folder / "sim", grid=grid)
    routes, built, told = pieces.RouteCheck(findings), 0, set[str]()
    for key in keys:
        try:
            scenario = sim.scenario(grid.by_key[key])
        except InputError as error:
            found = finding_of(str(error), situation=key)
            what = _SHOWN_IN.sub("", found.what)
            about = f"{found.place} {what.split(' in ' + key)[0]}"
            if about not in told:
                told.add(about)
                findings.add(Finding(Severity.ERROR, found.file, found.line, what, key, found.remedy))
            continue
        built += 1
        if study.command is None:
            routes.check(scenario, grid.documents_with(grid.values(scenario.situation).values())["world"])
    return built, routes.looked_at


_CHANGES_MINE = re.compile(r"\.set\.(world\.)?mine\b")


def check_plugins(findings: Findings) -> int:
    """Load every plugin; returns how many there are."""
    plugins = sorted(entry_points(group=PLUGIN_GROUP))
    for plugin in plugins:
        if error := refused(load_plugin, plugin):
            what, _, remedy = str(error).rpartition("; ")
            findings.add(Finding(Severity.ERROR, "", None, what, remedy=remedy))
    return len(plugins)


def check_operators(cells: Iterable[Cell], findings: Findings) -> None:
    """The operators of plugins whose example cannot be flown: an error where a cell uses one, else a note."""
    used = {fault.operator for cell in cells for fault in cell.faults}
    for name, one in OPERATORS.items():
        try:
            one.arrived()
        except TapError as error:
            severity = Severity.ERROR if name in used else Severity.NOTE
            what = f"{plugin_behind(error) or one.make.__module__}: {error}"
            findings.add(Finding(severity, "", None, what, remedy="mend or uninstall it"))


def check_stack_choice(study: Study, findings: Findings) -> Declaration | None:
    """The declaration of the study's stack, with its settings checked; None where it cannot be read."""
    declared: Declaration | None = None
    with findings.collecting():
        _ = study.command
    with findings.collecting():
        declared = study.stack
        choice = StackChoice.read(load(study.folder / "sim" / "stack.yaml"))
        settings = choice.settings(choice.declaration)
        if isinstance(settings, OutsideConfig):
            _check_processes(study, choice.document, settings, findings)
    return declared


def _check_processes(study: Study, document: Item, settings: OutsideConfig, findings: Findings) -> None:
    """The programs of a stack outside, and the software of its border, on this machine."""
    if error := refused(BORDERS[settings.border].need):
        place = document.need("border").place
        findings.note(place, f"border {settings.border!r} cannot be used on this machine: {error}", "install it there")
    items = document.need("processes").items()
    for item, process in zip(items, settings.processes, strict=True):
        program, *words = process.run
        place = program.replace("{study}", str(study.folder.absolute()))
        if "{" not in place and not runs(place, study.folder / process.folder):
            what = f"there is no program {program!r} on this machine that can be run"
            findings.note(item.place, what, "install it where flights run")
        for word in words:
            path = Path(word.replace("{study}", str(study.folder)))
            if word.startswith("{study}/") and not is_there(path):
                findings.wrong(item.place, f"the study has no file {word.removeprefix('{study}/')!r}", "add it")


def known_signals(study: Study, stack: Declaration | None, world: World | None) -> pieces.KnownSignals | None:
    """The signals of the study in one of its worlds; None where its stack is unknown.

    Where the world cannot be read, the bodies are known by their names alone.

    Raises:
        InputError: the mapping of a command's record cannot be read.
    """
    if stack is None:
        return None
    if world is None:
        entries = load(study.folder / "sim" / "world.yaml").mapping()
        bodies = entries["bodies"].value if "bodies" in entries else {}
        surfaces = (WALL, GROUND, *(bodies if isinstance(bodies, dict) else ()))
        return pieces.KnownSignals(dict.fromkeys(signal_names(surfaces, stack.beliefs, list(SIGNALS)), ANY), stack.caps)
    ours = signal_names(world.surfaces, stack.beliefs, world.signals)
    optional = {name: SIGNALS[name].most for name in world.signals if math.isfinite(SIGNALS[name].most)}
    ranges = dict(ranges_of(world, stack.beliefs, ours))
    if study.command is not None:
        measured = {name: ANY if cap_of(name, stack.caps) else spans for name, spans in ranges.items()}
        return pieces.KnownSignals({**dict.fromkeys(_recorded(study), ANY), **measured}, None)
    ranges |= {**without(world), **_rock(study, world), "elapsed_s": ((0.0, _longest_s(study)),)}
    return pieces.KnownSignals(ranges, {**stack.caps, **optional})


def _longest_s(study: Study) -> float:
    """The longest time limit in the situations of the study's own grid, by pairs of values where they are many [s]."""
    if study.grid_name is not None:
        return math.inf
    try:
        sim = load_sim(study.folder / "sim", grid=study.grid)
        return max(sim.scenario(study.grid.by_key[key]).t_max_s for key in _chosen(study.grid)[0]) + TICK_S
    except InputError:  # it is told where the grid is checked
        return math.inf


def _recorded(study: Study) -> tuple[str, ...]:
    """The signals that the record of a command brings."""
    path = study.folder / "sim" / "record.yaml"
    return tuple(load_record_map(path).signals) if is_there(path) else ()


def _rock(study: Study, world: World) -> Ranges:
    """Where the rock ends, unless an axis changes the mine."""
    sim = study.folder / "sim"
    for path in (sim / grids_of.FILE, *sorted((sim / grids_of.FOLDER).glob("*.yaml"))):
        if any(_CHANGES_MINE.search(place) for place, _ in leaves(load(path))):
            return {}
    return within_rock(world)


def check_command_of(study: Study, findings: Findings) -> None:
    """What would fail in each flight of the study's command."""
    command = study.command
    if command is None:
        with findings.collecting():
            mapping_of(study)
        return
    for name in command.inputs:
        if not is_file(study.folder / name):
            what = f"the study has no file {name!r}, which decides what is flown"
            findings.wrong(command.place, what, "add it, or take it out of `inputs`")
    notes: list[str] = []
    with findings.collecting():
        check_command(study, command, notes.append)
    record = study.folder / "sim" / "record.yaml"
    for note in notes:
        findings.add(finding_of(f"{record}:1: {note}; map it under `signals`", Severity.NOTE))


NEEDED = {"hazop": ("guidewords", "parameters"), "sim": (*DOCUMENTS, "requirements")}
OPTIONAL = {
    "hazop": ("score", "severities", "dispositions"),
    "sim": ("sources", Path(grids_of.FOUND_FILE).stem, "flyer", "record"),
}


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
    for path in sorted((folder / "sim" / grids_of.FOLDER).glob("*.y*ml")):
        if path.suffix != ".yaml" or not grids_of.is_grid_name(path.stem):
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
    yield from sorted(
        path for path in (folder / "sim" / grids_of.FOLDER).glob("*.yaml") if grids_of.is_grid_name(path.stem)
    )


def _stray(folder: Path, known: list[Path]) -> Iterator[Path]:
    for part in NEEDED:
        yield from (path for path in sorted((folder / part).glob("*.y*ml")) if path not in known)


def check_seams(study: Study, findings: Findings, allow: Callable[[Study], None]) -> tuple[int | None, str]:
    """Fly the baseline once in the first situation, and hold every poll against the declaration.

    Returns:
        How many seams the stack polls, and ""; or None, and why nothing was flown.
    """
    if findings.errors:
        return None, "not flown, because the study has errors"
    if study.command is not None:
        return None, "not flown, because a command flies this study"
    situation, place = study.grid.situations[0], str(study.folder / "sim" / "stack.yaml")
    allow(study)
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
    path = study.folder / "sim" / grids_of.FOUND_FILE
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

    accepted = 0

    def read(entry: tuple[str, Item]) -> None:
        nonlocal accepted
        _, disposition = read_disposition(*entry, matrix, situations)
        accepted += disposition is not None

    with findings.collecting():
        findings.each(read, tuple(load(path).mapping().items()))
        _ = study.dispositions  # tells what is there twice
    return accepted


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


def check_study(folder: Path, *, fly: bool = False, allow: Callable[[Study], None] = lambda _study: None) -> Check:
    """Check every part of a study on its own; nothing is written, and without `fly` nothing is flown.

    Args:
        folder: the study.
        fly: whether one baseline flight shows which seams the stack polls.
        allow: called before that flight; it may refuse what the study starts.

    Raises:
        InputError: as `allow`.
    """
    findings, study, sim = Findings(), Study(folder), folder / "sim"
    plugins = check_plugins(findings)
    documents = check_documents(folder, findings)
    stack = check_stack_choice(study, findings)
    world = pieces.check_world(sim / "world.yaml", findings)
    pieces.check_vehicle(sim, findings)
    known = _known(study, stack, world, findings)
    requirements = pieces.check_requirements(sim / "requirements.yaml", known, findings) if known else None
    grids = (check_grid(study, grid_of(study, findings), known, findings), *_further(study, stack, world, findings))
    matrix = pieces.check_matrix(study, stack, pieces.kinds_in(sim / "requirements.yaml"), findings)
    check_operators(matrix.cells, findings)
    found = accepted = 0
    if matrix.matrix is not None:
        found = check_found(study, findings)
        accepted = check_dispositions(study, matrix.matrix, SituationKeys(study), findings)
    if not findings.errors:
        check_sources(study, findings)
        check_command_of(study, findings)
    polled, unflown = check_seams(study, findings, allow) if fly else (None, "`scaloft-fi check --fly` flies once")
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


def _known(
    study: Study, stack: Declaration | None, world: World | None, findings: Findings
) -> pieces.KnownSignals | None:
    with findings.collecting():
        return known_signals(study, stack, world)
    return None


def _further(study: Study, stack: Declaration | None, world: World | None, findings: Findings) -> Iterator[GridCheck]:
    """The check of each further grid, with the world that it makes of the study's by what it adds."""
    names: tuple[str, ...] = ()
    with findings.collecting():
        names = grids_of.grid_names(study.folder / "sim")[1:]
    for name in names:
        if name.endswith(grids_of.WITH_FOUND) and _has_misfits(study):
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
