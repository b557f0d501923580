"""`scaloft-fi map`: mine, bodies and route of one situation, without flying."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from scaloft_fi.console import say
from scaloft_fi.document import load
from scaloft_fi.errors import InputError
from scaloft_fi.sim.happenings import Happening
from scaloft_fi.sim.mesh import Flaw
from scaloft_fi.sim.mine import flaws_of
from scaloft_fi.sim.situation import Situation
from scaloft_fi.sim.world import assembled
from scaloft_fi.study import Study
from scaloft_fi.verbs.names import situations
from scaloft_fi.verbs.options import GridOfStudy, Option, StudyFolder, TableFormat, answer, check_writable, verb, write
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.picture import FloorPlan, Happens, draw_plan, png, scene_of
from scaloft_fi.views.table import Table


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


@verb(
    "map",
    examples=(
        ("Tell what stands and happens in the benign situation", "scaloft-fi map"),
        ("Draw a situation with a corner and a person", "scaloft-fi map T1O0W0D0H1 --output map.svg"),
        ("Draw a situation of the grid `wide`", "scaloft-fi map --grid wide --output map.png"),
    ),
)
def map_command(
    *,
    situation: Annotated[str | None, Option("", "", complete=situations)] = None,
    study_folder: StudyFolder,
    grid: GridOfStudy,
    output: Annotated[
        Path | None,
        Option(
            "Draw the map: mine, bodies, route, waypoints and happenings with their names and a scale (.svg, .png).",
            metavar="FILE",
        ),
    ],
    style: TableFormat,
) -> None:
    """Show mine, bodies, route and happenings of one situation, without flying it.

    SITUATION is a key or another name of it; by default every axis has its benign value.
    A mesh with flaws is drawn with a ring at each, even where it cannot be flown.
    """
    check_writable(output, *PICTURES)
    try:
        study = Study.open(study_folder, grid)
        one = study.grid.situation(situation) if situation else study.grid.situations[0]
        answer(Answer(MAP, lambda: map_of(study, one), lambda: (map_table(study, one),)), style)
        if output is not None:
            _draw(plan_of(study, one), output, one.key, ", ".join(study.grid.titles(one)))
    except InputError:
        plan = plan_of_mesh(study_folder or Path()) if output is not None else None
        if output is not None and plan is not None:
            _draw(plan, output, "The mesh", "its flaws; no situation can be flown")
        raise


def _draw(plan: FloorPlan, output: Path, title: str, subtitle: str) -> None:
    drawn = draw_plan(plan, title=title, subtitle=subtitle)
    write(output, png(drawn) if output.suffix.lower() == ".png" else drawn.encode())
    say(f"map: {output}")
