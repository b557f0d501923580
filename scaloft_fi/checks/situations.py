"""A grid of situations: axes, predicates, pairs of values that are built; the stack and the signals that it brings."""

from __future__ import annotations

import math
import re
import shutil
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.analysis.coverage import greedy_array
from scaloft_fi.checks.finding import Finding, Findings, Severity, finding_of
from scaloft_fi.checks.matrix import KnownSignals, check_predicate
from scaloft_fi.checks.world import RouteCheck
from scaloft_fi.document import Item, is_file, is_there, load
from scaloft_fi.errors import InputError
from scaloft_fi.judge.bounds import ANY, Ranges, ranges_of, within_rock, without
from scaloft_fi.judge.space import MOST_LISTED, Space
from scaloft_fi.judge.stl import FormulaError
from scaloft_fi.model import value_of
from scaloft_fi.registry import PLUGIN_GROUP, load_plugin
from scaloft_fi.sim.grid import FILE, FOLDER, WITH_FOUND, Grid, assembled, contradictions
from scaloft_fi.sim.happenings import HAPPENINGS
from scaloft_fi.sim.log import SIGNALS, clearance_name, signal_names
from scaloft_fi.sim.patch import PARTS, leaves
from scaloft_fi.sim.situation import Axis, AxisModel, AxisValue
from scaloft_fi.sim.stacks import StackChoice
from scaloft_fi.sim.world import GROUND, WALL

if TYPE_CHECKING:
    from scaloft_fi.outside.exchange import OutsideConfig
    from scaloft_fi.sim.load import SimConfig
    from scaloft_fi.sim.world import World
    from scaloft_fi.stack.declaration import Declaration
    from scaloft_fi.study import Study


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


def check_grid(study: Study, grid: Grid | None, known: KnownSignals | None, findings: Findings) -> GridCheck:
    """Check one grid of a study.

    Args:
        study: the study with that grid.
        grid: as `grid_of` reads it.
        known: its signals; None where they are unknown, which leaves the predicates unchecked.
        findings: takes the findings.
    """
    name = study.grid_name or (grid.name if grid else FILE)
    if grid is None and name.endswith(WITH_FOUND):
        return GridCheck(name)
    axes = grid.axes if grid else _axes(study, findings)
    predicates = [(axis, value) for axis in axes for value in (*axis.values, *axis.extremes) if value.realised]
    # the situations of a search are in the axes of another grid, which has been checked
    agreed = grid is not None and (grid.listed is not None or findings.all_of(contradictions(grid)))
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


def grid_of(study: Study, findings: Findings) -> Grid | None:
    """The grid of a study, without a check that its axes agree; None where it cannot be read."""
    folder, name = study.folder / "sim", study.grid_name
    with findings.collecting():
        if name is not None and name.endswith(WITH_FOUND):
            return study.grid
        documents = {part: load(folder / f"{part}.yaml") for part in PARTS}
        return assembled(_file(study), documents, name)
    return None


def _file(study: Study) -> Item:
    folder, name = study.folder / "sim", study.grid_name
    return load(folder / FILE if name is None else folder / FOLDER / f"{name}.yaml")


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
    axis: Axis, value: AxisValue, known: KnownSignals, passing: Collection[str], findings: Findings
) -> None:
    name = f"{axis.id}{value.id}"
    try:
        check_predicate(value.realised, value.place, name, known, passing, findings)
    except FormulaError as error:
        findings.error(InputError(f"{value.place}: realised of {name} {error}"))


def _check_choice(grid: Grid) -> None:
    """Refuse a `choose` that is no choice.

    Raises:
        InputError: it is none.
    """
    from scaloft_fi.campaign.runs.request import STRATEGIES, hint

    if not any(strategy.pattern.fullmatch(grid.choose) for strategy in STRATEGIES.values()):
        raise InputError(f"{grid.chosen_at}={grid.choose!r} must be {hint()}")


