"""`scaloft-fi axes`, `coverage`, `map`: the axes of situations, what a campaign covers of them, one as a map."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from scaloft_fi.analysis.coverage import SHARES, Coverage, coverage_of
from scaloft_fi.analysis.detection import LEAST, State
from scaloft_fi.campaign.store.held import Remembered
from scaloft_fi.document import Item, load
from scaloft_fi.errors import InputError
from scaloft_fi.judge.space import Space
from scaloft_fi.marks import Called, Choices
from scaloft_fi.output import say, write_named
from scaloft_fi.sim.grid import Grid
from scaloft_fi.sim.happenings import Happening
from scaloft_fi.sim.mesh import Flaw
from scaloft_fi.sim.mine import flaws_of
from scaloft_fi.sim.situation import Axis, Drawn, FreeAxis, Shape, Situation, number_text
from scaloft_fi.sim.world import assembled
from scaloft_fi.study import Study
from scaloft_fi.verbs import options
from scaloft_fi.verbs.listing import Entry, Listing
from scaloft_fi.verbs.names import axes, situations
from scaloft_fi.verbs.snapshot import Stale, snapshot
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.picture import FloorPlan, Happens, draw_plan, png, scene_of
from scaloft_fi.views.table import Table, said

VALUES, RANGE, FREE = "values", "range", "free"


@dataclass(frozen=True)
class Change:
    """A change.

    Attributes:
        path: path of a value of the study.
        value: its new value.
    """

    path: str
    value: Any

    def __str__(self) -> str:
        return f"{self.path}: {self.value}"


@dataclass(frozen=True)
class ListedValue:
    """A value.

    Attributes:
        name: its name in keys.
        title: its name in tables.
        changes: what it sets.
        realised: formula: whether a flight met it.
    """

    name: str
    title: str
    changes: Annotated[tuple[Change, ...], Called("set")]
    realised: str


@dataclass(frozen=True)
class Companion:
    """An axis.

    Attributes:
        axis: its name.
        values: ids of its values.
    """

    axis: str
    values: tuple[str, ...]


@dataclass(frozen=True)
class ListedAxis(Entry):
    """An axis.

    Attributes:
        name: its name in keys.
        title: its name in tables.
        category: category of the operational design domain.
        kind: single values, a range of one number, or a number that spans no grid.
        keys: how keys of situations name its values.
        benign: its benign value.
        summary: its values in words.
        values: its values, of a range its bins; none of a free axis.
        distribution: distribution of the number; empty for single values.
        path: path of the number; empty for single values.
        realised: formula of a range, with the word `number`; empty for others.
        unit: unit of the number; empty for single values.
        low: lower end; null: an axis with single values.
        high: upper end; null: an axis with single values.
        also: what else a number off the benign value sets.
        only_with: values of other axes without which a free axis has no effect or cannot be.
    """

    title: str
    category: str
    kind: Annotated[str, Choices((VALUES, RANGE, FREE))]
    keys: tuple[str, ...]
    benign: str
    summary: str
    values: tuple[ListedValue, ...] = ()
    distribution: str = ""
    path: Annotated[str, Called("set")] = ""
    realised: str = ""
    unit: str = ""
    low: Annotated[float | None, Called("from")] = None
    high: Annotated[float | None, Called("to")] = None
    also: tuple[Change, ...] = ()
    only_with: tuple[Companion, ...] = ()

    def sheet(self) -> Sequence[tuple[str, str]]:
        """The axis whole."""
        rows = [("title", self.title), ("category", self.category), ("benign", self.benign)]
        rows.append(("in keys", ", ".join(self.keys)))
        if self.kind != VALUES:
            rows += [("numbers", self.summary), ("sets", self.path)]
            rows += [("sets off benign", str(each)) for each in self.also]
            rows += [("only with", f"{each.axis}{'/'.join(each.values)}") for each in self.only_with]
            rows.append(("realised", self.realised))
        for value in self.values:
            heading = f"{value.name} {value.title}"
            if self.kind == VALUES:
                rows += [(heading, f"sets {each}") for each in value.changes]
                rows.append((heading, f"met if {value.realised}"))
            else:
                rows.append(("bins", heading))
        return rows


@dataclass(frozen=True)
class Axes:
    """The axes of a grid of situations.

    Attributes:
        axes: the axes, the free ones last.
    """

    axes: tuple[ListedAxis, ...]


AXES = Output("axes", "1.0", Axes, rows="axes")
AXIS_OVERVIEW = {"axis": "name", "title": "title", "category": "category", "kind": "kind", "values": "summary"}


def axis_list(grid: Grid) -> Listing[ListedAxis]:
    """Every axis of a grid, the free ones last."""
    listed = (*map(_spanning, grid.axes), *map(_free, grid.free))
    situations = f"{len(grid):,} situations with keys like {''.join(f'{axis.id}0' for axis in grid.axes)}"
    notes = [f"{situations}; 0 is the benign value of an axis."]
    if grid.free:
        left_out = "at its benign value it is left out of the key, else it stands at the end"
        notes.append(f"A free axis spans no grid: {left_out}.")
    for one in grid.constraints:
        excluded = (f"{axis}{'/'.join(map(str, sorted(values)))}" for axis, values in one.excluded.items())
        notes.append(f"excluded: {' with '.join(excluded)}: {one.reason}")
    if grid.aliases:
        notes.append("other names: " + ", ".join(f"{alias} = {key}" for alias, key in list(grid.aliases.items())[:12]))
    notes.append("`scaloft-fi axes NAME` shows one whole; category: of the operational design domain.")
    return Listing("axis", f"Axes of the grid {grid.name}: {len(listed)}", AXIS_OVERVIEW, listed, AXES, tuple(notes))


def _spanning(axis: Axis) -> ListedAxis:
    met = ", ".join(f"{axis.id}{value.id}" for value in axis.values if value.realised)
    benign, *others = (value.title for value in axis.values)
    keys = tuple(f"{axis.id}{value.id}" for value in axis.values)
    values = tuple(
        ListedValue(key, value.title, _changes(value.changes), value.realised or f"none of {met} is met")
        for key, value in zip(keys, axis.values, strict=True)
    )
    if (own := axis.range) is None:
        summary = f"{benign} (benign), {', '.join(others)}"
        return ListedAxis(axis.id, axis.title, axis.category, VALUES, keys, benign, summary, values)
    middle = next(bin_ for bin_ in own.ids if bin_ != 0)
    drawn = _drawn(axis, own, RANGE, (*keys, f"{axis.id}{middle}={number_text(own.middle(middle))}"))
    summary = f"{drawn.summary}, {len(own.ids)} bins"
    return replace(drawn, summary=summary, values=values, realised=axis.realised)


def _free(axis: FreeAxis) -> ListedAxis:
    only_with = (Companion(name, tuple(map(str, sorted(ids)))) for name, ids in axis.only_with.items())
    drawn = _drawn(axis, axis, FREE, (f"{axis.id}={number_text(axis.at(0.5))}",))
    return replace(drawn, also=_changes(axis.also), only_with=tuple(only_with))


def _drawn(axis: Axis | FreeAxis, own: Drawn, kind: str, keys: tuple[str, ...]) -> ListedAxis:
    """What is told of every axis of a number."""
    return ListedAxis(
        *(axis.id, axis.title, axis.category, kind, keys),
        benign=f"{number_text(own.benign)} {own.unit}",
        summary=f"{number_text(own.low)} to {number_text(own.high)} {own.unit}, {_shape(own)}",
        distribution=_shape(own),
        path=own.path,
        unit=own.unit,
        low=own.low,
        high=own.high,
    )


def _changes(items: Mapping[str, Item]) -> tuple[Change, ...]:
    return tuple(Change(path, item.plain()) for path, item in items.items())


def _shape(own: Drawn) -> str:
    if own.shape is Shape.NORMAL:
        return f"{own.shape} (mean {own.mean:g}, sd {own.sd:g})"
    return f"{own.shape} (mode {own.mode:g})" if own.shape is Shape.TRIANGULAR else str(own.shape)


Names = Annotated[tuple[str, ...], options.Option("", "", metavar="[NAME]...", complete=axes)]


@options.verb("axes")
def axes_command(names: Names = (), *, study_folder: options.StudyFolder, grid: options.GridOfStudy) -> Answer:
    """List the axes of a grid of situations.

    Without a NAME an overview.  Names, and patterns with *, ? or [, show these whole:  what each value sets, and
    the formula that says whether a flight met it.

    Examples:
        List the axes of the study's own grid: `scaloft-fi axes`
        Show one whole: `scaloft-fi axes H`
        List those of the grid `search`, as Markdown: `scaloft-fi axes --grid search --format markdown`
    """
    return axis_list(Study.open(study_folder, grid).grid).answer(names)


@dataclass(frozen=True)
class CampaignCoverage:
    """How much of the situations a campaign covers.

    Attributes:
        coverage: how much of the situations the flights cover.
        choices: how `run --choose` chose situations.
        stale: the stored flights that no longer count and were not flown again.
    """

    coverage: Coverage
    choices: tuple[Remembered, ...]
    stale: Stale


COVERAGE = Output("coverage", "1.1", CampaignCoverage, rows="summary")

MEANINGS = {
    State.STEADY: "at least nine tenths of the baseline's flights hold it: it tests a fault",
    State.UNSTEADY: "the baseline holds it or not by chance",
    State.RED: "most of the baseline's flights violate it",
    State.OPEN: "more than a tenth of the baseline's flights end before it is judged",
    State.VACUOUS: "less than half of the baseline's flights trigger it",
    State.UNKNOWN: f"the situation has fewer than {LEAST} baseline flights",
}


def coverage_tables(covered: Coverage, space: Space, choices: Sequence[Remembered] = ()) -> tuple[Table, ...]:
    """Every number of the coverage.

    Args:
        covered: the coverage.
        space: the grid.
        choices: how situations were chosen.
    """
    rows = [
        ("distinct situations", str(covered.situations), "situations of the grid"),
        ("draws", str(covered.draws), "test cases: situations flown, each seed anew"),
        *([("pool", str(covered.pool), "of these draws, the baseline's alone, to decide by")] if covered.pool else []),
        ("realised", str(covered.realised), "situations whose every value came true in a baseline flight"),
        ("steady pairs", str(covered.steady), "situation x safety requirement, where the baseline has a pool"),
    ]
    true = "flown situations where the value on that axis came true"
    rows += [(f"realised {axis}", str(ratio), true) for axis, ratio in covered.by_axis]
    judged = "flown situations where it was triggered and judged"
    rows += [(f"triggered {name}", str(ratio), judged) for name, ratio in covered.requirements]
    states = tuple((state.value, covered.states[state], meaning) for state, meaning in MEANINGS.items())
    tables = [
        Table("Situation coverage", ("coverage", "part/whole", "of"), tuple(rows)),
        Table("Safety requirements in the situations flown", ("state", "pairs", "meaning"), states),
        _t_way(covered, len(space.axes)),
    ]
    if choices:
        headers = ("--choose", "--choose-seed", "test cases", "distinct situations")
        cases = [(one.text, one.seed, len(one.draws), len({case.situation for case in one.draws})) for one in choices]
        tables.append(Table("How situations were chosen", headers, tuple(cases)))
    return tuple(tables)


def _t_way(covered: Coverage, axes: int) -> Table:
    possible = (one for one in covered.combinations if one.strength <= axes)
    rows = tuple((f"{one.strength}-way", str(one.total), *map(str, one.completeness)) for one in possible)
    headers = ("combinations", "covered", *(f"p = {share:g}" for share in SHARES))
    notes = (
        "Covered: value combinations of t axes that were flown, of all that the grid has.",
        "p: (p, t)-completeness: choices of t axes with at least the share p of these covered.",
    )
    return Table("Combinations of axis values", headers, rows, notes)


def coverage(study: Study, campaign: options.Campaign) -> Answer:
    """How much of the situations a campaign covers, number by number.

    Examples:
        Ask how much of the grid was flown, pair by pair: `scaloft-fi coverage`
        Look at another campaign: `scaloft-fi coverage --campaign night`
        Let a script read it: `scaloft-fi coverage --format json`

    Raises:
        InputError: there is no such campaign, or it holds no flight that counts.
    """
    with snapshot(study, campaign) as now:
        space, rulings, remembered, stale = now.study.space, now.rulings, now.choices, now.stale
    covered = coverage_of(rulings.baselines, rulings.draws, space)
    told = CampaignCoverage(covered, tuple(remembered), stale)
    tables = [said(one, of_tests=space.of_tests) for one in coverage_tables(covered, space, remembered)]
    return Answer(COVERAGE, lambda: told, lambda: tables, warnings=stale.sentences)


coverage_command = options.verb("coverage")(coverage)


@dataclass(frozen=True)
class Box:
    """The box around walls and floor.

    Attributes:
        least_x_m: lowest end of it, east [m].
        least_y_m: lowest end of it, north [m].
        least_z_m: lowest end of it, height [m].
        most_x_m: highest end of it, east [m].
        most_y_m: highest end of it, north [m].
        most_z_m: highest end of it, height [m].
    """

    least_x_m: float
    least_y_m: float
    least_z_m: float
    most_x_m: float
    most_y_m: float
    most_z_m: float


@dataclass(frozen=True)
class Stop:
    """A place.

    Attributes:
        place: its name.
        x_m: east [m].
        y_m: north [m].
        z_m: height [m].
    """

    place: str
    x_m: float
    y_m: float
    z_m: float


@dataclass(frozen=True)
class Standing:
    """A body.

    Attributes:
        body: its name.
        role: its role.
        x_m: east [m].
        y_m: north [m].
        z_m: height [m].
    """

    body: str
    role: str
    x_m: float
    y_m: float
    z_m: float


@dataclass(frozen=True)
class Occurrence:
    """A happening.

    Attributes:
        happening: its name.
        moves: the body that it moves; empty for none.
        at_s: earliest time [s].
        near_x_m: east of the place that starts it [m]; null: a time starts it.
        near_y_m: north of the place that starts it [m]; null: a time starts it.
        within_m: distance from that place [m].
        lasts_s: how long it lasts [s]; null: to the end.
    """

    happening: str
    moves: str
    at_s: float
    near_x_m: float | None
    near_y_m: float | None
    within_m: float
    lasts_s: float | None

    @classmethod
    def of(cls, one: Happening) -> Occurrence:
        """What is told of a happening."""
        x_m, y_m = one.start.near or (None, None)
        lasts_s = one.lasts_s if math.isfinite(one.lasts_s) else None
        return cls(one.name, one.effect.moved, one.start.at_s, x_m, y_m, one.start.within_m, lasts_s)

    @property
    def happens(self) -> Happens:
        """The same on the plan."""
        near = None if self.near_x_m is None or self.near_y_m is None else (self.near_x_m, self.near_y_m)
        when = [f"near ({near[0]:g}, {near[1]:g}) within {self.within_m:g} m"] if near else []
        if self.at_s:
            when.append(f"{'not before' if near else 'at'} {self.at_s:g} s")
        lasts = "" if self.lasts_s is None else f", for {self.lasts_s:g} s"
        moves = f", moves {self.moves}" * bool(self.moves)
        return Happens(f"{self.happening}: {', '.join(when) or 'from take-off'}{lasts}{moves}", near, self.within_m)


@dataclass(frozen=True)
class SituationMap:
    """What stands and happens in one situation, without flying it.

    Attributes:
        situation: key of the situation.
        values: the values of its axes, in words.
        nominal_s: time of the nominal flight [s].
        limit_s: time limit of a flight [s].
        mine: the box around walls and floor.
        places: home, then the waypoints in order; it lands at the last one.
        bodies: the bodies that are there.
        happenings: what happens.
    """

    situation: str
    values: tuple[str, ...]
    nominal_s: float
    limit_s: float
    mine: Box
    places: tuple[Stop, ...]
    bodies: tuple[Standing, ...]
    happenings: tuple[Occurrence, ...]


MAP = Output("map", "1.0", SituationMap, rows="places")


def map_of(study: Study, situation: Situation) -> SituationMap:
    """What stands and happens in a situation.

    Raises:
        InputError: the values of the situation contradict each other.
    """
    scenario = study.scenario(situation)
    world = scenario.world
    return SituationMap(
        situation=situation.key,
        values=tuple(study.grid.titles(situation)),
        nominal_s=scenario.nominal_s,
        limit_s=scenario.t_max_s,
        mine=Box(*world.mine.extents.ravel().tolist()),
        places=tuple(Stop(name, *world.waypoints[name]) for name in ("home", *world.mission.route)),
        bodies=tuple(Standing(body.name, body.role, *body.centre) for body in world.present),
        happenings=tuple(map(Occurrence.of, world.happenings)),
    )


FLAW_M = 0.3
"""Radius of the ring around the first face of a flaw [m]."""


def _flaws(study: Study, situation: Situation) -> tuple[Flaw, ...]:
    world = study.grid.documents_with(study.grid.values(situation).values())["world"]
    return flaws_of(world.need("mine"))


def plan_of(study: Study, situation: Situation) -> FloorPlan:
    """The plan of a situation.

    Raises:
        InputError: the values of the situation contradict each other.
    """
    told, world = map_of(study, situation), study.scenario(situation).world
    mission = world.mission
    speeds = f"cruise {mission.cruise_mps:g} m/s, near a person {mission.slow_mps:g} m/s"
    return FloorPlan(
        scene_of(world),
        tuple((one.place, (one.x_m, one.y_m)) for one in told.places[1:]),
        (*(one.happens for one in told.happenings), *_rings(_flaws(study, situation))),
        (
            f"altitude {mission.altitude_m:g} m, {speeds}, light {world.light:g}",
            f"nominal flight {told.nominal_s:.0f} s, time limit {told.limit_s:.0f} s",
        ),
    )


def plan_of_mesh(folder: Path) -> FloorPlan | None:
    """The plan of a world that cannot be flown, with the flaws of its mesh; None where it has none or is unreadable."""
    with suppress(InputError):
        document = load(folder / "sim" / "world.yaml")
        world = assembled(document)
        places = world.waypoints
        if flaws := flaws_of(document.need("mine"), tuple(places.values())):
            stops = tuple((name, place[:2]) for name, place in places.items() if name != "home")
            return FloorPlan(scene_of(world), stops, _rings(flaws), tuple(f"mesh: {flaw.remedy}" for flaw in flaws[:3]))
    return None


def _rings(flaws: tuple[Flaw, ...]) -> tuple[Happens, ...]:
    return tuple(Happens(f"mesh: {flaw.sentence.split(',', 1)[0]}", flaw.at[:2], FLAW_M) for flaw in flaws)


def map_table(study: Study, situation: Situation) -> Table:
    """The facts of a situation in words."""
    told, plan = map_of(study, situation), plan_of(study, situation)
    bodies = (f"{one.body} ({one.role}) at ({one.x_m:g}, {one.y_m:g})" for one in told.bodies)
    rows = [
        ("situation", ", ".join(told.values)),
        ("mine [m]", study.scenario(situation).world.mine.extents_text),
        ("route [m]", ", ".join(f"{one.place} ({one.x_m:g}, {one.y_m:g}, {one.z_m:g})" for one in told.places)),
        ("bodies [m]", ", ".join(bodies) or "none"),
        *(("happens", one.happens.words) for one in told.happenings),
        *(("mesh", str(flaw)) for flaw in _flaws(study, situation)),
        *(("", fact) for fact in plan.facts),
    ]
    return Table(told.situation, ("what", ""), tuple(rows))


PICTURES = (".svg", ".png")


@options.verb("map")
def map_command(
    *,
    situation: Annotated[str | None, options.Option("", "", complete=situations)] = None,
    study_folder: options.StudyFolder,
    grid: options.GridOfStudy,
    output: Annotated[
        Path | None,
        options.Option(
            "Draw the map: mine, bodies, route, waypoints and happenings with their names and a scale (.svg, .png).",
            metavar="FILE",
        ),
    ],
    style: options.TableFormat,
) -> None:
    """Show mine, bodies, route and happenings of one situation, without flying it.

    SITUATION is a key or another name of it; by default every axis has its benign value.
    A mesh with flaws is drawn with a ring at each, even where it cannot be flown.

    Examples:
        Tell what stands and happens in the benign situation: `scaloft-fi map`
        Draw a situation with a corner and a person: `scaloft-fi map T1O0W0D0H1 --output map.svg`
        Draw a situation of the grid `wide`: `scaloft-fi map --grid wide --output map.png`
    """
    options.check_writable(output, *PICTURES)
    try:
        study = Study.open(study_folder, grid)
        one = study.grid.situation(situation) if situation else study.grid.situations[0]
        options.answer(Answer(MAP, lambda: map_of(study, one), lambda: (map_table(study, one),)), style)
        if output is not None:
            _draw(plan_of(study, one), output, one.key, ", ".join(study.grid.titles(one)))
    except InputError:
        if output is not None and (plan := plan_of_mesh(study_folder or Path())) is not None:
            _draw(plan, output, "The mesh", "its flaws; no situation can be flown")
        raise


def _draw(plan: FloorPlan, output: Path, title: str, subtitle: str) -> None:
    drawn = draw_plan(plan, title=title, subtitle=subtitle)
    write_named(output, png(drawn) if output.suffix.lower() == ".png" else drawn.encode())
    say(f"map: {output}")
