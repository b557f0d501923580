"""A grid of situations: every axis, every predicate, every pair of values in a situation that is built."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scaloft_fi.analysis.situations.covering import greedy_array
from scaloft_fi.checks.finding import Finding, Findings, Severity, finding_of
from scaloft_fi.checks.requirements import KnownSignals, check_predicate
from scaloft_fi.checks.routes import RouteCheck
from scaloft_fi.document import Item, load
from scaloft_fi.errors import InputError
from scaloft_fi.judge.space import MOST_LISTED
from scaloft_fi.judge.stl import FormulaError
from scaloft_fi.sim.grid import Grid, assembled, contradictions
from scaloft_fi.sim.grids import FILE, FOLDER, WITH_FOUND
from scaloft_fi.sim.happenings import HAPPENINGS
from scaloft_fi.sim.log import clearance_name
from scaloft_fi.sim.patch import PARTS, leaves
from scaloft_fi.sim.situation import Axis, AxisValue, read_axis, read_constraints

if TYPE_CHECKING:
    from scaloft_fi.sim.load import SimConfig
    from scaloft_fi.study import Study

_SHOWN_IN = re.compile(r",? as in situation \S+")


@dataclass(frozen=True)
class GridCheck:
    """What was checked of a grid.

    Attributes:
        name: name of the grid.
        situations: number of its situations; 0 where it cannot be read.
        built: number of situations whose world, vehicle, sensors and route were built.
        pairs: number of pairs of values of two axes that situations have, each of them built.
        predicates: number of formulas `realised`.
        legs: number of waypoints, and legs between them, with which the hull was compared.
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
    """The axes of a grid that cannot be read whole, those that can be read."""
    with findings.collecting():
        item = _file(study)
        entries = item.need("axes").mapping()
        axes = findings.each(lambda one: read_axis(*one), entries.items())
        if len(axes) == len(entries) and (constraints := item.get("constraints")):
            findings.each(lambda one: read_constraints(one, axes), _alone(constraints))
        return tuple(axes)
    return ()


def _alone(constraints: Item) -> Iterable[Item]:
    """A list of one constraint for each."""
    for item in constraints.items():
        yield Item(item.path, item.line, item.name, (item,))


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
    from scaloft_fi.campaign.runs.choice import hint
    from scaloft_fi.campaign.runs.strategy import STRATEGIES

    if not any(strategy.pattern.fullmatch(grid.choose) for strategy in STRATEGIES.values()):
        raise InputError(f"{grid.chosen_at}={grid.choose!r} must be {hint()}")


def _chosen(grid: Grid) -> tuple[tuple[str, ...], int]:
    """The situations to build, all of a small grid; and how many pairs of values they have."""
    from scaloft_fi.judge.space import Space

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
                findings.add(Finding(Severity.ERROR, found.file, found.line, what, found.remedy, key))
            continue
        built += 1
        if study.command is None:
            routes.check(scenario, grid.documents_with(grid.values(scenario.situation).values())["world"])
    return built, routes.looked_at