def _chosen(grid: Grid) -> tuple[tuple[str, ...], int]:
    """The situations to build, all of a small grid; and how many pairs of values they have."""
    keys = tuple(grid.by_key)
    array, pairs = greedy_array(Space.of(grid), keys, min(2, len(grid.axes)))
    return (keys if len(keys) <= MOST_LISTED else array), pairs


def _build(study: Study, grid: Grid, keys: Iterable[str], findings: Findings) -> tuple[int, int]:
    """Build the situations and look at their routes; the same reason in several situations is told once."""
    from scaloft_fi.sim.load import load as load_sim

    sim: SimConfig = load_sim(study.folder / "sim", grid=grid)
    routes, built, told = RouteCheck(findings), 0, set[str]()
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
        try:
            load_plugin(plugin)
        except InputError as error:
            what, _, remedy = str(error).rpartition("; ")
            findings.add(Finding(Severity.ERROR, "", None, what, remedy=remedy))
    return len(plugins)


def check_stack_choice(study: Study, findings: Findings) -> Declaration | None:
    """The declaration of the study's stack, with its settings checked; None where it cannot be read."""
    declared: Declaration | None = None
    with findings.collecting():
        _ = study.command
    with findings.collecting():
        declared = study.stack
        choice = StackChoice.read(load(study.folder / "sim" / "stack.yaml"))
        settings = choice.settings(choice.declaration)
        if choice.name == "outside":
            _check_processes(study, choice.document, settings, findings)
    return declared


def _check_processes(study: Study, document: Item, settings: OutsideConfig, findings: Findings) -> None:
    """The programs of a stack outside, and the software of its border, on this machine."""
    from scaloft_fi.outside.border import BORDERS

    try:
        BORDERS[settings.border].need()
    except InputError as error:
        place = document.need("border").place
        findings.note(place, f"border {settings.border!r} cannot be used on this machine: {error}", "install it there")
    items = document.need("processes").items()
    for item, process in zip(items, settings.processes, strict=True):
        program, *words = process.run
        folder = study.folder / process.folder
        if "{" not in program and shutil.which(program) is None and not is_file(folder / program):
            what = f"there is no program {program!r} on this machine"
            findings.note(item.place, what, "install it where flights run")
        for word in words:
            path = Path(word.replace("{study}", str(study.folder)))
            if word.startswith("{study}/") and not is_there(path):
                findings.wrong(item.place, f"the study has no file {word.removeprefix('{study}/')!r}", "add it")


def known_signals(study: Study, stack: Declaration | None, world: World | None) -> KnownSignals | None:
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
        return KnownSignals(dict.fromkeys(signal_names(surfaces, stack.beliefs, list(SIGNALS)), ANY), stack.caps)
    ours = signal_names(world.surfaces, stack.beliefs, world.signals)
    optional = {name: SIGNALS[name].most for name in world.signals if math.isfinite(SIGNALS[name].most)}
    ranges = dict(ranges_of(world, stack.beliefs, ours))
    if study.command is not None:
        return KnownSignals({**dict.fromkeys(_recorded(study), ANY), **ranges}, {**stack.caps, **optional})
    return KnownSignals(ranges | dict(without(world)) | dict(_rock(study, world)), {**stack.caps, **optional})


def _recorded(study: Study) -> tuple[str, ...]:
    """The signals that the record of a command brings."""
    from scaloft_fi.outside.records.record_map import load_record_map

    path = study.folder / "sim" / "record.yaml"
    return tuple(load_record_map(path).signals) if is_there(path) else ()


def _rock(study: Study, world: World) -> Ranges:
    """Where the rock ends, unless an axis changes the mine."""
    sim = study.folder / "sim"
    for path in (sim / FILE, *sorted((sim / FOLDER).glob("*.yaml"))):
        if any(_CHANGES_MINE.search(place) for place, _ in leaves(load(path))):
            return {}
    return within_rock(world)


def check_command_of(study: Study, findings: Findings) -> None:
    """What would fail in each flight of the study's command."""
    from scaloft_fi.campaign.flights.command import check_command, mapping_of

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
